//! Laws that contain others: a richer law whose fitted values are those of a simpler one, as closely as data can say,
//! is the simpler one and no rival of it.

use super::Candidate;
use super::candidate::symbol;
use super::search::{EQUAL_COST, Search};
use crate::fit::Signatures;
use sealegs_model::{EffectCard, Scale, SimplerLaw};

/// Departure from the simpler law, as a share of its strength, that data must exclude.
const EXCLUDED: f64 = 0.1;

/// Standard errors by which they must.
const SURE: f64 = 3.0;

/// Departure below which laws are the same in any case.
const SAME: f64 = 0.01;

/// Departure that must show wherever on its scale another parameter of the law lies (a Stribeck velocity that no run
/// falls below).
const WIDE: f64 = 0.3;

impl Search<'_> {
    /// Whether a set is the chosen one with richer laws in the place of some of its own, whose fitted values say that
    /// they are these.
    pub(super) fn is_the_same(&self, chosen: &Candidate, richer: &Candidate) -> bool {
        let cards = self.base.effects(self.seen);
        let mut as_simple: Vec<String> = Vec::new();
        for effect in &richer.effects {
            if chosen.effects.contains(effect) {
                as_simple.push(effect.clone());
                continue;
            }
            let Some(card) = cards.iter().find(|c| c.id == *effect) else { return false };
            match card.becomes.as_ref().map(|law| (law, simpler_id(card, law))) {
                Some((law, id)) if self.is_reduced(chosen, richer, effect, law) => as_simple.push(id),
                _ => return false,
            }
        }
        let alike = as_simple.iter().all(|e| chosen.effects.contains(e));
        alike && chosen.effects.iter().all(|e| as_simple.contains(e))
    }

    /// Whether an effect of a fitted set is the simpler law that it contains.
    fn is_reduced(&self, chosen: &Candidate, candidate: &Candidate, effect: &str, law: &SimplerLaw) -> bool {
        let (fit, parameters) = (&candidate.fit, candidate.model.parameters());
        let own: Vec<usize> =
            (0..parameters.len()).filter(|&i| symbol(&parameters[i].name, effect).is_some()).collect();
        let place = |i: usize| fit.free.iter().position(|&f| f == i);
        let Some((departing, at)) = own.get(law.departure).and_then(|&i| Some((i, place(i)?))) else {
            return false;
        };
        let like = law.like.and_then(|l| own.get(l)).and_then(|&i| Some((i, place(i)?)));
        if law.like.is_some() && like.is_none() {
            return false;
        }
        let c = &fit.covariance;
        let (departure, variance) = match like {
            Some((l, to)) => (
                fit.values[departing] / fit.values[l] - 1.0,
                (c[(at, at)] + c[(to, to)] - 2.0 * c[(at, to)]) / fit.values[l].powi(2),
            ),
            None => (fit.values[departing], c[(at, at)]),
        };
        let std = variance.max(0.0).sqrt();
        if departure.abs() > SAME.max(SURE * std) || departure.abs() + SURE * std > EXCLUDED {
            return false;
        }
        let scale = |i: usize| {
            parameters[i].scale == Scale::Logarithmic && i != departing && like.is_none_or(|(l, _)| l != i)
        };
        own.iter().filter(|&&i| scale(i)).all(|&i| {
            let mut values = fit.values.clone();
            values[i] = parameters[i].min;
            values[departing] = like.map_or(WIDE, |(l, _)| (1.0 + WIDE) * fit.values[l]);
            self.would_show(chosen, candidate, &values)
        })
    }

    /// Whether a set at these values predicts what the chosen one cannot, however its own parameters are fitted.
    fn would_show(&self, chosen: &Candidate, other: &Candidate, values: &[f64]) -> bool {
        let Ok(predicted) = self.data.predict(other.model.as_ref(), values) else { return false };
        let own = &chosen.fit.evaluation.predictions;
        let signatures = Signatures::new(self.data, &chosen.fit, own, &[&predicted]);
        signatures.gradient[0] + 0.5 * signatures.gram[(0, 0)] > EQUAL_COST
    }
}

/// The id of the simpler law at the same place.
fn simpler_id(card: &EffectCard, law: &SimplerLaw) -> String {
    card.id.rsplit_once('/').map_or_else(|| law.id.to_owned(), |(place, _)| format!("{place}/{}", law.id))
}
