//! `sealegs impact`: drops from several heights with several springs, as a table and as a gate.

use super::run::load;
use crate::failure::{LIMIT_EXCEEDED, OrBadInput, bad_input};
use crate::jobs::{self, JobArguments};
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::impact::{DropRecorder, ImpactTable, Survival, drops, sweep, sweep_watched};
use sealegs::jobs::{JobFolder, hash};
use sealegs::leg::scenario::{Scenario, SweepSpec};
use sealegs::recorder::recording::Output;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Drop a leg from several heights with several springs; exit status 3 when a stated limit is exceeded.
#[derive(Args)]
pub struct Impact {
    /// A shipped scenario's name (see `sealegs list`) or a TOML file.
    scenario: String,
    /// Drop heights, m; without it those of the scenario's [sweep].
    #[arg(long, value_delimiter = ',', value_name = "M,M,...")]
    heights: Vec<f64>,
    /// Spring settings of all actuators; without it those of the scenario's [sweep].
    #[arg(long, value_delimiter = ',', value_name = "SETTING,...")]
    springs: Vec<String>,
    /// Exit with status 3 if any actuator's force exceeds this, N.
    #[arg(long, value_name = "N")]
    max_force: Option<f64>,
    /// Repeat every drop at half the step and print how much the peak forces change.
    #[arg(long)]
    check: bool,
    /// Write the table as CSV, one line for each actuator of each drop (`-`: standard output).
    #[arg(long, value_name = "FILE", conflicts_with = "jobs")]
    csv: Option<PathBuf>,
    /// Write the table as JSON (`-`: standard output).
    #[arg(long, value_name = "FILE", conflicts_with = "jobs")]
    json: Option<PathBuf>,
    /// Write a report as one HTML file: which spring survives which drop, and peaks over the height beside their limits.
    #[arg(long, value_name = "FILE.html", conflicts_with = "jobs")]
    report: Option<PathBuf>,
    /// Write all drops side by side as one Rerun recording.
    #[arg(long, value_name = "FILE.rrd", conflicts_with = "jobs")]
    rrd: Option<PathBuf>,
    /// Change a key of the scenario, dotted: `base.carriage_mass_kg=30`. May be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Integration step, s.
    #[arg(long, value_name = "SECONDS")]
    step: Option<f64>,
    #[command(flatten)]
    jobs: JobArguments,
}

/// The verb's name in lists of jobs.
pub(super) const VERB: &str = "impact";

/// What the drops follow from, and what is said of them.
#[derive(Debug, Serialize, Deserialize)]
struct About {
    scenario: String,
    /// Of the scenario with the command line's changes.
    scenario_sha256: String,
    step_s: f64,
    heights_m: Vec<f64>,
    springs: Vec<String>,
    check: bool,
    max_force_n: Option<f64>,
}

/// Where the table goes.
pub(super) struct Outputs {
    csv: Option<Destination>,
    json: Option<Destination>,
    report: Option<Destination>,
    quiet: bool,
}

impl Outputs {
    /// Tries the files out.
    ///
    /// # Errors
    ///
    /// Bad input if one cannot be written.
    pub(super) fn new(
        csv: Option<&PathBuf>,
        json: Option<&PathBuf>,
        report: Option<&PathBuf>,
    ) -> anyhow::Result<Self> {
        let quiet = [csv, json, report].into_iter().flatten().any(|path| path.as_os_str() == "-");
        let (csv, json) = (Destination::optional(csv)?, Destination::optional(json)?);
        Ok(Self { csv, json, report: Destination::optional(report)?, quiet })
    }

