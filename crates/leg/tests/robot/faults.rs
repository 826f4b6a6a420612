//! Faults that real robots' files have, a small URDF for each: what is mended is said, what is strict is refused, and
//! what was mended falls without gaining energy.

use std::path::Path;

use nalgebra::{DMatrix, Matrix3, Point3, Vector3};
use sealegs_leg::robot::{Inertial, JointLimits, LoadOptions};
use sealegs_leg::run_simulation;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::Simulation;

use super::*;

/// One fault: the file, parts of the remarks that say what was done, and a part of what a strict reader says
/// (empty where there is nothing to refuse).
const FAULTS: [(&str, &[&str], &str); 11] = [
    (
        "massless-frames",
        &["without mass, and part of the link that they are fixed to: 'imu', 'tool'"],
        "link 'imu' inertial mass: 0: must be positive",
    ),
    ("point-mass", &["without mass, and part of the link that they are fixed to: 'sole'"], "link 'camera'"),
    (
        "zero-inertia",
        &[
            "link 'thigh': what the joint moves (the link) has the principal moments 0.000e0, 0.000e0, 0.000e0 kg m^2, \
           raised to 1.000e-9, 1.000e-9, 1.000e-9 kg m^2",
        ],
        "link 'thigh' inertial inertia: no body has the principal moments",
    ),
    (
        "rounded-inertia",
        &["has the principal moments -2.459e-22, 3.000e-6, 3.000e-6 kg m^2, raised to 1.000e-9"],
        "each must be positive",
    ),
    ("triangle", &["all set to their mean 2.667e-2 kg m^2"], "the largest exceeds the sum"),
    (
        "virtual-links",
        &[
            "link 'roll': what the joint moves (the link) has a mass of 0e0 kg, raised to 1e-6 kg",
            "link 'pitch'",
        ],
        "",
    ),
    (
        "massless-leaf",
        &["link 'gripper'", "raised to 1e-6 kg"],
        "the mass of what this joint moves is missing",
    ),
    (
        "no-limits",
        &[
            "joint 'none': <limit> is missing: it has no limits",
            "joint 'zero': lower and upper limit 0 are read as none",
            "joint 'wheel' limit: both 'lower' and 'upper' is missing: it has no limits",
            "joint 'slide': <limit> is missing",
        ],
        "joint 'none': <limit> is missing",
    ),
    (
        "mimic",
        &["joint 'right_finger' mimic: following joint 'left_finger' is not supported: it moves on its own"],
        "'left_finger'",
    ),
    ("floating-base", &["joint 'free': the floating joint and the empty link 'world' are left out"], ""),
    (
        "missing-meshes",
        &[
            "'nowhere.stl': no such file: left out",
            "'thigh.blend': neither STL",
            "/thigh.dae': no such file",
            "'nowhere.obj'",
        ],
        "'nowhere.stl': no such file",
    ),
];

fn path(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(format!("tests/robot/faults/{name}.urdf"))
        .display()
        .to_string()
}

fn loaded(name: &str) -> Robot {
    Robot::load_with(&path(name), None, &LoadOptions::default()).expect("mended")
}

#[test]
fn each_fault_is_mended_with_a_remark_and_refused_by_the_strict() {
    for (name, remarks, refusal) in FAULTS {
        let robot = loaded(name);
        for part in remarks {
            let said = robot.warnings.iter().filter(|w| w.contains(part)).count();
            assert_eq!(said, 1, "{name}: {part:?} in {:#?}", robot.warnings);
        }
        assert!(robot.warnings.iter().all(|w| w.starts_with(&path(name))), "each names the file");
        let strict = LoadOptions { strict: true, ..LoadOptions::default() };
        match Robot::load_with(&path(name), None, &strict) {
            Ok(_) => assert!(refusal.is_empty(), "{name} is refused"),
            Err(error) => {
                let said = error.to_string();
                assert!(!refusal.is_empty() && said.contains(refusal), "{name}: {said}");
            }
        }
    }
}

