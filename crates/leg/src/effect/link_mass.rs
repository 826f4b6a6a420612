//! Link mass: a link heavier or lighter than its URDF says, or with its mass elsewhere.

use super::{Build, LegEffect, LegSetting};
use nalgebra::Vector3;
use sealegs_actuator::effect::{with_neutral, with_starts};
use sealegs_model::{EffectCard, Parameter};

/// Another mass and centre of mass of a link.
#[derive(Debug)]
pub struct LinkMass;

/// One standard deviation of what is known of the inertia's ratio: an estimate. A tenth of a link's mass at half its length from
/// the centre makes it 1.3 for a slender rod.
const INERTIA_TOLERANCE: f64 = 0.3;

impl LegEffect for LinkMass {
    fn id(&self) -> &'static str {
        "link-mass"
    }

    /// Links that move; the base moves on a rail only.
    fn places(&self, leg: &LegSetting) -> Vec<String> {
        let fixed = matches!(leg.scenario.base, crate::scenario::BaseSpec::Fixed { .. });
        let links =
            leg.robot.links.iter().enumerate().filter(|(i, l)| l.inertial.is_some() && !(fixed && *i == 0));
        links.map(|(_, l)| l.name.clone()).collect()
    }

    fn card(&self, place: &str, leg: &LegSetting) -> EffectCard {
        let own = leg.robot.link_index(place).and_then(|i| leg.robot.links[i].inertial.as_ref());
        let mass = own.map_or(1.0, |i| i.mass_kg);
        let kg = Parameter {
            typical: 0.05 * mass,
            ..Parameter::new("mass_kg", "kg", 0.3 * mass, -0.7 * mass, 4.0 * mass.max(1.0))
        };
        let shift = |name: &str| {
            let m = Parameter { typical: 0.01, ..Parameter::new(name, "m", 0.0, -0.2, 0.2) };
            with_neutral(m, 0.0)
        };
        let inertia = Parameter {
            typical: 0.1,
            prior_std: Some(INERTIA_TOLERANCE),
            ..Parameter::new("inertia_ratio", "", 1.0, 0.2, 5.0)
        };
        EffectCard {
            id: self.id().to_owned(),
            summary: "A link heavier or lighter than its URDF says, or with its mass elsewhere.".to_owned(),
            acts_on: "link".to_owned(),
            equation: "m + dm about a centre moved by dx, dz in the link's frame; I s (m + dm)/m about it".to_owned(),
            validity: "A mass that is spread as the link's own has s = 1; one at a place far from the centre has more, and s \
                       is known to a third before it is fitted."
                .to_owned(),
            reference: "Cables, covers and electronics that a CAD model leaves out".to_owned(),
            parameters: vec![
                with_neutral(kg, 0.0),
                with_starts(shift("shift_x_m"), [0.03]),
                with_starts(shift("shift_z_m"), [0.05]),
                with_neutral(inertia, 1.0),
            ],
            symbols: "m, I: the link's mass and inertia; dm: mass; dx, dz: shift_x, shift_z; s: inertia_ratio".to_owned(),
            told_apart:
                "The missing torque follows the pose as gravity does, at rest as well. Friction depends on \
                         the direction of motion, an offset on nothing."
                    .to_owned(),
            cure: "Weigh the link with its cables and covers, and correct the URDF.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], place: &str, leg: &mut Build) {
        let link = leg.robot.link_index(place);
        let Some(own) = link.and_then(|i| leg.robot.links[i].inertial.as_mut()) else { return };
        let ratio = (own.mass_kg + values[0]) / own.mass_kg;
        own.mass_kg += values[0];
        own.inertia *= ratio * values[3];
        own.com += Vector3::new(values[1], 0.0, values[2]);
    }
}
