//! Command quantisation: the drive takes the command in whole counts.

use super::Effect;
use super::setting::{CommandKind, Setting, magnitude, with_neutral, with_starts};
use crate::plant::{CommandStage, Plant};
use sealegs_model::{EffectCard, Parameter};

/// The drive takes the command in whole counts.
#[derive(Debug)]
pub struct CommandQuantisation;

impl Effect for CommandQuantisation {
    fn card(&self, setting: &Setting) -> EffectCard {
        let peak = setting.command();
        let unit = match setting.command {
            CommandKind::Voltage => ("count_v", "V"),
            _ if setting.force_per_command == 1.0 => ("count", ""),
            _ => ("count_a", "A"),
        };
        // The error left by a count is rugged in it: many starts. A drive that resolves fewer than ten counts of
        // what it was used for is none.
        let most = 0.1 * peak;
        let starts = (1..=72).map(|i| most * 10.0_f64.powf(-f64::from(i) / 24.0));
        let parameters = vec![
            with_neutral(with_starts(magnitude(unit.0, unit.1, most, 1e-4 * most, most), starts), 0.0),
            with_starts(Parameter { typical: 0.3, ..Parameter::new("rounding", "", 0.0, 0.0, 1.0) }, [1.0]),
        ];
        EffectCard {
            id: "command-quantisation".to_owned(),
            summary: "The drive takes the command in whole counts.".to_owned(),
            acts_on: "drive".to_owned(),
            equation:
                "count floor(abs(u)/count + rounding/2) sign(u): rounding 0 truncates toward zero, 1 rounds"
                    .to_owned(),
            validity: "Matters at small commands; the count is in the command's unit.".to_owned(),
            reference: "Quantisation of digital-to-analogue conversion".to_owned(),
            parameters,
            symbols: "u: command".to_owned(),
            told_apart:
                "Slow ramps at small commands: the force rises in steps of equal height. Dry friction holds \
                         back as well, but shows no steps and depends on the direction."
                    .to_owned(),
            cure:
                "A finer resolution of the command (more bits, a smaller full scale), or dither of one count."
                    .to_owned(),
            passive: false,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.command_stages.push(Box::new(Counts { count: values[0], rounding: values[1] }));
    }

    /// A goal's counts are the position sensor's.
    fn applies(&self, setting: &Setting) -> bool {
        setting.command != CommandKind::Goal
    }
}

#[derive(Debug)]
struct Counts {
    count: f64,
    rounding: f64,
}

impl CommandStage for Counts {
    fn apply(&self, _time_s: &mut [f64], values: &mut [f64]) {
        if self.count <= 0.0 {
            return;
        }
        for v in values {
            // A command that is a whole number of counts stays one, whatever its last digit's rounding.
            let counts = (v.abs() / self.count + 0.5 * self.rounding + 1e-9).floor();
            *v = v.signum() * self.count * counts;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truncates_or_rounds() {
        let mut values = [0.27, -0.27, 0.04];
        Counts { count: 0.1, rounding: 0.0 }.apply(&mut [0.0; 3], &mut values);
        for (got, truth) in values.iter().zip([0.2, -0.2, 0.0]) {
            assert!((got - truth).abs() < 1e-12);
        }
        let mut values = [0.27, -0.27];
        Counts { count: 0.1, rounding: 1.0 }.apply(&mut [0.0; 2], &mut values);
        assert!((values[0] - 0.3).abs() < 1e-12 && (values[1] + 0.3).abs() < 1e-12);
    }
}
