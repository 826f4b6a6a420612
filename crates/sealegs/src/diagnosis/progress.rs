//! What a diagnosis is trying, in words.

use crate::Options;
use crate::stoppable::SearchEnd;
use sealegs_sysid::diagnose::Progress;
use std::time::Instant;

/// Sets that a line of progress names.
const NAMED: usize = 3;

/// How a message begins that says what was found so far, and not what is being done.
pub const SO_FAR: &str = "so far ";

/// Share of a longest search from which on the time that is left is said: before, the speed is not known.
const KNOWN_FROM: f64 = 0.05;

/// A diagnosis that is under way.
pub(super) struct Searching<'a> {
    options: &'a Options,
    end: &'a SearchEnd,
    began: Instant,
}

impl<'a> Searching<'a> {
    pub fn of(options: &'a Options, end: &'a SearchEnd) -> Self {
        Self { options, end, began: Instant::now() }
    }

    /// Tells what is being done, and while it searches which share of a longest search is spent and how much time is left at most;
    /// the search can be ended from its begin to its end.
    pub fn tell(&self, doing: &Progress, spent: f64) {
        match doing {
            Progress::Looking => self.end.set_under_way(true),
            Progress::Searched => return self.end.set_under_way(false),
            _ => {}
        }
        let said = message(doing);
        let so_far = matches!(doing, Progress::Better { .. });
        if so_far || !(KNOWN_FROM..1.0).contains(&spent) {
            return self.options.tell(&said);
        }
        let left = self.began.elapsed().as_secs_f64() * (1.0 - spent) / spent;
        let share = 100.0 * spent;
        self.options.tell(&format!("{said} ({share:.0} % of the longest search, at most {left:.0} s more)"));
    }
}

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
        Progress::Searched => "the search is over".to_owned(),
        Progress::Curves => "fitting the curve that is missing at a port".to_owned(),
        Progress::Judging => "scoring the held-out runs".to_owned(),
    }
}
