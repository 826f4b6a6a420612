//! Joint stop: what a joint runs into is softer, harder, or sooner than the scenario and the URDF say.

use super::{Build, LegEffect, LegSetting, moving_joints};
use crate::dynamics::stop::JointStopChange;
use sealegs_actuator::effect::{magnitude, with_neutral, with_starts};
use sealegs_model::{EffectCard, Parameter};

/// Another stop at a joint: other rubber, a cable, a cover, a shifted end.
#[derive(Debug)]
pub struct JointStop;

impl LegEffect for JointStop {
    fn id(&self) -> &'static str {
        "joint-stop"
    }

    fn places(&self, leg: &LegSetting) -> Vec<String> {
        moving_joints(leg)
    }

    fn card(&self, place: &str, leg: &LegSetting) -> EffectCard {
        let joint = leg.robot.joint_index(place).map(|j| leg.robot.joints[j].limits);
        let (lower, upper) = joint.map_or((-1.0, 1.0), |l| (l.lower.max(-6.3), l.upper.min(6.3)));
        // A joint that comes within the stop's reach is stopped by another stop first of all; one that does not by
        // a stop inside its range.
        let seen = leg.seen.range(&format!("{place}.angle_rad"));
        let spare = seen.map_or(0.1, |r| (upper - r.max).min(r.min - lower));
        let sooner = spare.max(0.0) + seen.map_or(0.05, |r| 0.15 * (r.max - r.min));
        let margin = Parameter {
            typical: 0.01,
            ..Parameter::new("sooner_rad", "rad", 0.0, 0.0, 0.5 * (upper - lower).max(0.02))
        };
        let inside = if spare > 0.0 { vec![sooner, spare + 0.3 * (sooner - spare)] } else { vec![0.02] };
        EffectCard {
            id: self.id().to_owned(),
            summary: "A joint's stop softer, harder or sooner than assumed.".to_owned(),
            acts_on: "output joint".to_owned(),
            equation: "-s k (q - q_l) - s_d d q' past q_l, sooner than the URDF's limit, and it never pulls"
                .to_owned(),
            validity: "Ratios to the scenario's [stops]; both limits of the joint move inwards alike."
                .to_owned(),
            reference: "A spring-damper stop, as the scenario's".to_owned(),
            parameters: vec![
                with_neutral(with_starts(margin, inside), 0.0),
                with_neutral(magnitude("stiffness_ratio", "", 0.5, 1e-2, 100.0), 1.0),
                with_neutral(magnitude("damping_ratio", "", 1.0, 1e-2, 100.0), 1.0),
            ],
            symbols:
                "s: stiffness_ratio; s_d: damping_ratio; k, d: the scenario's stop; q, q_l: joint angle and \
                      limit"
                    .to_owned(),
            told_apart:
                "It acts only near the joint's limit. The contact of the foot acts at touch-down, whatever \
                         the angle."
                    .to_owned(),
            cure:
                "Correct the limit in the URDF or the scenario's [stops], or move the cable or cover that is \
                   in the way."
                    .to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], place: &str, leg: &mut Build) {
        let Some(dof) = leg.robot.joint_index(place).and_then(|j| leg.robot.joints[j].dof) else { return };
        leg.stops.push(JointStopChange {
            dof,
            sooner_rad: values[0],
            stiffness_ratio: values[1],
            damping_ratio: values[2],
        });
    }
}