    /// Writes the table everywhere; returns the exit status.
    fn write(self, table: &ImpactTable, max_force_n: Option<f64>) -> anyhow::Result<u8> {
        if let Some(csv) = self.csv {
            csv.write(&csv_of(table)?)?;
        }
        if let Some(json) = self.json {
            json.write(format!("{}\n", serde_json::to_string_pretty(table)?).as_bytes())?;
        }
        if let Some(report) = self.report {
            report.write(sealegs::impact::page(table, max_force_n, &crate::command()).as_bytes())?;
        }
        if !self.quiet {
            let text = text_of(table) + &Survival::of(table, max_force_n).text();
            std::io::stdout().write_all(text.as_bytes())?;
        }
        if let Some(row) = table.rows.iter().find(|r| r.stopped.is_some()) {
            let why = row.stopped.as_deref().unwrap_or_default();
            anyhow::bail!("the drop from {} m with {} springs stopped: {why}", row.height_m, row.spring);
        }
        Ok(gate(table, max_force_n))
    }
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input, or a drop that did not reach its end.
pub fn run(args: &Impact) -> anyhow::Result<u8> {
    let scenario = load(&args.scenario, &args.set, args.step)?;
    let over = over(args, &scenario)?;
    if let Some(limit) = args.max_force
        && !(limit > 0.0 && limit.is_finite())
    {
        return Err(bad_input(format!("--max-force {limit}: must be positive and finite")));
    }
    if let Some(folder) = &args.jobs.jobs {
        return work(args, folder, &scenario, &over);
    }
    let outputs = Outputs::new(args.csv.as_ref(), args.json.as_ref(), args.report.as_ref())?;
    let rrd = Destination::optional(args.rrd.as_ref())?;
    let bar = progress::bar(
        (over.heights_m.len() * over.springs.len()) as u64,
        "{elapsed} {bar:40} {pos} of {len} drops",
    );
    let done = || bar.inc(1);
    let table = match rrd {
        None => sweep(&scenario, &over, args.check, &done).or_bad_input()?,
        Some(destination) => {
            let Some(part) = destination.part() else {
                return Err(bad_input("--rrd -: a recording goes to a file"));
            };
            let (table, drops) =
                sweep_watched(&scenario, &over, args.check, &done, DropRecorder::default).or_bad_input()?;
            let document = toml::to_string_pretty(&scenario).unwrap_or_default();
            let output = Output::File(part.to_owned());
            sealegs::impact::record(&table, &drops, args.max_force, &document, &output)?;
            destination.finish()?;
            table
        }
    };
    bar.finish();
    outputs.write(&table, args.max_force)
}

/// The heights and springs: those of the command line, else those of the scenario.
fn over(args: &Impact, scenario: &Scenario) -> anyhow::Result<SweepSpec> {
    let own = scenario.sweep.clone().unwrap_or_default();
    let choose = |given: bool, what: &str| match given {
        true => Ok(()),
        false => Err(bad_input(format!("{}: no [sweep] in the scenario: give --{what}", args.scenario))),
    };
    choose(!args.heights.is_empty() || !own.heights_m.is_empty(), "heights")?;
    choose(!args.springs.is_empty() || !own.springs.is_empty(), "springs")?;
    Ok(SweepSpec {
        heights_m: if args.heights.is_empty() { own.heights_m } else { args.heights.clone() },
        springs: if args.springs.is_empty() { own.springs } else { args.springs.clone() },
    })
}

/// Does a shard of the drops.
fn work(args: &Impact, folder: &Path, scenario: &Scenario, over: &SweepSpec) -> anyhow::Result<u8> {
    let drops = drops(scenario, over).or_bad_input()?;
    let about = About {
        scenario: scenario.name.clone(),
        scenario_sha256: hash(&toml::to_string(scenario)?),
        step_s: scenario.step_s,
        heights_m: over.heights_m.clone(),
        springs: over.springs.clone(),
        check: args.check,
        max_force_n: args.max_force,
    };
    let names: Vec<String> = drops.iter().map(|d| format!("{}m-{}", d.height_m, d.spring)).collect();
    let list = jobs::list(VERB, serde_json::to_value(about)?, &names);
    jobs::work(folder, args.jobs.shard, list, |number| drops[number].run(args.check).or_bad_input())
}

/// Puts the drops of a folder together.
///
/// # Errors
///
/// As [`run`]; bad input where a drop is missing.
pub(super) fn merge(folder: &JobFolder, outputs: Outputs) -> anyhow::Result<u8> {
    let about: About = folder.about()?;
    let table = ImpactTable { scenario: about.scenario, step_s: about.step_s, rows: folder.results()? };
    outputs.write(&table, about.max_force_n)
}

/// The exit status that the limit asks for.
fn gate(table: &ImpactTable, max_force_n: Option<f64>) -> u8 {
    let Some(limit) = max_force_n else { return 0 };
    let mut status = 0;
    for row in &table.rows {
        let (force, name) = row.greatest_force();
        if force > limit {
            status = LIMIT_EXCEEDED;
            eprintln!(
                "limit exceeded: {name} {force:.0} N > {limit:.0} N (drop of {} m, {} springs)",
                row.height_m, row.spring
            );
        }
    }
    status
}

fn csv_of(table: &ImpactTable) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "height_m",
        "spring",
        "ground_force_n",
        "actuator",
        "force_1_n",
        "force_2_n",
        "deflection_m",
        "stress_pa",
        "force_margin",
        "stress_margin",
        "change_at_half_step",
    ])?;
    let or_empty = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    for row in &table.rows {
        for a in &row.actuators {
            writer.write_record([
                row.height_m.to_string(),
                row.spring.clone(),
                row.ground_force_n.to_string(),
                a.name.clone(),
                a.force_1_n.to_string(),
                a.force_2_n.to_string(),
                a.deflection_m.to_string(),
                or_empty(a.stress_pa),
                or_empty(a.force_margin),
                or_empty(a.stress_margin),
                or_empty(row.change_at_half_step),
            ])?;
        }
    }
    Ok(writer.into_inner()?)
}

/// The table for a terminal.
pub(super) fn text_of(table: &ImpactTable) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{}: {} drops at a step of {:.0} us; margin = limit over peak, below 1 the limit is exceeded",
        table.scenario,
        table.rows.len(),
        1e6 * table.step_s
    );
    for row in &table.rows {
        let _ = writeln!(
            out,
            "\n{:.3} m, {}: peak ground force {:.0} N at {:.4} s, energy unexplained {:.1e}",
            row.height_m, row.spring, row.ground_force_n, row.ground_force_time_s, row.energy_residual
        );
        if let (Some(change), Some(name)) = (row.change_at_half_step, &row.changes_most) {
            let _ =
                writeln!(out, "  at half the step peaks change by at most {:.3} % ({name})", 100.0 * change);
        }
        let _ = writeln!(
            out,
            "  {:<14}{:>10}{:>10}{:>12}{:>10}{:>14}{:>14}",
            "actuator", "F1 N", "F2 N", "spring mm", "beam MPa", "force margin", "stress margin"
        );
        for a in &row.actuators {
            let or_dash =
                |v: Option<f64>, digits: usize| v.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"));
            let _ = writeln!(
                out,
                "  {:<14}{:>10.0}{:>10.0}{:>12.3}{:>10}{:>14}{:>14}",
                a.name,
                a.force_1_n,
                a.force_2_n,
                1e3 * a.deflection_m,
                or_dash(a.stress_pa.map(|s| 1e-6 * s), 1),
                or_dash(a.force_margin, 2),
                or_dash(a.stress_margin, 2)
            );
        }
    }
    out
}
