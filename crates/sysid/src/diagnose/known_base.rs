//! Back to what is known of the base parameters, where a fit has driven them far from it.
//!
//! Without an effect a wrong model drives them away, and with the right one a search from there may come to rest on its
//! way back: where a part rings for long, the error has a comb of valleys along every parameter, each of them at the
//! noise, and only what is known beforehand tells which of them is right.

use super::candidate::{Candidate, Effort};
use super::finish::{following, moved};
use super::profile::Place;
use super::screen::is_amplitude;
use super::search::{FINAL_STEPS, Search};
use crate::data::Data;
use crate::fit::{self, Difference, FittedParameter};
use rayon::prelude::*;
use sealegs_model::{Excitation, Model, Parameter, Scale};

/// Prior standard deviations from its nominal value beyond which a base parameter is suspected to have been driven there.
const FAR: f64 = 2.5;

/// The same as a ratio where only an order of magnitude was known.
const FAR_RATIO: f64 = 3.0;

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
    let driven = |(p, known): (&FittedParameter, &Parameter)| {
        let far = match p.prior_std {
            Some(std) => (p.value - p.nominal).abs() > FAR * std,
            None => is_unknown(known) && (p.value / p.nominal).ln().abs() > FAR_RATIO.ln(),
        };
        !p.fixed && (p.at_bound.is_some() || far)
    };
    candidate.fit.parameters.iter().zip(base.parameters()).any(driven)
}

/// Whether nothing is known of a base parameter but an order of magnitude.
pub(super) fn is_unknown(p: &Parameter) -> bool {
    !p.fixed && p.prior_std.is_none() && p.scale == Scale::Logarithmic
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

/// A candidate's values with the nominal ones of the base parameters.
pub(super) fn values_with_nominal_base(base: &dyn Model, candidate: &Candidate) -> Vec<f64> {
    with_nominal_base(base, candidate.known()).into_iter().map(|(_, value)| value).collect()
}

impl Search<'_> {
    /// A candidate with the base parameters' nominal values, as it is.
    pub(super) fn at_nominal(&self, candidate: &Candidate) -> Option<Candidate> {
        let (model, values) = (candidate.model.as_ref(), values_with_nominal_base(self.base, candidate));
        let fit = fit::at_values(self.data, model, &values, Difference::Forward).ok()?;
        Some(Candidate { fit, ..candidate.clone() })
    }

    /// Puts a fit in the place of a polished one that what is known of the base parameters speaks against, where one is
    /// found and fits are cheap; the other places that were looked at.
    pub(super) fn reconcile(&mut self, index: usize) -> Vec<Place> {
        if self.options.secants {
            return Vec::new();
        }
        let candidate = self.tried[index].clone();
        let (found, places) = places_beside(self.data, self.exact, self.seen, candidate);
        if found.fit.cost < self.tried[index].fit.cost {
            self.tried[index] = self.polished(&found);
        }
        places
    }
}

/// The candidate, or a fit of lower cost, what is known beforehand counted, from the base parameters' nominal values and
/// from other strengths of the effects, with all places that were fitted on the way. For models whose fits are cheap;
/// nothing is done where what is known neither speaks against the candidate nor leaves a part of it open.
fn places_beside(
    data: &Data,
    base: &dyn Model,
    seen: &Excitation,
    mut candidate: Candidate,
) -> (Candidate, Vec<Place>) {
    let effort_of = |steps: usize| Effort { last: true, ..Effort::steps(steps) };
    let finally = effort_of(FINAL_STEPS);
    let mut places = Vec::new();
    for power in ROUNDS {
        let open = candidate.model.parameters().iter().any(|p| p.freed_at_last);
        if !open && !is_driven(base, &candidate) {
            break;
        }
        let model = candidate.model.as_ref();
        let strength = |i: &usize| {
            let p = &model.parameters()[*i];
            *i >= base.parameters().len() && (p.scale == Scale::Logarithmic || is_amplitude(p))
        };
        let nominal = values_with_nominal_base(base, &candidate);
        let moved = moved(&candidate, &nominal, strength, &LADDER.map(|ratio| ratio.powf(power)));
        let mut followed: Vec<Place> = moved
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
        let fitted: Vec<Candidate> = fitted.into_iter().flatten().collect();
        places.extend(fitted.iter().map(|c| (c.fit.values.clone(), c.fit.cost)));
        let best = fitted.into_iter().reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a });
        candidate = best.filter(|best| best.fit.cost < candidate.fit.cost).unwrap_or(candidate);
    }
    (candidate, places)
}

/// The candidate, or a fit of lower cost, what is known beforehand counted, from the base parameters' nominal values and
/// from other strengths of the effects, where the candidate contradicts what is known. For models whose fits are cheap.
pub fn reconciled(data: &Data, base: &dyn Model, seen: &Excitation, candidate: Candidate) -> Candidate {
    places_beside(data, base, seen, candidate).0
}
