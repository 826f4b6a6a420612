//! Back to what is known of the base parameters, where a fit has driven them far from it.
//!
//! Without an effect a wrong model drives them away, and with the right one a search from there may come to rest on its
//! way back: where a part rings for long, the error has a comb of valleys along every parameter, each of them at the
//! noise, and only what is known beforehand tells which of them is right.

use super::candidate::{Candidate, Effort};
use super::finish::{following, moved};
use super::screen::is_amplitude;
use super::search::FINAL_STEPS;
use crate::data::Data;
use crate::fit::FittedParameter;
use rayon::prelude::*;
use sealegs_model::{Excitation, Model, Scale};

/// Prior standard deviations from its nominal value beyond which a base parameter is suspected to have been driven there.
const FAR: f64 = 2.5;

/// Ratios by which a strength or a magnitude of an effect is moved beside the nominal base model: a ladder, then a finer
/// one from where that led.
const LADDER: [f64; 13] = [0.3, 0.37, 0.45, 0.55, 0.67, 0.82, 1.0, 1.22, 1.5, 1.8, 2.2, 2.7, 3.3];
/// Powers of the ladder's ratios, round by round.
const ROUNDS: [f64; 3] = [1.0, 0.25, 0.06];

/// Steps in which the other parameters follow there.
const STEPS: usize = 3;

/// The most promising places, which are fitted.
const FITTED: usize = 4;

/// Whether a fit has driven a base parameter to a bound, or far from its nominal value.
pub(super) fn is_driven(base: &dyn Model, candidate: &Candidate) -> bool {
    let driven = |p: &FittedParameter| {
        let far = p.prior_std.is_some_and(|std| (p.value - p.nominal).abs() > FAR * std);
        !p.fixed && (p.at_bound.is_some() || far)
    };
    candidate.fit.parameters[..base.parameters().len()].iter().any(driven)
}

/// The same values with the nominal ones of the base parameters.
pub(super) fn with_nominal_base(base: &dyn Model, mut known: Vec<(String, f64)>) -> Vec<(String, f64)> {
    for p in base.parameters().iter().filter(|p| !p.fixed) {
        for entry in known.iter_mut().filter(|(name, _)| *name == p.name) {
            entry.1 = p.value;
        }
    }
    known
}

/// The candidate, or a fit of lower cost, what is known beforehand counted, from the base parameters' nominal values and
/// from other strengths of the effects. For models whose fits are cheap.
pub fn reconciled(data: &Data, base: &dyn Model, seen: &Excitation, mut candidate: Candidate) -> Candidate {
    let effort_of = |steps: usize| Effort { last: true, ..Effort::steps(steps) };
    let finally = effort_of(FINAL_STEPS);
    for power in ROUNDS {
        if !is_driven(base, &candidate) {
            break;
        }
        let model = candidate.model.as_ref();
        let strength = |i: &usize| {
            let p = &model.parameters()[*i];
            *i >= base.parameters().len() && (p.scale == Scale::Logarithmic || is_amplitude(p))
        };
        let nominal: Vec<f64> =
            with_nominal_base(base, candidate.known()).into_iter().map(|(_, v)| v).collect();
        let places = moved(&candidate, &nominal, strength, &LADDER.map(|ratio| ratio.powf(power)));
        let mut followed: Vec<(Vec<f64>, f64)> = places
            .into_par_iter()
            .filter_map(|(i, start)| following(data, model, start, i, &effort_of(STEPS)))
            .collect();
        followed.sort_by(|a, b| a.1.total_cmp(&b.1));
        followed.truncate(FITTED);
        let fitted: Vec<Option<Candidate>> = followed
            .par_iter()
            .map(|(values, _)| {
                Candidate::fitted(data, base, &candidate.effects, seen, &candidate.named(values), &finally)
                    .ok()
            })
            .collect();
        let best = fitted.into_iter().flatten().reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a });
        candidate = best.filter(|best| best.fit.cost < candidate.fit.cost).unwrap_or(candidate);
    }
    candidate
}
