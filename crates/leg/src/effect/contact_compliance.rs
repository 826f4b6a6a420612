//! Contact compliance: a sole or floor that is softer, harder or more damped than the scenario's.

use super::{Build, FOOT, LegEffect, LegSetting};
use sealegs_actuator::effect::{magnitude, with_neutral, with_starts};
use sealegs_model::{EffectCard, Parameter};

/// Another stiffness and damping of the sole's contact with the ground.
#[derive(Debug)]
pub struct ContactCompliance;

impl LegEffect for ContactCompliance {
    fn id(&self) -> &'static str {
        "contact-compliance"
    }

    fn places(&self, leg: &LegSetting) -> Vec<String> {
        leg.scenario.ground.map(|_| FOOT.to_owned()).into_iter().collect()
    }

    fn card(&self, _place: &str, leg: &LegSetting) -> EffectCard {
        let damping = leg.scenario.ground.map_or(0.5, |g| g.damping_s_m);
        let change =
            Parameter { typical: 0.1, ..Parameter::new("damping_change_s_m", "s/m", 0.0, -damping, 5.0) };
        EffectCard {
            id: self.id().to_owned(),
            summary: "A sole or floor softer, harder or more damped than assumed.".to_owned(),
            acts_on: FOOT.to_owned(),
            equation: "N = s k d^n (1 + (c + dc) d')".to_owned(),
            validity: "s multiplies the contact stiffness of every sole point, dc adds to its damping."
                .to_owned(),
            reference: "K. H. Hunt and F. R. E. Crossley 1975, J. Appl. Mech. 42".to_owned(),
            parameters: vec![
                with_neutral(
                    with_starts(magnitude("stiffness_ratio", "", 0.3, 1e-3, 100.0), [0.05, 3.0]),
                    1.0,
                ),
                with_neutral(with_starts(change, [0.5]), 0.0),
            ],
            symbols: "s: stiffness_ratio; k, n, c: the scenario's contact; d: depth; dc: damping_change; N: normal \
                      force".to_owned(),
            told_apart: "The first milliseconds after touch-down change in peak and length, the flight does not. A \
                         wrong spring setting shows while the leg swings as well.".to_owned(),
            cure: "Press the sole on a scale and correct the scenario's [ground], or replace a worn sole.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn replaces(&self) -> &'static [&'static str] {
        &["contact_stiffness", "contact_damping"]
    }

    fn install(&self, values: &[f64], _place: &str, leg: &mut Build) {
        if let Some(ground) = &mut leg.scenario.ground {
            ground.stiffness_n_m_n *= values[0];
            ground.damping_s_m = (ground.damping_s_m + values[1]).max(0.0);
        }
    }
}
