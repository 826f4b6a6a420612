//! `sealegs tour`: the whole loop on the shipped drop of a leg; each step shows the command that does the same.

use super::impact;
use super::run::summary as run_summary;
use crate::failure::{OrBadInput, bad_input};
use crate::output::Destination;
use crate::progress;
use anyhow::Context;
use clap::Args;
use sealegs::diagnosis::outcome::Outcome;
use sealegs::leg::impact::{ImpactTable, sweep};
use sealegs::leg::scenario::SweepSpec;
use sealegs::recorder::chart::{Axis, Bar, BarChart, Hue};
use sealegs::recorder::recording::Output;
use sealegs::recorder::report::{Report, Tone};
use sealegs::{Addition, Campaign, Options, Scenario, leg_scene};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Drop a leg, compare it with a shipped recording, find what the model lacks, add it, and see the error fall.
#[derive(Args)]
pub struct Tour {
    /// The folder that the results are left in; those of an earlier tour are replaced.
    #[arg(short = 'o', long = "output", default_value = "tour", value_name = "FOLDER")]
    output: PathBuf,
}

/// The shipped campaign that the tour is about, file by file.
const CAMPAIGN: [(&str, &str); 9] = [
    ("campaign.toml", include_str!("../../../../assets/campaigns/leg-drop/campaign.toml")),
    ("fit-05cm.csv", include_str!("../../../../assets/campaigns/leg-drop/fit-05cm.csv")),
    ("fit-05cm.toml", include_str!("../../../../assets/campaigns/leg-drop/fit-05cm.toml")),
    ("fit-10cm.csv", include_str!("../../../../assets/campaigns/leg-drop/fit-10cm.csv")),
    ("fit-10cm.toml", include_str!("../../../../assets/campaigns/leg-drop/fit-10cm.toml")),
    ("fit-crouched.csv", include_str!("../../../../assets/campaigns/leg-drop/fit-crouched.csv")),
    ("fit-crouched.toml", include_str!("../../../../assets/campaigns/leg-drop/fit-crouched.toml")),
    ("check-upright.csv", include_str!("../../../../assets/campaigns/leg-drop/check-upright.csv")),
    ("check-upright.toml", include_str!("../../../../assets/campaigns/leg-drop/check-upright.toml")),
];

/// The model that the campaign does not fit.
const MODEL: &str = "thor-drop";

/// Drops of the last step, m.
const HEIGHTS_M: [f64; 2] = [0.05, 0.10];

/// Runs the verb.
///
/// # Errors
///
/// Bad input if the folder cannot be written; whatever a step could not do.
pub fn run(arguments: &Tour) -> anyhow::Result<u8> {
    let started = Instant::now();
    let folder = &arguments.output;
    let data = folder.join("leg-drop");
    std::fs::create_dir_all(&data)
        .map_err(|e| bad_input(format!("{}: cannot be made: {e}", data.display())))?;
    for (name, text) in CAMPAIGN {
        Destination::new(&data.join(name))?.write(text.as_bytes())?;
    }
    let campaign = Campaign::read(&data).or_bad_input()?;
    let of_campaign = |verb: &str| format!("sealegs {verb} {}", data.display());

    step("1. The leg drops, and every force in it is recorded.", &format!("sealegs run {MODEL}"))?;
    drop_the_leg(folder)?;
    step("2. The same drops, recorded elsewhere: where does the model fail?", &of_campaign("compare"))?;
    compare(folder, &campaign, of_campaign("compare"))?;
    step("3. Which physical effect is missing, and at which joint?", &of_campaign("diagnose"))?;
    let better = folder.join("better.toml");
    let command = format!("{} --better {}", of_campaign("diagnose"), better.display());
    let (outcome, addition) = diagnose(folder, &campaign, command.clone())?;
    let mut impact = None;
    if let (Some(first), Some(addition)) = (outcome.effects.first(), addition) {
        step("4. It is added, and the error falls.", &command)?;
        Destination::new(&better)?.write(addition.model_file(folder)?.as_bytes())?;
        Destination::new(&folder.join("4-add.json"))?.write((addition.to_json()? + "\n").as_bytes())?;
        print(&addition.to_text())?;
        let heights = HEIGHTS_M.map(|h| h.to_string()).join(",");
        let command = |model: &str| format!("sealegs impact {model} --heights {heights} --springs compliant");
        step("5. How the missing effect changes the predicted impact forces.", &command(MODEL))?;
        let before = drops(MODEL, &folder.join("5-impact-before.json"))?;
        say(&format!("$ {}", command(&better.to_string_lossy())))?;
        let after = drops(&better.to_string_lossy(), &folder.join("5-impact-after.json"))?;
        let place = first.split('/').next().unwrap_or_default();
        let peaks = peaks(&before, &after, place);
        Destination::new(&folder.join("5-impact.html"))?
            .write(impact_page(&peaks, &outcome.effects).as_bytes())?;
        impact = Some(lines(&peaks));
    } else {
        say("Nothing is to be added.")?;
    }
    let page = summary(&outcome, impact.as_deref(), started.elapsed().as_secs_f64());
    let file = folder.join("summary.md");
    Destination::new(&file)?.write(page.as_bytes())?;
    say(&format!("{page}\nThis page is {}; open 3-diagnose.html beside it for the curves.", file.display()))?;
    Ok(0)
}

