//! Tables as text: CSV, also separated by semicolons, tabs or spaces, with comments, with or without a header, in UTF-8, Latin-1 or UTF-16.

use crate::budget::{Budget, MOST_COLUMNS};
use crate::encoding::in_utf8;
use crate::preamble::{self, Preamble};
use crate::table::{Column, EMPTY, EXACT, IN_UNIT, Log, Places, TRUTH, Table, no_number};
use crate::{LogError, moment};
use std::path::Path;

/// Reads the bytes of a text.
///
/// The first line that is no comment (`#`, `%`, `//`) holds the columns' names, or a later one where other lines stand above
/// it ([`preamble`]). Where it holds numbers, the comment before it does if it has as many words, and else nobody does
/// ([`Table::headerless`]). The separator is that of
/// `;`, tab, `,` and space which the line has first in this order; a comma inside a cell is a decimal point.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    let text = in_utf8(bytes);
    let bytes = text.as_ref();
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(LogError::whole(path, "is empty"));
    }
    let start = Start::of(bytes);
    let body = &bytes[start.offset..];
    let separator = start.separator;
    // Spaces in a row, and at the line's ends, are one separator: such cells are split here and not by the library.
    if separator == b' ' {
        return spaced(path, body, &start);
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(separator)
        .comment(start.comment)
        .from_reader(body);
    let line_of = |position: Option<&csv::Position>| position.map(|p| p.line() + start.lines);
    let mut row = csv::ByteRecord::new();
    let mut table: Option<Building> = None;
    loop {
        match reader.read_byte_record(&mut row) {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => {
                return Err(LogError::new(path, line_of(e.position()), None, format!("is no CSV: {e}")));
            }
        }
        // A row of one empty cell is a blank line with spaces in it.
        if row.len() == 1 && row[0].iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let line = row.position().map_or(1, |p| start.lines + line_of_record(body, p, start.comment));
        match &mut table {
            None => table = Some(Building::new(path, line, row.iter(), &start, bytes.len())?),
            Some(table) => table.row(path, line, row.len(), row.iter())?,
        }
    }
    finish(path, table, &start)
}

/// The line of a record that the library says to begin here: it means the end of the record before, with blank lines,
/// comments and half of a line break between them.
fn line_of_record(body: &[u8], position: &csv::Position, comment: Option<u8>) -> u64 {
    let (mut at, mut line) = (position.byte() as usize, position.line());
    loop {
        match body.get(at) {
            Some(b'\n') => line += 1,
            Some(b'\r') => {}
            Some(&mark) if Some(mark) == comment => {
                let rest = &body[at..];
                at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                continue;
            }
            _ => return line,
        }
        at += 1;
    }
}

/// As [`parse`] of a body whose cells are separated by spaces.
fn spaced(path: &Path, body: &[u8], start: &Start) -> Result<Log, LogError> {
    let mut table: Option<Building> = None;
    for (i, line) in body.split(|&b| b == b'\n').enumerate() {
        let number = i as u64 + 1 + start.lines;
        let cells = || line.split(u8::is_ascii_whitespace).filter(|c| !c.is_empty());
        let count = cells().count();
        if count == 0 || start.comment.is_some_and(|c| line.trim_ascii_start().starts_with(&[c])) {
            continue;
        }
        match &mut table {
            None => table = Some(Building::new(path, number, cells(), start, body.len())?),
            Some(table) => table.row(path, number, count, cells())?,
        }
    }
    finish(path, table, start)
}

fn finish(path: &Path, table: Option<Building>, start: &Start) -> Result<Log, LogError> {
    let Some(table) = table else { return Err(LogError::whole(path, "is empty")) };
    let cut = table.cut.map(|cut| format!("{cut}: the last line is cut off, and left out"));
    let above = start.above.as_ref().map(|_| format!("the columns' names stand in line {}", start.lines + 1));
    let again =
        table.named_again.map(|line| format!("the columns' names stand again in line {line}: left out"));
    let table = Table {
        columns: table.columns,
        places: table.places,
        headerless: table.headerless,
        ..Table::default()
    };
    let notes = above.into_iter().chain(again).chain(cut).collect();
    let constants = start.above.as_ref().map_or(Vec::new(), |above| above.constants.clone());
    Ok(Log { format: "CSV", tables: vec![table], notes, constants })
}

