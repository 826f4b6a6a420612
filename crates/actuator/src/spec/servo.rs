//! The drive's own position loop, as a file states it.

use super::parts::{optional_positive, positive};
use crate::ActuatorError;
use serde::{Deserialize, Serialize};

/// Whose position and speed a loop sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Feedback {
    /// The output's, as of an encoder at the joint.
    #[default]
    Joint,
    /// The rotor's over the ratio, as of the one encoder that most quasi-direct drives have: ahead of the joint by play and by
    /// what the transmission yields.
    Motor,
}

impl Feedback {
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
    fn is_joint(&self) -> bool {
        *self == Self::Joint
    }
}

/// A position loop inside the drive, whose command is a goal; `e = goal - position` of the output, or as `feedback` says. Only for
/// a rotary drive without a spring.
///
/// A hobby servo's sets a voltage: `duty = clamp(k_p e - k_d position' + k_i integral(e))`, and the motor gets duty times supply. That of
/// a joint under impedance control commands a torque at the output: `clamp(k_p e + k_d (goal' - position') + feed-forward)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoSpec {
    /// `k_p` of a loop that commands a torque, N m/rad; a run's `servo_gain` multiplies it and `k_d`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proportional_nm_per_rad: Option<f64>,
    /// `k_d` of a loop that commands a torque, N m s/rad.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub derivative_nm_s_per_rad: f64,
    /// Greatest magnitude of the torque that the loop commands, N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_limit_nm: Option<f64>,
    /// `k_p`, duty per rad; a run's `servo_gain` multiplies it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub proportional_per_rad: f64,
    /// `k_d`, duty per rad/s.
    #[serde(default)]
    pub derivative_s_per_rad: f64,
    /// `k_i`, duty per rad s.
    #[serde(default)]
    pub integral_per_rad_s: f64,
    /// Greatest magnitude of the duty.
    #[serde(default = "one")]
    pub duty_limit: f64,
    /// Duty below which the bridge gives no voltage.
    #[serde(default)]
    pub duty_dead_zone: f64,
    /// Greatest current, A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// An error below this counts as none, rad.
    #[serde(default)]
    pub dead_band_rad: f64,
    /// From the logged goal to the loop, s.
    #[serde(default)]
    pub command_delay_s: f64,
    /// Age of the position that the loop sees, s.
    #[serde(default)]
    pub feedback_delay_s: f64,
    /// Whose position the loop sees.
    #[serde(default, skip_serializing_if = "Feedback::is_joint")]
    pub feedback: Feedback,
    /// Sampling rate of the loop, Hz; continuous if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
}

fn one() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl ServoSpec {
    /// Whether the loop commands a torque and no voltage.
    #[must_use]
    pub fn commands_torque(&self) -> bool {
        self.proportional_nm_per_rad.is_some()
    }

    /// The keys of one kind of loop that stand beside those of the other one, or the gain that neither has.
    fn validate_kind(&self) -> Result<(), ActuatorError> {
        let stated =
            |(field, value, unless): (&'static str, f64, f64)| (value != unless).then_some((field, value));
        let of_voltage = [
            ("proportional_per_rad", self.proportional_per_rad, 0.0),
            ("derivative_s_per_rad", self.derivative_s_per_rad, 0.0),
            ("integral_per_rad_s", self.integral_per_rad_s, 0.0),
            ("duty_limit", self.duty_limit, 1.0),
            ("duty_dead_zone", self.duty_dead_zone, 0.0),
            ("current_limit_a", self.current_limit_a.unwrap_or(0.0), 0.0),
        ];
        let of_torque = [
            ("derivative_nm_s_per_rad", self.derivative_nm_s_per_rad, 0.0),
            ("torque_limit_nm", self.torque_limit_nm.unwrap_or(0.0), 0.0),
        ];
        let Some(proportional) = self.proportional_nm_per_rad else {
            let alien = of_torque.into_iter().find_map(stated);
            return match alien {
                Some((field, value)) => {
                    let admitted = "absent where the loop sets a voltage: proportional_nm_per_rad is missing";
                    Err(ActuatorError::value(field, value, admitted))
                }
                None if self.proportional_per_rad == 0.0 => {
                    let admitted = "given, or proportional_nm_per_rad of a loop that commands a torque";
                    Err(ActuatorError::value("proportional_per_rad", "nothing", admitted))
                }
                None => positive("proportional_per_rad", self.proportional_per_rad),
            };
        };
        if let Some((field, value)) = of_voltage.into_iter().find_map(stated) {
            let admitted = "absent where the loop commands a torque, as proportional_nm_per_rad says";
            return Err(ActuatorError::value(field, value, admitted));
        }
        optional_positive("torque_limit_nm", self.torque_limit_nm)?;
        positive("proportional_nm_per_rad", proportional)
    }

    pub(super) fn validate(&self) -> Result<(), ActuatorError> {
        self.validate_kind()?;
        let not_negative = [
            ("derivative_nm_s_per_rad", self.derivative_nm_s_per_rad),
            ("derivative_s_per_rad", self.derivative_s_per_rad),
            ("integral_per_rad_s", self.integral_per_rad_s),
            ("duty_dead_zone", self.duty_dead_zone),
            ("dead_band_rad", self.dead_band_rad),
            ("command_delay_s", self.command_delay_s),
            ("feedback_delay_s", self.feedback_delay_s),
        ];
        for (field, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(ActuatorError::value(field, value, "zero or positive, and finite"));
            }
        }
        if !(self.duty_limit > 0.0 && self.duty_limit <= 1.0) {
            return Err(ActuatorError::value("duty_limit", self.duty_limit, "above 0 and at most 1"));
        }
        if self.duty_dead_zone >= self.duty_limit {
            return Err(ActuatorError::value("duty_dead_zone", self.duty_dead_zone, "below duty_limit"));
        }
        optional_positive("current_limit_a", self.current_limit_a)?;
        optional_positive("rate_hz", self.rate_hz)
    }
}
