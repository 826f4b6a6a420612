//! Joint stop: something that a joint runs into before the limit of its URDF.

use super::{Build, LegEffect, LegSetting, moving_joints};
use crate::dynamics::stop::ExtraStop;
use sealegs_actuator::effect::with_starts;
use sealegs_model::{EffectCard, Parameter};

/// A stop inside a joint's range: a cable, a cover, a shifted end stop.
#[derive(Debug)]
pub struct JointStop;

/// Shares of the range seen beyond which a stop is first looked for.
const BEYOND: [f64; 2] = [0.75, 0.9];

impl LegEffect for JointStop {
    fn id(&self) -> &'static str {
        "joint-stop"
    }

    fn places(&self, leg: &LegSetting) -> Vec<String> {
        moving_joints(leg)
    }

    fn card(&self, place: &str, leg: &LegSetting) -> EffectCard {
        let start = leg.scenario.start.posture_rad.get(place).copied().unwrap_or(0.0);
        let limits = leg.robot.joint_index(place).map(|j| leg.robot.joints[j].limits.clone());
        let (lower, upper) = limits.map_or((-3.0, 3.0), |l| (l.lower.max(-6.3), l.upper.min(6.3)));
        let seen = leg.seen.range(&format!("{place}.angle_rad"));
        let (least, most) = seen.map_or((start - 0.1, start + 0.1), |r| (r.min, r.max));
        let ends = if most - start > start - least { [most, least] } else { [least, most] };
        let mut places: Vec<f64> = ends.iter().map(|end| start + BEYOND[0] * (end - start)).collect();
        places.push(start + BEYOND[1] * (ends[0] - start));
        places.iter_mut().for_each(|p| *p = p.clamp(lower, upper));
        let angle =
            Parameter { typical: 0.01, ..Parameter::new("angle_rad", "rad", places[0], lower, upper) };
        let law = leg.scenario.stops;
        let stiffness = Parameter {
            neutral: Some(0.0),
            typical: 0.1 * law.stiffness_nm_rad,
            ..Parameter::new("stiffness_nm_rad", "N m/rad", 0.3 * law.stiffness_nm_rad, 0.0, 1e5)
        };
        let relaxation = Parameter::new("relaxation_s", "s", 5e-3, 0.0, 0.1);
        EffectCard {
            id: self.id().to_owned(),
            summary: "A stop that a joint runs into before its URDF's limit.".to_owned(),
            acts_on: "output joint".to_owned(),
            equation: "-k ((q - q_s) + tau q') past q_s, and it never pulls".to_owned(),
            validity: "Past q_s is away from the posture at the start; tau is damping over stiffness."
                .to_owned(),
            reference: "A spring-damper stop, as at the URDF's limits".to_owned(),
            parameters: vec![with_starts(angle, places[1..].iter().copied()), stiffness, relaxation],
            passive: true,
        }
    }

    fn install(&self, values: &[f64], place: &str, leg: &mut Build) {
        let start = leg.scenario.start.posture_rad.get(place).copied().unwrap_or(0.0);
        let Some(dof) = leg.robot.joint_index(place).and_then(|j| leg.robot.joints[j].dof) else { return };
        if values[1] > 0.0 {
            leg.stops.push(ExtraStop {
                dof,
                angle_rad: values[0],
                upward: values[0] >= start,
                stiffness_nm_rad: values[1],
                damping_nm_s_rad: values[1] * values[2],
            });
        }
    }
}