/// How a text begins.
struct Start<'a> {
    /// Bytes and lines before the first line of the table: comment, and what stands above the columns' names.
    offset: usize,
    lines: u64,
    /// What comments begin with.
    comment: Option<u8>,
    separator: u8,
    /// The last line of comment, which may be a header.
    commented: Option<&'a [u8]>,
    above: Option<Preamble>,
}

impl<'a> Start<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        let (mut offset, mut lines, mut comment, mut commented) = (0, 0, None, None);
        loop {
            let rest = &bytes[offset..];
            let length = rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |at| at + 1);
            let line = rest[..length].trim_ascii();
            let mark = [&b"#"[..], b"%", b"//"].into_iter().find(|mark| line.starts_with(mark));
            // Spreadsheets begin with `sep=;`.
            let blank = line.is_empty() || (line.len() == 5 && line.starts_with(b"sep="));
            // The reader skips and counts blank lines itself, unless a comment follows them.
            if length == 0 || (mark.is_none() && !blank) {
                let above = preamble::above(rest);
                if let Some(above) = &above {
                    offset += above.bytes;
                    lines += above.lines as u64;
                }
                let first = bytes[offset..].split(|&b| b == b'\n').next().unwrap_or_default();
                let separator = separator(first.trim_ascii());
                return Self { offset, lines, comment, separator, commented, above };
            }
            if let Some(mark) = mark {
                comment = Some(mark[0]);
                commented = Some(line[mark.len()..].trim_ascii());
            }
            offset += length;
            lines += 1;
        }
    }
}

/// What separates the cells of a line.
pub(crate) fn separator(line: &[u8]) -> u8 {
    [b';', b'\t', b',', b' '].into_iter().find(|s| line.contains(s)).unwrap_or(b',')
}

/// A table that is being read.
struct Building {
    columns: Vec<Column>,
    places: Places,
    headerless: bool,
    budget: Budget,
    decimal_comma: bool,
    /// Whether the next row is the first one below a header.
    units_may_follow: bool,
    /// A row with too few cells, which may be the last one of a log whose power went.
    cut: Option<LogError>,
    /// The first line that holds the names once more: a log that began anew.
    named_again: Option<u64>,
}

