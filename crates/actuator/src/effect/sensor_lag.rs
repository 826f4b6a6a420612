//! Sensor lag: a first-order low-pass in front of what the logger records.

use super::setting::{Setting, magnitude, with_neutral, with_starts};
use super::{Effect, Scope};
use crate::plant::{Plant, SensorStage};
use sealegs_model::EffectCard;

/// A first-order low-pass in the force or torque sensors.
#[derive(Debug)]
pub struct SensorLag;

impl Effect for SensorLag {
    fn card(&self, setting: &Setting) -> EffectCard {
        let top = setting.nyquist_hz();
        let parameters = vec![with_neutral(
            with_starts(
                magnitude("cutoff_hz", "Hz", 0.2 * top, 1e-3 * top, 40.0 * top),
                [0.04 * top, 0.8 * top, 3.0 * top],
            ),
            f64::INFINITY,
        )];
        EffectCard {
            id: "sensor-lag".to_owned(),
            summary: "A first-order low-pass in the force or torque sensors.".to_owned(),
            acts_on: "sensor".to_owned(),
            equation: "x' = 2 pi f_c (F - x)".to_owned(),
            validity: "On all force and torque sensors, or on the one that is named.".to_owned(),
            reference: "Any amplifier with a filter; e.g. load-cell conditioners".to_owned(),
            parameters,
            symbols: "F: true force; x: shown force; f_c: cutoff".to_owned(),
            told_apart:
                "Above the cutoff the amplitude falls. A sensor-delay changes the phase and keeps the \
                         amplitude; damping changes the motion as well, this one only what is shown."
                    .to_owned(),
            cure: "Raise the filter's cutoff, filter all channels alike, or put the known filter into the \
                   model."
                .to_owned(),
            passive: false,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], channel: Option<&str>, plant: &mut Plant) {
        plant.laws.sensor_stages.push(Box::new(LowPass {
            channel: channel.map(str::to_owned),
            angular: std::f64::consts::TAU * values[0],
        }));
    }

    fn scope(&self) -> Scope {
        Scope::ForceSensors
    }
}

#[derive(Debug)]
struct LowPass {
    channel: Option<String>,
    angular: f64,
}

impl SensorStage for LowPass {
    fn concerns(&self, channel: &str) -> bool {
        self.channel.as_ref().map_or_else(|| super::is_force(channel), |c| c == channel)
    }

    /// Exact for a signal that is straight between the points.
    fn apply(&self, values: &mut [f64], h: f64) {
        if !self.angular.is_finite() {
            return;
        }
        let x = self.angular * h;
        let decay = (-x).exp();
        // Weights of the interval's two ends in the convolution of a straight line with the exponential.
        let late = if x < 1e-6 { 0.5 * x } else { 1.0 - (1.0 - decay) / x };
        let early = 1.0 - decay - late;
        let mut state = values.first().copied().unwrap_or(0.0);
        let mut before = state;
        for value in values.iter_mut() {
            state = decay * state + early * before + late * *value;
            before = *value;
            *value = state;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_step_response() {
        let law = LowPass { channel: None, angular: 50.0 };
        let h = 1e-4;
        let mut values = vec![1.0; 1000];
        values[0] = 0.0;
        law.apply(&mut values, h);
        // The first interval is a ramp; from then on the exact exponential of a step half a sample late.
        let truth = 1.0 - (-50.0 * (999.0 - 0.5) * h).exp();
        assert!((values[999] - truth).abs() < 1e-7);
        assert!(!LowPass { channel: Some("force_1_n".to_owned()), angular: 1.0 }.concerns("force_2_n"));
    }
}
