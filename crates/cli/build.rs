//! Puts the commit into the version, where the sources are a git checkout.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=SEALEGS_COMMIT");
    println!("cargo::rerun-if-changed=build.rs");
    let version = env!("CARGO_PKG_VERSION");
    // A release that is built from an archive can say its commit itself.
    let commit = std::env::var("SEALEGS_COMMIT").ok().filter(|c| !c.is_empty()).or_else(commit);
    let said = commit.map_or_else(|| version.to_owned(), |commit| format!("{version} ({commit})"));
    println!("cargo::rustc-env=SEALEGS_VERSION={said}");
}

/// The commit of the checkout that these sources are the top of; none in an archive, even inside another checkout.
fn commit() -> Option<String> {
    let house = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().ok()?;
    let top = Path::new(&git(&house, &["rev-parse", "--show-toplevel"])?).canonicalize().ok()?;
    if top != house {
        return None;
    }
    // Every commit and every checkout adds a line to this log.
    let log = git(&house, &["rev-parse", "--git-path", "logs/HEAD"])?;
    println!("cargo::rerun-if-changed={}", house.join(log).display());
    let commit = git(&house, &["rev-parse", "--short=10", "HEAD"])?;
    let day = git(&house, &["show", "-s", "--format=%cs", "HEAD"])?;
    Some(format!("{commit}, {day}"))
}

/// What git says in one line; nothing if there is no git or no checkout.
fn git(folder: &Path, arguments: &[&str]) -> Option<String> {
    let done = Command::new("git").args(arguments).current_dir(folder).output().ok()?;
    let said = String::from_utf8(done.stdout).ok()?;
    Some(said.trim().to_owned()).filter(|s| done.status.success() && !s.is_empty())
}
