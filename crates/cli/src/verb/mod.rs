//! The verbs: each file holds one verb's arguments and its `run`, which returns the exit status.

use clap::Subcommand;

/// What the program can do.
#[derive(Subcommand)]
pub enum Verb {}

/// Does what was asked.
///
/// # Errors
///
/// Whatever the verb could not do; bad input is marked as such (see `failure`).
pub fn run(verb: Verb) -> anyhow::Result<u8> {
    match verb {}
}
