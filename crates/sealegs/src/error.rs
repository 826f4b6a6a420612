//! What can go wrong, in one enum: the members' errors inside, and what only a campaign with its model can get wrong.

use sealegs_actuator::ActuatorError;
use sealegs_leg::LegError;
use sealegs_logs::Format;
use sealegs_model::ModelError;
use sealegs_recorder::RecorderError;
use std::path::{Path, PathBuf};

/// The library's result.
pub type Result<T> = std::result::Result<T, Error>;

/// Why the library could not do what was asked. Every message stands alone, in one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A campaign's file is bad, it lacks a run that is needed, or nothing could be simulated.
    #[error(transparent)]
    Campaign(#[from] sealegs_sysid::Error),
    /// An actuator, its file or its spring setting is not usable.
    #[error(transparent)]
    Actuator(#[from] ActuatorError),
    /// A robot, a scenario or a run of a leg is not usable.
    #[error(transparent)]
    Leg(#[from] LegError),
    /// A model cannot do what was asked of it.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A recording could not be written.
    #[error(transparent)]
    Recording(#[from] RecorderError),
    /// The actuator that a file names does not suit the file's bench.
    #[error("{}: {source}", file.display())]
    ModelFile {
        /// The campaign file or the model file.
        file: PathBuf,
        /// Why not.
        source: Box<ActuatorError>,
    },
    /// The robot that a file names is not usable.
    #[error("{}: {source}", file.display())]
    RobotFile {
        /// The campaign file or the model file.
        file: PathBuf,
        /// Why not.
        source: Box<LegError>,
    },
    /// A run's own scenario is not usable.
    #[error("{}: scenario of {run}: {source}", file.display())]
    RunScenario {
        /// The campaign file.
        file: PathBuf,
        /// The run's file name.
        run: String,
        /// Why not.
        source: Box<LegError>,
    },
    /// A column of a run commands nothing that the model has.
    #[error("{}{}, column '{channel}': {reason}", file.display(), if Format::has_lines(file) { ", line 1" } else { "" })]
    RefusedInput {
        /// The run's file.
        file: PathBuf,
        /// The column.
        channel: String,
        /// Why it is refused.
        reason: String,
    },
    /// The model cannot have this effect.
    #[error("{source} (it can have {})", known.join(", "))]
    UnknownEffect {
        /// The effect that was asked for, and the nearest one.
        source: ModelError,
        /// The effects that it can have.
        known: Vec<String>,
    },
    /// The catalogue has no such effect.
    #[error("no effect '{id}' in the catalogue{}", did_you_mean(suggestions))]
    NoSuchEffect {
        /// As it was asked for.
        id: String,
        /// All ids that contain it, or else the nearest one.
        suggestions: Vec<String>,
    },
    /// The model includes this effect already.
    #[error("{model} includes '{effect}' already")]
    AlreadyIncluded {
        /// The model's name.
        model: String,
        /// The effect's id.
        effect: String,
    },
    /// No effect was named where one is to be added.
    #[error("no effect was named")]
    NoEffect,
    /// An effect is named in a way that names none, or twice.
    #[error("'{effect}' {problem}")]
    BadEffect {
        /// As it was named.
        effect: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// One model file cannot hold the values of several units.
    #[error(
        "{}: has the units '{}', each with values of its own: one model file cannot hold them; write one for each unit",
        campaign.display(),
        units.join("', '")
    )]
    SeveralUnits {
        /// The campaign's file.
        campaign: PathBuf,
        /// Its units.
        units: Vec<String>,
    },
    /// A campaign has no such unit.
    #[error("{}: has no unit '{unit}'{}", campaign.display(), it_has(units))]
    NoSuchUnit {
        /// The campaign's file.
        campaign: PathBuf,
        /// As it was asked for.
        unit: String,
        /// Its units; empty where it has fewer than two.
        units: Vec<String>,
    },
    /// The model is of another kind than the campaign: an actuator for a leg, or a scenario for a bench.
    #[error("{model}: a campaign on the {bench} bench needs {needed}")]
    WrongModel {
        /// The model as it was given.
        model: String,
        /// The campaign's bench.
        bench: &'static str,
        /// What would be right.
        needed: &'static str,
    },
    /// A command has not one value for each time stamp.
    #[error("{channel}: {rows} values for {expected} time stamps")]
    Length {
        /// The command's channel.
        channel: String,
        /// Its values.
        rows: usize,
        /// The time stamps.
        expected: usize,
    },
    /// The log is not what its header says: a sign, a unit, a column that is another's.
    #[error(
        "{}: {why} `sealegs check` shows all that was found; --force diagnoses all the same",
        campaign.display()
    )]
    WrongLog {
        /// The campaign's file.
        campaign: PathBuf,
        /// The first of what stops a diagnosis, with its cure.
        why: String,
    },
    /// A text names no shard of a list of jobs.
    #[error("'{given}' is no shard: I/N, the I-th of N, with I from 1 to N")]
    BadShard {
        /// The text.
        given: String,
    },
    /// A folder holds other jobs than those that are asked for.
    #[error("{}: {what}; name another folder", file.display())]
    OtherJobs {
        /// The list's file.
        file: PathBuf,
        /// In what they differ.
        what: String,
    },
    /// A folder holds no list of jobs, or a file in it is not what it should be.
    #[error("{}: {problem}", file.display())]
    NoJobs {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// Results are to be put together, and some are not there.
    #[error("{}: {} of {of} jobs have no whole result: {}", folder.display(), missing.len(), some(missing))]
    JobsMissing {
        /// The folder.
        folder: PathBuf,
        /// How many jobs there are.
        of: usize,
        /// Those without a whole result.
        missing: Vec<String>,
    },
    /// Runs of a mystery would be too short for their commands.
    #[error("runs of {duration_s} s: at least {shortest_s} s are needed")]
    TooShort {
        /// As it was asked for, s.
        duration_s: f64,
        /// The shortest, s.
        shortest_s: f64,
    },
    /// There is no rough mystery on a leg.
    #[error("--level rough: a rough log is one of a bench, not of a leg")]
    NoSuchMystery,
    /// The work was ended by [`Stop`](crate::Stop).
    #[error("stopped")]
    Stopped,
    /// A sealed answer is damaged, or of another version.
    #[error("{problem}")]
    SealedAnswer {
        /// What is wrong with it.
        problem: String,
    },
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A result cannot be put in the form that was asked for.
    #[error("{what} cannot be written: {problem}")]
    Unwritable {
        /// What was to be written.
        what: &'static str,
        /// Why not.
        problem: String,
    },
}

impl Error {
    /// Whether the input is at fault (a file, a name, a value), not the simulation, the disk or this library.
    #[must_use]
    pub fn is_bad_input(&self) -> bool {
        use sealegs_sysid::Error as Campaign;
        match self {
            Self::Campaign(error) => matches!(error, Campaign::BadFile { .. } | Campaign::NoRun { .. }),
            Self::Leg(error) => !matches!(error, LegError::NotFinite { .. } | LegError::Observer(_)),
            Self::Model(error) => !matches!(error, ModelError::NotFinite { .. }),
            Self::Recording(_) | Self::Io { .. } | Self::Unwritable { .. } | Self::Stopped => false,
            Self::Actuator(_)
            | Self::ModelFile { .. }
            | Self::RobotFile { .. }
            | Self::RunScenario { .. }
            | Self::RefusedInput { .. }
            | Self::UnknownEffect { .. }
            | Self::NoSuchEffect { .. }
            | Self::AlreadyIncluded { .. }
            | Self::NoEffect
            | Self::BadEffect { .. }
            | Self::SeveralUnits { .. }
            | Self::NoSuchUnit { .. }
            | Self::WrongModel { .. }
            | Self::Length { .. }
            | Self::WrongLog { .. }
            | Self::BadShard { .. }
            | Self::OtherJobs { .. }
            | Self::NoJobs { .. }
            | Self::JobsMissing { .. }
            | Self::TooShort { .. }
            | Self::NoSuchMystery
            | Self::SealedAnswer { .. } => true,
        }
    }

    /// A file that could not be read or written.
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }

    /// A model that would not load again once written, or cannot be put into words.
    pub(crate) fn model_file(problem: impl std::fmt::Display) -> Self {
        Self::Unwritable { what: "the model file", problem: problem.to_string() }
    }
}

/// Names that a message says at most.
const SOME: usize = 5;

/// The first of some names, and whether there are more.
fn some(names: &[String]) -> String {
    let more = if names.len() > SOME { " and more" } else { "" };
    names[..names.len().min(SOME)].join(", ") + more
}

/// The end of a message that names the units that there are.
fn it_has(units: &[String]) -> String {
    if units.is_empty() {
        ": its runs name fewer than two, and its model file is one".to_owned()
    } else {
        format!("; it has '{}'", units.join("', '"))
    }
}

/// The end of a message that names what comes nearest, if anything does.
fn did_you_mean(suggestions: &[String]) -> String {
    match suggestions {
        [] => "; `sealegs effects` lists it".to_owned(),
        [one] => format!("; did you mean '{one}'?"),
        several => format!("; did you mean one of {}?", several.join(", ")),
    }
}
