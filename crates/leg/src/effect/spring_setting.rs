//! Spring setting: a beam clamped at another setting than the scenario says.

use super::{Build, LegEffect, LegSetting};
use crate::robot::Drive;
use crate::simulation::actuator_spec;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::effect::{magnitude, with_neutral, with_starts};
use sealegs_actuator::spec::EffectValue;
use sealegs_model::EffectCard;

/// A spring at another setting: compliant taken for stiff.
#[derive(Debug)]
pub struct SpringSetting;

/// Settings by name that a clamped beam has.
const NAMED: [&str; 3] = ["compliant", "stiff", "locked-out"];

/// A setting is told from an individual's tolerance by at least this ratio.
const APART: f64 = 1.05;

impl LegEffect for SpringSetting {
    fn id(&self) -> &'static str {
        "spring-setting"
    }

    fn places(&self, leg: &LegSetting) -> Vec<String> {
        let sprung = leg.robot.actuators.iter().filter(|a| !matches!(a.drive, Drive::RigidPosition { .. }));
        sprung.map(|a| a.name.clone()).collect()
    }

    fn card(&self, place: &str, leg: &LegSetting) -> EffectCard {
        let spec = leg
            .robot
            .actuator_index(place)
            .and_then(|i| leg.robot.actuators[i].spec.as_ref())
            .and_then(|spec| actuator_spec(leg.scenario, place, spec).ok());
        let others = spec.as_ref().map_or_else(Vec::new, other_settings);
        let ratios: Vec<f64> = others.iter().map(|(_, r)| *r).collect();
        let (first, rest) = ratios.split_first().map_or((0.5, &[2.0][..]), |(f, rest)| (*f, rest));
        let least = ratios.iter().copied().fold(0.3, f64::min);
        let most = ratios.iter().copied().fold(3.0, f64::max);
        let ratio = magnitude("stiffness_ratio", "", first, 0.8 * least, 1.25 * most);
        let words: Vec<String> = others.iter().map(|(name, r)| format!("{r:.3} is {name}")).collect();
        let validity = if words.is_empty() {
            "Beyond the tolerance of an individual spring.".to_owned()
        } else {
            format!("Beyond the tolerance of an individual spring: {}.", words.join(", "))
        };
        EffectCard {
            id: self.id().to_owned(),
            summary: "A spring clamped at another setting than the scenario says.".to_owned(),
            acts_on: "spring".to_owned(),
            equation: "s k delta".to_owned(),
            validity,
            reference: "Dissertation sections 2-4 and 2-5: settings of the beams".to_owned(),
            parameters: vec![with_neutral(with_starts(ratio, rest.iter().copied()), 1.0)],
            symbols: "s: stiffness_ratio; k: nominal stiffness; delta: deflection".to_owned(),
            told_apart:
                "A load at rest is enough: force over deflection is off by the ratio of two settings, not by \
                         a few per cent. A hardening spring is right at small deflections."
                    .to_owned(),
            cure:
                "Read the clamp's position and clamp again, or correct the spring's setting in the scenario."
                    .to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], place: &str, leg: &mut Build) {
        let own = leg.scenario.actuator.entry(place.to_owned()).or_default();
        own.parameters.insert("stiffness_ratio".to_owned(), EffectValue { value: values[0], std: None });
    }
}

/// The named settings that the spring could have instead, with the ratio of their stiffness to the present one.
fn other_settings(spec: &ActuatorSpec) -> Vec<(&'static str, f64)> {
    let present = spec.spring.stiffness();
    let ratio = |name: &&'static str| {
        let other = spec.spring.with_setting(name).ok()?;
        Some((*name, other.stiffness() / present)).filter(|(_, r)| *r > APART || *r < 1.0 / APART)
    };
    NAMED.iter().filter_map(ratio).collect()
}
