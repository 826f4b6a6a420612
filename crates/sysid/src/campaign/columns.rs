//! `[columns]`, `[run.columns]` and `files` of a campaign file: from the text to column maps.

use crate::Error;
use sealegs_logs::columns::{ColumnMap, Said};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// `[columns]` as it stands in the file.
pub(super) type RawColumns = BTreeMap<String, Spanned<Said>>;

/// A column map, and the line of the campaign file that says it.
#[derive(Debug, Clone)]
pub(super) struct MappedColumn {
    pub map: ColumnMap,
    pub line: u64,
}

/// One of the files of a run: its name alone, or with what is added to its clock.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "a file's name, or { file = \"name\", offset_s = seconds }")]
pub(super) enum RawFile {
    Name(String),
    Shifted {
        file: String,
        #[serde(default)]
        offset_s: f64,
    },
}

/// A file of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FileEntry {
    pub file: String,
    /// What is added to its clock, s.
    pub offset_s: f64,
}

impl FileEntry {
    /// A file with its own clock.
    pub fn plain(file: &str) -> Self {
        Self { file: file.to_owned(), offset_s: 0.0 }
    }
}

/// Checks the maps, in the order in which they stand in the file.
pub(super) fn mapped(
    path: &Path,
    raw: &RawColumns,
    line: &dyn Fn(std::ops::Range<usize>) -> u64,
) -> Result<Vec<MappedColumn>, Error> {
    let mut ordered: Vec<_> = raw.iter().collect();
    ordered.sort_by_key(|(_, said)| said.span().start);
    ordered
        .into_iter()
        .map(|(source, said)| {
            let line = line(said.span());
            ColumnMap::new(source, &said.get_ref().0)
                .map(|map| MappedColumn { map, line })
                .map_err(|problem| Error::bad(path, line, Some(&format!("columns.{source}")), problem))
        })
        .collect()
}

/// The campaign's maps with a run's own in the place of those of the same source or channel.
pub(super) fn with_own(shared: &[MappedColumn], own: &[MappedColumn]) -> Vec<MappedColumn> {
    let replaced =
        |map: &ColumnMap| own.iter().any(|o| o.map.source == map.source || o.map.target == map.target);
    own.iter().chain(shared.iter().filter(|m| !replaced(&m.map))).cloned().collect()
}

/// The files of a run, by `file` or `files`.
pub(super) fn files(raw: &Spanned<Vec<RawFile>>) -> Result<Vec<FileEntry>, &'static str> {
    let files: Vec<FileEntry> = raw
        .get_ref()
        .iter()
        .map(|f| match f {
            RawFile::Name(file) => FileEntry::plain(file),
            RawFile::Shifted { file, offset_s } => FileEntry { file: file.clone(), offset_s: *offset_s },
        })
        .collect();
    if files.is_empty() {
        return Err("is empty; a run has at least one file");
    }
    if files.iter().any(|f| !f.offset_s.is_finite()) {
        return Err("has an offset_s that is not finite");
    }
    if (1..files.len()).any(|i| files[..i].iter().any(|f| f.file == files[i].file)) {
        return Err("names a file twice");
    }
    Ok(files)
}
