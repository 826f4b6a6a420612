//! Load-dependent friction: dry friction proportional to the force in the screw.

use super::Effect;
use super::setting::{Setting, with_starts};
use crate::plant::{DryFriction, Plant, Slip};
use sealegs_model::{EffectCard, Parameter};

/// Friction of the screw that grows with the force it carries.
#[derive(Debug)]
pub struct LoadDependentFriction;

impl Effect for LoadDependentFriction {
    fn card(&self, _setting: &Setting) -> EffectCard {
        let parameters = vec![with_starts(
            Parameter {
                neutral: Some(0.0),
                typical: 0.03,
                ..Parameter::new("coefficient", "", 0.03, 0.0, 0.9)
            },
            [0.15, 0.4],
        )];
        EffectCard {
            id: "load-dependent-friction".to_owned(),
            summary: "Friction of the screw that grows with the force it carries.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "mu abs(F_bs) sign(y')".to_owned(),
            validity: "Opposes the screw's motion; the loss of efficiency of a ball screw or a gear.".to_owned(),
            reference: "Ball-screw efficiency, e.g. Olaru et al. 2005; dissertation section 3-3-2 (not modelled there)".to_owned(),
            parameters,
            symbols: "mu: coefficient; F_bs: force in the screw; y': speed of the screw".to_owned(),
            told_apart: "Coulomb friction does not change with the load: record equal motion under different loads. \
                         Directional efficiency has one coefficient while it drives the load and another while the \
                         load drives it.".to_owned(),
            cure: "Divide the wanted force by the efficiency in the feedforward. Check preload, alignment and \
                   lubrication of the nut.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.rotor_friction.push(Box::new(LoadDependent { coefficient: values[0] }));
    }
}

#[derive(Debug)]
struct LoadDependent {
    coefficient: f64,
}

impl DryFriction for LoadDependent {
    fn bound(&self, slip: &Slip) -> f64 {
        self.coefficient * slip.load.abs()
    }

    fn feels_speed(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_grows_with_the_load_of_either_sign() {
        let law = LoadDependent { coefficient: 0.1 };
        assert_eq!(law.bound(&Slip { speed: 0.1, direction: 1.0, load: -200.0, ..Slip::default() }), 20.0);
        assert_eq!(law.bound(&Slip { direction: 1.0, ..Slip::default() }), 0.0);
    }
}
