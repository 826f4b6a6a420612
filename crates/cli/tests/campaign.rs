//! `sealegs check`, `compare` and `add` as a user types them: keys of the result, exit statuses, every refusal of
//! the data contract through the program, nothing half written, nothing said in a pipe.

mod program;
mod truck;

use program::{json, sealegs};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;
use truck::campaign;

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

fn files(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

/// The program must end well and say nothing but what was asked for.
fn well(arguments: &[&str]) -> Output {
    let done = sealegs(2, arguments);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(0), "{arguments:?}: {error}");
    assert!(!error.contains(['\r', '\x1b']), "progress in a pipe: {error:?}");
    done
}

fn result(path: &Path) -> Value {
    let value = json(path);
    assert_eq!(value["campaign"], "truck");
    value
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// What the contract asks of one side (`base`, `after`) of a result.
fn side(value: &Value) {
    assert!(number(&value["holdout_error"]) > 0.0 && number(&value["fit_error"]) > 0.0);
    let parameters = value["parameters"].as_array().unwrap();
    for parameter in parameters {
        assert!(parameter["name"].is_string() && parameter["unit"].is_string(), "{parameter}");
        assert!(number(&parameter["value"]).is_finite() && parameter.get("std").is_some(), "{parameter}");
    }
}

#[test]
fn a_drives_file_in_the_place_of_a_robot_is_told_what_was_meant() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..40).map(|i| format!("{},{},0\n", 0.01 * f64::from(i), i % 3)).collect();
    let drive = "id = \"d\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.1\n\
                 rotor_inertia_kg_m2 = 1e-4\nrotor_damping_nm_s = 1e-3\n[transmission]\ntype = \"direct\"\n";
    let campaign = "bench = \"robot\"\nrobot = \"drive.toml\"\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n";
    for (name, text) in [
        ("r.csv", format!("time_s,elbow.torque_nm,elbow.angle_rad\n{rows}")),
        ("drive.toml", drive.to_owned()),
        ("campaign.toml", campaign.to_owned()),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let done = sealegs(1, &["check", &text(folder.path())]);
    let message = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{message}");
    assert!(message.contains("campaign.toml") && message.contains("line 2"), "{message}");
    assert!(
        message.contains("is a drive's file") && message.contains("actuator = \"drive.toml\""),
        "{message}"
    );
}

#[test]
fn check_says_what_is_in_the_files_and_needs_no_role() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 6.0);
    let json = folder.path().join("check.json");
    let done = well(&["check", &text(&campaign), "--json", &text(&json)]);
    assert!(String::from_utf8_lossy(&done.stdout).contains("chirp.csv"));
    let found = result(&json);
    let runs = found["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 4);
    for run in runs {
        assert_eq!(run["rows"], 1500);
        assert!((number(&run["clock"]["period_s"]) - 0.002).abs() < 1e-9);
        assert!(run["clock"]["gaps"].as_array().unwrap().is_empty());
    }
    let noise = found["noise"].as_array().unwrap().iter().find(|n| n["channel"] == "force_1_n").unwrap();
    // The campaign states 0.05 N, and what differences say must agree with the noise that was added.
    assert_eq!(noise["origin"], "stated");
    assert!((number(&noise["from_differences"]) / 0.05 - 1.0).abs() < 0.15, "{noise}");
    for key in ["columns", "parameters", "effects", "repeats"] {
        assert!(found[key].is_array(), "{key}");
    }
    // To standard output: the result and nothing else.
    let done = well(&["check", &text(&campaign.join("campaign.toml")), "--json", "-"]);
    assert_eq!(serde_json::from_slice::<Value>(&done.stdout).unwrap(), found);
    // Fit runs alone are enough for a check and a comparison.
    let toml = std::fs::read_to_string(campaign.join("campaign.toml")).unwrap();
    std::fs::write(campaign.join("campaign.toml"), toml.replace("holdout", "fit")).unwrap();
    well(&["check", &text(&campaign)]);
}

