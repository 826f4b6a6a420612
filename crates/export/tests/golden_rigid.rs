//! The files of drives without a spring, as they stand in `golden/`. `SEALEGS_WRITE_GOLDEN=1` writes them anew, for a look at
//! what changed.

mod common;

use common::is_golden;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig, RunSetup};
use sealegs_export::{ExportError, Exported, Fate, Format, bench, on_run, robot};
use sealegs_leg::bench::{RobotFile, RobotModel};
use std::path::Path;

/// Round numbers: r = 1, J = 0.01 kg m^2, b = 0.02 N m s, K = 0.5 N m/A, R = 2 ohm, 10 V.
const SERVO: &str = "id = \"servo\"
kind = \"rotary\"
spring = \"none\"

[motor]
torque_constant_nm_a = 0.5
winding_resistance_ohm = 2.0
supply_v = 10.0
rotor_inertia_kg_m2 = 0.01
rotor_damping_nm_s = 0.02

[transmission]
type = \"direct\"

[servo]
proportional_per_rad = 2.0
duty_limit = 0.8
duty_dead_zone = 0.05
command_delay_s = 0.01

[[effect]]
id = \"load-dependent-friction\"
parameters = { coefficient = 0.1 }
";

const URDF: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.1"/><mass value="1"/>
    <inertia ixx="0.005" iyy="0.005" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 -0.4"/><axis xyz="0 -1 0"/>
    <limit lower="-2" upper="2" effort="5" velocity="10"/><dynamics damping="0.05" friction="0.3"/></joint>
</robot>
"#;

const DRIVE: &str = "id = \"drive\"
kind = \"rotary\"
spring = \"none\"
[motor]
torque_constant_nm_a = 1.0
rotor_inertia_kg_m2 = 1e-4
rotor_damping_nm_s = 1e-3
[transmission]
type = \"gear\"
gear_ratio = 10.0
";

/// An improved model, as `sealegs add` writes it.
const ARM: &str = "robot = \"arm.urdf\"
actuator = \"drive.toml\"
[[effect]]
id = \"shoulder/coulomb-friction\"
parameters = { force_nm = 0.2 }
[[effect]]
id = \"elbow/load-dependent-friction\"
parameters = { coefficient = 0.05 }
[[effect]]
id = \"elbow/dahl-friction\"
parameters = { }
";

fn lost(exported: &Exported) -> Vec<&str> {
    exported.notes.iter().filter(|n| n.fate == Fate::Lost).map(|n| n.what.as_str()).collect()
}

/// A pendulum of 3 kg on a rod of 1.2 kg, 0.5 m.
fn servo() -> BenchModel {
    let rig = PendulumRig { arm_m: 1.0, length_m: 0.5, mass_kg: 3.0, rod_mass_kg: 1.2 };
    let spec = ActuatorSpec::from_toml(SERVO, "servo.toml").unwrap_or_else(|e| panic!("{e}"));
    let bench = Bench::Pendulum(rig);
    let run = RunSetup {
        record: "a.csv".to_owned(),
        bench,
        start: (0.25, -0.5),
        first_rows: None,
        servo_gain: 2.0,
    };
    BenchModel::new(spec, bench)
        .and_then(|model| model.with_runs(vec![run]))
        .unwrap_or_else(|e| panic!("{e}"))
}

