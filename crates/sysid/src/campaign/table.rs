//! One run's table: a CSV file with a header, every cell a finite number.

use super::file::did_you_mean;
use super::{Bench, FEWEST_ROWS, INPUT_COLUMNS, OUTPUT_COLUMNS};
use crate::Error;
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

/// Reads a run's file; `leg_inputs` are a leg's columns that are commands, and it must have them all.
pub(super) fn read(path: &Path, bench: Bench, leg_inputs: &[String]) -> Result<Table, Error> {
    let bytes =
        std::fs::read(path).map_err(|e| Error::bad(path, None, None, format!("cannot be read: {e}")))?;
    parse(path, &bytes, bench, leg_inputs)
}

/// As [`read`], of the file's bytes.
pub(super) fn parse(path: &Path, bytes: &[u8], bench: Bench, leg_inputs: &[String]) -> Result<Table, Error> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Error::bad(path, None, None, "is empty"));
    }
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let broken = |e: &csv::Error| {
        Error::bad(path, e.position().map(csv::Position::line), None, format!("is no CSV: {e}"))
    };
    let mut row = csv::ByteRecord::new();
    if !reader.read_byte_record(&mut row).map_err(|e| broken(&e))? {
        return Err(Error::bad(path, None, None, "is empty"));
    }
    let names = header(path, &row)?;
    check_columns(path, &names, bench)?;
    if let Some(missing) = leg_inputs.iter().find(|i| !names.contains(i)) {
        return Err(Error::bad(path, 1, Some(missing), "is missing; the campaign's 'inputs' names it"));
    }

    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(bytes.len() / (8 * names.len())); names.len()];
    let time_column = names.iter().position(|n| n == "time_s").unwrap_or(0);
    while reader.read_byte_record(&mut row).map_err(|e| broken(&e))? {
        let line = row.position().map(csv::Position::line);
        // A row of one empty cell is a blank line with spaces in it.
        if row.len() == 1 && row[0].iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        if row.len() != names.len() {
            let missing = names.get(row.len()).map(String::as_str);
            let problem = format!("has {} cells, the header {} columns", row.len(), names.len());
            return Err(Error::bad(path, line, missing, problem));
        }
        for (i, cell) in row.iter().enumerate() {
            match number(cell) {
                Ok(value) => columns[i].push(value),
                Err(problem) => return Err(Error::bad(path, line, Some(&names[i]), problem)),
            }
        }
        let time = &columns[time_column];
        if let [.., before, now] = time.as_slice()
            && now <= before
        {
            let what = if now == before { "repeats" } else { "goes back" };
            return Err(Error::bad(path, line, Some("time_s"), format!("time {what}: {now} after {before}")));
        }
    }
    if columns[time_column].len() < FEWEST_ROWS {
        let problem = format!("has {} rows; at least {FEWEST_ROWS} are needed", columns[time_column].len());
        return Err(Error::bad(path, None, None, problem));
    }
    Ok(sort(names, columns, bench, leg_inputs))
}

/// The column names of the first row.
fn header(path: &Path, row: &csv::ByteRecord) -> Result<Vec<String>, Error> {
    if row.iter().any(|cell| number(cell).is_ok()) {
        return Err(Error::bad(path, 1, None, "no header: the first row must hold the columns' names"));
    }
    let mut names: Vec<String> = Vec::with_capacity(row.len());
    for cell in row {
        let Ok(name) = std::str::from_utf8(cell) else {
            return Err(Error::bad(path, 1, None, "a column's name is not UTF-8"));
        };
        let name = name.trim().to_owned();
        if name.is_empty() {
            let problem = format!("column {} has no name", names.len() + 1);
            return Err(Error::bad(path, 1, None, problem));
        }
        if row.len() == 1 && name.contains([';', '\t']) {
            return Err(Error::bad(path, 1, None, "columns must be separated by commas"));
        }
        if names.contains(&name) {
            return Err(Error::bad(path, 1, Some(&name), "stands in the header twice"));
        }
        names.push(name);
    }
    Ok(names)
}

/// Time, exactly one input, known units.
fn check_columns(path: &Path, names: &[String], bench: Bench) -> Result<(), Error> {
    let words: Vec<&str> = names.iter().map(String::as_str).collect();
    for name in &words {
        // A name without an underscore carries no unit at all (`index`): kept, as unknown.
        if name.contains('_')
            && let Err(error) = Unit::of_channel(name)
        {
            return Err(Error::bad(path, 1, Some(name), format!("{error}")));
        }
    }
    if !words.contains(&"time_s") {
        let hint =
            words.iter().find(|w| w.contains("time")).map_or_else(String::new, |w| format!(" (found '{w}')"));
        return Err(Error::bad(path, 1, Some("time_s"), format!("is missing{hint}")));
    }
    if bench == Bench::Leg {
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
            Err(Error::bad(path, 1, None, problem))
        }
        _ => Err(Error::bad(
            path,
            1,
            Some(inputs[1]),
            format!("two input columns at once: {}", inputs.join(", ")),
        )),
    }
}

/// A finite number, or what is wrong with the cell.
fn number(cell: &[u8]) -> Result<f64, String> {
    let text = String::from_utf8_lossy(cell.trim_ascii());
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("'{text}' is not finite")),
        Err(_) if text.is_empty() => Err("the cell is empty".to_owned()),
        Err(_) => Err(format!("'{}' is no number", text.chars().take(40).collect::<String>())),
    }
}

fn sort(names: Vec<String>, columns: Vec<Vec<f64>>, bench: Bench, leg_inputs: &[String]) -> Table {
    let mut table =
        Table { time_s: Vec::new(), inputs: Vec::new(), outputs: Vec::new(), unknown: Vec::new() };
    for (channel, values) in names.into_iter().zip(columns) {
        let leg_output = bench == Bench::Leg && channel.contains('.');
        if channel == "time_s" {
            table.time_s = values;
        } else if leg_inputs.contains(&channel)
            || (bench != Bench::Leg && INPUT_COLUMNS.contains(&channel.as_str()))
        {
            table.inputs.push(Signal { channel, values });
        } else if leg_output || OUTPUT_COLUMNS.contains(&channel.as_str()) {
            table.outputs.push(Signal { channel, values });
        } else {
            table.unknown.push(Signal { channel, values });
        }
    }
    table
}
