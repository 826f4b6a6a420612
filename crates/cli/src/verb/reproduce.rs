//! `sealegs reproduce`: the dissertation's numbers recomputed by our own models, misses included.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::output::Destination;
use sealegs_reproduce::{html, reproduce, text};

/// Recompute the numbers of the dissertation "Series Elasticity in Linearly Actuated Humanoids".
#[derive(Args)]
pub struct Reproduce {
    /// Write the rows as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Write a page with the figures and every row
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Print every row, not only the misses
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
    let report = Destination::optional(arguments.report.as_ref())?;
    let reproduction = reproduce()?;
    if let Some(destination) = json {
        let mut text = serde_json::to_string_pretty(&text::json(&reproduction))?;
        text.push('\n');
        destination.write(text.as_bytes())?;
    }
    if let Some(destination) = report {
        let command = crate::command();
        destination.write(html(&reproduction, &command)?.as_bytes())?;
    }
    let to_stdout = |p: &Option<PathBuf>| p.as_deref() == Some(Path::new("-"));
    if !to_stdout(&arguments.json) && !to_stdout(&arguments.report) {
        write!(std::io::stdout().lock(), "{}", text::table(&reproduction, arguments.all))?;
    }
    Ok(0)
}
