//! Mass matrix and weight of the bodies in the engine.

use super::Engine;
use crate::robot::Inertial;
use nalgebra::{DMatrix, DVector, Matrix6, Point3, Vector3};

impl Engine {
    /// The mass matrix of the bodies at the present poses, in the engine's order (without armature): for
    /// energies at the recorded samples, and where a step needs a [mobility](Engine::mobility).
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let n = self.coordinates();
        let mut mass = DMatrix::zeros(n, n);
        for (i, state) in self.states.iter().enumerate() {
            let j = self.jacobian(i);
            let r = state.pose.rotation.to_rotation_matrix();
            let turned = r * self.inertia[i] * r.transpose();
            let (linear, angular) = (j.fixed_rows::<3>(0), j.fixed_rows::<3>(3));
            mass += linear.transpose() * linear * self.mass_kg[i] + angular.transpose() * turned * angular;
        }
        mass
    }

    /// Acceleration of a body's point along a direction per unit of a force on it in that direction, 1/kg (without
    /// armature).
    pub fn mobility(&self, body: usize, point: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
        let along = self.along(body, point, direction);
        let along = DVector::from_fn(self.coordinates(), |column, _| along(column));
        let factor = self.mass_matrix().cholesky();
        factor.map_or(0.0, |factor| along.dot(&factor.solve(&along)))
    }

    /// Acceleration of a body's centre of mass, linear and angular, per unit of a force on it and of a torque, world frame
    /// (without armature).
    pub fn body_mobility(&self, body: usize) -> Matrix6<f64> {
        let j = self.jacobian(body);
        let factor = self.mass_matrix().cholesky();
        let mobility = factor.map(|factor| j * factor.solve(&j.transpose()));
        mobility.map_or_else(Matrix6::zeros, |w| Matrix6::from_fn(|i, k| w[(i, k)]))
    }

    /// Potential energy of the bodies, zero at world height 0, J.
    pub fn potential_energy(&self) -> f64 {
        self.states.iter().zip(&self.mass_kg).map(|(s, m)| -m * self.gravity * s.com.z).sum()
    }

    /// Weight of all bodies, N.
    pub fn weight(&self) -> f64 {
        self.mass_kg.iter().sum::<f64>() * self.gravity.abs()
    }

    /// Generalised force of gravity at the present poses, in the engine's order.
    pub fn gravity_forces(&self) -> DVector<f64> {
        let mut forces = DVector::zeros(self.coordinates());
        for i in 0..self.states.len() {
            let j = self.jacobian(i);
            for column in 0..j.ncols() {
                forces[column] += j[(2, column)] * self.mass_kg[i] * self.gravity;
            }
        }
        forces
    }

    /// As [`Engine::gravity_forces`], for bodies with other masses in the places of these.
    pub fn gravity_forces_of(&self, bodies: &[Option<Inertial>]) -> DVector<f64> {
        let mut forces = DVector::zeros(self.coordinates());
        for (i, (inertial, state)) in bodies.iter().zip(&self.states).enumerate() {
            let Some(inertial) = inertial else { continue };
            let arm = state.pose * inertial.com - state.com;
            let j = self.jacobian(i);
            for column in 0..j.ncols() {
                let rising = j[(2, column)] + j[(3, column)] * arm.y - j[(4, column)] * arm.x;
                forces[column] += rising * inertial.mass_kg * self.gravity;
            }
        }
        forces
    }
}
