//! Motor strength: a motor that gives more or less than the force or torque it is told.

use super::Effect;
use super::setting::{CommandKind, Setting, ratio_to_stated};
use crate::plant::Plant;
use sealegs_model::EffectCard;

/// A motor that gives more or less than the force or torque it is told.
#[derive(Debug)]
pub struct MotorStrength;

impl Effect for MotorStrength {
    fn card(&self, _setting: &Setting) -> EffectCard {
        EffectCard {
            id: "motor-strength".to_owned(),
            summary: "A motor that gives more or less than the force or torque it is told.".to_owned(),
            acts_on: "drive".to_owned(),
            equation: "f_m = r u in the place of f_m = u".to_owned(),
            validity: "Felt only beside a load whose mass and weight are known: a lighter load with less friction moves \
                       alike. Where the command is a current or the goal of a loop, the motor's constant or its gain is \
                       fitted in any case."
                .to_owned(),
            reference: "M. Gautier, S. Briot 2014, J. Dynamic Systems, Measurement, and Control 136(5): drive gains \
                        identified with a payload that is weighed"
                .to_owned(),
            parameters: vec![ratio_to_stated("ratio", 0.9, 1.1)],
            symbols: "f_m: force or torque of the motor; u: command; r: ratio".to_owned(),
            told_apart: "The missing torque is proportional to the command, and the joint's own weight does not balance \
                         the command that holds it. An offset is the same at every command, and friction depends on the \
                         direction."
                .to_owned(),
            cure: "Correct the scale of the command's column, or the torque constant by which it was made of a current."
                .to_owned(),
            passive: false,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.force_per_command *= values[0];
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_load && matches!(setting.command, CommandKind::Effort | CommandKind::Unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_command_gives_so_much_more_and_only_a_commanded_effort_beside_a_load_is_asked() {
        let mut plant = Plant::new(1.0, 0.1, 0.0, 1e3);
        let before = plant.force_per_command;
        MotorStrength.install(&[0.85], None, &mut plant);
        assert!((plant.force_per_command - 0.85 * before).abs() < 1e-12);
        let with = |has_load, command| Setting { has_load, command, ..Setting::unknown() };
        assert!(MotorStrength.applies(&with(true, CommandKind::Effort)));
        assert!(!MotorStrength.applies(&with(false, CommandKind::Effort)));
        assert!(!MotorStrength.applies(&with(true, CommandKind::Current)));
    }
}
