//! A spring that is just a number: along an axis or about it.

use serde::{Deserialize, Serialize};

/// A linear spring of constant stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ConstantSpring {
    /// Stiffness `k`, N/m.
    pub stiffness_n_m: f64,
}

/// A torsion spring of constant stiffness, for a rotary actuator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TorsionSpring {
    /// Stiffness `k`, N m/rad.
    pub stiffness_nm_rad: f64,
}
