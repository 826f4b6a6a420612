//! The verbs: each file holds one verb's arguments and its `run`, which returns the exit status.

mod impact;
mod list;
mod run;

use clap::Subcommand;

/// What the program can do.
#[derive(Subcommand)]
pub enum Verb {
    Run(run::Run),
    Impact(impact::Impact),
    List(list::List),
}

/// Does what was asked.
///
/// # Errors
///
/// Whatever the verb could not do; bad input is marked as such (see `failure`).
pub fn run(verb: Verb) -> anyhow::Result<u8> {
    match verb {
        Verb::Run(arguments) => run::run(&arguments),
        Verb::Impact(arguments) => impact::run(&arguments),
        Verb::List(arguments) => list::run(&arguments),
    }
}
