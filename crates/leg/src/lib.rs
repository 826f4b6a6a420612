//! A URDF leg in the physics engine, driven by series elastic actuators.

mod error;
pub mod robot;

pub use error::LegError;
