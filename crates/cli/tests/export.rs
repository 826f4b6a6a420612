//! `sealegs export` as a user types it: files and what is said of them, and refusals that leave nothing behind.

mod program;

use program::sealegs;
use std::path::Path;

fn files(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

fn export(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut all = vec!["export"];
    all.extend(arguments);
    let folder = folder.display().to_string();
    let all: Vec<String> = all.iter().map(|a| a.replace("HERE", &folder)).collect();
    let done = sealegs(2, &all.iter().map(String::as_str).collect::<Vec<_>>());
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (done.status.code(), text(&done.stdout), text(&done.stderr))
}

#[test]
fn a_bench_and_a_leg_are_written_with_what_they_lack() {
    let folder = tempfile::tempdir().unwrap();
    let better = folder.path().join("better.toml");
    let text = sealegs::actuator::ActuatorSpec::preset_text("thor-linear").unwrap();
    let effect = "\n[[effect]]\nid = \"stribeck-friction\"\nparameters = { coulomb_n = 20.0, static_n = 40.0, stribeck_velocity_m_s = 0.004 }\n";
    std::fs::write(&better, format!("{text}{effect}")).unwrap();
    let (status, out, error) = export(
        folder.path(),
        &["HERE/better.toml", "--to", "mjcf", "--bench", "pendulum", "-o", "HERE/bench.xml"],
    );
    assert_eq!(status, Some(0), "{error}");
    assert!(
        out.contains("bench.xml") && out.contains("bench.py") && out.contains("stribeck-friction"),
        "{out}"
    );
    let (status, out, error) =
        export(folder.path(), &["thor-drop", "--to", "isaaclab", "-o", "HERE/my-leg.py"]);
    assert_eq!(status, Some(0), "{error}");
    assert!(out.contains("lost") && out.contains("springs"), "{out}");
    assert_eq!(files(folder.path()), ["bench.py", "bench.xml", "better.toml", "my-leg.py", "my_leg.urdf"]);
    // What is said of the file stands in it.
    let written = std::fs::read_to_string(folder.path().join("my-leg.py")).unwrap();
    for line in out.lines().filter(|l| l.starts_with("  ")) {
        let said: Vec<&str> = line.split_whitespace().skip(1).collect();
        let words: Vec<&str> = written.split_whitespace().collect();
        assert!(words.windows(said.len()).any(|w| w == said), "not in the file: {line}");
    }
}

#[test]
fn what_cannot_be_exported_is_told_in_one_line_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.toml"), "id = \"bad\"\nkind = \"linear\"\nsprung_mass_kg = -1\n")
        .unwrap();
    for (arguments, wanted) in [
        (vec!["thor-linar", "--to", "mjcf", "-o", "HERE/a.xml"], "did you mean 'thor-linear'?"),
        (vec!["HERE/none.toml", "--to", "mjcf", "-o", "HERE/a.xml"], "no such file"),
        (vec!["HERE/bad.toml", "--to", "mjcf", "-o", "HERE/a.xml"], "bad.toml:"),
        (vec!["thor-drop", "--to", "mjcf", "--bench", "locked", "-o", "HERE/a.xml"], "--bench"),
        (vec!["thor-linear", "--to", "mjcf", "-o", "-"], "name a file"),
        (vec!["thor-linear", "--to", "mjcf", "-o", "HERE/a.py"], "take another ending"),
        (vec!["thor-linear", "--to", "mjcf", "-o", "HERE/no/a.xml"], "cannot be written"),
        (vec!["thor-linear", "--to", "collada", "-o", "HERE/a.dae"], "mjcf"),
    ] {
        let (status, out, error) = export(folder.path(), &arguments);
        assert_eq!(status, Some(2), "{arguments:?}: {error}");
        assert!(error.contains(wanted), "{arguments:?}: {error}");
        assert!(out.is_empty() && !error.contains("panicked"), "{arguments:?}: {error}");
        assert_eq!(files(folder.path()), ["bad.toml"], "{arguments:?}");
    }
}