#[test]
fn energy_every_mended_robot_falls_without_gaining_any() {
    for (name, ..) in FAULTS {
        let (scenario, robot) =
            Scenario::for_robot(&path(name), &["duration_s=0.3".to_owned()]).expect("good");
        let moves = robot.moving_joints().count();
        let simulation = Simulation::with_robot(&scenario, robot).expect("physical");
        let result = run_simulation(&scenario, simulation, &mut ()).expect("runs");
        assert_eq!(result.stopped, None, "{name}");
        assert_eq!(result.joints.len(), moves);
        assert!(result.energy.kinetic_j > 1e-6, "{name} falls: {:?}", result.energy);
        // A bound below what one wrong number costs: with its principal axes turned by 45 degrees the light body of
        // `rounded-inertia` leaves 2.3e-2.
        assert!(result.worst_energy_residual < 2e-3, "{name}: {}", result.worst_energy_residual);
    }
}

/// The mass matrix of a robot as it is simulated, all joints at zero.
fn mass_matrix(name: &str) -> DMatrix<f64> {
    let (scenario, robot) = Scenario::for_robot(&path(name), &[]).expect("good");
    Simulation::with_robot(&scenario, robot).expect("physical").mass_matrix()
}

#[test]
fn analytic_frames_without_mass_change_nothing() {
    // A hinge about y with 1 kg at (0.05, 0, -0.25): 0.02 + 0.05^2 + 0.25^2.
    let wanted = 0.02 + 0.0025 + 0.0625;
    for name in ["massless-frames", "missing-meshes", "floating-base"] {
        assert!((mass_matrix(name)[(0, 0)] - wanted).abs() < 1e-14, "{name}");
    }
}

#[test]
fn analytic_point_masses_and_bare_inertias_on_fixed_joints_are_exact() {
    // The frames' poses: (0.1, 0, -0.2), then rpy (0.1, 0.2, 0.3).
    let turn = nalgebra::Rotation3::from_euler_angles(0.1, 0.2, 0.3);
    let camera = Vector3::new(0.1, 0.0, -0.2) + turn * Vector3::new(0.0, 0.0, 0.02);
    let bare = (turn * Matrix3::from_diagonal(&Vector3::new(5e-7, 6e-7, 8e-7)) * turn.transpose())[(1, 1)];
    let wanted = 0.085 + 0.3 * (camera.x * camera.x + camera.z * camera.z) + bare;
    assert!((mass_matrix("point-mass")[(0, 0)] - wanted).abs() < 1e-14);
    assert!(
        !loaded("point-mass").warnings.iter().any(|w| w.contains("raised")),
        "a body that can be is not mended"
    );
}

#[test]
fn analytic_mended_moments_are_those_of_the_simulation() {
    // 1.2 kg at (0.05, 0, -0.25) about y, with the bound of 1e-9 kg m^2.
    assert!((mass_matrix("zero-inertia")[(0, 0)] - (1.2 * 0.065 + 1e-9)).abs() < 1e-14);
    // A light body keeps its principal axes: the engine's own search for them would turn these by 45 degrees.
    assert!((mass_matrix("rounded-inertia")[(0, 0)] / (1e-3 * 0.065 + 1e-9) - 1.0).abs() < 1e-12);
    // The mean of 0.01, 0.05 and 0.02.
    assert!((mass_matrix("triangle")[(0, 0)] - (0.065 + 0.08 / 3.0)).abs() < 1e-14);
    // Three hinges through one point: the thigh's inertia about it, and the bound of two links (the yaw hinge moves
    // neither of them).
    let about = |i: f64, a: f64, b: f64| i + a * a + b * b;
    let m = mass_matrix("virtual-links");
    let diagonal = [about(0.02, 0.0, 0.25) + 2e-9, about(0.02, 0.05, 0.25) + 1e-9, about(0.005, 0.05, 0.0)];
    for (i, wanted) in diagonal.into_iter().enumerate() {
        assert!((m[(i, i)] - wanted).abs() < 1e-14, "{i}: {} {wanted}", m[(i, i)]);
    }
}

