//! Presliding friction: an elastic contact that slips at the Coulomb force.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{ElastoSlip, Onset, Plant};
use sealegs_model::{EffectCard, SimplerAt, SimplerLaw};

/// Dry friction that yields elastically before it slips.
#[derive(Debug)]
pub struct PreslidingFriction;

impl Effect for PreslidingFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let force = setting.force();
        let parameters = vec![
            with_starts(setting.amount("force", Quantity::Force, 0.05 * force, 2.0 * force), [0.2 * force]),
            with_starts(
                setting.magnitude(
                    "stiffness",
                    Quantity::Stiffness,
                    3.0 * setting.stiffness,
                    1e-2 * setting.stiffness,
                    1e3 * setting.stiffness,
                ),
                [0.3 * setting.stiffness, 30.0 * setting.stiffness],
            ),
        ];
        EffectCard {
            id: "presliding-friction".to_owned(),
            summary: "Dry friction that yields elastically before it slips.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "f' = sigma y', held within +-F_c".to_owned(),
            validity: "Opposes the screw's motion; stores energy while it sticks.".to_owned(),
            reference: "P. R. Dahl 1968; Dupont et al. 2002, IEEE Trans. Automatic Control 47(5)".to_owned(),
            parameters,
            symbols: "f: friction force; sigma: stiffness; F_c: force; y': speed of the screw".to_owned(),
            told_apart:
                "Oscillations too small to slip: here the screw still moves, as on a spring; under Coulomb \
                         friction it stands still. In wide motion the two are alike."
                    .to_owned(),
            cure:
                "Feed its elastic state forward. Avoid integral action while it sticks: the loop would hunt."
                    .to_owned(),
            passive: true,
            becomes: Some(SimplerLaw {
                id: "coulomb-friction",
                departure: 1,
                at: SimplerAt::Infinity,
                beside: None,
            }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        if values[0] > 0.0 {
            plant.laws.rotor_presliding.push(ElastoSlip {
                bound: values[0],
                stiffness: values[1],
                onset: Onset::Sudden,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_holds_within_its_bound() {
        let element = ElastoSlip { bound: 10.0, stiffness: 1e6, onset: Onset::Sudden };
        assert!((element.advance(0.0, 4e-6) - 4.0).abs() < 1e-12);
        assert_eq!(element.advance(9.0, 4e-6), 10.0);
        assert_eq!(element.advance(10.0, -1.0), -10.0);
    }
}
