//! Sensor delay: samples that carry a later time than their value.

use super::setting::Setting;
use super::{Effect, Scope};
use crate::plant::{Plant, SensorStage};
use sealegs_model::EffectCard;

/// Samples that are stamped late.
#[derive(Debug)]
pub struct SensorDelay;

impl Effect for SensorDelay {
    fn card(&self, setting: &Setting) -> EffectCard {
        EffectCard {
            id: "sensor-delay".to_owned(),
            summary: "Samples that are stamped late.".to_owned(),
            acts_on: "sensor".to_owned(),
            equation: "x(t - tau)".to_owned(),
            validity: "On all sensors, or on the one that is named; a delay of all of them cannot be told from one of the drive.".to_owned(),
            reference: "Any bus or logger; dissertation section 2-4-3".to_owned(),
            parameters: vec![setting.delay()],
            symbols: "x: true signal; tau: delay".to_owned(),
            told_apart: "One channel runs late against the others by the same time at every frequency. A late drive \
                         delays all of them; a lag also takes amplitude.".to_owned(),
            cure: "Stamp the samples at their source or by a common trigger. Until then shift the file by its \
                   offset_s.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], channel: Option<&str>, plant: &mut Plant) {
        plant
            .laws
            .sensor_stages
            .push(Box::new(Late { channel: channel.map(str::to_owned), delay_s: values[0] }));
    }

    fn scope(&self) -> Scope {
        Scope::Sensors
    }
}

#[derive(Debug)]
struct Late {
    channel: Option<String>,
    delay_s: f64,
}

impl SensorStage for Late {
    fn concerns(&self, channel: &str) -> bool {
        self.channel.as_ref().is_none_or(|c| c == channel)
    }

    fn apply(&self, values: &mut [f64], h: f64) {
        let shift = self.delay_s / h;
        let whole = shift.floor() as usize;
        let part = shift - shift.floor();
        for n in (0..values.len()).rev() {
            let at = |back: usize| values[n.saturating_sub(back)];
            values[n] = (1.0 - part) * at(whole) + part * at(whole + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_line_is_shifted() {
        let mut values: Vec<f64> = (0..20).map(f64::from).collect();
        Late { channel: None, delay_s: 2.5 }.apply(&mut values, 1.0);
        assert_eq!(values[10], 7.5);
        assert_eq!(values[1], 0.0);
    }
}
