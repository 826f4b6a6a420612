//! Where an actuator's force goes: along a rod between two points, or through a linkage to a joint.

use super::curve::{Curve, CurvePoint};
use crate::dynamics::engine::Engine;
use nalgebra::{Point3, Vector3};

/// How length follows from the pose, and what a force along it does to the bodies.
#[derive(Debug, Clone)]
pub(crate) enum Path {
    /// A rod between two points of two bodies (each in its body's frame).
    Rod {
        /// Body and point of link 1.
        end_1: (usize, Point3<f64>),
        /// Body and point of link 2.
        end_2: (usize, Point3<f64>),
    },
    /// A linkage that turns body 2 against its parent; the actuator is mounted in body 1.
    Crank {
        /// Body and mounting point of the spring in link 1, body frame.
        mount: (usize, Point3<f64>),
        /// Direction of the actuator in body 1.
        axis: Vector3<f64>,
        /// The body that the crank turns with.
        body_2: usize,
        /// The parent of body 2, which takes the reaction of the joint torque.
        parent: usize,
        /// Degree of freedom of the joint.
        dof: usize,
        /// Travel over the crank angle.
        curve: Curve,
        /// Crank angle at joint position zero, rad.
        at_zero_rad: f64,
        /// +1 if positive joint motion lengthens.
        sign: f64,
        /// Length at the middle of the range, m.
        length_mid_m: f64,
    },
}

/// The path at one pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    /// Length, m.
    pub length_m: f64,
    /// Rate of the length at the extrapolated velocities, m/s.
    pub rate_m_s: f64,
    /// Direction from link 1 to link 2, world.
    pub direction: Vector3<f64>,
    /// Ends in the world; the second is where the tracer is for a linkage.
    pub ends: [Point3<f64>; 2],
    /// `d length / d joint`, and its derivative; for a linkage only.
    pub arm: CurvePoint,
}

impl Path {
    /// Length, rate and direction at the engine's present state.
    pub fn reach(&self, engine: &Engine) -> Reach {
        match self {
            Self::Rod { end_1, end_2 } => {
                let (b1, b2) = (&engine.states[end_1.0], &engine.states[end_2.0]);
                let (p1, p2) = (b1.pose * end_1.1, b2.pose * end_2.1);
                let between = p2 - p1;
                let length_m = between.norm();
                let direction = between / length_m;
                Reach {
                    length_m,
                    rate_m_s: direction.dot(&(b2.velocity_at(&p2) - b1.velocity_at(&p1))),
                    direction,
                    ends: [p1, p2],
                    arm: CurvePoint { travel_m: 0.0, arm_m: 0.0, arm_slope_m: 0.0 },
                }
            }
            Self::Crank { mount, axis, dof, curve, at_zero_rad, sign, length_mid_m, .. } => {
                let point = curve.at(at_zero_rad + sign * engine.q[*dof]);
                let arm = CurvePoint { arm_m: sign * point.arm_m, ..point };
                let pose = &engine.states[mount.0].pose;
                let direction = pose * axis;
                let p1 = pose * mount.1;
                let length_m = length_mid_m + point.travel_m;
                Reach {
                    length_m,
                    rate_m_s: arm.arm_m * engine.joint_velocity(*dof),
                    direction,
                    ends: [p1, p1 + direction * length_m],
                    arm,
                }
            }
        }
    }

    /// Adds the forces of the actuator to the bodies: `-on_1` along the direction on link 1, `+on_2` on
    /// link 2. Through a linkage, link 2 feels `on_2` as the joint torque `on_2 dx/dq` with its reaction on
    /// the parent, where all other linkage forces close too; what is left over, `on_2 - on_1`, is the force
    /// that a moving sprung mass needs, and acts at the mount.
    pub fn push(&self, engine: &mut Engine, reach: &Reach, on_1: f64, on_2: f64) {
        match self {
            Self::Rod { end_1, end_2 } => {
                engine.add_force(end_1.0, &(reach.direction * -on_1), &reach.ends[0]);
                engine.add_force(end_2.0, &(reach.direction * on_2), &reach.ends[1]);
            }
            Self::Crank { mount, body_2, parent, .. } => {
                let torque = engine.joint_axis(*body_2) * (reach.arm.arm_m * on_2);
                engine.add_torque(*body_2, &torque);
                engine.add_torque(*parent, &-torque);
                engine.add_force(mount.0, &(reach.direction * (on_2 - on_1)), &reach.ends[0]);
            }
        }
    }

    /// The gradient of the length with respect to the engine's coordinates: the moment arms.
    pub fn gradient(&self, engine: &Engine, reach: &Reach, out: &mut [f64]) {
        match self {
            Self::Rod { end_1, end_2 } => engine.length_gradient(
                (end_1.0, &reach.ends[0]),
                (end_2.0, &reach.ends[1]),
                &reach.direction,
                out,
            ),
            Self::Crank { dof, .. } => {
                out.fill(0.0);
                out[engine.column(*dof)] = reach.arm.arm_m;
            }
        }
    }
}
