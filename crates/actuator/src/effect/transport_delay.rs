//! Transport delay: the command acts later than it was given.

use super::Effect;
use super::setting::Setting;
use crate::plant::{CommandStage, Plant};
use sealegs_model::EffectCard;

/// The command acts later than it was given.
#[derive(Debug)]
pub struct TransportDelay;

impl Effect for TransportDelay {
    fn card(&self, setting: &Setting) -> EffectCard {
        EffectCard {
            id: "transport-delay".to_owned(),
            summary: "The command acts later than it was given.".to_owned(),
            acts_on: "drive".to_owned(),
            equation: "I(t - tau)".to_owned(),
            validity: "Communication, control loops and computation; cannot be told from an equal delay of every sensor.".to_owned(),
            reference: "Dissertation section 2-4-3".to_owned(),
            parameters: vec![setting.delay()],
            symbols: "I: commanded current; tau: delay".to_owned(),
            told_apart: "It delays all sensors alike; sensor-delay at one channel shifts that channel against the \
                         others. A lag rounds a step, a delay only shifts it. An equal delay of every sensor cannot \
                         be told from it.".to_owned(),
            cure: "A shorter cycle or a faster bus, a prediction over the known delay in the controller, or \
                   lower gains.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.command_stages.push(Box::new(Delay { delay_s: values[0] }));
    }
}

#[derive(Debug)]
struct Delay {
    delay_s: f64,
}

impl CommandStage for Delay {
    fn apply(&self, time_s: &mut [f64], _values: &mut [f64]) {
        time_s.iter_mut().for_each(|t| *t += self.delay_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_the_time_stamps() {
        let mut time = [0.0, 1.0];
        Delay { delay_s: 0.25 }.apply(&mut time, &mut [1.0, 2.0]);
        assert_eq!(time, [0.25, 1.25]);
    }
}
