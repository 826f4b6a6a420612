//! `sealegs add`: puts an effect into a model, refits, and writes the better model.

use crate::kind;
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::Options;
use sealegs::diagnosis::named;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Add an effect to a model, refit it on a campaign and write the better model
#[derive(Args)]
pub struct Add {
    /// The effect's id, or the file of your own effect; several, or `a+b`, are fitted together
    #[arg(required_unless_present = "law")]
    effect: Vec<String>,
    /// The file of a law that `diagnose --law` wrote, as if it were named among the effects
    #[arg(long, value_name = "LAW.toml")]
    law: Vec<PathBuf>,
    /// The model: an actuator file, for a leg a scenario file, or a preset
    #[arg(long = "to", value_name = "MODEL.toml")]
    model: PathBuf,
    /// The campaign's folder, or its campaign.toml
    #[arg(long)]
    campaign: PathBuf,
    /// Where to write the better model
    #[arg(short = 'o', long = "output", value_name = "BETTER.toml")]
    output: PathBuf,
    /// Write the result as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Write a report as one HTML file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write measured, before, after and residuals as a recording
    #[arg(long, value_name = "FILE.rrd")]
    rrd: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a file with an error in it or an unknown effect; otherwise if an output file cannot be
/// written or nothing can be simulated.
pub fn run(arguments: &Add) -> anyhow::Result<u8> {
    let started = Instant::now();
    let laws = arguments.law.iter().map(|path| path.display().to_string());
    let asked: Vec<String> = arguments.effect.iter().cloned().chain(laws).collect();
    let (effects, _) = named(&asked)?;
    let campaign = kind::campaign(&arguments.campaign)?;
    let output = Destination::new(&arguments.output)?;
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;

    let bar = progress::spinner();
    let command = format!(
        "sealegs add {} --to {} --campaign {}",
        effects.join(" "),
        arguments.model.display(),
        arguments.campaign.display()
    );
    let options =
        Options::new().model(arguments.model.as_path()).command(command).on_progress(progress::on(&bar));
    let addition = sealegs::add(&asked, &campaign, options);
    bar.finish_and_clear();
    let addition = addition?;

    let folder = arguments.output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let better = addition.model_file(folder)?;
    if let Some(destination) = report {
        destination.write(addition.to_html()?.as_bytes())?;
    }
    if let Some(destination) = rrd {
        destination.record(&addition.recording()?)?;
    }
    output.write(better.as_bytes())?;
    if let Some(destination) = json {
        destination.write((addition.to_json()? + "\n").as_bytes())?;
    }
    let to_stdout = |path: &Path| path == Path::new("-");
    let taken = [Some(&arguments.output), arguments.json.as_ref(), arguments.report.as_ref()];
    if !taken.into_iter().flatten().any(|p| to_stdout(p)) {
        let (simulations, simulated_s) = addition.added().work;
        write!(
            std::io::stdout().lock(),
            "{}\nwritten to {}\n{simulations} simulations, {simulated_s:.0} s of experiment in {:.1} s\n",
            addition.to_text(),
            arguments.output.display(),
            started.elapsed().as_secs_f64()
        )?;
    }
    Ok(0)
}
