//! One series elastic actuator: motor, transmission, spring and beams, integration, benches and effects.
//!
//! [`ActuatorSpec`] is the actuator's file and what follows from it. [`spring`] says what a beam does and bears,
//! [`linkage`] what moves between actuator and joint. [`plant`] is the motion in time with every [`effect`] in place,
//! [`mod@bench`] a plant between two links as a model that diagnosis sees, [`excitation`] what drives it. [`response`]
//! has the same physics in closed form, [`compensator`] and [`design`] what it means for force control.

pub mod bench;
pub mod compensator;
pub mod design;
pub mod effect;
mod error;
pub mod excitation;
mod kaiser;
pub mod linkage;
pub mod plant;
pub mod response;
pub mod spec;
pub mod spring;
pub mod text;

pub use error::ActuatorError;
pub use spec::{ActuatorSpec, Coefficients, Configuration, Kind};
