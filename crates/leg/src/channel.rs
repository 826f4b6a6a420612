//! The channels of a leg: what a logger may have recorded of it, and how each follows from an instant.

use crate::dynamics::coupling::ActuatorInstant;

/// One channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Channel {
    /// Position of a joint by its degree of freedom, rad.
    Joint(usize),
    /// Something of an actuator by its index.
    Actuator(usize, OfActuator),
    /// Height of the base's frame, m.
    BaseHeight,
    /// Sum of the ground's normal forces, N.
    GroundForce,
}

/// What an actuator's sensors show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OfActuator {
    /// Load cell on link 1, N.
    Force1,
    /// Load cell on link 2, N.
    Force2,
    /// The current that is commanded, A.
    Current,
    /// Rotor angle, rad.
    RotorAngle,
}

/// Endings of an actuator's channels.
const OF_ACTUATOR: [(&str, OfActuator); 4] = [
    ("force_1_n", OfActuator::Force1),
    ("force_2_n", OfActuator::Force2),
    ("current_a", OfActuator::Current),
    ("rotor_angle_rad", OfActuator::RotorAngle),
];

/// All channels of a leg with these joints and actuators, in the order of recordings: `<joint>.angle_rad`,
/// `<actuator>.force_1_n`, `.force_2_n`, `.current_a`, `.rotor_angle_rad`, `base.height_m`,
/// `foot.normal_force_n`.
pub(crate) fn all<S: AsRef<str>>(joints: &[S], actuators: &[S]) -> Vec<(String, Channel)> {
    let of_joints =
        joints.iter().enumerate().map(|(i, j)| (format!("{}.angle_rad", j.as_ref()), Channel::Joint(i)));
    let of_actuators = actuators.iter().enumerate().flat_map(|(i, a)| {
        OF_ACTUATOR.map(|(ending, what)| (format!("{}.{ending}", a.as_ref()), Channel::Actuator(i, what)))
    });
    let rest = [("base.height_m", Channel::BaseHeight), ("foot.normal_force_n", Channel::GroundForce)];
    of_joints.chain(of_actuators).chain(rest.map(|(name, c)| (name.to_owned(), c))).collect()
}

/// Everything that channels read, at one instant.
pub(crate) struct Instant<'a> {
    /// Joint positions, rad.
    pub joint_angles_rad: &'a [f64],
    /// The actuators.
    pub actuators: &'a [ActuatorInstant],
    /// Height of the base's frame, m.
    pub base_height_m: f64,
    /// Sum of the ground's normal forces, N.
    pub normal_force_n: f64,
}

impl Channel {
    /// Its value at an instant.
    pub fn at(self, instant: &Instant) -> f64 {
        match self {
            Self::Joint(dof) => instant.joint_angles_rad[dof],
            Self::Actuator(i, what) => {
                let actuator = &instant.actuators[i];
                match what {
                    OfActuator::Force1 => actuator.force_1_n,
                    OfActuator::Force2 => actuator.force_2_n,
                    OfActuator::Current => actuator.current_a,
                    OfActuator::RotorAngle => actuator.rotor_angle_rad,
                }
            }
            Self::BaseHeight => instant.base_height_m,
            Self::GroundForce => instant.normal_force_n,
        }
    }
}
