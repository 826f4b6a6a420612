//! `sealegs list`, `run` and `impact` as a user types them: results, exit statuses, and nothing left of a refusal.

use sealegs::recorder::recording::RecordingContents;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn sealegs(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sealegs")).args(arguments).output().unwrap()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

fn files(folder: &Path) -> usize {
    std::fs::read_dir(folder).unwrap().count()
}

#[test]
fn what_is_listed_runs_and_leaves_whole_files() {
    let folder = tempfile::tempdir().unwrap();
    let listed = String::from_utf8(sealegs(&["list"]).stdout).unwrap();
    for scenario in ["thor-drop", "saffir-drop", "thor-swing", "saffir-swing"] {
        assert!(listed.contains(scenario), "{listed}");
        let file = |ending: &str| folder.path().join(format!("{scenario}.{ending}"));
        let (csv, json, rrd) = (file("csv"), file("json"), file("rrd"));
        let output = sealegs(&[
            "run",
            scenario,
            "--set",
            "duration_s=0.3",
            "--csv",
            csv.to_str().unwrap(),
            "--json",
            json.to_str().unwrap(),
            "--rrd",
            rrd.to_str().unwrap(),
        ]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stderr.is_empty(), "quiet in a pipe");
        let rows = text(&csv);
        let columns = rows.lines().next().unwrap().split(',').count();
        assert_eq!(rows.lines().count(), 302, "a header, then a sample a millisecond, both ends counted");
        assert!(rows.lines().all(|l| l.split(',').count() == columns));
        let result: Value = serde_json::from_str(&text(&json)).unwrap();
        assert_eq!(result["scenario"], scenario);
        assert!(rrd.metadata().unwrap().len() > 10_000);
    }
    assert_eq!(files(folder.path()), 12, "nothing unfinished beside the results");
}

#[test]
fn a_sweep_is_gated_by_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("sweep.json");
    let sweep = |limit: &str| {
        let arguments = ["impact", "thor-impact", "--heights", "0.02", "--springs", "compliant,locked-out"];
        let more = ["--set", "duration_s=0.3", "--max-force", limit, "--json", json.to_str().unwrap()];
        sealegs(&[&arguments[..], &more[..]].concat()).status.code()
    };
    assert_eq!(sweep("3000"), Some(3), "locked out, the knee bears more");
    let result: Value = serde_json::from_str(&text(&json)).unwrap();
    assert_eq!(result["rows"].as_array().map(Vec::len), Some(2), "the table is written all the same");
    assert_eq!(sweep("30000"), Some(0));
}

#[test]
fn a_sweep_has_a_report_and_one_recording_of_all_drops() {
    let folder = tempfile::tempdir().unwrap();
    let (report, rrd) = (folder.path().join("sweep.html"), folder.path().join("sweep.rrd"));
    let sweep = ["impact", "thor-impact", "--heights", "0.02,0.05", "--springs", "compliant,locked-out"];
    let outputs = ["--report", report.to_str().unwrap(), "--rrd", rrd.to_str().unwrap()];
    let output = sealegs(&[&sweep[..], &["--set", "duration_s=0.2"], &outputs[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let page = text(&report);
    for said in ["Peak force of the ground", "rated force", "yield strength", "sealegs impact thor-impact"] {
        assert!(page.contains(said), "{said}");
    }
    let recording = RecordingContents::read(&rrd).unwrap();
    assert!(recording.is_complete());
    for drop in ["compliant 0.02 m", "locked-out 0.02 m", "compliant 0.05 m", "locked-out 0.05 m"] {
        let force = recording.series("ground", drop).unwrap_or_else(|| panic!("{drop}"));
        assert_eq!(force.time_s.len(), 201, "{drop}: a sample a millisecond, both ends counted");
        assert!(force.values.iter().all(|v| v.is_finite()) && force.values.iter().any(|v| *v > 100.0));
        assert!(recording.events.iter().any(|e| e.text.starts_with(&format!("{drop}: "))), "{drop}");
        assert!(recording.entities.iter().any(|e| e.contains("shank")), "{:?}", recording.entities);
    }
    assert_eq!(files(folder.path()), 2, "nothing unfinished beside the results");
    let refused = sealegs(&[&sweep[..], &["--rrd", "-"]].concat());
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn bad_input_is_one_message_with_status_2_and_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("out.json");
    std::fs::write(folder.path().join("broken.urdf"), "<robot name='x'><link").unwrap();
    std::fs::write(folder.path().join("broken.toml"), "robot = \"broken.urdf\"\nduration_s = 1.0\n").unwrap();
    let broken = folder.path().join("broken.toml");
    let before = files(folder.path());
    for (arguments, named) in [
        (vec!["run", "thor-dorp"], "thor-drop"),
        (vec!["run", "thor-drop", "--set", "start.drop_heigt_m=0.1"], "drop_height_m"),
        (vec!["run", "thor-drop", "--set", "ground.stiffness_n_m_n=-1"], "ground.stiffness_n_m_n"),
        (vec!["run", "thor-drop", "--set", "gravity_m_s2=nan"], "gravity_m_s2"),
        (vec!["run", "thor-drop", "--step", "0"], "step_s"),
        (vec!["run", broken.to_str().unwrap()], "broken.urdf"),
        (vec!["impact", "thor-impact", "--springs", "sitff"], "stiff"),
    ] {
        let output = sealegs(&[&arguments[..], &["--json", json.to_str().unwrap()]].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
        assert!(message.contains(named), "{arguments:?}: {message}");
        assert_eq!(files(folder.path()), before, "{arguments:?} left a file");
    }
    let nowhere = folder.path().join("no/such/folder/out.json");
    let output = sealegs(&["run", "thor-drop", "--json", nowhere.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
}
