//! Dahl friction: dry friction that yields from the first motion on, with a loop over the position.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{ElastoSlip, Onset, Plant};
use sealegs_model::{EffectCard, SimplerAt, SimplerLaw};

/// Dry friction with hysteresis over the position before it slips.
#[derive(Debug)]
pub struct DahlFriction;

impl Effect for DahlFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let (force, k) = (setting.force(), setting.stiffness);
        let parameters = vec![
            with_starts(setting.amount("force", Quantity::Force, 0.05 * force, 2.0 * force), [0.2 * force]),
            with_starts(
                setting.magnitude("stiffness", Quantity::Stiffness, 3.0 * k, 1e-2 * k, 1e3 * k),
                [0.3 * k, 30.0 * k],
            ),
        ];
        EffectCard {
            id: "dahl-friction".to_owned(),
            summary: "Dry friction with hysteresis over the position: it yields from the first motion on.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "f' = sigma y' (1 - f sign(y') / F_c)".to_owned(),
            validity: "Opposes the screw's motion. After a reversal it reaches 86 % of F_c within 2 F_c / sigma; under a \
                       push that trembles it may drift, which a real contact does not."
                .to_owned(),
            reference: "P. R. Dahl 1968, A solid friction model; F. Al-Bender, J. Swevers 2008, IEEE Control Systems \
                        28(6): hysteresis in presliding"
                .to_owned(),
            parameters,
            symbols: "f: friction force; sigma: stiffness; F_c: force; y': speed of the screw".to_owned(),
            told_apart: "Oscillations too small to slip leave a loop of force over position here, and a straight line \
                         under presliding friction. In wide motion both are Coulomb friction: record small \
                         reversals."
                .to_owned(),
            cure: "Feed its force forward from the way since the last reversal; a friction observer learns it. Avoid \
                   integral action at rest: the loop would hunt."
                .to_owned(),
            passive: true,
            becomes: Some(SimplerLaw { id: "coulomb-friction", departure: 1, at: SimplerAt::Infinity, beside: None }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        if values[0] > 0.0 {
            let onset = Onset::Gradual;
            plant.laws.rotor_presliding.push(ElastoSlip { bound: values[0], stiffness: values[1], onset });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Grid, Link};

    #[test]
    fn analytic_a_mass_that_is_thrown_into_it_stops_where_its_energy_is_spent() {
        // From rest of the friction 0.5 m v^2 = integral of F (1 - exp(-k y / F)) = F y - F^2 / k (1 - exp(-k y / F)).
        let (mass, speed, bound, stiffness) = (2.0, 0.5, 3.0, 40.0);
        let mut plant = Plant::new(mass, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(0.0));
        plant.start = (0.0, speed);
        DahlFriction.install(&[bound, stiffness], None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-4, steps: 8000 };
        let trace = plant.simulate(grid, &[0.0; 8000]).expect("finite");
        let farthest = trace.screw_position.iter().copied().fold(0.0, f64::max);
        let spent = |y: f64| bound * y + bound * bound / stiffness * (-stiffness * y / bound).exp_m1();
        let energy = 0.5 * mass * speed * speed;
        assert!((spent(farthest) / energy - 1.0).abs() < 1e-5, "{} of {energy} J", spent(farthest));
    }
}
