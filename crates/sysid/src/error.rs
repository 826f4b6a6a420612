//! What can go wrong between a campaign's files and a verdict, with the values inside.

use sealegs_logs::{LogError, place};
use sealegs_model::ModelError;
use std::path::{Path, PathBuf};

/// An error of this crate. All but [`Error::Model`] and [`Error::NoStart`] are bad input.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read, or holds something that the data contract does not admit.
    #[error("{}: {problem}", place(.file, *.at, .column.as_deref()))]
    BadFile {
        /// The file.
        file: PathBuf,
        /// Where in it, as far as that can be named.
        at: Place,
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

pub use sealegs_logs::Place;

impl Error {
    /// Bad content at a place of a file.
    pub(crate) fn bad(
        file: &Path,
        at: impl Into<Place>,
        column: Option<&str>,
        problem: impl Into<String>,
    ) -> Self {
        Self::BadFile {
            file: file.to_owned(),
            at: at.into(),
            column: column.map(str::to_owned),
            problem: problem.into(),
        }
    }

    /// A fault of a log with what is misspelt in its campaign behind it, which may be the reason.
    pub(crate) fn hinted(mut self, campaign: &Path, misspelt: &str) -> Self {
        if let Self::BadFile { file, problem, .. } = &mut self
            && *file != campaign
            && let Some(said) = misspelt.strip_prefix(';')
        {
            let name = campaign.file_name().unwrap_or_default().to_string_lossy();
            *problem = format!("{problem}; in {name}{said}");
        }
        self
    }
}

impl From<LogError> for Error {
    fn from(error: LogError) -> Self {
        let LogError { file, at, column, problem } = error;
        Self::BadFile { file, at, column, problem }
    }
}
