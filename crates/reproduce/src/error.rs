//! Why the reproduction failed: a fault of the table, of a preset or of a simulation.

use sealegs_actuator::ActuatorError;
use sealegs_sysid::frf::FrfError;

/// What went wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReproduceError {
    /// A file of the table is damaged.
    #[error("{file}: {message}")]
    Table {
        /// The file's name.
        file: &'static str,
        /// What is wrong, with its line.
        message: String,
    },
    /// No row of the table has this id.
    #[error("no row {id}")]
    UnknownRow {
        /// The id that was asked for.
        id: String,
    },
    /// A row's formula, input or remark cannot be evaluated.
    #[error("row {row}: `{text}`: {message}")]
    Formula {
        /// The row's id.
        row: String,
        /// The text that was evaluated.
        text: String,
        /// What is wrong.
        message: String,
    },
    /// A response lacks the feature that is sought in it.
    #[error("{what}")]
    NoFeature {
        /// Which one.
        what: String,
    },
    /// A simulation failed.
    #[error("{run}: {message}")]
    Simulation {
        /// Which one.
        run: String,
        /// What the model says.
        message: String,
    },
    /// A frequency response could not be estimated.
    #[error(transparent)]
    Response(#[from] FrfError),
    /// A preset could not be loaded.
    #[error(transparent)]
    Actuator(#[from] ActuatorError),
}

impl ReproduceError {
    /// That a response has no such feature.
    pub(crate) fn missing(what: impl Into<String>) -> Self {
        Self::NoFeature { what: what.into() }
    }

    /// That a simulation failed.
    pub(crate) fn simulation(run: &str, error: impl std::fmt::Display) -> Self {
        Self::Simulation { run: run.to_owned(), message: error.to_string() }
    }
}