/// Step 1: one drop, recorded.
fn drop_the_leg(folder: &Path) -> anyhow::Result<()> {
    let scenario = Scenario::load(MODEL, &[]).or_bad_input()?;
    let rrd = Destination::new(&folder.join("1-drop.rrd"))?;
    if let Some(part) = rrd.part() {
        let (_, result) = leg_scene::record(&scenario, Output::File(part.to_owned()))?;
        print(&run_summary(&result))?;
    }
    rrd.finish()
}

/// Step 2: where the model fails.
fn compare(folder: &Path, campaign: &Campaign, command: String) -> anyhow::Result<()> {
    let comparison = sealegs::compare(campaign, Options::new().command(command))?;
    Destination::new(&folder.join("2-compare.html"))?.write(comparison.to_html()?.as_bytes())?;
    Destination::new(&folder.join("2-compare.json"))?.write((comparison.to_json()? + "\n").as_bytes())?;
    print(&comparison.to_text()?)
}

/// Step 3: what is missing, and the model with it.
fn diagnose(
    folder: &Path,
    campaign: &Campaign,
    command: String,
) -> anyhow::Result<(Outcome, Option<Addition>)> {
    let bar = progress::spinner();
    let options = Options::new().command(command).on_progress(progress::on(&bar));
    let diagnosis = sealegs::diagnose(campaign, options);
    bar.finish();
    let diagnosis = diagnosis?;
    Destination::new(&folder.join("3-diagnose.html"))?.write(diagnosis.to_html()?.as_bytes())?;
    Destination::new(&folder.join("3-diagnose.rrd"))?.record(&diagnosis.recording()?)?;
    Destination::new(&folder.join("3-diagnose.json"))?.write((diagnosis.to_json()? + "\n").as_bytes())?;
    print(&diagnosis.to_text())?;
    Ok((diagnosis.outcome().clone(), diagnosis.better()))
}

/// Step 5: a model's drops.
fn drops(model: &str, json: &Path) -> anyhow::Result<ImpactTable> {
    let scenario = Scenario::load(model, &[]).or_bad_input()?;
    let over = SweepSpec { heights_m: HEIGHTS_M.to_vec(), springs: vec!["compliant".to_owned()] };
    let table = sweep(&scenario, &over, false, &|| {}).or_bad_input()?;
    if let Some(why) = table.rows.iter().find_map(|row| row.stopped.as_deref()) {
        anyhow::bail!("a drop of {model} stopped: {why}");
    }
    Destination::new(json)?.write((serde_json::to_string_pretty(&table)? + "\n").as_bytes())?;
    print(&impact::text_of(&table))?;
    Ok(table)
}

/// Prints what a step is about, and the command that does the same.
fn step(about: &str, command: &str) -> anyhow::Result<()> {
    say(about)?;
    say(&format!("$ {command}"))
}

