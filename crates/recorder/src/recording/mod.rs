//! A run as one Rerun recording: a 3D scene, time series, events and the scenario that led to them.

mod cadence;
mod color;
mod columns;
mod comparison;
mod contents;
mod entities;
mod frame;
mod layout;
mod paths;
mod rerun;
mod scene;
mod scene_view;
mod stream;
mod viewer;
mod writer;

pub use cadence::{Cadence, Due};
pub use color::{Color, FORCE_SCALE, force_color};
pub use comparison::{ComparedChannel, ComparedRun, Comparison};
pub use contents::{DecodedEvent, DecodedSeries, Ending, RecordingContents};
pub use frame::{ArrowState, Frame, Level, Pose, Poses, RodState};
pub use scene::{Arrow, Body, Document, Geometry, Ground, Rod, Scene, SeriesGroup, Shape};
pub use viewer::show;
pub use writer::{Output, RecordingWriter};
