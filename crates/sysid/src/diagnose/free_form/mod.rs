//! Beyond the catalogue: the curve that is missing at a port becomes an effect, is fitted as one, and tells whether a known
//! effect deserves its name.

pub(super) mod curves;

use crate::diagnose::candidate::compare::{clearly_better, excess};
use crate::diagnose::missing::dependence::Dependence;
use crate::diagnose::missing::picture::{MissingForce, missing_force};
use crate::diagnose::missing::{Missing, Port};
use crate::diagnose::policy::{
    CURVE_BEATS, CURVE_LEAVES, CURVES_FITTED, DRY_MOSTLY, EXPLAINED, LEFT_SHARE, MOST_LOST, WORTH_NAMING,
};
use crate::diagnose::refine::Models;
use crate::diagnose::refine::starts::with_nominal_base;
use crate::diagnose::search::Search;
use crate::diagnose::{Candidate, Found, Progress};
use crate::fit::Fit;
use curves::Tried;
use rayon::prelude::*;
use sealegs_model::{Curve, Factor, Law, Over, internal};

/// A fitted curve.
#[derive(Debug, Clone)]
pub struct FreeForm {
    /// The law with its fitted points.
    pub law: Law,
    /// The port with its place, as in [`Missing::name`].
    pub port: String,
    /// What it depends on, as in [`Dependence::on`].
    pub on: &'static str,
    /// Share of what a curve over the speed predicts that the direction of motion predicts by itself; 0 of other curves.
    pub dry_share: f64,
    /// The set beside which it was fitted, in [`Found::tried`]: the base model, or the chosen one.
    pub beside: usize,
    /// That set with the law.
    pub with: Candidate,
    /// What is missing without it over what it depends on, the law drawn over it.
    pub force: Option<MissingForce>,
}

/// A curve with the set that it was fitted with, as the search fits sets.
pub(crate) struct Fitted {
    tried: Tried,
    pub with: Candidate,
}

impl Fitted {
    /// Whether it leaves far less than a set does, and is no dry friction: then the set does not deserve its name.
    pub fn beats(&self, set: &Candidate, floor: f64) -> bool {
        takes(set, &self.with, 1.0 / CURVE_BEATS, floor)
            && !is_dry_friction(self.tried.on, self.tried.dry_share)
    }

    /// It fitted to the end, beside the set with this index.
    fn finished(self, models: &Models, beside: usize, ports: &[Port]) -> FreeForm {
        let Self { tried, with } = self;
        let models = tried.models(models);
        let with = models.polished(&with);
        let force = missing_force(&models, &with, ports);
        let with = models.in_open_loop(with);
        let law = refitted(tried.law.clone(), &with);
        FreeForm {
            law,
            port: tried.port.clone(),
            on: tried.on,
            dry_share: tried.dry_share,
            beside,
            with,
            force,
        }
    }
}

impl Search<'_> {
    /// Fits curves at the ports beside the base model, once, where a set leaves something. On a leg, where a simulation is
    /// dear, they wait until nothing else is left to try.
    pub(crate) fn look_for_curve(&mut self, set: usize) {
        let left = self.tried[set].fit.error() > EXPLAINED * self.models.data.floor;
        if !self.models.dear && left && self.curve.is_none() {
            self.say(Progress::Curves);
            self.curve = Some(lowest(&self.models, &self.tried[0], &self.ports));
        }
    }

    /// The curve that was found.
    fn found_curve(&self) -> Option<&Fitted> {
        self.curve.as_ref()?.as_ref()
    }

    /// Whether the curve leaves far less than a set: no known effect deserves its name then.
    pub(crate) fn curve_beats(&self, set: usize) -> bool {
        let floor = self.models.data.floor;
        self.found_curve().is_some_and(|curve| curve.beats(&self.tried[set], floor))
    }

    /// Whether, besides, it explains nearly all that is missing, so that further effects would have nothing to explain.
    pub(crate) fn curve_explains(&self, set: usize) -> bool {
        let floor = self.models.data.floor;
        let left = |candidate: &Candidate| excess(candidate.fit.error(), floor);
        let explains = |curve: &Fitted| left(&curve.with) <= CURVE_LEAVES * left(&self.tried[0]);
        self.found_curve().is_some_and(explains) && self.curve_beats(set)
    }
}

