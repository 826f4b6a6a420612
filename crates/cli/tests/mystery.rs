//! `sealegs mystery` and `sealegs reveal` as a user types them.

use std::path::Path;
use std::process::{Command, Output};

fn sealegs(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sealegs")).args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn good(arguments: &[&str]) -> String {
    let done = sealegs(arguments);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(done.stderr.is_empty(), "quiet in a pipe: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

fn refused(arguments: &[&str], said: &str) {
    let done = sealegs(arguments);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.contains(said) && error.trim_end().lines().count() == 1, "{arguments:?}: {error}");
}

fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// A verdict in the data contract's form.
fn verdict(campaign: &str, kind: &str, effects: &[&str], tied: &[&[&str]]) -> String {
    serde_json::json!({
        "campaign": campaign,
        "verdict": kind,
        "effects": effects,
        "indistinguishable": tied,
        "base": { "holdout_error": 9.0, "parameters": [ { "name": "stiffness", "value": 6.5e5, "std": 10.0 } ] },
        "after": null,
    })
    .to_string()
}

#[test]
fn a_mystery_is_whole_the_same_for_its_seed_and_can_be_checked_and_revealed() {
    let folder = tempfile::tempdir().unwrap();
    let (first, again) = (folder.path().join("first"), folder.path().join("again"));
    for place in [&first, &again] {
        let said = good(&["mystery", "--bench", "locked", "--seed", "4", "-o", text(place)]);
        assert!(said.contains("sealegs reveal"), "{said}");
    }
    assert_eq!(entries(folder.path()), ["again", "first"]);
    let files = entries(&first);
    assert_eq!(
        files,
        [
            "answer.sealed",
            "campaign.toml",
            "check_low.csv",
            "check_noise.csv",
            "fit_chirp.csv",
            "fit_steps.csv"
        ]
    );
    for file in &files {
        assert!(
            std::fs::read(first.join(file)).unwrap() == std::fs::read(again.join(file)).unwrap(),
            "{file}"
        );
    }
    good(&["check", text(&first)]);

    let answer = good(&["reveal", text(&first)]);
    let hidden = answer.lines().find_map(|l| l.strip_prefix("Hidden: ")).unwrap().trim_end_matches('.');
    assert!(answer.contains("force_constant") && answer.contains(&format!("{hidden}.")), "{answer}");
    for file in &files {
        let open = String::from_utf8_lossy(&std::fs::read(first.join(file)).unwrap()).contains(hidden);
        assert!(!open, "{file} gives it away");
    }

    let file = folder.path().join("verdict.json");
    let score = |json: String| {
        std::fs::write(&file, json).unwrap();
        good(&["reveal", text(&first), "--verdict", text(&file)])
    };
    let name = "mystery-locked-4";
    let right = score(verdict(name, "missing-effect", &[hidden], &[]));
    assert!(right.contains("Score: right") && right.contains("650000"), "{right}");
    assert!(score(verdict(name, "missing-effect", &["x"], &[&[hidden]])).contains("Score: tied"));
    assert!(score(verdict(name, "missing-effect", &["x", hidden], &[])).contains("Score: part"));
    assert!(score(verdict(name, "missing-effect", &["x"], &[])).contains("Score: wrong"));
    assert!(score(verdict(name, "adequate", &[], &[])).contains("Score: missed"));

    std::fs::write(&file, verdict("another", "adequate", &[], &[])).unwrap();
    refused(&["reveal", text(&first), "--verdict", text(&file)], "a verdict on 'another'");
    std::fs::write(&file, "{}").unwrap();
    refused(&["reveal", text(&first), "--verdict", text(&file)], "verdict.json");
    let sealed = first.join("answer.sealed");
    let whole = std::fs::read_to_string(&sealed).unwrap();
    std::fs::write(&sealed, &whole[..whole.len() / 2]).unwrap();
    refused(&["reveal", text(&first)], "answer.sealed");
}

#[test]
fn a_rough_mystery_is_rough_and_its_answer_says_how() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("rough");
    good(&["mystery", "--bench", "locked", "--level", "rough", "--seed", "3", "-o", text(&place)]);
    let answer = good(&["reveal", text(&place)]);
    assert!(answer.contains("The log is rough: "), "{answer}");
    good(&["check", text(&place)]);
    let leg = folder.path().join("leg");
    refused(&["mystery", "--bench", "leg", "--level", "rough", "-o", text(&leg)], "not of a leg");
    assert_eq!(entries(folder.path()), ["rough"]);
}

#[test]
fn bad_input_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("there");
    std::fs::create_dir(&place).unwrap();
    refused(&["mystery", "-o", text(&place)], "is there already");
    std::fs::write(folder.path().join("file"), "").unwrap();
    refused(&["mystery", "-o", text(&folder.path().join("file/place"))], "cannot be made");
    refused(&["reveal", text(&place)], "answer.sealed");
    assert_eq!(entries(folder.path()), ["file", "there"]);
}
