//! Structural mode: a resonance in the path of the measured forces.

use super::Effect;
use super::setting::{Setting, magnitude, with_starts};
use crate::plant::{Plant, SensorStage};
use sealegs_model::{EffectCard, Parameter};

/// A resonance of the structure that the forces pass through (screw bending).
#[derive(Debug)]
pub struct StructuralMode;

impl Effect for StructuralMode {
    fn card(&self, setting: &Setting) -> EffectCard {
        let top = 0.95 * setting.nyquist_hz();
        let guess = (4.0 * setting.natural_hz()).min(0.3 * top);
        let starts = (0..24).map(|i| 0.5 * setting.natural_hz() * 1.2_f64.powi(i));
        let mut participation = Parameter::new("participation", "", 0.3, -5.0, 20.0);
        participation.neutral = Some(0.0);
        participation.typical = 0.2;
        let parameters = vec![
            with_starts(magnitude("frequency_hz", "Hz", guess, 0.02 * top, top), starts),
            with_starts(magnitude("damping_ratio", "", 0.05, 1e-3, 1.0), [0.2]),
            participation,
        ];
        EffectCard {
            id: "structural-mode".to_owned(),
            summary: "A resonance of the structure that the forces pass through (screw bending).".to_owned(),
            acts_on: "force path".to_owned(),
            equation: "forces times 1 + g p^2/(p^2 + 2 zeta w p + w^2)".to_owned(),
            validity: "Seen by the force and torque sensors; the participation g may have either sign.".to_owned(),
            reference: "Dissertation section 3-4-2: the unexplained resonance at 80 Hz, attributed to a ball-screw mode".to_owned(),
            parameters,
            passive: false,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.sensor_stages.push(Box::new(Mode {
            angular: std::f64::consts::TAU * values[0],
            damping_ratio: values[1],
            participation: values[2],
        }));
    }
}

#[derive(Debug)]
struct Mode {
    angular: f64,
    damping_ratio: f64,
    participation: f64,
}

impl SensorStage for Mode {
    fn concerns(&self, channel: &str) -> bool {
        super::is_force(channel)
    }

    /// `p^2/(...) F = F - P - (2 zeta/w) P'` with the low-passed `P'' + 2 zeta w P' + w^2 P = w^2 F`, by
    /// the implicit midpoint.
    fn apply(&self, values: &mut [f64], h: f64) {
        let (w, zeta, g) = (self.angular, self.damping_ratio, self.participation);
        let system = 1.0 / (2.0 / h + 2.0 * zeta * w + 0.5 * h * w * w);
        let (mut low, mut rate) = (0.0, 0.0);
        let mut before = values.first().copied().unwrap_or(0.0);
        for value in values.iter_mut().skip(1) {
            let mid = 0.5 * (before + *value);
            before = *value;
            let mean = system * (2.0 / h * rate - w * w * (low - mid));
            low += h * mean;
            rate = 2.0 * mean - rate;
            *value += g * (*value - low - 2.0 * zeta / w * rate);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_gain_at_resonance() {
        // At p = i w the factor is 1 + g w^2 (-1) / (2 zeta i w^2) = 1 + i g / (2 zeta).
        let (hz, h) = (20.0, 1e-4);
        let mode = Mode { angular: std::f64::consts::TAU * hz, damping_ratio: 0.1, participation: 0.5 };
        let mut values: Vec<f64> =
            (0..100_000).map(|n| (std::f64::consts::TAU * hz * h * f64::from(n)).sin()).collect();
        mode.apply(&mut values, h);
        let peak = values[90_000..].iter().fold(0.0_f64, |p, v| p.max(v.abs()));
        assert!((peak - (1.0_f64 + 2.5 * 2.5).sqrt()).abs() < 2e-3, "{peak}");
    }
}
