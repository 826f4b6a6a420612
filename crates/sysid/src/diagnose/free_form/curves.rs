//! Which curve at which port takes most of the residual under the observer: every ordinate of a curve is screened as an effect
//! of its own.
//!
//! A force of a newton is far below what an encoder's noise is worth as an acceleration, and is not seen in the force that an
//! observer needs. In the sensors themselves, where the noise is white, it is: the residual is regressed on what each ordinate
//! does to the sensors, which weighs every frequency as it is known.

use super::law;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::symbol;
use crate::diagnose::missing::Port;
use crate::diagnose::missing::dependence::{Form, forms};
use crate::diagnose::missing::regression::Smooth;
use crate::diagnose::missing::rows::{rows, step};
use crate::diagnose::policy::{CURVE_UNIT, CURVES, CURVES_DEAR, KNOTS_WORTH_MOVING, WORTH_PER_PARAMETER};
use crate::diagnose::refine::Models;
use crate::diagnose::{values_by_name, with_effects};
use crate::fit::Signatures;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sealegs_model::{Curve, Factor, Law, Model, Parameter, Prediction};
use std::sync::Arc;

/// Ports and dependences of each that are tried where a simulation is dear.
const PORTS: usize = 2;
const DEPENDENCES: usize = 3;

/// Shares of the greatest diagonal element that hold amplitudes near zero, until they promise no more than there is to gain.
const RIDGES: [f64; 3] = [1e-6, 1e-4, 1e-2];

/// Times that knots are moved: each halves the distance of two, from a tenth of the range to the hundredth that a signal's noise
/// blurs.
const ROUNDS: usize = 4;

/// A law that a model could have, and the model in the forms that could.
pub(crate) struct Tried {
    pub law: Law,
    pub port: String,
    pub on: &'static str,
    /// As in [`FreeForm::dry_share`](super::FreeForm::dry_share).
    pub dry_share: f64,
    exact: Box<dyn Model>,
    coarse: Box<dyn Model>,
    observed: Box<dyn Model>,
}

impl Tried {
    /// `None` where the model has no place for it.
    fn of(models: &Models, law: Law, port: &Port, on: &'static str) -> Option<Self> {
        let exact = models.exact.knowing(&law)?;
        let (coarse, observed) = (models.coarse.knowing(&law)?, models.observed.as_deref()?.knowing(&law)?);
        let port = port.missing.name();
        Some(Self { law, port, on, dry_share: 0.0, exact, coarse, observed })
    }

    /// The model in its forms that have the law to choose from.
    pub fn models<'a>(&'a self, of: &'a Models) -> Models<'a> {
        Models {
            data: of.data,
            exact: self.exact.as_ref(),
            coarse: self.coarse.clone(),
            before: Arc::default(),
            observed: Some(self.observed.clone()),
            seen: of.seen.clone(),
            ..*of
        }
    }

    /// A candidate's set with the law.
    pub fn set(&self, near: &Candidate) -> Vec<String> {
        near.effects.iter().cloned().chain([self.law.effect()]).collect()
    }
}

/// A law that was screened: as strong as it takes most of the residual.
struct Promised<'a> {
    port: &'a Port,
    on: &'static str,
    law: Law,
    /// The ordinate that it was screened with.
    unit: f64,
    /// By how much the cost would fall, less what chance gives as many ordinates.
    drop: f64,
    dry_share: f64,
}

/// The curves that promise most beside a set, which is fitted under the observer.
pub(crate) fn promising(models: &Models, observed: &Candidate, ports: &[Port]) -> Vec<Tried> {
    if models.dear {
        return seen_at_ports(models, ports);
    }
    let mut all: Vec<Promised> =
        ports.par_iter().flat_map_iter(|port| at_port(models, observed, port)).collect();
    all.sort_by(|a, b| b.drop.total_cmp(&a.drop));
    leaders(&mut all, CURVES as usize, |promised| &promised.law);
    let tried = |promised: Promised| {
        let Promised { port, on, law, dry_share, .. } = refined(models, observed, promised);
        Some(Tried { dry_share, ..Tried::of(models, law, port, on)? })
    };
    all.into_par_iter().filter_map(tried).collect()
}

/// Keeps the first so many of some curves, the best first, and the best one of each place that they may act on: the drive, the
/// rotor, the spring, the output, a sensor.
pub(crate) fn leaders<T>(all: &mut Vec<T>, first: usize, law: impl Fn(&T) -> &Law) {
    let mut places: Vec<String> = Vec::new();
    all.retain(|curve| {
        let place = law(curve).acts_on.split('/').next().unwrap_or_default().to_owned();
        let is_new = !places.contains(&place);
        places.push(place);
        is_new || places.len() <= first
    });
}

