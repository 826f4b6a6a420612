//! One series elastic actuator: motor, transmission, spring and beams, integration, benches and effects.
//!
//! [`ActuatorSpec`] is the actuator's file; [`spring`] says what a beam does and bears, [`linkage`] what moves
//! between actuator and joint.

pub mod bench;
pub mod compensator;
pub mod design;
pub mod effect;
mod error;
pub mod linkage;
pub mod plant;
pub mod response;
pub mod spec;
pub mod spring;
pub mod text;

pub use error::ActuatorError;
pub use spec::{ActuatorSpec, Coefficients, Configuration, Kind};
