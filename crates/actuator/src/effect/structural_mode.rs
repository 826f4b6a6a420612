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
            symbols: "g: participation; w: angular frequency; zeta: damping_ratio; p: Laplace variable".to_owned(),
            told_apart: "A peak at one frequency in the measured forces that the rotor's motion does not show. Series \
                         compliance moves the rotor as well; torque ripple changes its frequency with the speed. A \
                         sweep tells them apart.".to_owned(),
            cure: "Keep the bandwidth below the mode, or place a notch there. Stiffen or damp the part, or move \
                   the load cell.".to_owned(),
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

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_spring
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

    /// `p^2/(...) F = F - P - (2 zeta/w) P'` with the low-passed `P'' + 2 zeta w P' + w^2 P = w^2 F`, exact for a
    /// force that is straight between the points: a step's error in its place would shift the frequency.
    fn apply(&self, values: &mut [f64], h: f64) {
        let (w, zeta, g) = (self.angular, self.damping_ratio, self.participation);
        let decay = zeta * w;
        let damped = w * (1.0 - zeta * zeta).max(0.0).sqrt();
        let fall = (-decay * h).exp();
        let (cosine, sine) = match damped * h {
            angle if angle > 1e-8 => (fall * angle.cos(), fall * angle.sin() / damped),
            _ => (fall, fall * h),
        };
        let lag = 2.0 * zeta / w;
        let mut before = values.first().copied().unwrap_or(0.0);
        let (mut low, mut rate) = (before, 0.0);
        for value in values.iter_mut().skip(1) {
            // Along a ramp P lags behind F by 2 zeta/w; what departs from that rings freely.
            let slope = (*value - before) / h;
            let (apart, apart_rate) = (low - (before - lag * slope), rate - slope);
            before = *value;
            low = *value - lag * slope + apart * (cosine + decay * sine) + apart_rate * sine;
            rate = slope - w * w * sine * apart + apart_rate * (cosine - decay * sine);
            *value += g * (*value - low - lag * rate);
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

    #[test]
    fn analytic_rings_at_its_frequency_whatever_the_step() {
        for (hz, zeta) in [(20.0, 0.03), (90.0, 0.3), (90.0, 1.0)] {
            let (h, w) = (2e-3, std::f64::consts::TAU * hz);
            let mode = Mode { angular: w, damping_ratio: zeta, participation: 0.5 };
            let mut values = vec![0.0];
            values.resize(100, 1.0);
            mode.apply(&mut values, h);
            // Samples of a damped oscillation obey y(n+1) = 2 e^(-zeta w h) cos(w_d h) y(n) - e^(-2 zeta w h) y(n-1).
            let fall = (-zeta * w * h).exp();
            let turn = (w * h * f64::sqrt(1.0 - zeta * zeta)).cos();
            let ringing: Vec<f64> = values[1..].iter().map(|v| v - 1.0).collect();
            assert!(ringing[0].abs() > 1e-3);
            for y in ringing.windows(3) {
                assert!((y[2] - (2.0 * fall * turn * y[1] - fall * fall * y[0])).abs() < 1e-12, "{y:?}");
            }
        }
    }
}
