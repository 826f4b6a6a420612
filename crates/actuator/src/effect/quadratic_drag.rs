//! Quadratic drag: a resistance proportional to the squared speed of the screw.

use super::Effect;
use super::setting::{Quantity, Setting};
use crate::plant::{Plant, RotorForce};
use sealegs_model::EffectCard;

/// Drag that grows with the square of the speed.
#[derive(Debug)]
pub struct QuadraticDrag;

impl Effect for QuadraticDrag {
    fn card(&self, setting: &Setting) -> EffectCard {
        let guess = 0.05 * setting.force() / setting.speed().powi(2);
        let parameters = vec![setting.amount("coefficient", Quantity::QuadraticDrag, guess, 100.0 * guess)];
        EffectCard {
            id: "quadratic-drag".to_owned(),
            summary: "Drag that grows with the square of the speed.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "c y' abs(y')".to_owned(),
            validity: "Opposes the screw's motion; windage and churning of grease.".to_owned(),
            reference: "Standard drag law".to_owned(),
            parameters,
            symbols: "c: coefficient; y': speed of the screw".to_owned(),
            told_apart:
                "Viscous damping grows with the speed, this one with its square, dry friction with neither. \
                         Runs at several speeds up to the greatest tell them apart."
                    .to_owned(),
            cure: "Feed it forward at high speed. Less grease, and openings against windage.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.rotor_forces.push(Box::new(Drag { coefficient: values[0] }));
    }
}

#[derive(Debug)]
struct Drag {
    coefficient: f64,
}

impl RotorForce for Drag {
    fn force(&self, _y: f64, y_dot: f64, _load: f64, _t: f64) -> f64 {
        -self.coefficient * y_dot * y_dot.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_opposes_motion() {
        let law = Drag { coefficient: 100.0 };
        assert_eq!(law.force(0.0, 0.1, 0.0, 0.0), -1.0);
        assert_eq!(law.force(0.0, -0.2, 0.0, 0.0), 4.0);
    }
}
