//! Backlash: play in line with the spring, or in the gears of a drive without one.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{DeadZone, Plant, Transmission};
use sealegs_model::{EffectCard, Parameter};

/// The widest gap where the output moves, in deflections.
const WIDEST_WHERE_OUTPUT_MOVES: f64 = 100.0;

/// Stiffness of gear teeth in contact, in peak forces over the travel: they yield by a four hundredth of it.
const CONTACT: f64 = 400.0;

/// Play in line with the spring, or between the rotor and the load of a drive without one: a dead zone in deflection.
#[derive(Debug)]
pub struct Backlash;

impl Effect for Backlash {
    fn card(&self, setting: &Setting) -> EffectCard {
        let length = setting.length();
        // In a locked actuator a gap beyond the deflection would be free of all force; behind a moving output a light
        // load hardly deflects the spring and still crosses a wide gap.
        let widest = if setting.output_moves { WIDEST_WHERE_OUTPUT_MOVES } else { 2.0 };
        let parameters = if setting.has_load {
            let contact = setting.transmission_stiffness(CONTACT);
            vec![
                with_starts(
                    setting.amount("gap", Quantity::Length, 0.02 * length, 0.5 * length),
                    [0.003, 0.01, 0.05, 0.12].map(|share| share * length),
                ),
                // How stiff gear teeth are hardly shows where they are stiff.
                Parameter { prior_std: Some(contact.value), ..contact },
            ]
        } else {
            vec![with_starts(
                setting.amount("gap", Quantity::Length, 0.02 * length, widest * length),
                [0.1, 0.4, 2.0, 8.0, 30.0].map(|share| share * length),
            )]
        };
        EffectCard {
            id: "backlash".to_owned(),
            summary: if setting.has_load {
                "Play between rotor and load: a dead zone in the gears.".to_owned()
            } else {
                "Play in line with the spring: a dead zone in deflection.".to_owned()
            },
            acts_on: if setting.has_load { "transmission" } else { "spring path" }.to_owned(),
            equation: "force by delta less the play: 0 within +-g/2".to_owned(),
            validity: "Width g of the whole dead zone; play in universal joint, nut or gears; impacts follow from the spring's stiffness, or from that of the gears of a drive without one.".to_owned(),
            reference: "M. Nordin and P.-O. Gutman 2002, Automatica 38(10)".to_owned(),
            parameters,
            symbols: "delta: deflection, of a drive without a spring rotor less load; g: gap".to_owned(),
            told_apart: "It shows only where the force passes through zero: the deflection changes without force, and \
                         the end of the gap is an impact. Presliding friction gives way at every reversal, under any \
                         load.".to_owned(),
            cure: "Preload the joint so that the force keeps its sign, or replace the worn universal joint or \
                   nut.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        match values {
            // Without a gap the teeth are in contact for good, and what yields there is another effect.
            [gap, stiffness] if *gap > 0.0 => {
                plant.transmission = plant.transmission.in_series(Transmission {
                    stiffness: *stiffness,
                    gap: *gap,
                    ..Transmission::RIGID
                });
            }
            [gap] => plant.laws.spring_path.push(Box::new(DeadZone { half_gap: 0.5 * gap })),
            _ => {}
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_spring || setting.has_load
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::SpringPath;

    #[test]
    fn analytic_dead_zone() {
        let law = DeadZone { half_gap: 1e-5 };
        assert_eq!(law.left(0.9e-5), 0.0);
        assert!((law.left(3e-5) - 2e-5).abs() < 1e-18);
        assert!((law.left(-3e-5) + 2e-5).abs() < 1e-18);
    }
}
