//! Which search a line of the matrix was made by: a hash of its sources.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// What a verdict follows from, from the project's root.
const SOURCES: [&str; 4] = [
    "crates/sysid/src/diagnose",
    "crates/sysid/src/fit",
    "crates/actuator/src/plant/observer.rs",
    "crates/actuator/src/bench/observed.rs",
];

/// Digits of the hash that a line carries.
const DIGITS: usize = 12;

/// The present search's stamp: the same for the same sources.
///
/// # Errors
///
/// If a source cannot be read.
pub fn stamp() -> std::io::Result<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    for source in SOURCES {
        collect(&root.join(source), &mut files)?;
    }
    files.sort();
    let mut hash = Sha256::new();
    for file in files {
        hash.update(std::fs::read(file)?);
    }
    let digits: String = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(digits[..DIGITS].to_owned())
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    if !path.is_dir() {
        files.push(path.to_owned());
        return Ok(());
    }
    for entry in std::fs::read_dir(path)? {
        collect(&entry?.path(), files)?;
    }
    Ok(())
}
