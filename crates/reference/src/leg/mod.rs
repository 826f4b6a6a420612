//! An independent simulator of a leg: bodies, rotors and sprung masses in one linear system, its own controller.
//!
//! The equations of motion are written down again without the engine: joints and rotors are solved together, so that
//! nothing is lagged and no inertia is lumped, and integrated by classical Runge-Kutta at a fine step, with dry
//! friction as located events. It has the same physical limit as the product's coupling (the sprung mass at the screw
//! side of a rod and at the mount of a linkage, Hunt and Crossley's contact with bristles) and nothing else in common.
//! From the product it takes the robot's geometry, scenarios and command profiles only.
//!
//! Signs as everywhere: an actuator's axis points from link 1 to link 2, compression is positive.

mod bodies;
mod controller;
mod friction;
mod ground;
mod machine;
mod run;
mod setup;
mod solve;

pub use run::Instant;
pub use setup::{LegIndividual, LegReference};
