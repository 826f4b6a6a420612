//! One run's table, whatever it was stored as: what is asked of its columns, and the columns sorted by what they are.

use super::file::did_you_mean;
use super::{Bench, FEWEST_ROWS, INPUT_COLUMNS, OUTPUT_COLUMNS, SIDE_COLUMNS, csv_table, parquet_table};
use crate::{Error, Place};
use sealegs_model::{Signal, Unit};
use std::path::Path;

/// A run's columns, sorted by what they are.
#[derive(Debug)]
pub(super) struct Table {
    pub time_s: Vec<f64>,
    pub inputs: Vec<Signal>,
    pub outputs: Vec<Signal>,
    pub unknown: Vec<Signal>,
}

/// What a campaign says of the columns of its runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Said<'a> {
    pub bench: Bench,
    /// A leg's columns that are commands; every run must have them all.
    pub leg_inputs: &'a [String],
}

/// Reads a run's file: Parquet if its name ends in `.parquet`, else CSV.
pub(super) fn read(path: &Path, said: Said) -> Result<Table, Error> {
    let bytes =
        std::fs::read(path).map_err(|e| Error::bad(path, None, None, format!("cannot be read: {e}")))?;
    if is_parquet(path) {
        parquet_table::parse(path, bytes.into(), said)
    } else {
        csv_table::parse(path, &bytes, said)
    }
}

/// Whether a run's file is Parquet, by the ending of its name.
fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("parquet"))
}

/// Where a run's file says what its columns are called.
pub(super) fn header_of(path: &Path) -> Place {
    if is_parquet(path) || super::memory::is_in_memory(path) { Place::Whole } else { Place::Line(1) }
}

/// Takes one more column name.
pub(super) fn add_name(
    path: &Path,
    at: impl Into<Place>,
    names: &mut Vec<String>,
    name: &str,
) -> Result<(), Error> {
    if name.is_empty() {
        return Err(Error::bad(path, at, None, format!("column {} has no name", names.len() + 1)));
    }
    if names.len() == MOST_COLUMNS {
        return Err(Error::bad(path, at, None, format!("has more than {MOST_COLUMNS} columns")));
    }
    if names.iter().any(|n| n == name) {
        return Err(Error::bad(path, at, Some(name), "stands in the header twice"));
    }
    names.push(name.to_owned());
    Ok(())
}

/// Most columns that a table may have: no bench has so many, and a file that is no table at all may seem to.
const MOST_COLUMNS: usize = 10_000;

/// Time, exactly one input, known units.
pub(super) fn check_columns(
    path: &Path,
    at: impl Into<Place>,
    names: &[String],
    said: Said,
) -> Result<(), Error> {
    let (at, bench) = (at.into(), said.bench);
    if let Some(missing) = said.leg_inputs.iter().find(|i| !names.contains(i)) {
        return Err(Error::bad(path, at, Some(missing), "is missing; the campaign's 'inputs' names it"));
    }
    let words: Vec<&str> = names.iter().map(String::as_str).collect();
    for name in &words {
        // A name without an underscore carries no unit at all (`index`): kept, as unknown. So is the index
        // that pandas writes beside the columns of a table of which rows were left out.
        if name.contains('_')
            && !name.starts_with("__index_level_")
            && let Err(error) = Unit::of_channel(name)
        {
            return Err(Error::bad(path, at, Some(name), format!("{error}")));
        }
    }
    if !words.contains(&"time_s") {
        let hint =
            words.iter().find(|w| w.contains("time")).map_or_else(String::new, |w| format!(" (found '{w}')"));
        return Err(Error::bad(path, at, Some("time_s"), format!("is missing{hint}")));
    }
    if bench == Bench::Robot && !words.iter().any(|w| is_joint_command(w)) {
        let problem = "no input column; a robot's joints are commanded by '<joint>.torque_nm'";
        return Err(Error::bad(path, at, None, problem));
    }
    if bench.has_joints() {
        return Ok(());
    }
    let inputs: Vec<&str> = words.iter().copied().filter(|w| INPUT_COLUMNS.contains(w)).collect();
    match inputs.len() {
        1 => Ok(()),
        0 => {
            let near = words.iter().map(|w| did_you_mean(w, &INPUT_COLUMNS)).find(|s| !s.is_empty());
            let problem = format!(
                "no input column; one of {} is needed{}",
                INPUT_COLUMNS.join(", "),
                near.unwrap_or_default()
            );
            Err(Error::bad(path, at, None, problem))
        }
        _ => Err(Error::bad(
            path,
            at,
            Some(inputs[1]),
            format!("two input columns at once: {}", inputs.join(", ")),
        )),
    }
}

/// Whether a robot's column commands a joint.
fn is_joint_command(name: &str) -> bool {
    name.ends_with(".torque_nm") || name.ends_with(".force_n")
}

/// Time must go on.
pub(super) fn later(path: &Path, at: impl Into<Place>, before: f64, now: f64) -> Result<(), Error> {
    if now > before {
        return Ok(());
    }
    let what = if now == before { "repeats" } else { "goes back" };
    Err(Error::bad(path, at, Some("time_s"), format!("time {what}: {now} after {before}")))
}

/// There must be enough rows.
pub(super) fn check_length(path: &Path, rows: usize) -> Result<(), Error> {
    if rows >= FEWEST_ROWS {
        return Ok(());
    }
    Err(Error::bad(path, None, None, format!("has {rows} rows; at least {FEWEST_ROWS} are needed")))
}

/// The columns by what they are.
pub(super) fn sort(names: Vec<String>, columns: Vec<Vec<f64>>, said: Said) -> Table {
    let mut table =
        Table { time_s: Vec::new(), inputs: Vec::new(), outputs: Vec::new(), unknown: Vec::new() };
    let mut beside = Vec::new();
    for (channel, values) in names.into_iter().zip(columns) {
        let commands_joint = said.bench == Bench::Robot && is_joint_command(&channel);
        let leg_output = said.bench.has_joints() && channel.contains('.');
        if channel == "time_s" {
            table.time_s = values;
        } else if commands_joint
            || said.leg_inputs.contains(&channel)
            || (!said.bench.has_joints() && INPUT_COLUMNS.contains(&channel.as_str()))
        {
            table.inputs.push(Signal { channel, values });
        } else if !said.bench.has_joints() && SIDE_COLUMNS.contains(&channel.as_str()) {
            beside.push(Signal { channel, values });
        } else if leg_output || OUTPUT_COLUMNS.contains(&channel.as_str()) {
            table.outputs.push(Signal { channel, values });
        } else {
            table.unknown.push(Signal { channel, values });
        }
    }
    // After the command, which is the first of the inputs.
    table.inputs.append(&mut beside);
    table
}
