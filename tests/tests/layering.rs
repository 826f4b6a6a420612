//! The arrows between the crates are the design: this reads what Cargo says of them and fails on any other.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// What each crate of the project may depend on within the project.
const ARROWS: [(&str, &[&str]); 12] = [
    ("sealegs-model", &[]),
    ("sealegs-actuator", &["sealegs-model"]),
    // Parameters, geometry, scenarios and command profiles only: its integration is its own.
    ("sealegs-reference", &["sealegs-model", "sealegs-actuator", "sealegs-leg"]),
    ("sealegs-leg", &["sealegs-model", "sealegs-actuator"]),
    ("sealegs-logs", &["sealegs-model"]),
    ("sealegs-sysid", &["sealegs-model", "sealegs-logs"]),
    ("sealegs-recorder", &["sealegs-model", "sealegs-sysid"]),
    ("sealegs-export", &["sealegs-model", "sealegs-actuator", "sealegs-leg"]),
    ("sealegs-reproduce", &["sealegs-model", "sealegs-actuator", "sealegs-sysid", "sealegs-recorder"]),
    (
        "sealegs",
        &[
            "sealegs-model",
            "sealegs-logs",
            "sealegs-actuator",
            "sealegs-reference",
            "sealegs-leg",
            "sealegs-sysid",
            "sealegs-recorder",
        ],
    ),
    (
        "sealegs-cli",
        &[
            "sealegs",
            "sealegs-model",
            "sealegs-actuator",
            "sealegs-reference",
            "sealegs-leg",
            "sealegs-sysid",
            "sealegs-recorder",
            "sealegs-export",
            "sealegs-reproduce",
        ],
    ),
    ("sealegs-py", &["sealegs", "sealegs-cli"]),
];

/// Libraries that only one crate may know; recordings of Rerun are read among the logs, too.
const OWNED: [(&str, &str); 13] = [
    ("rerun", "sealegs-recorder"),
    ("re_sdk_types", "sealegs-recorder"),
    ("re_chunk", "sealegs-recorder"),
    ("re_chunk", "sealegs-logs"),
    ("re_log_types", "sealegs-recorder"),
    ("re_log_encoding", "sealegs-recorder"),
    ("re_log_encoding", "sealegs-logs"),
    ("rapier3d-f64", "sealegs-leg"),
    ("parry3d-f64", "sealegs-leg"),
    ("parquet", "sealegs-logs"),
    ("mcap", "sealegs-logs"),
    ("anyhow", "sealegs-cli"),
    ("pyo3", "sealegs-py"),
];

/// What `cargo tree` prints with these arguments, one package a line.
fn tree(arguments: &[&str]) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--prefix", "none"])
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .expect("cargo runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo tree {}: {said}", arguments.join(" "));
    text.lines().filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

/// Direct dependencies (not those of tests) of every crate of the workspace.
fn direct_dependencies() -> BTreeMap<String, Vec<String>> {
    ARROWS
        .iter()
        .map(|(name, _)| {
            let lines = tree(&["--edges", "normal", "--depth", "1", "-p", name]);
            let names = lines.iter().skip(1).filter_map(|line| line.split(' ').next());
            ((*name).to_owned(), names.map(str::to_owned).collect())
        })
        .collect()
}

#[test]
fn crates_depend_only_along_the_arrows() {
    for (name, dependencies) in direct_dependencies() {
        let (_, allowed) = ARROWS.iter().find(|(n, _)| *n == name).expect("listed above");
        for dependency in dependencies.iter().filter(|d| d.starts_with("sealegs")) {
            assert!(allowed.contains(&dependency.as_str()), "{name} -> {dependency} is a forbidden arrow");
        }
    }
}

#[test]
fn engine_and_recorder_are_known_to_their_crate_only() {
    for (name, dependencies) in direct_dependencies() {
        for (library, owner) in OWNED {
            let knows = dependencies.iter().any(|d| d == library);
            let may = OWNED.contains(&(library, name.as_str()));
            assert!(!knows || may, "{name} -> {library}: only {owner} may know it");
        }
    }
}

#[test]
fn program_and_wheel_take_over_what_the_tests_have_compiled() {
    let compiled = |arguments: &[&str]| -> BTreeSet<String> {
        let lines = tree(&[arguments, &["--format", "{p} [{f}]"]].concat());
        lines.iter().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
    };
    let all = compiled(&["--workspace"]);
    for alone in ["sealegs-cli", "sealegs-py"] {
        let alone_needs = compiled(&["-p", alone, "--edges", "normal,build"]);
        let again: Vec<&String> = alone_needs.difference(&all).collect();
        assert!(again.is_empty(), "crates/cli/Cargo.toml lacks features of the workspace: {again:#?}");
    }
}

/// Modules of the actuator in which its motion is computed.
const INTEGRATION: [&str; 3] = ["plant", "response", "effect"];

/// All that the independent simulator may take from the leg: nothing in which a motion is computed.
const FROM_LEG: [&str; 3] = ["robot", "scenario", "LegError"];

#[test]
fn the_independent_simulator_takes_no_integration_from_the_product() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/reference/src"));
    let mut folders = vec![folder.to_owned()];
    let mut seen = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("sources") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            seen += 1;
            let text = std::fs::read_to_string(&path).expect("a source");
            for module in INTEGRATION {
                let taken = text.contains(&format!("sealegs_actuator::{module}"));
                assert!(!taken, "{} takes from the actuator's {module}", path.display());
            }
            assert!(!text.contains("BenchModel"), "{} takes the actuator's own bench", path.display());
            for (at, _) in text.match_indices("sealegs_leg::") {
                let what = &text[at + "sealegs_leg::".len()..];
                let allowed = FROM_LEG.iter().any(|name| what.starts_with(name));
                let name = what.lines().next().unwrap_or_default();
                assert!(allowed, "{} takes from the leg's {name}", path.display());
            }
        }
    }
    assert!(seen > 5, "{seen} sources");
}

#[test]
fn the_trait_crate_needs_serde_and_nothing_else() {
    assert_eq!(direct_dependencies()["sealegs-model"], ["serde"]);
}
