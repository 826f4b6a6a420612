//! `sealegs diagnose` and `sealegs add` on a small campaign whose truth comes from another integrator.

mod program;
mod truck;

use program::{json, sealegs};
use serde_json::Value;
use std::path::Path;
use truck::campaign;

fn finite(value: &Value) -> bool {
    match value {
        Value::Null => false,
        Value::Number(n) => n.as_f64().is_some_and(f64::is_finite),
        Value::Array(a) => a.iter().all(finite),
        Value::Object(o) => {
            o.iter().all(|(key, v)| (matches!(key.as_str(), "after" | "std") && v.is_null()) || finite(v))
        }
        _ => true,
    }
}

#[test]
fn reference_friction_is_found_the_same_on_any_number_of_threads_and_added_for_good() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 6.0);
    let path = |name: &str| folder.path().join(name);
    let text = |p: &Path| p.to_str().unwrap().to_owned();
    let diagnose = |threads: usize, out: &Path, plan: &Path| {
        let done =
            sealegs(threads, &["diagnose", &text(&campaign), "--json", &text(out), "--plan", &text(plan)]);
        assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
        assert!(done.stderr.is_empty(), "quiet in a pipe: {}", String::from_utf8_lossy(&done.stderr));
    };
    let (one, two, plan) = (path("one.json"), path("two.json"), path("plan.csv"));
    diagnose(1, &one, &plan);
    diagnose(2, &two, &plan);
    assert_eq!(std::fs::read(&one).unwrap(), std::fs::read(&two).unwrap());
    let result = json(&one);
    assert!(finite(&result));
    for key in [
        "campaign",
        "noise_floor",
        "base",
        "verdict",
        "effects",
        "indistinguishable",
        "after",
        "unexplained_share",
        "ranking",
        "next_experiment",
    ] {
        assert!(result.get(key).is_some(), "{key}");
    }
    assert_eq!(result["verdict"], "missing-effect");
    let hidden = serde_json::json!(["coulomb-friction"]);
    let tied = result["indistinguishable"].as_array().unwrap();
    assert!(result["effects"] == hidden || tied.contains(&hidden), "{}", result["effects"]);
    assert!(result["base"]["holdout_error"].as_f64().unwrap() > 3.0);
    assert!(result["after"]["holdout_error"].as_f64().unwrap() < 1.15);
    assert!(!result["next_experiment"].as_str().unwrap().is_empty());
    let planned = std::fs::read_to_string(&plan).unwrap();
    assert!(planned.starts_with("time_s,motor_force_n\n0,0\n"));
    for line in planned.lines().skip(1) {
        let force: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
        assert!(force.abs() <= 45.0 + 1e-9, "the plan keeps to what the campaign dared: {force}");
    }

    // Added, written, loaded: the same errors without another fit.
    let (better, added, again) = (path("better.toml"), path("added.json"), path("again.json"));
    let model = text(&campaign.join("model.toml"));
    let done = sealegs(
        2,
        &[
            "add",
            "coulomb-friction",
            "--to",
            &model,
            "--campaign",
            &text(&campaign),
            "-o",
            &text(&better),
            "--json",
            &text(&added),
        ],
    );
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let added = json(&added);
    let friction = added["after"]["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .find(|p| p["name"] == "coulomb-friction.force_n")
        .unwrap();
    assert!((friction["value"].as_f64().unwrap() - 6.0).abs() < 0.3, "{friction}");
    let done = sealegs(
        2,
        &["compare", &text(&campaign), "--model", &text(&better), "--as-is", "--json", &text(&again)],
    );
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let errors = json(&again);
    let after = added["after"]["holdout_error"].as_f64().unwrap();
    let loaded = errors["base"]["holdout_error"].as_f64().unwrap();
    assert!((after / loaded - 1.0).abs() < 0.01, "{after} when written, {loaded} when loaded");

    // Refitted to the runs that it was fitted to: they tell no more the second time.
    let done = sealegs(2, &["compare", &text(&campaign), "--model", &text(&better), "--json", &text(&again)]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(String::from_utf8_lossy(&done.stderr).contains("was fitted to runs of this campaign"));
    let refitted = json(&again);
    for p in refitted["base"]["parameters"].as_array().unwrap() {
        let parameters = added["after"]["parameters"].as_array().unwrap();
        let before = parameters.iter().find(|q| q["name"] == p["name"]).unwrap();
        assert_eq!(p["at_bound"], false, "a file's value has room on both sides: {p}");
        let (Some(std), Some(known)) = (p["std"].as_f64(), before["std"].as_f64()) else { continue };
        assert!(std >= 0.9 * known, "{p} after {before}");
    }
}

#[test]
fn reference_the_verdicts_model_predicts_what_the_verdict_says() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 6.0);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (campaign, better) = (campaign.to_str().unwrap(), path("better.toml"));
    let done = sealegs(
        2,
        &["diagnose", campaign, "--better", &better, "--json", &path("verdict.json"), "--progress"],
    );
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(0), "{said}");
    // Each line begins with the seconds so far.
    assert!(said.contains(" s  scoring the held-out runs"), "{said}");
    let done =
        sealegs(2, &["compare", campaign, "--model", &better, "--as-is", "--json", &path("again.json")]);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let (verdict, again) = (json(Path::new(&path("verdict.json"))), json(Path::new(&path("again.json"))));
    let said = verdict["after"]["holdout_error"].as_f64().unwrap();
    let loaded = again["base"]["holdout_error"].as_f64().unwrap();
    assert!((said / loaded - 1.0).abs() < 0.01, "{said} in the verdict, {loaded} when loaded");
}

