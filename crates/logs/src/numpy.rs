//! NumPy: `.npy` with one array (or one of records), `.npz` with several.
//!
//! The header is a dictionary in Python's notation with three keys; it is read here, as the libraries that read it bring
//! a parser generator along.

use crate::arrays::{Array, into_log};
use crate::budget::{Budget, MOST_ARRAY};
use crate::table::{Log, TRUTH};
use crate::{LogError, zip};
use std::path::Path;

/// Reads the bytes of a `.npy` file.
pub(crate) fn parse_npy(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    let mut budget = Budget::of_file(bytes.len());
    let mut notes = Vec::new();
    let arrays =
        arrays("array", bytes, &mut budget, &mut notes).map_err(|problem| LogError::whole(path, problem))?;
    Ok(into_log("NumPy", arrays, notes))
}

/// Reads the bytes of a `.npz` archive.
pub(crate) fn parse_npz(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    let broken = |problem: String| LogError::whole(path, format!("is no readable NPZ archive: {problem}"));
    let mut budget = Budget::of_file(bytes.len());
    let (mut all, mut notes) = (Vec::new(), Vec::new());
    for member in zip::members(bytes).map_err(broken)? {
        let Some(name) = member.name.strip_suffix(".npy") else {
            notes.push(format!("'{}' is no array: left out", member.name));
            continue;
        };
        let found = zip::content(bytes, &member)
            .and_then(|content| arrays(name, &content, &mut budget, &mut notes))
            .map_err(|problem| LogError::new(path, None, Some(name), problem))?;
        all.extend(found);
    }
    Ok(into_log("NumPy", all, notes))
}

/// The arrays of one `.npy`: one, or one for each field of its records.
fn arrays(
    name: &str,
    bytes: &[u8],
    budget: &mut Budget,
    notes: &mut Vec<String>,
) -> Result<Vec<Array>, String> {
    let header = Header::read(bytes)?;
    let count = header
        .shape
        .iter()
        .try_fold(1usize, |n, &d| n.checked_mul(d))
        .filter(|&n| n.checked_mul(header.record()).is_some_and(|size| size <= bytes.len() - header.data))
        .ok_or_else(|| format!("its header claims {:?} values, more than the file has", header.shape))?;
    let data = &bytes[header.data..];
    let (record, mut arrays, mut offset) = (header.record(), Vec::new(), 0);
    for field in &header.fields {
        let name = match field.name.as_str() {
            "" => name.to_owned(),
            part => format!("{name}.{part}"),
        };
        let from = offset;
        offset += field.size * field.count;
        let Some(kind) = field.kind else {
            notes.push(format!("'{name}' holds {}: left out", field.descr));
            continue;
        };
        for i in 0..field.count {
            budget.take(count)?;
            let at = |n: usize| kind.number(&data[n * record + from + i * field.size..][..field.size]);
            arrays.push(Array {
                name: if field.count == 1 { name.clone() } else { format!("{name}[{i}]") },
                shape: header.shape.clone(),
                first_fastest: header.fortran,
                values: (0..count).map(at).collect(),
                holds: matches!(kind, Kind::Bool).then(|| TRUTH.to_owned()),
            });
        }
    }
    Ok(arrays)
}

/// What a header says.
struct Header {
    shape: Vec<usize>,
    fortran: bool,
    fields: Vec<Field>,
    /// Where the data begin.
    data: usize,
}

/// A field of a record, or the only one of a plain array, without name.
struct Field {
    name: String,
    descr: String,
    kind: Option<Kind>,
    size: usize,
    /// How many there are in one record.
    count: usize,
}

impl Header {
    fn record(&self) -> usize {
        self.fields.iter().map(|f| f.size * f.count).sum()
    }

