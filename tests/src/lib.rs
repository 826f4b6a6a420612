//! What holds across crates; the tests themselves are in `tests/`.

pub mod damage;

/// The independent integrator that makes the truth for tests of recovery and of the plant.
#[path = "../../crates/actuator/tests/reference/mod.rs"]
pub mod reference;
