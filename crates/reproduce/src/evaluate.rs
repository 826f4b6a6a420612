//! A row of the table made a row of the reproduction.

use serde::Serialize;

use crate::function::Call;
use crate::rows::{Entry, Input, Verdict};
use crate::setup::Setup;
use crate::{ReproduceError, template};
use sealegs_actuator::effect::{Expression, Fault};

/// A row of the reproduction: print, ours, and what to think of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Row id.
    pub id: String,
    /// Place in the dissertation.
    pub reference: String,
    /// What it is.
    pub quantity: String,
    /// Unit of `published` and `ours`.
    pub unit: String,
    /// As printed; empty where nothing is.
    pub published: String,
    /// The formula that `ours` comes from; empty for a statement.
    pub formula: String,
    /// Recomputed; absent for a statement.
    pub ours: Option<f64>,
    /// Ours over the print, less one.
    pub deviation: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// A line of why.
    pub why: String,
}

/// Recomputes an entry. The inputs come first, then the formula, then the remark, which may show any of them.
pub(crate) fn row(setup: &Setup, entry: &Entry) -> Result<Row, ReproduceError> {
    let mut names = Vec::new();
    let mut values = Vec::new();
    for (name, input) in &entry.inputs {
        names.push(name.as_str());
        values.push(match input {
            Input::Number(value) => *value,
            Input::Call(text) => called(setup, entry, text)?
                .ok_or_else(|| fault(entry, text, "an input is a number or a call of a function"))?,
        });
    }
    let ours = match &entry.formula {
        None => None,
        Some(text) => Some(match called(setup, entry, text)? {
            Some(value) => value,
            None => arithmetic(entry, text, &names, &values)?,
        }),
    };
    if let Some(ours) = ours {
        names.push("ours");
        values.push(ours);
    }
    let why = template::filled(&entry.why, |text| arithmetic(entry, text, &names, &values))
        .map_err(|fault_of| fault_of.unwrap_or_else(|| fault(entry, &entry.why, "a brace is not closed")))?;
    Ok(Row {
        id: entry.id.clone(),
        reference: entry.reference.clone(),
        quantity: entry.quantity.clone(),
        unit: entry.unit.clone(),
        published: entry.printed.clone(),
        formula: entry.formula.clone().unwrap_or_default(),
        ours,
        deviation: ours.and_then(|value| entry.deviation(value)),
        verdict: ours.filter(|_| entry.judged).map_or(Verdict::Statement, |value| entry.judge(value)),
        why,
    })
}

fn fault(entry: &Entry, text: &str, message: impl Into<String>) -> ReproduceError {
    ReproduceError::Formula { row: entry.id.clone(), text: text.to_owned(), message: message.into() }
}

/// The value of a call; nothing if the text is no call of a function of this crate.
fn called(setup: &Setup, entry: &Entry, text: &str) -> Result<Option<f64>, ReproduceError> {
    let Some(call) = Call::parse(text) else { return Ok(None) };
    call.value(setup).map(Some).map_err(|error| fault(entry, text, error.to_string()))
}

fn arithmetic(entry: &Entry, text: &str, names: &[&str], values: &[f64]) -> Result<f64, ReproduceError> {
    let at = |f: Fault| fault(entry, text, format!("character {}: {}", f.character, f.message));
    Expression::parse(text, names).map_err(at)?.checked(values).map_err(at)
}
