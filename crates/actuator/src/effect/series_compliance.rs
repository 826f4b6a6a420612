//! Series compliance: a spring between screw and link 2 that carries the unsprung mass, or in the gears of a drive without a
//! spring.

use super::Effect;
use super::setting::{Quantity, Setting, magnitude, with_neutral, with_starts};
use crate::plant::{Plant, SeriesCompliance, TRANSMISSION_DAMPING_RATIO, Transmission};
use sealegs_model::{EffectCard, Parameter};

/// Compliance of universal joints and clamp between screw and link 2; of the transmission of a drive without a spring.
#[derive(Debug)]
pub struct SeriesComplianceEffect;

impl Effect for SeriesComplianceEffect {
    fn card(&self, setting: &Setting) -> EffectCard {
        if setting.has_load {
            return of_transmission(setting);
        }
        let k = setting.stiffness;
        let stiffness = with_neutral(
            with_starts(
                setting.magnitude("stiffness", Quantity::Stiffness, 6.0 * k, 0.2 * k, 1e4 * k),
                [0.5 * k, 2.0 * k, 20.0 * k, 60.0 * k],
            ),
            f64::INFINITY,
        );
        // The mass is the file's, an estimate. Free beside the stiffness it leads a search astray: where the end rings
        // undamped the error has many minima along both. Held for good it would make the stiffness look well known
        // where the data tell only its ratio to the mass.
        let stated = setting.unsprung_mass;
        let mass = if stated > 0.0 { stated } else { UNSPRUNG_SHARE * setting.total_mass };
        let mass = Parameter {
            fixed: true,
            freed_at_last: true,
            prior_std: Some(MASS_TOLERANCE * mass),
            ..setting.magnitude("unsprung", Quantity::Inertia, mass, 0.1 * mass, 10.0 * mass)
        };
        EffectCard {
            id: "series-compliance".to_owned(),
            summary: "Compliance of universal joints and clamp between screw and link 2; of a drive without a spring, of its \
                      gears or belt."
                .to_owned(),
            acts_on: "screw side".to_owned(),
            equation: "F_2 = k_j (x_s - x_2), x_s the screw's end, which carries the unsprung mass".to_owned(),
            validity: "Indistinguishable from a softer spring where only forces and the rotor are measured on a locked bench.".to_owned(),
            reference: "Dissertation sections 2-5-1 and 5-2; 2771 kN/m follows from equations 2-9 and 2-10".to_owned(),
            parameters: vec![stiffness, mass],
            symbols: "k_j: stiffness; x_s, x_2: positions of the screw's end and of link 2".to_owned(),
            told_apart: "A softer spring explains forces and rotor on a locked bench as well. Measure the deflection \
                         of the spring or the output's motion, or let the output move: then they differ.".to_owned(),
            cure: "Stiffen universal joints and clamps, or use the stiffness of both in series in the \
                   controller.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        match values {
            [stiffness, second] if stiffness.is_finite() && plant.rigid.is_some() => {
                let yields = Transmission { stiffness: *stiffness, damping_ratio: *second, gap: 0.0 };
                plant.transmission = plant.transmission.in_series(yields);
            }
            [stiffness, second] if stiffness.is_finite() => {
                plant.series = Some(SeriesCompliance { stiffness: *stiffness, mass: *second });
            }
            _ => {}
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_spring || setting.has_load
    }
}

/// The card of a drive without a spring, whose gears, belt or coupling yield.
fn of_transmission(setting: &Setting) -> EffectCard {
    let k = setting.stiffness;
    let stiffness = with_starts(
        setting.transmission_stiffness(100.0),
        [10.0, 30.0, 300.0, 1000.0].map(|ratio| ratio * k),
    );
    let damping_ratio = magnitude("damping_ratio", "", TRANSMISSION_DAMPING_RATIO, 0.002, 1.0);
    EffectCard {
        id: "series-compliance".to_owned(),
        summary: "Compliance of gears, belt or coupling between rotor and load.".to_owned(),
        acts_on: "transmission".to_owned(),
        equation: "s = k_j (y - x) + 2 zeta sqrt(k_j m) (y' - x'), m = m_J m_2 / (m_J + m_2)".to_owned(),
        validity: "Where only one side is measured a stiff transmission shows by its resonance alone.".to_owned(),
        reference: "M. W. Spong 1987, J. Dynamic Systems, Measurement, and Control 109(4)".to_owned(),
        parameters: vec![stiffness, damping_ratio],
        symbols: "k_j: stiffness; zeta: damping ratio; s: torque or force in the transmission; y, m_J: position and reflected \
                  inertia of the rotor; x, m_2: of the load"
            .to_owned(),
        told_apart: "The load swings against the rotor after every hit or step. Play is free in the middle; a delay \
                     does not ring."
            .to_owned(),
        cure: "Stiffen belt, coupling or gears, or keep the controller below the resonance.".to_owned(),
        passive: true,
        becomes: None,
    }
}

/// The unsprung mass as a share of the moving mass where the file has none: nut and tube of the THOR actuator, 0.15 kg of
/// 294.9 kg (the dissertation's own estimate, section 4-5-1).
const UNSPRUNG_SHARE: f64 = 0.15 / 294.9;

/// One standard deviation of the unsprung mass, as a ratio: an estimate from the difference of two catalogue masses.
const MASS_TOLERANCE: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_is_no_compliance() {
        let mut plant = Plant::new(294.0, 0.6, 0.0, 6e5);
        SeriesComplianceEffect.install(&[f64::INFINITY, 0.1], None, &mut plant);
        assert_eq!(plant.series, None);
    }
}
