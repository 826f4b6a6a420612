//! `sealegs add`: puts an effect into a model, refits, and writes the better model.

use crate::campaign_model::inputs_of;
use crate::diagnosis::addition::{Added, add};
use crate::diagnosis::outcome::{Outcome, Ranked, Work, parameters, percent};
use crate::diagnosis::provenance::Provenance;
use crate::diagnosis::story::{Sides, Story};
use crate::diagnosis::{page, progress, text};
use crate::failure::{OrBadInput, bad_input};
use crate::output::Destination;
use crate::{campaign_model, comparison};
use clap::Args;
use sealegs_actuator::effect::OwnEffect;
use sealegs_recorder::recording::Output;
use sealegs_sysid::Campaign;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Add an effect to a model, refit it on a campaign and write the better model
#[derive(Args)]
pub struct Add {
    /// The effect's id, or the file of your own effect; several, or `a+b`, are fitted together
    #[arg(required = true)]
    effect: Vec<String>,
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
    let mut campaign = Campaign::read(&arguments.campaign).or_bad_input()?;
    let (effects, own) = named(&arguments.effect)?;
    let model = campaign_model::with_own_effects(&mut campaign, Some(&arguments.model), &own)?;
    campaign.require(sealegs_sysid::Role::Fit).or_bad_input()?;
    let output = Destination::new(&arguments.output)?;
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;

    let bar = progress::spinner();
    let added = add(&campaign, model.as_ref(), &effects, &|message| bar.set_message(message));
    bar.finish_and_clear();
    let added = added?;

    let mut others: Vec<&Path> = own.iter().map(PathBuf::as_path).collect();
    others.extend(Some(arguments.model.as_path()).filter(|p| p.is_file()));
    let provenance = Provenance::of_campaign(&campaign, model.name(), &others)?;
    let command = format!(
        "sealegs add {} --to {} --campaign {}",
        effects.join(" "),
        arguments.model.display(),
        arguments.campaign.display()
    );
    let from = [
        ("command", command.clone()),
        ("version", format!("sealegs {}", provenance.version)),
        ("model", arguments.model.display().to_string()),
        inputs_of(&provenance),
    ];
    let folder = arguments.output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let better = model.better(&added, &campaign, &from, folder)?;
    if report.is_some() || rrd.is_some() {
        let outcome = outcome(&campaign, &added, provenance.clone());
        let sides = Sides {
            base: &added.before,
            base_holdout: added.before_holdout.as_ref(),
            after: Some(&added.after),
            after_holdout: added.after_holdout.as_ref(),
        };
        let story = Story::new(&campaign, &outcome, &sides, None, command)?;
        if let Some(destination) = report {
            destination.write(page(&story).as_bytes())?;
        }
        if let Some(destination) = rrd {
            let recording = comparison::recording(&story.compared, outcome.sentence.clone());
            if let Some(part) = destination.part() {
                recording.write(&Output::File(part.to_owned()))?;
            }
            destination.finish()?;
        }
    }
    let summary = added.summary(&campaign, provenance);
    output.write(better.as_bytes())?;
    if let Some(destination) = json {
        destination.write((serde_json::to_string_pretty(&summary)? + "\n").as_bytes())?;
    }
    let to_stdout = |path: &Path| path == Path::new("-");
    let taken = [Some(&arguments.output), arguments.json.as_ref(), arguments.report.as_ref()];
    if !taken.into_iter().flatten().any(|p| to_stdout(p)) {
        let text = printed(arguments, &added, started.elapsed().as_secs_f64());
        write!(std::io::stdout().lock(), "{text}")?;
    }
    Ok(0)
}

