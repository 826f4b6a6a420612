//! What stands above a table in a text, as instruments write it: who measured what, at which rate.

use crate::csv_table::{is_number, separator};

/// Most lines above the columns' names.
const MOST_LINES: usize = 200;

/// Longest line that is looked at: of more columns than a table may have.
const LONGEST: usize = 1 << 18;

/// A column that LabVIEW names and mostly leaves without cells.
const REMARKS: &[u8] = b"Comment";

/// Lines above the columns' names.
#[derive(Debug, PartialEq)]
pub(crate) struct Preamble {
    /// Their bytes.
    pub bytes: usize,
    /// Their number.
    pub lines: usize,
    /// Number of the table's columns.
    pub columns: usize,
    /// Numbers that they state: `Rate: 200 Hz`.
    pub constants: Vec<(String, f64)>,
}

/// The lines of a text above the columns' names; `None` where the first line holds them, or nothing looks like a table.
///
/// Two rows of numbers with as many cells each are a table's; the line above them with as many words holds the names, or,
/// where another such line stands above that, the units.
pub(crate) fn above(text: &[u8]) -> Option<Preamble> {
    let lines: Vec<&[u8]> = text.split_inclusive(|&b| b == b'\n').take(MOST_LINES + 3).collect();
    let blank = |at: &usize| !lines[*at].trim_ascii().is_empty();
    let said: Vec<usize> = (0..lines.len()).filter(blank).collect();
    let row = (0..said.len().checked_sub(1)?).find(|&i| {
        let (line, next) = (lines[said[i]], lines[said[i + 1]]);
        let by = separator(line.trim_ascii());
        let cells = cells(line, by);
        cells.len() > 1 && are_numbers(&cells, by) && {
            let next = self::cells(next, by);
            next.len() == cells.len() && are_numbers(&next, by)
        }
    })?;
    let by = separator(lines[said[row]].trim_ascii());
    let columns = cells(lines[said[row]], by).len();
    let are_names = |words: &[Vec<u8>]| !words.iter().any(|w| w.is_empty() || is_number(w, by != b','));
    let names = |i: &usize| {
        let mut words = cells(lines[said[*i]], by);
        if words.len() == columns + 1 && words.last().is_some_and(|w| w == REMARKS) {
            words.pop();
        }
        words.len() == columns && are_names(&words)
    };
    let header = (row.saturating_sub(2)..row).rev().take_while(names).last()?;
    // Names in the first line, and as many cells in all below it: an ordinary table, some cells of which are no numbers.
    let first = cells(lines[said[0]], by);
    let like_it = || said[..header].iter().all(|&at| cells(lines[at], by).len() == first.len());
    if header == 0 || (first.len() == columns && are_names(&first) && like_it()) {
        return None;
    }
    let above = &lines[..said[header]];
    Some(Preamble {
        bytes: above.iter().map(|line| line.len()).sum(),
        lines: above.len(),
        columns,
        constants: above.iter().filter_map(|line| constant(line, by)).collect(),
    })
}

/// The cells of a line, without an empty one at its end.
fn cells(line: &[u8], by: u8) -> Vec<Vec<u8>> {
    if line.len() > LONGEST {
        return Vec::new();
    }
    let line = line.trim_ascii_end();
    let mut cells: Vec<Vec<u8>> = if by == b' ' {
        line.split(u8::is_ascii_whitespace).filter(|c| !c.is_empty()).map(<[u8]>::to_vec).collect()
    } else {
        let mut record = csv::ByteRecord::new();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).delimiter(by).from_reader(line);
        match reader.read_byte_record(&mut record) {
            Ok(true) => record.iter().map(|cell| cell.trim_ascii().to_vec()).collect(),
            _ => Vec::new(),
        }
    };
    if cells.last().is_some_and(Vec::is_empty) {
        cells.pop();
    }
    cells
}

/// Whether cells are those of a row: numbers, some of which may be missing.
fn are_numbers(cells: &[Vec<u8>], by: u8) -> bool {
    let number = |cell: &Vec<u8>| is_number(cell, by != b',');
    cells.iter().any(number) && cells.iter().all(|cell| cell.is_empty() || number(cell))
}

/// The number that a line states, and its name: `Rate: 200 Hz`, `Delta_X<tab>0.005`.
fn constant(line: &[u8], by: u8) -> Option<(String, f64)> {
    let line = String::from_utf8_lossy(line.trim_ascii());
    let at = line.find([':', '=']).or_else(|| line.find(char::from(by)))?;
    let (name, rest) = (line[..at].trim().trim_matches('"'), &line[at + 1..]);
    let first = rest.split([' ', '\t', char::from(by)]).find(|word| !word.is_empty())?;
    let value = first.trim_matches('"').replacen(',', ".", 1).parse::<f64>().ok()?;
    (value.is_finite() && name.chars().any(char::is_alphabetic)).then(|| (name.to_owned(), value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_above_the_names_are_counted_and_their_numbers_read() {
        let text = b"Bench 3\nRate: 200 Hz\n\nTime,Force\n0,1\n1,2\n";
        let found = above(text).expect("a preamble");
        assert_eq!((found.bytes, found.lines, found.columns), (22, 3, 2));
        assert_eq!(found.constants, [("Rate".to_owned(), 200.0)]);
        // Names, units, and a column without cells, as LabVIEW writes them.
        let text = b"LabVIEW Measurement\t\nSeparator\tTab\t\n***End_of_Header***\t\nX_Value\tForce\tComment\n0,0\t1,5\n0,1\t2,5\n";
        assert_eq!(above(text).map(|found| (found.lines, found.columns)), Some((3, 2)));
        // Cells as many as the table's, but of other lines, or numbers among them.
        let text = b"Bench 3, run 4\nOperator: A\nTime,Force\n0,1\n1,2\n";
        assert_eq!(above(text).map(|found| (found.lines, found.columns)), Some((2, 2)));
        let text = b"Sample Interval,0.005\n,\nTime,Force\n0,1\n1,2\n";
        assert_eq!(
            above(text).map(|found| found.constants),
            Some(vec![("Sample Interval".to_owned(), 0.005)])
        );
        let text = b"Motor 7\nt;q;f\ns;deg;N\n0;1;2\n1;2;3\n";
        assert_eq!(above(text).map(|found| (found.lines, found.columns)), Some((1, 3)));
    }

    #[test]
    fn an_ordinary_table_has_nothing_above_it() {
        for text in [
            &b"t,q\n0,1\n1,2\n"[..],
            b"t,q\n0,1,\n1,2,\n",
            b"t,q,f\n0,1\n1,2\n",
            b"0,1\n1,2\n",
            b"t,q\n0,x\n1,2\n2,3\n",
            b"\"t, s\",q\n0,1\n1,2\n",
            b"no table at all\n",
            b"",
        ] {
            assert_eq!(above(text), None, "{}", String::from_utf8_lossy(text));
        }
    }
}
