//! Where links and attachment points are at given joint positions, how long actuators are, and their moment
//! arms, without the physics engine: for checks, controllers and tests.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Unit, Vector3};

use super::{Drive, Joint, JointKind, LengthRange, Robot, RobotFault};
use crate::LegError;

/// The pose of every link at given joint positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// `world_from_link` by link index.
    pub world_from_link: Vec<Isometry3<f64>>,
}

/// Length and moment arms of one actuator at given joint positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Lever {
    /// Length from link 1 to link 2, m. For a rigid position drive the joint's position, rad or m.
    pub length_m: f64,
    /// `d length / d q_j` by degree of freedom, m/rad or m/m: the actuator's compressive force times this is
    /// the joint's torque. For a rigid position drive 1 at its joint.
    pub arms: DVector<f64>,
}

impl Posture {
    /// A point of a link in the world, m.
    #[must_use]
    pub fn point(&self, link: usize, point: &Point3<f64>) -> Point3<f64> {
        self.world_from_link[link] * point
    }
}

impl Robot {
    /// The pose of every link with the base at `world_from_base` and the joints at `q` (by degree of freedom,
    /// rad or m).
    ///
    /// # Panics
    ///
    /// If `q` is shorter than the number of degrees of freedom.
    #[must_use]
    pub fn posture(&self, world_from_base: &Isometry3<f64>, q: &[f64]) -> Posture {
        let mut world_from_link = Vec::with_capacity(self.links.len());
        world_from_link.push(*world_from_base);
        for joint in &self.joints {
            let position = joint.dof.map_or(0.0, |dof| q[dof]);
            world_from_link.push(world_from_link[joint.parent] * joint.parent_from_child(position));
        }
        Posture { world_from_link }
    }

    /// The two ends of an actuator's axis in the world, m: the spring side on link 1, then the screw side on
    /// link 2 (the tracer of a Hoekens linkage). `None` for a rigid position drive.
    ///
    /// # Errors
    ///
    /// [`LegError::Actuator`] if a linkage does not close at this posture.
    pub fn attachment(
        &self,
        actuator: usize,
        posture: &Posture,
        q: &[f64],
    ) -> Result<Option<[Point3<f64>; 2]>, LegError> {
        let placement = &self.actuators[actuator];
        Ok(match &placement.drive {
            Drive::Linear { point_1, point_2 } => {
                Some([posture.point(placement.link_1, point_1), posture.point(placement.link_2, point_2)])
            }
            Drive::Hoekens(mount) => {
                let length = self.lever(actuator, q)?.length_m;
                let tracer = mount.point_1 + mount.axis_1.into_inner() * length;
                Some([
                    posture.point(placement.link_1, &mount.point_1),
                    posture.point(placement.link_1, &tracer),
                ])
            }
            Drive::RigidPosition { .. } => None,
        })
    }

    /// Length and moment arms of an actuator.
    ///
    /// # Errors
    ///
    /// [`LegError::Actuator`] if a linkage does not close at this posture.
    ///
    /// # Panics
    ///
    /// If `q` is shorter than the number of degrees of freedom or there is no such actuator.
    pub fn lever(&self, actuator: usize, q: &[f64]) -> Result<Lever, LegError> {
        let placement = &self.actuators[actuator];
        let mut arms = DVector::zeros(self.dofs);
        let length_m = match &placement.drive {
            Drive::Linear { point_1, point_2 } => {
                let posture = self.posture(&Isometry3::identity(), q);
                let p_1 = posture.point(placement.link_1, point_1);
                let p_2 = posture.point(placement.link_2, point_2);
                let axis = Unit::new_normalize(p_2 - p_1);
                // Each joint between the links moves one of the two ends against the other.
                let (mut end_1, mut end_2) = (placement.link_1, placement.link_2);
                while end_1 != end_2 {
                    // Topological order: the higher index cannot be the ancestor.
                    let (end, point, sign) =
                        if end_1 > end_2 { (&mut end_1, &p_1, -1.0) } else { (&mut end_2, &p_2, 1.0) };
                    let joint = &self.joints[*end - 1];
                    if let Some(dof) = joint.dof {
                        arms[dof] = sign * axis.dot(&rate(joint, &posture, point));
                    }
                    *end = joint.parent;
                }
                (p_2 - p_1).norm()
            }
            Drive::Hoekens(mount) => {
                // A fixed joint is not accepted by the placement file.
                let dof = self.joints[mount.joint].dof.unwrap_or(0);
                let angle = mount.crank_angle_at_zero_rad + mount.sign * q[dof];
                arms[dof] = mount.sign * mount.linkage.moment_arm_m(angle)?;
                mount.length_mid_m + mount.linkage.travel_m(angle)?
            }
            Drive::RigidPosition { joint } => {
                let dof = self.joints[*joint].dof.unwrap_or(0);
                arms[dof] = 1.0;
                q[dof]
            }
        };
        Ok(Lever { length_m, arms })
    }

    /// The moment arms of all actuators: a row for each actuator, a column for each degree of freedom.
    ///
    /// # Errors
    ///
    /// Those of [`Robot::lever`].
    pub fn moment_arms(&self, q: &[f64]) -> Result<DMatrix<f64>, LegError> {
        let mut matrix = DMatrix::zeros(self.actuators.len(), self.dofs);
        for i in 0..self.actuators.len() {
            matrix.set_row(i, &self.lever(i, q)?.arms.transpose());
        }
        Ok(matrix)
    }

    /// Whether every actuator can be as long as a posture asks; `posture` names it in the message.
    ///
    /// # Errors
    ///
    /// [`RobotFault::OutOfStroke`] with the actuator and the length, or those of [`Robot::lever`].
    pub fn check_strokes(&self, q: &[f64], posture: &str) -> Result<(), LegError> {
        for (i, placement) in self.actuators.iter().enumerate() {
            if matches!(placement.drive, Drive::RigidPosition { .. }) {
                continue;
            }
            let length_m = self.lever(i, q)?.length_m;
            let LengthRange { min_m, max_m } = placement.length;
            if !placement.length.contains(length_m) {
                return Err(LegError::Robot {
                    file: self.source.placement_name(),
                    line: None,
                    element: format!("actuator '{}'", placement.name),
                    fault: Box::new(RobotFault::OutOfStroke {
                        length_m,
                        min_m,
                        max_m,
                        posture: posture.to_owned(),
                    }),
                });
            }
        }
        Ok(())
    }
}

/// Velocity in the world of a point behind the joint, per unit of joint speed.
fn rate(joint: &Joint, posture: &Posture, point: &Point3<f64>) -> Vector3<f64> {
    let world_from_child = &posture.world_from_link[joint.child];
    let along = world_from_child.rotation * joint.axis.into_inner();
    match joint.kind {
        JointKind::Prismatic => along,
        _ => along.cross(&(point - Point3::from(world_from_child.translation.vector))),
    }
}
