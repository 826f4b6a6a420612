//! From measurements to a verdict: campaign, residual, location, screening, fit, selection.

pub mod frf;
