//! `sealegs reproduce`: the dissertation's numbers recomputed by our own models, misses included.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::output::Destination;
use crate::reproduce::{reproduce, text};

/// Recompute the numbers of the dissertation "Series Elasticity in Linearly Actuated Humanoids".
#[derive(Args)]
pub struct Reproduce {
    /// Write the rows as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Show every row, not only the misses
    #[arg(long)]
    all: bool,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input if a file cannot be written; otherwise only if a simulation fails.
pub fn run(arguments: &Reproduce) -> anyhow::Result<u8> {
    let json = Destination::optional(arguments.json.as_ref())?;
    let json_to_stdout = arguments.json.as_deref() == Some(Path::new("-"));
    let reproduction = reproduce()?;
    if let Some(destination) = json {
        let mut text = serde_json::to_string_pretty(&text::json(&reproduction))?;
        text.push('\n');
        destination.write(text.as_bytes())?;
    }
    if !json_to_stdout {
        write!(std::io::stdout().lock(), "{}", text::table(&reproduction, arguments.all))?;
    }
    Ok(0)
}
