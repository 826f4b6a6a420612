//! The dissertation's figures drawn from our own numbers, with the published ones marked.

pub(crate) mod control;
mod responses;
mod springs;

use sealegs_recorder::chart::Chart;

use crate::thor::Thor;
use crate::{ReproduceError, Reproduction};

/// A figure of the dissertation.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Its number, `3-9`.
    pub number: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// What to see in it and where it differs from the print.
    pub caption: String,
    /// Its pictures, top to bottom.
    pub charts: Vec<Chart>,
}

/// All figures in the order of the text.
///
/// # Errors
///
/// If a preset is missing.
pub fn figures(r: &Reproduction) -> Result<Vec<Figure>, ReproduceError> {
    let thor = Thor::new()?;
    Ok(vec![
        springs::figure_2_12(),
        springs::figure_2_13(),
        springs::figure_2_18(),
        springs::figure_2_19(),
        springs::figure_2_20(),
        responses::figure_3_7(r, &thor),
        responses::figure_3_9(r, &thor),
        responses::figure_4_10(&thor),
        control::figure_4_11(&thor),
        responses::figure_4_12(&thor),
        control::figure_4_14(&thor),
        control::figure_4_16(&thor),
        control::figure_4_17(&thor),
    ])
}

/// `n` values with equal ratios from `low` to `high`.
fn logarithmic(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| low * (high / low).powf(i as f64 / (n - 1) as f64)).collect()
}

/// `n` values with equal distances from `low` to `high`.
fn linear(low: f64, high: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| low + (high - low) * i as f64 / (n - 1) as f64).collect()
}
