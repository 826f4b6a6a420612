//! Independent simulators of an actuator on a bench and of a leg: the truth of tests, and campaigns with a hidden
//! effect.
//!
//! [`Reference`] integrates by classical Runge-Kutta at a fine step in the absolute positions of the masses, with
//! dry friction as located events. It shares nothing with the product's plant: no code, no coordinates, no scheme.
//! From the product it takes parameters (an actuator's file, a bench's dimensions) and command profiles only.
//! Positions are absolute: sprung mass `p`, screw's end `s`, link 1, link 2, wobbling mass `u`; the screw's
//! extension is `s - p`. [`leg`] has the same of a whole leg.

mod beyond;
pub mod campaign;
mod effect;
mod friction;
mod laws;
pub mod leg;
mod machine;
mod reference;
mod sensor;

pub use beyond::{Beyond, Whereabouts};
pub use effect::{FrictionLaw, Rubbing};
pub use reference::{End, Outputs, Reference, SensorErrors};
