//! A law that is a curve: what acts at a port as a function of one signal, where no known effect gives it.

use serde::{Deserialize, Serialize};

/// The signal over which a [`Curve`] stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Over {
    /// Of the screw, m/s (rad/s of a rotary actuator); at an output of the joint, rad/s.
    Speed,
    /// Extension of the screw, m (rad); at an output the joint's angle, rad.
    Position,
    /// Magnitude of the force in the screw, N (N m).
    Load,
    /// Of the spring, m (rad).
    Deflection,
    /// Of the spring, m/s (rad/s).
    DeflectionRate,
    /// Of the run, s.
    Time,
    /// What was commanded, in its own unit.
    Command,
    /// What a sensor would show, in its own unit.
    Value,
}

/// What a [`Curve`] is multiplied by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Factor {
    /// Nothing.
    #[default]
    One,
    /// The sign of the speed, against the motion: the curve is the bound of a dry friction.
    Direction,
    /// The deflection of the spring, m (rad).
    Deflection,
    /// The command, in its own unit.
    Command,
}

/// Straight lines between points. Beyond the first and the last a curve over a place, a load or the time stays as it is there;
/// any other one goes on as straight as it ends, as damping, a stiffness or a gain of the model does that shares its slope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Curve {
    /// The abscissa.
    pub over: Over,
    /// What the curve is multiplied by.
    #[serde(default)]
    pub times: Factor,
    /// Abscissas, ascending.
    pub x: Vec<f64>,
    /// Ordinates, in the port's unit over that of the factor.
    pub y: Vec<f64>,
    /// Dry friction beside a curve over the rotor's speed, N (N m): what the curve cannot have at speed zero.
    #[serde(default)]
    pub dry: f64,
}

impl Curve {
    /// Most points of which each is a parameter; a curve of more has its size alone.
    pub const MOST_FREE: usize = 12;

    /// The ordinate of `y` at an abscissa.
    #[must_use]
    #[inline]
    pub fn at(over: Over, x: &[f64], y: &[f64], at: f64) -> f64 {
        let mut k = x.partition_point(|knot| *knot <= at);
        if k == 0 || k == x.len() {
            if matches!(over, Over::Position | Over::Load | Over::Time) || x.len() < 2 {
                return y[k.clamp(1, x.len()) - 1];
            }
            k = k.clamp(1, x.len() - 1);
        }
        y[k - 1] + (y[k] - y[k - 1]) * (at - x[k - 1]) / (x[k] - x[k - 1])
    }
}

/// A curve at a port: an effect that was read off a missing signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct Law {
    /// Lower-case words joined by `-`; another one than any effect's.
    pub id: String,
    /// The actuator or joint of a leg or robot; none on a bench.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// `rotor`, `drive`, `spring`, `output` or `sensor/CHANNEL`.
    pub acts_on: String,
    /// One line: what it stands for.
    pub summary: String,
    /// The curve. A force on the rotor is positive where it lengthens the actuator, one in the spring in compression, one at
    /// an output where its angle grows; a drive's is what the motor force has too much; a sensor's what is shown too much.
    pub curve: Curve,
}

impl Law {
    /// The id under which a model includes it.
    #[must_use]
    pub fn effect(&self) -> String {
        self.place.as_ref().map_or_else(|| self.id.clone(), |place| format!("{place}/{}", self.id))
    }
}

#[cfg(test)]
mod tests {
    use super::{Curve, Over};

    #[test]
    fn analytic_lines_between_points_and_level_or_straight_beyond() {
        let (x, y) = ([0.0, 1.0, 3.0], [2.0, 4.0, 0.0]);
        let over = |over| [-1.0, 0.0, 0.5, 2.0, 3.0, 4.0].map(|v| Curve::at(over, &x, &y, v));
        assert_eq!(over(Over::Position), [2.0, 2.0, 3.0, 2.0, 0.0, 0.0]);
        for straight in [Over::Speed, Over::Deflection, Over::Command] {
            assert_eq!(over(straight), [0.0, 2.0, 3.0, 2.0, 0.0, -2.0]);
        }
    }
}
