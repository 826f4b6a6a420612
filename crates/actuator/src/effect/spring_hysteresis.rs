//! Spring hysteresis: an elastic element beside the spring that slips (clamp slip).

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{ElastoSlip, Onset, Plant};
use sealegs_model::EffectCard;

/// Slip in the spring's clamp: an elastic element beside it that slips.
#[derive(Debug)]
pub struct SpringHysteresis;

impl Effect for SpringHysteresis {
    fn card(&self, setting: &Setting) -> EffectCard {
        let k = setting.stiffness;
        let force = setting.force();
        let parameters = vec![
            with_starts(
                setting.magnitude("stiffness", Quantity::Stiffness, 0.2 * k, 1e-3 * k, 1e2 * k),
                [0.05 * k, 1.0 * k],
            ),
            with_starts(
                setting.amount("slip_force", Quantity::Force, 0.04 * force, 2.0 * force),
                [0.15 * force, 0.01 * force],
            ),
        ];
        EffectCard {
            id: "spring-hysteresis".to_owned(),
            summary: "Slip in the spring's clamp: an elastic element beside it that slips.".to_owned(),
            acts_on: "spring".to_owned(),
            equation: "k delta + f, f' = k_h delta', held within +-F_h".to_owned(),
            validity:
                "Force positive in compression; a loop in force over deflection that does not depend on rate."
                    .to_owned(),
            reference: "W. D. Iwan 1966, J. Applied Mechanics 33; dissertation section 2-5-1 (clamp)"
                .to_owned(),
            parameters,
            symbols: "k: the spring's stiffness; k_h: stiffness; F_h: slip_force; delta: deflection".to_owned(),
            told_apart: "Slow cycles leave an open loop of force over deflection. The loop of spring-damping closes \
                         when slow; friction of the rotor lies between motor and spring, not between force and \
                         deflection.".to_owned(),
            cure: "Tighten or bond the clamp. Take the force from a load cell and not from the deflection.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        if values[1] > 0.0 {
            plant.laws.spring_slip =
                Some(ElastoSlip { stiffness: values[0], bound: values[1], onset: Onset::Sudden });
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_spring
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_loop_width_is_twice_the_slip_force() {
        let element = ElastoSlip { stiffness: 1e5, bound: 20.0, onset: Onset::Sudden };
        let up = element.advance(0.0, 1e-3);
        let down = element.advance(up, -2e-3);
        assert_eq!(up - down, 40.0);
    }
}