impl Building {
    /// Takes the first row, a header or not.
    fn new<'r>(
        path: &Path,
        line: u64,
        first: impl Iterator<Item = &'r [u8]> + Clone,
        start: &Start,
        bytes: usize,
    ) -> Result<Self, LogError> {
        let first = first.take(start.above.as_ref().map_or(usize::MAX, |above| above.columns));
        let cells = first.clone().count();
        let decimal_comma = start.separator != b',';
        let numbers = first.clone().filter(|cell| number(cell, decimal_comma).is_ok()).count();
        if numbers > 0 && numbers < cells {
            return Err(LogError::new(path, line, None, NO_HEADER));
        }
        let mut building = Self {
            columns: Vec::with_capacity(cells.min(MOST_COLUMNS)),
            places: Places::lines(),
            headerless: false,
            budget: Budget::of_file(bytes),
            decimal_comma,
            units_may_follow: numbers == 0,
            cut: None,
            named_again: None,
        };
        if numbers == 0 {
            for cell in first.clone() {
                building.name(path, line, cell)?;
            }
        } else {
            let split = |b: &u8| match start.separator {
                b' ' => b.is_ascii_whitespace(),
                s => *b == s,
            };
            let said = start.commented.map_or(Vec::new(), |c| {
                c.split(split).map(<[u8]>::trim_ascii).filter(|w| !w.is_empty()).collect::<Vec<_>>()
            });
            building.headerless = said.len() != cells;
            for i in 0..cells {
                let numbered = format!("#{}", i + 1);
                let name = if building.headerless { numbered.as_bytes() } else { said[i] };
                building.name(path, start.lines.max(1), name)?;
            }
        }
        let rows = bytes / (8 * cells.max(1));
        building.columns.iter_mut().for_each(|c| c.values.reserve_exact(rows));
        if numbers > 0 {
            building.row(path, line, cells, first)?;
        }
        Ok(building)
    }

    fn name(&mut self, path: &Path, line: u64, cell: &[u8]) -> Result<(), LogError> {
        let bad = |name: Option<&str>, problem: String| Err(LogError::new(path, line, name, problem));
        let Ok(name) = std::str::from_utf8(cell) else {
            let problem = "a column's name is not UTF-8: save the log as CSV in UTF-8 (a spreadsheet or a pickle has to be exported)";
            return bad(None, problem.to_owned());
        };
        let name = name.trim().trim_matches('"').trim();
        if self.columns.len() == MOST_COLUMNS {
            return bad(None, format!("has more than {MOST_COLUMNS} columns"));
        }
        // pandas writes its index under an empty name.
        let numbered = format!("#{}", self.columns.len() + 1);
        let name = if name.is_empty() { &numbered } else { name };
        if self.columns.iter().any(|c| c.name == name) {
            return bad(Some(name), "stands in the header twice".to_owned());
        }
        self.columns.push(Column::named(name));
        Ok(())
    }

    /// Takes a row; one with too few cells is an error once another one follows.
    fn row<'r>(
        &mut self,
        path: &Path,
        line: u64,
        count: usize,
        cells: impl Iterator<Item = &'r [u8]> + Clone,
    ) -> Result<(), LogError> {
        if let Some(cut) = self.cut.take() {
            return Err(cut);
        }
        let (columns, begun) = (self.columns.len(), !self.columns[0].values.is_empty());
        // Some writers end every row with a separator.
        let ended = count == columns + 1 && cells.clone().last().is_some_and(|c| c.trim_ascii().is_empty());
        if count != columns && !ended {
            let missing = self.columns.get(count).map(|c| c.name.as_str());
            let cure = match begun {
                true => "",
                false => "; where lines stand above the columns' names, delete them or begin them with #",
            };
            let problem = format!("has {count} cells, the header {columns} columns{cure}");
            let error = LogError::new(path, line, missing, problem);
            if count > columns || !begun {
                return Err(error);
            }
            self.cut = Some(error);
            return Ok(());
        }
        self.budget.take(columns).map_err(|problem| LogError::whole(path, problem))?;
        if std::mem::take(&mut self.units_may_follow) && self.are_units(cells.clone()) {
            for (column, cell) in self.columns.iter_mut().zip(cells) {
                let unit = String::from_utf8_lossy(cell.trim_ascii()).into_owned();
                column.holds = (!unit.is_empty()).then(|| format!("{IN_UNIT}{unit}"));
            }
            return Ok(());
        }
        let named = |(column, cell): (&Column, &[u8])| cell.trim_ascii() == column.name.as_bytes();
        if self.columns.iter().zip(cells.clone()).all(named) {
            self.named_again.get_or_insert(line);
            return Ok(());
        }
        self.places.note(self.columns[0].values.len(), line);
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            match number(cell, self.decimal_comma) {
                Ok(value) if value.abs() < EXACT as f64 && column.origin == 0 => column.values.push(value),
                Ok(value) => {
                    let text = std::str::from_utf8(cell.trim_ascii()).unwrap_or_default();
                    column.push_whole(value, text.parse().ok());
                }
                Err(Odd::Moment(stamp, what)) => {
                    column.holds.get_or_insert_with(|| what.to_owned());
                    column.push_whole(stamp as f64, Some(stamp));
                }
                Err(Odd::Truth(value)) => {
                    column.holds.get_or_insert_with(|| TRUTH.to_owned());
                    column.values.push(f64::from(u8::from(value)));
                }
                Err(Odd::Fault(problem)) => column.push_fault(|| problem),
            }
        }
        Ok(())
    }

    /// Whether cells are units: short words, and no number or truth value.
    fn are_units<'r>(&self, cells: impl Iterator<Item = &'r [u8]> + Clone) -> bool {
        let word = |cell: &[u8]| {
            let text = String::from_utf8_lossy(cell.trim_ascii());
            let fault = matches!(number(cell, self.decimal_comma), Err(Odd::Fault(_)));
            fault && text.chars().count() <= LONGEST_UNIT && !text.to_lowercase().contains("nan")
        };
        let said = cells.clone().filter(|c| !c.trim_ascii().is_empty()).count();
        2 * said > self.columns.len() && cells.into_iter().all(word)
    }
}

