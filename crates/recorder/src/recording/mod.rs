//! A run as one Rerun recording: a 3D scene, time series, events and the scenario that led to them.

mod color;
mod comparison;
mod frame;
mod scene;

pub use color::{Color, FORCE_SCALE, force_color};
pub use comparison::{ComparedChannel, ComparedRun, Comparison};
pub use frame::{ArrowState, Frame, Level, Pose, Poses, RodState};
pub use scene::{Arrow, Body, Document, Geometry, Ground, Rod, Scene, SeriesGroup, Shape};
