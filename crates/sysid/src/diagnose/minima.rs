//! Other minima of the error along a base parameter.
//!
//! A joint that hardly moves rings for tens of periods after every impulse. The error of such a run has a minimum for each
//! number of periods that its spring may ring, nearly as deep as the lowest one; within what is known of the spring there are
//! two or three. A fit ends in the one that it began in.

use super::Candidate;
use super::policy::{BENDS, MOST_BEND, NOTHING_MORE, OTHER_MINIMA, OTHER_MINIMA_ROUNDS};
use super::refine::{Models, finishing};
use crate::data::Data;
use crate::fit::FitOptions;
use rayon::prelude::*;

/// Where the error along a parameter is looked at, in standard deviations of what is known of it about its nominal value.
const PLACES: [f64; 11] = [-2.5, -2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5];

impl Models<'_> {
    /// A set fitted again from other minima of its error along a base parameter, if one of them leaves less; `None` otherwise.
    pub(super) fn lower_minimum(&self, set: &Candidate) -> Option<Candidate> {
        let mut best = None;
        for _ in 0..OTHER_MINIMA_ROUNDS as usize {
            let now: &Candidate = best.as_ref().unwrap_or(set);
            let from = |start: Vec<f64>| {
                // Derivatives are others there.
                let options = finishing(self.options(now.model.as_ref(), start, now));
                let options = FitOptions { columns: None, ..options };
                Candidate::fitted(self.data, now.effects.clone(), now.model.clone_box(), &options).ok()
            };
            let again: Vec<Candidate> =
                other_minima(self.data, now).into_par_iter().filter_map(from).collect();
            let lowest = again.into_iter().reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a });
            match lowest.filter(|lowest| lowest.fit.cost < now.fit.cost - NOTHING_MORE) {
                Some(lowest) => best = Some(lowest),
                None => break,
            }
        }
        best
    }
}

/// Values at other minima of a set's error along one of its base parameters, all others held, the lowest ones first. None where
/// the error along most of them is no parabola: play that rattles makes it rugged everywhere, and no place is a beginning.
fn other_minima(data: &Data, set: &Candidate) -> Vec<Vec<f64>> {
    let (fit, parameters) = (&set.fit, set.model.parameters());
    let of_base = |i: usize| !parameters[i].name.contains('.');
    let known: Vec<(usize, usize, f64)> = fit
        .free
        .iter()
        .enumerate()
        .filter_map(|(k, &i)| Some((k, i, parameters[i].prior_std.filter(|_| of_base(i))?)))
        .collect();
    let moved = |i: usize, by: f64| {
        let mut values = fit.values.clone();
        values[i] = (values[i] + by).clamp(parameters[i].min, parameters[i].max);
        values
    };
    let cost = |values: &[f64]| data.evaluate(set.model.as_ref(), values).map_or(f64::INFINITY, |at| at.cost);
    let bends = |&&(k, i, std): &&(usize, usize, f64)| {
        let risen = [-std, std].map(|by| cost(&moved(i, by)) - fit.evaluation.cost);
        // What is known of it makes up one of its curvature, and no part of the cost.
        let expected = fit.normal[(k, k)] * (std / fit.slopes[k]).powi(2) - 1.0;
        risen.iter().sum::<f64>() < BENDS * expected
    };
    let bending: Vec<&(usize, usize, f64)> = known.par_iter().filter(bends).collect();
    if bending.len() as f64 > MOST_BEND * fit.free.iter().filter(|&&i| of_base(i)).count() as f64 {
        return Vec::new();
    }
    let along = |&&(_, i, std): &&(usize, usize, f64)| {
        let at = PLACES.map(|place| moved(i, parameters[i].value + place * std - fit.values[i]));
        let costs: Vec<f64> = at.iter().map(|values| cost(values)).collect();
        let own = |values: &[f64]| (values[i] - fit.values[i]).abs() <= 0.5 * std;
        let is_lowest = |j: &usize| costs[*j] <= costs[j - 1] && costs[*j] <= costs[j + 1] && !own(&at[*j]);
        let places: Vec<usize> = (1..PLACES.len() - 1).filter(is_lowest).collect();
        places.into_iter().map(|j| (costs[j], at[j].clone())).collect::<Vec<_>>()
    };
    let mut all: Vec<(f64, Vec<f64>)> = bending.par_iter().flat_map_iter(along).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.into_iter().take(OTHER_MINIMA as usize).map(|(_, values)| values).collect()
}

#[cfg(test)]
mod tests {
    use crate::Role;
    use crate::data::Data;
    use crate::diagnose::{Candidate, Models};
    use crate::fit::{FitOptions, fit};
    use crate::toy::{Toy, campaign, run};

    #[test]
    fn a_fit_whose_spring_rings_too_fast_goes_on_from_the_lowest_minimum() {
        // So great that what is left at the wrong stiffness is of its size, as on a leg.
        let noise = (10.0, 0.02);
        let mut toy = Toy::new();
        toy.parameters[1].value = 0.2;
        toy.parameters[2].prior_std = Some(40.0);
        let record = run(&[1.0, 0.2, 400.0], 1600, 3, noise, (1.0, 0.0), 1.0);
        let campaign = campaign(vec![(Role::Fit, record)], noise);
        let data = Data::new(&campaign, Some(Role::Fit), &toy).expect("a fit run");
        let models = Models::new(&data, &toy);
        let from = |stiffness: f64| {
            let options =
                FitOptions { start: Some(vec![1.0, 0.2, stiffness]), starts: 1, ..FitOptions::default() };
            let fit = fit(&data, &toy, &options).expect("a fit");
            Candidate::exactly(&data, Vec::new(), Box::new(toy.clone()), fit)
        };
        let off = from(500.0);
        let found = models.lower_minimum(&off).expect("a lower minimum");
        let (before, after) = (off.fit.values[2], found.fit.values[2]);
        assert!((before - 400.0).abs() > 10.0 && (after - 400.0).abs() < 4.0, "{before} {after}");
        assert!(models.lower_minimum(&found).is_none());
    }
}
