//! What a person and a program get of a diagnosis: JSON, text, report, recording, plan.

pub mod addition;
mod better;
pub(crate) mod bounds;
pub mod confidence;
pub(crate) mod drift;
mod figures;
mod friction;
pub(crate) mod headline;
mod intervals;
pub mod law;
pub mod outcome;
mod page;
pub mod plan;
pub mod progress;
pub mod provenance;
mod result;
mod sentence;
mod signals;
mod splits;
pub mod story;
pub mod text;
#[cfg(test)]
mod toy;
pub mod units;

pub use better::{Addition, add, named};
pub use page::of as page;
pub use result::{Diagnosis, diagnose};
pub use splits::{OtherChoice, Splits};
