//! Recordings for Rerun and self-contained HTML reports with pictures.
//!
//! - [`recording`]: a run as a 3D scene with time series and events, written as one `.rrd` file or shown
//!   live; a comparison of measured and predicted channels; reading back what was written.
//! - [`chart`]: small pictures in SVG: lines, bands, contours, bars, maps.
//! - [`report`]: one HTML file made of sections, tables and figures that needs no network.
//!
//! The input types are plain numbers and text. No type of Rerun leaves this crate, and no physics enters it.

pub mod chart;
pub mod recording;
pub mod report;

mod error;

pub use error::RecorderError;
