//! What a person and a program get of a diagnosis: JSON, text, report, recording, plan.

pub mod addition;
mod figures;
mod friction;
pub mod outcome;
mod page;
pub mod plan;
pub mod progress;
pub mod provenance;
pub mod story;
pub mod text;

pub use page::of as page;

use sealegs_model::Model;
use sealegs_sysid::Campaign;

/// The noise floor of a campaign in noise units: what repeats of a run leave between them; never below 1.
#[must_use]
pub fn floor(campaign: &Campaign, _model: &dyn Model) -> f64 {
    sealegs_sysid::diagnose::noise_floor(campaign)
}
