//! Laws that contain others: where no departure from the simpler law could hide in the data, the richer one is it by
//! another name, and no rival.

use super::Candidate;
use super::candidate::symbol;
use super::policy::TIED_COST;
use super::refine::Models;
use crate::fit::{EQUAL_COST, Signatures};
use sealegs_model::{EffectCard, Scale, SimplerAt, SimplerLaw};

/// Departure of a richer law from the simpler one that it contains, as a share of its strength, that data must exclude for
/// both to be the same.
pub const DEPARTURE: f64 = 0.3;

impl Models<'_> {
    /// The sets among those tried that are the chosen one by another name.
    pub(super) fn by_another_name(&self, tried: &[Candidate], chosen: usize) -> Vec<usize> {
        let others = (0..tried.len()).filter(|&i| i != chosen);
        others.filter(|&i| self.is_the_same(&tried[chosen], &tried[i])).collect()
    }

    /// Whether a set is the chosen one with richer laws in the place of some of its own, fits no better, and could not
    /// depart from it unseen.
    fn is_the_same(&self, chosen: &Candidate, richer: &Candidate) -> bool {
        let cost = chosen.fit.cost;
        let comparable = richer.effects.len() == chosen.effects.len() && richer.fit.cost <= TIED_COST * cost;
        if !comparable || richer.fit.cost < cost - EQUAL_COST {
            return false;
        }
        let cards = self.exact.effects(&self.seen);
        let mut as_simple: Vec<String> = Vec::new();
        for effect in &richer.effects {
            if chosen.effects.contains(effect) {
                as_simple.push(effect.clone());
                continue;
            }
            let card = cards.iter().find(|c| c.id == *effect);
            match card.and_then(|card| Some((card, card.becomes.as_ref()?))) {
                Some((card, law)) if self.cannot_hide(chosen, richer, card, law) => {
                    as_simple.push(simpler_id(card, law));
                }
                _ => return false,
            }
        }
        let alike = as_simple.iter().all(|e| chosen.effects.contains(e));
        alike && chosen.effects.iter().all(|e| as_simple.contains(e))
    }

    /// Whether a departure of one of the richer set's laws would show, wherever on its scale another parameter of that
    /// law lies, among those that are tried for it (a Stribeck velocity that the runs hardly fall below).
    fn cannot_hide(
        &self,
        chosen: &Candidate,
        richer: &Candidate,
        card: &EffectCard,
        law: &SimplerLaw,
    ) -> bool {
        let parameters = richer.model.parameters();
        let own: Vec<usize> =
            (0..parameters.len()).filter(|&i| symbol(&parameters[i].name, &card.id).is_some()).collect();
        let mut departed = richer.fit.values.clone();
        let departs = own[law.departure];
        departed[departs] = match law.at {
            SimplerAt::Zero => DEPARTURE,
            SimplerAt::Equal(like) => (1.0 + DEPARTURE) * departed[own[like]],
            // Every value that is tried for it departs.
            SimplerAt::Infinity => departed[departs],
        };
        let mut places = vec![departed];
        for (&i, p) in own.iter().zip(&card.parameters) {
            if p.scale == Scale::Logarithmic && (i != departs || law.at == SimplerAt::Infinity) {
                let values = p.starts.iter().copied().chain([p.min, p.value]);
                let at = |value: f64| {
                    places.iter().map(move |place| {
                        let mut place = place.clone();
                        place[i] = value;
                        place
                    })
                };
                places = values.flat_map(at).collect();
            }
        }
        places.iter().all(|place| self.would_show(chosen, richer, place))
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
pub(super) fn simpler_id(card: &EffectCard, law: &SimplerLaw) -> String {
    card.id.rsplit_once('/').map_or_else(|| law.id.to_owned(), |(place, _)| format!("{place}/{}", law.id))
}
