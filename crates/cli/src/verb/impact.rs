//! `sealegs impact`: drops from several heights with several springs, as a table and as a gate.

use super::run::{load, progress};
use crate::failure::{LIMIT_EXCEEDED, OrBadInput, bad_input};
use crate::output::Destination;
use clap::Args;
use sealegs::leg::impact::{ImpactRow, ImpactTable, sweep};
use sealegs::leg::scenario::SweepSpec;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

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
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the table as JSON (`-`: standard output).
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Change a key of the scenario, dotted: `base.carriage_mass_kg=30`. May be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Integration step, s.
    #[arg(long, value_name = "SECONDS")]
    step: Option<f64>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input, or a drop that did not reach its end.
pub fn run(args: &Impact) -> anyhow::Result<u8> {
    let scenario = load(&args.scenario, &args.set, args.step)?;
    let own = scenario.sweep.clone().unwrap_or_default();
    let choose = |given: bool, what: &str| match given {
        true => Ok(()),
        false => Err(bad_input(format!("{}: no [sweep] in the scenario: give --{what}", args.scenario))),
    };
    choose(!args.heights.is_empty() || !own.heights_m.is_empty(), "heights")?;
    choose(!args.springs.is_empty() || !own.springs.is_empty(), "springs")?;
    let over = SweepSpec {
        heights_m: if args.heights.is_empty() { own.heights_m } else { args.heights.clone() },
        springs: if args.springs.is_empty() { own.springs } else { args.springs.clone() },
    };
    if let Some(limit) = args.max_force
        && !(limit > 0.0 && limit.is_finite())
    {
        return Err(bad_input(format!("--max-force {limit}: must be positive and finite")));
    }
    let csv = Destination::optional(args.csv.as_ref())?;
    let json = Destination::optional(args.json.as_ref())?;
    let drops = (over.heights_m.len() * over.springs.len()) as u64;
    let bar = progress(drops, "{elapsed} {bar:40} {pos} of {len} drops");
    let done = || {
        if let Some(bar) = &bar {
            bar.inc(1);
        }
    };
    let table = sweep(&scenario, &over, args.check, &done).or_bad_input()?;
    if let Some(bar) = &bar {
        bar.finish_and_clear();
    }
    let to_stdout = [&args.csv, &args.json].iter().any(|p| p.as_ref().is_some_and(|p| p.as_os_str() == "-"));
    if let Some(csv) = csv {
        csv.write(&csv_of(&table)?)?;
    }
    if let Some(json) = json {
        json.write(format!("{}\n", serde_json::to_string_pretty(&table)?).as_bytes())?;
    }
    if !to_stdout {
        std::io::stdout().write_all((text_of(&table) + &survival(&table, args.max_force)).as_bytes())?;
    }
    if let Some(row) = table.rows.iter().find(|r| r.stopped.is_some()) {
        let why = row.stopped.as_deref().unwrap_or_default();
        anyhow::bail!("the drop from {} m with {} springs stopped: {why}", row.height_m, row.spring);
    }
    Ok(gate(&table, args.max_force))
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
        "{}: {} drops at a step of {:.0} us; margin = allowed over asked, below 1 the limit is exceeded",
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

/// A drop beside its limits: the least margin of any actuator, and whose it is.
struct Verdict {
    /// Allowed over asked; infinite where no limit is known.
    margin: f64,
    /// Actuator and limit.
    what: String,
}

/// The least margin of a drop over the rated forces, the yield strengths and the limit of the command line.
fn verdict(row: &ImpactRow, max_force_n: Option<f64>) -> Verdict {
    let of_actuators = row.actuators.iter().flat_map(|a| {
        let rated = a.force_margin.map(|m| (m, format!("{} rated force", a.name)));
        let yielding = a.stress_margin.map(|m| (m, format!("{} yield strength", a.name)));
        rated.into_iter().chain(yielding)
    });
    let (force, name) = row.greatest_force();
    let stated = max_force_n.filter(|_| force > 0.0).map(|max| (max / force, format!("{name} --max-force")));
    let none = (f64::INFINITY, String::new());
    let (margin, what) =
        of_actuators.chain(stated).fold(none, |least, m| if m.0 < least.0 { m } else { least });
    Verdict { margin, what }
}

/// One table of springs over heights: the least margin, and what is exceeded where it is below 1; then which survive.
fn survival(table: &ImpactTable, max_force_n: Option<f64>) -> String {
    let mut heights: Vec<f64> = Vec::new();
    let mut springs: Vec<&str> = Vec::new();
    for row in &table.rows {
        if !heights.contains(&row.height_m) {
            heights.push(row.height_m);
        }
        if !springs.contains(&row.spring.as_str()) {
            springs.push(&row.spring);
        }
    }
    let cell = |spring: &str, height: f64| -> (String, bool) {
        let Some(row) = table.rows.iter().find(|r| r.spring == spring && r.height_m == height) else {
            return ("-".to_owned(), false);
        };
        if row.stopped.is_some() {
            return ("stopped".to_owned(), false);
        }
        let Verdict { margin, what } = verdict(row, max_force_n);
        match margin {
            m if m.is_infinite() => ("no limit known".to_owned(), true),
            m if m < 1.0 => (format!("{m:.2} {what}"), false),
            m => (format!("{m:.2}"), true),
        }
    };
    let cells: Vec<Vec<(String, bool)>> =
        springs.iter().map(|s| heights.iter().map(|h| cell(s, *h)).collect()).collect();
    let name = springs.iter().map(|s| s.chars().count()).max().unwrap_or(0).max(6);
    let width = cells.iter().flatten().map(|(text, _)| text.chars().count()).max().unwrap_or(0).max(8);
    let mut out = String::from("\nLeast margin of any actuator, and what is exceeded where it is below 1:\n");
    let _ = write!(out, "  {:<name$}", "spring");
    for height in &heights {
        let _ = write!(out, "  {:<width$}", format!("{height} m"));
    }
    out.truncate(out.trim_end().len());
    out.push('\n');
    for (spring, row) in springs.iter().zip(&cells) {
        let _ = write!(out, "  {spring:<name$}");
        for (text, _) in row {
            let _ = write!(out, "  {text:<width$}");
        }
        out.truncate(out.trim_end().len());
        out.push('\n');
    }
    for (spring, row) in springs.iter().zip(&cells) {
        let kept = heights.iter().zip(row).filter(|(_, (_, survives))| *survives);
        let kept: Vec<String> = kept.map(|(h, _)| format!("{h} m")).collect();
        let said = match kept.len() {
            0 => "no drop".to_owned(),
            n if n == heights.len() => "every drop".to_owned(),
            _ => kept.join(", "),
        };
        let _ = writeln!(out, "{spring} springs survive {said}.");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use sealegs::leg::impact::ImpactActuator;

    fn row(height_m: f64, spring: &str, force_margin: f64, stress_margin: Option<f64>) -> ImpactRow {
        let knee = ImpactActuator {
            name: "knee".to_owned(),
            force_1_n: 900.0,
            force_2_n: -1000.0,
            deflection_m: 1e-3,
            stress_pa: None,
            force_margin: Some(force_margin),
            stress_margin,
        };
        ImpactRow {
            height_m,
            spring: spring.to_owned(),
            ground_force_n: 2000.0,
            ground_force_time_s: 0.1,
            actuators: vec![knee],
            energy_residual: 0.0,
            stopped: None,
            change_at_half_step: None,
            changes_most: None,
        }
    }

    #[test]
    fn the_last_table_says_which_spring_survives_which_drop() {
        let rows = vec![
            row(0.05, "compliant", 2.0, Some(1.5)),
            row(0.05, "stiff", 1.2, None),
            row(0.1, "compliant", 1.1, Some(0.8)),
            row(0.1, "stiff", 0.5, None),
        ];
        let table = ImpactTable { scenario: "drop".to_owned(), step_s: 1e-4, rows };
        let text = survival(&table, None);
        assert!(
            text.contains("0.80 knee yield strength") && text.contains("0.50 knee rated force"),
            "{text}"
        );
        assert!(text.contains("compliant springs survive 0.05 m.\nstiff springs survive 0.05 m."), "{text}");
        // 1000 N against 400 N: everything fails, and the reason is the stated limit.
        let text = survival(&table, Some(400.0));
        assert!(text.contains("0.40 knee --max-force") && text.contains("survive no drop"), "{text}");
    }
}
