//! The rigid bodies as they are simulated: mass matrix, gravity torques, mass properties.

use super::Simulation;
use crate::robot::Inertial;
use nalgebra::{DMatrix, DVector};

impl Simulation {
    /// The mass matrix of the rigid bodies over the joints at the present posture, in the order of their degrees of
    /// freedom, kg m^2 (kg m, kg where joints slide): without rotors, armature and the rail.
    #[must_use]
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let (all, n) = (self.engine.mass_matrix(), self.engine.q.len());
        DMatrix::from_fn(n, n, |i, j| all[(self.engine.column(i), self.engine.column(j))])
    }

    /// The joint torques that hold the rigid bodies against gravity at the present posture, by degree of freedom,
    /// N m (N where a joint slides): `g` in `M q'' + c + g = tau`.
    #[must_use]
    pub fn gravity_torques(&self) -> DVector<f64> {
        let weight = self.engine.gravity_forces();
        DVector::from_fn(self.engine.q.len(), |dof, _| -weight[self.engine.column(dof)])
    }

    /// The mass properties that the rigid bodies are simulated with, each by the name of the link that its joint
    /// carries and in that link's frame: the link with everything fixed to it.
    pub fn moving_bodies(&self) -> impl Iterator<Item = (&str, &Inertial)> {
        self.tree.bodies.iter().skip(1).filter_map(|b| Some((b.name.as_str(), b.inertial.as_ref()?)))
    }
}
