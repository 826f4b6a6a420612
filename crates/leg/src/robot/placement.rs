//! Where an actuator sits: between which links, from which points, with which linkage and spring setting.

use nalgebra::{Point3, Unit, Vector3};
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::linkage::Hoekens;

/// One actuator on the robot.
///
/// Its length `x` is measured from link 1, the spring side, to link 2, the screw side, and grows when the
/// screw extends. A compressive force `F` (positive) pushes the links apart, and joint `j` feels
/// `F dx/dq_j`: the gradient of the length is the vector of moment arms. Which joints lie between the two
/// links follows from the tree; an actuator pair across two hinges is nothing special.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Unique name, used in scenarios and results.
    pub name: String,
    /// The actuator: a preset's name or the path of an actuator file. Empty for a rigid position drive.
    pub actuator: String,
    /// The name of the spring's setting in the actuator's file, `compliant` for instance. Empty for a rigid
    /// position drive, or where the actuator's own default is meant.
    pub spring_setting: String,
    /// The actuator itself with its spring at that setting; `None` for a rigid position drive.
    pub spec: Option<ActuatorSpec>,
    /// Index of link 1, the spring side.
    pub link_1: usize,
    /// Index of link 2, the screw side.
    pub link_2: usize,
    /// Which way force gets from the actuator to the links.
    pub drive: Drive,
    /// Least and greatest length that the stroke allows, m; infinite where nothing is stated.
    pub length: LengthRange,
    /// The link whose mass in the URDF already contains the actuator's sprung mass `m_p`, if one does. The
    /// coupling puts `m_p` at the screw side, so it must first be taken out there (at the attachment point).
    pub sprung_mass_in: Option<usize>,
}

/// How an actuator acts on the links.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// A rod between two points: length is their distance.
    Linear {
        /// Attachment on link 1 (spring side) in its frame, m.
        point_1: Point3<f64>,
        /// Attachment on link 2 (screw side) in its frame, m.
        point_2: Point3<f64>,
    },
    /// The screw drives the tracer of an inverted Hoekens linkage, whose crank turns with a joint.
    Hoekens(HoekensMount),
    /// The joint follows its command rigidly: no spring, no force to be read.
    RigidPosition {
        /// Index of the joint.
        joint: usize,
    },
}

/// An inverted Hoekens linkage about a joint.
///
/// The linkage's ground belongs to link 1, which also carries the actuator; its crank turns with link 2.
/// The crank's angle against the middle of its straight range is `psi = psi_0 + sign q`, and the length is
/// `x = length_mid + travel(psi)` with the tracer's travel along its line, zero in the middle, growing
/// with `psi`. The two links feel the joint's torque `F dx/dq` only: all other forces close in the linkage.
/// The line from `point_1` along `axis_1` places the actuator for drawing and for the weight of its sprung
/// mass; where the tracer's line lies against the joint does not enter.
#[derive(Debug, Clone, PartialEq)]
pub struct HoekensMount {
    /// Index of the joint that the crank turns with.
    pub joint: usize,
    /// The linkage, from the actuator's file.
    pub linkage: Hoekens,
    /// Crank angle from the middle of the straight range at joint position zero, rad.
    pub crank_angle_at_zero_rad: f64,
    /// +1 if positive joint motion lengthens the actuator, -1 if it shortens it.
    pub sign: f64,
    /// Length at the middle of the range, from the spring side's attachment to the tracer, m.
    pub length_mid_m: f64,
    /// Attachment of the spring on link 1 in its frame, m: for drawing, and for where the sprung mass is.
    pub point_1: Point3<f64>,
    /// Direction of the actuator from the spring to the tracer, in link 1.
    pub axis_1: Unit<Vector3<f64>>,
}

/// Between which lengths an actuator can be, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthRange {
    /// Least length, m.
    pub min_m: f64,
    /// Greatest length, m.
    pub max_m: f64,
}

impl LengthRange {
    /// Any length.
    pub const ANY: Self = Self { min_m: 0.0, max_m: f64::INFINITY };

    /// Whether the length is allowed.
    #[must_use]
    pub fn contains(&self, length_m: f64) -> bool {
        (self.min_m..=self.max_m).contains(&length_m)
    }
}
