//! Who commands the motors: joint-space PD through the actuators' moment arms, and current profiles.
//!
//! Stiffness acts on the joint's position. Damping acts on the joint speeds that the motors stand for (their
//! screw speeds through the moment arms), not on the joints' own: seen through the springs, damping of a
//! light foot's own speed would be unstable. With the spring's stiffness `k_q` at the joint, position feedback
//! is stable below `k_q` whatever the link's inertia (Routh's criterion on motor, spring and link).
//!
//! The command is found at the controller's rate and holds in between. Joint torques are shared out to the
//! actuators so that `A^T F` comes nearest to the wanted torques, `A` being the matrix of moment arms; the
//! motor force `F` becomes the current `F r / K_tau`, clipped at the limit.

use crate::LegError;
use crate::dynamics::coupling::Actuator;
use crate::dynamics::engine::Engine;
use crate::robot::Inertial;
use crate::scenario::{ControllerKind, Motion, Scenario};
use crate::simulation::LegDescription;
use nalgebra::{DMatrix, DVector};
use sealegs_actuator::Coefficients;
use sealegs_actuator::excitation::Profile;

/// The forces along the actuators that come nearest to the joint torques, the smallest such forces where
/// several do: `(A A^T) F = A tau`.
pub(crate) fn share_out(arms: &DMatrix<f64>, torques: &DVector<f64>) -> DVector<f64> {
    let mut square = arms * arms.transpose();
    // Two actuators that do the same to all joints share the work instead of dividing by zero.
    let small = 1e-9 * square.trace().max(1e-300);
    for i in 0..square.nrows() {
        square[(i, i)] += small;
    }
    let right = arms * torques;
    square.cholesky().map_or_else(|| DVector::zeros(arms.nrows()), |c| c.solve(&right))
}

/// The joint speeds that the screws' speeds stand for, the smallest where several do: `A q' = y'`.
fn seen_at_joints(arms: &DMatrix<f64>, actuators: &[Actuator]) -> DVector<f64> {
    let rates = DVector::from_iterator(actuators.len(), actuators.iter().map(Actuator::screw_speed));
    let mut square = arms * arms.transpose();
    let small = 1e-9 * square.trace().max(1e-300);
    for i in 0..square.nrows() {
        square[(i, i)] += small;
    }
    square.cholesky().map_or_else(|| DVector::zeros(arms.ncols()), |c| arms.transpose() * c.solve(&rates))
}

/// The moment arms of the actuators over the robot's degrees of freedom.
pub(crate) fn moment_arms(engine: &Engine, actuators: &[Actuator], dofs: usize) -> DMatrix<f64> {
    let mut row = vec![0.0; engine.coordinates()];
    let mut arms = DMatrix::zeros(actuators.len(), dofs);
    for (i, actuator) in actuators.iter().enumerate() {
        actuator.gradient(engine, &mut row);
        for dof in 0..dofs {
            arms[(i, dof)] = row[engine.column(dof)];
        }
    }
    arms
}

/// One joint's wanted motion and gains.
#[derive(Debug, Clone)]
struct JointCommand {
    posture: f64,
    motion: Option<Motion>,
    /// Recorded positions in place of a motion: times, s, and rad.
    given: Option<(Vec<f64>, Vec<f64>)>,
    stiffness: f64,
    damping: f64,
}

impl JointCommand {
    /// Where the joint is to be at a time, with speed and acceleration: rad, rad/s, rad/s^2. Between recorded
    /// positions it goes straight, at both ends it rests.
    fn wanted(&self, time_s: f64) -> [f64; 3] {
        let Some((times, positions)) = &self.given else {
            return self.motion.map_or([self.posture, 0.0, 0.0], |m| m.at(time_s, self.posture));
        };
        let after = times.partition_point(|t| *t <= time_s);
        match (after.checked_sub(1), positions.get(after)) {
            (Some(before), Some(next)) => {
                let slope = (next - positions[before]) / (times[after] - times[before]);
                [positions[before] + slope * (time_s - times[before]), slope, 0.0]
            }
            (Some(last), None) => [positions[last], 0.0, 0.0],
            (None, first) => [first.copied().unwrap_or(self.posture), 0.0, 0.0],
        }
    }
}

/// The controller of a run.
#[derive(Debug)]
pub(crate) struct Controller {
    kind: ControllerKind,
    /// Steps between two commands.
    every: usize,
    gravity_compensation: bool,
    feed_forward: bool,
    joints: Vec<JointCommand>,
    profiles: Vec<Option<Profile>>,
    limits_a: Vec<f64>,
    /// The actuators' numbers as the controller knows them.
    known: Vec<Coefficients>,
    /// The bodies as it knows them, where they are others.
    known_bodies: Option<Vec<Option<Inertial>>>,
    /// The commanded currents that hold now, A.
    pub currents_a: Vec<f64>,
    /// Which of them are clipped.
    pub saturated: Vec<bool>,
}

