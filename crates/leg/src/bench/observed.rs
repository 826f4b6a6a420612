//! A robot under an observer: its joints are pulled to their measured motion, and what that takes is what the model lacks.
//!
//! The pull is an acceleration, critically damped, turned into torques by the mass matrix: joints then do not feel one
//! another's pull, however their inertias couple.

use super::simulate::JointTrace;
use sealegs_actuator::plant::{Grid, ReferenceMotion, pull_at, rigid_observer_rate, sample, smoothed};
use sealegs_model::Record;
use std::sync::{Arc, Mutex, PoisonError};

/// The measured motion of the joints in some records.
#[derive(Debug)]
pub(super) struct Observed {
    /// By the records' names; joint by joint.
    runs: Vec<(String, Vec<ReferenceMotion>)>,
    /// Natural frequency of the pull, rad/s; as fast as shows what is missing where none is given.
    rate: Option<f64>,
    /// The same on grids: every simulation asks for them again.
    on_grids: Mutex<Vec<OnGrid>>,
}

/// A record's name, the bits of the step and the steps of its grid, and the pulls there.
type OnGrid = ((String, u64, usize), Arc<Pulls>);

/// The pulls on all joints over a run.
#[derive(Debug)]
pub(super) struct Pulls {
    /// Measured motion on the grid, joint by joint, rad.
    to: Vec<ReferenceMotion>,
    /// Measured speed at the time stamps, joint by joint, rad/s.
    speed_at_samples: Vec<Vec<f64>>,
    /// Natural frequency, rad/s.
    rate: f64,
}

impl Observed {
    /// What can be followed of some records, by the joints' position channels, at a natural frequency (rad/s) of its own
    /// where one is given; `None` unless each measured them all.
    pub fn of(records: &[&Record], channels: &[String], rate: Option<f64>) -> Option<Self> {
        let of_record = |record: &&Record| {
            let motion = |c: &String| Some(smoothed(&record.time_s, record.output(c)?));
            Some((record.name.clone(), channels.iter().map(motion).collect::<Option<Vec<_>>>()?))
        };
        let runs = records.iter().map(of_record).collect::<Option<Vec<_>>>()?;
        Some(Self { runs, rate, on_grids: Mutex::default() })
    }

    /// Whether the pull is fast enough to show what is missing.
    pub fn shows_missing(&self) -> bool {
        self.rate.is_none()
    }

    /// The pulls of a record's simulation on a grid; `None` for a record that is not followed.
    pub fn pulls(&self, record: &Record, grid: &Grid) -> Option<Arc<Pulls>> {
        let (_, motions) = self.runs.iter().find(|(name, _)| *name == record.name)?;
        let key = (record.name.clone(), grid.step_s.to_bits(), grid.steps);
        // A thread that panicked while it held the lock leaves whole entries behind.
        let lock = || self.on_grids.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = lock().iter().find(|(k, _)| *k == key) {
            return Some(known.clone());
        }
        let pulls = Arc::new(Pulls {
            to: motions.iter().map(|m| m.on(grid, &record.time_s)).collect(),
            speed_at_samples: motions.iter().map(|m| m.speed.clone()).collect(),
            rate: self.rate.unwrap_or_else(|| rigid_observer_rate(grid.step_s, record.mean_period_s())),
        });
        lock().push((key, pulls.clone()));
        Some(pulls)
    }
}

impl Pulls {
    /// The torques, N m, on some joints over the step from a point of the grid on, for their positions (rad) and speeds (rad/s) in its
    /// middle.
    pub fn torques(
        &self,
        (joints, step): (&[usize], usize),
        (q, v): (&[f64], &[f64]),
        inertia: impl Fn(usize, usize) -> f64,
        torques: &mut [f64],
    ) {
        let middle = |values: &[f64]| 0.5 * (values[step] + values[step + 1]);
        let acceleration = |j: usize| {
            let to = &self.to[joints[j]];
            let (behind, slower) = (middle(&to.position) - q[j], middle(&to.speed) - v[j]);
            self.rate * (self.rate * behind + 2.0 * slower)
        };
        torques.fill(0.0);
        for j in 0..q.len() {
            let a = acceleration(j);
            torques.iter_mut().enumerate().for_each(|(i, torque)| *torque += inertia(i, j) * a);
        }
    }

    /// The torque that the model lacks at a joint, N m, at the record's time stamps: the pull, and what the drive's viscous
    /// damping (N m s/rad) does not feel of it as the joint lags behind its measured motion.
    pub fn missing(
        &self,
        joint: usize,
        trace: &JointTrace,
        damping: f64,
        time_s: &[f64],
        grid: &Grid,
    ) -> Vec<f64> {
        let pull = pull_at(&trace.pulled, grid, time_s);
        let speed = sample(&trace.speed, grid, time_s, 0.0);
        let behind = self.speed_at_samples[joint].iter().zip(&speed).map(|(to, v)| to - v);
        pull.iter().zip(behind).map(|(pull, behind)| pull + damping * behind).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_pulled_torque_is_mass_matrix_times_pulled_acceleration() {
        let still = |at: f64| ReferenceMotion { position: vec![at; 2], speed: vec![0.0; 2] };
        let pulls = Pulls { to: vec![still(1.0), still(0.0)], speed_at_samples: Vec::new(), rate: 10.0 };
        let mass = [[2.0, 0.5], [0.5, 1.0]];
        let mut torques = [0.0; 2];
        pulls.torques((&[0, 1], 0), (&[0.0, 0.0], &[0.0, 3.0]), |i, j| mass[i][j], &mut torques);
        // 100 rad/s^2 on the first joint, -2 * 10 * 3 on the second.
        assert_eq!(torques, [2.0 * 100.0 - 0.5 * 60.0, 0.5 * 100.0 - 60.0]);
    }
}
