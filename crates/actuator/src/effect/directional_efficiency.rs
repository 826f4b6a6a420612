//! Directional efficiency: friction of a gear or screw by its load, less or more while it is driven back.

use super::Effect;
use super::setting::{Setting, with_starts};
use crate::plant::{DryFriction, Plant, Slip};
use sealegs_model::{EffectCard, Parameter, SimplerAt, SimplerLaw};

/// Friction proportional to the load, with one coefficient while driving it and another while driven by it.
#[derive(Debug)]
pub struct DirectionalEfficiency;

impl Effect for DirectionalEfficiency {
    fn card(&self, _setting: &Setting) -> EffectCard {
        let ratio = |name: &str| Parameter {
            neutral: Some(0.0),
            typical: 0.03,
            ..Parameter::new(name, "", 0.1, 0.0, 0.95)
        };
        let parameters = vec![
            with_starts(ratio("driving_coefficient"), [0.03, 0.4]),
            with_starts(ratio("driven_coefficient"), [0.03, 0.4]),
        ];
        EffectCard {
            id: "directional-efficiency".to_owned(),
            summary: "Friction by the load of a gear or screw that differs between driving and being driven.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "mu_f abs(F) sign(y') while the load opposes the motion, mu_b abs(F) sign(y') while it drives it"
                .to_owned(),
            validity: "F is the force in the screw, or what a drive without a spring passes to its load. The efficiencies \
                       are 1/(1 + mu_f) and 1 - mu_b."
                .to_owned(),
            reference: "A. Wang, S. Kim 2015, Directional efficiency in geared transmissions, IEEE ICRA".to_owned(),
            parameters,
            symbols: "mu_f: driving_coefficient; mu_b: driven_coefficient; F: force in the screw; y': speed of the \
                      screw".to_owned(),
            told_apart: "Load-dependent friction has one coefficient for both cases. Motion with the load and against \
                         it, in both directions, tells them apart.".to_owned(),
            cure: "Use both coefficients in the feedforward. Where impacts must be passed on to the motor, \
                   choose a greater lead or a smaller gear ratio: a screw that is hard to drive back protects \
                   nothing.".to_owned(),
            passive: true,
            becomes: Some(SimplerLaw { id: "load-dependent-friction", departure: 1, at: SimplerAt::Equal(0), beside: None }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.rotor_friction.push(Box::new(ByPower { driving: values[0], driven: values[1] }));
    }
}

#[derive(Debug)]
struct ByPower {
    driving: f64,
    driven: f64,
}

impl DryFriction for ByPower {
    fn bound(&self, slip: &Slip) -> f64 {
        // In compression the load opposes a screw that lengthens.
        let coefficient = if slip.load * slip.direction > 0.0 { self.driving } else { self.driven };
        coefficient * slip.load.abs()
    }

    fn feels_speed(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_lifting_and_lowering_a_load() {
        let law = ByPower { driving: 0.2, driven: 0.05 };
        let at = |direction: f64, load: f64| {
            law.bound(&Slip { speed: 0.1 * direction, direction, load, ..Slip::default() })
        };
        assert_eq!([at(1.0, 100.0), at(-1.0, 100.0), at(-1.0, -100.0)], [20.0, 5.0, 20.0]);
    }
}
