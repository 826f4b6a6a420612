//! `sealegs compare`: where the model fails, and by how much.

use crate::failure::OrBadInput;
use crate::output::Destination;
use clap::Args;
use sealegs::campaign_model;
use sealegs::comparison;
use sealegs::diagnosis::provenance::Provenance;
use sealegs_recorder::recording::Output;
use sealegs_sysid::Campaign;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

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
    let started = Instant::now();
    let mut campaign = Campaign::read(&arguments.campaign).or_bad_input()?;
    let model = campaign_model::of_campaign(&mut campaign, arguments.model.as_deref())?;
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;

    let level = campaign.noise_floor();
    let compared = comparison::compare(&campaign, model.as_ref(), level, arguments.as_is)?;
    let took = started.elapsed();

    let others: Vec<&Path> = arguments.model.iter().map(PathBuf::as_path).collect();
    let provenance = Provenance::of_campaign(&campaign, model.name(), &others)?;
    if let Some(destination) = rrd {
        let recording = comparison::recording(&compared, compared.sentence());
        if let Some(part) = destination.part() {
            recording.write(&Output::File(part.to_owned()))?;
        }
        destination.finish()?;
    }
    if let Some(destination) = report {
        let command = std::env::args().collect::<Vec<_>>().join(" ");
        destination.write(comparison::page(&compared, &command, &provenance).as_bytes())?;
    }
    if let Some(destination) = json {
        let summary = comparison::Summary::new(&compared, provenance);
        destination.write((serde_json::to_string_pretty(&summary)? + "\n").as_bytes())?;
    }
    if arguments.json.as_deref() != Some(Path::new("-")) {
        for note in &campaign.notes {
            eprintln!("sealegs: note: {note}");
        }
        write!(std::io::stdout().lock(), "{}", comparison::text(&compared, took))?;
    }
    Ok(0)
}
