//! The scenario's controller once more: joint-space PD through the moment arms, by the nominal leg's numbers.
//!
//! Stiffness acts on joint positions, damping on the joint speeds that the screws' speeds stand for. Like a robot's
//! firmware it knows the nominal torque constants, dampings, inertias, masses and spring settings, not the true ones.

use super::setup::LegReference;
use nalgebra::{DMatrix, DVector, Isometry3, Point3};
use sealegs_leg::LegError;
use sealegs_leg::robot::{Drive, Robot};
use sealegs_leg::scenario::ControllerKind;

/// Singular values below this share of the greatest are none: m/rad.
const LEAST_ARM_M: f64 = 1e-6;

/// The smallest solution of `matrix x = right` that comes nearest.
fn nearest(matrix: DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let columns = matrix.ncols();
    // Both factors are asked for: there is nothing else to fail at.
    matrix.svd(true, true).solve(right, LEAST_ARM_M).unwrap_or_else(|_| DVector::zeros(columns))
}

impl LegReference {
    /// Joint torques (N m) by gravity on a robot that hangs from its base.
    fn weight(&self, robot: &Robot, q: &[f64]) -> DVector<f64> {
        let posture = robot.posture(&Isometry3::identity(), q);
        let mut weights: Vec<(usize, f64, Point3<f64>)> = Vec::new();
        for (link, own) in robot.links.iter().enumerate() {
            if let Some(own) = &own.inertial {
                weights.push((link, own.mass_kg, posture.point(link, &own.com)));
            }
        }
        for (placement, part) in robot.actuators.iter().zip(&self.parts) {
            let (link, point) = match &placement.drive {
                Drive::Linear { point_2, .. } => (placement.link_2, point_2),
                Drive::Hoekens(mount) => (placement.link_1, &mount.point_1),
                Drive::RigidPosition { .. } => continue,
            };
            weights.push((link, part.sprung, posture.point(link, point)));
        }
        let mut torques = DVector::zeros(robot.dofs);
        for (carried_by, mass, at) in weights {
            let mut link = carried_by;
            while link > 0 {
                let joint = &robot.joints[link - 1];
                if let Some(dof) = joint.dof {
                    let pose = &posture.world_from_link[joint.child];
                    let axis = pose.rotation * joint.axis.into_inner();
                    let arm = at - Point3::from(pose.translation.vector);
                    torques[dof] += mass * self.gravity.dot(&axis.cross(&arm));
                }
                link = joint.parent;
            }
        }
        torques
    }

    /// The spring forces (N, compression positive) that carry the leg's weight at the start.
    pub(super) fn balanced(&self) -> Result<DVector<f64>, LegError> {
        let arms = self.robot.moment_arms(&self.start_q)?;
        Ok(nearest(arms.transpose(), &-self.weight(&self.robot, &self.start_q)))
    }

    /// The commanded currents, A, at a time (s), from joint positions (rad) and the screws' speeds (m/s).
    pub(super) fn command(&self, t: f64, q: &[f64], screw_speeds: &[f64]) -> Result<Vec<f64>, LegError> {
        let forces = match self.scenario.controller.kind {
            ControllerKind::Free => DVector::zeros(self.parts.len()),
            ControllerKind::Pd => self.pd(t, q, screw_speeds)?,
        };
        let current = |(i, name): (usize, &str)| {
            let added = self.scenario.current.get(name).map_or(0.0, |profile| profile.at(t));
            let wanted = forces[i] / self.known[i].force_per_command + added;
            wanted.clamp(-self.limits_a[i], self.limits_a[i])
        };
        Ok(self.actuators().enumerate().map(current).collect())
    }

    fn pd(&self, t: f64, q: &[f64], screw_speeds: &[f64]) -> Result<DVector<f64>, LegError> {
        let spec = &self.scenario.controller;
        let arms = self.known_robot.moment_arms(q)?;
        let seen = nearest(arms.clone(), &DVector::from_column_slice(screw_speeds));
        let dofs = self.robot.dofs;
        let (mut torques, mut speeds, mut accelerations) =
            (DVector::zeros(dofs), DVector::zeros(dofs), DVector::zeros(dofs));
        for (dof, joint) in self.robot.moving_joints().enumerate() {
            let own = spec.joints.get(&joint.name).copied().unwrap_or_default();
            let posture = self.start_q[dof];
            let motion = self.scenario.motion.get(&joint.name);
            let [position, speed, acceleration] = motion.map_or([posture, 0.0, 0.0], |m| m.at(t, posture));
            torques[dof] = own.stiffness_nm_rad.unwrap_or(spec.stiffness_nm_rad) * (position - q[dof])
                + own.damping_nm_s_rad.unwrap_or(spec.damping_nm_s_rad) * (speed - seen[dof]);
            (speeds[dof], accelerations[dof]) = (speed, acceleration);
        }
        if spec.gravity_compensation {
            torques -= self.weight(&self.known_robot, q);
        }
        let mut forces = nearest(arms.transpose(), &torques);
        if spec.feed_forward {
            let (rates, changes) = (&arms * speeds, &arms * accelerations);
            for (i, c) in self.known.iter().enumerate() {
                forces[i] += c.damping * rates[i] + c.rotor * changes[i];
            }
        }
        Ok(forces)
    }
}
