//! `sealegs diagnose`: which physical effect is missing.

use crate::bench_model;
use crate::diagnosis::outcome::Outcome;
use crate::diagnosis::provenance::Provenance;
use crate::diagnosis::{floor, progress, text};
use crate::failure::OrBadInput;
use crate::output::Destination;
use clap::Args;
use sealegs_model::Model;
use sealegs_sysid::{Campaign, Role, diagnose};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Find the physical effect that the model lacks, or say that none is missing or none is known.
#[derive(Args)]
pub struct Diagnose {
    /// The campaign's folder, or its campaign.toml
    campaign: PathBuf,
    /// An actuator file in place of the campaign's own actuator
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Write the result as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a campaign, model or effect file with an error in it; otherwise if an output file cannot
/// be written or nothing can be simulated.
pub fn run(arguments: &Diagnose) -> anyhow::Result<u8> {
    let started = Instant::now();
    let mut campaign = Campaign::read(&arguments.campaign).or_bad_input()?;
    let model = bench_model::of_campaign(&mut campaign, arguments.model.as_deref())?;
    campaign.require(Role::Fit).or_bad_input()?;
    campaign.require(Role::Holdout).or_bad_input()?;
    let json = Destination::optional(arguments.json.as_ref())?;

    let options = diagnose::Options { floor: floor(&campaign, &model), ..Default::default() };
    let bar = progress::spinner();
    let diagnosis =
        diagnose::diagnose(&campaign, &model, &options, &|p| bar.set_message(progress::message(&p)));
    bar.finish_and_clear();
    let diagnosis = diagnosis?;

    let others: Vec<&Path> = arguments.model.iter().map(PathBuf::as_path).collect();
    let provenance = Provenance::of_campaign(&campaign, model.name(), &others)?;
    let outcome = Outcome::new(&campaign, &diagnosis, String::new(), provenance);
    if let Some(destination) = json {
        destination.write((serde_json::to_string_pretty(&outcome)? + "\n").as_bytes())?;
    }
    if arguments.json.as_deref() != Some(Path::new("-")) {
        write!(std::io::stdout().lock(), "{}", text::of(&outcome, started.elapsed()))?;
    }
    Ok(0)
}
