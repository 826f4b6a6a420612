//! JSON: lists of entries, lists of numbers under names, and one entry a line (JSON Lines).
//!
//! A list of objects (or of lists) is a table, its name the keys that lead to it: the numbers of
//! `{"entries": [{"position": 1.0, "motor": {"current": 2.0}}]}` are columns `position` and `motor.current` of the
//! table `entries`. Lists inside an entry are columns `forces[0]`, `forces[1]`. A list of numbers outside of any entry is
//! a column by itself; single numbers are constants. The text is read as a stream: only the numbers are kept.

use crate::LogError;
use crate::arrays::{Array, into_log};
use crate::budget::{Budget, MOST_ARRAY};
use crate::table::{Cell, Log, Rows, TRUTH};
use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::path::Path;

/// Most tables of one file.
const MOST_TABLES: usize = 1000;

/// Reads the bytes of a JSON text.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(LogError::whole(path, "is empty"));
    }
    let mut found = Found { budget: Some(Budget::of_file(bytes.len())), ..Found::default() };
    let said = |e: &serde_json::Error| LogError::new(path, e.line() as u64, None, unreadable(e, bytes));
    let mut text = serde_json::Deserializer::from_slice(bytes);
    Outside { found: &mut found, path: String::new() }.deserialize(&mut text).map_err(|e| said(&e))?;
    if let Err(error) = text.end() {
        // More values after the first: one entry a line.
        let first_line = bytes.split(|&b| b == b'\n').find(|l| !l.trim_ascii().is_empty()).unwrap_or(bytes);
        if !first_line.trim_ascii_start().starts_with(b"{") || !first_line.trim_ascii_end().ends_with(b"}") {
            return Err(said(&error));
        }
        return lines(path, bytes);
    }
    Ok(found.into_log())
}

/// One entry a line.
fn lines(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    let mut budget = Budget::of_file(bytes.len());
    let mut rows = Rows::default();
    let mut places = crate::table::Places::lines();
    for (i, line) in bytes.split(|&b| b == b'\n').enumerate() {
        if line.trim_ascii().is_empty() {
            continue;
        }
        let number = i as u64 + 1;
        places.note(rows.rows(), number);
        entry(line, &mut rows, &mut budget).map_err(|problem| LogError::new(path, number, None, problem))?;
    }
    let mut log = Log { format: "JSON Lines", ..Log::default() };
    if let Some(mut table) = rows.into_table("") {
        table.places = places;
        log.tables.push(table);
    }
    Ok(log)
}

/// What is wrong with a text that is no JSON, without its place; Python writes numbers that JSON has not.
fn unreadable(error: &serde_json::Error, text: &[u8]) -> String {
    let has = |word: &[u8]| text.windows(word.len()).any(|w| w == word);
    let cure =
        if has(b"NaN") || has(b"Infinity") { "; NaN and Infinity are no JSON: write null" } else { "" };
    let said = error.to_string();
    format!("is no readable JSON: {}{cure}", said.split(" at line ").next().unwrap_or_default())
}

/// Puts one JSON object into a row.
pub(crate) fn entry(text: &[u8], rows: &mut Rows, budget: &mut Budget) -> Result<(), String> {
    let mut deserializer = serde_json::Deserializer::from_slice(text);
    Inside { rows: &mut *rows, budget: &mut *budget, path: &mut String::new() }
        .deserialize(&mut deserializer)
        .map_err(|e| unreadable(&e, text))?;
    deserializer.end().map_err(|e| unreadable(&e, text))?;
    rows.end_row(budget)
}

/// What a file was found to hold.
#[derive(Default)]
struct Found {
    tables: Vec<(String, Rows)>,
    arrays: Vec<Array>,
    constants: Vec<(String, f64)>,
    notes: Vec<String>,
    budget: Option<Budget>,
}

