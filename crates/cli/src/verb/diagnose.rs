//! `sealegs diagnose`: which physical effect is missing.

use super::add::Better;
use crate::failure::bad_input;
use crate::interrupt::EndsSearch;
use crate::jobs::{self, JobArguments};
use crate::kind;
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::diagnosis::provenance::Provenance;
use sealegs::jobs::JobFolder;
use sealegs::{Campaign, ModelSource, Options};
use serde::Deserialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Find the physical effect that the model lacks, or say that none is missing or none is known
#[derive(Args)]
pub struct Diagnose {
    /// The campaign's folder, or its campaign.toml; several are diagnosed one after the other
    #[arg(required = true)]
    campaign: Vec<PathBuf>,
    /// An actuator file in place of the campaign's own actuator, or a scenario file for a leg
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// An effect of your own, as a file with an expression; may be repeated
    #[arg(long, value_name = "OWN.toml")]
    effect: Vec<PathBuf>,
    /// Diagnose although the log is not what its header says (see `sealegs check`)
    #[arg(long)]
    force: bool,
    /// End the search after so many seconds and judge the best set that was found until then
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    at_most: Option<Duration>,
    /// Write the result as JSON (`-` for standard output); of several campaigns a list
    #[arg(long, value_name = "FILE.json", conflicts_with = "jobs")]
    json: Option<PathBuf>,
    /// Write a report as one HTML file
    #[arg(long, value_name = "FILE.html", conflicts_with = "jobs")]
    report: Option<PathBuf>,
    /// Write measured, before, after and residuals as a recording
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "jobs")]
    rrd: Option<PathBuf>,
    /// Write the next experiment as a file that can be played: an input's CSV, or a leg's scenario
    #[arg(long, value_name = "FILE", conflicts_with = "jobs")]
    plan: Option<PathBuf>,
    /// Where no known effect explains everything, write the curve that does as an effect's file for `add`
    #[arg(long, value_name = "LAW.toml", conflicts_with = "jobs")]
    law: Option<PathBuf>,
    /// Write the model with the named effects at the verdict's values, as `add` does but without another fit; for a campaign
    /// of several units, one BETTER-UNIT.toml each
    #[arg(long, value_name = "BETTER.toml", conflicts_with = "jobs")]
    better: Option<PathBuf>,
    #[command(flatten)]
    jobs: JobArguments,
}

/// A time in seconds.
fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.ok_or_else(|| format!("'{text}' is no time in seconds"))
}

/// The verb's name in lists of jobs.
pub(super) const VERB: &str = "diagnose";

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a campaign, model or effect file with an error in it, and for a log that is not what its header says,
/// unless forced; otherwise if an output file cannot
/// be written or nothing can be simulated.
pub fn run(arguments: &Diagnose) -> anyhow::Result<u8> {
    let campaigns: Vec<Campaign> =
        arguments.campaign.iter().map(|path| kind::campaign(path)).collect::<anyhow::Result<_>>()?;
    if let Some(folder) = &arguments.jobs.jobs {
        return work(arguments, folder, &campaigns);
    }
    let [campaign] = &campaigns[..] else { return several(arguments, &campaigns) };
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;
    let plan_file = Destination::optional(arguments.plan.as_ref())?;
    let law_file = Destination::optional(arguments.law.as_ref())?;
    let better = arguments.better.as_ref().map(|path| Better::new(path, campaign)).transpose()?;

    let diagnosis = diagnose(arguments, campaign)?;
    if let Some(destination) = report {
        destination.write(diagnosis.to_html()?.as_bytes())?;
    }
    if let Some(destination) = rrd {
        destination.record(&diagnosis.recording()?)?;
    }
    if let Some(destination) = plan_file {
        let folder = arguments.plan.as_deref().and_then(Path::parent).unwrap_or(Path::new("."));
        if let Some(text) = diagnosis.plan(folder)? {
            destination.write(text.as_bytes())?;
        }
    }
    if let Some(destination) = law_file
        && let Some(text) = diagnosis.law_file()?
    {
        destination.write(text.as_bytes())?;
    }
    if let Some(destination) = json {
        destination.write((diagnosis.to_json()? + "\n").as_bytes())?;
    }
    let to_stdout = |path: &Option<PathBuf>| path.as_deref() == Some(Path::new("-"));
    let taken = [&arguments.json, &arguments.plan, &arguments.law, &arguments.report, &arguments.better];
    let says = !taken.into_iter().any(to_stdout);
    if says {
        write!(std::io::stdout().lock(), "{}", diagnosis.to_text())?;
    }
    if let (Some(better), Some(addition)) = (better, diagnosis.better()) {
        let written = better.write(&addition)?;
        if says {
            writeln!(
                std::io::stdout().lock(),
                "\nthe model with {} is written to {written}",
                addition.added().effects.join(" + ")
            )?;
        }
    }
    Ok(0)
}

