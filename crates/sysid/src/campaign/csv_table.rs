//! A run's table as CSV: a header, then rows whose every cell is a finite number.

use super::table::{Said, Table, add_name, check_columns, check_length, later, sort};
use crate::Error;
use std::path::Path;

/// Reads the bytes of a CSV file.
pub(super) fn parse(path: &Path, bytes: &[u8], said: Said) -> Result<Table, Error> {
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
    check_columns(path, 1, &names, said)?;

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
        if let [.., before, now] = time.as_slice() {
            later(path, line, *before, *now)?;
        }
    }
    check_length(path, columns[time_column].len())?;
    Ok(sort(names, columns, said))
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
        let name = name.trim();
        if row.len() == 1 && name.contains([';', '\t']) {
            return Err(Error::bad(path, 1, None, "columns must be separated by commas"));
        }
        add_name(path, 1, &mut names, name)?;
    }
    Ok(names)
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
