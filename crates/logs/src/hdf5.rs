//! HDF5 as h5py and MATLAB (level 7.3, `save -v7.3`) write it: numeric datasets, also inside groups.
//!
//! The decoder is `hdf5-pure`. What a header claims is checked before room is made for it, and the decoder stands behind a
//! fence: it checks much, and nothing promises that it checks all.

use crate::LogError;
use crate::arrays::{Array, into_log};
use crate::budget::{Budget, MOST_INFLATED};
use crate::episodes::stacked;
use crate::fence::fenced;
use crate::table::{Log, TRUTH};
use hdf5_pure::{AttrValue, DType, Dataset, File, Group};
use std::path::Path;

/// Deepest group inside groups that is followed.
const DEEPEST: usize = 32;

/// Most groups and datasets that are looked into.
const MOST_OBJECTS: usize = 20_000;

/// The attribute that says of a MATLAB variable what it is.
const CLASS: &str = "MATLAB_class";

/// The attribute of one without elements: its dataset holds the shape in their place.
const EMPTY: &str = "MATLAB_empty";

/// Reads the bytes of an HDF5 file.
pub(crate) fn parse(path: &Path, bytes: Vec<u8>) -> Result<Log, LogError> {
    let matlab = bytes.starts_with(b"MATLAB ");
    let read = fenced(move || read(bytes, matlab));
    read.unwrap_or_else(|| Err("its structure is broken".to_owned()))
        .map_err(|problem| LogError::whole(path, format!("is no readable HDF5 file: {problem}")))
}

fn read(bytes: Vec<u8>, matlab: bool) -> Result<Log, String> {
    let budget = Budget::of_file(bytes.len());
    let file = File::from_bytes(bytes).map_err(|e| e.to_string())?;
    let mut found = Found { budget, matlab, objects: 0, arrays: Vec::new(), notes: Vec::new() };
    found.group(&file.root(), "", 0)?;
    let format = if matlab { "MATLAB (HDF5)" } else { "HDF5" };
    Ok(into_log(format, stacked(found.arrays), found.notes))
}

/// What has been found so far.
struct Found {
    budget: Budget,
    matlab: bool,
    objects: usize,
    arrays: Vec<Array>,
    notes: Vec<String>,
}

impl Found {
    /// The datasets of a group and of those inside it; `at` is its name with a point behind it.
    fn group(&mut self, group: &Group, at: &str, depth: usize) -> Result<(), String> {
        let of = |e: hdf5_pure::Error| {
            if at.is_empty() { e.to_string() } else { format!("group '{}': {e}", at.trim_end_matches('.')) }
        };
        for name in group.datasets().map_err(of)? {
            self.count()?;
            let full = format!("{at}{name}");
            match group.dataset(&name) {
                Ok(dataset) => self.dataset(&dataset, full)?,
                Err(e) => self.notes.push(format!("'{full}' cannot be read ({}): left out", line(&e))),
            }
        }
        for name in group.groups().map_err(of)? {
            self.count()?;
            // What MATLAB's cells and objects point to.
            if name.starts_with('#') {
                continue;
            }
            let full = format!("{at}{name}");
            match group.group(&name) {
                Ok(inner) if depth < DEEPEST => self.group(&inner, &format!("{full}."), depth + 1)?,
                Ok(_) => self.notes.push(format!("'{full}' is too deep: left out")),
                Err(e) => self.notes.push(format!("'{full}' cannot be read ({}): left out", line(&e))),
            }
        }
        Ok(())
    }

    /// A damaged file may hold a group in itself.
    fn count(&mut self) -> Result<(), String> {
        self.objects += 1;
        if self.objects > MOST_OBJECTS {
            return Err(format!("more than {MOST_OBJECTS} groups and datasets"));
        }
        Ok(())
    }

    fn dataset(&mut self, dataset: &Dataset, name: String) -> Result<(), String> {
        match self.array(dataset, &name) {
            Ok(array) => self.arrays.push(array),
            Err(Left::Out(why)) => self.notes.push(format!("'{name}' {why}: left out")),
            Err(Left::TooLarge(why)) => return Err(format!("'{name}' {why}")),
        }
        Ok(())
    }

