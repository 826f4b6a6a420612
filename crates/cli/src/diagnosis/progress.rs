//! A line on the terminal that says what is being tried; nothing at all in a pipe.

use indicatif::{ProgressBar, ProgressStyle};
use sealegs_sysid::diagnose::Progress;
use std::time::Duration;

/// A spinner that names what a diagnosis is trying. Standard error is no terminal: it draws nothing.
#[must_use]
pub fn spinner() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(120));
    bar
}

/// What is being done, in a few words.
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
            let names: Vec<String> = sets.iter().map(|s| s.join(" + ")).collect();
            format!("fitting {} sets: {}", sets.len(), names.join(", "))
        }
        Progress::Judging => "judging on the holdout runs".to_owned(),
    }
}