#[test]
fn compare_states_the_error_in_noise_units_with_and_without_a_refit() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 0.0);
    let file = |name: &str| folder.path().join(name);
    let (refit, as_is) = (file("refit.json"), file("as-is.json"));
    let (html, rrd) = (file("r.html"), file("r.rrd"));
    let outputs = ["--json", &text(&refit), "--report", &text(&html), "--rrd", &text(&rrd)];
    let done = well(&[&["compare", &text(&campaign), "--progress"][..], &outputs].concat());
    let progress = String::from_utf8_lossy(&done.stderr);
    assert!(progress.contains("refitting the model's own parameters"), "{progress}");
    assert!(!done.stdout.is_empty());
    well(&["compare", &text(&campaign), "--as-is", "--json", &text(&as_is)]);
    assert_eq!(files(folder.path()), ["as-is.json", "friction-0", "r.html", "r.rrd", "refit.json"]);
    assert!(std::fs::read_to_string(&html).unwrap().trim_end().ends_with("</html>"));
    assert_eq!(std::fs::read(&rrd).unwrap()[..3], *b"RRF");
    let (refit, as_is) = (result(&refit), result(&as_is));
    for compared in [&refit, &as_is] {
        assert!(number(&compared["noise_floor"]) > 0.0);
        side(&compared["base"]);
    }
    // Nothing is fitted as it is, so that no fitted value is stated.
    assert!(as_is["base"]["parameters"].as_array().unwrap().is_empty());
    // Without friction the truth is the model's own kind, so that a refit reaches the noise, and the file's
    // wrong values do not.
    assert!((number(&refit["base"]["holdout_error"]) - 1.0).abs() < 0.05, "{}", refit["base"]);
    assert!(number(&as_is["base"]["holdout_error"]) > 3.0, "{}", as_is["base"]);
    let stiffness = refit["base"]["parameters"].as_array().unwrap();
    let stiffness = stiffness.iter().find(|p| p["name"] == "stiffness").unwrap();
    assert!((number(&stiffness["value"]) / 4000.0 - 1.0).abs() < 0.01, "{stiffness}");
}

#[test]
fn add_writes_a_model_and_its_two_sides() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 6.0);
    let (better, json) = (folder.path().join("better.toml"), folder.path().join("add.json"));
    let model = text(&campaign.join("model.toml"));
    let common = ["--to", &model, "--campaign", &text(&campaign), "-o", &text(&better)];
    let done = well(&[&["add", "coulomb-friction"][..], &common, &["--json", &text(&json)]].concat());
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(said.contains("held-out") && said.contains("better.toml"), "{said}");
    let added = result(&json);
    assert_eq!(added["effects"], serde_json::json!(["coulomb-friction"]));
    side(&added["base"]);
    side(&added["after"]);
    assert!(number(&added["after"]["holdout_error"]) < 0.5 * number(&added["base"]["holdout_error"]));
    let written = std::fs::read_to_string(&better).unwrap();
    assert!(written.contains("coulomb-friction") && written.contains("sha256:"), "{written}");

    // An effect that the model has already is refused, and the model that is there stays as it is.
    let again = ["--to", &text(&better), "--campaign", &text(&campaign), "-o", &text(&better)];
    let done = sealegs(2, &[&["add", "coulomb-friction"][..], &again].concat());
    assert_eq!(done.status.code(), Some(2), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(std::fs::read_to_string(&better).unwrap(), written);
}

/// Replaces the cell of a column (from 0) in a line (from 1) of a table.
fn with_cell(table: &str, line: usize, column: usize, cell: &str) -> String {
    let mut lines: Vec<String> = table.lines().map(str::to_owned).collect();
    let mut cells: Vec<&str> = lines[line - 1].split(',').collect();
    cells[column] = cell;
    lines[line - 1] = cells.join(",");
    lines.join("\n") + "\n"
}

