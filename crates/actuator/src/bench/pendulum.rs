//! The moving-output bench: a pendulum on a lever.

use crate::plant::{GRAVITY_M_S2, Link};

/// A mass on a massless link that the screw turns by a lever of constant arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PendulumRig {
    /// Lever arm, m.
    pub arm_m: f64,
    /// Distance of the mass from the joint, m.
    pub length_m: f64,
    /// kg.
    pub mass_kg: f64,
}

impl Default for PendulumRig {
    /// The dissertation's rig (section 3-4-5): 4 kg at 0.300 m on a lever of 0.0725 m.
    fn default() -> Self {
        Self { arm_m: 0.0725, length_m: 0.300, mass_kg: 4.0 }
    }
}

impl PendulumRig {
    /// The rig as the actuator's link 2.
    #[must_use]
    pub fn link(&self) -> Link {
        Link::Pendulum {
            inertia_kg_m2: self.mass_kg * self.length_m * self.length_m,
            gravity_torque_nm: self.mass_kg * GRAVITY_M_S2 * self.length_m,
            arm_m: self.arm_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_effective_mass_and_gravity_stiffness() {
        let link = PendulumRig::default().link();
        assert!((link.mass_kg() - 68.49).abs() < 0.005);
        assert!((link.gravity_stiffness_n_m() - 2239.6).abs() < 0.05);
    }
}
