//! MATLAB's MAT-files of level 5 (`save -v6` and `-v7`): numeric arrays, also inside structures.
//!
//! The layout is that of "MAT-File Format" (The MathWorks, 2024), chapter 1. The reader is our own because the crates
//! that there are leave structures out or make room for what a header claims before they look for it. Level 7.3 is HDF5: see
//! `hdf5.rs`.

use crate::LogError;
use crate::arrays::{Array, into_log};
use crate::budget::{Budget, MOST_INFLATED};
use crate::encoding::of_utf16;
use crate::table::{IN_UNIT, Log, TRUTH};
use std::io::Read;
use std::path::Path;

/// Bytes before the first element.
const HEADER: usize = 128;

/// Deepest structure inside structures that is followed.
const DEEPEST: usize = 32;

/// Most variables and fields that are looked into.
const MOST_ARRAYS: usize = 20_000;

/// Fields of a structure that name its numbers, and those that hold them: signals as dSPACE (`Name`, `Data`) and Simulink
/// (`label`, `values`) write them.
const LABELS: [&str; 2] = ["Name", "label"];
const LABELLED: [&str; 2] = ["Data", "values"];

/// The field of dSPACE that holds the unit of those numbers.
const UNIT: &str = "Unit";

/// Reads the bytes of a MAT-file.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    if bytes.is_empty() {
        return Err(LogError::whole(path, "is empty"));
    }
    let big = match bytes.get(HEADER - 4..HEADER) {
        Some([_, _, b'I', b'M']) => false,
        Some([_, _, b'M', b'I']) => true,
        _ => {
            let problem = "is no MAT-file of level 5 (MATLAB: save('-v7', …)): its header is broken";
            return Err(LogError::whole(path, problem));
        }
    };
    let mut file = File {
        budget: Budget::of_file(bytes.len()),
        inflatable: MOST_INFLATED.max(bytes.len() as u64),
        arrays: Vec::new(),
        notes: Vec::new(),
    };
    let mut rest = Part { bytes: &bytes[HEADER..], big };
    let mut count = 0;
    while !rest.bytes.is_empty() {
        count += 1;
        let in_variable = |problem: String| {
            let name = format!("variable {count}");
            LogError::whole(path, format!("is no readable MAT-file: {problem} in {name}"))
        };
        // Zeros after the last variable are padding.
        if rest.bytes.iter().all(|&b| b == 0) {
            break;
        }
        let (kind, data) = rest.element().map_err(in_variable)?;
        if kind == COMPRESSED {
            let inflated = file.inflate(data).map_err(in_variable)?;
            let (kind, data) = Part { bytes: &inflated, big }.element().map_err(in_variable)?;
            file.variable(kind, data).map_err(in_variable)?;
        } else {
            file.variable(kind, data).map_err(in_variable)?;
        }
    }
    Ok(into_log("MATLAB", file.arrays, file.notes))
}

/// What an HDF5 file begins with.
pub(crate) const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Whether a MAT-file is of level 7.3: HDF5 behind MATLAB's own header.
pub(crate) fn is_hdf5(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MATLAB 7.3") || bytes.get(512..).is_some_and(|b| b.starts_with(HDF5))
}

/// The element type of a compressed element, and of a matrix.
const COMPRESSED: u32 = 15;
const MATRIX: u32 = 14;

