//! A mystery on a whole leg: what is sealed is what is in the files.

use sealegs::campaign_model;
use sealegs::model::Model;
use sealegs::mystery::answer::Answer;
use sealegs::sysid::{Campaign, Data};
use std::path::Path;
use std::process::{Command, Output};

fn sealegs(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sealegs")).args(arguments).output().unwrap()
}

fn good(arguments: &[&str]) -> String {
    let done = sealegs(arguments);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(done.stderr.is_empty(), "quiet in a pipe: {}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    all.sort();
    all
}

/// What the diagnosis could at best say.
fn verdict(campaign: &str, effects: &[&str], tied: &[&[&str]]) -> String {
    let base = serde_json::json!({ "holdout_error": 9.0, "parameters": [] });
    serde_json::json!({ "campaign": campaign, "verdict": "missing-effect", "effects": effects,
        "indistinguishable": tied, "base": base, "after": null })
    .to_string()
}

#[test]
fn an_easy_leg_is_read_shows_its_effect_and_is_explained_by_its_answer() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("leg");
    let said = good(&["mystery", "--bench", "leg", "--seed", "1", "-o", text(&place)]);
    assert!(said.contains("4 runs on the leg bench"), "{said}");

    let answer = Answer::opened(&std::fs::read_to_string(place.join("answer.sealed")).unwrap()).unwrap();
    assert_eq!((answer.bench.as_str(), answer.effects.len()), ("leg", 1));
    let hidden = answer.effects[0].id.as_str();
    assert!(hidden.contains('/'), "{hidden} has no place");
    for file in names(&place) {
        let open = std::fs::read_to_string(place.join(&file)).unwrap();
        let (_, effect) = hidden.split_once('/').unwrap();
        assert!(!open.contains(effect), "{file} gives {hidden} away");
    }

    let mut campaign = Campaign::read(&place).unwrap();
    let base = campaign_model::of_campaign(&mut campaign, None).unwrap();
    let data = Data::new(&campaign, None, base.as_ref()).unwrap();
    let truth = |name: &str| {
        let of_base = answer.parameters.iter().find(|p| p.name == name);
        let symbol = name.strip_prefix(hidden).and_then(|rest| rest.strip_prefix('.'));
        let of_effect = answer.effects[0].parameters.iter().find(|p| Some(p.name.as_str()) == symbol);
        of_base.or(of_effect).unwrap_or_else(|| panic!("{name} is not in the answer")).value
    };
    let values = |model: &dyn Model| model.parameters().iter().map(|p| truth(&p.name)).collect::<Vec<f64>>();
    let own = values(base.as_ref());
    let without = data.evaluate(base.as_ref(), &own).unwrap().rms;
    let seen = data.excitation(&data.predict(base.as_ref(), &own).unwrap());
    let full = base.with_effect(hidden, &seen).unwrap();
    let with = data.evaluate(full.as_ref(), &values(full.as_ref())).unwrap().rms;
    println!("{hidden}: {without:.2} without, {with:.4} with");
    assert!(without > 3.0, "{hidden}: {without}");
    assert!((with - 1.0).abs() < 0.04, "{hidden}: {with}");
    // Where a fit may look for it, and not only there where it begins.
    for p in full.parameters() {
        assert!((p.min..=p.max).contains(&truth(&p.name)), "{}: {} in {p:?}", p.name, truth(&p.name));
    }
}

#[test]
fn a_leg_of_a_seed_is_the_same_to_the_last_bit_and_its_places_count() {
    let folder = tempfile::tempdir().unwrap();
    let [first, again] = ["first", "again"].map(|name| folder.path().join(name));
    for place in [&first, &again] {
        good(&["mystery", "--bench", "leg", "--seed", "2", "-o", text(place)]);
    }
    for file in names(&first) {
        let [a, b] = [&first, &again].map(|place| std::fs::read(place.join(&file)).unwrap());
        assert!(a == b, "{file}");
    }
    let answer = good(&["reveal", text(&first)]);
    assert!(answer.contains("estimated to first order") && answer.contains("knee/stiffness"), "{answer}");
    let hidden = answer.lines().find_map(|l| l.strip_prefix("Hidden: ")).unwrap().trim_end_matches('.');
    let (_, effect) = hidden.split_once('/').unwrap();
    let elsewhere = format!("somewhere/{effect}");
    let file = folder.path().join("verdict.json");
    let score = |effects: &[&str], tied: &[&[&str]]| {
        std::fs::write(&file, verdict("mystery-leg-2", effects, tied)).unwrap();
        good(&["reveal", text(&first), "--verdict", text(&file)])
    };
    assert!(score(&[hidden], &[]).contains("Score: right"));
    assert!(score(&[&elsewhere], &[&[hidden]]).contains("Score: tied"));
    assert!(score(&[&elsewhere, hidden], &[]).contains("Score: part"));
    // The right law at another place is another effect.
    assert!(score(&[&elsewhere], &[]).contains("Score: wrong"));
    let done = sealegs(&["mystery", "--bench", "leg", "-o", text(&first)]);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{error}");
    assert!(error.contains("is there already") && error.trim_end().lines().count() == 1, "{error}");
}
