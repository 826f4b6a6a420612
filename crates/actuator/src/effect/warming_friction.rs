//! Warming friction: dry friction that falls as its own heat warms the lubricant.

use super::Effect;
use super::setting::{Quantity, Setting, magnitude, with_starts};
use crate::plant::{DryFriction, Plant, Slip};
use sealegs_model::{EffectCard, Parameter, SimplerAt, SimplerLaw};

/// Dry friction that falls as its own heat warms it.
#[derive(Debug)]
pub struct WarmingFriction;

impl Effect for WarmingFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let force = setting.force();
        // What a friction of that size makes over ten times the travel that was seen.
        let energy = force * setting.length();
        let parameters = vec![
            with_starts(setting.amount("force", Quantity::Force, 0.03 * force, 2.0 * force), [0.15 * force]),
            with_starts(Parameter { typical: 0.1, ..Parameter::new("fall", "", 0.3, 0.0, 1.0) }, [0.7]),
            with_starts(
                magnitude("energy_j", "J", energy, 1e-3 * energy, 1e3 * energy),
                [0.1 * energy, 10.0 * energy],
            ),
        ];
        EffectCard {
            id: "warming-friction".to_owned(),
            summary: "Dry friction that falls as its own heat warms the lubricant.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "F_c (1 - a (1 - exp(-E/E_0))) sign(y'), E the heat that the rotor's dry friction has made".to_owned(),
            validity: "Every run begins cold; nothing cools down within a run. a lies between 0 and 1.".to_owned(),
            reference: "A. C. Bittencourt, S. Gunnarsson 2012, J. Dyn. Sys. Meas. Control 134(5): load and temperature \
                        effects on joint friction"
                .to_owned(),
            parameters,
            symbols: "F_c: force; a: fall; E_0: energy; E: heat that the friction has made; y': speed of the screw".to_owned(),
            told_apart: "Coulomb friction is the same at the end of a run as at its beginning. One long run of even \
                         motion tells them apart.".to_owned(),
            cure: "Warm the drive up before measuring and before work, or schedule the feedforward by the \
                   temperature.".to_owned(),
            passive: true,
            becomes: Some(SimplerLaw { id: "coulomb-friction", departure: 1, at: SimplerAt::Zero, beside: None }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        let law = Warming { cold: values[0], fall: values[1], per_energy: 1.0 / values[2] };
        plant.laws.rotor_friction.push(Box::new(law));
    }
}

#[derive(Debug)]
struct Warming {
    cold: f64,
    fall: f64,
    per_energy: f64,
}

impl DryFriction for Warming {
    fn bound(&self, slip: &Slip) -> f64 {
        self.cold * (1.0 + self.fall * (-slip.heat * self.per_energy).exp_m1())
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
    use crate::plant::{Grid, Link};

    #[test]
    fn analytic_falls_by_the_heat_it_has_made() {
        let law = Warming { cold: 20.0, fall: 0.5, per_energy: 0.1 };
        assert_eq!(law.bound(&Slip::default()), 20.0);
        let warm = law.bound(&Slip { heat: 10.0, ..Slip::default() });
        assert!((warm - 20.0 * (1.0 - 0.5 * (1.0 - (-1.0_f64).exp()))).abs() < 1e-12);
    }

    #[test]
    fn analytic_a_mass_that_slides_to_rest_has_made_its_energy_into_heat() {
        // Friction that vanishes with the first joules: 0.5 J of motion at F = F_0 exp(-E/E_0) lets the mass slide
        // until E_0 (exp(E/E_0) - 1) = F_0 s.
        let mut plant = Plant::new(1.0, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(0.0));
        plant.start = (0.0, 1.0);
        WarmingFriction.install(&[2.0, 1.0, 0.5], None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-4, steps: 20_000 };
        let trace = plant.simulate(grid, &[0.0; 20_000]).expect("finite");
        let distance = 0.5 * 1.0_f64.exp_m1() / 2.0;
        let end = trace.screw_position[20_000];
        assert_eq!(trace.screw_speed[20_000], 0.0);
        assert!((end / distance - 1.0).abs() < 1e-3, "{end} {distance}");
    }
}
