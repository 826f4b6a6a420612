//! `sealegs run FILE.urdf` as a user types it: any robot falls, what was mended is said, and `--strict` refuses it.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn sealegs(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sealegs")).args(arguments).output().unwrap()
}

fn robot(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../leg/tests/robot/faults/{name}.urdf"))
}

#[test]
fn a_urdf_by_itself_falls_from_a_fixed_base() {
    let urdf = robot("virtual-links");
    let urdf = urdf.to_str().unwrap();
    let output = sealegs(&["run", urdf, "--duration", "0.2"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    for part in [
        "link 'roll': what the joint moves (the link) has a mass of 0e0 kg, raised to 1e-6 kg",
        "virtual-links: 0.200 s at a step of 100 us, 3 joints, 0 actuators",
        "hip_pitch",
        "rad/s",
        "unexplained at most",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let output = sealegs(&["run", urdf, "--duration", "0.2", "--json", "-"]);
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result["joints"].as_array().map(Vec::len), Some(3));
    assert_eq!(result["joints"][1]["name"], "hip_pitch");
    assert!(result["joints"][1]["speed"].as_f64().unwrap().abs() > 0.1, "it falls: {result}");
    assert_eq!(result["remarks"].as_array().map(Vec::len), Some(2), "{result}");
}

#[test]
fn the_strict_get_one_message_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("out.json");
    let deep = folder.path().join("deep.urdf");
    let nested = format!("{}{}", "<link>".repeat(100_000), "</link>".repeat(100_000));
    std::fs::write(&deep, format!("<robot name=\"r\">\n{nested}\n</robot>")).unwrap();
    let plain = robot("triangle");
    for (urdf, more, named) in [
        (&plain, vec!["--strict"], "triangle.urdf:6: link 'thigh' inertial inertia: no body has"),
        (&deep, vec![], "deep.urdf:2: URDF: elements are nested more than 256 deep"),
        (&plain, vec!["--duration=-1"], "duration_s"),
    ] {
        let arguments =
            [&["run", urdf.to_str().unwrap(), "--json", json.to_str().unwrap()], &more[..]].concat();
        let output = sealegs(&arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
        assert!(message.contains(named), "{arguments:?}: {message}");
        assert!(!json.exists(), "{arguments:?} left a file");
    }
}

#[test]
fn packages_are_found_where_ros_says() {
    let folder = tempfile::tempdir().unwrap();
    let package = folder.path().join("install/share/not_installed/meshes");
    std::fs::create_dir_all(&package).unwrap();
    let plate = Path::new(env!("CARGO_MANIFEST_DIR")).join("../leg/tests/robot/faults/plate.dae");
    std::fs::copy(plate, package.join("thigh.dae")).unwrap();
    let urdf = robot("missing-meshes");
    let run = |variable: &str, value: PathBuf| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sealegs"));
        command.args(["run", urdf.to_str().unwrap(), "--duration", "0.01"]).env(variable, value);
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().contains("thigh.dae': no such file")
    };
    assert!(run("AMENT_PREFIX_PATH", folder.path().join("elsewhere")), "costs the picture, not the run");
    assert!(!run("AMENT_PREFIX_PATH", folder.path().join("install")));
    assert!(!run("ROS_PACKAGE_PATH", folder.path().join("install/share")));
}