#[test]
fn reference_nothing_is_missing_where_nothing_is_hidden() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 0.0);
    let done = sealegs(2, &["diagnose", campaign.to_str().unwrap(), "--json", "-"]);
    assert_eq!(done.status.code(), Some(0));
    let result: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(result["verdict"], "adequate", "{}", result["effects"]);
    assert_eq!(result["effects"], serde_json::json!([]));
    assert!(result["after"].is_null());
    assert!(finite(&result));
}

#[test]
fn a_search_that_ends_at_once_leaves_a_verdict_on_the_base_model_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 6.0);
    let done = sealegs(2, &["diagnose", campaign.to_str().unwrap(), "--at-most", "0", "--json", "-"]);
    assert_eq!(done.status.code(), Some(0));
    let result: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!((&result["verdict"], &result["effects"]), (&"unexplained".into(), &serde_json::json!([])));
    assert_eq!(result["work"]["ended_early"], true);
    let sentence = result["sentence"].as_str().unwrap();
    assert!(sentence.contains("Unexplained so far: ") && !sentence.contains("no known effect"), "{sentence}");
    assert!(sentence.contains("The search was ended before it was done"), "{sentence}");
    let wrong = sealegs(2, &["diagnose", campaign.to_str().unwrap(), "--at-most=-1"]);
    let said = String::from_utf8_lossy(&wrong.stderr);
    assert!(wrong.status.code() == Some(2) && said.contains("'-1' is no time in seconds"), "{said}");
}

#[test]
fn bad_input_is_refused_with_status_2_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 0.0);
    let out = folder.path().join("out.json");
    let better = folder.path().join("better.toml");
    let text = |p: &Path| p.to_str().unwrap().to_owned();
    let model = text(&campaign.join("model.toml"));
    let nowhere = text(&folder.path().join("nowhere"));
    let refuse = |arguments: &[&str], said: &str| {
        let done = sealegs(2, arguments);
        let error = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(said), "{arguments:?}: {error}");
        assert!(!out.exists() && !better.exists() && !out.with_extension("json.part").exists());
    };
    let (c, o, b) = (text(&campaign), text(&out), text(&better));
    refuse(&["diagnose", &nowhere, "--json", &o], "nowhere");
    refuse(&["diagnose", &c, "--json", &o, "--model", &nowhere], "nowhere");
    refuse(&["diagnose", &c, "--json", &o, "--effect", &nowhere], "nowhere");
    refuse(&["diagnose", &c, "--json", &text(&folder.path().join("no/such/folder.json"))], "folder.json");
    refuse(
        &["add", "coulomb-fricton", "--to", &model, "--campaign", &c, "-o", &b],
        "did you mean 'coulomb-friction'",
    );
    refuse(&["add", "backlash+backlash", "--to", &model, "--campaign", &c, "-o", &b], "named twice");
    refuse(&["add", "own.toml", "--to", &model, "--campaign", &c, "-o", &b], "no such file");
    let description = std::fs::read_to_string(campaign.join("campaign.toml")).unwrap();
    std::fs::write(campaign.join("campaign.toml"), description.replace("holdout", "fit")).unwrap();
    refuse(&["diagnose", &c, "--json", &o], "holdout");
}
