//! Puts the commit into the version, where the sources are a git checkout, and has functions of the same code linked once and
//! relocations packed, where linker and system can.

use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=SEALEGS_COMMIT");
    println!("cargo::rerun-if-changed=build.rs");
    let version = env!("CARGO_PKG_VERSION");
    // A release that is built from an archive can say its commit itself.
    let commit = std::env::var("SEALEGS_COMMIT").ok().filter(|c| !c.is_empty()).or_else(commit);
    let said = commit.map_or_else(|| version.to_owned(), |commit| format!("{version} ({commit})"));
    println!("cargo::rustc-env=SEALEGS_VERSION={said}");
    // A million bytes of the program: generics that differ in their types alone. No address of a function is compared.
    if linked_with(FOLDED).is_some() {
        println!("cargo::rustc-link-arg-bins={FOLDED}");
    }
    // Another million: the addresses that the loader must correct.
    let runs_here = std::env::var("HOST") == std::env::var("TARGET");
    let runs = |program: PathBuf| Command::new(program).status().is_ok_and(|status| status.success());
    if runs_here && linked_with(PACKED).is_some_and(runs) {
        println!("cargo::rustc-link-arg-bins={PACKED}");
    }
}

/// Identical code folding of LLVM's linker, which is Rust's own on Linux; GNU's has none.
const FOLDED: &str = "-Wl,--icf=all";

/// Relocations by ranges of addresses; loaders know them since glibc 2.36 and musl 1.2.4.
const PACKED: &str = "-Wl,-z,pack-relative-relocs";

/// A program of nothing that is linked for Linux with an argument, by the linker and the flags of this build, if they can.
fn linked_with(argument: &str) -> Option<PathBuf> {
    let variable = |name| std::env::var(name).ok();
    let (target, out, rustc) = (variable("TARGET")?, variable("OUT_DIR")?, variable("RUSTC")?);
    if !target.contains("-linux-") {
        return None;
    }
    let (source, program) = (Path::new(&out).join("nothing.rs"), Path::new(&out).join("nothing"));
    std::fs::write(&source, "fn main() {}").ok()?;
    let mut command = Command::new(rustc);
    command
        .args(["--target", &target])
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .arg(format!("-Clink-arg={argument}"));
    command.args(variable("RUSTC_LINKER").map(|linker| format!("-Clinker={linker}")));
    let flags = variable("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    command.args(flags.split('\u{1f}').filter(|flag| !flag.is_empty()));
    command.output().ok().filter(|done| done.status.success()).map(|_| program)
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
