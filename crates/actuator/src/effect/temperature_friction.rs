//! Friction that falls with the temperature that was logged.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::bench::TEMPERATURE;
use crate::plant::{DryFriction, Plant, REFERENCE_TEMPERATURE_C, Slip};
use sealegs_model::{EffectCard, Parameter, SimplerAt, SimplerLaw};

/// Dry friction that falls with the logged temperature of the drive.
#[derive(Debug)]
pub struct TemperatureFriction;

impl Effect for TemperatureFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let force = setting.force();
        let fall = Parameter { typical: 0.005, ..Parameter::new("fall_per_k", "1/K", 0.01, 0.0, 0.2) };
        let parameters = vec![
            with_starts(setting.amount("force", Quantity::Force, 0.03 * force, 2.0 * force), [0.15 * force]),
            with_starts(fall, [0.04]),
        ];
        EffectCard {
            id: "temperature-friction".to_owned(),
            summary: "Dry friction that falls with the logged temperature of the drive.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "F_c exp(-a (T - T_0)) sign(y')".to_owned(),
            validity: format!(
                "Where temperature_c is logged beside the command of a bench. F_c is the force at T_0 = \
                 {REFERENCE_TEMPERATURE_C} C, at which a run without a thermometer is taken to be; over tens of kelvin one \
                 exponential is enough."
            ),
            reference: "A. C. Bittencourt, S. Gunnarsson 2012, J. Dyn. Sys. Meas. Control 134(5): friction falls about \
                        exponentially with the temperature"
                .to_owned(),
            parameters,
            symbols: "F_c: force; a: fall_per_k; T: temperature_c; y': speed of the screw".to_owned(),
            told_apart: "Coulomb friction is the same in a cold and in a warm run. Warming friction falls with the heat \
                         that it has made itself, this one with the thermometer: warm the drive from outside, or let it \
                         cool between runs."
                .to_owned(),
            cure: "Schedule the feedforward of the friction by the thermometer, warm the drive up before work, or use a \
                   lubricant whose viscosity changes less."
                .to_owned(),
            passive: true,
            becomes: Some(SimplerLaw { id: "coulomb-friction", departure: 1, at: SimplerAt::Zero, beside: None }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.rotor_friction.push(Box::new(ByTemperature { force: values[0], fall_per_k: values[1] }));
    }

    fn applies(&self, setting: &Setting) -> bool {
        // A model file is read before any run is known.
        setting.seen.ranges.is_empty() || setting.seen.range(TEMPERATURE).is_some()
    }
}

#[derive(Debug)]
struct ByTemperature {
    force: f64,
    fall_per_k: f64,
}

impl DryFriction for ByTemperature {
    fn bound(&self, slip: &Slip) -> f64 {
        self.force * (-self.fall_per_k * slip.warmer_k).exp()
    }

    fn feels_speed(&self) -> bool {
        false
    }

    fn feels_load(&self) -> bool {
        false
    }

    fn feels_temperature(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Feed, Grid, Link};

    #[test]
    fn analytic_a_pushed_mass_gains_speed_by_what_the_warm_friction_leaves() {
        // 10 N against 8 exp(-0.05 (T - 25)) N at 25, then at 45 degrees, on 2 kg.
        let mut plant = Plant::new(2.0, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(0.0));
        TemperatureFriction.install(&[8.0, 0.05], None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-3, steps: 2000 };
        let temperature: Vec<f64> = (0..2000).map(|n| if n < 1000 { 25.0 } else { 45.0 }).collect();
        let commands = [10.0; 2000];
        let feed = Feed { commands: &commands, temperature_c: Some(&temperature), ..Feed::default() };
        let speed = plant.simulate_fed(grid, feed).expect("finite").screw_speed;
        assert!((speed[1000] - 1.0).abs() < 1e-9, "{}", speed[1000]);
        let gained = (10.0 - 8.0 * (-1.0_f64).exp()) / 2.0;
        assert!((speed[2000] - speed[1000] - gained).abs() < 1e-9, "{}", speed[2000]);
    }
}
