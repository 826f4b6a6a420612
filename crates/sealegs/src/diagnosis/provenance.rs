//! Which files a result came from, by their hashes, and with which version of the program.

use crate::{Error, Result};
use schemars::JsonSchema;
use sealegs_sysid::{Campaign, Run};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::path::Path;

/// The inputs of a result.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Provenance {
    /// The program's version.
    pub version: &'static str,
    /// The model that was started from.
    pub model: String,
    /// Every file that was read.
    pub inputs: Vec<Input>,
}

/// A file that was read, or columns that were given in memory.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Input {
    /// The file's name without its folder; `(memory)` and the run's name for columns.
    pub file: String,
    /// SHA-256 of the file's bytes; of columns that of their names, each ended by a zero byte, and values (IEEE 754,
    /// little-endian), one column after the other in the order of time, inputs, outputs, unknown columns.
    pub sha256: String,
}

impl Input {
    /// Reads and hashes a file.
    ///
    /// # Errors
    ///
    /// If it can no longer be read.
    pub fn of_file(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { file, sha256: hex(Sha256::digest(&bytes).as_slice()) })
    }

    /// The file of a run; its columns, where they are in memory or in a folder (a ROS bag).
    ///
    /// # Errors
    ///
    /// If the file can no longer be read.
    pub fn of_run(run: &Run) -> Result<Self> {
        if !run.is_in_memory() && !run.path.is_dir() {
            return Self::of_file(&run.path);
        }
        let mut hash = Sha256::new();
        let mut column = |name: &str, values: &[f64]| {
            hash.update(name.as_bytes());
            hash.update([0]);
            values.iter().for_each(|v| hash.update(v.to_le_bytes()));
        };
        column("time_s", &run.record.time_s);
        for signal in run.record.inputs.iter().chain(&run.record.outputs).chain(&run.unknown) {
            column(&signal.channel, &signal.values);
        }
        Ok(Self { file: run.path.display().to_string(), sha256: hex(hash.finalize().as_slice()) })
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

impl Provenance {
    /// The files of a campaign, then others (a model file, files of own effects).
    ///
    /// # Errors
    ///
    /// If one of them can no longer be read.
    pub fn of_campaign(campaign: &Campaign, model: String, others: &[&Path]) -> Result<Self> {
        let file = Some(campaign.file.as_path()).filter(|_| !campaign.is_in_memory());
        let file = file.into_iter().map(Input::of_file);
        let runs = campaign.runs.iter().map(Input::of_run);
        let others = others.iter().map(|path| Input::of_file(path));
        let inputs = file.chain(runs).chain(others).collect::<Result<_>>()?;
        Ok(Self { version: env!("CARGO_PKG_VERSION"), model, inputs })
    }
}
