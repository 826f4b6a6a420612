//! A URDF leg in the physics engine, driven by series elastic actuators.
//!
//! [`mod@bench`] is a robot with its drives and no contact, in its joints' own coordinates.
//! A [`scenario`] says which [`robot`] does what; [`run()`] runs it for an [`Observer`](simulation::Observer)
//! and returns peaks, events and the energy balance; [`impact`] sweeps drop heights and springs. Rigid
//! bodies are the engine's, every force is ours (see [`dynamics`]); no type of the engine is public.

pub mod bench;
mod channel;
mod controller;
pub mod dynamics;
pub mod effect;
mod error;
pub mod impact;
pub mod model;
pub mod robot;
mod run;
pub mod scenario;
pub mod simulation;

pub use error::LegError;
pub use run::{Channels, JointEnd, Recorded, RunResult, channels, run, run_robot, run_simulation};