/// Ids of the effects that are asked for, and the files of those that a user wrote.
fn named(asked: &[String]) -> anyhow::Result<(Vec<String>, Vec<PathBuf>)> {
    let (mut ids, mut own) = (Vec::new(), Vec::new());
    for argument in asked {
        let whole = Path::new(argument).is_file();
        let parts: Vec<&str> =
            if whole { vec![argument] } else { argument.split('+').map(str::trim).collect() };
        for part in parts {
            let path = Path::new(part);
            let id = if path.is_file() {
                let effect = OwnEffect::load(path).or_bad_input()?;
                own.push(path.to_owned());
                effect.table().get("id").and_then(|id| id.as_str()).unwrap_or_default().to_owned()
            } else if part.ends_with(".toml") {
                return Err(bad_input(format!("{part}: no such file")));
            } else {
                part.to_owned()
            };
            if id.is_empty() {
                return Err(bad_input(format!("'{argument}': an effect's name is empty")));
            }
            if ids.contains(&id) {
                return Err(bad_input(format!("'{id}' is named twice")));
            }
            ids.push(id);
        }
    }
    Ok((ids, own))
}

/// The addition in the form that the report shows.
fn outcome(campaign: &Campaign, added: &Added, provenance: Provenance) -> Outcome {
    let base = Added::side(&added.before, added.before_holdout.as_ref());
    let after = Added::side(&added.after, added.after_holdout.as_ref());
    let floor = campaign.noise_floor();
    let excess = |error: f64| (error * error - floor * floor).max(0.0);
    let share = if excess(base.holdout_error) > 0.0 {
        (excess(after.holdout_error) / excess(base.holdout_error)).min(1.0)
    } else {
        0.0
    };
    let runs = if added.before_holdout.is_some() { "held-out" } else { "fit" };
    let sentence = format!(
        "Added {}: the error on the {runs} runs goes from {:.3} to {:.3} noise units (floor {floor:.2}); {} of the energy above \
         the floor is left.",
        added.effects.join(" + "),
        base.holdout_error,
        after.holdout_error,
        percent(share)
    );
    let left = |c: &sealegs_sysid::diagnose::Candidate| c.validation.mean_square();
    let residuals = added.before.validation.residuals as f64;
    Outcome {
        campaign: campaign.name.clone(),
        noise_floor: floor,
        ranking: vec![Ranked {
            effects: added.effects.clone(),
            holdout_error: after.holdout_error,
            evidence: 0.5 * (left(&added.before) - left(&added.after)) * residuals
                / left(&added.after).max(1.0),
            parameters: parameters(&added.after.fit),
        }],
        base,
        verdict: "added",
        effects: added.effects.clone(),
        indistinguishable: Vec::new(),
        same_by_another_name: Vec::new(),
        equally_good_choices: Vec::new(),
        after: Some(after),
        unexplained_share: share,
        next_experiment: String::new(),
        sentence,
        remainder: Vec::new(),
        sanity: Vec::new(),
        notes: campaign.notes.clone(),
        work: Work { simulations: added.work.0, simulated_s: added.work.1 },
        provenance,
    }
}

fn printed(arguments: &Add, added: &Added, seconds: f64) -> String {
    let mut out = String::new();
    let o = &mut out;
    let _ = writeln!(o, "{} with {}", added.before.model.name(), added.effects.join(" + "));
    let _ = writeln!(o, "\n  error in noise units      before      after");
    let (b, a) = (added.before.fit.error(), added.after.fit.error());
    let _ = writeln!(o, "  {:<22} {b:>9.3} {a:>10.3}", "fit runs");
    match (&added.before_holdout, &added.after_holdout) {
        (Some(b), Some(a)) => {
            let _ = writeln!(o, "  {:<22} {:>9.3} {:>10.3}", "held-out runs", b.rms, a.rms);
        }
        _ => {
            let _ = writeln!(
                o,
                "  no held-out runs: nothing judges the effect but the runs that it was fitted to"
            );
        }
    }
    let _ = writeln!(o, "\n  parameters");
    out.push_str(&text::parameter_lines(&parameters(&added.after.fit)));
    let _ = writeln!(out, "\nwritten to {}", arguments.output.display());
    let _ =
        writeln!(out, "{} simulations, {:.0} s of experiment in {seconds:.1} s", added.work.0, added.work.1);
    out
}
