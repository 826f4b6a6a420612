//! What can go wrong between a campaign's files and a verdict, with the values inside.

use sealegs_model::ModelError;
use std::path::{Path, PathBuf};

/// An error of this crate. All but [`Error::Model`] and [`Error::NoStart`] are bad input.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, or holds something that the data contract does not admit.
    #[error("{}: {problem}", place(.file, *.line, .column.as_deref()))]
    BadFile {
        /// The file.
        file: PathBuf,
        /// The line, from 1, where one can be named.
        line: Option<u64>,
        /// The column (of a table) or key (of `campaign.toml`), where one can be named.
        column: Option<String>,
        /// What is wrong and what would be right.
        problem: String,
    },
    /// The command needs a run of a role of which the campaign has none.
    #[error("{}: no run with role \"{role}\", and this command needs one", .file.display())]
    NoRun {
        /// The campaign file.
        file: PathBuf,
        /// The role, `fit` or `holdout`.
        role: &'static str,
    },
    /// A model could not predict a run.
    #[error("{run}: {source}")]
    Model {
        /// The run's file name.
        run: String,
        /// Why.
        source: ModelError,
    },
    /// No start of a fit could be simulated.
    #[error("no starting point of the fit can be simulated; the first failure was: {run}: {source}")]
    NoStart {
        /// The run's file name.
        run: String,
        /// Why.
        source: ModelError,
    },
}

impl Error {
    /// Bad content at a place of a file.
    pub(crate) fn bad(
        file: &Path,
        line: impl Into<Option<u64>>,
        column: Option<&str>,
        problem: impl Into<String>,
    ) -> Self {
        Self::BadFile {
            file: file.to_owned(),
            line: line.into(),
            column: column.map(str::to_owned),
            problem: problem.into(),
        }
    }
}

fn place(file: &Path, line: Option<u64>, column: Option<&str>) -> String {
    let mut place = file.display().to_string();
    if let Some(line) = line {
        place.push_str(&format!(", line {line}"));
    }
    if let Some(column) = column {
        place.push_str(&format!(", column '{column}'"));
    }
    place
}
