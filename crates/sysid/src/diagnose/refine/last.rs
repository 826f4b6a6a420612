//! The last fit of a set: with the model itself, and derivatives that are good enough for standard errors.

use super::count;
use super::horizon::Derivatives;
use super::starts::{freed, with_nominal_base};
use super::{Models, finishing};
use crate::Error;
use crate::diagnose::candidate::{Known, within_half_a_period};
use crate::diagnose::policy::{
    DEAR_STEPS, FAR_FROM_KNOWN, FREED_ROUNDS, HALF_STEPS, NEAR_FLOOR, NOTHING_MORE, WORTH_SQUARED_NOISE,
};
use crate::diagnose::refine::Seen;
use crate::diagnose::{Candidate, with_effects};
use crate::fit::{self, Difference, Fit, FitOptions, KnownColumns};
use sealegs_model::{Model, Parameter};
use std::sync::Arc;

/// Gain of a step with half the integrator's steps below which it is not taken: a fifth of a standard error.
const HALF_TOLERANCE: f64 = 0.02;

impl Models<'_> {
    /// The candidate fitted to the end with the model itself, with the memory of a last fit, and derivatives good enough for
    /// standard errors; those of a base model that something is missing beside are no use, and dear on a leg.
    #[must_use]
    pub fn polished(&self, candidate: &Candidate) -> Candidate {
        let rough =
            self.dear && candidate.effects.is_empty() && candidate.fit.error() > NEAR_FLOOR * self.data.floor;
        let again = (self.dear && !rough).then(|| self.refitted_from_known(candidate)).flatten();
        let candidate = again.as_ref().unwrap_or(candidate);
        let (lower, reaches) = match self.dear && !rough {
            true => self.along_profiles(candidate),
            false => (None, Known::new()),
        };
        let candidate = lower.as_ref().unwrap_or(candidate);
        let polish = || -> Result<Candidate, Error> {
            let last = self.remembering(self.last);
            let model = with_effects(last.as_deref().unwrap_or(self.exact), &candidate.effects, &self.seen)?;
            let usual = FitOptions::of(self.exact);
            let options = FitOptions {
                starts: 1,
                columns: usual.secants.then(|| candidate.columns()),
                max_steps: if self.dear { DEAR_STEPS as usize } else { usual.max_steps },
                difference: match (rough, self.dear) {
                    (true, _) => Difference::Secant,
                    (false, true) => Difference::Forward,
                    (false, false) => usual.difference,
                },
                compares: rough,
                last: true,
                ..usual
            };
            let from = |start: Vec<f64>| {
                let options = FitOptions { start: Some(start), ..options.clone() };
                count::fit_holding(self.data, model.as_ref(), &options)
            };
            let values =
                self.with_longer_memory(candidate).unwrap_or_else(|| self.rescaled(candidate).values);
            let start = within_half_a_period(model.parameters(), &values);
            let mut fit = from(start)?;
            // What lies far from the value that was held is several steps away.
            for _ in 0..if self.dear { 1 } else { FREED_ROUNDS as usize } {
                let before = fit.cost;
                for start in freed(model.as_ref(), &fit.values) {
                    fit = from(start).ok().filter(|other| other.cost < fit.cost).unwrap_or(fit);
                }
                if fit.cost > before - NOTHING_MORE {
                    break;
                }
            }
            let fit = self.through_beginnings_at_last(candidate, model.as_ref(), fit);
            let (model, mut fit) = if rough { (model, fit) } else { self.with_half_the_steps(model, fit) };
            for p in &mut fit.parameters {
                let reach = reaches.iter().find(|(name, _)| *name == p.name);
                p.std = reach.map_or(p.std, |(_, reach)| p.std.max(*reach));
            }
            Ok(Candidate::exactly(self.data, candidate.effects.clone(), model, fit))
        };
        polish().unwrap_or_else(|_| candidate.clone())
    }

    /// A set fitted again with the base parameters that ended far from what is known of them where they are known to be, if that
    /// leaves less. A joint that hardly moves rings for a hundred periods: its springs fit in many places, and each
    /// looks like the end. Where simulations are cheap other starts find that.
    fn refitted_from_known(&self, set: &Candidate) -> Option<Candidate> {
        let is_far = |p: &Parameter, value: f64| {
            let known = p.prior_std.filter(|_| !p.fixed);
            known.is_some_and(|std| (value - p.value).abs() > FAR_FROM_KNOWN * std)
        };
        let parameters = set.model.parameters().iter().zip(&set.fit.values);
        let start = parameters.map(|(p, &value)| if is_far(p, value) { p.value } else { value });
        let start: Vec<f64> = start.collect();
        if start == set.fit.values {
            return None;
        }
        self.finished_from(set, start)
    }

    /// A set fitted again from other values, if that leaves less.
    pub(crate) fn finished_from(&self, set: &Candidate, start: Vec<f64>) -> Option<Candidate> {
        // Derivatives are others there.
        let options = FitOptions { columns: None, ..finishing(self.options(set.model.as_ref(), start, set)) };
        let again = Candidate::fitted(self.data, set.effects.clone(), set.model.clone_box(), &options).ok();
        again.filter(|again| again.fit.cost < set.fit.cost)
    }

    /// A last fit, or that through ever longer beginnings of the runs, where derivatives are dear, it leaves something and that
    /// leaves less: other steps than the search's put the minimum of a rugged error elsewhere.
    fn through_beginnings_at_last(&self, set: &Candidate, model: &dyn Model, fit: Fit) -> Fit {
        if !self.dear || set.effects.is_empty() || fit.error() <= NEAR_FLOOR * self.data.floor {
            return fit;
        }
        let observed = self.observing(set, &with_nominal_base(self.exact, &set.known()));
        let again = observed.and_then(|o| {
            self.through_beginnings(set, model, &Seen::of(&o.fit), Derivatives::AnewWhereRugged)
        });
        again.map(|again| again.fit).filter(|again| again.cost < fit.cost).unwrap_or(fit)
    }

    /// A last fit led on with half the integrator's steps, where that makes a difference: by the derivatives that it has, as only
    /// the values depend on the steps, by less than an interval. What the steps move a value by is part of what it is known
    /// within. Where the steps change what is left, the error is rugged: beginnings of the runs, over which an error has not
    /// grown yet, tell how far off the steps put a value, and the fit stays that leaves less.
    fn with_half_the_steps(&self, model: Box<dyn Model>, fit: Fit) -> (Box<dyn Model>, Fit) {
        let Some(finer) = model.finer().filter(|finer| count::held(finer.as_ref()).is_empty()) else {
            return (model, fit);
        };
        let options = FitOptions {
            start: Some(fit.values.clone()),
            starts: 1,
            max_steps: HALF_STEPS as usize,
            tolerance: HALF_TOLERANCE,
            difference: Difference::Secant,
            secants: true,
            columns: Some(Arc::new(KnownColumns::of(&fit))),
            last: true,
            ..FitOptions::default()
        };
        let Ok(led_on) = fit::fit(self.data, finer.as_ref(), &options) else { return (model, fit) };
        let worse = led_on.error().powi(2) - fit.error().powi(2);
        let rugged = worse.abs() > WORTH_SQUARED_NOISE * self.data.floor.powi(2);
        let moved = || led_on.values.iter().zip(&fit.values).map(|(a, b)| a - b).collect();
        let off = match rugged {
            true => self.off_by_steps(&fit, model.as_ref(), finer.as_ref()).unwrap_or_else(moved),
            false => moved(),
        };
        let (model, mut last) = if rugged && worse > 0.0 { (model, fit) } else { (finer, led_on) };
        for (p, off) in last.parameters.iter_mut().zip(off) {
            p.std = p.std.hypot(off);
        }
        (model, last)
    }

    /// A candidate's fit followed along changes of the units of force and length, where derivatives are cheap.
    fn rescaled(&self, candidate: &Candidate) -> Fit {
        let (model, fit) = (candidate.model.as_ref(), candidate.fit.clone());
        if self.dear {
            return fit;
        }
        let refit = |near: &Fit, start: Vec<f64>| {
            let columns = Some(Arc::new(KnownColumns::of(near)));
            let options = FitOptions { secants: true, columns, ..self.options(model, start, candidate) };
            fit::fit(self.data, model, &options).ok()
        };
        fit::along_units(self.data, model, fit, &count::held(model), refit)
    }
}
