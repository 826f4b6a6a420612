//! Link mass: a link heavier or lighter than its URDF says, or with its mass elsewhere.

use super::{Build, LegEffect, LegSetting};
use crate::robot::Inertial;
use sealegs_actuator::effect::{with_neutral, with_starts};
use sealegs_model::{EffectCard, Parameter};

/// Another mass and centre of mass of a link.
#[derive(Debug)]
pub struct LinkMass;

/// Its id without a place.
pub(crate) const ID: &str = "link-mass";

/// One standard deviation of what is known of the inertia's ratio: an estimate. A tenth of a link's mass at half its length from
/// the centre makes it 1.3 for a slender rod.
const INERTIA_TOLERANCE: f64 = 0.3;

impl LegEffect for LinkMass {
    fn id(&self) -> &'static str {
        ID
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
        LinkChange::IN_PLANE.card(own.map_or(1.0, |i| i.mass_kg))
    }

    fn install(&self, values: &[f64], place: &str, leg: &mut Build) {
        let link = leg.robot.link_index(place);
        let Some(own) = link.and_then(|i| leg.robot.links[i].inertial.as_mut()) else { return };
        LinkChange::IN_PLANE.apply(values, own);
    }
}

/// The axes of a link's frame along which its centre of mass may be elsewhere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinkChange {
    /// Each with its parameter and a shift, m, that a fit may start at.
    axes: &'static [(usize, &'static str, f64)],
    farthest_m: f64,
}

impl LinkChange {
    /// A leg moves in a plane.
    const IN_PLANE: Self = Self { axes: &[(0, "shift_x_m", 0.03), (2, "shift_z_m", 0.05)], farthest_m: 0.2 };

    /// A robot turns about any axis, and carries what is farther away than what a drawing left out.
    pub const IN_SPACE: Self = Self {
        axes: &[(0, "shift_x_m", 0.03), (1, "shift_y_m", 0.03), (2, "shift_z_m", 0.05)],
        farthest_m: 0.5,
    };

    /// The card for a link of a mass, kg.
    pub fn card(self, mass_kg: f64) -> EffectCard {
        let kg = Parameter {
            typical: 0.05 * mass_kg,
            ..Parameter::new("mass_kg", "kg", 0.3 * mass_kg, -0.7 * mass_kg, 4.0 * mass_kg.max(1.0))
        };
        let most = self.farthest_m;
        let shift = |&(_, name, start): &(usize, &str, f64)| {
            let m = Parameter { typical: 0.01, ..Parameter::new(name, "m", 0.0, -most, most) };
            with_starts(with_neutral(m, 0.0), [start])
        };
        let inertia = Parameter {
            typical: 0.1,
            prior_std: Some(INERTIA_TOLERANCE),
            ..Parameter::new("inertia_ratio", "", 1.0, 0.2, 5.0)
        };
        let shifts = self.axes.iter().map(shift);
        let parameters = std::iter::once(with_neutral(kg, 0.0))
            .chain(shifts)
            .chain(std::iter::once(with_neutral(inertia, 1.0)))
            .collect();
        EffectCard {
            id: ID.to_owned(),
            summary: "A link heavier or lighter than its URDF says, or with its mass elsewhere.".to_owned(),
            acts_on: "link".to_owned(),
            equation: "m + dm about a centre moved by dx, dz (of a robot dy, too) in the link's frame; I s (m + dm)/m about it".to_owned(),
            validity: "A mass that is spread as the link's own has s = 1; one at a place far from the centre has more, and s \
                       is known to a third before it is fitted."
                .to_owned(),
            reference: "Cables, covers and electronics that a CAD model leaves out; a tool or a payload".to_owned(),
            parameters,
            symbols: "m, I: the link's mass and inertia; dm: mass; dx, dy, dz: shift_x, shift_y, shift_z; s: \
                      inertia_ratio"
                .to_owned(),
            told_apart:
                "The missing torque follows the pose as gravity does, at rest as well. Friction depends on \
                         the direction of motion, an offset on nothing."
                    .to_owned(),
            cure: "Weigh the link with its cables and covers, and correct the URDF.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    /// Puts values, in the card's order, into a link.
    pub fn apply(self, values: &[f64], own: &mut Inertial) {
        let (mass, shifts, inertia) = (values[0], &values[1..=self.axes.len()], values[self.axes.len() + 1]);
        let ratio = (own.mass_kg + mass) / own.mass_kg;
        own.mass_kg += mass;
        own.inertia *= ratio * inertia;
        self.axes.iter().zip(shifts).for_each(|((axis, ..), shift)| own.com[*axis] += shift);
    }
}
