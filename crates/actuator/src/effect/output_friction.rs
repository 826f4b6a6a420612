//! Output friction: dry friction at the output joint.

use super::Effect;
use super::setting::{Setting, with_starts};
use crate::plant::{Link, Plant};
use sealegs_model::{EffectCard, Parameter};

/// Dry friction at the joint of the lever or the leg.
#[derive(Debug)]
pub struct OutputFriction;

impl Effect for OutputFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let arm = setting.output_arm_m.unwrap_or(1.0);
        let torque = setting.force() * arm;
        let parameters = vec![with_starts(
            Parameter {
                neutral: Some(0.0),
                typical: 0.02 * torque,
                ..Parameter::new("torque_nm", "N m", 0.02 * torque, 0.0, 2.0 * torque)
            },
            [0.005 * torque, 0.1 * torque],
        )];
        EffectCard {
            id: "output-friction".to_owned(),
            summary: "Dry friction at the joint of the lever or the leg.".to_owned(),
            acts_on: "output joint".to_owned(),
            equation: "T_c sign(joint speed); at rest it balances the applied torque up to T_c".to_owned(),
            validity: "Opposes the joint's motion; holds without creep. Needs an output that moves; in a drive without a \
                       spring it is the rotor's own friction."
                .to_owned(),
            reference: "C. A. Coulomb 1785".to_owned(),
            parameters,
            symbols: "T_c: torque".to_owned(),
            told_apart: "It lies behind the spring, so that the spring's force balances it. Coulomb friction of the \
                         rotor lies before the spring: compare the measured forces with the joint's motion.".to_owned(),
            cure: "Better bearings or seals, and feedforward by the joint's speed.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        let arm = if let Link::Pendulum { arm_m, .. } = plant.link_2 { arm_m } else { 1.0 };
        plant.output_friction += values[0] / arm;
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.output_moves && setting.has_spring
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_is_referred_to_the_axis_by_the_arm() {
        let mut plant = Plant::new(1.0, 0.1, 0.0, 1e3);
        plant.link_2 = Link::Pendulum { inertia_kg_m2: 1.0, gravity_torque_nm: 1.0, arm_m: 0.1 };
        OutputFriction.install(&[0.5], None, &mut plant);
        assert_eq!(plant.output_friction, 5.0);
    }
}