/// The curve with knots moved to where it bends most, as long as that helps: a bump is narrower than even knots are apart.
fn refined<'a>(models: &Models, observed: &Candidate, mut best: Promised<'a>) -> Promised<'a> {
    for _ in 0..ROUNDS {
        let mut law = best.law.clone();
        law.curve.x = closer_knots(&best.law.curve.x, &best.law.curve.y);
        law.curve.y = vec![best.unit; law.curve.x.len()];
        law.curve.dry = if law.curve.dry > 0.0 { best.unit.abs() } else { 0.0 };
        match promised(models, observed, law, (best.port, best.on)) {
            Some(next) if next.drop >= KNOTS_WORTH_MOVING * best.drop => best = next,
            _ => break,
        }
    }
    best
}

/// Knots with two more beside the one where the curve bends most, and as many of those less where it bends least.
fn closer_knots(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let bend = |k: usize| {
        let along = (x[k] - x[k - 1]) / (x[k + 1] - x[k - 1]);
        (y[k] - y[k - 1] - along * (y[k + 1] - y[k - 1])).abs()
    };
    let mut inner: Vec<usize> = (1..n.saturating_sub(1)).collect();
    inner.sort_by(|&a, &b| bend(b).total_cmp(&bend(a)));
    let Some(&most) = inner.first() else { return x.to_vec() };
    let more = [0.5 * (x[most - 1] + x[most]), 0.5 * (x[most] + x[most + 1])];
    // Its neighbours stay, or the curve could not come down beside it.
    let stays = |k: &usize| k.abs_diff(most) <= 1;
    let (near, mut far): (Vec<usize>, Vec<usize>) = inner.iter().copied().partition(stays);
    far.truncate(Curve::MOST_FREE.saturating_sub(near.len() + more.len() + 2));
    let mut knots: Vec<f64> = near.iter().chain(&far).chain([&0, &(n - 1)]).map(|&k| x[k]).collect();
    knots.extend(more);
    knots.sort_by(f64::total_cmp);
    knots
}

/// The curves of dependences that the ports' missing signals show.
fn seen_at_ports(models: &Models, ports: &[Port]) -> Vec<Tried> {
    let felt = ports.iter().filter(|p| p.missing.is_felt()).take(PORTS);
    let dependences = felt.flat_map(|port| {
        let direction =
            port.depends.iter().find(|d| d.on == "direction of motion").map_or(0.0, |d| d.explained);
        let tried = port.depends.iter().filter_map(move |d| {
            let curve = d.curve.as_ref()?;
            let law = law(&port.missing, d.on, curve.points.clone(), curve.step)?;
            let dry_share = if d.on == "speed" { direction / d.explained } else { 0.0 };
            Some(Tried { dry_share, ..Tried::of(models, law, port, d.on)? })
        });
        tried.take(DEPENDENCES).collect::<Vec<_>>()
    });
    dependences.take(CURVES_DEAR as usize).collect()
}

/// The curves at one port that promise something.
fn at_port<'a>(models: &Models, observed: &Candidate, port: &'a Port) -> Vec<Promised<'a>> {
    let (data, missing) = (models.data, &port.missing);
    let rows = rows(data, observed, missing, step(&missing.runs));
    let unit = CURVE_UNIT * missing.rms.max(missing.std);
    let of_form = |form: Form| {
        let knots = form.knots?;
        // A unit of what is multiplied by a signal is that of the port at the signal's size.
        let size = |c: &Vec<f64>| c.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let factor = match form.times {
            "1" | "direction" => 1.0,
            _ => form.columns.iter().map(size).fold(f64::MIN_POSITIVE, f64::max),
        };
        let ordinates = vec![-unit / factor; knots.len()];
        let law = law(missing, form.on, (knots, ordinates), -unit)?;
        promised(models, observed, law, (port, form.on))
    };
    forms(&rows, missing.port.starts_with("sensor/")).into_iter().filter_map(of_form).collect()
}