/// Bytes that hold elements, with the order of theirs.
#[derive(Clone, Copy)]
struct Part<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl<'a> Part<'a> {
    fn u32(self, at: usize) -> Option<u32> {
        let four: [u8; 4] = self.bytes.get(at..at + 4)?.try_into().ok()?;
        Some(if self.big { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
    }

    /// Takes one element: its type and its bytes.
    fn element(&mut self) -> Result<(u32, Part<'a>), String> {
        let cut = || "the file ends".to_owned();
        let first = self.u32(0).ok_or_else(cut)?;
        let (kind, from, length, whole): (u32, usize, usize, usize) = if first >> 16 != 0 {
            // Four bytes or less stand in the tag itself.
            (first & 0xFFFF, 4, (first >> 16) as usize, 8)
        } else {
            let length = self.u32(4).ok_or_else(cut)? as usize;
            let padded = if first == COMPRESSED {
                length
            } else {
                length.checked_next_multiple_of(8).ok_or_else(cut)?
            };
            (first, 8, length, padded.saturating_add(8))
        };
        let bytes = self.bytes.get(from..from.saturating_add(length)).ok_or_else(cut)?;
        // The padding of the last element may be missing.
        self.bytes = self.bytes.get(whole..).unwrap_or_default();
        Ok((kind, Part { bytes, big: self.big }))
    }

    /// Takes an element of 32-bit integers.
    fn integers(&mut self) -> Result<Vec<u32>, String> {
        let (_, data) = self.element()?;
        Ok((0..data.bytes.len() / 4).filter_map(|i| data.u32(4 * i)).collect())
    }
}

/// A file that is being read.
struct File {
    budget: Budget,
    inflatable: u64,
    arrays: Vec<Array>,
    notes: Vec<String>,
}

impl File {
    /// Unpacks a compressed element.
    fn inflate(&mut self, data: Part) -> Result<Vec<u8>, String> {
        let mut inflated = Vec::new();
        // A damaged checksum at the end is found only once everything is there.
        flate2::read::ZlibDecoder::new(data.bytes)
            .take(self.inflatable + 1)
            .read_to_end(&mut inflated)
            .map_err(|e| format!("packed data cannot be unpacked ({e})"))?;
        if inflated.len() as u64 > self.inflatable {
            return Err(format!("packed data become more than {} bytes", self.inflatable));
        }
        Ok(inflated)
    }

    fn variable(&mut self, kind: u32, data: Part) -> Result<(), String> {
        if kind != MATRIX {
            self.notes.push(format!("an element of type {kind} is no array: left out"));
            return Ok(());
        }
        self.matrix(data, None, 0)
    }

    /// One array: a variable, or a field of this name.
    fn matrix(&mut self, mut data: Part, field: Option<&str>, depth: usize) -> Result<(), String> {
        // An empty field is an array without content.
        if data.bytes.is_empty() {
            return Ok(());
        }
        let flags = *data.integers()?.first().ok_or("an array has no class")?;
        let (class, complex, logical) = (flags & 0xFF, flags & 0x800 != 0, flags & 0x200 != 0);
        // Opaque objects (tables, time series, strings) have their name where other arrays have their shape.
        if class == 17 {
            let (_, name) = data.element()?;
            let name = field.map_or_else(|| text(name.bytes), str::to_owned);
            self.notes.push(format!("'{name}' is {}: left out", kind_of(class)));
            return Ok(());
        }
        let shape: Vec<usize> = data.integers()?.into_iter().map(|n| n as usize).collect();
        let (_, own_name) = data.element()?;
        let name = field.map_or_else(|| text(own_name.bytes), str::to_owned);
        let count = shape.iter().try_fold(1usize, |n, &d| n.checked_mul(d));
        let count = count.ok_or_else(|| format!("'{name}' claims a shape of {shape:?}"))?;
        if self.arrays.len() + self.notes.len() > MOST_ARRAYS {
            return Err(format!("more than {MOST_ARRAYS} arrays"));
        }
        match class {
            6..=15 if complex => self.notes.push(format!("'{name}' is complex: left out")),
            6..=15 => {
                let values = self.numbers(&mut data, count, &name)?;
                let holds = logical.then(|| TRUTH.to_owned());
                self.arrays.push(Array { name, shape, first_fastest: true, values, holds });
            }
            2 | 3 if depth < DEEPEST => {
                if class == 3 {
                    data.element()?;
                }
                let longest = data.integers()?.first().copied().unwrap_or(0) as usize;
                let (_, names) = data.element()?;
                if longest == 0 {
                    return Ok(());
                }
                let fields: Vec<String> = names.bytes.chunks(longest).map(text).collect();
                for i in 0..count {
                    if data.bytes.is_empty() {
                        break;
                    }
                    let at = if count == 1 { String::new() } else { format!("({})", i + 1) };
                    let (mut label, mut unit, mut labelled) = (None, None, None);
                    for part in &fields {
                        let (kind, inner) = data.element()?;
                        if kind != MATRIX {
                            continue;
                        }
                        if LABELS.contains(&part.as_str())
                            && let Some(own) = label_of(inner)
                        {
                            label = Some(own);
                            continue;
                        }
                        if part == UNIT
                            && let Some(own) = label_of(inner)
                        {
                            unit = Some(own);
                            continue;
                        }
                        let before = self.arrays.len();
                        self.matrix(inner, Some(&format!("{name}{at}.{part}")), depth + 1)?;
                        if LABELLED.contains(&part.as_str()) && self.arrays.len() == before + 1 {
                            labelled = Some(before);
                        }
                    }
                    if let (Some(unit), Some(array)) = (unit, labelled) {
                        self.arrays[array].holds = Some(format!("{IN_UNIT}{unit}"));
                    }
                    if let (Some(label), Some(array)) = (label, labelled)
                        && self.arrays.iter().all(|other| other.name != label)
                    {
                        self.arrays[array].name = label;
                    }
                }
            }
            _ => self.notes.push(format!("'{name}' is {}: left out", kind_of(class))),
        }
        Ok(())
    }

    /// The numbers of an array's real part.
    fn numbers(&mut self, data: &mut Part, count: usize, name: &str) -> Result<Vec<f64>, String> {
        let (kind, part) = data.element()?;
        let (size, number): (usize, fn(u64) -> f64) = match kind {
            1 => (1, |b| f64::from((b as u8).cast_signed())),
            2 => (1, |b| b as f64),
            3 => (2, |b| f64::from((b as u16).cast_signed())),
            4 | 6 | 13 => (
                if kind == 4 {
                    2
                } else if kind == 6 {
                    4
                } else {
                    8
                },
                |b| b as f64,
            ),
            5 => (4, |b| f64::from((b as u32).cast_signed())),
            7 => (4, |b| f64::from(f32::from_bits(b as u32))),
            9 => (8, f64::from_bits),
            12 => (8, |b| b.cast_signed() as f64),
            _ => return Err(format!("'{name}' has numbers of the unknown type {kind}")),
        };
        if part.bytes.len() / size != count {
            let has = part.bytes.len() / size;
            return Err(format!("'{name}' claims {count} numbers and has {has}"));
        }
        self.budget.take(count)?;
        let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        let bits = |bytes: &[u8]| {
            if part.big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) }
        };
        Ok(part.bytes.chunks_exact(size).map(|bytes| number(bits(bytes))).collect())
    }
}

/// The characters of an array of text that is not empty.
fn label_of(mut data: Part) -> Option<String> {
    let class = data.integers().ok()?.first()? & 0xFF;
    // Its shape and its name.
    data.element().ok()?;
    data.element().ok()?;
    let (kind, characters) = data.element().ok()?;
    let label = match (class, kind) {
        (4, 1 | 2 | 16) => String::from_utf8_lossy(characters.bytes).into_owned(),
        (4, 4 | 17) => of_utf16(characters.bytes, characters.big),
        _ => return None,
    };
    Some(label.trim().to_owned()).filter(|label| !label.is_empty())
}

/// A name, without the zeros that fill it up.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// What arrays are that hold no numbers.
fn kind_of(class: u32) -> &'static str {
    match class {
        1 => "a cell array",
        2 | 3 => "a structure too deep inside others",
        4 => "text",
        5 => "a sparse matrix",
        16 => "a function",
        17 => "an object (a table or a time series; save its numbers as arrays)",
        _ => "of an unknown class",
    }
}
