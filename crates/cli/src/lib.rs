//! The program `sealegs` as a library, so that tests call what the verbs call: one file per verb in [`verb`],
//! what they share in [`failure`] and [`output`].
//!
//! Exit status: 0 done, 2 bad input, 3 a limit stated on the command line was passed, 1 anything else.

pub mod bench_model;
pub mod campaign_model;
pub mod comparison;
pub mod diagnosis;
pub mod failure;
pub mod leg_model;
mod leg_scene;
pub mod mystery;
pub mod output;
pub mod reproduce;
pub mod robot_model;
pub mod verb;

use clap::Parser;

/// A sandbox for humanoid legs driven by linear series elastic actuators.
#[derive(Parser)]
#[command(
    name = "sealegs",
    version,
    about = "A sandbox for humanoid legs driven by linear series elastic actuators, and the finding of what its models lack",
    arg_required_else_help = true
)]
struct Arguments {
    #[command(subcommand)]
    verb: verb::Verb,
}

/// Runs the command line of this process.
#[must_use]
pub fn run() -> std::process::ExitCode {
    output::remove_unfinished_on_interrupt();
    match verb::run(Arguments::parse().verb) {
        Ok(status) => std::process::ExitCode::from(status),
        Err(error) => failure::report(&error),
    }
}