impl Found {
    fn budget(&mut self) -> &mut Budget {
        self.budget.get_or_insert_with(|| Budget::of_file(0))
    }

    fn into_log(self) -> Log {
        let mut log = into_log("JSON", self.arrays, self.notes);
        log.constants.extend(self.constants);
        let mut tables: Vec<_> =
            self.tables.into_iter().filter_map(|(name, rows)| rows.into_table(name)).collect();
        tables.append(&mut log.tables);
        log.tables = tables;
        log
    }
}

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}

/// What is outside of any entry.
struct Outside<'a> {
    found: &'a mut Found,
    path: String,
}

impl<'de> DeserializeSeed<'de> for Outside<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Outside<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of entries")
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<(), E> {
        if self.found.constants.len() < MOST_TABLES {
            self.found.constants.push((self.path, value));
        }
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            map.next_value_seed(Outside { found: self.found, path: joined(&self.path, &key) })?;
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let (mut rows, mut alone) = (Rows::default(), Alone::default());
        let mut budget = std::mem::replace(self.found.budget(), Budget::of_file(0));
        loop {
            let element =
                Element { rows: &mut rows, alone: &mut alone, budget: &mut budget, path: &mut String::new() };
            if seq.next_element_seed(element)?.is_none() {
                break;
            }
        }
        *self.found.budget() = budget;
        if rows.too_many {
            self.found.notes.push(format!("'{}' has more columns than are read", self.path));
        }
        if alone.count > 0 {
            if alone.others > 0 || rows.rows() > 0 {
                let note = format!("'{}' is a list of numbers and other things: left out", self.path);
                self.found.notes.push(note);
            } else {
                let name = if self.path.is_empty() { "values".to_owned() } else { self.path.clone() };
                let array = Array {
                    name,
                    shape: vec![alone.values.len()],
                    first_fastest: true,
                    values: alone.values,
                    holds: (alone.truths > 0).then(|| TRUTH.to_owned()),
                };
                self.found.arrays.push(array);
            }
        }
        if rows.rows() > 0 && self.found.tables.len() < MOST_TABLES {
            self.found.tables.push((self.path, rows));
        }
        Ok(())
    }
}

/// The numbers of a list that has no entries.
#[derive(Default)]
struct Alone {
    values: Vec<f64>,
    count: usize,
    truths: usize,
    /// Texts and nulls.
    others: usize,
}

/// One element of a list outside of any entry.
struct Element<'a> {
    rows: &'a mut Rows,
    alone: &'a mut Alone,
    budget: &'a mut Budget,
    path: &'a mut String,
}