/// The longest unit's letters: `[mNm/rad]`.
const LONGEST_UNIT: usize = 9;

const NO_HEADER: &str = "no header: the first row must hold the columns' names; `ros2 topic echo --csv` leaves them out, a bag of `ros2 bag record` \
                         holds them";

/// What a cell is if not a finite number.
enum Odd {
    Truth(bool),
    /// Nanoseconds, and since when.
    Moment(i64, &'static str),
    Fault(String),
}

/// Whether a cell holds a number, a date or a truth value.
pub(crate) fn is_number(cell: &[u8], decimal_comma: bool) -> bool {
    !matches!(number(cell, decimal_comma), Err(Odd::Fault(_)))
}

/// A finite number, or what the cell is instead.
fn number(cell: &[u8], decimal_comma: bool) -> Result<f64, Odd> {
    let text = String::from_utf8_lossy(cell.trim_ascii());
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Odd::Fault(format!("'{text}' is not finite"))),
        Err(_) if text.is_empty() => Err(Odd::Fault(EMPTY.to_owned())),
        Err(_) if text.eq_ignore_ascii_case("true") => Err(Odd::Truth(true)),
        Err(_) if text.eq_ignore_ascii_case("false") => Err(Odd::Truth(false)),
        Err(_) if decimal_comma && text.contains(',') && !text.contains('.') => {
            let value = text.replacen(',', ".", 1).parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| Odd::Fault(no_number(&text)))
        }
        Err(_) => Err(match moment::nanoseconds(&text) {
            Some((stamp, what)) => Odd::Moment(stamp, what),
            None => Odd::Fault(no_number(&text)),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Place;

    fn read(text: &str) -> Result<Table, LogError> {
        parse(Path::new("r.csv"), text.as_bytes()).map(|mut log| log.tables.remove(0))
    }

    #[test]
    fn separators_comments_and_commented_headers_are_found() {
        for text in [
            "# a rig\n\nt, q ,\"f\"\n0,1,2\n# in between\n1,2,3\n\n2,3,4\n",
            "t;q;f\n0,0;1,0;2\n1;2,0;3\n2;3;4\n",
            "sep=;\nt;q;f\n0,0;1,0;2\n1;2,0;3\n2;3;4\n",
            "t\tq\tf\n0,0\t1,0\t2\n1\t2,0\t3\n2\t3\t4\n",
            "% made by a rig\nt\tq\tf\n0\t1\t2\n1\t2\t3\n2\t3\t4",
            "  t   q  f\n 0.0  1 2\n 1 2 3\n2 3 4  \n",
            "# rig 7\n# t q f\n0 1 2\n1 2 3\n2 3 4\n",
            "# t,q,f\n0,1,2\n1,2,3\n2,3,4\n",
        ] {
            let table = read(text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
            assert_eq!(names, ["t", "q", "f"], "{text:?}");
            assert_eq!(table.columns[1].values, [1.0, 2.0, 3.0], "{text:?}");
            assert_eq!(table.columns[2].values, [2.0, 3.0, 4.0], "{text:?}");
            assert!(!table.headerless);
        }
    }

    #[test]
    fn rows_know_their_lines() {
        let table = read("# a\n# b\n\nt,q\n0,1\n\n1,x\n# c\n2,\n").unwrap();
        let fault = table.columns[1].fault.as_ref().unwrap();
        assert_eq!(
            (table.places.of(fault.row), fault.problem.as_str()),
            (Place::Line(7), "'x' is no number")
        );
        assert_eq!(table.places.of(2), Place::Line(9));
        for text in ["t q\n\n0 1\n\n1 x\n", "t,q\r\n\r\n0,1\r\n\r\n1,x\r\n", "t;q\n\n0;\"1\"\n\n1;x"] {
            let table = read(text).unwrap();
            assert_eq!(table.places.of(0), Place::Line(3), "{text:?}");
            assert_eq!(table.places.of(1), Place::Line(5), "{text:?}");
        }
    }

    #[test]
    fn a_table_without_names_is_numbered() {
        let table = read("0,1\n1,2\n").unwrap();
        assert!(table.headerless);
        assert_eq!(table.columns[1].name, "#2");
        assert_eq!(table.rows(), 2);
        let table = read(",t\n0,0.0\n1,0.1\n").unwrap();
        assert_eq!(table.columns[0].name, "#1");
        assert!(read("t,2\n0,1\n").unwrap_err().problem.contains("no header"));
    }

    #[test]
    fn a_row_of_units_below_the_header_is_no_row_of_numbers() {
        let table = read("t;Winkel;Strom\n[s];[deg];A\n0;1;2\n1;2;3\n").unwrap();
        assert_eq!(table.columns[1].values, [1.0, 2.0]);
        assert_eq!(table.columns[1].holds.as_deref(), Some("in [deg]"));
        assert_eq!(table.places.of(0), Place::Line(3));
        // A cell that is no number is a fault of its row.
        let table = read("t,q\n0,x\n1,2\n").unwrap();
        assert!(table.rows() == 2 && table.columns[1].fault.is_some());
    }

    #[test]
    fn rows_may_end_with_a_separator_and_the_last_one_may_be_cut_off() {
        let table = read("t,q\n0,1,\n1,2,\n").unwrap();
        assert_eq!((table.rows(), table.columns.len()), (2, 2));
        let log = parse(Path::new("r.csv"), b"t,q,f\n0,1,2\n1,2,3\n2,2").unwrap();
        assert_eq!(log.tables[0].rows(), 2);
        assert!(log.notes[0].contains("line 4") && log.notes[0].contains("left out"), "{:?}", log.notes);
        assert!(read("t,q,f\n0,1,2\n1,2\n2,2,3\n").unwrap_err().problem.contains("has 2 cells"));
    }

    #[test]
    fn a_line_that_names_the_columns_again_is_no_row() {
        let log = parse(Path::new("r.csv"), b"t,q\n0,1\nt,q\n1,2\n").unwrap();
        assert_eq!(log.tables[0].columns[1].values, [1.0, 2.0]);
        assert!(log.notes[0].contains("line 3") && log.tables[0].columns[1].fault.is_none());
        assert_eq!(log.tables[0].places.of(1), Place::Line(4));
    }

    #[test]
    fn dates_are_nanoseconds_and_say_so() {
        let table = read("stamp,q\n2026-05-01 09:30:00.000000001,0\n2026-05-01 09:30:00.002,1\n").unwrap();
        assert_eq!(table.columns[0].values, [0.0, 1_999_999.0]);
        assert_eq!(table.columns[0].origin, 1_777_627_800_000_000_001);
        assert!(table.columns[0].holds.as_ref().is_some_and(|h| h.contains("nanoseconds since 1970")));
        assert!(table.columns[0].fault.is_none() && table.columns[1].values == [0.0, 1.0]);
    }

    #[test]
    fn a_text_in_latin_1_or_utf_16_is_read() {
        let text = "t;Kraft µN\n0;1,5\n1;2\n";
        let latin = b"t;Winkel \xb0\n0;1,5\n1;2\n";
        let table = parse(Path::new("r.csv"), latin).unwrap().tables.remove(0);
        assert_eq!(table.columns[1].name, "Winkel °");
        let in_order = |mark: [u8; 2], of: fn(u16) -> [u8; 2]| -> Vec<u8> {
            mark.into_iter().chain(text.encode_utf16().flat_map(of)).collect()
        };
        for bytes in [in_order([0xff, 0xfe], u16::to_le_bytes), in_order([0xfe, 0xff], u16::to_be_bytes)] {
            let table = parse(Path::new("r.csv"), &bytes).unwrap().tables.remove(0);
            assert_eq!(table.columns[1].name, "Kraft µN");
            assert_eq!(table.columns[1].values, [1.5, 2.0]);
        }
    }

    #[test]
    fn truth_values_are_numbers_and_say_so() {
        let table = read("t,enable\n0,True\n1,false\n").unwrap();
        assert_eq!(table.columns[1].values, [1.0, 0.0]);
        assert_eq!(table.columns[1].holds.as_deref(), Some(TRUTH));
    }
}
