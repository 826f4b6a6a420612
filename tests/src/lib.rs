//! What holds across crates; the tests themselves are in `tests/`.

pub mod matrix;
pub mod mujoco;
