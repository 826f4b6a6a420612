//! What can go wrong with an actuator file, a spring setting or a design, with the values inside.

use thiserror::Error;

/// Why an actuator could not be loaded, configured or designed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ActuatorError {
    /// The file could not be read.
    #[error("{file}: {reason}")]
    Unreadable {
        /// The file as it was asked for.
        file: String,
        /// What the operating system said.
        reason: String,
    },
    /// The text is no TOML, lacks a key, or has a key that is not known.
    #[error("{file}:{line}:{column}: {message}{}", did_you_mean(.suggestion))]
    Syntax {
        /// The file's name.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        message: String,
        /// The key that was probably meant.
        suggestion: Option<String>,
    },
    /// A value that the physics does not admit.
    #[error("{}{field} = {value}: must be {admitted}", place(.file, .line))]
    Value {
        /// The file's name; empty for a value that came from no file.
        file: String,
        /// Line, from 1, where it can be told.
        line: Option<usize>,
        /// The field's path, for example `motor.rotor_inertia_kg_m2`.
        field: String,
        /// The value as printed.
        value: String,
        /// What is admitted, for example `positive and finite`.
        admitted: String,
    },
    /// No file and no preset has this name.
    #[error("no actuator '{name}'{}; the presets are {}", did_you_mean(.suggestion), known.join(", "))]
    UnknownActuator {
        /// The name that was asked for.
        name: String,
        /// The preset that comes nearest to it.
        suggestion: Option<String>,
        /// All presets.
        known: Vec<String>,
    },
    /// The spring has no such setting.
    #[error("no spring setting '{setting}'{}; this spring takes {takes}", did_you_mean(.suggestion))]
    UnknownSetting {
        /// The setting that was asked for.
        setting: String,
        /// The setting that comes nearest to it.
        suggestion: Option<String>,
        /// What the spring takes.
        takes: String,
    },
    /// No position of the pivot, or no length of the beam, gives this stiffness.
    #[error(
        "no setting of this spring gives {stiffness_n_m} N/m; it reaches {least_n_m:.0} to {greatest_n_m:.0} N/m"
    )]
    StiffnessOutOfReach {
        /// The stiffness that was asked for, N/m.
        stiffness_n_m: f64,
        /// Least that the spring can do, N/m.
        least_n_m: f64,
        /// Greatest that the spring can do, N/m.
        greatest_n_m: f64,
    },
    /// A linkage whose bars do not close at the angle asked for.
    #[error("the linkage does not close at {angle_rad} rad")]
    LinkageOpen {
        /// The crank angle, rad.
        angle_rad: f64,
    },
}

fn did_you_mean(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map(|s| format!("; did you mean '{s}'?")).unwrap_or_default()
}

/// `file:line: `, `file: `, or nothing for a value that came from no file.
fn place(file: &str, line: &Option<usize>) -> String {
    match line {
        _ if file.is_empty() => String::new(),
        Some(line) => format!("{file}:{line}: "),
        None => format!("{file}: "),
    }
}

impl ActuatorError {
    /// A value outside what is admitted, before the file is known.
    pub(crate) fn value(field: impl Into<String>, value: impl ToString, admitted: impl Into<String>) -> Self {
        Self::Value {
            file: String::new(),
            line: None,
            field: field.into(),
            value: value.to_string(),
            admitted: admitted.into(),
        }
    }
}