/// A rotary drive and a robot of one joint with a campaign of it.
fn robot_campaign(folder: &Path) {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write(
        "drive.toml",
        "id = \"drive\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 1.0\nrotor_inertia_kg_m2 = \
         0.01\nrotor_damping_nm_s = 0.02\n[transmission]\ntype = \"direct\"\n",
    );
    write(
        "arm.urdf",
        "<robot name=\"arm\"><link name=\"base\"/><link name=\"tip\"><inertial><origin xyz=\"0 0 -0.2\"/><mass value=\"1\"/><inertia \
         ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"elbow\" \
         type=\"continuous\"><parent link=\"base\"/><child link=\"tip\"/><axis xyz=\"0 1 0\"/></joint></robot>",
    );
    write(
        "better.toml",
        "robot = \"arm.urdf\"\nactuator = \"drive.toml\"\n[[effect]]\nid = \"elbow/coulomb-friction\"\n",
    );
    let rows: String = (0..60)
        .map(|i| format!("{:.3},0.1,{:.4}\n", f64::from(i) * 1e-3, 0.3 + 1e-4 * f64::from(i)))
        .collect();
    write("a.csv", &format!("time_s,elbow.torque_nm,elbow.angle_rad\n{rows}"));
    let head = "bench = \"robot\"\nrobot = \"arm.urdf\"\nactuator = \"drive.toml\"\n[noise_std]\n\"elbow.angle_rad\" = 1e-3\n";
    write("campaign.toml", &format!("{head}[[run]]\nfile = \"a.csv\"\nrole = \"fit\"\n"));
}

#[test]
fn a_campaign_and_a_robots_model_file_are_written_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    robot_campaign(folder.path());
    for (arguments, held) in [
        (vec!["HERE/campaign.toml"], "key name=\"a.csv\""),
        (vec!["HERE"], "key name=\"a.csv\""),
        (vec!["HERE/campaign.toml", "--model", "HERE/better.toml", "--run", "a.csv"], "frictionloss"),
        (vec!["HERE/better.toml"], "frictionloss"),
        (vec!["HERE/drive.toml"], "joint name=\"shaft\""),
    ] {
        let (status, out, error) =
            export(folder.path(), &[&arguments[..], &["--to", "mjcf", "-o", "HERE/out.xml"]].concat());
        assert_eq!(status, Some(0), "{arguments:?}: {error}");
        let written = std::fs::read_to_string(folder.path().join("out.xml")).unwrap();
        assert!(written.contains(held) && out.contains("out.py"), "{arguments:?}: {out}");
    }
}

#[test]
fn what_says_too_little_of_a_drive_is_told() {
    let folder = tempfile::tempdir().unwrap();
    robot_campaign(folder.path());
    for (arguments, wanted) in [
        (vec!["HERE/arm.urdf"], "says nothing of its drives"),
        (vec!["HERE/campaign.toml", "--bench", "free"], "--bench"),
        (vec!["HERE/campaign.toml", "--run", "b.csv"], "there are a.csv"),
        (vec!["HERE/better.toml", "--run", "a.csv"], "--run"),
        (vec!["HERE/drive.toml", "--model", "HERE/better.toml"], "--model"),
        (vec!["HERE/drive.toml", "--bench", "pendulum"], "length_m"),
        (vec!["HERE/drive.toml", "--bench", "locked"], "drive.toml"),
        (vec!["HERE/drive.toml", "--input", "voltage"], "takes no voltage_v"),
    ] {
        let (status, out, error) =
            export(folder.path(), &[&arguments[..], &["--to", "mjcf", "-o", "HERE/out.xml"]].concat());
        assert_eq!(status, Some(2), "{arguments:?}: {error}");
        assert!(error.contains(wanted) && out.is_empty(), "{arguments:?}: {error}");
        assert!(!folder.path().join("out.xml").exists(), "{arguments:?}");
    }
}
