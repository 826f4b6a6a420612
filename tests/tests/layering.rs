//! The arrows between the crates are the design: this reads what Cargo says of them and fails on any other.

use std::collections::BTreeMap;
use std::process::Command;

/// What each crate of the project may depend on within the project.
const ARROWS: [(&str, &[&str]); 6] = [
    ("sealegs-model", &[]),
    ("sealegs-actuator", &["sealegs-model"]),
    ("sealegs-leg", &["sealegs-model", "sealegs-actuator"]),
    ("sealegs-sysid", &["sealegs-model"]),
    ("sealegs-recorder", &["sealegs-model", "sealegs-sysid"]),
    (
        "sealegs-cli",
        &["sealegs-model", "sealegs-actuator", "sealegs-leg", "sealegs-sysid", "sealegs-recorder"],
    ),
];

/// Libraries that only one crate may know.
const OWNED: [(&str, &str); 5] = [
    ("rerun", "sealegs-recorder"),
    ("rapier3d-f64", "sealegs-leg"),
    ("parry3d-f64", "sealegs-leg"),
    ("parquet", "sealegs-sysid"),
    ("anyhow", "sealegs-cli"),
];

/// Direct dependencies (not those of tests) of every crate of the workspace.
fn direct_dependencies() -> BTreeMap<String, Vec<String>> {
    ARROWS
        .iter()
        .map(|(name, _)| {
            let output = Command::new(env!("CARGO"))
                .args([
                    "tree",
                    "--offline",
                    "--edges",
                    "normal",
                    "--depth",
                    "1",
                    "--prefix",
                    "none",
                    "-p",
                    name,
                ])
                .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
                .output()
                .expect("cargo runs");
            let text = String::from_utf8_lossy(&output.stdout);
            assert!(
                output.status.success(),
                "cargo tree -p {name}: {}",
                String::from_utf8_lossy(&output.stderr)
            );
            let names = text.lines().skip(1).filter_map(|line| line.split(' ').next());
            ((*name).to_owned(), names.filter(|n| !n.is_empty()).map(str::to_owned).collect())
        })
        .collect()
}

#[test]
fn crates_depend_only_along_the_arrows() {
    for (name, dependencies) in direct_dependencies() {
        let (_, allowed) = ARROWS.iter().find(|(n, _)| *n == name).expect("listed above");
        for dependency in dependencies.iter().filter(|d| d.starts_with("sealegs-")) {
            assert!(allowed.contains(&dependency.as_str()), "{name} -> {dependency} is a forbidden arrow");
        }
    }
}

#[test]
fn engine_and_recorder_are_known_to_their_crate_only() {
    for (name, dependencies) in direct_dependencies() {
        for (library, owner) in OWNED {
            let knows = dependencies.iter().any(|d| d == library);
            assert!(!knows || name == owner, "{name} -> {library}: only {owner} may know it");
        }
    }
}

#[test]
fn the_trait_crate_needs_serde_and_nothing_else() {
    assert_eq!(direct_dependencies()["sealegs-model"], ["serde"]);
}