/// Regresses the residual on what each ordinate of a law does, of which all are alike; `None` where that is no more than
/// chance gives.
fn promised<'a>(
    models: &Models,
    observed: &Candidate,
    mut law: Law,
    (port, on): (&'a Port, &'static str),
) -> Option<Promised<'a>> {
    let unit = law.curve.y[0];
    let (data, at) = (models.data, &observed.fit);
    let mut effects = observed.effects.clone();
    effects.push(law.effect());
    let model =
        with_effects(models.observed.as_deref()?.knowing(&law)?.as_ref(), &effects, &models.seen).ok()?;
    let of_law = |p: &Parameter| symbol(&p.name, &law.effect()).is_some();
    let own: Vec<usize> = (0..model.parameters().len()).filter(|&i| of_law(&model.parameters()[i])).collect();
    let stated = values_by_name(model.as_ref(), &observed.known());
    let changed: Vec<Vec<Prediction>> = own
        .par_iter()
        .map(|&k| {
            let mut values = stated.clone();
            own.iter().filter(|&&i| i != k).for_each(|&i| values[i] = 0.0);
            data.predict_outputs(model.as_ref(), &values).ok()
        })
        .collect::<Option<_>>()?;
    let columns: Vec<&[Prediction]> = changed.iter().map(Vec::as_slice).collect();
    let Signatures { gram, gradient, .. } = Signatures::new(data, at, &at.evaluation.predictions, &columns);
    let mut a = gram.clone();
    let points = law.curve.x.len().min(own.len());
    if points == law.curve.x.len() {
        Smooth { first: 0, knots: &law.curve.x }.add_to(&mut a);
    }
    let bound = law.curve.times == Factor::Direction;
    let fall = |x: &DVector<f64>| -(gradient.dot(x) + 0.5 * x.dot(&(&gram * x)));
    // Where ordinates can hardly be told from base parameters, rounding promises more than there is.
    let held = RIDGES.iter().filter_map(|ridge| solved(&a, &gradient, *ridge, bound));
    let all = held.into_iter().find(|x| fall(x) <= at.cost)?;
    let drop = fall(&all) - 0.5 * WORTH_PER_PARAMETER * own.len() as f64;
    let mut dry_share = 0.0;
    if points < own.len() {
        // The dry friction beside a curve over the speed comes last.
        let last = own.len() - 1;
        let mut dry = DVector::zeros(own.len());
        dry[last] = (-gradient[last] / gram[(last, last)].max(f64::MIN_POSITIVE)).max(0.0);
        dry_share = fall(&dry) / fall(&all).max(f64::MIN_POSITIVE);
        law.curve.dry *= all[last].max(1e-3);
    }
    for (y, x) in law.curve.y.iter_mut().zip(all.iter()).take(points) {
        *y *= x;
    }
    (drop > 0.0).then_some(Promised { port, on, law, unit, drop, dry_share })
}

/// Solves normal equations for what lowers the cost most; amplitudes of a bound are not negative.
fn solved(a: &DMatrix<f64>, gradient: &DVector<f64>, ridge: f64, bound: bool) -> Option<DVector<f64>> {
    let n = gradient.len();
    let mut regular = a.clone();
    let size = (0..n).map(|i| a[(i, i)]).fold(0.0, f64::max);
    (0..n).for_each(|i| regular[(i, i)] += ridge * size + f64::MIN_POSITIVE);
    let mut x = -regular.cholesky()?.solve(gradient);
    if bound {
        x.iter_mut().for_each(|v| *v = v.max(0.0));
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::{closer_knots, leaders, solved};
    use nalgebra::{DMatrix, DVector};
    use sealegs_model::{Curve, Factor, Law, Over};

    #[test]
    fn the_best_curve_of_each_place_stays() {
        let at = |acts_on: &str, id: &str| Law {
            id: id.to_owned(),
            place: None,
            acts_on: acts_on.to_owned(),
            summary: String::new(),
            curve: Curve {
                over: Over::Speed,
                times: Factor::One,
                x: vec![0.0, 1.0],
                y: vec![0.0, 1.0],
                dry: 0.0,
            },
        };
        let mut all = vec![
            at("rotor", "a"),
            at("rotor", "b"),
            at("rotor", "c"),
            at("sensor/force_1_n", "d"),
            at("drive", "e"),
            at("sensor/force_2_n", "f"),
            at("drive", "g"),
        ];
        leaders(&mut all, 2, |law| law);
        let kept: Vec<&str> = all.iter().map(|law| law.id.as_str()).collect();
        assert_eq!(kept, ["a", "b", "d", "e"]);
    }

    #[test]
    fn analytic_knots_move_to_the_bend() {
        let x: Vec<f64> = (0..12).map(f64::from).collect();
        let mut y = vec![0.0; 12];
        y[4] = 1.0;
        let knots = closer_knots(&x, &y);
        assert!(knots.len() == 12 && knots.is_sorted(), "{knots:?}");
        assert!([0.0, 3.0, 3.5, 4.0, 4.5, 5.0, 11.0].iter().all(|k| knots.contains(k)), "{knots:?}");
    }

    #[test]
    fn analytic_amplitudes_solve_and_a_bound_does_not_push() {
        let a = DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 4.0]));
        let gradient = DVector::from_vec(vec![-2.0, 4.0]);
        let free = solved(&a, &gradient, 1e-6, false).expect("regular");
        assert!((free[0] - 1.0).abs() < 1e-5 && (free[1] + 1.0).abs() < 1e-5, "{free}");
        assert_eq!(solved(&a, &gradient, 1e-6, true).expect("regular")[1], 0.0);
    }
}