fn arm(folder: &Path) -> RobotModel {
    for (name, text) in [("arm.urdf", URDF), ("drive.toml", DRIVE), ("arm.toml", ARM)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let file = RobotFile::load(&folder.join("arm.toml")).unwrap_or_else(|e| panic!("{e}"));
    RobotModel::new(file, &[]).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn regress_a_servo_on_a_pendulum_in_every_format() {
    for (format, ending) in
        [(Format::Mjcf, "xml"), (Format::Urdf, "urdf"), (Format::Sdf, "sdf"), (Format::IsaacLab, "py")]
    {
        let done = on_run(format, &servo(), "position_rad", Some("a.csv"), "servo").unwrap();
        is_golden(&format!("servo.{ending}"), &done.text);
        if format == Format::Mjcf {
            is_golden("servo_beside.py", &done.beside[0].1);
            assert!(lost(&done).is_empty(), "{:?}", lost(&done));
        }
    }
}

#[test]
fn analytic_a_servo_is_a_spring_with_a_limit_and_a_back_emf() {
    let done = on_run(Format::Mjcf, &servo(), "position_rad", Some("a.csv"), "servo").unwrap();
    let xml = roxmltree::Document::parse(&done.text).unwrap();
    let find = |tag: &str, name: &str| {
        xml.descendants().find(|n| n.has_tag_name(tag) && n.attribute("name") == Some(name)).unwrap()
    };
    let numbers = |node: roxmltree::Node, attribute: &str| -> Vec<f64> {
        node.attribute(attribute).unwrap().split(' ').map(|v| v.parse().unwrap()).collect()
    };
    // 2 per rad, doubled by the run, of 10 V over 2 ohm at 0.5 N m/A: 10 N m/rad; 0.8 of 2.5 N m at most.
    let motor = find("general", "lever");
    assert_eq!((numbers(motor, "gainprm"), numbers(motor, "biasprm")), (vec![10.0], vec![0.0, -10.0, 0.0]));
    assert_eq!(numbers(motor, "forcerange"), [-2.0, 2.0]);
    // 3 kg and half a rod's weight at 0.5 m, 3 kg and a third of a rod's inertia.
    let load = xml.descendants().find(|n| n.has_tag_name("inertial")).unwrap();
    let (mass, at) = (numbers(load, "mass")[0], numbers(load, "pos")[2]);
    assert!((mass * at + (3.0 + 0.6) * 0.5).abs() < 1e-12, "{mass} {at}");
    assert!((mass * at * at - (3.0 + 0.4) * 0.25).abs() < 1e-12, "{mass} {at}");
    let key = find("key", "a.csv");
    assert_eq!((numbers(key, "qpos"), numbers(key, "qvel")), (vec![0.25], vec![-0.5]));
}

#[test]
fn analytic_a_joint_under_impedance_control_is_an_actuator_with_stiffness_damping_and_a_limit() {
    let spec = SERVO.replace(
        "proportional_per_rad = 2.0\nduty_limit = 0.8\nduty_dead_zone = 0.05\n",
        "proportional_nm_per_rad = 30.0\nderivative_nm_s_per_rad = 0.8\ntorque_limit_nm = 9.0\nrate_hz = 500.0\n",
    );
    let rig = PendulumRig { arm_m: 1.0, length_m: 0.5, mass_kg: 3.0, rod_mass_kg: 1.2 };
    let spec = ActuatorSpec::from_toml(&spec, "joint.toml").unwrap_or_else(|e| panic!("{e}"));
    let model = BenchModel::new(spec, Bench::Pendulum(rig)).unwrap_or_else(|e| panic!("{e}"));
    let done = |format| bench(format, &model, "position_rad", "joint").unwrap();
    let mjcf = done(Format::Mjcf);
    let xml = roxmltree::Document::parse(&mjcf.text).unwrap();
    let motor = xml.descendants().find(|n| n.has_tag_name("general")).unwrap();
    let numbers = |attribute: &str| -> Vec<f64> {
        motor.attribute(attribute).unwrap().split(' ').map(|v| v.parse().unwrap()).collect()
    };
    assert_eq!((numbers("gainprm"), numbers("biasprm")), (vec![30.0], vec![0.0, -30.0, -0.8]));
    assert_eq!(numbers("forcerange"), [-9.0, 9.0]);
    assert!(motor.has_attribute("delay"), "the command's delay is lost");
    assert!(lost(&mjcf).contains(&"rate_hz of the loop"), "{:?}", lost(&mjcf));
    let isaac = done(Format::IsaacLab).text;
    for line in ["stiffness=30,", "damping=0.8,", "effort_limit=9,"] {
        assert!(isaac.contains(line), "{line}: {isaac}");
    }
    assert!(lost(&done(Format::Urdf)).iter().any(|what| what.starts_with("command")));
}

#[test]
fn regress_a_robot_with_torque_drives_in_every_format() {
    let folder = std::env::temp_dir().join(format!("sealegs-arm-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let model = arm(&folder);
    for (format, ending) in
        [(Format::Mjcf, "xml"), (Format::Urdf, "urdf"), (Format::Sdf, "sdf"), (Format::IsaacLab, "py")]
    {
        let done = robot(format, &model, "arm").unwrap();
        is_golden(&format!("arm.{ending}"), &done.text);
        // What no format holds is said of every one.
        assert!(lost(&done).contains(&"elbow/dahl-friction"), "{:?}", lost(&done));
        assert!(lost(&done).contains(&"friction in the URDF"), "{:?}", lost(&done));
        match format {
            Format::Mjcf => is_golden("arm_beside.py", &done.beside[0].1),
            Format::IsaacLab => {}
            _ => assert!(roxmltree::Document::parse(&done.text).is_ok()),
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_drive_without_its_winding_takes_no_voltage() {
    let spec = ActuatorSpec::from_toml(DRIVE, "drive.toml").unwrap_or_else(|e| panic!("{e}"));
    let model = BenchModel::new(spec, Bench::Free { load: 0.0 }).unwrap_or_else(|e| panic!("{e}"));
    let refused: Result<_, ExportError> = bench(Format::Mjcf, &model, "voltage_v", "a");
    assert!(refused.is_err_and(|e| e.to_string().contains("winding_resistance")));
}
