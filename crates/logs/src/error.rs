//! What can be wrong with a log, with the file, the place and the column.

use std::path::{Path, PathBuf};

/// A file that cannot be read, or that holds something that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", place(.file, *.at, .column.as_deref()))]
pub struct LogError {
    /// The file.
    pub file: PathBuf,
    /// Where in it, as far as that can be named.
    pub at: Place,
    /// The column, where one can be named.
    pub column: Option<String>,
    /// What is wrong and what would be right.
    pub problem: String,
}

impl LogError {
    /// A fault of the file at a place.
    pub(crate) fn new(
        file: &Path,
        at: impl Into<Place>,
        column: Option<&str>,
        problem: impl Into<String>,
    ) -> Self {
        Self {
            file: file.to_owned(),
            at: at.into(),
            column: column.map(str::to_owned),
            problem: one_line(&problem.into()),
        }
    }

    /// A fault of the file as a whole.
    pub(crate) fn whole(file: &Path, problem: impl Into<String>) -> Self {
        Self::new(file, Place::Whole, None, problem)
    }
}

/// Where in a file something is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In the file as a whole.
    Whole,
    /// In a line of a text, from 1; the header of a table is one.
    Line(u64),
    /// In a row of a table that has no lines (Parquet), an element of an array, an entry of a list, a message of a
    /// topic; from 1.
    Row(u64),
}

impl From<u64> for Place {
    fn from(line: u64) -> Self {
        Self::Line(line)
    }
}

impl From<Option<u64>> for Place {
    fn from(line: Option<u64>) -> Self {
        line.map_or(Self::Whole, Self::Line)
    }
}

/// A text without line breaks and other control characters: names in a damaged file may hold them.
fn one_line(text: &str) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect()
}

/// `r.csv, line 12, column 'force_1_n'`.
#[must_use]
pub fn place(file: &Path, at: Place, column: Option<&str>) -> String {
    let mut place = file.display().to_string();
    match at {
        Place::Whole => {}
        Place::Line(line) => place.push_str(&format!(", line {line}")),
        Place::Row(row) => place.push_str(&format!(", row {row}")),
    }
    if let Some(column) = column {
        // A campaign file has keys, a table has columns.
        let what = if file.extension().is_some_and(|e| e == "toml") { "key" } else { "column" };
        place.push_str(&format!(", {what} '{}'", one_line(column)));
    }
    place
}
