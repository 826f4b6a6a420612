//! Feedback delay: a servo's loop sees its position late.

use super::Effect;
use super::setting::{CommandKind, Setting};
use crate::plant::Plant;
use sealegs_model::EffectCard;

/// The servo's loop sees its position late.
#[derive(Debug)]
pub struct FeedbackDelay;

impl Effect for FeedbackDelay {
    fn card(&self, setting: &Setting) -> EffectCard {
        EffectCard {
            id: "feedback-delay".to_owned(),
            summary: "The servo's own loop sees its position late.".to_owned(),
            acts_on: "drive".to_owned(),
            equation: "e(t) = goal(t) - position(t - tau)".to_owned(),
            validity: "Inside the loop: it takes damping from it. A late goal is transport-delay, a late log sensor-delay."
                .to_owned(),
            reference: "G. F. Franklin, J. D. Powell, A. Emami-Naeini, Feedback Control of Dynamic Systems".to_owned(),
            parameters: vec![setting.delay()],
            symbols: "e: control error; tau: delay".to_owned(),
            told_apart: "It acts inside the servo's loop: ringing and overshoot grow with the gain. Transport-delay \
                         shifts the whole answer and keeps its shape, sensor-delay shifts only the log. Record runs \
                         at two gains.".to_owned(),
            cure: "A faster loop or a lower gain. Take the derivative from a measured speed where there is one.".to_owned(),
            passive: false,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        if let Some(servo) = &mut plant.servo {
            servo.feedback_delay_s += values[0];
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.command == CommandKind::Goal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plant_without_a_loop_stays_as_it_is() {
        let mut plant = Plant::new(1.0, 0.0, 0.0, 1.0);
        FeedbackDelay.install(&[0.01], None, &mut plant);
        assert_eq!(plant.servo, None);
    }
}
