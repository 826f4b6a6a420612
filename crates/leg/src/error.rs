//! What can go wrong with a robot, a scenario or a run.

use crate::robot::RobotFault;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LegError {
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// Why not.
        source: std::io::Error,
    },
    /// A robot's URDF, mesh or placement file is not usable.
    #[error("{}: {element}: {fault}", at(file, *line))]
    Robot {
        /// The file.
        file: String,
        /// The line in it, where known.
        line: Option<u32>,
        /// The element or field, for example `link 'shank' inertial`.
        element: String,
        /// What is wrong.
        fault: Box<RobotFault>,
    },
    /// An actuator's file, its spring setting or its linkage is not usable.
    #[error(transparent)]
    Actuator(Box<sealegs_actuator::ActuatorError>),
    /// No robot is embedded under this name, and no file has it.
    #[error("no robot '{name}': neither a file nor one of {}{}", known.join(", "), did_you_mean(suggestion.as_deref()))]
    UnknownRobot {
        /// What was asked for.
        name: String,
        /// The embedded robots.
        known: Vec<String>,
        /// The nearest of them, if one is near.
        suggestion: Option<String>,
    },
    /// No scenario is embedded under this name, and no file has it.
    #[error("no scenario '{name}': neither a file nor one of {}{}", known.join(", "), did_you_mean(suggestion.as_deref()))]
    UnknownScenario {
        /// What was asked for.
        name: String,
        /// The embedded scenarios.
        known: Vec<String>,
        /// The nearest of them, if one is near.
        suggestion: Option<String>,
    },
    /// A key of a scenario, or an override, is not usable.
    #[error("{file}: {field}: {problem}")]
    Scenario {
        /// The file, or the override as given.
        file: String,
        /// The key, dotted.
        field: String,
        /// What is wrong, with the value.
        problem: String,
    },
    /// The state is no longer finite.
    #[error("{what} is no longer finite at {time_s:.6} s")]
    NotFinite {
        /// When, s.
        time_s: f64,
        /// The body, joint or actuator.
        what: String,
    },
    /// An observer of a run could not go on.
    #[error("{0}")]
    Observer(String),
}

impl LegError {
    /// A key of a scenario that is not usable.
    pub(crate) fn scenario(file: &str, field: &str, problem: String) -> Self {
        Self::Scenario { file: file.to_owned(), field: field.to_owned(), problem }
    }
}

impl From<sealegs_actuator::ActuatorError> for LegError {
    fn from(error: sealegs_actuator::ActuatorError) -> Self {
        Self::Actuator(Box::new(error))
    }
}

/// `file:line`, or `file` alone.
fn at(file: &str, line: Option<u32>) -> String {
    line.map_or_else(|| file.to_owned(), |l| format!("{file}:{l}"))
}

/// `; did you mean 'x'?` where there is a suggestion.
pub(crate) fn did_you_mean(suggestion: Option<&str>) -> String {
    suggestion.map_or_else(String::new, |s| format!("; did you mean '{s}'?"))
}

/// The same with the candidate nearest to `name`.
pub(crate) fn meant<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    did_you_mean(nearest(name, candidates).as_deref())
}

/// The candidate nearest to `name`, if it is near enough to be what was meant.
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    candidates
        .into_iter()
        .map(|c| (strsim::normalized_damerau_levenshtein(name, c), c))
        .filter(|(similarity, _)| *similarity >= 0.5)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c.to_owned())
}
