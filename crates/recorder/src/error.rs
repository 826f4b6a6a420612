//! What can go wrong while recording or reading back.

use std::path::PathBuf;

/// Why a recording could not be written, shown or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// The scene or a frame does not fit together: the caller's mistake, named.
    #[error("{what}: {expected} expected, {found} given")]
    Mismatch {
        /// What does not fit, for example `scalars at 0.1 s`.
        what: String,
        /// The number that the scene asks for.
        expected: usize,
        /// The number that was given.
        found: usize,
    },
    /// Two things of the scene would be written to the same place.
    #[error("'{path}' is named twice in the scene")]
    Duplicate {
        /// The entity's path.
        path: String,
    },
    /// The time of a frame does not come after the one before.
    #[error("a frame at {time_s} s after one at {previous_s} s: times must increase")]
    TimeOrder {
        /// The time that was given, s.
        time_s: f64,
        /// The time before it, s.
        previous_s: f64,
    },
    /// A file could not be written or read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no Rerun recording, or its bytes are damaged.
    #[error("{}: not a readable recording: {what}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What was wrong.
        what: String,
    },
    /// The recorder refused what it was given.
    #[error("recording: {what}")]
    Recorder {
        /// What it said.
        what: String,
    },
    /// No viewer is installed, or it cannot be reached.
    #[error(
        "no Rerun viewer: {what}; get one with `pip install rerun-sdk=={version}`, or record to a file with --rrd"
    )]
    NoViewer {
        /// What was tried.
        what: String,
        /// The viewer's version that fits.
        version: &'static str,
    },
}
