//! The places at which an effect can act on an actuator: each is a small trait that the integrator calls.
//!
//! Quantities are those of a linear actuator (N, m); for a rotary actuator they stand for N m and rad at
//! the output. Signs: the screw's extension `y` is positive when it lengthens the actuator, forces inside
//! the actuator are positive in compression.

use std::fmt::Debug;

/// Where and how the rotor slips, as a law of dry friction sees it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slip {
    /// Extension of the screw, m.
    pub position: f64,
    /// Screw speed, m/s; its sign is the direction of slip, 0 asks for the limit at rest.
    pub speed: f64,
    /// +1 or -1: the sign of `speed` in motion, at rest the way in which the rotor is pushed.
    pub direction: f64,
    /// Force in the screw, N, positive in compression; of a drive without a spring what passes to its load.
    pub load: f64,
    /// Heat that the rotor's dry friction has made since the beginning of the run, J.
    pub heat: f64,
}

/// Dry friction between the rotor and the motor housing: a bound that holds the rotor at rest and opposes
/// its motion when it moves.
pub trait DryFriction: Debug + Send + Sync {
    /// The bound in N (not negative) where the rotor slips or is about to.
    fn bound(&self, slip: &Slip) -> f64;

    /// Whether the bound depends on speed; saying no saves time.
    fn feels_speed(&self) -> bool {
        true
    }

    /// Whether the bound depends on the load; saying no saves time.
    fn feels_load(&self) -> bool {
        true
    }
}

/// A force on the rotor, referred to the screw, positive when it lengthens the actuator.
pub trait RotorForce: Debug + Send + Sync {
    /// The force in N at extension `y` (m), speed `y_dot` (m/s), screw force `load` (N), time `t` (s).
    fn force(&self, y: f64, y_dot: f64, load: f64, t: f64) -> f64;

    /// The energy that it has stored at extension `y`, J; none unless it is a force of position alone.
    fn stored(&self, _y: f64) -> f64 {
        0.0
    }
}

/// What the drive does to the commanded force at every instant, depending on speed.
pub trait DriveLimit: Debug + Send + Sync {
    /// The motor force (N) that is left of the commanded one (N) at screw speed `y_dot` (m/s).
    fn limit(&self, commanded: f64, y_dot: f64) -> f64;
}

/// What happens to the command on its way to the motor, independent of the state. Each sample is changed on its
/// own: a controller's commands are not known in advance.
pub trait CommandStage: Debug + Send + Sync {
    /// Changes the command's samples in place: `time_s` may be shifted, `values` (in the command's own
    /// unit, A, N or N m) changed.
    fn apply(&self, time_s: &mut [f64], values: &mut [f64]);
}

/// Something in line with the spring that uses up deflection, such as play.
pub trait SpringPath: Debug + Send + Sync {
    /// The deflection (m) that is left for the spring out of the total one (m).
    fn left(&self, deflection: f64) -> f64;
}

/// A force beside the linear spring, positive in compression.
pub trait SpringForce: Debug + Send + Sync {
    /// The force (N) at deflection `delta` (m), its rate `delta_dot` (m/s) and time `t` (s).
    fn force(&self, delta: f64, delta_dot: f64, t: f64) -> f64;
}

/// What a sensor, or the structure in front of it, does to the signal that it measures.
pub trait SensorStage: Debug + Send + Sync {
    /// Whether this channel passes through the stage.
    fn concerns(&self, channel: &str) -> bool;

    /// Changes the signal in place. It is given on a uniform grid of step `h` (s).
    fn apply(&self, values: &mut [f64], h: f64);
}

/// An elastic element in series with a dry slider: `f' = stiffness * rate`, held within `±bound`.
///
/// Beside the rotor it is presliding friction, beside the spring it is the slip of a clamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElastoSlip {
    /// N/m.
    pub stiffness: f64,
    /// N.
    pub bound: f64,
}

impl ElastoSlip {
    /// The element's force after its ends have moved by `step` (m), from the force `f` (N) before.
    #[must_use]
    pub fn advance(&self, f: f64, step: f64) -> f64 {
        (f + self.stiffness * step).clamp(-self.bound, self.bound)
    }
}
