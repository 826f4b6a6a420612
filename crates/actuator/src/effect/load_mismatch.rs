//! Load mismatch: a pendulum's load that is heavier, lighter or farther out than the campaign says.

use super::Effect;
use super::setting::{Setting, ratio_to_stated};
use crate::plant::{Link, Plant};
use sealegs_model::EffectCard;

/// A pendulum's load that is not the stated one.
#[derive(Debug)]
pub struct LoadMismatch;

impl Effect for LoadMismatch {
    fn card(&self, _setting: &Setting) -> EffectCard {
        let ratio = |name: &str| ratio_to_stated(name, 1.1, 0.8);
        EffectCard {
            id: "load-mismatch".to_owned(),
            summary: "A pendulum's load that is heavier, lighter or farther out than stated.".to_owned(),
            acts_on: "output link".to_owned(),
            equation: "g_r m g l sin(theta) in the place of m g l sin(theta), i_r m l^2 in that of m l^2".to_owned(),
            validity: "Another mass at the same place changes both ratios alike; another length changes the inertia by \
                       its square. Needs a pendulum."
                .to_owned(),
            reference: "C. G. Atkeson, C. H. An, J. M. Hollerbach 1986, Int. J. Robotics Research 5(3): loads \
                        identified from joint torques"
                .to_owned(),
            parameters: vec![ratio("gravity_ratio"), ratio("inertia_ratio")],
            symbols: "g_r: gravity_ratio; i_r: inertia_ratio; m, l: stated mass and length; theta: joint angle".to_owned(),
            told_apart: "The missing torque follows the sine of the angle, at rest as well, and the joint's acceleration. \
                         A cable's pull follows the angle itself, and an offset is the same everywhere."
                .to_owned(),
            cure: "Weigh the load with its rod and clamps, measure where its centre is, and correct the campaign."
                .to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        for link in plant.rigid.iter_mut().chain(std::iter::once(&mut plant.link_2)) {
            if let Link::Pendulum { inertia_kg_m2, gravity_torque_nm, .. } = link {
                *gravity_torque_nm *= values[0];
                *inertia_kg_m2 *= values[1];
            }
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.output_arm_m.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::PendulumRig;

    #[test]
    fn analytic_a_longer_rod_acts_by_its_length_and_its_square() {
        let rig = |length_m: f64| PendulumRig { length_m, ..PendulumRig::default() }.link();
        let mut plant = Plant::new(1.0, 0.1, 0.0, 1e3);
        plant.link_2 = rig(0.3);
        LoadMismatch.install(&[1.1, 1.21], None, &mut plant);
        let (
            Link::Pendulum { inertia_kg_m2, gravity_torque_nm, .. },
            Link::Pendulum { inertia_kg_m2: i, gravity_torque_nm: g, .. },
        ) = (plant.link_2, rig(0.33))
        else {
            panic!("pendulums")
        };
        assert!((inertia_kg_m2 - i).abs() < 1e-12 && (gravity_torque_nm - g).abs() < 1e-12);
        assert_eq!(plant.rigid, None);
    }
}
