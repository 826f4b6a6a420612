//! `sealegs effects` and what helps around the verbs: the catalogue, files of the wrong kind, version, completions, man pages.

mod program;

use program::{json, sealegs};
use std::path::Path;
use std::process::Output;

fn said(done: &Output) -> String {
    String::from_utf8(done.stdout.clone()).unwrap()
}

fn refused(arguments: &[&str]) -> String {
    let done = sealegs(1, arguments);
    let message = String::from_utf8(done.stderr.clone()).unwrap();
    assert_eq!(done.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    message
}

fn asset(file: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets").join(file).display().to_string()
}

#[test]
fn the_table_names_every_effect_with_its_parameters() {
    let table = said(&sealegs(1, &["effects"]));
    for effect in sealegs::catalogue::entries().unwrap() {
        let card = effect.card();
        assert!(table.contains(&card.id) && table.contains(&card.summary), "{}", card.id);
        assert!(card.parameters.iter().all(|p| table.contains(&p.name)), "{}", card.id);
    }
    assert!(table.contains("stiffness_n_m (N/m)"), "{table}");
    let listed = said(&sealegs(1, &["list"]));
    assert!(listed.contains("backlash") && listed.contains("leg-drop"), "{listed}");
}

#[test]
fn a_card_has_its_law_its_neighbours_and_its_signature() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("card.json");
    let done = sealegs(1, &["effects", "knee/backlash", "--json", file.to_str().unwrap()]);
    let card = said(&done);
    for word in
        ["law", "told apart", "usual cure", "reference", "gap_m (m)", "Force over deflection", "Residual of"]
    {
        assert!(card.contains(word), "no '{word}' in\n{card}");
    }
    // Drawn by dots, and not an empty frame.
    let dots = card.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
    assert!(dots > 60, "{dots} characters with dots in\n{card}");
    let sheet = json(&file);
    assert_eq!(sheet["id"], "backlash");
    // Within the gap the spring has no force, beyond it the slope is the spring's.
    let gap = sheet["signature"]["values"][0].as_f64().unwrap();
    let law: Vec<(f64, f64)> =
        serde_json::from_value(sheet["signature"]["law"]["curves"][1]["points"].clone()).unwrap();
    assert!(law.iter().filter(|(x, _)| x.abs() < 0.49 * gap).all(|(_, force)| *force == 0.0));
    assert!(law.iter().any(|(x, force)| *x > gap && *force > 0.0));
    let all = said(&sealegs(1, &["effects", "--json", "-"]));
    let all: serde_json::Value = serde_json::from_str(&all).unwrap();
    assert!(all.as_array().unwrap().iter().all(|sheet| sheet["told_apart"].as_str().unwrap().len() > 10));
}

#[test]
fn an_unknown_effect_gets_the_nearest_one() {
    assert!(refused(&["effects", "coulomb-frition"]).contains("did you mean 'coulomb-friction'?"));
}

#[test]
fn a_file_of_the_wrong_kind_is_named_as_what_it_is() {
    let log = asset("campaigns/leg-drop/fit-05cm.csv");
    for verb in ["diagnose", "compare", "check"] {
        let message = refused(&[verb, &log]);
        assert!(message.contains("is a log") && message.contains("sealegs import"), "{message}");
        assert!(message.contains("a campaign's folder"), "{message}");
    }
    let message = refused(&["run", &log]);
    assert!(message.contains("is a log") && message.contains("takes a scenario"), "{message}");
    let message = refused(&["run", &asset("campaigns/leg-drop/campaign.toml")]);
    assert!(message.contains("is a campaign") && message.contains("sealegs diagnose"), "{message}");
    let message = refused(&["diagnose", &asset("robots/thor-leg.urdf")]);
    assert!(message.contains("is a robot") && message.contains("sealegs run"), "{message}");
    let message = refused(&["impact", &asset("actuators/thor-linear.toml")]);
    assert!(message.contains("is an actuator's file") && message.contains("sealegs bench"), "{message}");
}

#[test]
fn a_key_of_a_campaign_file_is_called_key() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("campaign.toml");
    std::fs::write(&file, "bench = 'lokced'\nactuator = 'thor-linear'\n").unwrap();
    let message = refused(&["check", folder.path().to_str().unwrap()]);
    assert!(message.contains("line 1, key 'bench'"), "{message}");
}

#[test]
fn version_completions_and_man_pages() {
    let version = said(&sealegs(1, &["--version"]));
    assert!(version.starts_with(&format!("sealegs {}", env!("CARGO_PKG_VERSION"))), "{version}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = said(&sealegs(1, &["completions", shell]));
        assert!(script.contains("diagnose") && script.contains("effects"), "{shell}");
    }
    let folder = tempfile::tempdir().unwrap();
    let done = sealegs(1, &["man", "-o", folder.path().to_str().unwrap()]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    for page in ["sealegs", "sealegs-diagnose", "sealegs-effects", "sealegs-man"] {
        let text = std::fs::read_to_string(folder.path().join(format!("{page}.1"))).unwrap();
        assert!(text.contains(".SH NAME"), "{page}");
    }
}
