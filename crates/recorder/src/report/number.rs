//! Numbers of figures and tables, given when the page is written: first what is open, then what is folded.

use std::fmt::Write as _;

/// What stands around a place for a number: noncharacters, which no escaped text holds.
const MARKS: (char, char) = ('\u{FDD0}', '\u{FDD1}');

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Figure,
    Table,
}

/// What has been counted so far.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Numbers {
    /// How many details are open around what is written now.
    pub folded: usize,
    given: Vec<(Kind, bool)>,
}

impl Numbers {
    /// The place of the next number.
    pub fn next(&mut self, kind: Kind) -> String {
        self.given.push((kind, self.folded > 0));
        format!("{}{}{}", MARKS.0, self.given.len() - 1, MARKS.1)
    }

    /// The number of a place.
    fn of(&self, place: usize) -> usize {
        let (kind, folded) = self.given[place];
        let same = |wanted: bool| move |(k, f): &&(Kind, bool)| *k == kind && *f == wanted;
        let before = self.given[..place].iter().filter(same(folded)).count();
        let open = if folded { self.given.iter().filter(same(false)).count() } else { 0 };
        open + before + 1
    }

    /// A text with the numbers in their places.
    pub fn written_into(&self, text: &str) -> String {
        let mut out = String::with_capacity(text.len());
        let mut parts = text.split(MARKS.0);
        out.push_str(parts.next().unwrap_or(""));
        for part in parts {
            let (place, rest) = part.split_once(MARKS.1).unwrap_or(("", part));
            if let Some(place) = place.parse().ok().filter(|&p| p < self.given.len()) {
                let _ = write!(out, "{}", self.of(place));
            }
            out.push_str(rest);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_folded_is_numbered_after_what_is_open() {
        let mut numbers = Numbers::default();
        let first = numbers.next(Kind::Figure);
        numbers.folded += 1;
        let (inside, table) = (numbers.next(Kind::Figure), numbers.next(Kind::Table));
        numbers.folded -= 1;
        let last = numbers.next(Kind::Figure);
        let text = format!("a{first}b{inside}c{table}d{last}e");
        assert_eq!(numbers.written_into(&text), "a1b3c1d2e");
    }
}
