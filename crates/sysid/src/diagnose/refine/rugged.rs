//! Intervals of values along which the error is rugged: it has many minima there, and the curvature of the one that a fit has
//! ended in says nothing of how far the value may be off. Play that rattles makes it so, and a foot that strikes again.

use super::count::is_count;
use crate::data::Data;
use crate::diagnose::Candidate;
use crate::diagnose::policy::{KNOWN_FROM_ZERO, NEAR_FLOOR, RUGGED, WORTH_SQUARED_NOISE};
use crate::fit::Fit;
use rayon::prelude::*;

/// The nearest value that is tried, in standard errors, the ratio of each to the one before, and how many are tried to either
/// side: up to some thousands of standard errors.
const NEAREST: f64 = 3.0;
/// See [`NEAREST`].
const FURTHER: f64 = 3.0;
/// See [`NEAREST`].
const PROBES: i32 = 8;

/// A set with the standard errors of its effects such that their intervals hold every value beside which no more is added to
/// what is left than that itself, where the error is rugged; and the names of those parameters. Where it is not, the
/// curvature tells how far that is, and standard errors stay as they are, or become so great that no more is added than half
/// the integrator's steps change, where that is worth a word: values are known no better than the steps let them be.
#[must_use]
pub(crate) fn widened(data: &Data, set: &Candidate) -> (Fit, Vec<String>) {
    let mut fit = set.fit.clone();
    let (square, floor) = (fit.error().powi(2), data.floor.powi(2));
    let by_steps = set.step_error(data, &fit.evaluation);
    let (is_left, is_stepped) = (square > NEAR_FLOOR.powi(2) * floor, by_steps > WORTH_SQUARED_NOISE * floor);
    if !is_left && !is_stepped {
        return (fit, Vec::new());
    }
    let half_of = |square: f64| 0.5 * square * fit.evaluation.residuals() as f64;
    let parameters = set.model.parameters();
    let known: Vec<(usize, usize)> = fit
        .free
        .iter()
        .copied()
        .enumerate()
        .filter(|&(_, i)| !is_count(&parameters[i]) && fit.parameters[i].std > 0.0)
        .collect();
    let expected = |k: usize, left: f64| (2.0 * left / fit.normal[(k, k)]).sqrt() * fit.slopes[k].abs();
    let mut reaches: Vec<(usize, f64)> = Vec::new();
    if is_stepped {
        reaches.extend(known.iter().map(|&(k, i)| (i, expected(k, half_of(by_steps)))));
    }
    let left = half_of(square.max(by_steps + floor) - floor);
    let reach_of = |&(k, i): &(usize, usize)| {
        let reach = reach(data, set, i, left);
        (reach > RUGGED * expected(k, left)).then_some((i, reach))
    };
    let of_effects: Vec<_> = known.into_iter().filter(|&(_, i)| parameters[i].name.contains('.')).collect();
    let rugged: Vec<(usize, f64)> = of_effects.par_iter().filter_map(reach_of).collect();
    let names = rugged.iter().map(|&(i, _)| parameters[i].name.clone()).collect();
    for (i, reach) in reaches.into_iter().chain(rugged) {
        let p = &mut fit.parameters[i];
        p.std = p.std.max(reach / KNOWN_FROM_ZERO);
    }
    (fit, names)
}

/// How far a value can be moved to either side, all others held, until so much more is left.
fn reach(data: &Data, set: &Candidate, index: usize, left: f64) -> f64 {
    let (fit, p) = (&set.fit, &set.model.parameters()[index]);
    let to_side = |side: f64| {
        let shifts = (0..PROBES).map(|k| NEAREST * FURTHER.powi(k) * fit.parameters[index].std);
        let stays = |shift: &f64| {
            let mut values = fit.values.clone();
            values[index] += side * shift;
            let at = || data.evaluate(set.model.as_ref(), &values).map_or(f64::INFINITY, |at| at.cost);
            (p.min..=p.max).contains(&values[index]) && at() <= fit.evaluation.cost + left
        };
        shifts.take_while(stays).last().unwrap_or(0.0)
    };
    to_side(-1.0).max(to_side(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::Role;
    use crate::fit::{FitOptions, fit};
    use crate::toy::{Toy, campaign, run};
    use sealegs_model::{Excitation, Model};

    #[test]
    fn an_interval_grows_where_the_error_has_many_minima_and_nowhere_else() {
        // The noise is stated half as great as it is, so that something is left.
        let (noise, stated) = ((0.2, 0.001), (0.1, 0.0005));
        let campaign =
            campaign(vec![(Role::Fit, run(&[1.0, 4.0, 400.0], 800, 7, noise, (1.0, 0.0), 1.0))], stated);
        let with_wave = |amplitude: f64| {
            let mut toy = Toy::new();
            toy.wave = (amplitude, 4e-5);
            let data = Data::new(&campaign, None, &toy).unwrap();
            let model = toy.with_effect("cubic-sensor", &Excitation::default()).unwrap();
            let start = Some(model.parameters().iter().map(|p| p.neutral.unwrap_or(p.value)).collect());
            let fit = fit(&data, model.as_ref(), &FitOptions { start, ..FitOptions::default() }).unwrap();
            let set = Candidate::exactly(&data, vec!["cubic-sensor".to_owned()], model, fit);
            let (wide, names) = widened(&data, &set);
            (set.fit.parameters[3].std, wide.parameters[3].std, names)
        };
        let (own, kept, names) = with_wave(0.0);
        assert!(own == kept && names.is_empty(), "{own} {kept} {names:?}");
        let (narrow, wide, names) = with_wave(2e-4);
        assert!(narrow < 0.1 * own && wide > own && names == ["cubic-sensor.a"], "{narrow} {wide} {own}");
    }
}
