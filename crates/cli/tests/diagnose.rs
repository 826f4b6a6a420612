//! `sealegs diagnose` and `sealegs add` on a small campaign whose truth comes from another integrator:
//! semi-implicit Euler with a stick test at a hundredth of the program's step.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Mass, damping, stiffness of the truth; the model file starts elsewhere.
const TRUTH: [f64; 3] = [1.2, 30.0, 4000.0];
const NOISE_M: f64 = 2e-5;
const NOISE_N: f64 = 0.05;
const STEP_S: f64 = 1e-6;
const SAMPLE_S: f64 = 2e-3;

fn sealegs(threads: usize, arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sealegs"));
    program.env("RAYON_NUM_THREADS", threads.to_string()).args(arguments).output().unwrap()
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A reproducible standard normal number: the sum of twelve uniform ones, less six.
fn normal(state: &mut u64) -> f64 {
    let mut sum = -6.0;
    for _ in 0..12 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (*state >> 11) as f64 / (1u64 << 53) as f64;
    }
    sum
}

/// One run as CSV: force in, deflection and spring force out, with Coulomb friction `friction` in N.
fn run(friction: f64, seconds: f64, seed: u64, input: impl Fn(f64) -> f64) -> String {
    let [m, b, k] = TRUTH;
    let (mut x, mut v) = (0.0f64, 0.0f64);
    let mut state = seed;
    let mut text = "time_s,motor_force_n,spring_deflection_m,force_1_n\n".to_owned();
    let per_sample = (SAMPLE_S / STEP_S).round() as usize;
    for i in 0..(seconds / SAMPLE_S) as usize {
        let u = input(i as f64 * SAMPLE_S);
        let (nx, nf) = (NOISE_M * normal(&mut state), NOISE_N * normal(&mut state));
        text.push_str(&format!("{:.3},{u},{},{}\n", i as f64 * SAMPLE_S, x + nx, k * x + nf));
        for _ in 0..per_sample {
            // Friction takes the speed to zero at most; what is over moves the mass.
            let free = v + STEP_S * (u - b * v - k * x) / m;
            let most = STEP_S * friction / m;
            v = if free.abs() <= most { 0.0 } else { free - most.copysign(free) };
            x += STEP_S * v;
        }
    }
    text
}

const MODEL: &str = r#"
id = "bench-truck"
kind = "linear"
[motor]
torque_constant_nm_a = 1.0
rotor_inertia_kg_m2 = 1.0
rotor_damping_nm_s = 25.0
[transmission]
type = "direct"
[spring]
type = "constant"
stiffness_n_m = 3600.0
[parameters.force_constant]
fixed = true
[sensors.spring_deflection_m]
gain_std = 0.0
"#;

/// Writes a campaign with this friction and returns its folder.
fn campaign(folder: &Path, friction: f64) -> PathBuf {
    let folder = folder.join(format!("friction-{friction}"));
    std::fs::create_dir_all(&folder).unwrap();
    let chirp = |t: f64| if t < 0.3 { 0.0 } else { 40.0 * ((4.0 + 6.0 * (t - 0.3)) * (t - 0.3)).sin() };
    let stairs = |t: f64| [0.0, 25.0, 45.0, -10.0, -40.0, -15.0, 30.0, 5.0][((t / 0.5) as usize).min(7)];
    let mixed = |t: f64| if t < 0.3 { 0.0 } else { 22.0 * (9.0 * t).sin() + 15.0 * (31.0 * t + 1.0).sin() };
    let slow = |t: f64| if t < 0.3 { 0.0 } else { 35.0 * (3.0 * (t - 0.3)).sin() };
    std::fs::write(folder.join("chirp.csv"), run(friction, 3.0, 1, chirp)).unwrap();
    std::fs::write(folder.join("stairs.csv"), run(friction, 3.0, 2, stairs)).unwrap();
    std::fs::write(folder.join("mixed.csv"), run(friction, 3.0, 3, mixed)).unwrap();
    std::fs::write(folder.join("slow.csv"), run(friction, 3.0, 4, slow)).unwrap();
    std::fs::write(folder.join("model.toml"), MODEL).unwrap();
    let text = format!(
        "name = \"truck\"\nbench = \"locked\"\nactuator = \"model.toml\"\nsample_rate_hz = 500.0\n\
         [noise_std]\nspring_deflection_m = {NOISE_M}\nforce_1_n = {NOISE_N}\n\
         [[run]]\nfile = \"chirp.csv\"\nrole = \"fit\"\n[[run]]\nfile = \"stairs.csv\"\nrole = \"fit\"\n\
         [[run]]\nfile = \"mixed.csv\"\nrole = \"holdout\"\n[[run]]\nfile = \"slow.csv\"\nrole = \"holdout\"\n"
    );
    std::fs::write(folder.join("campaign.toml"), text).unwrap();
    folder
}

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
