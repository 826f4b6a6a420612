//! Wobbling mass: a mass on the output link that a spring and a damper hold.

use super::Effect;
use super::setting::{Setting, magnitude, with_starts};
use crate::plant::{Plant, WobblingMass};
use sealegs_model::{EffectCard, Parameter};

/// A mass on the output link that is held softly.
#[derive(Debug)]
pub struct WobblingMassEffect;

impl Effect for WobblingMassEffect {
    fn card(&self, setting: &Setting) -> EffectCard {
        let mut mass = Parameter::new("mass_kg", "kg", 0.3, 0.0, 20.0);
        mass.neutral = Some(0.0);
        mass.typical = 0.1;
        let natural = setting.natural_hz();
        let parameters = vec![
            mass,
            // Mass and radius act together as m rho^2: the radius is where a lever's tip is, unless told.
            Parameter { fixed: true, ..magnitude("radius_m", "m", 0.3, 0.02, 2.0) },
            with_starts(
                magnitude("frequency_hz", "Hz", natural, 0.05 * natural, 40.0 * natural),
                (0..12).map(|i| 0.3 * natural * 1.35_f64.powi(i)),
            ),
            with_starts(magnitude("damping_ratio", "", 0.1, 1e-3, 2.0), [0.03]),
        ];
        EffectCard {
            id: "wobbling-mass".to_owned(),
            summary: "A mass on the output link that is held softly.".to_owned(),
            acts_on: "output link".to_owned(),
            equation: "m at radius rho: m w'' + 2 zeta w0 m w' + m w0^2 w = -m rho theta'' - m g sin(theta)"
                .to_owned(),
            validity: "An additional mass with its own weight; displacement tangential. Needs a pendulum."
                .to_owned(),
            reference: "Dissertation section 5-2 (wobbling masses)".to_owned(),
            parameters,
            symbols: "m: mass; rho: radius; w: displacement; w0: angular frequency; zeta: damping_ratio; theta: \
                      joint angle".to_owned(),
            told_apart: "A wrong inertia acts alike at all frequencies, this one rings near its own. A structural \
                         mode shows in the forces only, this one also in the joint's motion. A sweep tells them \
                         apart.".to_owned(),
            cure: "Fasten what is loose (battery, cover, cable), or give the model a second body.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        if values[0] > 0.0 {
            plant.wobbling = Some(WobblingMass {
                mass: values[0],
                radius: values[1],
                angular_frequency: std::f64::consts::TAU * values[2],
                damping_ratio: values[3],
            });
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.output_arm_m.is_some() && setting.has_spring
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_is_no_mass() {
        let mut plant = Plant::new(1.0, 0.1, 0.0, 1e3);
        WobblingMassEffect.install(&[0.0, 0.3, 2.0, 0.1], None, &mut plant);
        assert_eq!(plant.wobbling, None);
    }
}
