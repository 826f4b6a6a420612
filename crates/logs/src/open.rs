//! Which reader a file needs.

use crate::budget::MOST_INFLATED;
use crate::table::Log;
use crate::{
    LogError, bag, csv_table, hdf5, json, matlab, mcap_log, numpy, parquet_table, rrd, sparse, sqlite, stamps,
};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// A format of log files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text: CSV, or separated by semicolons, tabs or spaces. What is nothing else is taken for it.
    Text,
    /// Parquet.
    Parquet,
    /// MATLAB.
    Matlab,
    /// JSON, JSON Lines.
    Json,
    /// One NumPy array.
    Npy,
    /// An archive of NumPy arrays.
    Npz,
    /// MCAP.
    Mcap,
    /// The SQLite storage of ROS 2 bags.
    Sqlite,
    /// HDF5.
    Hdf5,
    /// A recording of Rerun.
    Rrd,
}

impl Format {
    /// The format of a file by the ending of its name and its first bytes; the bytes decide where they are known.
    #[must_use]
    pub fn of(path: &Path, bytes: &[u8]) -> Self {
        for (magic, format) in MAGIC {
            if bytes.starts_with(magic) {
                return format;
            }
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        ENDINGS.iter().find(|(e, _)| *e == ending).map_or(Self::Text, |&(_, format)| format)
    }

    /// Whether a file of this name has lines, of which the first names the columns.
    #[must_use]
    pub fn has_lines(path: &Path) -> bool {
        Self::of(path, b"") == Self::Text
    }
}

const MAGIC: [(&[u8], Format); 7] = [
    (mcap_log::MAGIC, Format::Mcap),
    (b"PAR1", Format::Parquet),
    (b"MATLAB ", Format::Matlab),
    (b"\x93NUMPY", Format::Npy),
    (matlab::HDF5, Format::Hdf5),
    (sqlite::MAGIC, Format::Sqlite),
    (rrd::MAGIC, Format::Rrd),
];

const ENDINGS: [(&str, Format); 16] = [
    ("parquet", Format::Parquet),
    ("pq", Format::Parquet),
    ("mat", Format::Matlab),
    ("json", Format::Json),
    ("jsonl", Format::Json),
    ("ndjson", Format::Json),
    ("npy", Format::Npy),
    ("npz", Format::Npz),
    ("mcap", Format::Mcap),
    ("db3", Format::Sqlite),
    ("sqlite3", Format::Sqlite),
    ("h5", Format::Hdf5),
    ("hdf5", Format::Hdf5),
    ("rrd", Format::Rrd),
    ("csv", Format::Text),
    ("txt", Format::Text),
];

/// Largest file that is read.
const MOST_BYTES: u64 = 4 << 30;

/// Reads a log file, or the only recording in the folder of a ROS 2 bag.
///
/// # Errors
///
/// [`LogError`] for a file that cannot be read, or whose content is no log of its format. Cells that are no numbers are
/// no error here: see [`crate::Column::fault`].
pub fn read(path: &Path) -> Result<Log, LogError> {
    if path.is_dir() {
        return read(&recording_in(path)?);
    }
    let unreadable = |e: std::io::Error| LogError::whole(path, format!("cannot be read: {e}"));
    let size = std::fs::metadata(path).map_err(unreadable)?.len();
    if size > MOST_BYTES {
        let problem =
            format!("has {size} bytes, more than the {MOST_BYTES} that are read; cut it into several");
        return Err(LogError::whole(path, problem));
    }
    parse(path, std::fs::read(path).map_err(unreadable)?)
}

/// What a file that is packed by gzip begins with.
const GZIP: &[u8] = b"\x1f\x8b\x08";

/// As [`read`] of the bytes of a file; the path says the format, where the bytes do not, and is named in errors.
///
/// # Errors
///
/// As [`read`].
pub fn parse(path: &Path, bytes: Vec<u8>) -> Result<Log, LogError> {
    let (named, bytes) = match bytes.starts_with(GZIP) {
        // `leg.csv.gz` is named `leg.csv` inside.
        true => (path.with_extension(""), unpacked(path, &bytes)?),
        false => (path.to_owned(), bytes),
    };
    let mut log = of_format(Format::of(&named, &bytes), path, bytes)?;
    log.tables.iter_mut().for_each(stamps::made_whole);
    log.tables = log.tables.into_iter().flat_map(sparse::apart).collect();
    Ok(log)
}

/// What gzip has packed.
fn unpacked(path: &Path, bytes: &[u8]) -> Result<Vec<u8>, LogError> {
    let mut inside = Vec::new();
    let read = flate2::read::MultiGzDecoder::new(bytes).take(MOST_INFLATED + 1).read_to_end(&mut inside);
    match read {
        Err(e) => Err(LogError::whole(path, format!("cannot be unpacked: {e}"))),
        Ok(size) if size as u64 > MOST_INFLATED => {
            let problem = format!("holds more than {MOST_INFLATED} bytes; unpack it");
            Err(LogError::whole(path, problem))
        }
        Ok(_) => Ok(inside),
    }
}

fn of_format(format: Format, path: &Path, bytes: Vec<u8>) -> Result<Log, LogError> {
    match format {
        Format::Text => csv_table::parse(path, &bytes),
        Format::Parquet => parquet_table::parse(path, bytes.into()),
        Format::Matlab if matlab::is_hdf5(&bytes) => hdf5::parse(path, bytes),
        Format::Matlab => matlab::parse(path, &bytes),
        Format::Json => json::parse(path, &bytes),
        Format::Npy => numpy::parse_npy(path, &bytes),
        Format::Npz => numpy::parse_npz(path, &bytes),
        Format::Mcap => mcap_log::parse(path, &bytes),
        Format::Sqlite => bag::parse(path, &bytes),
        Format::Hdf5 => hdf5::parse(path, bytes),
        Format::Rrd => rrd::parse(path, &bytes),
    }
}

/// The only recording in a folder.
fn recording_in(folder: &Path) -> Result<PathBuf, LogError> {
    let unreadable = |e: std::io::Error| LogError::whole(folder, format!("cannot be read: {e}"));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if matches!(Format::of(&path, b""), Format::Mcap | Format::Sqlite) {
            found.push(path);
        }
    }
    found.sort();
    match found.len() {
        1 => Ok(found.remove(0)),
        0 => Err(LogError::whole(folder, "is a folder without a recording (.mcap, .db3); name its files")),
        n => Err(LogError::whole(folder, format!("has {n} recordings; name them one by one under files"))),
    }
}