    fn read(bytes: &[u8]) -> Result<Self, String> {
        let broken = || "is no readable NumPy array: its header is broken".to_owned();
        let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(broken)?;
        let (length, at) = match rest {
            [1, _, a, b, ..] => (u32::from(u16::from_le_bytes([*a, *b])), 10),
            [2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([*a, *b, *c, *d]), 12),
            _ => return Err(broken()),
        };
        let data = usize::try_from(length).ok().and_then(|n| n.checked_add(at)).ok_or_else(broken)?;
        let text = bytes.get(at..data).and_then(|t| std::str::from_utf8(t).ok()).ok_or_else(broken)?;
        let mut text = Notation { rest: text, depth: 0 };
        let Some(Value::Dict(items)) = text.value() else { return Err(broken()) };
        let mut header = Self { shape: Vec::new(), fortran: false, fields: Vec::new(), data };
        for (key, value) in items {
            match (key.as_str(), value) {
                ("fortran_order", Value::Bool(fortran)) => header.fortran = fortran,
                ("shape", Value::List(shape)) => {
                    let number = |v: Value| if let Value::Number(n) = v { Some(n) } else { None };
                    header.shape = shape.into_iter().map(number).collect::<Option<_>>().ok_or_else(broken)?;
                }
                ("descr", Value::Text(descr)) => header.fields.push(Field::of(String::new(), &descr, 1)?),
                ("descr", Value::List(fields)) => {
                    for field in fields {
                        let Value::List(field) = field else { return Err(broken()) };
                        header.fields.push(record_field(field).ok_or_else(broken)??);
                    }
                }
                _ => return Err(broken()),
            }
        }
        if header.fields.is_empty() || header.record() == 0 {
            return Err(broken());
        }
        Ok(header)
    }
}

/// `('name', '<f8')` or `('name', '<f8', (3,))`.
fn record_field(field: Vec<Value>) -> Option<Result<Field, String>> {
    let mut parts = field.into_iter();
    let (Value::Text(name), Value::Text(descr)) = (parts.next()?, parts.next()?) else { return None };
    let count = match parts.next() {
        None => 1,
        Some(Value::Number(n)) => n,
        Some(Value::List(shape)) => shape.into_iter().try_fold(1usize, |n, d| match d {
            Value::Number(d) => n.checked_mul(d),
            _ => None,
        })?,
        _ => return None,
    };
    Some(Field::of(name, &descr, count))
}

impl Field {
    fn of(name: String, descr: &str, count: usize) -> Result<Self, String> {
        let unknown = || format!("holds '{descr}', which is not read");
        let digits = descr.find(|c: char| c.is_ascii_digit()).unwrap_or(descr.len());
        let (code, rest) = descr.split_at(digits);
        // What follows the size says the unit of a time stamp.
        let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
        let size: usize = rest[..end].parse().map_err(|_| {
            if descr.contains('O') {
                "holds Python objects, which are not read".to_owned()
            } else {
                unknown()
            }
        })?;
        let big = code.starts_with('>');
        let letter = code.trim_start_matches(['<', '>', '|', '=']);
        let kind = match (letter, size) {
            ("b", 1) => Some(Kind::Bool),
            ("f", 2) => Some(Kind::Half(big)),
            ("f", 4) => Some(Kind::Single(big)),
            ("f", 8) => Some(Kind::Double(big)),
            ("i", 1 | 2 | 4 | 8) => Some(Kind::Signed(big)),
            ("u", 1 | 2 | 4 | 8) => Some(Kind::Unsigned(big)),
            ("M" | "m", 8) => Some(Kind::Signed(big)),
            // Texts, raw bytes, complex and long numbers: skipped by their size.
            ("U", n) if n < 1 << 20 => None,
            ("S" | "V" | "c" | "f" | "a", n) if n < 1 << 20 => None,
            _ => return Err(unknown()),
        };
        let size = if letter == "U" { 4 * size } else { size };
        let kind = kind.filter(|_| count <= MOST_ARRAY);
        if count > 1 << 30 || size.checked_mul(count).is_none_or(|n| n > 1 << 40) {
            return Err(unknown());
        }
        Ok(Self { name, descr: descr.to_owned(), kind, size, count })
    }
}

