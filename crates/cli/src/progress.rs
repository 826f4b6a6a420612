//! A line on the terminal that says what is being tried; nothing at all in a pipe.

use indicatif::{ProgressBar, ProgressStyle};
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

/// Shows on the spinner what is being tried.
pub fn on(bar: &ProgressBar) -> impl Fn(&str) + Send + Sync + use<> {
    let bar = bar.clone();
    move |what| bar.set_message(what.to_owned())
}