    fn array(&mut self, dataset: &Dataset, name: &str) -> Result<Array, Left> {
        let unreadable = |e: hdf5_pure::Error| Left::Out(format!("cannot be read ({})", line(&e)));
        let class = self.class(dataset);
        let truth = match dataset.dtype().map_err(unreadable)? {
            DType::F32 | DType::F64 | DType::I8 | DType::I16 | DType::I32 | DType::I64 => false,
            DType::U8 | DType::U16 | DType::U32 | DType::U64 => class.as_deref() == Some("logical"),
            DType::Enum(names) if is_truth(&names) => true,
            other => return Err(Left::Out(format!("holds {}", kind(&other)))),
        };
        if let Some(class @ ("char" | "cell" | "string" | "function_handle")) = class.as_deref() {
            return Err(Left::Out(format!("is a {class}")));
        }
        let shape: Vec<usize> = dataset
            .shape()
            .map_err(unreadable)?
            .into_iter()
            .map(|n| usize::try_from(n).unwrap_or(usize::MAX))
            .collect();
        let count = shape.iter().try_fold(1usize, |n, &d| n.checked_mul(d));
        let claims = || Left::TooLarge(format!("claims a shape of {shape:?}"));
        let count = count.ok_or_else(claims)?;
        if count == 0 || self.is_empty(dataset) {
            return Err(Left::Out("has no numbers".to_owned()));
        }
        let chunk = dataset.chunk_shape().map_err(unreadable)?.unwrap_or_default();
        let in_chunk = chunk.iter().try_fold(8u64, |n, &d| n.checked_mul(d));
        if in_chunk.is_none_or(|bytes| bytes > MOST_INFLATED) {
            return Err(Left::TooLarge(format!("claims chunks of {chunk:?}")));
        }
        self.budget.take(count).map_err(Left::TooLarge)?;
        let values = dataset.read_f64().map_err(unreadable)?;
        if values.len() != count {
            return Err(Left::Out(format!("claims {count} numbers and has {}", values.len())));
        }
        // MATLAB's first index is the fastest and stands last in the file.
        let shape = if self.matlab { shape.into_iter().rev().collect() } else { shape };
        let holds = truth.then(|| TRUTH.to_owned());
        Ok(Array { name: name.to_owned(), shape, first_fastest: self.matlab, values, holds })
    }

    fn class(&self, dataset: &Dataset) -> Option<String> {
        let attributes = dataset.attrs().ok().filter(|_| self.matlab)?;
        match attributes.get(CLASS)? {
            AttrValue::String(class) | AttrValue::AsciiString(class) => Some(class.clone()),
            AttrValue::StringSized { value, .. } | AttrValue::AsciiStringSized { value, .. } => {
                Some(value.clone())
            }
            _ => None,
        }
    }

    fn is_empty(&self, dataset: &Dataset) -> bool {
        self.matlab && dataset.attrs().is_ok_and(|a| a.contains_key(EMPTY))
    }
}

/// Why a dataset becomes no array.
enum Left {
    /// It is no array of numbers, or not one that can be read: the others can.
    Out(String),
    /// It claims more than a file may hold.
    TooLarge(String),
}

/// Whether the names of an enumeration are those of h5py's truth values.
fn is_truth(names: &[String]) -> bool {
    names.len() == 2 && names.iter().all(|n| ["FALSE", "TRUE"].contains(&n.as_str()))
}

/// What a dataset holds that is no number.
fn kind(of: &DType) -> &'static str {
    match of {
        DType::String | DType::VariableLengthString => "text",
        DType::Compound(_) => "complex numbers or records",
        DType::Enum(_) => "names",
        DType::Array(..) => "arrays in its cells",
        DType::ObjectReference => "references (a cell array, a string or an object of MATLAB)",
        _ => "no plain numbers",
    }
}

/// An error in one line.
fn line(error: &hdf5_pure::Error) -> String {
    error.to_string().replace('\n', " ")
}
