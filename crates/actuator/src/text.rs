//! Reading TOML with messages that name file, line and the key that was probably meant.

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use crate::ActuatorError;

/// The name out of `known` that comes nearest to `wanted`, if one comes near at all.
#[must_use]
pub fn nearest<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    known
        .into_iter()
        .map(|k| (strsim::jaro_winkler(wanted, k).max(strsim::normalized_damerau_levenshtein(wanted, k)), k))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, k)| k.to_owned())
}

/// `; did you mean 'x'?` with the name that comes near, else nothing.
#[must_use]
pub fn meant<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(wanted, known).map_or_else(String::new, |n| format!("; did you mean '{n}'?"))
}

/// Parses TOML into a type whose structs deny unknown keys; `file` is only named in messages.
///
/// # Errors
///
/// [`ActuatorError::Syntax`] with line and column, and with a suggestion for a misspelt key.
pub fn parse_toml<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, ActuatorError> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let start = error.span().map_or(0, |span| span.start);
        let (line, column) = line_and_column(text, start);
        ActuatorError::Syntax {
            file: file.to_owned(),
            line,
            column,
            suggestion: suggestion_from(error.message()),
            message: sealegs_model::plain(error.message().trim_end()),
        }
    })
}

/// The line, from 1, on which a dotted path of keys is set in a TOML text. The longest leading part that
/// exists counts, so that a missing key is reported at its table.
#[must_use]
pub fn line_of(text: &str, path: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut table = root.get_ref();
    let mut line = None;
    for key in path.split('.') {
        let Some((name, value)) = table.iter().find(|(name, _)| name.get_ref() == key) else { break };
        line = Some(line_and_column(text, name.span().start).0);
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            _ => break,
        }
    }
    line
}

fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |l| l.chars().count()) + 1;
    (line, column)
}

/// serde lists what it expected in backticks after the name that it found: "unknown field `a`, expected
/// one of `b`, `c`".
fn suggestion_from(message: &str) -> Option<String> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let found = quoted.next()?;
    nearest(found, quoted)
}
