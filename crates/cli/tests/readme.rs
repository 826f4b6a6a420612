//! Every command that the README shows runs, and the shipped campaigns are named right.

mod program;

use program::{json, sealegs};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn house() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn readme() -> String {
    std::fs::read_to_string(house().join("README.md")).unwrap()
}

/// The commands of the indented lines, without the program's name: those that `cargo run` starts as well.
fn commands(readme: &str) -> Vec<Vec<String>> {
    let ours = |line: &str| -> Option<Vec<String>> {
        let line = line.strip_prefix("    ")?;
        let words = line.strip_prefix("sealegs ").or_else(|| line.strip_prefix("cargo run --release -- "))?;
        Some(words.split_whitespace().map(str::to_owned).collect())
    };
    readme.lines().filter_map(ours).collect()
}

/// The block of TOML that begins with this line.
fn block<'a>(readme: &'a str, first: &str) -> &'a str {
    let from = readme.find(&format!("```toml\n{first}")).unwrap() + "```toml\n".len();
    &readme[from..from + readme[from..].find("```").unwrap()]
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

fn run_in(folder: &Path, words: &[String]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sealegs")).current_dir(folder).args(words).output().unwrap()
}

fn succeeds(done: &Output, what: &str) {
    assert!(done.status.success(), "{what}: {}", String::from_utf8_lossy(&done.stderr));
}

/// A folder with what the README's commands are about: a bench's logs, a user's effect and scenario, and the shipped
/// campaign of a leg.
fn workshop() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (at, readme) = (folder.path(), readme());
    let made = at.join("made");
    succeeds(
        &sealegs(2, &["mystery", "--bench", "locked", "--seed", "3", "-o", made.to_str().unwrap()]),
        "mystery",
    );
    let bench = at.join("knee-bench");
    std::fs::create_dir(&bench).unwrap();
    std::fs::write(bench.join("campaign.toml"), block(&readme, "name = \"knee-bench\"")).unwrap();
    let campaign: toml::Table = std::fs::read_to_string(made.join("campaign.toml")).unwrap().parse().unwrap();
    for (role, name) in [("fit", "fit_chirp.csv"), ("holdout", "check_noise.csv")] {
        let runs = campaign["run"].as_array().unwrap();
        let file = runs.iter().find(|r| r["role"].as_str() == Some(role)).unwrap()["file"].as_str().unwrap();
        std::fs::copy(made.join(file), bench.join(name)).unwrap();
    }
    std::fs::write(at.join("belt-drag.toml"), block(&readme, "id = \"belt-drag\"")).unwrap();
    std::fs::copy(house().join("assets/scenarios/thor-drop.toml"), at.join("my-drop.toml")).unwrap();
    std::fs::copy(house().join("assets/robots/thor-leg.urdf"), at.join("robot.urdf")).unwrap();
    // Of the two that stand there the one without an effect: the other is the tour's, and takes as long.
    copy(&house().join("assets/campaigns/leg-clean"), &at.join("assets/campaigns/leg-drop"));
    folder
}

#[test]
fn every_command_of_the_readme_runs() {
    let folder = workshop();
    let all = commands(&readme());
    assert!(all.len() > 12, "{all:?}");
    for words in all.iter().filter(|words| words[0] != "tour") {
        succeeds(&run_in(folder.path(), words), &words.join(" "));
    }
    assert!(all.iter().any(|words| words == &["tour"]));
}

/// The effects that are hidden in a shipped campaign.
fn hidden(campaign: &str) -> Vec<String> {
    let text = std::fs::read_to_string(house().join("assets/campaigns/answers.toml")).unwrap();
    let answers: toml::Table = text.parse().unwrap();
    answers[campaign]["effects"].as_table().unwrap().keys().cloned().collect()
}

fn said(verdict: &serde_json::Value) -> Vec<String> {
    serde_json::from_value(verdict["effects"].clone()).unwrap()
}

#[test]
fn shipped_campaigns_are_named_right() {
    let folder = tempfile::tempdir().unwrap();
    for campaign in ["leg-clean", "bench-knee"] {
        let data = house().join("assets/campaigns").join(campaign);
        let verdict = folder.path().join(format!("{campaign}.json"));
        let done = sealegs(2, &["diagnose", data.to_str().unwrap(), "--json", verdict.to_str().unwrap()]);
        succeeds(&done, campaign);
        let verdict = json(&verdict);
        assert_eq!(said(&verdict), hidden(campaign), "{campaign}");
        let kind = if hidden(campaign).is_empty() { "adequate" } else { "missing-effect" };
        assert_eq!(verdict["verdict"], kind, "{campaign}");
    }
}

#[test]
fn the_tour_names_what_is_hidden_and_leaves_its_files() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(&run_in(folder.path(), &["tour".to_owned()]), "tour");
    let tour = folder.path().join("tour");
    let verdict = json(&tour.join("3-diagnose.json"));
    assert_eq!(said(&verdict), hidden("leg-drop"));
    let (before, after) = (&verdict["base"]["holdout_error"], &verdict["after"]["holdout_error"]);
    assert!(after.as_f64().unwrap() < 0.5 * before.as_f64().unwrap(), "{before} {after}");
    // A worn sole is felt by the ground: the tour is to show that it matters.
    let peak = |file: &str| json(&tour.join(file))["rows"][1]["ground_force_n"].as_f64().unwrap();
    let (before, after) = (peak("5-impact-before.json"), peak("5-impact-after.json"));
    assert!((after / before - 1.0).abs() > 0.1, "{before} {after}");
    for file in [
        "1-drop.rrd",
        "2-compare.html",
        "3-diagnose.html",
        "3-diagnose.rrd",
        "better.toml",
        "5-impact.html",
        "summary.md",
    ] {
        let size = std::fs::metadata(tour.join(file)).unwrap_or_else(|e| panic!("{file}: {e}")).len();
        assert!(size > 200, "{file}");
    }
}
