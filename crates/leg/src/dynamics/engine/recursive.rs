//! The bodies by their equations of motion in the joints' coordinates: a leapfrog of second order.

use super::{Bodies, Jacobian};
use crate::dynamics::equations::{Equations, MovingBodies, solve_with};
use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};

/// Bodies with their state.
pub(super) struct Recursive {
    bodies: MovingBodies,
    equations: Equations,
    q: Vec<f64>,
    v: DVector<f64>,
    /// Inertia added to each coordinate.
    armature: Vec<f64>,
    /// Room for a step's mass matrix and accelerations.
    room: (DMatrix<f64>, DVector<f64>),
    /// Force and torque about the centre of mass on each moving body, world frame.
    forces: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// Of each body of the tree, the base first.
    jacobians: Vec<Jacobian>,
    /// How many bodies of the tree do not move: the base, where it is not on a rail.
    fixed: usize,
    step_s: f64,
}

impl Recursive {
    /// At rest with all coordinates zero. On a rail the first moving body is the base.
    pub fn new(bodies: MovingBodies, rail: bool, step_s: f64) -> Self {
        let (n, fixed) = (bodies.len(), usize::from(!rail));
        let mut recursive = Self {
            equations: bodies.equations(),
            q: vec![0.0; n],
            v: DVector::zeros(n),
            armature: vec![0.0; n],
            room: (DMatrix::zeros(n, n), DVector::zeros(n)),
            forces: vec![Default::default(); n],
            jacobians: vec![Jacobian::zeros(n); n + fixed],
            fixed,
            step_s,
            bodies,
        };
        recursive.place();
        recursive
    }

    /// Index among the moving bodies of a body of the tree; `None` of a base that does not move.
    fn moving(&self, body: usize) -> Option<usize> {
        body.checked_sub(self.fixed)
    }

    fn place(&mut self) {
        self.bodies.place(&self.q, &mut self.equations);
        self.bodies.write_columns(&mut self.equations);
        for (body, jacobian) in self.jacobians.iter_mut().skip(self.fixed).enumerate() {
            for (column, linear, turning) in self.equations.columns(body) {
                jacobian.fixed_view_mut::<3, 1>(0, *column).copy_from(linear);
                jacobian.fixed_view_mut::<3, 1>(3, *column).copy_from(turning);
            }
        }
    }
}

impl Bodies for Recursive {
    fn clear_forces(&mut self) {
        self.forces.fill(Default::default());
    }

    fn add_force(&mut self, body: usize, force: &Vector3<f64>, point: &Point3<f64>) {
        let Some(body) = self.moving(body) else { return };
        let (sum, torque) = &mut self.forces[body];
        *sum += force;
        *torque += (point.coords - self.equations.com(body)).cross(force);
    }

    fn add_torque(&mut self, body: usize, torque: &Vector3<f64>) {
        if let Some(body) = self.moving(body) {
            self.forces[body].1 += torque;
        }
    }

    fn set_armature(&mut self, column: usize, inertia: f64) {
        self.armature[column] = inertia;
    }

    fn displace(&mut self, displacement: &[f64], velocity: &DVector<f64>) {
        self.q.iter_mut().zip(displacement).for_each(|(q, d)| *q += d);
        self.v.copy_from(velocity);
        self.place();
    }

    fn step(&mut self, speed: &DVector<f64>) {
        self.bodies.set_in_motion(speed.as_slice(), &mut self.equations);
        let (mass, accelerations) = &mut self.room;
        accelerations.iter_mut().zip(&self.equations.bias).for_each(|(a, bias)| *a = -bias);
        for (body, (force, torque)) in self.forces.iter().enumerate() {
            for (column, linear, turning) in self.equations.columns(body) {
                accelerations[*column] += linear.dot(force) + turning.dot(torque);
            }
        }
        mass.clone_from(&self.equations.mass);
        self.armature.iter().enumerate().for_each(|(i, inertia)| mass[(i, i)] += inertia);
        if !solve_with(mass, |factor| factor.solve_mut(accelerations)) {
            // What is not a number any more is found by whoever watches the run.
            accelerations.fill(f64::NAN);
        }
        self.v.axpy(self.step_s, accelerations, 1.0);
        self.q.iter_mut().zip(&self.v).for_each(|(q, v)| *q += v * self.step_s);
        self.place();
    }

    fn velocity(&self, out: &mut DVector<f64>) {
        out.copy_from(&self.v);
    }

    fn column(&self, body: usize) -> usize {
        self.moving(body).unwrap_or_default()
    }

    fn position(&self, body: usize) -> f64 {
        self.moving(body).map_or(0.0, |i| self.q[i])
    }

    fn pose(&self, body: usize) -> Isometry3<f64> {
        *self.moving(body).map_or(self.bodies.base(), |moving| self.equations.pose(moving))
    }

    fn jacobian(&self, body: usize) -> &Jacobian {
        &self.jacobians[body]
    }

    #[cfg(test)]
    fn own_forces(&self) -> Vec<String> {
        let added = self.armature.iter().any(|inertia| *inertia != 0.0);
        added.then(|| "armature".to_owned()).into_iter().collect()
    }
}
