//! Laws that repeat along the screw, in the place of the simpler one that they become where nothing repeats.
//!
//! A friction of a tenth of a newton shows in open loop, over seconds, and not in the force that is missing at an instant.
//! Beside the same friction without its waves, a wave's signature is linear in its size: every period that a travel can
//! tell from the next one is looked at, in two phases.

use super::nested::simpler_id;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{Known, symbol};
use crate::diagnose::policy::{PERIODS, SCREEN_STEPS_PER_SAMPLE, SLIGHT_WAVE};
use crate::diagnose::refine::Models;
use crate::diagnose::screen::periods::{peaks, waves_along};
use crate::fit::Signatures;
use rayon::prelude::*;
use sealegs_model::{EffectCard, SimplerAt, internal};
use std::f64::consts::TAU;

/// Where a card of a law that repeats along the screw has its parameters, and what it becomes.
struct Repeating {
    simple: String,
    /// The size of both laws.
    size: usize,
    /// The share of it that repeats, 0 for the simpler law.
    share: usize,
    period: usize,
    place: usize,
}

impl Repeating {
    fn of(card: &EffectCard) -> Option<Self> {
        let law = card.becomes.as_ref().filter(|law| law.at == SimplerAt::Zero)?;
        let at = |name: &str| card.parameters.iter().position(|p| p.name.starts_with(name));
        let (period, place) = (at(EffectCard::PERIOD)?, at(EffectCard::PLACE)?);
        Some(Self { simple: simpler_id(card, law), size: 0, share: law.departure, period, place })
    }
}

/// The simpler law's id, where a card is of a law that repeats along the screw.
pub(crate) fn simpler_along(card: &EffectCard) -> Option<String> {
    Repeating::of(card).map(|law| law.simple)
}

impl Models<'_> {
    /// A set with a law that repeats along the screw in the place of the simpler one in `near`, from the periods that
    /// promise most in open loop; the lowest fit. `None` if `near` has no such law, or a simulation is dear.
    #[must_use]
    pub(crate) fn repeating(&self, near: &Candidate, card: &EffectCard) -> Option<Candidate> {
        let law = Repeating::of(card).filter(|law| !self.dear && near.effects.contains(&law.simple))?;
        let (before, known) = (&near.fit.values, near.known());
        // The simpler law's first parameter means what the richer one's does, whatever it is called.
        let (_, size) = known.iter().find(|(name, _)| symbol(name, &law.simple).is_some())?;
        let size = *size;
        let place = card.id.rsplit_once('/').map_or("", |(place, _)| place);
        let predictions = near.fit.evaluation.predictions.iter();
        let positions = predictions.filter_map(|p| p.internal_at(place, internal::SCREW_POSITION)).flatten();
        let (travel, waves) = waves_along(positions.copied(), &card.parameters[law.period])?;
        let coarse = near.model.coarser(SCREEN_STEPS_PER_SAMPLE);
        let unchanged = self.data.predict_outputs(coarse.as_ref(), before).ok()?;
        let model = coarse.with_effect(&card.id, &self.seen).ok()?;
        let slight = SLIGHT_WAVE * size;
        let with_wave = |period: f64, turn: f64| {
            let mut own: Vec<f64> = card.parameters.iter().map(|p| p.value).collect();
            (own[law.size], own[law.share]) = (slight, 1.0);
            (own[law.period], own[law.place]) = (period, turn * period);
            let values: Vec<f64> = before.iter().copied().chain(own).collect();
            self.data.predict_outputs(model.as_ref(), &values).ok()
        };
        // By how much the cost falls, and with which wave.
        let look = |waves: &f64| {
            let both = [with_wave(travel / waves, 0.0)?, with_wave(travel / waves, 0.25)?];
            let signatures = Signatures::new(self.data, &near.fit, &unchanged, &[&both[0], &both[1]]);
            Some(signatures.wave(0, 1)).filter(|wave| wave.0.is_finite())
        };
        let looks: Vec<(f64, f64, f64)> = waves.par_iter().map(|w| look(w).unwrap_or_default()).collect();
        let drops: Vec<f64> = looks.iter().map(|look| look.0).collect();
        let effects: Vec<String> =
            near.effects.iter().map(|e| if *e == law.simple { card.id.clone() } else { e.clone() }).collect();
        let named = |at: usize, value: f64| (format!("{}.{}", card.id, card.parameters[at].name), value);
        let from = |i: usize| {
            let (period, (_, amplitude, phase)) = (travel / waves[i], looks[i]);
            let most = card.parameters[law.share].max;
            let start: Known = vec![
                named(law.size, size),
                named(law.share, (slight * amplitude / size).min(most)),
                named(law.period, period),
                named(law.place, phase / TAU * period),
            ];
            self.fitted_near(near, &effects, &known.iter().cloned().chain(start).collect())
        };
        let mut best: Vec<usize> = peaks(&drops);
        best.truncate(PERIODS as usize);
        let fitted: Vec<Candidate> = best.into_par_iter().filter_map(from).collect();
        fitted.into_iter().reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::Toy;
    use sealegs_model::{Excitation, Model, Parameter, SimplerLaw};

    #[test]
    fn a_law_repeats_along_the_screw_if_it_has_a_period_and_becomes_another_one_without_its_share() {
        let becomes = Some(SimplerLaw { id: "plain", departure: 1, at: SimplerAt::Zero, beside: None });
        let names = ["force_n", "share", "period_m", "place_m"];
        let mut card = EffectCard {
            id: "knee/wavy".to_owned(),
            parameters: names.map(|name| Parameter::new(name, "", 1.0, 0.0, 2.0)).to_vec(),
            becomes,
            ..Toy::new().effects(&Excitation::default()).remove(0)
        };
        let law = Repeating::of(&card).expect("it repeats");
        assert_eq!((law.simple.as_str(), law.size, law.share), ("knee/plain", 0, 1));
        assert_eq!((law.period, law.place), (2, 3));
        card.parameters.truncate(2);
        assert!(Repeating::of(&card).is_none());
    }
}
