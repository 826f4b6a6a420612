//! The moving-output bench: a pendulum on a lever.

use crate::plant::{GRAVITY_M_S2, Link};

/// A mass on a rod that the screw turns by a lever of constant arm, or a rotary drive directly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PendulumRig {
    /// Lever arm, m; 1 where a rotary drive turns the joint directly.
    pub arm_m: f64,
    /// Distance of the mass from the joint, m.
    pub length_m: f64,
    /// kg.
    pub mass_kg: f64,
    /// Mass of the rod, evenly spread from the joint to the mass, kg.
    pub rod_mass_kg: f64,
}

impl Default for PendulumRig {
    /// The dissertation's rig (section 3-4-5): 4 kg at 0.300 m on a lever of 0.0725 m.
    fn default() -> Self {
        Self { arm_m: 0.0725, length_m: 0.300, mass_kg: 4.0, rod_mass_kg: 0.0 }
    }
}

impl PendulumRig {
    /// The rig as the actuator's link 2.
    #[must_use]
    pub fn link(&self) -> Link {
        Link::Pendulum {
            inertia_kg_m2: (self.mass_kg + self.rod_mass_kg / 3.0) * self.length_m * self.length_m,
            gravity_torque_nm: (self.mass_kg + self.rod_mass_kg / 2.0) * GRAVITY_M_S2 * self.length_m,
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
        assert!((link.stiffness_n_m() - 2239.6).abs() < 0.05);
    }

    #[test]
    fn analytic_a_rod_has_a_third_of_its_inertia_and_half_of_its_weight() {
        let rig = PendulumRig { arm_m: 1.0, length_m: 0.5, mass_kg: 0.0, rod_mass_kg: 1.2 };
        let Link::Pendulum { inertia_kg_m2, gravity_torque_nm, .. } = rig.link() else {
            panic!("a pendulum")
        };
        assert!((inertia_kg_m2 - 0.1).abs() < 1e-15 && (gravity_torque_nm - 0.3 * 9.81).abs() < 1e-15);
    }
}
