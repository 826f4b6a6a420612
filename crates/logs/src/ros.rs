//! Messages of ROS 2: the definition of their types as text, and their bytes in CDR.
//!
//! Definitions are those of `.msg` files, the types that a message uses behind lines of `=` and `MSG: package/Name`, as
//! recorders store them. Bytes are Common Data Representation (OMG, XCDR version 1): every number stands at a multiple
//! of its size, counted from the fifth byte.

use crate::budget::{Budget, MOST_ARRAY};
use crate::table::{Cell, Rows};
use std::collections::{HashMap, HashSet};

/// Types inside types are followed so deep.
const DEEPEST: usize = 32;

/// Parts without bytes that a message may have beside one for each byte.
const MOST_EMPTY: usize = 1000;

/// Definitions of messages that files of old recorders do not bring along.
const KNOWN: [(&str, &str); 12] = [
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Int32", "int32 data"),
    ("std_msgs/Int64", "int64 data"),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data"),
    ("std_msgs/Float32MultiArray", "MultiArrayLayout layout\nfloat32[] data"),
    ("std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset"),
    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
];

/// A message type with all that it uses.
#[derive(Debug)]
pub(crate) struct Schema {
    types: HashMap<String, Vec<Field>>,
    root: String,
}

#[derive(Debug, Clone)]
struct Field {
    name: String,
    kind: Kind,
    many: Many,
}

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    Bool,
    Signed(usize),
    Unsigned(usize),
    Single,
    Double,
    Text,
    WideText,
    Other(String),
}

impl Kind {
    /// Bytes of a number of this kind.
    fn size(&self) -> Option<usize> {
        match self {
            Self::Bool => Some(1),
            Self::Signed(size) | Self::Unsigned(size) => Some(*size),
            Self::Single => Some(4),
            Self::Double => Some(8),
            _ => None,
        }
    }
}

#[derive(Debug, Clone, Copy)]
enum Many {
    One,
    Fixed(usize),
    Any,
}

/// `sensor_msgs/msg/JointState` is `sensor_msgs/JointState`.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

impl Schema {
    /// Of a definition; of a known type without any.
    pub fn new(name: &str, definition: &str) -> Result<Self, String> {
        let root = plain(name.trim());
        let mut types: HashMap<String, Vec<Field>> = HashMap::new();
        let mut current = root.clone();
        let package_of = |name: &str| name.split('/').next().unwrap_or_default().to_owned();
        for known in KNOWN {
            types.insert(known.0.to_owned(), fields(known.1, &package_of(known.0))?);
        }
        let mut text = String::new();
        let mut put = |name: &str, text: &mut String| -> Result<(), String> {
            if !text.trim().is_empty() || name != root {
                types.insert(name.to_owned(), fields(text, &package_of(name))?);
            }
            text.clear();
            Ok(())
        };
        for line in definition.lines() {
            if line.starts_with("====") {
                continue;
            }
            if let Some(next) = line.strip_prefix("MSG:") {
                put(&current, &mut text)?;
                current = plain(next.trim());
            } else {
                text.push_str(line);
                text.push('\n');
            }
        }
        put(&current, &mut text)?;
        if !types.contains_key(&root) {
            return Err(format!("the file does not define the message type {name}"));
        }
        Ok(Self { types, root })
    }

    /// Puts the numbers of one message, with its four bytes of encapsulation, into the row that is being built.
    ///
    /// Of stamps the whole number `stamps.origin` is subtracted; their columns are noted in `stamps`.
    pub fn decode(
        &self,
        bytes: &[u8],
        rows: &mut Rows,
        budget: &mut Budget,
        stamps: &mut Stamps,
    ) -> Result<(), String> {
        let big = match bytes {
            [0, 0, _, _, ..] => true,
            [0, 1, _, _, ..] => false,
            [_, kind, ..] => return Err(format!("its bytes are of kind {kind}, which is not read (CDR is)")),
            _ => return Err(CUT.to_owned()),
        };
        // An element without content has no bytes; such may stand inside each other without end.
        let steps = bytes.len() + MOST_EMPTY;
        let mut cdr = Cdr { bytes: &bytes[4..], at: 0, big, steps };
        let mut sink = Sink { rows, budget, stamps, quiet: false };
        self.message(&self.root, &mut cdr, &mut String::new(), &mut sink, 0)
    }

