//! `sealegs diagnose`: which physical effect is missing.

use crate::diagnosis::outcome::Outcome;
use crate::diagnosis::provenance::Provenance;
use crate::diagnosis::story::{Sides, Story};
use crate::diagnosis::{page, progress, text};
use crate::failure::OrBadInput;
use crate::output::Destination;
use crate::{campaign_model, comparison};
use clap::Args;
use sealegs_recorder::recording::Output;
use sealegs_sysid::{Campaign, Role, diagnose, sanity};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Find the physical effect that the model lacks, or say that none is missing or none is known
#[derive(Args)]
pub struct Diagnose {
    /// The campaign's folder, or its campaign.toml
    campaign: PathBuf,
    /// An actuator file in place of the campaign's own actuator, or a scenario file for a leg
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// An effect of your own, as a file with an expression; may be repeated
    #[arg(long, value_name = "OWN.toml")]
    effect: Vec<PathBuf>,
    /// Diagnose although the log is not what its header says (see `sealegs check`)
    #[arg(long)]
    force: bool,
    /// Write the result as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Write a report as one HTML file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write measured, before, after and residuals as a recording
    #[arg(long, value_name = "FILE.rrd")]
    rrd: Option<PathBuf>,
    /// Write the next experiment as a file that can be played: an input's CSV, or a leg's scenario
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a campaign, model or effect file with an error in it, and for a log that is not what its header says,
/// unless forced; otherwise if an output file cannot
/// be written or nothing can be simulated.
pub fn run(arguments: &Diagnose) -> anyhow::Result<u8> {
    let started = Instant::now();
    let mut campaign = Campaign::read(&arguments.campaign).or_bad_input()?;
    let model =
        campaign_model::with_own_effects(&mut campaign, arguments.model.as_deref(), &arguments.effect)?;
    campaign.require(Role::Fit).or_bad_input()?;
    campaign.require(Role::Holdout).or_bad_input()?;
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;
    let plan_file = Destination::optional(arguments.plan.as_ref())?;

    let wrong = sanity::look(&campaign, model.as_ref());
    crate::sanity::gate(&arguments.campaign, &wrong, arguments.force)?;
    let bar = progress::spinner();
    let done = diagnose::diagnose(&campaign, model.as_ref(), &diagnose::Options::of(model.as_ref()), &|p| {
        bar.set_message(progress::message(&p));
    });
    bar.set_message("planning the next experiment");
    let planned = done.and_then(|d| {
        let limits = model.limits(&campaign);
        diagnose::next_experiment(&campaign, &d, limits).map(|e| (d, e))
    });
    bar.finish_and_clear();
    let (diagnosis, experiment) = planned?;

    let others: Vec<&Path> = arguments.model.iter().chain(&arguments.effect).map(PathBuf::as_path).collect();
    let provenance = Provenance::of_campaign(&campaign, model.name(), &others)?;
    let next = match &experiment {
        Some(e) => e.sentence.clone(),
        None => "There is nothing to tell apart, and so no experiment to propose.".to_owned(),
    };
    let outcome = Outcome::new(&campaign, &diagnosis, next, wrong, provenance);
    if report.is_some() || rrd.is_some() {
        let command = std::env::args().collect::<Vec<_>>().join(" ");
        let sides = Sides::of(&diagnosis);
        let story = Story::new(&campaign, &outcome, &sides, experiment.as_ref(), command)?;
        if let Some(destination) = report {
            destination.write(page(&story).as_bytes())?;
        }
        if let Some(destination) = rrd {
            let recording = comparison::recording(
                &story.compared,
                format!(
                    "{}\n\n{}\n\n{}",
                    outcome.sentence,
                    outcome.remainder.join(" "),
                    outcome.next_experiment
                ),
            );
            if let Some(part) = destination.part() {
                recording.write(&Output::File(part.to_owned()))?;
            }
            destination.finish()?;
        }
    }
    if let (Some(destination), Some(experiment)) = (plan_file, &experiment) {
        let folder = arguments.plan.as_deref().and_then(Path::parent).unwrap_or(Path::new("."));
        if let Some(text) = model.plan(experiment, folder)? {
            destination.write(text.as_bytes())?;
        }
    }
    if let Some(destination) = json {
        destination.write((serde_json::to_string_pretty(&outcome)? + "\n").as_bytes())?;
    }
    let to_stdout = |path: &Option<PathBuf>| path.as_deref() == Some(Path::new("-"));
    if ![&arguments.json, &arguments.plan, &arguments.report].into_iter().any(to_stdout) {
        write!(std::io::stdout().lock(), "{}", text::of(&outcome, started.elapsed()))?;
    }
    Ok(0)
}
