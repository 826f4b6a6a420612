//! One recorded run, and what a model says it should have been.

use std::ops::Range;

/// How the input behaves between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InputHold {
    /// Constant from one sample to the next.
    #[default]
    ZeroOrder,
    /// A straight line from one sample to the next.
    Linear,
    /// No content above half the sampling frequency: interpolated accordingly.
    BandLimited,
}

/// A named sequence of values, one per time stamp of its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// The name with its unit as suffix, for example `force_1_n`.
    pub channel: String,
    /// The values, SI.
    pub values: Vec<f64>,
}

/// One recorded run on its own, possibly irregular, time stamps.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Where it came from, for messages.
    pub name: String,
    /// Whether it was cut out of a longer run: it then begins in motion, even where its first rows alone cannot tell that from
    /// rest.
    pub cut: bool,
    /// Strictly increasing time stamps, s.
    pub time_s: Vec<f64>,
    /// How the inputs behave between samples.
    pub hold: InputHold,
    /// The input channels.
    pub inputs: Vec<Signal>,
    /// The measured output channels.
    pub outputs: Vec<Signal>,
}

impl Signal {
    /// Its values at some rows.
    ///
    /// # Panics
    ///
    /// If there are fewer rows.
    #[must_use]
    pub fn at_rows(&self, rows: Range<usize>) -> Self {
        Self { channel: self.channel.clone(), values: self.values[rows].to_vec() }
    }
}

impl Record {
    /// The values of an input channel.
    #[must_use]
    pub fn input(&self, channel: &str) -> Option<&[f64]> {
        self.inputs.iter().find(|s| s.channel == channel).map(|s| s.values.as_slice())
    }

    /// The values of a measured output channel.
    #[must_use]
    pub fn output(&self, channel: &str) -> Option<&[f64]> {
        self.outputs.iter().find(|s| s.channel == channel).map(|s| s.values.as_slice())
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Time from the first sample to the last, s; 0 where there is none.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.time_s.last().zip(self.time_s.first()).map_or(0.0, |(b, a)| b - a)
    }

    /// Mean time between samples, s; 0 where there are fewer than two.
    #[must_use]
    pub fn mean_period_s(&self) -> f64 {
        self.duration_s() / self.len().saturating_sub(1).max(1) as f64
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The samples of some rows alone, under the same name.
    ///
    /// # Panics
    ///
    /// If there are fewer rows.
    #[must_use]
    pub fn at_rows(&self, rows: Range<usize>) -> Self {
        let of = |signals: &[Signal]| signals.iter().map(|s| s.at_rows(rows.clone())).collect();
        Self {
            name: self.name.clone(),
            cut: self.cut,
            time_s: self.time_s[rows.clone()].to_vec(),
            hold: self.hold,
            inputs: of(&self.inputs),
            outputs: of(&self.outputs),
        }
    }
}

/// What a model predicts for one record, at the record's time stamps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Prediction {
    /// The output channels that were asked for, in that order.
    pub outputs: Vec<Signal>,
    /// Signals inside the model that nobody measured, by which a residual is located: speed, load,
    /// deflection, angle. Their names are those of [`internal`] where they apply.
    pub internals: Vec<Signal>,
    /// What the reader should know: a beam past yield, a current at its limit; one line each, with the time.
    pub events: Vec<String>,
    /// Integration steps that it took, times the actuators that were simulated: what it cost.
    pub steps: u64,
}

impl Prediction {
    /// The values of a predicted output channel.
    #[must_use]
    pub fn output(&self, channel: &str) -> Option<&[f64]> {
        self.outputs.iter().find(|s| s.channel == channel).map(|s| s.values.as_slice())
    }

    /// The values of an internal signal.
    #[must_use]
    pub fn internal(&self, name: &str) -> Option<&[f64]> {
        self.internals.iter().find(|s| s.channel == name).map(|s| s.values.as_slice())
    }

    /// The internal signal with a name at a place of a leg, `PLACE.NAME`; the place of a bench's only actuator is empty.
    #[must_use]
    pub fn internal_at(&self, place: &str, name: &str) -> Option<&[f64]> {
        if place.is_empty() { self.internal(name) } else { self.internal(&format!("{place}.{name}")) }
    }

    /// The places that internal signals belong to, each once, in their order.
    #[must_use]
    pub fn places(&self) -> Vec<&str> {
        let mut places: Vec<&str> = Vec::new();
        for signal in &self.internals {
            let name =
                signal.channel.split_once(internal::MISSING).map_or(signal.channel.as_str(), |(p, _)| p);
            let place = name.rsplit_once('.').map_or("", |(place, _)| place);
            if !places.contains(&place) {
                places.push(place);
            }
        }
        places
    }
}

/// Names of internal signals.
///
/// For a rotary actuator the same names stand for the rotary quantities (N m and rad in place of N and m):
/// effects and residual maps then need no second set.
pub mod internal {
    /// Speed of the screw (linear) or of the motor at the output (rotary): m/s or rad/s.
    pub const SCREW_SPEED: &str = "screw_speed";
    /// Extension of the screw `y` (linear) or motor angle at the output (rotary): m or rad.
    pub const SCREW_POSITION: &str = "screw_position";
    /// Force in the screw `F_bs` (linear) or torque behind the gear (rotary): N or N m.
    pub const SCREW_FORCE: &str = "screw_force";
    /// Spring deflection: m or rad.
    pub const SPRING_DEFLECTION: &str = "spring_deflection";
    /// Force of the motor on the screw `F_m`: N or N m.
    pub const MOTOR_FORCE: &str = "motor_force";
    /// Force of the spring on the output, of an actuator in a leg: N.
    pub const SPRING_FORCE: &str = "spring_force";
    /// Rotor angle, rad.
    pub const ROTOR_ANGLE: &str = "rotor_angle_rad";
    /// Rotor speed, rad/s.
    pub const ROTOR_SPEED: &str = "rotor_speed_rad_s";
    /// Angle of the output joint, rad.
    pub const JOINT_ANGLE: &str = "joint_angle";
    /// Speed of the output joint, rad/s.
    pub const JOINT_SPEED: &str = "joint_speed";
    /// What the name of a signal begins with (behind its place) that a model under an observer lacks at a port:
    /// `missing.rotor`, `missing.spring`, `missing.output`, in N or N m, positive like the port's own force.
    pub const MISSING: &str = "missing.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_at_some_rows_has_their_time_and_values_alone() {
        let signal =
            |name: &str, values: [f64; 3]| Signal { channel: name.to_owned(), values: values.to_vec() };
        let record = Record {
            cut: false,
            name: "run".to_owned(),
            time_s: vec![0.0, 0.1, 0.2],
            hold: InputHold::Linear,
            inputs: vec![signal("current_a", [1.0, 2.0, 3.0])],
            outputs: vec![signal("force_1_n", [4.0, 5.0, 6.0])],
        };
        let part = record.at_rows(1..3);
        assert_eq!((part.time_s.as_slice(), part.hold), (&[0.1, 0.2][..], InputHold::Linear));
        assert_eq!(part.input("current_a"), Some(&[2.0, 3.0][..]));
        assert_eq!(part.output("force_1_n"), Some(&[5.0, 6.0][..]));
    }
}
