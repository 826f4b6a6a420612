//! Series elastic actuators between the links: forces on both links, rotors in lockstep with the engine.
//!
//! With `u` the direction from link 1 (spring side) to link 2 (screw side), `x` the length, `y` the screw's
//! extension, and everything positive as in the dissertation's chapter 4 (compression positive):
//!
//! ```text
//! spring       F_k = k (y - (x - x_rest))
//! rotor        (J/r^2 + m_p) y'' = F_m - b y' - F_k + m_p u.(a_2 - g)
//! link 1       -F_k u          link 2   +(F_k + m_p y'') u
//! load cells   F_1 = F_k       F_2 = F_k + m_p y'' - m_p u.(a_2 - g)
//! ```
//!
//! The sprung mass `m_p` of a sprung motor housing (SMH) is at `x_p = x_2 - y` along the axis; its absolute
//! inertia and weight come from a point mass `m_p` at link 2's attachment, which is in the engine's mass
//! properties. `a_2` is that attachment's acceleration one step ago: a term of 0.2 % in the rotor alone,
//! zero in free fall, so that nothing can go unstable for a light foot. A sprung ball nut (SBN) is the mirror
//! image: `x_r = x_1 + y`, point mass at link 1, `F_1 = F_k + m_r y'' + m_r u.(a_1 - g)` and `F_2 = F_k`.
//! The conventional lumped model has `m_T (F_k-deflection)'' = F_m - b y' - F_k`, `F_1 = F_k` and
//! `F_2 = F_m - b y'`: its mass has neither weight nor absolute acceleration, and its reaction goes nowhere.
//!
//! A linkage drive (inverted Hoekens) puts the joint torque `F_2 dx/dq` on link 2 and its reaction on the
//! parent. Its actuator is mounted in link 1, so that the sprung mass is a point mass of link 1 at the mount;
//! the part of its inertia that goes with the joint's acceleration, `m_p (dx/dq)^2`, is set as the engine's
//! armature of that joint, the mount's acceleration along the axis is taken one step late.
//!
//! A compliance between screw and link 2 adds a coordinate to a sprung motor housing: see `screw_end`.
//!
//! Modelling choice: across the axis the sprung mass of a rod sits at the screw side's attachment. Put half
//! way along the actuator instead, the peak ground force of a drop is 9 % lower.

mod actuator;
mod curve;
mod links;
mod path;
mod rotor;
mod screw_end;

pub use actuator::ActuatorInstant;
pub(crate) use actuator::{Actuator, ActuatorPower, ActuatorStart};
pub(crate) use links::{KnownLinks, KnownPath};
pub(crate) use path::Reach;
pub(crate) use screw_end::carries_series;

use crate::dynamics::engine::Engine;
use crate::dynamics::tree::Tree;
use crate::robot::{Drive, Placement, Robot};
use curve::Curve;
use nalgebra::{Point3, Vector3};
use path::Path;
use sealegs_actuator::{ActuatorError, Coefficients, Configuration};

/// Puts a sprung mass where the engine is to carry it: at the screw side's attachment of a rod, at the mount
/// of a linkage drive. Links that contained it have been freed of it before
/// ([`Robot::without_sprung_masses`]). The lumped model leaves masses where they are.
pub(crate) fn place_sprung_mass(tree: &mut Tree, placement: &Placement, coefficients: &Coefficients) {
    let m = coefficients.sprung_mass;
    let at: Option<(usize, Point3<f64>)> = match (&placement.drive, coefficients.configuration) {
        (_, Configuration::Lumped) | (Drive::RigidPosition { .. }, _) => None,
        (Drive::Linear { point_2, .. }, Configuration::SprungMotorHousing) => {
            Some((placement.link_2, *point_2))
        }
        (Drive::Linear { point_1, .. }, _) => Some((placement.link_1, *point_1)),
        (Drive::Hoekens(mount), _) => Some((placement.link_1, mount.point_1)),
    };
    let Some((link, point)) = at else { return };
    tree.add_point_mass(link, m, &point);
}

impl Actuator {
    /// The actuator of a placement that is no rigid position drive; `None` for one that is.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::LinkageOpen`] if the linkage does not close.
    pub fn place(
        robot: &Robot,
        tree: &Tree,
        placement: &Placement,
        coefficients: Coefficients,
        engine: &Engine,
    ) -> Result<Option<Self>, ActuatorError> {
        let path = match &placement.drive {
            Drive::RigidPosition { .. } => return Ok(None),
            Drive::Linear { point_1, point_2 } => Path::Rod {
                end_1: tree.in_body(placement.link_1, point_1),
                end_2: tree.in_body(placement.link_2, point_2),
            },
            Drive::Hoekens(mount) => {
                let joint = &robot.joints[mount.joint];
                let (body_2, _) = tree.links[joint.child];
                let (parent, _) = tree.links[joint.parent];
                let (body_1, body_from_link) = tree.links[placement.link_1];
                let curve = Curve::of(&mount.linkage)?;
                Path::Crank {
                    mount: (body_1, body_from_link * mount.point_1),
                    axis: body_from_link * mount.axis_1.into_inner(),
                    body_2,
                    parent,
                    dof: joint.dof.unwrap_or_default(),
                    curve,
                    at_zero_rad: mount.crank_angle_at_zero_rad,
                    sign: mount.sign,
                    length_mid_m: mount.length_mid_m,
                }
            }
        };
        Ok(Some(Self::new(coefficients, path, engine)))
    }

    /// Speed of the screw, extrapolated to the time of the poses, m/s.
    pub fn screw_speed(&self) -> f64 {
        self.rotor.speed_now()
    }

    /// The gradient of the length: moment arms over the engine's coordinates.
    pub fn gradient(&self, engine: &Engine, out: &mut [f64]) {
        self.path.gradient(engine, &self.reach, out);
    }
}

/// Gravity as a vector, m/s^2.
pub(crate) fn gravity_vector(gravity_m_s2: f64) -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -gravity_m_s2)
}