impl Controller {
    /// The controller of a scenario for a leg. It knows the actuators as their files and spring settings state
    /// them, not as the single one in the leg is, and the bodies as `known_bodies` where that is given.
    pub fn new(
        scenario: &Scenario,
        leg: &LegDescription,
        start_q: &[f64],
        known_bodies: Option<Vec<Option<Inertial>>>,
    ) -> Result<Self, LegError> {
        let spec = &scenario.controller;
        let joints = leg
            .robot
            .moving_joints()
            .zip(start_q)
            .map(|(joint, &posture)| {
                let own = spec.joints.get(&joint.name).copied().unwrap_or_default();
                JointCommand {
                    posture,
                    motion: scenario.motion.get(&joint.name).copied(),
                    given: None,
                    stiffness: own.stiffness_nm_rad.unwrap_or(spec.stiffness_nm_rad),
                    damping: own.damping_nm_s_rad.unwrap_or(spec.damping_nm_s_rad),
                }
            })
            .collect();
        let mut profiles = Vec::new();
        for name in leg.actuators.iter().map(|a| &a.name) {
            profiles.push(match (scenario.current.get(name), scenario.current_file.get(name)) {
                (Some(profile), None) => Some(profile.clone()),
                (None, None) => None,
                (None, Some(from)) => {
                    let path = scenario.folder.as_deref().map_or_else(
                        || std::path::PathBuf::from(&from.file),
                        |folder| folder.join(&from.file),
                    );
                    let file = path.display().to_string();
                    let text = std::fs::read_to_string(&path)
                        .map_err(|source| LegError::Io { path: file.clone(), source })?;
                    Some(Profile::table_from_csv(&text, &from.column, from.linear, &file)?)
                }
                (Some(_), Some(_)) => {
                    let field = format!("current_file.{name}");
                    let problem = "the actuator has a profile in [current] already".to_owned();
                    return Err(LegError::scenario(&scenario.name, &field, problem));
                }
            });
        }
        let limit = spec.current_limit_a.unwrap_or(f64::INFINITY);
        Ok(Self {
            kind: spec.kind,
            every: (1.0 / (spec.rate_hz * scenario.step_s)).round().max(1.0) as usize,
            gravity_compensation: spec.gravity_compensation,
            feed_forward: spec.feed_forward,
            joints,
            profiles,
            limits_a: leg.actuators.iter().map(|a| a.current_limit_a.min(limit)).collect(),
            known: leg.actuators.iter().map(|a| a.nominal).collect(),
            known_bodies,
            currents_a: vec![0.0; leg.actuators.len()],
            saturated: vec![false; leg.actuators.len()],
        })
    }

    /// Where a joint is to be at a time, rad.
    pub fn target_rad(&self, dof: usize, time_s: f64) -> f64 {
        self.joints[dof].wanted(time_s)[0]
    }

    /// Wants a joint at recorded positions.
    pub fn give_target(&mut self, dof: usize, time_s: Vec<f64>, position_rad: Vec<f64>) {
        self.joints[dof].given = Some((time_s, position_rad));
    }

    /// Whether a new command is due at this step.
    pub fn due(&self, step: usize) -> bool {
        step.is_multiple_of(self.every)
    }

    /// Finds the command for a time.
    pub fn update(&mut self, time_s: f64, engine: &Engine, actuators: &[Actuator]) {
        let forces = match self.kind {
            ControllerKind::Free => DVector::zeros(actuators.len()),
            ControllerKind::Pd => self.pd(time_s, engine, actuators),
        };
        for i in 0..actuators.len() {
            let by_profile = self.profiles[i].as_ref().map_or(0.0, |p| p.at(time_s));
            let wanted = forces[i] / self.known[i].force_constant + by_profile;
            let limit = self.limits_a[i];
            self.currents_a[i] = wanted.clamp(-limit, limit);
            self.saturated[i] = wanted.abs() > limit;
        }
    }

    fn pd(&self, time_s: f64, engine: &Engine, actuators: &[Actuator]) -> DVector<f64> {
        let dofs = self.joints.len();
        let arms = moment_arms(engine, actuators, dofs);
        let motor_speeds = seen_at_joints(&arms, actuators);
        let weight = match &self.known_bodies {
            Some(bodies) => engine.gravity_forces_of(bodies),
            None => engine.gravity_forces(),
        };
        let (mut torques, mut speeds, mut accelerations) =
            (DVector::zeros(dofs), DVector::zeros(dofs), DVector::zeros(dofs));
        for (dof, joint) in self.joints.iter().enumerate() {
            let [position, speed, acceleration] = joint.wanted(time_s);
            torques[dof] =
                joint.stiffness * (position - engine.q[dof]) + joint.damping * (speed - motor_speeds[dof]);
            if self.gravity_compensation {
                torques[dof] -= weight[engine.column(dof)];
            }
            speeds[dof] = speed;
            accelerations[dof] = acceleration;
        }
        let mut forces = share_out(&arms, &torques);
        if self.feed_forward {
            let (rates, rate_changes) = (&arms * speeds, &arms * accelerations);
            for (i, c) in self.known.iter().enumerate() {
                forces[i] += c.damping * rates[i] + c.reflected_inertia * rate_changes[i];
            }
        }
        forces
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_crossed_pair_shares_out() {
        // Two actuators: both pitch with 0.06 m, they roll with +-0.05 m.
        let arms = DMatrix::from_row_slice(2, 2, &[0.06, 0.05, 0.06, -0.05]);
        let torques = DVector::from_vec(vec![12.0, 5.0]);
        let forces = share_out(&arms, &torques);
        assert!((forces[0] - 150.0).abs() < 1e-6 && (forces[1] - 50.0).abs() < 1e-6, "{forces}");
    }

    #[test]
    fn analytic_twins_share_and_idle_joints_are_left() {
        let arms = DMatrix::from_row_slice(2, 2, &[0.1, 0.0, 0.1, 0.0]);
        let forces = share_out(&arms, &DVector::from_vec(vec![10.0, 99.0]));
        assert!((forces[0] - 50.0).abs() < 1e-4 && (forces[1] - 50.0).abs() < 1e-4, "{forces}");
    }
}