#[test]
fn what_stays_without_a_limit() {
    let robot = loaded("no-limits");
    for joint in &robot.joints {
        assert_eq!(
            (joint.limits.lower, joint.limits.upper),
            (f64::NEG_INFINITY, f64::INFINITY),
            "{}",
            joint.name
        );
    }
    assert_eq!(robot.joints[0].limits, JointLimits::NONE);
    assert_eq!((robot.joints[2].limits.effort, robot.joints[2].limits.velocity), (35.0, 20.0));
}

#[test]
fn a_single_limit_keeps_the_default_of_the_other() {
    let urdf = leg().replacen("lower=\"-2\" ", "", 1);
    let robot = Robot::from_urdf(&urdf, "r.urdf", None).expect("good");
    assert_eq!((robot.joints[0].limits.lower, robot.joints[0].limits.upper), (0.0, 2.0));
    // An infinite limit is none.
    let urdf = leg().replacen("lower=\"-2\"", "lower=\"-inf\"", 1);
    let robot = Robot::from_urdf(&urdf, "r.urdf", None).expect("good");
    assert_eq!((robot.joints[0].limits.lower, robot.joints[0].limits.upper), (f64::NEG_INFINITY, 2.0));
}

#[test]
fn a_clearly_negative_moment_is_another_matrix() {
    let urdf = leg().replacen("ixx=\"0.02\"", "ixx=\"-0.02\"", 3);
    let (line, element, fault) = refusal(&urdf);
    assert_eq!((line, element.as_str()), (Some(3), "link 'thigh' inertial inertia"));
    assert!(matches!(fault, RobotFault::ImpossibleInertia(_, "each must be positive")), "{fault}");
    // The base never turns: its inertia counts for nothing.
    assert!(Robot::from_urdf(&leg().replacen("ixx=\"0.02\"", "ixx=\"-0.02\"", 1), "r.urdf", None).is_ok());
}

#[test]
fn a_hundred_thousand_elements_inside_each_other_are_refused() {
    let deep =
        |tag: &str| format!("{}{}", format!("<{tag}>").repeat(100_000), format!("</{tag}>").repeat(100_000));
    for inside in [deep("link"), deep("gazebo"), deep("robot")] {
        let (line, element, fault) = refusal(&robot(&inside));
        assert_eq!((line, element.as_str()), (Some(2), "URDF"));
        assert_eq!(fault, RobotFault::NestedTooDeep(256));
    }
    // Cut short, nobody closes them.
    let (_, _, fault) = refusal(&format!("<robot name=\"r\">\n{}", "<link>".repeat(100_000)));
    assert!(matches!(fault, RobotFault::NotXml(_)), "{fault}");
}

#[test]
fn a_robot_starts_within_its_limits() {
    let urdf = leg().replacen("lower=\"-2\" upper=\"2\"", "lower=\"-2\" upper=\"-0.4\"", 1);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("leg.urdf");
    std::fs::write(&file, urdf).expect("writable");
    let (scenario, robot) = Scenario::for_robot(file.to_str().expect("plain"), &[]).expect("good");
    assert_eq!(scenario.start.posture_rad.get("hip"), Some(&-0.4));
    assert!(robot.warnings.last().is_some_and(|w| w.ends_with("'hip' at -0.4 rad")), "{:?}", robot.warnings);
    let given = ["start.posture_rad.hip=-1".to_owned()];
    let (scenario, _) = Scenario::for_robot(file.to_str().expect("plain"), &given).expect("good");
    assert_eq!(scenario.start.posture_rad.get("hip"), Some(&-1.0));
}

#[test]
fn analytic_a_mass_of_zero_is_no_body_by_itself() {
    let nothing = Inertial { mass_kg: 0.0, com: Point3::origin(), inertia: Matrix3::identity() };
    assert!(!nothing.is_physical());
}
