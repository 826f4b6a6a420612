//! Damaged scenarios, robots and placements: whatever the text, reading ends soon with something that can be
//! simulated without panic, or with a message that names the file.

use nalgebra::Isometry3;
use proptest::prelude::*;
use sealegs_damage::{cases, damaged, survives};
use sealegs_leg::robot::{LoadOptions, Robot};
use sealegs_leg::scenario::{Scenario, preset_names, preset_text};
use sealegs_leg::{Channels, LegError, run_robot};

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8_lossy(&bytes).into_owned()
}

fn names(files: &[&str], error: &LegError) {
    let message = error.to_string();
    assert!(files.iter().any(|f| message.contains(f)), "{message:?}");
}

/// A few steps of the scenario with this robot; a state that runs away is an error, not a panic.
fn simulate(scenario: &Scenario, robot: Robot) {
    let short = Scenario { duration_s: 5.0 * scenario.step_s, ..scenario.clone() };
    let _ = run_robot(&short, robot, &mut Channels::default());
}

fn robot(urdf: &str, placement: &str) -> Result<Robot, LegError> {
    Robot::from_urdf(urdf, "own.urdf", None)?.with_placement(placement, "own.actuators.toml", None)
}

/// Meshes by the ending of their files.
const MESHES: [(&str, &[u8]); 3] = [
    ("stl", b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n"),
    ("obj", b"o s\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -4 -3 -2\n"),
    ("dae", include_bytes!("robot/faults/plate.dae")),
];

/// Robots without actuators, each with a fault of its own beside what damage does to it.
const ROBOTS: [&str; 12] = [
    include_str!("../../../assets/robots/thor-leg.urdf"),
    include_str!("../../../assets/robots/saffir-leg.urdf"),
    include_str!("robot/faults/floating-base.urdf"),
    include_str!("robot/faults/massless-frames.urdf"),
    include_str!("robot/faults/massless-leaf.urdf"),
    include_str!("robot/faults/mimic.urdf"),
    include_str!("robot/faults/missing-meshes.urdf"),
    include_str!("robot/faults/no-limits.urdf"),
    include_str!("robot/faults/point-mass.urdf"),
    include_str!("robot/faults/rounded-inertia.urdf"),
    include_str!("robot/faults/triangle.urdf"),
    include_str!("robot/faults/virtual-links.urdf"),
];

fn some_robot() -> impl Strategy<Value = Vec<u8>> {
    (0..ROBOTS.len()).prop_flat_map(|i| damaged(ROBOTS[i].as_bytes()))
}

fn some_preset() -> impl Strategy<Value = Vec<u8>> {
    (0..preset_names().len()).prop_flat_map(|i| damaged(preset_text(preset_names()[i]).unwrap().as_bytes()))
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn a_damaged_scenario_is_simulated_or_refused(bytes in some_preset()) {
        survives(move || match Scenario::from_toml(&text(bytes), "own.toml", &[]) {
            Ok(scenario) => {
                assert!(scenario.duration_s / scenario.step_s <= 1e8);
                if let Ok(robot) = Robot::load(&scenario.robot, None) {
                    simulate(&scenario, robot);
                }
            }
            Err(error) => names(&["own.toml"], &error),
        });
    }

    #[test]
    fn a_damaged_robot_is_simulated_or_refused(
        bytes in damaged(Robot::preset_texts("thor-leg").unwrap().0.as_bytes())
    ) {
        survives(move || {
            let (_, placement) = Robot::preset_texts("thor-leg").unwrap();
            match robot(&text(bytes), placement) {
                Ok(robot) => simulate(&Scenario::load("thor-drop", &[]).unwrap(), robot),
                Err(error) => names(&["own.urdf", "own.actuators.toml"], &error),
            }
        });
    }

    #[test]
    fn a_damaged_urdf_is_read_or_refused(bytes in some_robot(), strict in any::<bool>()) {
        survives(move || {
            let options = LoadOptions { strict, ..LoadOptions::default() };
            match Robot::from_urdf_with(&text(bytes), "own.urdf", None, &options) {
                Ok(robot) => {
                    assert!(robot.mass_kg().is_finite() && robot.mass_kg() >= 0.0, "{} kg", robot.mass_kg());
                    let postured = robot.posture(&Isometry3::identity(), &vec![0.0; robot.joints.len()]);
                    assert_eq!(postured.world_from_link.len(), robot.links.len());
                    let _ = robot.mirrored();
                }
                Err(error) => names(&["own.urdf"], &error),
            }
        });
    }

    #[test]
    fn a_damaged_mesh_is_read_or_left_out(
        (ending, bytes) in (0..MESHES.len()).prop_flat_map(|i| {
            damaged(MESHES[i].1).prop_map(move |bytes| (MESHES[i].0, bytes))
        })
    ) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(format!("damaged.{ending}"));
        std::fs::write(&file, bytes).unwrap();
        survives(move || {
            let mesh = format!("file://{}", file.display());
            let shape = format!("<visual><geometry><mesh filename=\"{mesh}\"/></geometry></visual>");
            let urdf = format!("<robot name=\"r\"><link name=\"a\">{shape}</link></robot>");
            let robot = Robot::from_urdf(&urdf, "own.urdf", None).unwrap();
            assert_eq!(robot.links[0].visuals.len() + robot.warnings.len(), 1, "{:?}", robot.warnings);
        });
    }

    #[test]
    fn a_damaged_placement_is_simulated_or_refused(
        bytes in damaged(Robot::preset_texts("thor-leg").unwrap().1.as_bytes())
    ) {
        survives(move || {
            let (urdf, _) = Robot::preset_texts("thor-leg").unwrap();
            match robot(urdf, &text(bytes)) {
                Ok(robot) => simulate(&Scenario::load("thor-drop", &[]).unwrap(), robot),
                Err(error) => names(&["own.actuators.toml"], &error),
            }
        });
    }
}
