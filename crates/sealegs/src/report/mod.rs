//! What the reports of `compare` and `diagnose` share: values in a person's units, the missing force, and where a model fails.

pub(crate) mod fails;
pub(crate) mod force;
pub(crate) mod units;

/// Ratio of two bars from which on a linear axis would hide the shorter one.
pub(crate) const WIDE_RATIO: f64 = 20.0;
