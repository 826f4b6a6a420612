//! A number that a fit may change: its value, unit, bounds and what is known of it beforehand.

use serde::{Deserialize, Serialize};

/// How a parameter is stepped in a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// In steps of its own typical size.
    #[default]
    Linear,
    /// In ratios: positive quantities whose order of magnitude is unknown.
    Logarithmic,
}

/// A model parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Name with the unit as suffix where it belongs to an effect (`coulomb-friction.force_n`).
    pub name: String,
    /// Unit as printed, `N s/m`; empty for a ratio.
    pub unit: String,
    /// Nominal value, where a fit starts.
    pub value: f64,
    /// Least admitted value.
    pub min: f64,
    /// Greatest admitted value.
    pub max: f64,
    /// One standard deviation of what is known beforehand about `value`, from the maker's tolerance;
    /// `None` where nothing is known.
    pub prior_std: Option<f64>,
    /// Never changed by a fit. A fixed parameter with `starts` is a discrete choice: each of them is tried.
    pub fixed: bool,
    /// A fixed parameter that is known only as well as `prior_std` says. Free it would lead a search astray, so it is
    /// held; the last fit of a chosen model changes it, too, and standard errors count what is not known of it.
    #[serde(default)]
    pub freed_at_last: bool,
    /// For an effect's parameter, the value at which the effect vanishes; may lie on a bound.
    pub neutral: Option<f64>,
    /// Other values worth starting from where the law is not smooth, in the order to try them.
    pub starts: Vec<f64>,
    /// A typical size of a change, positive, in the parameter's unit: it scales steps of a search and
    /// finite differences.
    pub typical: f64,
    /// How a search steps.
    pub scale: Scale,
}

impl Parameter {
    /// A parameter with a nominal value and bounds, no prior, linear steps of a tenth of its value.
    #[must_use]
    pub fn new(name: impl Into<String>, unit: &str, value: f64, min: f64, max: f64) -> Self {
        let typical = if value == 0.0 { 0.1 * (max - min) } else { 0.1 * value.abs() };
        Self {
            name: name.into(),
            unit: unit.to_owned(),
            value,
            min,
            max,
            prior_std: None,
            fixed: false,
            freed_at_last: false,
            neutral: None,
            starts: Vec::new(),
            typical,
            scale: Scale::Linear,
        }
    }

    /// Whether nothing is known of it but an order of magnitude.
    #[must_use]
    pub fn is_unknown(&self) -> bool {
        !self.fixed && self.prior_std.is_none() && self.scale == Scale::Logarithmic
    }
}
