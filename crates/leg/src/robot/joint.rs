//! Joints: what moves against what, how far, and with what passive losses.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

/// What a joint allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Nothing.
    Fixed,
    /// Turning about the axis between limits.
    Revolute,
    /// Turning about the axis without limits.
    Continuous,
    /// Sliding along the axis between limits.
    Prismatic,
}

/// A joint between two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// What it allows.
    pub kind: JointKind,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// `parent_from_child` at joint position zero.
    pub origin: Isometry3<f64>,
    /// Axis in the child's frame (which has the joint's origin and directions).
    pub axis: Unit<Vector3<f64>>,
    /// Position, effort and speed limits.
    pub limits: JointLimits,
    /// Viscous loss, N m s/rad or N s/m.
    pub damping: f64,
    /// Coulomb friction, N m or N.
    pub friction: f64,
    /// Index of its degree of freedom in vectors of joint positions; `None` if fixed.
    pub dof: Option<usize>,
}

/// Limits of a joint; infinite where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// Least position, rad or m.
    pub lower: f64,
    /// Greatest position, rad or m.
    pub upper: f64,
    /// Greatest effort, N m or N.
    pub effort: f64,
    /// Greatest speed, rad/s or m/s.
    pub velocity: f64,
}

impl JointLimits {
    /// No limit at all.
    pub const NONE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        effort: f64::INFINITY,
        velocity: f64::INFINITY,
    };

    /// Whether the position lies between the limits.
    #[must_use]
    pub fn contain(&self, position: f64) -> bool {
        (self.lower..=self.upper).contains(&position)
    }
}

impl Joint {
    /// `parent_from_child` at joint position `q` (rad or m; without effect on a fixed joint).
    #[must_use]
    pub fn parent_from_child(&self, q: f64) -> Isometry3<f64> {
        match self.kind {
            JointKind::Fixed => self.origin,
            JointKind::Revolute | JointKind::Continuous => {
                self.origin * UnitQuaternion::from_axis_angle(&self.axis, q)
            }
            JointKind::Prismatic => self.origin * Translation3::from(self.axis.into_inner() * q),
        }
    }
}
