//! Stribeck friction: dry friction that falls from a static to a Coulomb level with speed.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{DryFriction, Plant, Slip};
use sealegs_model::{EffectCard, SimplerAt, SimplerLaw};

/// Dry friction that falls from a static to a Coulomb level as speed rises.
#[derive(Debug)]
pub struct StribeckFriction;

impl Effect for StribeckFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let (force, speed) = (setting.force(), setting.speed());
        let parameters = vec![
            with_starts(
                setting.amount("coulomb", Quantity::Force, 0.03 * force, 2.0 * force),
                [0.15 * force],
            ),
            with_starts(setting.amount("static", Quantity::Force, 0.06 * force, 3.0 * force), [0.3 * force]),
            with_starts(
                setting.magnitude(
                    "stribeck_velocity",
                    Quantity::Speed,
                    0.05 * speed,
                    1e-3 * speed,
                    1.0 * speed,
                ),
                [0.3 * speed, 0.01 * speed],
            ),
        ];
        EffectCard {
            id: "stribeck-friction".to_owned(),
            summary: "Dry friction that falls from a static to a Coulomb level as speed rises.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "(F_c + (F_s - F_c) exp(-(y'/v_s)^2)) sign(y')".to_owned(),
            validity:
                "Opposes the screw's motion; needs reversals or standstill to be told from Coulomb friction."
                    .to_owned(),
            reference: "R. Stribeck 1902; Armstrong-Helouvry et al. 1994, Automatica 30(7)".to_owned(),
            parameters,
            symbols:
                "F_c: coulomb; F_s: static, at least F_c; v_s: stribeck_velocity; y': speed of the screw"
                    .to_owned(),
            told_apart:
                "Coulomb friction stays the same at every speed, this one falls as the speed rises from \
                         standstill. Slow reversals and fast motion in one campaign tell them apart."
                    .to_owned(),
            cure:
                "Another lubricant, dither near standstill, or the curve in the feedforward. Expect stick- \
                   slip under stiff position control."
                    .to_owned(),
            passive: true,
            becomes: Some(SimplerLaw {
                id: "coulomb-friction",
                departure: 1,
                at: SimplerAt::Equal(0),
                beside: None,
            }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.rotor_friction.push(Box::new(Stribeck {
            coulomb: values[0],
            // A friction that rises with speed is another law.
            above: (values[1] - values[0]).max(0.0),
            inverse_velocity: 1.0 / values[2],
        }));
    }
}

#[derive(Debug)]
struct Stribeck {
    coulomb: f64,
    above: f64,
    inverse_velocity: f64,
}

impl DryFriction for Stribeck {
    fn bound(&self, slip: &Slip) -> f64 {
        let ratio = slip.speed * self.inverse_velocity;
        self.coulomb + self.above * (-ratio * ratio).exp()
    }

    fn feels_load(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_static_at_rest_and_coulomb_at_speed() {
        let law = Stribeck { coulomb: 20.0, above: 25.0, inverse_velocity: 250.0 };
        let at =
            |speed: f64| law.bound(&Slip { speed, direction: 1.0_f64.copysign(speed), ..Slip::default() });
        assert_eq!(at(0.0), 45.0);
        assert!((at(0.004) - 20.0 - 25.0 / std::f64::consts::E).abs() < 1e-12);
        assert!((at(-0.1) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn a_static_level_below_the_coulomb_one_is_coulomb_friction() {
        let mut plant = Plant::new(1.0, 1.0, 1.0, 1.0);
        StribeckFriction.install(&[20.0, 5.0, 4e-3], None, &mut plant);
        let law = &plant.laws.rotor_friction[0];
        let at = |speed: f64| law.bound(&Slip { speed, direction: 1.0, ..Slip::default() });
        assert_eq!([at(0.0), at(0.002), at(0.1)], [20.0; 3]);
    }
}
