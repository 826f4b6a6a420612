//! What a log is once it has been read: tables of named columns, and where each row stood in the file.

use crate::budget::{Budget, MOST_COLUMNS};
use crate::error::Place;
use std::collections::HashMap;

/// A log file: one table, or one for each topic, list or length of arrays.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// What the file is, for people: `CSV`, `MCAP`.
    pub format: &'static str,
    /// The tables, none of them without rows.
    pub tables: Vec<Table>,
    /// Single numbers beside the tables: the gains and masses that the maker wrote down.
    pub constants: Vec<(String, f64)>,
    /// What the file has and no table shows, and other oddities, one line each.
    pub notes: Vec<String>,
}

/// Rows of numbers under named columns.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The topic or list that it stands for; empty where the file has one table.
    pub name: String,
    /// The columns, all of one length, no two with the same name.
    pub columns: Vec<Column>,
    /// Where each row stood.
    pub places: Places,
    /// The column that the format itself keeps time in (of a message: when it was logged), s.
    pub clock: Option<usize>,
    /// Whether the file names no columns; they are then called `#1`, `#2` and so on.
    pub headerless: bool,
}

/// A named column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// Its name in the file.
    pub name: String,
    /// One value for each row; NaN where the cell is no finite number.
    pub values: Vec<f64>,
    /// A whole number that was subtracted from every value, so that time since 1970 keeps its nanoseconds.
    pub origin: i64,
    /// What it holds if not plain numbers: truth values, time stamps.
    pub holds: Option<String>,
    /// Its first cell that is no finite number.
    pub fault: Option<Fault>,
}

/// Whole numbers up to this are exact as doubles.
pub(crate) const EXACT: u64 = 1 << 53;

/// A cell that is no finite number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The row, from 0.
    pub row: usize,
    /// What is wrong with the cell.
    pub problem: String,
}

impl Table {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// The column of this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// How a campaign may call the column from anywhere: its name, behind the table's name if that has one.
    #[must_use]
    pub fn full_name(&self, column: &Column) -> String {
        if self.name.is_empty() { column.name.clone() } else { format!("{}.{}", self.name, column.name) }
    }

    /// Keeps these rows alone, which must be in increasing order.
    pub(crate) fn keep(&mut self, rows: &[usize]) {
        for column in &mut self.columns {
            let first_bad = rows.iter().position(|&r| !column.values[r].is_finite());
            column.values = rows.iter().map(|&r| column.values[r]).collect();
            column.fault = first_bad.map(|row| Fault {
                row,
                problem: column.fault.take().map_or_else(|| NOT_FINITE.to_owned(), |f| f.problem),
            });
        }
        let before = std::mem::take(&mut self.places);
        self.places = Places { lines: before.lines, breaks: Vec::new() };
        for (now, &row) in rows.iter().enumerate() {
            self.places.note(now, before.number(row));
        }
    }
}

/// What is said of a cell of which nothing better is known.
const NOT_FINITE: &str = "is no finite number";

impl Column {
    /// An empty column.
    pub(crate) fn named(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// A column of these values; those that are not finite are faults.
    pub(crate) fn of(name: impl Into<String>, values: Vec<f64>) -> Self {
        let fault = values
            .iter()
            .position(|v| !v.is_finite())
            .map(|row| Fault { row, problem: format!("'{}' is not finite", values[row]) });
        let mut column = Self { name: name.into(), values, fault, ..Self::default() };
        if let Some(fault) = &column.fault {
            column.values[fault.row..].iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = f64::NAN);
        }
        column
    }

    /// Appends a cell that is no finite number.
    pub(crate) fn push_fault(&mut self, problem: impl FnOnce() -> String) {
        if self.fault.is_none() {
            self.fault = Some(Fault { row: self.values.len(), problem: problem() });
        }
        self.values.push(f64::NAN);
    }

    /// The values with what was subtracted from them.
    #[must_use]
    pub fn into_absolute(mut self) -> Vec<f64> {
        if self.origin != 0 {
            self.values.iter_mut().for_each(|v| *v += self.origin as f64);
        }
        self.values
    }

    /// Appends a number that may have more digits than a double, given as a whole number too if it is one: of a column
    /// that begins with such, the first is subtracted from all.
    pub(crate) fn push_whole(&mut self, value: f64, whole: Option<i64>) {
        if self.values.is_empty()
            && let Some(first) = whole.filter(|w| w.unsigned_abs() > EXACT)
        {
            self.origin = first;
        }
        let told = match whole {
            Some(whole) if self.origin != 0 => whole.wrapping_sub(self.origin) as f64,
            _ => value - self.origin as f64,
        };
        self.push(told);
    }

    /// Appends a value.
    pub(crate) fn push(&mut self, value: f64) {
        if value.is_finite() {
            self.values.push(value);
        } else {
            self.push_fault(|| format!("'{value}' is not finite"));
        }
    }
}

/// Where rows stood in the file: numbers that count up by one but for a few jumps (blank lines, comments).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Places {
    /// Whether the numbers are those of lines; else of rows.
    pub(crate) lines: bool,
    /// Rows from which on the number is the second plus the distance to the first.
    breaks: Vec<(usize, u64)>,
}

impl Places {
    /// Rows that are lines of a text.
    pub(crate) fn lines() -> Self {
        Self { lines: true, breaks: Vec::new() }
    }

    /// Says that the row (from 0; called in increasing order) stood at this number (from 1).
    pub(crate) fn note(&mut self, row: usize, number: u64) {
        if self.number(row) != number {
            self.breaks.push((row, number));
        }
    }

