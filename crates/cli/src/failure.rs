//! How a failure reaches the shell: one message on standard error, and the exit status.

use std::fmt;

/// Exit status of a run in which a limit stated on the command line was exceeded.
pub const LIMIT_EXCEEDED: u8 = 3;

/// Marks an error as the user's input's fault: exit status 2.
#[derive(Debug)]
struct BadInput(String);

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for BadInput {}

/// An error for bad input with this message.
pub fn bad_input(message: impl fmt::Display) -> anyhow::Error {
    anyhow::Error::new(BadInput(message.to_string()))
}

/// Turns a library's error into one for bad input.
pub trait OrBadInput<T> {
    /// The same value, or the error's whole message marked as bad input.
    fn or_bad_input(self) -> anyhow::Result<T>;
}

impl<T, E: fmt::Display> OrBadInput<T> for Result<T, E> {
    fn or_bad_input(self) -> anyhow::Result<T> {
        self.map_err(|error| bad_input(format!("{error:#}")))
    }
}

/// Prints the error in one line and chooses the exit status.
#[must_use]
pub fn report(error: &anyhow::Error) -> u8 {
    // A reader that has gone away (`| head`) is no failure of ours to talk about.
    if error.chain().any(|e| {
        e.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
    }) {
        return 1;
    }
    eprintln!("sealegs: {}", one_line(&message(error)));
    let bad_input = error.chain().any(|e| {
        e.downcast_ref::<BadInput>().is_some()
            || e.downcast_ref::<sealegs::Error>().is_some_and(sealegs::Error::is_bad_input)
    });
    if bad_input { 2 } else { 1 }
}

/// The error and its causes; a cause that the message before it quotes already is not said twice.
fn message(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |said, cause| match said.as_str() {
        "" => cause,
        text if text.contains(&cause) => said,
        text => format!("{text}: {cause}"),
    })
}

/// A message in one line: it may quote a file's text, line breaks and all.
fn one_line(message: &str) -> String {
    message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_said_once() {
        let source = sealegs::model::ModelError::NotFinite { time_s: 0.5, what: "deflection".to_owned() };
        let error = sealegs::sysid::Error::Model { run: "a.csv".to_owned(), source };
        let error = anyhow::Error::new(sealegs::Error::from(error)).context("while fitting");
        assert_eq!(message(&error), "while fitting: a.csv: deflection is no longer finite at 0.5 s");
    }

    #[test]
    fn a_quoted_line_break_does_not_break_the_message() {
        assert_eq!(one_line("no link 'sh\nank\u{1b}[2J'"), "no link 'sh ank [2J'");
    }
}