#[test]
fn every_fault_of_the_contract_is_one_message_with_status_2_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 0.0);
    let toml = std::fs::read_to_string(campaign.join("campaign.toml")).unwrap();
    let table = std::fs::read_to_string(campaign.join("chirp.csv")).unwrap();
    let (json, better) = (folder.path().join("out.json"), folder.path().join("better.toml"));
    let model = text(&campaign.join("model.toml"));
    let (c, j) = (text(&campaign), text(&json));
    let verbs: [Vec<&str>; 4] = [
        vec!["check", &c, "--json", &j],
        vec!["compare", &c, "--json", &j],
        vec!["diagnose", &c, "--json", &j],
        vec![
            "add",
            "backlash",
            "--to",
            &model,
            "--campaign",
            &c,
            "-o",
            better.to_str().unwrap(),
            "--json",
            &j,
        ],
    ];
    let refused = |toml: &str, table: Option<&str>, said: &[&str], verbs: &[Vec<&str>]| {
        std::fs::write(campaign.join("campaign.toml"), toml).unwrap();
        let path = campaign.join("chirp.csv");
        match table {
            Some(table) => std::fs::write(&path, table).unwrap(),
            None => std::fs::remove_file(&path).unwrap(),
        }
        let before = files(&campaign);
        for verb in verbs {
            let done = sealegs(2, verb);
            let error = String::from_utf8_lossy(&done.stderr);
            assert_eq!(done.status.code(), Some(2), "{verb:?}: {said:?}: {error}");
            assert_eq!(error.lines().count(), 1, "{verb:?}: {error}");
            assert!(done.stdout.is_empty(), "{verb:?}: {}", String::from_utf8_lossy(&done.stdout));
            for word in said {
                assert!(error.contains(word), "{verb:?}: '{word}' is not in: {error}");
            }
            assert_eq!(files(folder.path()), ["friction-0"], "{verb:?}: {error}");
            assert_eq!(files(&campaign), before);
        }
    };
    let bad_table = |table: &str, said: &[&str]| {
        refused(&toml, Some(table), &[&["chirp.csv"], said].concat(), &verbs);
    };
    let bad_toml = |from: &str, to: &str, said: &[&str]| {
        assert!(toml.contains(from));
        refused(&toml.replacen(from, to, 1), Some(&table), &[&["campaign.toml"], said].concat(), &verbs);
    };
    // Missing or empty.
    refused(&toml, None, &["campaign.toml", "line 9", "chirp.csv"], &verbs);
    refused("", Some(&table), &["campaign.toml", "is empty"], &verbs);
    bad_table("", &["is empty"]);
    // No header.
    bad_table(table.split_once('\n').unwrap().1, &["line 1", "no header"]);
    // Unknown words.
    bad_toml("\"locked\"", "\"loked\"", &["line 2", "bench", "did you mean 'locked'"]);
    let unknown = toml.replacen("model.toml", "thor-liner", 1);
    let said = ["campaign.toml", "line 3", "actuator", "did you mean 'thor-linear'"];
    // `add` is told its model by `--to`, and reads no other.
    refused(&unknown, Some(&table), &said, &verbs[..3]);
    bad_toml("\"fit\"", "\"fits\"", &["line 10", "role", "did you mean 'fit'"]);
    // Cells.
    for (cell, said) in [("x", "no number"), ("NaN", "not finite"), ("inf", "not finite"), ("", "empty")] {
        bad_table(&with_cell(&table, 12, 2, cell), &["line 12", "'spring_deflection_m'", said]);
    }
    // Rows and time.
    let few: Vec<&str> = table.lines().take(16).collect();
    bad_table(&few.join("\n"), &["15 rows", "16"]);
    bad_table(&with_cell(&table, 12, 0, "0.018"), &["line 12", "'time_s'", "repeats"]);
    bad_table(&with_cell(&table, 12, 0, "0.001"), &["line 12", "'time_s'", "goes back"]);
    bad_table(&with_cell(&table, 2, 0, "-1.7e9"), &["'time_s'", "10000 s"]);
    // Columns.
    let line_12 = table.lines().nth(11).unwrap();
    let shorter = table.replacen(line_12, line_12.rsplit_once(',').unwrap().0, 1);
    bad_table(&shorter, &["line 12", "'force_1_n'", "3 cells"]);
    bad_table(&table.replacen("motor_force_n", "voltage_m", 1), &["line 1", "no input column"]);
    bad_table(&table.replacen("spring_deflection_m", "current_a", 1), &["line 1", "two input columns"]);
    bad_table(&table.replacen("force_1_n", "force_1_lbf", 1), &["line 1", "'force_1_lbf'"]);
    let unseen = table.replacen("spring_deflection_m,force_1_n", "housing_position_m,shaft_n", 1);
    bad_table(&unseen, &["line 1", "no output column"]);
    // A role that the command needs and no run has.
    refused(&toml.replace("holdout", "fit"), Some(&table), &["holdout"], &verbs[2..3]);
    refused(&toml.replace("\"fit\"", "\"holdout\""), Some(&table), &["\"fit\""], &verbs[2..]);
}

