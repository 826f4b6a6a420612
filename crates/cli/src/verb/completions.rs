//! `sealegs completions`: what a shell needs to complete the command line.

use clap::Args;
use clap_complete::Shell;
use std::io::Write as _;

/// Print the completions of a shell: `sealegs completions bash > /etc/bash_completion.d/sealegs`.
#[derive(Args)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

/// Runs the verb.
///
/// # Errors
///
/// If standard output cannot be written.
pub fn run(arguments: &Completions) -> anyhow::Result<u8> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::command_line(), "sealegs", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(0)
}
