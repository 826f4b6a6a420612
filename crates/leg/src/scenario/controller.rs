//! The keys that say who commands what.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Who commands the currents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControllerKind {
    /// Nobody: the currents are zero beside those of `[current]`.
    #[default]
    Free,
    /// Joint-space PD: joint torques by stiffness and damping about the wanted motion, shared out to the
    /// actuators through their moment arms.
    Pd,
}

/// The controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ControllerSpec {
    /// `free` or `pd`.
    pub kind: ControllerKind,
    /// Samples per second; the command holds in between. A multiple of the step must fit.
    pub rate_hz: f64,
    /// Joint stiffness, N m/rad; stable below the springs' own at the joint (`k` times moment arm squared).
    pub stiffness_nm_rad: f64,
    /// Joint damping, N m s/rad, beside the motors' own; it acts on the speeds that the motors stand for.
    pub damping_nm_s_rad: f64,
    /// Adds what holds the leg's own weight as it hangs from its base.
    pub gravity_compensation: bool,
    /// Adds what moves rotors and motor damping along the wanted motion.
    pub feed_forward: bool,
    /// Greatest current, A; the lesser of this and the actuator's own limit counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// Gains that differ for single joints, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub joints: BTreeMap<String, JointGains>,
}

impl Default for ControllerSpec {
    fn default() -> Self {
        Self {
            kind: ControllerKind::Free,
            rate_hz: 1000.0,
            stiffness_nm_rad: 500.0,
            damping_nm_s_rad: 20.0,
            gravity_compensation: true,
            feed_forward: true,
            current_limit_a: None,
            joints: BTreeMap::new(),
        }
    }
}

/// Gains of one joint.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointGains {
    /// Stiffness, N m/rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_nm_rad: Option<f64>,
    /// Damping, N m s/rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_nm_s_rad: Option<f64>,
}

/// How a joint is to move from its posture at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Motion {
    /// To another position along half a cosine, and there it stays.
    HalfCosine {
        /// Position at the end, rad.
        to_rad: f64,
        /// When it begins, s.
        #[serde(default)]
        start_s: f64,
        /// How long it takes, s.
        duration_s: f64,
    },
    /// A sine about the posture, faded in over its first period.
    Sine {
        /// Amplitude, rad.
        amplitude_rad: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Phase, rad.
        #[serde(default)]
        phase_rad: f64,
    },
}

impl Motion {
    /// Position, speed and acceleration at a time, from the posture `from_rad`: rad, rad/s, rad/s^2.
    #[must_use]
    pub fn at(&self, t: f64, from_rad: f64) -> [f64; 3] {
        match *self {
            Self::HalfCosine { to_rad, start_s, duration_s } => {
                let along = ((t - start_s) / duration_s).clamp(0.0, 1.0);
                let [s, ds, dds] = half_cosine(along);
                let way = to_rad - from_rad;
                [from_rad + way * s, way * ds / duration_s, way * dds / (duration_s * duration_s)]
            }
            Self::Sine { amplitude_rad, frequency_hz, phase_rad } => {
                let w = std::f64::consts::TAU * frequency_hz;
                let (sin, cos) = (w * t + phase_rad).sin_cos();
                // The fade takes away the jump in speed (and, with a phase, in position) at the start.
                let [f, df, ddf] = half_cosine((t * frequency_hz).clamp(0.0, 1.0));
                let (df, ddf) = (df * frequency_hz, ddf * frequency_hz * frequency_hz);
                let a = amplitude_rad;
                [
                    from_rad + a * f * sin,
                    a * (df * sin + f * w * cos),
                    a * (ddf * sin + 2.0 * df * w * cos - f * w * w * sin),
                ]
            }
        }
    }
}

/// `(1 - cos(pi s))/2` for s in 0..=1 with its derivatives; at rest at both ends.
fn half_cosine(s: f64) -> [f64; 3] {
    use std::f64::consts::PI;
    let (sin, cos) = (PI * s).sin_cos();
    let moving = if s > 0.0 && s < 1.0 { 1.0 } else { 0.0 };
    [0.5 * (1.0 - cos), 0.5 * PI * sin * moving, 0.5 * PI * PI * cos * moving]
}

/// A current from a CSV file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurrentFile {
    /// The file, seen from the scenario's folder; it has a header with `time_s`.
    pub file: String,
    /// The column with the current, A.
    #[serde(default = "default_column")]
    pub column: String,
    /// A straight line between the values instead of holding each until the next.
    #[serde(default)]
    pub linear: bool,
}

fn default_column() -> String {
    "current_a".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_speeds_are_derivatives_of_positions() {
        let motions = [
            Motion::HalfCosine { to_rad: 0.7, start_s: 0.2, duration_s: 0.9 },
            Motion::Sine { amplitude_rad: 0.4, frequency_hz: 1.3, phase_rad: 0.5 },
        ];
        for motion in motions {
            for t in [0.3, 0.55, 0.9, 1.05, 2.0] {
                let h = 1e-5;
                let [before, now, after] = [t - h, t, t + h].map(|t| motion.at(t, -0.1));
                assert!(((after[0] - before[0]) / (2.0 * h) - now[1]).abs() < 1e-6, "{motion:?} {t}");
                assert!(((after[1] - before[1]) / (2.0 * h) - now[2]).abs() < 1e-6, "{motion:?} {t}");
            }
        }
    }

    #[test]
    fn motions_start_from_the_posture_at_rest() {
        let sine = Motion::Sine { amplitude_rad: 0.4, frequency_hz: 1.3, phase_rad: 0.5 };
        assert_eq!(sine.at(0.0, 0.25)[..2], [0.25, 0.0]);
        let to = Motion::HalfCosine { to_rad: 0.7, start_s: 0.2, duration_s: 0.9 };
        assert_eq!(to.at(0.0, 0.25), [0.25, 0.0, 0.0]);
        assert!((to.at(5.0, 0.25)[0] - 0.7).abs() < 1e-15);
    }
}