#[test]
fn parquet_and_csv_give_the_same_result() {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sysid/tests/data/parquet");
    let check = |table: &str| {
        let toml = format!(
            "name = \"truck\"\nbench = \"locked\"\nactuator = \"thor-linear\"\n\
             [[run]]\nfile = \"{table}\"\nrole = \"fit\"\n"
        );
        std::fs::copy(data.join(table), folder.path().join(table)).unwrap();
        std::fs::write(folder.path().join("campaign.toml"), toml).unwrap();
        let done = well(&["check", &text(folder.path()), "--json", "-"]);
        String::from_utf8(done.stdout).unwrap().replace(table, "TABLE")
    };
    let csv = check("table.csv");
    for table in ["pyarrow.parquet", "polars.parquet", "pandas.parquet"] {
        assert_eq!(check(table), csv, "{table}");
    }
}

/// Starts the diagnosis of a campaign into four files and interrupts it after `seconds`.
#[cfg(unix)]
fn interrupted(campaign: &Path, out: &Path, seconds: f64) -> (Option<i32>, String) {
    use std::process::{Command, Stdio};
    let file = |name: &str| out.join(name);
    let mut program = Command::new(env!("CARGO_BIN_EXE_sealegs"))
        .args(["diagnose", campaign.to_str().unwrap()])
        .args([PathBuf::from("--json"), file("d.json"), "--report".into(), file("d.html")])
        .args([PathBuf::from("--rrd"), file("d.rrd"), "--plan".into(), file("d.csv")])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_secs_f64(seconds));
    let sent = Command::new("kill").args(["-INT", &program.id().to_string()]).status().unwrap();
    let status = program.wait().unwrap();
    let mut said = String::new();
    std::io::Read::read_to_string(&mut program.stderr.take().unwrap(), &mut said).unwrap();
    // A diagnosis that was quicker than the interrupt ends by itself.
    (status.code().filter(|_| sent.success()), said)
}

#[cfg(unix)]
#[test]
fn an_interrupted_diagnosis_leaves_no_broken_file() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 6.0);
    let out = folder.path().join("out");
    let mut stopped = 0;
    for seconds in [0.15, 0.4, 0.8] {
        std::fs::create_dir(&out).unwrap();
        // What was there before must still be there, whole.
        std::fs::write(out.join("d.json"), "before").unwrap();
        let (status, said) = interrupted(&campaign, &out, seconds);
        if status == Some(130) {
            stopped += 1;
            assert_eq!(files(&out), ["d.json"], "after {seconds} s");
            assert_eq!(std::fs::read_to_string(out.join("d.json")).unwrap(), "before");
            assert!(said.is_empty(), "{said}");
        }
        std::fs::remove_dir_all(&out).unwrap();
    }
    assert!(stopped > 0, "every diagnosis ended before it was interrupted");
}
