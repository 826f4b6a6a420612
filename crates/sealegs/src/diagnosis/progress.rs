//! What a diagnosis is trying, in words.

use sealegs_sysid::diagnose::Progress;

/// Sets that a line of progress names.
const NAMED: usize = 3;

/// How a message begins that says what was found so far, and not what is being done.
pub const SO_FAR: &str = "so far ";

/// What is being done, in a few words, or the best set so far (after [`SO_FAR`]).
#[must_use]
pub fn message(progress: &Progress) -> String {
    match progress {
        Progress::Base => "refitting the base model's own parameters".to_owned(),
        Progress::Looking => "estimating what is missing at each port".to_owned(),
        Progress::Screening { beside } if beside.is_empty() => {
            "screening every effect beside the base model".to_owned()
        }
        Progress::Screening { beside } => format!("screening beside {}", beside.join(" + ")),
        Progress::Fitting { sets } => {
            let names: Vec<String> = sets.iter().take(NAMED).map(|s| s.join(" + ")).collect();
            let more = match sets.len().saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            format!("fitting {} sets: {}{more}", sets.len(), names.join(", "))
        }
        Progress::Better { set, base, error } => {
            format!("{SO_FAR}{}: {base:.3} -> {error:.3} noise units on the fit runs", set.join(" + "))
        }
        Progress::Curves => "fitting the curve that is missing at a port".to_owned(),
        Progress::Judging => "scoring the held-out runs".to_owned(),
    }
}