impl<'de> DeserializeSeed<'de> for Element<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Element<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an entry")
    }

    fn visit_bool<E: serde::de::Error>(self, value: bool) -> Result<(), E> {
        self.alone.truths += 1;
        self.visit_f64(f64::from(u8::from(value)))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<(), E> {
        self.budget.take(1).map_err(E::custom)?;
        self.alone.values.push(value);
        self.alone.count += 1;
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        self.alone.others += 1;
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.alone.others += 1;
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<(), A::Error> {
        Inside { rows: &mut *self.rows, budget: &mut *self.budget, path: self.path }.visit_map(map)?;
        self.rows.end_row(self.budget).map_err(A::Error::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<(), A::Error> {
        Inside { rows: &mut *self.rows, budget: &mut *self.budget, path: self.path }.visit_seq(seq)?;
        self.rows.end_row(self.budget).map_err(A::Error::custom)
    }
}

/// What is inside an entry, at these keys.
struct Inside<'a> {
    rows: &'a mut Rows,
    budget: &'a mut Budget,
    path: &'a mut String,
}

impl Inside<'_> {
    fn put<E: serde::de::Error>(self, cell: &Cell) -> Result<(), E> {
        let name = if self.path.is_empty() { "value" } else { self.path.as_str() };
        self.rows.put(name, cell, self.budget).map_err(E::custom)
    }
}

impl<'de> DeserializeSeed<'de> for Inside<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Inside<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value of an entry")
    }

    fn visit_bool<E: serde::de::Error>(self, value: bool) -> Result<(), E> {
        self.put(&Cell::Bool(value))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<(), E> {
        self.put(&Cell::Number(value as f64))
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<(), E> {
        self.put(&Cell::Number(value as f64))
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<(), E> {
        self.put(&Cell::Number(value))
    }

    fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<(), E> {
        self.put(&Cell::Text(value))
    }

    fn visit_unit<E: serde::de::Error>(self) -> Result<(), E> {
        self.put(&Cell::Null)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let length = self.path.len();
        while let Some(key) = map.next_key::<String>()? {
            if length > 0 {
                self.path.push('.');
            }
            self.path.push_str(&key);
            map.next_value_seed(Inside {
                rows: &mut *self.rows,
                budget: &mut *self.budget,
                path: &mut *self.path,
            })?;
            self.path.truncate(length);
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let length = self.path.len();
        for i in 0..MOST_ARRAY {
            self.path.push_str(&format!("[{i}]"));
            let inside = Inside { rows: &mut *self.rows, budget: &mut *self.budget, path: &mut *self.path };
            let more = seq.next_element_seed(inside)?;
            self.path.truncate(length);
            if more.is_none() {
                return Ok(());
            }
        }
        // A longer list is a picture or a scan, and no signal.
        self.rows.too_many = true;
        while seq.next_element::<IgnoredAny>()?.is_some() {}
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Place;

    fn read(text: &str) -> Result<Log, LogError> {
        parse(Path::new("r.json"), text.as_bytes())
    }

    #[test]
    fn entries_constants_and_nested_keys_are_found() {
        let log = read(
            r#"{"mass": 0.5, "motor": {"kp": 3}, "rig": "a", "entries":
               [{"t": 0, "on": true, "m": {"i": [1.5, 2.5]}}, {"t": 1, "on": false, "m": {"i": [3, null]}}]}"#,
        )
        .unwrap();
        assert_eq!(log.constants, [("mass".to_owned(), 0.5), ("motor.kp".to_owned(), 3.0)]);
        let table = &log.tables[0];
        assert_eq!((table.name.as_str(), table.rows()), ("entries", 2));
        assert_eq!(table.column("m.i[0]").unwrap().values, [1.5, 3.0]);
        let bad = table.column("m.i[1]").unwrap();
        assert_eq!(table.places.of(bad.fault.as_ref().unwrap().row), Place::Row(2));
        assert_eq!(table.column("on").unwrap().values, [1.0, 0.0]);
        assert_eq!(table.full_name(bad), "entries.m.i[1]");
    }

    #[test]
    fn columns_lists_of_lists_and_lines_are_tables() {
        let log = read(r#"{"t": [0, 1, 2], "q": [3, 4, 5], "label": "x"}"#).unwrap();
        assert_eq!(log.tables[0].column("q").unwrap().values, [3.0, 4.0, 5.0]);
        let log = read("[[0, 1], [2, 3]]").unwrap();
        assert_eq!(log.tables[0].column("[1]").unwrap().values, [1.0, 3.0]);
        let log = read("{\"t\": 0}\n\n{\"t\": 1}\n{\"t\": \"x\"}").unwrap();
        let table = &log.tables[0];
        assert_eq!(table.places.of(table.columns[0].fault.as_ref().unwrap().row), Place::Line(4));
    }

    #[test]
    fn what_is_no_json_is_refused_with_its_line() {
        let error = read("{\"a\": [1,\n 2,\n ]}").unwrap_err();
        assert_eq!(error.at, Place::Line(3));
        assert!(read(&"[".repeat(100_000)).is_err());
        assert!(read("{\"a\": 1e999}").is_err());
        assert!(read(" ").unwrap_err().problem.contains("empty"));
    }
}
