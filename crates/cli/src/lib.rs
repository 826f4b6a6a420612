//! The program `sealegs` as a library, so that tests call what the verbs call: one file per verb in [`verb`],
//! what they share in [`failure`] and [`output`].
//!
//! Exit status: 0 done, 2 bad input, 3 a limit stated on the command line was exceeded, 1 anything else.

pub mod failure;
mod interrupt;
mod jobs;
mod kind;
pub mod output;
pub mod progress;
pub mod verb;

use clap::{CommandFactory, Parser};
use std::ffi::OsString;
use std::sync::OnceLock;

/// A sandbox for humanoid legs driven by linear series elastic actuators.
#[derive(Parser)]
#[command(
    name = "sealegs",
    version = VERSION,
    about = "Simulate humanoid legs driven by linear series elastic actuators, and find the effects that its models lack",
    arg_required_else_help = true
)]
struct Arguments {
    #[command(subcommand)]
    verb: verb::Verb,
    /// Say in a pipe, too, what is being done: a line for each step and every ten seconds on standard error.
    #[arg(long, global = true)]
    progress: bool,
}

/// The version, and the commit that it was built from where that is known.
const VERSION: &str = env!("SEALEGS_VERSION");

/// The whole command line as clap has it, for man pages, completions and the reference.
#[must_use]
pub fn command_line() -> clap::Command {
    Arguments::command()
}

/// Runs the command line of this process.
#[must_use]
pub fn run() -> std::process::ExitCode {
    std::process::ExitCode::from(run_with(std::env::args_os()))
}

/// Runs a command line, the program's name first; returns the exit status.
///
/// Ctrl-C ends the process from here on, after the unfinished files are removed.
#[must_use]
pub fn run_with<A: Into<OsString> + Clone>(arguments: impl IntoIterator<Item = A>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    interrupt::listen();
    let words: Vec<_> = arguments.iter().map(|a| a.to_string_lossy()).collect();
    // Only the first command line of a process counts; there is no second one.
    let _ = COMMAND.set(words.join(" "));
    match Arguments::try_parse_from(&arguments) {
        Ok(arguments) => {
            if arguments.progress {
                progress::in_a_pipe();
            }
            verb::run(arguments.verb).unwrap_or_else(|error| failure::report(&error))
        }
        Err(error) => {
            // Help and errors alike; a closed pipe is nobody's fault.
            let _ = error.print();
            u8::try_from(error.exit_code()).unwrap_or(2)
        }
    }
}

/// The command line as it was given, for what reports say of their origin.
static COMMAND: OnceLock<String> = OnceLock::new();

/// The command line as it was given.
pub(crate) fn command() -> String {
    COMMAND.get().cloned().unwrap_or_default()
}
