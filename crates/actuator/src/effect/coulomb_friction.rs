//! Coulomb friction: dry friction of the rotor that does not depend on speed.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{DryFriction, Plant, Slip};
use sealegs_model::EffectCard;

/// Dry friction of motor and transmission, independent of speed.
#[derive(Debug)]
pub struct CoulombFriction;

impl Effect for CoulombFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let force = setting.force();
        let parameters = vec![with_starts(
            setting.amount("force", Quantity::Force, 0.03 * force, 2.0 * force),
            [0.15 * force, 0.4 * force],
        )];
        EffectCard {
            id: "coulomb-friction".to_owned(),
            summary: "Dry friction of motor and transmission, independent of speed.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "F_c sign(y'); at rest it balances the applied force up to F_c".to_owned(),
            validity: "Opposes the screw's motion; holds without creep.".to_owned(),
            reference: "C. A. Coulomb 1785; Armstrong-Helouvry et al. 1994, Automatica 30(7)".to_owned(),
            parameters,
            symbols: "F_c: force; y': speed of the screw".to_owned(),
            told_apart: "Load-dependent friction grows with the load, this one does not: record runs under different \
                         loads. Stribeck friction rises towards standstill: record slow reversals. Viscous damping \
                         vanishes with the speed, this one does not.".to_owned(),
            cure: "Feed the friction force forward by the sign of the wanted speed, or close a force loop \
                   around the spring, which measures behind the friction. Check seals, preload and lubrication.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.rotor_friction.push(Box::new(Coulomb { force: values[0] }));
    }
}

#[derive(Debug)]
struct Coulomb {
    force: f64,
}

impl DryFriction for Coulomb {
    fn bound(&self, _slip: &Slip) -> f64 {
        self.force
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
    fn the_bound_is_the_same_at_any_speed() {
        let law = Coulomb { force: 30.0 };
        assert_eq!(law.bound(&Slip { direction: 1.0, load: 500.0, ..Slip::default() }), 30.0);
        assert_eq!(law.bound(&Slip { speed: -0.2, direction: -1.0, ..Slip::default() }), 30.0);
    }
}
