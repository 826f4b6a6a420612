//! Direction-dependent friction: dry friction that is greater one way than the other.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{DryFriction, Plant, Slip};
use sealegs_model::{EffectCard, Parameter, SimplerAt, SimplerLaw};

/// Dry friction that differs between lengthening and shortening.
#[derive(Debug)]
pub struct DirectionDependentFriction;

impl Effect for DirectionDependentFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let force = setting.force();
        let parameters = vec![
            with_starts(setting.amount("force", Quantity::Force, 0.03 * force, 2.0 * force), [0.15 * force]),
            with_starts(
                Parameter { typical: 0.2, ..Parameter::new("asymmetry", "", 0.2, -1.0, 1.0) },
                [-0.4, 0.6],
            ),
        ];
        EffectCard {
            id: "direction-dependent-friction".to_owned(),
            summary: "Dry friction that differs between lengthening and shortening.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "F_c (1 + a) while lengthening, F_c (1 - a) while shortening".to_owned(),
            validity: "Opposes the screw's motion; a lies between -1 and 1.".to_owned(),
            reference: "Armstrong-Helouvry et al. 1994, Automatica 30(7), section 2".to_owned(),
            parameters,
            symbols: "F_c: force; a: asymmetry".to_owned(),
            told_apart: "While it moves it equals Coulomb friction with a constant force beside it. Standstill tells: \
                         friction only balances what is applied, output-offset goes on pushing. The asymmetry of \
                         directional-efficiency changes its side with the load.".to_owned(),
            cure: "Look for misalignment, one-sided preload or a lip seal. Feed both levels forward.".to_owned(),
            passive: true,
            becomes: Some(SimplerLaw { id: "coulomb-friction", departure: 1, at: SimplerAt::Zero, beside: Some("output-offset") }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant
            .laws
            .rotor_friction
            .push(Box::new(DirectionDependent { force: values[0], asymmetry: values[1] }));
    }
}

#[derive(Debug)]
struct DirectionDependent {
    force: f64,
    asymmetry: f64,
}

impl DryFriction for DirectionDependent {
    fn bound(&self, slip: &Slip) -> f64 {
        self.force * (1.0 + self.asymmetry * slip.direction)
    }

    fn feels_speed(&self) -> bool {
        false
    }

    fn feels_load(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_plus_while_lengthening() {
        let law = DirectionDependent { force: 10.0, asymmetry: 0.3 };
        assert_eq!(law.bound(&Slip { speed: 0.1, direction: 1.0, ..Slip::default() }), 13.0);
        assert_eq!(law.bound(&Slip { direction: -1.0, ..Slip::default() }), 7.0);
    }
}
