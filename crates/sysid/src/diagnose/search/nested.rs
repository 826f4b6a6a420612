//! Laws that contain others: where no departure from the simpler law could hide in the data, the richer one is it by
//! another name, and no rival.

use super::Search;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{Known, all_but, compare::clearly_better, is_amplitude, symbol};
use crate::diagnose::policy::TIED_COST;
use crate::diagnose::refine::Models;
use crate::fit::{EQUAL_COST, Signatures};
use sealegs_model::{EffectCard, Parameter, Scale, SimplerAt, SimplerLaw};

/// Departure of a richer law from the simpler one that it contains, as a share of its strength, that data must exclude for
/// both to be the same.
pub const DEPARTURE: f64 = 0.3;

impl Models<'_> {
    /// The sets among those tried that are the chosen one by another name.
    pub(crate) fn by_another_name(&self, tried: &[Candidate], chosen: usize) -> Vec<usize> {
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

impl Search<'_> {
    /// Values of a set, with the strength of a law that is not in its rest added to that of the simpler one which the base model
    /// has: such a law takes what the simpler one lacks, and a fit without it does not find the way there. `None` where there is none.
    pub(crate) fn merged_with_base(&self, whole: &Candidate, rest: &[String]) -> Option<Known> {
        let (cards, included) = (self.models.exact.effects(&self.models.seen), self.models.exact.included());
        whole.effects.iter().filter(|e| !rest.contains(e)).find_map(|leaving| {
            let card = cards.iter().find(|c| c.id == *leaving)?;
            let simple = simpler_id(card, card.becomes.as_ref()?);
            let own = whole.model.parameters();
            included.contains(&simple).then(|| with_strength_of(own, &whole.fit.values, &simple, leaving))?
        })
    }

    /// A set without the members whose law another member contains (dry friction beside one that has a Stribeck effect), the
    /// other one taking over their strength, unless that is clearly worse: a fit that begins at the other one's own strength
    /// does not find the way there.
    pub(crate) fn without_contained(&mut self, best: usize) -> usize {
        let set = self.tried[best].clone();
        let cards = self.models.exact.effects(&self.models.seen);
        let card = |id: &String| cards.iter().find(|c| c.id == *id);
        let contained = |richer: &String| {
            let law = card(richer)?;
            let simple = simpler_id(law, law.becomes.as_ref()?);
            set.effects.contains(&simple).then(|| (richer.clone(), simple))
        };
        for (richer, simple) in set.effects.iter().filter_map(contained) {
            let own = set.model.parameters();
            let Some(known) = with_strength_of(own, &set.fit.values, &richer, &simple) else { continue };
            let rest = all_but(&set.effects, &simple);
            let Some(fitted) = self.models.fitted(&set, &rest, &known, None) else { continue };
            let index = self.kept(self.models.finished(fitted));
            if !clearly_better(&self.tried[index], &set, self.models.data.floor) {
                return self.without_contained(index);
            }
        }
        best
    }
}

/// Values by name, with the strength of a law that leaves added to those of another one that are in the same unit.
fn with_strength_of(parameters: &[Parameter], values: &[f64], stays: &str, leaves: &str) -> Option<Known> {
    let all = || parameters.iter().zip(values);
    let is_of = |p: &Parameter, effect: &str| symbol(&p.name, effect).is_some() && is_amplitude(p);
    let (leaving, strength) = all().find(|(p, _)| is_of(p, leaves))?;
    let takes = |p: &Parameter| is_of(p, stays) && p.unit == leaving.unit;
    Some(all().map(|(p, v)| (p.name.clone(), if takes(p) { v + strength } else { *v })).collect())
}

/// Values by name with those of a simpler law beside a richer law's own: its parameters mean what the richer one's first
/// ones do, whatever they are called (see [`SimplerLaw`]).
pub(crate) fn as_simple(known: &Known, richer: &EffectCard, simple: &EffectCard) -> Known {
    let taken = richer.parameters.iter().zip(&simple.parameters).filter_map(|(from, to)| {
        let of = format!("{}.{}", richer.id, from.name);
        let (_, value) = known.iter().find(|(name, _)| *name == of)?;
        Some((format!("{}.{}", simple.id, to.name), *value))
    });
    known.iter().cloned().chain(taken).collect()
}

/// The id of the simpler law at the same place.
pub(crate) fn simpler_id(card: &EffectCard, law: &SimplerLaw) -> String {
    card.id.rsplit_once('/').map_or_else(|| law.id.to_owned(), |(place, _)| format!("{place}/{}", law.id))
}

#[cfg(test)]
mod tests {
    use super::{as_simple, with_strength_of};
    use crate::toy::Toy;
    use sealegs_model::{EffectCard, Excitation, Model, Parameter};

    #[test]
    fn a_simpler_law_takes_over_the_first_values_of_the_richer_one_by_their_place() {
        let card = |id: &str, names: &[&str]| EffectCard {
            id: id.to_owned(),
            parameters: names.iter().map(|name| Parameter::new(*name, "N", 1.0, 0.0, 2.0)).collect(),
            ..Toy::new().effects(&Excitation::default()).remove(0)
        };
        let (richer, simple) =
            (card("knee/richer", &["sliding_n", "static_n"]), card("knee/simple", &["force_n"]));
        let known = [("damping", 2.0), ("knee/richer.sliding_n", 0.2), ("knee/richer.static_n", 0.3)];
        let known = known.map(|(name, value)| (name.to_owned(), value)).to_vec();
        let taken = as_simple(&known, &richer, &simple);
        assert_eq!(taken[..3], known);
        assert_eq!(taken[3..], [("knee/simple.force_n".to_owned(), 0.2)]);
    }

    #[test]
    fn a_richer_law_takes_over_the_strength_of_the_simple_one_and_nothing_else() {
        let amplitude = |name: &str, unit: &str| Parameter {
            neutral: Some(0.0),
            ..Parameter::new(name, unit, 1.0, 0.0, 100.0)
        };
        let parameters = [
            Parameter::new("damping", "N s/m", 5.0, 0.0, 100.0),
            amplitude("knee/simple.force_n", "N"),
            amplitude("knee/richer.force_n", "N"),
            amplitude("knee/richer.share", "1"),
            amplitude("hip/richer.force_n", "N"),
        ];
        let values = [5.0, 43.0, 7.0, 0.5, 9.0];
        let known = with_strength_of(&parameters, &values, "knee/richer", "knee/simple").expect("values");
        let taken: Vec<f64> = known.into_iter().map(|(_, value)| value).collect();
        assert_eq!(taken, [5.0, 43.0, 50.0, 0.5, 9.0]);
        assert!(with_strength_of(&parameters, &values, "knee/richer", "knee/none").is_none());
    }
}
