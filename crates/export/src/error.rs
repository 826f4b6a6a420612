//! What can go wrong with an export, with the values inside.

use crate::Format;
use sealegs_leg::LegError;
use sealegs_model::ModelError;

/// Why a model could not be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// No format has this name.
    #[error("no format '{name}'; there are {}", Format::ALL.map(Format::as_str).join(", "))]
    UnknownFormat {
        /// The name that was asked for.
        name: String,
    },
    /// A bench that no writer knows.
    #[error(
        "{model} on its bench cannot be exported; an actuator with a spring can, locked or on a pendulum whose rod has no mass, and a \
         drive without one, free or on a pendulum"
    )]
    Bench {
        /// The model's name.
        model: String,
    },
    /// A file's name from which no file beside it can be named.
    #[error("'{stem}' names no file")]
    Stem {
        /// The name without its ending.
        stem: String,
    },
    /// Values that no actuator can have.
    #[error("{0}")]
    Model(ModelError),
    /// A scenario or a robot with an error in it.
    #[error(transparent)]
    Leg(Box<LegError>),
}

impl From<ModelError> for ExportError {
    fn from(error: ModelError) -> Self {
        Self::Model(error)
    }
}

impl From<LegError> for ExportError {
    fn from(error: LegError) -> Self {
        Self::Leg(Box::new(error))
    }
}