    fn message(
        &self,
        name: &str,
        cdr: &mut Cdr,
        path: &mut String,
        sink: &mut Sink,
        depth: usize,
    ) -> Result<(), String> {
        let fields = self.types.get(name).ok_or_else(|| format!("the file does not define {name}"))?;
        if depth == DEEPEST {
            return Err(format!("{name} is inside of more than {DEEPEST} other types"));
        }
        cdr.steps = cdr.steps.checked_sub(1).ok_or_else(|| format!("{name} holds too many parts"))?;
        // An empty type has one byte.
        if fields.is_empty() {
            cdr.take(1)?;
        }
        let mut names: Vec<String> = Vec::new();
        let stem = path.len();
        for field in fields {
            if stem > 0 {
                path.push('.');
            }
            path.push_str(&field.name);
            // A stamp is one number.
            if field.kind == Kind::Other("builtin_interfaces/Time".to_owned())
                && matches!(field.many, Many::One)
            {
                let (seconds, nanoseconds) = (cdr.signed(4)?, cdr.unsigned(4)?);
                path.push_str("_s");
                let since = seconds.wrapping_sub(sink.stamps.origin);
                if !sink.quiet {
                    sink.stamps.note(path);
                }
                sink.put(path, since as f64 + 1e-9 * nanoseconds as f64)?;
                path.truncate(stem);
                continue;
            }
            let count = match field.many {
                Many::One => {
                    self.value(&field.kind, cdr, path, sink, depth)?;
                    path.truncate(stem);
                    continue;
                }
                Many::Fixed(count) => count,
                Many::Any => cdr.unsigned(4)? as usize,
            };
            // Every element takes at least a byte.
            if count > cdr.left() {
                return Err(format!("'{path}' claims {count} values, more than the message has"));
            }
            let whole = path.len();
            let joints = matches!(field.name.as_str(), "name" | "names" | "joint_names");
            let quiet = sink.quiet;
            // A longer array is a picture or a scan, and no signal.
            sink.quiet |= count > MOST_ARRAY;
            if let Some(size) = field.kind.size().filter(|_| sink.quiet && count > 0) {
                sink.rows.too_many = true;
                cdr.at = cdr.at.next_multiple_of(size);
                cdr.take(count.saturating_mul(size))?;
                sink.quiet = quiet;
                path.truncate(stem);
                continue;
            }
            for i in 0..count {
                if field.kind == Kind::Text && joints {
                    names.push(cdr.text()?);
                    continue;
                }
                if !sink.quiet {
                    match names.get(i).filter(|_| names.len() == count) {
                        Some(name) => path.extend(["[", name, "]"]),
                        None => path.push_str(&format!("[{i}]")),
                    }
                }
                self.value(&field.kind, cdr, path, sink, depth)?;
                path.truncate(whole);
            }
            sink.quiet = quiet;
            path.truncate(stem);
        }
        Ok(())
    }

    fn value(
        &self,
        kind: &Kind,
        cdr: &mut Cdr,
        path: &mut String,
        sink: &mut Sink,
        depth: usize,
    ) -> Result<(), String> {
        match kind {
            Kind::Bool => {
                let value = cdr.take(1)?[0] != 0;
                sink.cell(path, &Cell::Bool(value))
            }
            Kind::Signed(size) => {
                let value = cdr.signed(*size)?;
                sink.put(path, value as f64)
            }
            Kind::Unsigned(size) => {
                let value = cdr.unsigned(*size)?;
                sink.put(path, value as f64)
            }
            Kind::Single => {
                let value = f32::from_bits(cdr.unsigned(4)? as u32);
                sink.put(path, f64::from(value))
            }
            Kind::Double => {
                let value = f64::from_bits(cdr.unsigned(8)?);
                sink.put(path, value)
            }
            Kind::Text => cdr.text().map(drop),
            Kind::WideText => {
                let count = cdr.unsigned(4)? as usize;
                cdr.take(count.saturating_mul(2)).map(drop)
            }
            Kind::Other(name) => self.message(name, cdr, path, sink, depth + 1),
        }
    }
}

/// The columns of a topic that hold stamps, and the whole seconds that are subtracted from them.
#[derive(Debug, Default)]
pub(crate) struct Stamps {
    pub origin: i64,
    pub columns: HashSet<String>,
}

impl Stamps {
    fn note(&mut self, path: &str) {
        if !self.columns.contains(path) && self.columns.len() < MOST_ARRAY {
            self.columns.insert(path.to_owned());
        }
    }
}

/// Where the numbers go.
struct Sink<'a> {
    rows: &'a mut Rows,
    budget: &'a mut Budget,
    stamps: &'a mut Stamps,
    /// Inside an array that is too long to become columns.
    quiet: bool,
}

impl Sink<'_> {
    fn put(&mut self, path: &str, value: f64) -> Result<(), String> {
        self.cell(path, &Cell::Number(value))
    }

    fn cell(&mut self, path: &str, cell: &Cell) -> Result<(), String> {
        if self.quiet {
            self.rows.too_many = true;
            return Ok(());
        }
        self.rows.put(path, cell, self.budget)
    }
}

