//! Spring damping: viscous damping parallel to the spring.

use super::Effect;
use super::setting::{Quantity, Setting};
use crate::plant::Plant;
use sealegs_model::EffectCard;

/// Viscous damping parallel to the spring.
#[derive(Debug)]
pub struct SpringDamping;

impl Effect for SpringDamping {
    fn card(&self, setting: &Setting) -> EffectCard {
        let critical = 2.0 * (setting.stiffness * setting.total_mass).sqrt();
        let parameters = vec![setting.amount("damping", Quantity::Damping, 0.02 * critical, 2.0 * critical)];
        EffectCard {
            id: "spring-damping".to_owned(),
            summary: "Viscous damping parallel to the spring.".to_owned(),
            acts_on: "spring".to_owned(),
            equation: "k delta + c delta'".to_owned(),
            validity: "Force positive in compression; material and joint damping, taken as zero in the dissertation.".to_owned(),
            reference: "Dissertation sections 3-3-1 and 5-2".to_owned(),
            parameters,
            symbols: "k: the spring's stiffness; c: damping; delta, delta': deflection and its rate".to_owned(),
            told_apart: "The loop of force over deflection widens with the rate; that of spring-hysteresis does not. \
                         Damping of the rotor acts before the spring and leaves the spring's own force as it is.".to_owned(),
            cure: "Measure the force by a load cell, or put the damping into the force estimate. It helps \
                   against ringing and may stay.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.spring_damping += values[0];
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_spring
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_adds_to_the_plant() {
        let mut plant = Plant::new(1.0, 0.1, 0.0, 1e3);
        SpringDamping.install(&[7.0], None, &mut plant);
        assert_eq!(plant.spring_force(0.0, 2.0, 0.0), 14.0);
    }
}
