//! The file of a user's own effect: its keys, and what its id and parameters must be.

use super::super::CATALOGUE;
use super::super::setting::Setting;
use super::expression;
use crate::ActuatorError;
use crate::text::line_of;
use sealegs_model::{Curve, Parameter};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Most parameters of one law.
pub(super) const MOST_PARAMETERS: usize = 16;

/// Where a law acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Place {
    Rotor,
    Drive,
    Spring,
    Output,
}

impl Place {
    pub fn variables(self) -> &'static [&'static str] {
        match self {
            Self::Rotor => &["y", "y_dot", "theta", "theta_dot", "F_bs", "t"],
            Self::Drive => &["u", "F_m", "y_dot", "theta_dot"],
            Self::Spring => &["delta", "delta_dot", "F_k"],
            Self::Output => &["theta", "theta_dot", "y", "y_dot", "t"],
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Rotor => "rotor",
            Self::Drive => "drive",
            Self::Spring => "spring",
            Self::Output => "output",
        }
    }
}

/// A file whose law is an expression.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct File {
    pub id: String,
    pub acts_on: Place,
    pub law: String,
    #[serde(default)]
    pub parameters: BTreeMap<String, ParameterFile>,
    pub summary: Option<String>,
    pub told_apart: Option<String>,
    pub cure: Option<String>,
}

/// A file whose law is a curve.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct CurveFile {
    pub id: String,
    /// Where on a leg `add` puts it.
    pub place: Option<String>,
    pub acts_on: String,
    pub curve: Curve,
    pub summary: Option<String>,
    pub told_apart: Option<String>,
    pub cure: Option<String>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ParameterFile {
    pub guess: Option<f64>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    #[serde(default)]
    pub unit: String,
    pub fixed: Option<f64>,
    pub neutral: Option<f64>,
}

pub(super) fn check_id(id: &str) -> Result<(), ActuatorError> {
    let word = |w: &str| !w.is_empty() && w.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    if id.len() > 64 || !id.split('-').all(word) {
        return Err(ActuatorError::value("id", format!("\"{id}\""), "lower-case words joined by '-'"));
    }
    let setting = Setting::unknown();
    if CATALOGUE.iter().any(|e| e.card(&setting).id == id) {
        return Err(ActuatorError::value("id", format!("\"{id}\""), "another name than the catalogue's"));
    }
    Ok(())
}

pub(super) fn parameter(
    name: &str,
    said: &ParameterFile,
    variables: &[&str],
) -> Result<Parameter, ActuatorError> {
    let field = |key: &str| format!("parameters.{name}.{key}");
    let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !starts || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Err(ActuatorError::value("parameters", format!("\"{name}\""), "letters, digits and '_'"));
    }
    if variables.contains(&name) || expression::is_reserved(name) {
        return Err(ActuatorError::value("parameters", name, "no name of a variable or function"));
    }
    let given = [("guess", said.guess), ("min", said.min), ("max", said.max), ("neutral", said.neutral)];
    for (key, value) in given.into_iter().chain([("fixed", said.fixed)]) {
        if let Some(value) = value.filter(|v| !v.is_finite()) {
            return Err(ActuatorError::value(field(key), value, "finite"));
        }
    }
    if let Some(value) = said.fixed {
        if let Some((key, Some(other))) = given.into_iter().find(|(_, v)| v.is_some()) {
            return Err(ActuatorError::value(field(key), other, "absent beside 'fixed'"));
        }
        return Ok(Parameter { fixed: true, ..Parameter::new(name, &said.unit, value, value, value) });
    }
    let missing = |key: &str| ActuatorError::value(field(key), "nothing", "given, or 'fixed' in place of it");
    let guess = said.guess.ok_or_else(|| missing("guess"))?;
    let min = said.min.ok_or_else(|| missing("min"))?;
    let max = said.max.ok_or_else(|| missing("max"))?;
    if !(min <= guess && guess <= max && min < max) {
        return Err(ActuatorError::value(
            field("guess"),
            guess,
            format!("between min and max, {min} and {max}"),
        ));
    }
    if let Some(neutral) = said.neutral.filter(|n| !(min..=max).contains(n)) {
        return Err(ActuatorError::value(field("neutral"), neutral, format!("between {min} and {max}")));
    }
    Ok(Parameter::new(name, &said.unit, guess, min, max))
}

/// Line of the law in a file, and how many columns come before its text.
pub(super) fn law_place(text: &str) -> (usize, usize) {
    let line = line_of(text, "law").unwrap_or(1);
    let written = text.lines().nth(line - 1).unwrap_or_default();
    let quote = written.char_indices().find(|(_, c)| *c == '"' || *c == '\'').map_or(0, |(i, _)| i);
    (line, written[..quote].chars().count() + 1)
}