    fn number(&self, row: usize) -> u64 {
        let at = self.breaks.partition_point(|&(from, _)| from <= row);
        let (from, number) = at.checked_sub(1).map_or((0, 1), |i| self.breaks[i]);
        number + (row - from) as u64
    }

    /// Where the row stood.
    #[must_use]
    pub fn of(&self, row: usize) -> Place {
        let number = self.number(row);
        if self.lines { Place::Line(number) } else { Place::Row(number) }
    }
}

/// What a cell of a message or entry holds.
pub(crate) enum Cell<'a> {
    Number(f64),
    Bool(bool),
    Text(&'a str),
    Null,
}

/// A table that grows by rows whose cells come by name: entries of a list, messages of a topic.
#[derive(Default)]
pub(crate) struct Rows {
    columns: Vec<Column>,
    by_name: HashMap<String, usize>,
    rows: usize,
    /// The column after the one that was filled last: rows mostly have their cells in the same order.
    next: usize,
    /// Columns beyond the most that a table may have.
    pub too_many: bool,
}

impl Rows {
    /// Number of whole rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Fills the cell of this column in the row that is being built.
    pub fn put(&mut self, name: &str, cell: &Cell, budget: &mut Budget) -> Result<(), String> {
        let index = match self.columns.get(self.next) {
            Some(column) if column.name == name => self.next,
            _ => match self.by_name.get(name) {
                Some(&index) => index,
                None if self.columns.len() == MOST_COLUMNS => {
                    self.too_many = true;
                    return Ok(());
                }
                None => {
                    budget.take(self.rows)?;
                    let mut column = Column::named(name);
                    if self.rows > 0 {
                        column.push_fault(|| MISSING.to_owned());
                        column.values.resize(self.rows, f64::NAN);
                    }
                    self.columns.push(column);
                    self.by_name.insert(name.to_owned(), self.columns.len() - 1);
                    self.columns.len() - 1
                }
            },
        };
        self.next = index + 1;
        let column = &mut self.columns[index];
        if column.values.len() > self.rows {
            return Ok(());
        }
        budget.take(1)?;
        match cell {
            Cell::Number(value) => column.push(*value),
            Cell::Bool(value) => {
                column.holds.get_or_insert_with(|| TRUTH.to_owned());
                column.push(f64::from(u8::from(*value)));
            }
            Cell::Text(text) => column.push_fault(|| no_number(text)),
            Cell::Null => column.push_fault(|| EMPTY.to_owned()),
        }
        Ok(())
    }

    /// Ends the row; columns that got no cell have none.
    pub fn end_row(&mut self, budget: &mut Budget) -> Result<(), String> {
        self.rows += 1;
        self.next = 0;
        for column in self.columns.iter_mut().filter(|c| c.values.len() < self.rows) {
            budget.take(1)?;
            column.push_fault(|| MISSING.to_owned());
        }
        Ok(())
    }

    /// The table, if it has a column and a row.
    pub fn into_table(self, name: impl Into<String>) -> Option<Table> {
        let Self { mut columns, rows, .. } = self;
        // A row that was never ended is not whole.
        columns.iter_mut().for_each(|c| {
            c.values.truncate(rows);
            c.fault = c.fault.take().filter(|f| f.row < rows);
        });
        (rows > 0 && !columns.is_empty()).then(|| Table { name: name.into(), columns, ..Table::default() })
    }
}

/// What is said of columns whose cells are true or false.
pub(crate) const TRUTH: &str = "true and false";

/// What a column holds of which a row below the header states the unit, before that.
pub(crate) const IN_UNIT: &str = "in ";

/// The unit in what a column holds, where a row below the header states it, without brackets.
pub(crate) fn stated_unit(holds: &str) -> Option<&str> {
    Some(holds.strip_prefix(IN_UNIT)?.trim().trim_matches(['[', ']', '(', ')']))
}
/// What is said of a cell without content.
pub(crate) const EMPTY: &str = "the cell is empty";
const MISSING: &str = "has no value here";

/// What is said of a cell that holds something else.
pub(crate) fn no_number(text: &str) -> String {
    format!("'{}' is no number", text.chars().take(40).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_keep_the_jumps_and_nothing_else() {
        let mut places = Places::lines();
        for (row, line) in [2, 3, 4, 6, 7, 20, 21].into_iter().enumerate() {
            places.note(row, line);
        }
        assert_eq!(places.breaks.len(), 3);
        assert_eq!(places.of(3), Place::Line(6));
        assert_eq!(places.of(6), Place::Line(21));
        assert_eq!(Places::default().of(4), Place::Row(5));
    }

    #[test]
    fn rows_with_other_cells_leave_faults_behind() {
        let (mut rows, mut budget) = (Rows::default(), Budget::of_file(0));
        for (i, names) in [["a", "b"], ["a", "c"], ["b", "a"]].iter().enumerate() {
            for name in names {
                rows.put(name, &Cell::Number(i as f64), &mut budget).unwrap();
            }
            rows.end_row(&mut budget).unwrap();
        }
        let table = rows.into_table("t").unwrap();
        assert_eq!(table.column("a").unwrap().values, [0.0, 1.0, 2.0]);
        assert_eq!(table.column("b").unwrap().fault.as_ref().unwrap().row, 1);
        assert_eq!(table.column("c").unwrap().fault.as_ref().unwrap().row, 0);
        assert_eq!(table.rows(), 3);
    }
}
