//! Current saturation: the drive clips the commanded current.

use super::Effect;
use super::setting::{CommandKind, Quantity, Setting, magnitude, with_neutral, with_starts};
use crate::plant::{CommandStage, DriveLimit, Plant};
use sealegs_model::EffectCard;

/// The drive delivers no more than a limit current.
#[derive(Debug)]
pub struct CurrentSaturation;

impl Effect for CurrentSaturation {
    fn card(&self, setting: &Setting) -> EffectCard {
        let by_bridge = matches!(setting.command, CommandKind::Voltage | CommandKind::Goal);
        let winding = setting.winding.filter(|_| by_bridge);
        let peak = winding.map_or(setting.command(), |w| setting.force() / w.force_per_current);
        let unit = match setting.force_per_command == 1.0 {
            true => ("limit", setting.unit(Quantity::Force)),
            false => ("limit_a", "A"),
        };
        let parameters = vec![with_neutral(
            with_starts(
                magnitude(unit.0, unit.1, 0.95 * peak, 0.02 * peak, 1.5 * peak),
                // Often the limit is passed by a few samples only.
                [0.99, 0.9, 0.8, 0.6, 0.4].map(|share| share * peak),
            ),
            f64::INFINITY,
        )];
        EffectCard {
            id: "current-saturation".to_owned(),
            summary: "The drive delivers no more than a limit current; of one that is commanded a force or a torque, no more than \
                      a limit of that."
                .to_owned(),
            acts_on: "drive".to_owned(),
            equation: "I clipped to +-I_max".to_owned(),
            validity: "Matters only where the command exceeds the limit.".to_owned(),
            reference: "Dissertation section 4-6-1".to_owned(),
            parameters,
            symbols: "I: commanded current; I_max: limit".to_owned(),
            told_apart: "It cuts above one level of the command, at standstill as in motion. Voltage saturation cuts \
                         earlier as the speed rises.".to_owned(),
            cure: "Keep the commands below the limit and add anti-windup, or raise the limit if motor and drive \
                   bear it.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        match (plant.winding, plant.servo) {
            (Some(winding), _) => limit_current(plant, winding.force_per_current * values[0]),
            // The command is a goal there, and its loop commands a torque.
            (None, Some(_)) => limit_current(plant, plant.force_per_command * values[0]),
            (None, None) => plant.laws.command_stages.push(Box::new(Saturation { limit: values[0] })),
        }
    }
}

/// Limits the motor force (N) of a drive that sets a voltage.
pub(crate) fn limit_current(plant: &mut Plant, force: f64) {
    plant.laws.drive_limits.push(Box::new(AtBridge { force }));
}

#[derive(Debug)]
struct AtBridge {
    force: f64,
}

impl DriveLimit for AtBridge {
    fn limit(&self, commanded: f64, _y_dot: f64) -> f64 {
        commanded.max(-self.force).min(self.force)
    }
}

#[derive(Debug)]
struct Saturation {
    limit: f64,
}

impl CommandStage for Saturation {
    fn apply(&self, _time_s: &mut [f64], values: &mut [f64]) {
        values.iter_mut().for_each(|v| *v = v.clamp(-self.limit, self.limit));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_both_ways() {
        let mut values = [3.0, -5.0, 1.0];
        Saturation { limit: 2.0 }.apply(&mut [0.0, 1.0, 2.0], &mut values);
        assert_eq!(values, [2.0, -2.0, 1.0]);
    }
}
