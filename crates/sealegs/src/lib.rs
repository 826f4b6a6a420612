//! Legs with linear series elastic actuators: campaigns of logs, comparison, diagnosis, and the models that follow.

pub mod bench_model;
pub mod campaign_model;
pub mod comparison;
pub mod diagnosis;
mod error;
pub mod leg_model;
pub mod leg_scene;
pub mod mystery;

pub use error::{Error, Result};
