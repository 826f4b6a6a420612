//! Ground friction: another Coulomb coefficient between sole and ground.

use super::{Build, FOOT, LegEffect, LegSetting};
use sealegs_actuator::effect::{with_neutral, with_starts};
use sealegs_model::{EffectCard, Parameter};

/// A sole that slips sooner or later than the scenario says.
#[derive(Debug)]
pub struct GroundFriction;

impl LegEffect for GroundFriction {
    fn id(&self) -> &'static str {
        "ground-friction"
    }

    fn places(&self, leg: &LegSetting) -> Vec<String> {
        leg.scenario.ground.map(|_| FOOT.to_owned()).into_iter().collect()
    }

    fn card(&self, _place: &str, leg: &LegSetting) -> EffectCard {
        let own = leg.scenario.ground.map_or(0.8, |g| g.friction);
        let change = Parameter { typical: 0.05, ..Parameter::new("change", "", -0.5 * own, -own, 2.0) };
        EffectCard {
            id: self.id().to_owned(),
            summary: "A sole that slips sooner or later than assumed.".to_owned(),
            acts_on: FOOT.to_owned(),
            equation: "T at most (mu + change) N".to_owned(),
            validity: "Matters only where the sole slips, or would.".to_owned(),
            reference: "C. A. Coulomb 1785".to_owned(),
            parameters: vec![with_neutral(with_starts(change, [-0.85 * own, 0.2]), 0.0)],
            symbols: "T: tangential force; N: normal force; mu: the scenario's coefficient".to_owned(),
            told_apart:
                "It acts only where the sole slides. A run in which the foot is pushed sideways tells it; \
                         without sliding nothing does."
                    .to_owned(),
            cure: "Clean the ground, use another sole, or correct the friction of the scenario's [ground]."
                .to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _place: &str, leg: &mut Build) {
        if let Some(ground) = &mut leg.scenario.ground {
            ground.friction = (ground.friction + values[0]).max(0.0);
        }
    }
}
