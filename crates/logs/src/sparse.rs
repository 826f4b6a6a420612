//! Tables in which each signal has cells in rows of its own: what was logged on several clocks and written under one.

use crate::survey::{clock_of, goes_on};
use crate::table::Table;
use std::collections::HashMap;

/// Share of a column's cells without a number beyond which it was logged on a clock of its own; fewer are a fault of the log.
const SPARSE: f64 = 0.2;

/// Fewest cells with a number, and without one, that tell a clock of its own from a fault.
const FEWEST: usize = 8;

/// A column of the data contract's own time: in such a file a cell that is no number is a fault.
const OWN_TIME: &str = "time_s";

/// A table cut into one for each set of rows that columns have numbers in, each with the time of its rows; as it is where no
/// column is sparse, or no time stands beside them.
pub(crate) fn apart(table: Table) -> Vec<Table> {
    let rows = table.rows();
    let clock = clock_of(&table).map(|(clock, _)| clock).filter(|&clock| {
        let column = &table.columns[clock];
        column.fault.is_none() && goes_on(&column.values)
    });
    let Some(clock) = clock.filter(|_| table.column(OWN_TIME).is_none()) else { return vec![table] };
    let is_sparse = |values: &[f64]| {
        let numbers = values.iter().filter(|v| v.is_finite()).count();
        let empty = rows - numbers;
        numbers.min(empty) >= FEWEST && empty as f64 > SPARSE * rows as f64
    };
    // Columns by the rows in which they have numbers; those that are not sparse stay together.
    let mut of_rows: HashMap<Vec<bool>, usize> = HashMap::new();
    let mut groups: Vec<Vec<usize>> = vec![Vec::new()];
    for (i, column) in table.columns.iter().enumerate().filter(|(i, _)| *i != clock) {
        let group = match is_sparse(&column.values) {
            false => 0,
            true => {
                let filled: Vec<bool> = column.values.iter().map(|v| v.is_finite()).collect();
                *of_rows.entry(filled).or_insert(groups.len())
            }
        };
        if group == groups.len() {
            groups.push(Vec::new());
        }
        groups[group].push(i);
    }
    if groups.len() == 1 {
        return vec![table];
    }
    let cut = |(group, members): (usize, &Vec<usize>)| {
        let first = *members.first()?;
        let columns = std::iter::once(clock).chain(members.iter().copied());
        let mut part = Table {
            name: table.name.clone(),
            columns: columns.map(|i| table.columns[i].clone()).collect(),
            places: table.places.clone(),
            clock: table.clock.map(|_| 0),
            headerless: table.headerless,
        };
        if group > 0 {
            let values = &table.columns[first].values;
            part.keep(&(0..rows).filter(|&row| values[row].is_finite()).collect::<Vec<_>>());
        }
        Some(part)
    };
    groups.iter().enumerate().filter_map(cut).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Column;

    fn table(time: &str) -> Table {
        let every = |n: usize| (0..40).map(|r| if r % n == 0 { r as f64 } else { f64::NAN }).collect();
        let columns = vec![
            Column::of(time, (0..40).map(f64::from).collect()),
            Column::of("fast", every(2)),
            Column::of("slow", every(4)),
            Column::of("beside", every(4)),
        ];
        Table { columns, ..Table::default() }
    }

    #[test]
    fn signals_in_rows_of_their_own_are_tables_with_the_time_of_these() {
        let parts = apart(table("__time"));
        let names = |t: &Table| t.columns.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
        assert_eq!(
            parts.iter().map(names).collect::<Vec<_>>(),
            [vec!["__time", "fast"], vec!["__time", "slow", "beside"]]
        );
        assert_eq!(parts[1].columns[0].values[..3], [0.0, 4.0, 8.0]);
        assert!(parts.iter().flat_map(|t| &t.columns).all(|c| c.fault.is_none()));
        assert_eq!((parts[0].rows(), parts[1].rows()), (20, 10));
    }

    #[test]
    fn a_few_empty_cells_are_faults_and_so_are_those_beside_the_contracts_time() {
        assert_eq!(apart(table(OWN_TIME)).len(), 1);
        let mut whole = table("t");
        whole.columns.truncate(2);
        whole.columns[1].values = (0..40).map(|r| if r == 7 { f64::NAN } else { f64::from(r) }).collect();
        assert_eq!(apart(whole).len(), 1);
    }
}
