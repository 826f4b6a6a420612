//! What an actuator needs of the links that it lies between: the engine's, or links whose motion is known.

use super::path::{Path, Reach};
use crate::dynamics::engine::Engine;
use nalgebra::{Point3, Vector3};
use std::sync::Arc;

/// The links of an actuator.
pub(crate) trait Links {
    /// The path at the present pose.
    fn reach(&self, path: &Path) -> Reach;
    /// Velocity of a joint at the time of the pose, rad/s.
    fn joint_velocity(&self, dof: usize) -> f64;
    /// How a body's point yields to a force along a direction, m/s^2 per N.
    fn mobility(&self, body: usize, point: &Point3<f64>, direction: &Vector3<f64>) -> f64;
    /// Sets the inertia added to a joint, kg m^2.
    fn set_armature(&mut self, dof: usize, inertia: f64);
    /// Puts the forces on link 1 and link 2 along the path, N.
    fn push(&mut self, path: &Path, reach: &Reach, on_1: f64, on_2: f64);
    /// Accelerations of the sprung mass' attachment and of the length one point ago, m/s^2, where they are known better
    /// than by differences of three poses.
    fn known_accelerations(&self) -> Option<(Vector3<f64>, f64)> {
        None
    }
}

impl Links for Engine {
    fn reach(&self, path: &Path) -> Reach {
        path.reach(self)
    }

    fn joint_velocity(&self, dof: usize) -> f64 {
        Self::joint_velocity(self, dof)
    }

    fn mobility(&self, body: usize, point: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
        Self::mobility(self, body, point, direction)
    }

    fn set_armature(&mut self, dof: usize, inertia: f64) {
        Self::set_armature(self, dof, inertia);
    }

    fn push(&mut self, path: &Path, reach: &Reach, on_1: f64, on_2: f64) {
        path.push(self, reach, on_1, on_2);
    }
}

/// An actuator's path along a motion that is known, at every point of a grid and one beyond.
#[derive(Debug, Clone, Default)]
pub(crate) struct KnownPath {
    /// The path at each point.
    pub reaches: Vec<Reach>,
    /// Velocity of the joint that a linkage turns, rad/s.
    pub joint_speeds: Vec<f64>,
    /// Where the sprung mass is attached, m.
    pub attachments: Vec<Point3<f64>>,
    /// Accelerations of that point and of the length, m/s^2.
    pub accelerations: Vec<(Vector3<f64>, f64)>,
}

impl KnownPath {
    /// Finds the accelerations by parabolas over so many points to each side: three points of a measured motion would
    /// show the encoders' counts.
    pub fn find_accelerations(&mut self, half: usize, step_s: f64) {
        let of = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let values: Vec<f64> = (0..self.reaches.len()).map(value).collect();
            second_derivatives(&values, half, step_s)
        };
        let [x, y, z] = [0, 1, 2].map(|k| of(&|i| self.attachments[i][k]));
        let length = of(&|i| self.reaches[i].length_m);
        self.accelerations = (0..length.len()).map(|i| (Vector3::new(x[i], y[i], z[i]), length[i])).collect();
    }
}

/// Second derivatives by least squares over so many points to each side, fewer at the ends.
fn second_derivatives(values: &[f64], half: usize, step: f64) -> Vec<f64> {
    let last = values.len() - 1;
    (0..=last)
        .map(|i| {
            let half = half.min(i).min(last - i).max(1).min(last / 2);
            let middle = i.clamp(half, last - half);
            let mean = (half * (half + 1)) as f64 / 3.0;
            let (mut sum, mut norm) = (0.0, 0.0);
            for j in middle - half..=middle + half {
                let weight = (j as f64 - middle as f64).powi(2) - mean;
                sum += weight * (values[j] - values[middle]);
                norm += weight * weight;
            }
            2.0 * sum / (norm * step * step)
        })
        .collect()
}

/// Links that move as they are known to, whatever pushes on them.
#[derive(Debug, Clone)]
pub(crate) struct KnownLinks {
    pub path: Arc<KnownPath>,
    /// The present point of the grid.
    pub point: usize,
    /// How much longer the path is at each point than it was measured, m; empty where nothing is known of that.
    pub longer_m: Vec<f64>,
}

impl Links for KnownLinks {
    fn reach(&self, _path: &Path) -> Reach {
        let mut reach = self.path.reaches[self.point];
        reach.length_m += self.longer_m.get(self.point).copied().unwrap_or(0.0);
        reach
    }

    fn joint_velocity(&self, _dof: usize) -> f64 {
        self.path.joint_speeds[self.point]
    }

    fn mobility(&self, _body: usize, _point: &Point3<f64>, _direction: &Vector3<f64>) -> f64 {
        0.0
    }

    fn set_armature(&mut self, _dof: usize, _inertia: f64) {}

    fn push(&mut self, _path: &Path, _reach: &Reach, _on_1: f64, _on_2: f64) {}

    fn known_accelerations(&self) -> Option<(Vector3<f64>, f64)> {
        self.path.accelerations.get(self.point.saturating_sub(1)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::second_derivatives;

    #[test]
    fn analytic_a_parabola_has_its_second_derivative_everywhere() {
        let values: Vec<f64> = (0..40).map(|i| 2.0 - 0.3 * f64::from(i) + 0.05 * f64::from(i * i)).collect();
        for (i, a) in second_derivatives(&values, 6, 0.1).into_iter().enumerate() {
            assert!((a - 10.0).abs() < 1e-9, "{i}: {a}");
        }
    }
}
