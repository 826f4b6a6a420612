//! `sealegs compare`: where the model fails, and by how much.

use crate::kind;
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::{ModelSource, Options};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Show where the model fails on a campaign, and by how much
#[derive(Args)]
pub struct Compare {
    /// The campaign's folder, or its campaign.toml
    campaign: PathBuf,
    /// An actuator file in place of the campaign's own actuator, or a scenario file for a leg
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Compare with the model file's own values, without a refit
    #[arg(long)]
    as_is: bool,
    /// Write the result as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Write a report as one HTML file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write measured, predicted and residual as a recording
    #[arg(long, value_name = "FILE.rrd")]
    rrd: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a campaign or model file with an error in it; otherwise if an output file cannot be written
/// or the model cannot be simulated.
pub fn run(arguments: &Compare) -> anyhow::Result<u8> {
    let campaign = kind::campaign(&arguments.campaign)?;
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;

    let bar = progress::spinner();
    let options = Options::new()
        .model(ModelSource::from(arguments.model.as_deref()))
        .as_is(arguments.as_is)
        .command(crate::command())
        .on_progress(progress::on(&bar));
    let comparison = sealegs::compare(&campaign, options);
    bar.finish();
    let comparison = comparison?;
    if let Some(destination) = rrd {
        destination.record(&comparison.recording()?)?;
    }
    if let Some(destination) = report {
        destination.write(comparison.to_html()?.as_bytes())?;
    }
    if let Some(destination) = json {
        destination.write((comparison.to_json()? + "\n").as_bytes())?;
    }
    if arguments.json.as_deref() != Some(Path::new("-")) {
        for note in sealegs::notes::together(&comparison.campaign().notes) {
            eprintln!("sealegs: note: {note}");
        }
        write!(std::io::stdout().lock(), "{}", comparison.to_text()?)?;
    }
    Ok(0)
}