fn say(text: &str) -> anyhow::Result<()> {
    print(&format!("\n{text}\n"))
}

fn print(text: &str) -> anyhow::Result<()> {
    std::io::stdout().lock().write_all(text.as_bytes()).context("standard output")
}

/// A peak force at a drop, without and with what was found.
struct Peak {
    what: String,
    before_n: f64,
    after_n: f64,
}

impl Peak {
    fn change(&self) -> f64 {
        100.0 * (self.after_n / self.before_n - 1.0)
    }
}

/// The peak forces of the ground and of an actuator, drop by drop: the one where the effect is, or else the one that bears most.
fn peaks(before: &ImpactTable, after: &ImpactTable, place: &str) -> Vec<Peak> {
    let actuators = || before.rows.iter().flat_map(|row| &row.actuators);
    let most = actuators().reduce(|a, b| if b.force_1_n.abs() > a.force_1_n.abs() { b } else { a });
    let there = actuators().find(|actuator| actuator.name == place).or(most);
    let actuator = there.map_or("", |actuator| &actuator.name);
    let mut peaks = Vec::new();
    for (b, a) in before.rows.iter().zip(&after.rows) {
        let mut peak = |what: &str, before_n: f64, after_n: f64| {
            let what = format!("{what}, drop from {:.2} m", b.height_m);
            peaks.push(Peak { what, before_n, after_n });
        };
        peak("ground force", b.ground_force_n, a.ground_force_n);
        for (x, y) in b.actuators.iter().zip(&a.actuators).filter(|(x, _)| x.name == actuator) {
            peak(&format!("{actuator} F1"), x.force_1_n, y.force_1_n);
        }
    }
    peaks
}

/// The peaks as lines of a table.
fn lines(peaks: &[Peak]) -> String {
    let mut text = String::from("| peak of | before, N | after, N | change |\n|---|---|---|---|\n");
    for p in peaks {
        let _ =
            writeln!(text, "| {} | {:.0} | {:.0} | {:+.1} % |", p.what, p.before_n, p.after_n, p.change());
    }
    text
}

/// The peaks as a page with their picture.
fn impact_page(peaks: &[Peak], effects: &[String]) -> String {
    let bars = peaks
        .iter()
        .map(|p| Bar {
            label: p.what.clone(),
            values: vec![p.before_n, p.after_n],
            text: format!("{:+.1} %", p.change()),
        })
        .collect();
    let chart = BarChart {
        title: "Predicted peak forces at impact".to_owned(),
        axis: Axis::new("peak force", "N"),
        series: vec![
            ("model as it was".to_owned(), Hue::Vermillion),
            (format!("with {}", effects.join(" + ")), Hue::Blue),
        ],
        bars,
        ..BarChart::default()
    };
    let mut page = Report::new("What the missing effect changes at impact");
    if let Some(worst) = peaks.iter().reduce(|a, b| if b.change().abs() > a.change().abs() { b } else { a }) {
        let sentence = format!(
            "Without {} the model predicts {:.0} N for the {}; with it {:.0} N ({:+.1} %).",
            effects.join(" + "),
            worst.before_n,
            worst.what,
            worst.after_n,
            worst.change()
        );
        page.verdict(Tone::Neutral, &sentence, "");
    }
    page.figure(
        &chart,
        "Greatest value of each force in the drop. The percentage is the change that the effect makes.",
    );
    page.to_html()
}

/// The page that sums the tour up.
fn summary(outcome: &Outcome, impact: Option<&str>, seconds: f64) -> String {
    let mut page = String::from("# The loop on a leg's drop\n\n");
    let _ = writeln!(page, "{}", outcome.sentence);
    if let Some(impact) = impact {
        let _ = writeln!(page, "\nWhat it changes in predicted impacts:\n\n{impact}");
    }
    let _ = writeln!(
        page,
        "\nFiles: `1-drop.rrd` and `3-diagnose.rrd` (Rerun), `2-compare.html`, `3-diagnose.html`, `5-impact.html` (any browser), \
         `better.toml` (the model with it: `sealegs run better.toml`). {seconds:.0} s."
    );
    page
}