/// The curves that take most of what the chosen set leaves, beside it, and of what the base model leaves, alone; none where
/// nothing is left, or no curve takes a good part of it. Where one alone leaves far less than the chosen set, nothing stays
/// chosen: a known effect is named only if it explains what the free-form curve of its port does. `early` is what the
/// search found alone.
pub(crate) fn look(
    models: &Models,
    found: &mut Found,
    early: Option<Fitted>,
    (before, after): (&[Port], &[Port]),
) -> Vec<FreeForm> {
    let floor = models.data.floor;
    let error = |i: usize| found.tried[i].fit.error();
    let left = (error(found.chosen) - floor) / (error(0) - floor).max(f64::MIN_POSITIVE);
    if error(found.chosen) <= EXPLAINED * floor || (found.chosen > 0 && left < LEFT_SHARE) {
        return Vec::new();
    }
    let alone = early.or_else(|| lowest(models, &found.tried[0], before));
    let beats = alone.as_ref().is_some_and(|law| law.beats(&found.tried[found.chosen], floor));
    let alone = alone.map(|law| law.finished(models, 0, before));
    if found.chosen == 0 || beats {
        found.chosen = 0;
        found.tied.clear();
        found.same.clear();
        return alone.into_iter().collect();
    }
    let beside = lowest(models, &found.tried[found.chosen], after);
    let beside = beside.map(|law| law.finished(models, found.chosen, after));
    beside.into_iter().chain(alone).collect()
}

/// Whether a curve over the speed is dry friction with something beside it: its sign alone predicts nearly as much.
fn is_dry_friction(on: &str, dry_share: f64) -> bool {
    on == "speed" && dry_share >= DRY_MOSTLY
}

/// Whether a model leaves no more than a share of what another one leaves on left-out stretches, and clearly less.
fn takes(from: &Candidate, with: &Candidate, share: f64, floor: f64) -> bool {
    let square = |c: &Candidate| excess(c.validation.mean_square().sqrt(), floor);
    clearly_better(from, with, floor) && square(with) <= share * square(from)
}

/// The curve that leaves least beside a set: some are fitted under the observer for a few steps, the best of these to the end
/// and in open loop; `None` where it takes no good part of what the set leaves.
pub(crate) fn lowest(models: &Models, near: &Candidate, ports: &[Port]) -> Option<Fitted> {
    let known = near.known();
    let observed = models.observing(near, &with_nominal_base(models.exact, &known))?;
    let tried = curves::promising(models, &observed, ports);
    let mut seen: Vec<(Tried, Fit)> = tried
        .into_par_iter()
        .filter_map(|t| {
            let fit = t.models(models).observed_fit(&observed, &t.set(near), &known)?;
            Some((t, fit))
        })
        .collect();
    seen.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    if models.dear {
        seen.truncate(1);
    } else {
        // What an observer follows hides most of what lasts: the best curve of each place has its chance in open loop.
        curves::leaders(&mut seen, CURVES_FITTED as usize, |(tried, _)| &tried.law);
    }
    let fitted: Vec<Fitted> = seen
        .into_par_iter()
        .filter_map(|(tried, fit)| {
            let (models, set) = (tried.models(models), tried.set(near));
            let on = if fit.converged { None } else { models.observed_on(&observed, &set, &fit) };
            let with = models.fitted(near, &set, &known, Some(&on.unwrap_or(fit).known()))?;
            Some(Fitted { tried, with })
        })
        .filter(|Fitted { tried, with }| {
            tried.law.acts_on != "drive" || !is_left_undriven(&tried.law, near, with)
        })
        .collect();
    let least = fitted.into_iter().reduce(|a, b| if b.with.fit.cost < a.with.fit.cost { b } else { a })?;
    takes(near, &least.with, 1.0 - WORTH_NAMING, models.data.floor).then_some(least)
}

/// Puts the port at which a law acts first, and what the law depends on first there: a fit in the sensors' own noise says it
/// better than what an observer needs. `beside` is the set without the law.
pub(crate) fn put_first(law: &FreeForm, beside: &Candidate, floor: f64, ports: &mut Vec<Port>) {
    let Some(at) = ports.iter().position(|p| p.missing.name() == law.port) else { return };
    let square = |c: &Candidate| excess(c.validation.mean_square().sqrt(), floor);
    let explained = 1.0 - square(&law.with) / square(beside).max(f64::MIN_POSITIVE);
    let known = ports[at].depends.iter().find(|d| d.on == law.on);
    let coefficients = law.with.effect_parameters() - beside.effect_parameters();
    let none = Dependence { on: law.on, explained, coefficients, curve: None };
    let said = Dependence { explained, ..known.cloned().unwrap_or(none) };
    let mut port = if law.law.acts_on == "drive" {
        // What the drive lacks is missing at the rotor, which it acts on.
        let missing = Missing { port: "drive".to_owned(), ..ports[at].missing.clone() };
        Port { missing, depends: Vec::new(), force: law.force.clone() }
    } else {
        ports.remove(at)
    };
    port.depends.retain(|d| d.on != law.on);
    port.depends.insert(0, said);
    port.force = law.force.clone().or(port.force);
    ports.insert(0, port);
}

