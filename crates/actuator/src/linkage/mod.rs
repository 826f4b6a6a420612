//! Linkages between an actuator's output and the joint.

mod hoekens;

pub use hoekens::Hoekens;
