//! Output friction: dry friction of a joint's bearings and seals.

use super::{Build, LegEffect, LegSetting, moving_joints};
use sealegs_actuator::effect::with_starts;
use sealegs_model::{EffectCard, Parameter};

/// Dry friction at a joint.
#[derive(Debug)]
pub struct OutputFriction;

impl LegEffect for OutputFriction {
    fn id(&self) -> &'static str {
        "output-friction"
    }

    fn places(&self, leg: &LegSetting) -> Vec<String> {
        moving_joints(leg)
    }

    fn card(&self, _place: &str, _leg: &LegSetting) -> EffectCard {
        let torque = Parameter {
            neutral: Some(0.0),
            typical: 0.5,
            ..Parameter::new("torque_nm", "N m", 1.0, 0.0, 60.0)
        };
        EffectCard {
            id: self.id().to_owned(),
            summary: "Dry friction of a joint's bearings and seals.".to_owned(),
            acts_on: "output joint".to_owned(),
            equation: "T_c sign(q'); at rest it balances the applied torque up to T_c".to_owned(),
            validity: "Opposes the joint's motion, beside the friction that the URDF states.".to_owned(),
            reference: "C. A. Coulomb 1785; dissertation section 3-4-5".to_owned(),
            parameters: vec![with_starts(torque, [5.0])],
            symbols: "T_c: torque; q': joint speed".to_owned(),
            told_apart:
                "It loads every actuator of the joint, in both of its directions. Coulomb friction of one \
                         actuator loads that one, and lies before its spring."
                    .to_owned(),
            cure: "Better bearings or seals, and feedforward by the joint's speed.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], place: &str, leg: &mut Build) {
        if let Some(joint) = leg.robot.joint_index(place) {
            leg.robot.joints[joint].friction += values[0];
        }
    }
}
