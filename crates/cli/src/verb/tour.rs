//! `sealegs tour`: the whole loop on the shipped drop of a leg, each step by the command that a user would type.

use crate::failure::bad_input;
use crate::output::Destination;
use anyhow::Context;
use clap::{Args, Parser, Subcommand};
use sealegs_recorder::chart::{Axis, Bar, BarChart, Hue};
use sealegs_recorder::report::{Report, Tone};
use serde_json::Value;
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
const HEIGHTS: &str = "0.05,0.10";

/// A step's command line, parsed as a user's would be.
#[derive(Parser)]
struct Line {
    #[command(subcommand)]
    verb: Step,
}

#[derive(Subcommand)]
enum Step {
    Run(super::run::Run),
    Compare(super::compare::Compare),
    Diagnose(super::diagnose::Diagnose),
    Add(super::add::Add),
    Impact(super::impact::Impact),
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input if the folder cannot be written; whatever a step could not do.
pub fn run(arguments: &Tour) -> anyhow::Result<u8> {
    let started = Instant::now();
    let folder = &arguments.output;
    let campaign = folder.join("leg-drop");
    std::fs::create_dir_all(&campaign)
        .map_err(|e| bad_input(format!("{}: cannot be made: {e}", campaign.display())))?;
    for (name, text) in CAMPAIGN {
        Destination::new(&campaign.join(name))?.write(text.as_bytes())?;
    }
    let place = |name: &str| folder.join(name).display().to_string();
    let data = campaign.display().to_string();

    say("1. The leg drops, and every force in it is recorded.")?;
    step(&["run", MODEL, "--rrd", &place("1-drop.rrd")])?;
    say("2. The same drops, recorded elsewhere: where does the model fail?")?;
    step(&["compare", &data, "--report", &place("2-compare.html"), "--json", &place("2-compare.json")])?;
    say("3. Which physical effect is missing, and at which joint?")?;
    let (found, report, rrd) = (place("3-diagnose.json"), place("3-diagnose.html"), place("3-diagnose.rrd"));
    step(&["diagnose", &data, "--report", &report, "--rrd", &rrd, "--json", &found])?;
    let diagnosis = read(&found)?;
    let effects = names(&diagnosis["effects"]);
    let mut impact = None;
    if effects.is_empty() {
        say("Nothing is to be added.")?;
    } else {
        say("4. It is added, and the error falls.")?;
        let (set, better) = (effects.join("+"), place("better.toml"));
        step(&[
            "add",
            &set,
            "--to",
            MODEL,
            "--campaign",
            &data,
            "-o",
            &better,
            "--json",
            &place("4-add.json"),
        ])?;
        say("5. What the missing effect would have cost in predicted impact forces.")?;
        let (before, after) = (place("5-impact-before.json"), place("5-impact-after.json"));
        for (model, file) in [(MODEL, &before), (better.as_str(), &after)] {
            step(&["impact", model, "--heights", HEIGHTS, "--springs", "compliant", "--json", file])?;
        }
        let place_of = effects[0].split('/').next().unwrap_or_default();
        let peaks = peaks(&read(&before)?, &read(&after)?, place_of);
        Destination::new(&folder.join("5-impact.html"))?.write(impact_page(&peaks, &effects).as_bytes())?;
        impact = Some(lines(&peaks));
    }
    let page = summary(&diagnosis, &effects, impact.as_deref(), started.elapsed().as_secs_f64());
    let file = folder.join("summary.md");
    Destination::new(&file)?.write(page.as_bytes())?;
    say(&format!("{page}\nThis page is {}; open 3-diagnose.html beside it for the curves.", file.display()))?;
    Ok(0)
}

/// Prints the command of a step and does it.
fn step(words: &[&str]) -> anyhow::Result<()> {
    say(&format!("$ sealegs {}", words.join(" ")))?;
    let line = Line::try_parse_from(std::iter::once("sealegs").chain(words.iter().copied()))?;
    match line.verb {
        Step::Run(a) => super::run::run(&a),
        Step::Compare(a) => super::compare::run(&a),
        Step::Diagnose(a) => super::diagnose::run(&a),
        Step::Add(a) => super::add::run(&a),
        Step::Impact(a) => super::impact::run(&a),
    }
    .map(|_| ())
}

fn say(text: &str) -> anyhow::Result<()> {
    writeln!(std::io::stdout().lock(), "\n{text}").context("standard output")
}

fn read(file: &str) -> anyhow::Result<Value> {
    let text = std::fs::read_to_string(Path::new(file)).with_context(|| file.to_owned())?;
    serde_json::from_str(&text).with_context(|| file.to_owned())
}

fn names(list: &Value) -> Vec<String> {
    list.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
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

/// The peak forces of the ground and of the actuator that was named, drop by drop.
fn peaks(before: &Value, after: &Value, actuator: &str) -> Vec<Peak> {
    let mut peaks = Vec::new();
    let rows = |v: &Value| v["rows"].as_array().cloned().unwrap_or_default();
    for (b, a) in rows(before).iter().zip(&rows(after)) {
        let height = b["height_m"].as_f64().unwrap_or(f64::NAN);
        let mut peak = |what: &str, b: &Value, a: &Value| {
            if let (Some(before_n), Some(after_n)) = (b.as_f64(), a.as_f64()) {
                peaks.push(Peak { what: format!("{what}, drop from {height:.2} m"), before_n, after_n });
            }
        };
        peak("ground force", &b["ground_force_n"], &a["ground_force_n"]);
        let actuators = |v: &Value| v["actuators"].as_array().cloned().unwrap_or_default();
        for (x, y) in actuators(b).iter().zip(&actuators(a)) {
            if x["name"] == actuator {
                peak(&format!("{actuator} F1"), &x["force_1_n"], &y["force_1_n"]);
            }
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
    };
    let mut page = Report::new("What the missing effect costs at impact");
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
fn summary(diagnosis: &Value, effects: &[String], impact: Option<&str>, seconds: f64) -> String {
    let number = |v: &Value| v.as_f64().map_or("-".to_owned(), |x| format!("{x:.2}"));
    let mut page = String::from("# The loop on a leg's drop\n\n");
    let _ = writeln!(
        page,
        "Verdict: **{}**{}.",
        diagnosis["verdict"].as_str().unwrap_or("-"),
        match effects {
            [] => String::new(),
            _ => format!(", missing: **{}**", effects.join(" + ")),
        }
    );
    let _ = writeln!(
        page,
        "Error on drops that were never fitted, in units of the sensors' noise: {} with the model as it was, {} with \
         what was missing (noise floor {}).\n",
        number(&diagnosis["base"]["holdout_error"]),
        number(&diagnosis["after"]["holdout_error"]),
        number(&diagnosis["noise_floor"])
    );
    for p in diagnosis["after"]["parameters"].as_array().into_iter().flatten() {
        let name = p["name"].as_str().unwrap_or_default();
        if let (true, Some(value), Some(std)) = (name.contains('.'), p["value"].as_f64(), p["std"].as_f64()) {
            let _ =
                writeln!(page, "- {name}: {value:.4} ± {std:.2} {}", p["unit"].as_str().unwrap_or_default());
        }
    }
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