/// The fields of a definition's text.
fn fields(text: &str, package: &str) -> Result<Vec<Field>, String> {
    let mut fields = Vec::new();
    for line in text.lines() {
        let line = line.split('#').next().unwrap_or_default().trim();
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else { continue };
        // Constants have no bytes; a default value follows the name after a space.
        if name.contains('=') || words.next().is_some_and(|w| w.starts_with('=')) {
            continue;
        }
        let (kind, many) = match kind.split_once('[') {
            None => (kind, Many::One),
            Some((kind, size)) => {
                let size = size.trim_end_matches(']');
                match size.parse::<usize>() {
                    Ok(count) => (kind, Many::Fixed(count)),
                    Err(_) if size.is_empty() || size.starts_with("<=") => (kind, Many::Any),
                    Err(_) => return Err(format!("the definition of a message has '{line}'")),
                }
            }
        };
        // `string<=10` has a bound, which its bytes do not show.
        let kind = match kind.split("<=").next().unwrap_or_default() {
            "bool" => Kind::Bool,
            "byte" | "char" | "uint8" => Kind::Unsigned(1),
            "int8" => Kind::Signed(1),
            "int16" => Kind::Signed(2),
            "uint16" => Kind::Unsigned(2),
            "int32" => Kind::Signed(4),
            "uint32" => Kind::Unsigned(4),
            "int64" => Kind::Signed(8),
            "uint64" => Kind::Unsigned(8),
            "float32" => Kind::Single,
            "float64" => Kind::Double,
            "string" => Kind::Text,
            "wstring" => Kind::WideText,
            "time" | "duration" => return Err("its definition is of ROS 1, which is not read".to_owned()),
            "Header" => Kind::Other("std_msgs/Header".to_owned()),
            other if other.contains('/') => Kind::Other(plain(other)),
            other => Kind::Other(format!("{package}/{other}")),
        };
        fields.push(Field { name: name.to_owned(), kind, many });
    }
    Ok(fields)
}

const CUT: &str = "the message ends too soon";

/// Bytes in CDR.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
    /// How many more types may begin.
    steps: usize,
}

impl<'a> Cdr<'a> {
    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count).ok_or(CUT)?;
        let taken = self.bytes.get(self.at..end).ok_or(CUT)?;
        self.at = end;
        Ok(taken)
    }

    fn unsigned(&mut self, size: usize) -> Result<u64, String> {
        self.at = self.at.next_multiple_of(size);
        let bytes = self.take(size)?;
        let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        Ok(if self.big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) })
    }

    fn signed(&mut self, size: usize) -> Result<i64, String> {
        let unused = 64 - 8 * size as u32;
        Ok((self.unsigned(size)? << unused).cast_signed() >> unused)
    }

    /// A text; its length counts the zero at its end.
    fn text(&mut self) -> Result<String, String> {
        let count = self.unsigned(4)? as usize;
        let bytes = self.take(count)?;
        Ok(String::from_utf8_lossy(bytes.strip_suffix(&[0]).unwrap_or(bytes)).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_defaults_bounds_and_nested_types_are_read() {
        let definition = "int32 MODE=3\nint32 OTHER = 4\nstring<=5 label # a comment\nPart[2] parts\nfloat32[<=3] x\n\
            uint8 last 7\n================\nMSG: rig/Part\nbool on\nfloat64 value\n";
        let schema = Schema::new("rig/msg/Whole", definition).unwrap();
        let mut bytes = vec![0, 1, 0, 0];
        let put = |bytes: &mut Vec<u8>, size: usize, value: &[u8]| {
            while !(bytes.len() - 4).is_multiple_of(size) {
                bytes.push(0);
            }
            bytes.extend(value);
        };
        put(&mut bytes, 4, &3u32.to_le_bytes());
        put(&mut bytes, 1, b"ab\0");
        for value in [1.5f64, -2.5] {
            put(&mut bytes, 1, &[1]);
            put(&mut bytes, 8, &value.to_le_bytes());
        }
        put(&mut bytes, 4, &1u32.to_le_bytes());
        put(&mut bytes, 4, &0.5f32.to_le_bytes());
        put(&mut bytes, 1, &[7]);
        let (mut rows, mut budget) = (Rows::default(), Budget::of_file(0));
        schema.decode(&bytes, &mut rows, &mut budget, &mut Stamps::default()).unwrap();
        rows.end_row(&mut budget).unwrap();
        let table = rows.into_table("/t").unwrap();
        assert_eq!(table.column("parts[1].value").unwrap().values, [-2.5]);
        assert_eq!(table.column("x[0]").unwrap().values, [0.5]);
        assert_eq!(table.column("last").unwrap().values, [7.0]);
        for end in 0..bytes.len() {
            let cut = schema.decode(&bytes[..end], &mut Rows::default(), &mut budget, &mut Stamps::default());
            assert!(cut.is_err(), "{end}");
        }
    }
}