/// Whether the motor drives with less than half of its force beside a curve at the drive: such a curve takes the command
/// away, and a body without mass explains the rest.
fn is_left_undriven(law: &Law, near: &Candidate, with: &Candidate) -> bool {
    let place = law.place.as_deref().unwrap_or("");
    let force = |c: &Candidate| -> f64 {
        let runs = c.fit.evaluation.predictions.iter();
        let of_run = runs.filter_map(|p| p.internal_at(place, internal::MOTOR_FORCE));
        of_run.flatten().map(|f| f * f).sum::<f64>().sqrt()
    };
    force(with) < MOST_LOST * force(near)
}

/// The law of a dependence: a curve at its port, or at the drive where what the rotor lacks follows the command. `None` for a
/// dependence that is no curve of one signal.
pub(crate) fn law(missing: &Missing, on: &str, (x, mut y): (Vec<f64>, Vec<f64>), step: f64) -> Option<Law> {
    let sensor = missing.port.starts_with("sensor/");
    let (acts_on, over, times) = match (missing.port.as_str(), on) {
        ("rotor", "speed") => ("rotor", Over::Speed, Factor::One),
        ("rotor", "position") => ("rotor", Over::Position, Factor::One),
        ("rotor", "time") => ("rotor", Over::Time, Factor::One),
        ("rotor", "direction and position") => ("rotor", Over::Position, Factor::Direction),
        ("rotor", "direction and load") => ("rotor", Over::Load, Factor::Direction),
        ("rotor", "command") => ("drive", Over::Command, Factor::One),
        ("rotor", "command and time") => ("drive", Over::Time, Factor::Command),
        ("spring", "deflection") => ("spring", Over::Deflection, Factor::One),
        ("spring", "rate of deflection") => ("spring", Over::DeflectionRate, Factor::One),
        ("spring", "deflection and time") => ("spring", Over::Time, Factor::Deflection),
        ("output", "speed") => ("output", Over::Speed, Factor::One),
        ("output", "position") => ("output", Over::Position, Factor::One),
        ("output", "time") => ("output", Over::Time, Factor::One),
        (port, "its own value") if sensor => (port, Over::Value, Factor::One),
        (port, "time") if sensor => (port, Over::Time, Factor::One),
        _ => return None,
    };
    // A bound opposes the motion.
    let against = times == Factor::Direction;
    y.iter_mut().filter(|_| against).for_each(|y| *y = (-*y).max(0.0));
    let dry = if over == Over::Speed && acts_on == "rotor" { (-step).max(0.0) } else { 0.0 };
    let place = (!missing.place.is_empty()).then(|| missing.place.clone());
    let name = acts_on.rsplit('/').next().unwrap_or(acts_on).replace('_', "-");
    Some(Law {
        id: format!("unknown-at-{name}"),
        place,
        acts_on: acts_on.to_owned(),
        summary: format!("What no known effect gives: it depends on {on}."),
        curve: Curve { over, times, x, y, dry },
    })
}

/// The law with the points that were fitted.
fn refitted(mut law: Law, with: &Candidate) -> Law {
    let own = format!("{}.", law.effect());
    let value = |name: &str| {
        let full = format!("{own}{name}");
        with.fit.parameters.iter().find(|p| p.name == full).map(|p| p.value)
    };
    let size = value("size").unwrap_or(1.0);
    for (k, y) in law.curve.y.iter_mut().enumerate() {
        *y = value(&format!("y{}", k + 1)).unwrap_or(size * *y);
    }
    law.curve.dry = value("dry").unwrap_or(law.curve.dry);
    law
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missing(port: &str) -> Missing {
        Missing {
            place: "knee".to_owned(),
            port: port.to_owned(),
            unit: "N".to_owned(),
            runs: Vec::new(),
            rms: 1.0,
            std: 0.1,
            slow: (1.0, 0.1),
            quiet: Vec::new(),
        }
    }

    fn depends(port: &str, on: &str, step: f64) -> Option<Law> {
        law(&missing(port), on, (vec![-1.0, 1.0], vec![2.0, -2.0]), step)
    }

    #[test]
    fn what_is_missing_becomes_a_law_at_its_port() {
        let drag = depends("rotor", "speed", -1.5).expect("a law");
        assert_eq!((drag.effect().as_str(), drag.curve.dry), ("knee/unknown-at-rotor", 1.5));
        assert_eq!(drag.curve.y, [2.0, -2.0]);
        // A friction that would push is none.
        assert_eq!(depends("rotor", "speed", 1.5).expect("a law").curve.dry, 0.0);
        let bound = depends("rotor", "direction and position", 0.0).expect("a law");
        assert_eq!((bound.curve.times, bound.curve.y), (Factor::Direction, vec![0.0, 2.0]));
        let drive = depends("rotor", "command", 0.0).expect("a law");
        assert_eq!(drive.acts_on, "drive");
        let cell = depends("sensor/force_1_n", "its own value", 0.0).expect("a law");
        assert_eq!((cell.id.as_str(), cell.acts_on.as_str()), ("unknown-at-force-1-n", "sensor/force_1_n"));
        assert!(depends("rotor", "rotor angle", 0.0).is_none());
    }
}
