//! Hardening spring: a cubic term beside the linear stiffness.

use super::Effect;
use super::setting::{Quantity, Setting};
use crate::plant::{Plant, SpringForce};
use sealegs_model::EffectCard;

/// A spring that stiffens (or softens) with deflection.
#[derive(Debug)]
pub struct HardeningSpring;

impl Effect for HardeningSpring {
    fn card(&self, setting: &Setting) -> EffectCard {
        let guess = 0.05 * setting.stiffness / setting.length().powi(2);
        let mut cubic = setting.amount("cubic", Quantity::CubicStiffness, guess, 40.0 * guess);
        cubic.min = -10.0 * guess;
        let parameters = vec![cubic];
        EffectCard {
            id: "hardening-spring".to_owned(),
            summary: "A spring that stiffens (or softens) with deflection.".to_owned(),
            acts_on: "spring".to_owned(),
            equation: "k delta + k_3 delta^3".to_owned(),
            validity: "Positive k_3 hardens; symmetric in compression and tension.".to_owned(),
            reference: "G. Duffing 1918; dissertation sections 4-6-4 and 5-2".to_owned(),
            parameters,
            symbols: "k: the spring's stiffness; k_3: cubic; delta: deflection".to_owned(),
            told_apart: "A wrong stiffness is wrong by the same ratio at every deflection, this one is right at small \
                         deflections. Backlash acts around zero only, hysteresis opens a loop. Slow loads up to the \
                         greatest force tell them apart.".to_owned(),
            cure: "Use the measured curve of force over deflection in the force estimate, or keep within the \
                   linear range.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.spring_forces.push(Box::new(Cubic { cubic: values[0] }));
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_spring
    }
}

#[derive(Debug)]
struct Cubic {
    cubic: f64,
}

impl SpringForce for Cubic {
    fn force(&self, delta: f64, _delta_dot: f64, _t: f64) -> f64 {
        self.cubic * delta * delta * delta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_is_odd() {
        let law = Cubic { cubic: 2e9 };
        assert!((law.force(1e-3, 0.0, 0.0) - 2.0).abs() < 1e-12);
        assert!((law.force(-1e-3, 0.0, 0.0) + 2.0).abs() < 1e-12);
    }
}
