//! Files of named arrays (MATLAB, NumPy, JSON): arrays of one length become one table, single numbers constants.

use crate::budget::{MOST_ARRAY, MOST_COLUMNS};
use crate::table::{Column, Log, Table};

/// An array with its shape, in the order in which the file stores it.
pub(crate) struct Array {
    pub name: String,
    pub shape: Vec<usize>,
    /// Whether the first index varies fastest (MATLAB, Fortran).
    pub first_fastest: bool,
    pub values: Vec<f64>,
    pub holds: Option<String>,
}

/// The columns of an array along its longest side, the first of them: of a matrix named `name[0]`, `name[1]` and so on, of an array
/// of more dimensions `name[0][0]` and so on.
///
/// `Err` says why it becomes none.
fn columns(array: Array) -> Result<Vec<Column>, String> {
    let Array { name, shape, first_fastest, values, holds } = array;
    let long: Vec<usize> = shape.iter().copied().filter(|&n| n != 1).collect();
    let with = |mut column: Column| {
        column.holds.clone_from(&holds);
        column
    };
    match long[..] {
        [] | [_] => Ok(vec![with(Column::of(name, values))]),
        _ => {
            let (along, &rows) = long.iter().enumerate().rev().max_by_key(|(_, n)| **n).unwrap_or((0, &0));
            let across: usize =
                long.iter().enumerate().filter(|(i, _)| *i != along).map(|(_, n)| n).product();
            if across > MOST_ARRAY {
                let sides = long.iter().map(usize::to_string).collect::<Vec<_>>().join(" by ");
                return Err(format!("'{name}' is an array of {sides}: left out"));
            }
            // How far apart neighbours along each side are.
            let mut strides = vec![1; long.len()];
            let sides: Vec<usize> =
                if first_fastest { (0..long.len()).collect() } else { (0..long.len()).rev().collect() };
            for pair in sides.windows(2) {
                strides[pair[1]] = strides[pair[0]] * long[pair[0]];
            }
            let column = |c: usize| {
                let (mut rest, mut at, mut label) = (c, 0, String::new());
                for side in (0..long.len()).rev().filter(|&side| side != along) {
                    let index = rest % long[side];
                    rest /= long[side];
                    at += index * strides[side];
                    label = format!("[{index}]{label}");
                }
                let values = (0..rows).map(|row| values[at + row * strides[along]]).collect();
                with(Column::of(format!("{name}{label}"), values))
            };
            Ok((0..across).map(column).collect())
        }
    }
}

/// Puts the arrays into tables by their length; the table with the most numbers comes first and bears no name.
pub(crate) fn into_log(format: &'static str, arrays: Vec<Array>, mut notes: Vec<String>) -> Log {
    let mut log = Log { format, ..Log::default() };
    let mut tables: Vec<Table> = Vec::new();
    for array in arrays {
        match columns(array) {
            Err(note) => notes.push(note),
            Ok(columns) => {
                for column in columns {
                    let rows = column.values.len();
                    if rows == 1 && column.fault.is_none() {
                        log.constants.push((column.name, column.values[0]));
                        continue;
                    }
                    if rows < 2 {
                        notes.push(format!("'{}' has no numbers", column.name));
                        continue;
                    }
                    match tables.iter_mut().find(|t| t.rows() == rows) {
                        Some(table) if table.columns.len() >= MOST_COLUMNS => {}
                        Some(table) if table.column(&column.name).is_some() => {
                            notes.push(format!("'{}' is there twice: the first is kept", column.name));
                        }
                        Some(table) => table.columns.push(column),
                        None => tables.push(Table { columns: vec![column], ..Table::default() }),
                    }
                }
            }
        }
    }
    tables.sort_by_key(|t| std::cmp::Reverse(t.rows() * t.columns.len()));
    for table in tables.iter_mut().skip(1) {
        table.name = format!("arrays of {}", table.rows());
    }
    log.tables = tables;
    log.notes = notes;
    log
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_becomes_columns_along_its_longer_side_in_either_order() {
        let array = |shape: &[usize], first_fastest, values: &[f64]| Array {
            name: "q".into(),
            shape: shape.to_vec(),
            first_fastest,
            values: values.to_vec(),
            holds: None,
        };
        for array in [
            array(&[3, 2], true, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
            array(&[3, 2], false, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]),
            array(&[2, 3], true, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]),
            array(&[2, 1, 3], false, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        ] {
            let log = into_log("", vec![array], Vec::new());
            assert_eq!(log.tables[0].column("q[0]").unwrap().values, [1.0, 2.0, 3.0]);
            assert_eq!(log.tables[0].column("q[1]").unwrap().values, [4.0, 5.0, 6.0]);
        }
        assert_eq!(into_log("", vec![array(&[1, 1], true, &[7.0])], Vec::new()).constants[0].1, 7.0);
        // Two runs of three rows of two joints, row by row and as MATLAB keeps it.
        let rows: Vec<f64> = (0..12).map(f64::from).collect();
        let at = |run: usize, row: usize, joint: usize| rows[6 * run + 2 * row + joint];
        let fastest = [0, 1].map(|joint| [0, 1, 2].map(|row| [0, 1].map(|run| at(run, row, joint))));
        for array in
            [array(&[2, 3, 2], false, &rows), array(&[2, 3, 2], true, fastest.as_flattened().as_flattened())]
        {
            let log = into_log("", vec![array], Vec::new());
            for (run, joint) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let column = log.tables[0].column(&format!("q[{run}][{joint}]")).unwrap();
                assert_eq!(column.values, [0, 1, 2].map(|row| at(run, row, joint)));
            }
        }
        let wide = array(&[600, 600], false, &vec![0.0; 360_000]);
        assert!(into_log("", vec![wide], Vec::new()).notes[0].contains("600 by 600"));
    }
}
