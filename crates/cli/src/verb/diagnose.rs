//! `sealegs diagnose`: which physical effect is missing.

use crate::kind;
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::{ModelSource, Options};
use std::io::Write;
use std::path::{Path, PathBuf};

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
    /// Where no known effect explains everything, write the curve that does as an effect's file for `add`
    #[arg(long, value_name = "LAW.toml")]
    law: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a campaign, model or effect file with an error in it, and for a log that is not what its header says,
/// unless forced; otherwise if an output file cannot
/// be written or nothing can be simulated.
pub fn run(arguments: &Diagnose) -> anyhow::Result<u8> {
    let campaign = kind::campaign(&arguments.campaign)?;
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;
    let plan_file = Destination::optional(arguments.plan.as_ref())?;
    let law_file = Destination::optional(arguments.law.as_ref())?;

    let bar = progress::spinner();
    let options = Options::new()
        .model(ModelSource::from(arguments.model.as_deref()))
        .force(arguments.force)
        .command(crate::command())
        .on_progress(progress::on(&bar));
    let options = arguments.effect.iter().fold(options, Options::own_effect);
    let diagnosis = sealegs::diagnose(&campaign, options);
    bar.finish_and_clear();
    let diagnosis = diagnosis?;

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
    if ![&arguments.json, &arguments.plan, &arguments.law, &arguments.report].into_iter().any(to_stdout) {
        write!(std::io::stdout().lock(), "{}", diagnosis.to_text())?;
    }
    Ok(0)
}
