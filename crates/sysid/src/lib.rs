//! From measurements to a verdict: campaign, residual, location, screening, fit, selection.
//!
//! The walk, one stage per module; each takes plain structs and returns one:
//!
//! 1. [`campaign`] reads the files and refuses bad input; [`resample`] is for who needs an even grid.
//! 2. [`data`] chooses runs, channels and the rows that count for a model; it predicts and divides the
//!    residual (measured minus predicted) by each channel's noise. [`nuisance`] solves the sensors' gain
//!    and bias inside every such evaluation.
//! 3. [`fit`] refits a model's own parameters, with what is known of them beforehand.
//! 4. [`residual`] states the errors of fitted and held-out runs, [`locate`] says where they sit and
//!    [`structure`] what they depend on; [`frf`] compares in frequency.
//! 5. [`sanity`] looks for what is wrong with the log itself, [`check`] says what a campaign can identify at all, before any fit.
//!
//! 6. [`diagnose`] screens the effects, fits, selects and judges.
//!
//! A model is seen through [`sealegs_model::Model`] only. Whatever is computed in parallel is summed in a
//! fixed order, so that the same input gives the same bits for any number of threads.

pub mod campaign;
pub mod check;
pub mod data;
pub mod diagnose;
mod error;
pub mod fit;
pub mod flips;
pub mod frequency;
pub mod frf;
pub mod friction;
pub mod locate;
pub mod nuisance;
pub mod resample;
pub mod residual;
pub mod sanity;
pub mod stats;
pub mod structure;
#[cfg(test)]
pub(crate) mod toy;
pub mod units;

pub use campaign::{Bench, Campaign, Role, Run};
pub use data::{Data, Evaluation};
pub use error::{Error, Place};
pub use fit::{Fit, FitOptions};