/// How a number is stored; the flags say that its most significant byte comes first.
#[derive(Clone, Copy)]
enum Kind {
    Bool,
    Half(bool),
    Single(bool),
    Double(bool),
    Signed(bool),
    Unsigned(bool),
}

impl Kind {
    /// The number in these bytes, as many as the type has.
    fn number(self, bytes: &[u8]) -> f64 {
        let (Self::Half(big)
        | Self::Single(big)
        | Self::Double(big)
        | Self::Signed(big)
        | Self::Unsigned(big)) = self
        else {
            return f64::from(u8::from(bytes[0] != 0));
        };
        let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        let bits = if big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) };
        match self {
            Self::Double(_) => f64::from_bits(bits),
            Self::Single(_) => f64::from(f32::from_bits(bits as u32)),
            Self::Half(_) => half(bits as u16),
            Self::Signed(_) => {
                let unused = 64 - 8 * bytes.len() as u32;
                ((bits << unused).cast_signed() >> unused) as f64
            }
            _ => bits as f64,
        }
    }
}

/// A number of IEEE 754's binary16.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        e => (1.0 + fraction / 1024.0) * 2f64.powi(e - 15),
    }
}

/// A value in Python's notation, as far as headers have it.
enum Value {
    Text(String),
    Number(usize),
    Bool(bool),
    List(Vec<Value>),
    Dict(Vec<(String, Value)>),
}

/// A text in Python's notation.
struct Notation<'a> {
    rest: &'a str,
    depth: usize,
}

impl Notation<'_> {
    fn skip(&mut self, mark: char) -> bool {
        self.rest = self.rest.trim_start();
        let found = self.rest.starts_with(mark);
        if found {
            self.rest = &self.rest[mark.len_utf8()..];
        }
        found
    }

    fn value(&mut self) -> Option<Value> {
        // A record of arrays of a record is as deep as headers go.
        if self.depth > 8 {
            return None;
        }
        self.depth += 1;
        let value = self.some_value();
        self.depth -= 1;
        value
    }

    fn some_value(&mut self) -> Option<Value> {
        for quote in ['\'', '"'] {
            if self.skip(quote) {
                let end = self.rest.find(quote)?;
                let text = self.rest[..end].to_owned();
                self.rest = &self.rest[end + 1..];
                return Some(Value::Text(text));
            }
        }
        for (open, close) in [('(', ')'), ('[', ']')] {
            if self.skip(open) {
                let mut values = Vec::new();
                while !self.skip(close) {
                    values.push(self.value()?);
                    self.skip(',');
                }
                return Some(Value::List(values));
            }
        }
        if self.skip('{') {
            let mut items = Vec::new();
            while !self.skip('}') {
                let Value::Text(key) = self.value()? else { return None };
                if !self.skip(':') {
                    return None;
                }
                items.push((key, self.value()?));
                self.skip(',');
            }
            return Some(Value::Dict(items));
        }
        let end = self.rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        match word {
            "True" => Some(Value::Bool(true)),
            "False" => Some(Value::Bool(false)),
            // Python 2 wrote long numbers with an L.
            number => number.trim_end_matches('L').parse().ok().map(Value::Number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_precision_numbers_are_read() {
        for (bits, value) in [
            (0x3C00, 1.0),
            (0xC000, -2.0),
            (0x0001, 2f64.powi(-24)),
            (0x3555, 0.333_251_953_125),
            (0x7BFF, 65504.0),
        ] {
            assert_eq!(half(bits), value);
        }
    }

    #[test]
    fn a_header_that_claims_more_than_there_is_is_refused() {
        let text = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        let error = parse_npy(Path::new("r.npy"), &bytes).unwrap_err();
        assert!(error.problem.contains("claims"), "{error}");
    }
}
