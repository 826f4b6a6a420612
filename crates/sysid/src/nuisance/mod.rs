//! Gain and bias of every sensor, solved linearly inside each evaluation of a residual.
//!
//! A sensor is taken to show `gain * true + bias + noise`. Gain and bias are no physics of the model, so
//! they are never search variables: for given model parameters their best values follow from a small linear
//! least-squares problem (variable projection), with what is known of them beforehand as further rows:
//!
//! - `gain = 1 ± gain_std`, one per channel for all runs (a load cell's 1 %; an encoder's angle has no
//!   gain error, its gain is fixed at 1). It is held inside three standard deviations: where the model is
//!   wrong by a hundred times the noise, ten thousand samples would otherwise outvote any maker's data
//!   sheet and hide the model's error in an impossible sensor.
//! - `bias_r = common ± run_bias_std` for each fitted run `r`, and `common = 0 ± bias_std`: a sensor is
//!   tared anew before a run on many rigs. A run's bias is held as the gain is, beside the common one, of which a mounting
//!   may know little. The common one is held as well, only farther away: within [`SensorPrior::BIAS_LIMIT`] of its standard
//!   deviations, or for a drive's own encoder half of what it showed.
//!
//! # The zero of a held-out run
//!
//! A held-out run is never fitted, and so has no bias of its own from the model's point of view. Its zero
//! is taken from its own start, as an experimenter would: from the rows, at the very beginning of the
//! file, during which the command has not changed yet and the model is at rest. This *quiet start*, with
//! its own standard error, is weighed against the common bias, with the spread of the fitted runs' biases:
//! where all runs agree (spread near zero) the common bias stands, where each run was tared anew the
//! quiet start does. No row after the first change of the command takes part, so that nothing of the
//! run's answer to its excitation can improve its own error. A held-out run without a quiet start is
//! judged with the common bias, and its error then contains the error of tare.
//!
//! Within a step of a sensor that counts nobody knows its zero, at rest least of all: whoever switches an encoder on finds it
//! anywhere between two counts. That half a step to either side is taken from the whole run, and no more.

mod solve;

pub use solve::{RunSums, Sensor, judge_zero, quiet_start, solve, within_a_step};

/// What is known of a sensor beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPrior {
    /// One standard deviation of the gain about 1; 0 fixes it.
    pub gain_std: f64,
    /// One standard deviation of the common bias about 0, in the channel's unit.
    pub bias_std: f64,
    /// One standard deviation of a run's bias about the common one, in the channel's unit.
    pub run_bias_std: f64,
    /// The common bias stays within this, in the channel's unit.
    pub bias_limit: f64,
}

/// Whether a drive's own encoder shows a channel that is no angle: counts, and speeds from counts.
fn is_encoder(channel: &str) -> bool {
    channel == "position_m" || channel.ends_with("_m_s") || channel.ends_with("_rad_s")
}

impl SensorPrior {
    /// The gain stays within this many of its standard deviations.
    pub const GAIN_LIMIT: f64 = 3.0;

    /// A run's bias stays within this many of its standard deviations of the common one, for the same reason.
    pub const RUN_BIAS_LIMIT: f64 = 3.0;

    /// The common bias stays within this many of its standard deviations: 0.2 rad of a joint's encoder, five times the peak of a
    /// load cell. A zero is set wrongly by less; a joint that stands 20 rad beside its model is no matter of zeros.
    pub const BIAS_LIMIT: f64 = 10.0;

    /// Or within this share of the greatest magnitude, where a drive's own encoder shows a position and that is more. Its standard
    /// deviation is of the size of its noise, and beside a drive without its friction it drifts by thousands of those: such a base
    /// model is wrong, and it must still be fitted where it is least so. A speed or a mounted joint has no such drift.
    const BIAS_SHARE: f64 = 0.5;

    /// The default for a channel, by its unit and the greatest magnitude that it showed.
    ///
    /// Forces, torques, lengths: 1 % of gain; a bias of 5 % of the peak from run to run about a common one
    /// of which next to nothing is known (ten times that). A torque that is inferred from a spring
    /// (`spring_torque_nm`) carries the error of an assumed stiffness, 10 %. Angles: no gain; the rotor's
    /// is zero at the start by definition, up to some noise; a joint's or a spring's encoder is mounted
    /// within 2 % of what it showed and 0.02 rad, and stays where it is up to a fifth of that.
    #[must_use]
    pub fn of_channel(channel: &str, noise_std: f64, peak: f64) -> Self {
        let wide = (0.05 * peak).max(5.0 * noise_std);
        // A robot's column has its joint before it.
        let column = channel.rsplit_once('.').map_or(channel, |(_, column)| column);
        let gain_std = match channel {
            _ if column == "spring_torque_nm" => 0.1,
            // A length along a rail: a scale or a wire.
            "base.height_m" => 0.005,
            _ if channel.ends_with("_rad") || is_encoder(channel) => 0.0,
            _ => 0.01,
        };
        let (bias_std, run_bias_std) = match channel {
            "motor_angle_rad" => (2.0 * noise_std, 2.0 * noise_std),
            _ if is_encoder(channel) => (2.0 * noise_std, 2.0 * noise_std),
            _ if channel.ends_with(".rotor_angle_rad") => (2.0 * noise_std, 2.0 * noise_std),
            // A drive measures its current about a zero that it finds anew whenever it is switched on.
            _ if channel.ends_with("_a") => (wide.min(10.0 * noise_std), noise_std),
            _ if channel.ends_with("_rad") => {
                let mounted = (0.02 * peak).clamp(5.0 * noise_std, f64::max(0.02, 5.0 * noise_std));
                (mounted, 0.2 * mounted + noise_std)
            }
            _ => (10.0 * wide, wide),
        };
        let drifts =
            matches!(channel, "motor_angle_rad" | "position_m") || channel.ends_with(".rotor_angle_rad");
        let share = if drifts { Self::BIAS_SHARE } else { 0.0 };
        let bias_limit = (Self::BIAS_LIMIT * bias_std).max(share * peak);
        Self { gain_std, bias_std, run_bias_std, bias_limit }
    }

    /// The same with what a file states: the gain's standard deviation, and that of a run's bias. The
    /// common bias gets ten times that, so that the runs decide about it and not the prior.
    #[must_use]
    pub fn stated(self, gain_std: Option<f64>, bias_std: Option<f64>) -> Self {
        let gain_std = gain_std.unwrap_or(self.gain_std);
        let Some(run_bias_std) = bias_std.filter(|s| *s > 0.0) else { return Self { gain_std, ..self } };
        let bias_std = 10.0 * run_bias_std;
        let bias_limit = self.bias_limit.max(Self::BIAS_LIMIT * bias_std);
        Self { gain_std, bias_std, run_bias_std, bias_limit }
    }
}