/// Diagnoses one campaign as the arguments say.
fn diagnose(arguments: &Diagnose, campaign: &Campaign) -> anyhow::Result<sealegs::Diagnosis> {
    let bar = progress::spinner();
    let options = Options::new()
        .model(ModelSource::from(arguments.model.as_deref()))
        .force(arguments.force)
        .command(crate::command())
        .on_progress(progress::on(&bar));
    let options = arguments.effect.iter().fold(options, Options::own_effect);
    let options = arguments.at_most.into_iter().fold(options, Options::search_at_most);
    let interruptible = EndsSearch::new(options.stop_handle(), &bar);
    let diagnosis = sealegs::diagnose(campaign, options);
    drop(interruptible);
    bar.finish();
    Ok(diagnosis?)
}

/// Diagnoses several campaigns, one after the other.
fn several(arguments: &Diagnose, campaigns: &[Campaign]) -> anyhow::Result<u8> {
    let of_one = [
        ("report", &arguments.report),
        ("rrd", &arguments.rrd),
        ("plan", &arguments.plan),
        ("law", &arguments.law),
        ("better", &arguments.better),
    ];
    if let Some((option, _)) = of_one.iter().find(|(_, path)| path.is_some()) {
        return Err(bad_input(format!("--{option}: is one campaign's, and {} are given", campaigns.len())));
    }
    let json = Destination::optional(arguments.json.as_ref())?;
    let texts = campaigns.iter().map(|campaign| Ok(diagnose(arguments, campaign)?.to_json()?));
    say(&texts.collect::<anyhow::Result<Vec<String>>>()?, json)
}

/// Does a shard of the campaigns.
fn work(arguments: &Diagnose, folder: &Path, campaigns: &[Campaign]) -> anyhow::Result<u8> {
    let model = ModelSource::from(arguments.model.as_deref());
    let others: Vec<&Path> = (arguments.model.iter().filter(|path| path.is_file()))
        .chain(&arguments.effect)
        .map(PathBuf::as_path)
        .collect();
    let inputs = campaigns
        .iter()
        .map(|c| Ok(Provenance::of_campaign(c, model.label(c), &others)?.inputs))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let model = arguments.model.as_ref().map(|path| path.display().to_string());
    let about = serde_json::json!({ "inputs": inputs, "model": model, "force": arguments.force });
    let names: Vec<&str> = campaigns.iter().map(|c| c.name.as_str()).collect();
    jobs::work(folder, arguments.jobs.shard, jobs::list(VERB, about, &names), |number| {
        Ok(diagnose(arguments, &campaigns[number])?.outcome().clone())
    })
}

/// Puts the diagnoses of a folder together.
///
/// # Errors
///
/// Bad input where one is missing; otherwise if the file cannot be written.
pub(super) fn merge(folder: &JobFolder, json: Option<Destination>) -> anyhow::Result<u8> {
    say(&folder.texts()?, json)
}

/// What is printed of each of several diagnoses.
#[derive(Deserialize)]
struct Said {
    campaign: String,
    sentence: String,
}

/// Writes the list of diagnoses, whose texts are given, and a sentence of each.
fn say(texts: &[String], json: Option<Destination>) -> anyhow::Result<u8> {
    let to_stdout = json.as_ref().is_some_and(|destination| destination.part().is_none());
    if let Some(destination) = json {
        destination.write(format!("[\n{}\n]\n", texts.join(",\n")).as_bytes())?;
    }
    if !to_stdout {
        let mut out = std::io::stdout().lock();
        for text in texts {
            let said: Said = serde_json::from_str(text)?;
            writeln!(out, "{}: {}", said.campaign, said.sentence)?;
        }
    }
    Ok(0)
}
