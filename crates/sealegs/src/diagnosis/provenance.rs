//! Which files a result came from, by their hashes, and with which version of the program.

use crate::{Error, Result};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::path::Path;

/// The inputs of a result.
#[derive(Debug, Clone, Serialize)]
pub struct Provenance {
    /// The program's version.
    pub version: &'static str,
    /// The model that was started from.
    pub model: String,
    /// Every file that was read.
    pub inputs: Vec<Input>,
}

/// A file that was read.
#[derive(Debug, Clone, Serialize)]
pub struct Input {
    /// Its name without its folder.
    pub file: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

impl Provenance {
    /// Reads and hashes the files.
    ///
    /// # Errors
    ///
    /// If one of them can no longer be read.
    pub fn new<'a>(model: String, files: impl IntoIterator<Item = &'a Path>) -> Result<Self> {
        let inputs = files
            .into_iter()
            .map(|path| {
                let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
                let hash = Sha256::digest(&bytes);
                Ok(Input {
                    file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                    sha256: hash.iter().map(|b| format!("{b:02x}")).collect(),
                })
            })
            .collect::<Result<_>>()?;
        Ok(Self { version: env!("CARGO_PKG_VERSION"), model, inputs })
    }

    /// The files of a campaign, then others (a model file, files of own effects).
    ///
    /// # Errors
    ///
    /// If one of them can no longer be read.
    pub fn of_campaign(campaign: &sealegs_sysid::Campaign, model: String, others: &[&Path]) -> Result<Self> {
        let runs = campaign.runs.iter().map(|r| r.path.as_path());
        Self::new(model, std::iter::once(campaign.file.as_path()).chain(runs).chain(others.iter().copied()))
    }
}
