//! The shipped legs: what the dissertation says of them, and that their estimated geometry works.

use nalgebra::{Isometry3, Point3};
use sealegs_leg::robot::{Drive, Geometry};

use super::*;

fn preset(name: &str) -> Robot {
    Robot::load(name, None).expect("a preset")
}

/// Every combination of `steps` values of these joints over their limits, the others in the middle.
fn grid(robot: &Robot, dofs: &[usize], steps: usize) -> Vec<Vec<f64>> {
    let limits: Vec<(f64, f64)> = robot.moving_joints().map(|j| (j.limits.lower, j.limits.upper)).collect();
    let middle: Vec<f64> = limits.iter().map(|(lower, upper)| 0.5 * (lower + upper)).collect();
    let mut postures = vec![middle];
    for &dof in dofs {
        let (lower, upper) = limits[dof];
        postures = postures
            .iter()
            .flat_map(|q| {
                (0..steps).map(move |n| {
                    let mut q = q.clone();
                    q[dof] = lower + (upper - lower) * n as f64 / (steps - 1) as f64;
                    q
                })
            })
            .collect();
    }
    postures
}

fn driven(robot: &Robot, actuator: usize) -> Vec<usize> {
    let placement = &robot.actuators[actuator];
    let between = robot.joints_between(placement.link_1, placement.link_2);
    between.iter().filter_map(|j| robot.joints[*j].dof).collect()
}

#[test]
fn published_joints_and_actuators() {
    for (name, spans) in [
        // Sections 1-1, 1-2 and 2-3: who drives what.
        ("thor-leg", &[(0, 1), (0, 1), (2, 2), (3, 3), (4, 5), (4, 5)][..]),
        ("saffir-leg", &[(0, 0), (1, 2), (1, 2), (3, 3), (4, 5), (4, 5)]),
    ] {
        let robot = preset(name);
        assert_eq!(robot.name, name);
        assert!(robot.warnings.is_empty(), "{:?}", robot.warnings);
        let joints: Vec<&str> = robot.moving_joints().map(|j| j.name.as_str()).collect();
        assert_eq!(joints, ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"]);
        assert_eq!(robot.links[0].name, "base");
        for (i, (first, last)) in spans.iter().enumerate() {
            let mut dofs = driven(&robot, i);
            dofs.sort_unstable();
            dofs.dedup();
            assert_eq!((dofs.first(), dofs.last()), (Some(first), Some(last)), "{name} {i}");
        }
    }
    for actuator in &preset("thor-leg").actuators {
        // Compliant: 372 kN/m (eq 2-9), and the published extremes of force.
        let spec = actuator.spec.as_ref().expect("an SEA");
        let stiffness = spec.coefficients().stiffness;
        assert!((stiffness / 372e3 - 1.0).abs() < 2e-3, "{} {stiffness}", actuator.name);
        let hoekens = matches!(actuator.drive, Drive::Hoekens(_));
        assert_eq!(hoekens, ["hip_pitch", "knee"].contains(&actuator.name.as_str()));
    }
    let saffir = preset("saffir-leg");
    assert!(matches!(saffir.actuators[0].drive, Drive::RigidPosition { joint: 0 }));
    for actuator in &saffir.actuators[4..] {
        // Section 2-4-3: 70 mm, 430 kN/m at the ankle.
        let stiffness = actuator.spec.as_ref().expect("an SEA").coefficients().stiffness;
        assert!((stiffness / 430e3 - 1.0).abs() < 2e-3, "{} {stiffness}", actuator.name);
    }
}

#[test]
fn published_height_and_mass_bound_the_leg() {
    // Section 1-2: 1.7 m, 60 kg. Hip height is 0.530 H by Winter; pelvis and one leg are some 30 % of M.
    let robot = preset("thor-leg");
    let sprung: f64 =
        robot.actuators.iter().filter_map(|a| a.spec.as_ref()).map(|s| s.coefficients().sprung_mass).sum();
    let mass = robot.mass_kg() + sprung;
    assert!((mass / 60.0 - 0.142 - 0.161).abs() < 0.1, "{mass}");
    let posture = robot.posture(&Isometry3::identity(), &[0.0; 6]);
    let hip = posture.world_from_link[1].translation.z;
    let sole = posture.point(robot.links.len() - 1, &Point3::new(0.0, 0.0, -0.066)).z;
    assert!(((hip - sole) / (0.530 * 1.7) - 1.0).abs() < 0.02, "{}", hip - sole);
}

#[test]
fn strokes_hold_over_the_joint_limits() {
    for name in Robot::preset_names() {
        let robot = preset(name);
        for i in 0..robot.actuators.len() {
            for q in grid(&robot, &driven(&robot, i), 9) {
                robot.check_strokes(&q, &format!("{q:?}")).expect("within the stroke");
            }
        }
        robot.check_strokes(&[0.0; 6], "zero").expect("within the stroke");
    }
}

#[test]
fn moment_arms_are_those_of_a_leg() {
    for name in Robot::preset_names() {
        let robot = preset(name);
        let at_zero = robot.moment_arms(&[0.0; 6]).expect("closes");
        for (i, placement) in robot.actuators.iter().enumerate() {
            if placement.spec.is_none() {
                continue;
            }
            for dof in driven(&robot, i) {
                let arm = at_zero[(i, dof)].abs();
                assert!((0.04..0.1).contains(&arm), "{name} {} {dof}: {arm}", placement.name);
                // Nowhere in the range does it lose half of that.
                for q in grid(&robot, &driven(&robot, i), 9) {
                    let moved = robot.lever(i, &q).expect("closes").arms[dof];
                    assert!(
                        moved / at_zero[(i, dof)] > 0.5,
                        "{name} {} {dof} {q:?}: {moved}",
                        placement.name
                    );
                }
            }
        }
        // Sign: pushing straightens the knee, which works in compression (section 2-3).
        let knee = robot.actuator_index("knee").expect("a knee");
        assert!(at_zero[(knee, 3)] < 0.0);
    }
}

#[test]
fn pairs_are_well_conditioned() {
    for (name, pairs) in
        [("thor-leg", [(0, [0, 1]), (4, [4, 5])]), ("saffir-leg", [(1, [1, 2]), (4, [4, 5])])]
    {
        let robot = preset(name);
        for (first, dofs) in pairs {
            for q in grid(&robot, &dofs, 9) {
                let arms = robot.moment_arms(&q).expect("closes");
                let pair = nalgebra::Matrix2::from_fn(|i, j| arms[(first + i, dofs[j])]);
                let s = pair.singular_values();
                // Both actuators together and against each other: neither joint is left to one of them.
                assert!(s[0] / s[1] < 2.5, "{name} {first} {q:?}: {}", s[0] / s[1]);
            }
        }
    }
}

#[test]
fn published_hoekens_arms_are_almost_constant() {
    let robot = preset("thor-leg");
    for name in ["hip_pitch", "knee"] {
        let i = robot.actuator_index(name).expect("there");
        let dof = driven(&robot, i)[0];
        let arms: Vec<f64> = grid(&robot, &[dof], 200)
            .iter()
            .map(|q| robot.lever(i, q).expect("closes").arms[dof].abs())
            .collect();
        let (least, greatest) = arms.iter().fold((f64::MAX, 0.0_f64), |(l, g), a| (l.min(*a), g.max(*a)));
        // Within 5.5 % over 160 degrees (section 2-3-3, Figure 2-6); the joints use 149 and 132 of them.
        assert!(greatest / least < 1.055, "{name}: {least} to {greatest}");
    }
}

#[test]
fn rated_efforts_follow_from_force_and_arm() {
    // URDF effort = what the published peak forces (Table 2) give at the zero posture, or on a linkage's mean arm.
    for (name, force) in [("thor-leg", 2225.0), ("saffir-leg", 1000.0)] {
        let robot = preset(name);
        let arms = robot.moment_arms(&[0.0; 6]).expect("closes");
        for joint in robot.moving_joints() {
            let dof = joint.dof.expect("moves");
            if (name, dof) == ("saffir-leg", 0) {
                continue;
            }
            let effort: f64 = (0..robot.actuators.len()).map(|i| arms[(i, dof)].abs() * force).sum();
            // SAFFiR's knee arm grows from 0.044 m at zero to 0.065 m.
            let tolerance = if joint.name == "knee" { 0.35 } else { 0.06 };
            assert!(
                (joint.limits.effort / effort - 1.0).abs() < tolerance,
                "{name} {}: {effort}",
                joint.name
            );
        }
    }
}

#[test]
fn the_sole_is_a_box_with_four_level_corners() {
    for name in Robot::preset_names() {
        let robot = preset(name);
        let foot = robot.link_index("foot").expect("a foot");
        let [sole] = &robot.links[foot].collisions[..] else { panic!("one sole") };
        let Geometry::Box { half } = sole.geometry else { panic!("a box") };
        let posture = robot.posture(&Isometry3::identity(), &[0.0; 6]);
        let mut lowest = f64::MAX;
        for shape in robot.links.iter().flat_map(|l| &l.visuals) {
            if let Geometry::Box { half } = shape.geometry {
                lowest = lowest.min(shape.origin.translation.z - half[2]);
            }
        }
        let corner = |x: f64, y: f64| {
            posture.point(foot, &(sole.origin * Point3::new(x * half[0], y * half[1], -half[2])))
        };
        let z = corner(1.0, 1.0).z;
        for (x, y) in [(1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            assert!((corner(x, y).z - z).abs() < 1e-15);
        }
        // The ankle stands over the sole, nearer to the heel.
        assert!(corner(-1.0, 0.0).x < -0.04 && corner(1.0, 0.0).x > 0.15);
        assert!(lowest.is_finite());
    }
}

#[test]
fn actuators_end_on_what_is_drawn() {
    // Each end of an actuator lies in or within 3 cm of a shape of its link, so that rods do not float.
    for name in Robot::preset_names() {
        let robot = preset(name);
        for placement in &robot.actuators {
            let Drive::Linear { point_1, point_2 } = &placement.drive else { continue };
            for (link, point) in [(placement.link_1, point_1), (placement.link_2, point_2)] {
                let gap = robot.links[link]
                    .visuals
                    .iter()
                    .map(|shape| {
                        let p = shape.origin.inverse_transform_point(point);
                        let beyond = |v: f64, half: f64| (v.abs() - half).max(0.0);
                        match shape.geometry {
                            Geometry::Box { half } => {
                                beyond(p.x, half[0]).hypot(beyond(p.y, half[1])).hypot(beyond(p.z, half[2]))
                            }
                            Geometry::Cylinder { radius_m, length_m } => {
                                beyond(p.x.hypot(p.y), radius_m).hypot(beyond(p.z, 0.5 * length_m))
                            }
                            _ => f64::MAX,
                        }
                    })
                    .fold(f64::MAX, f64::min);
                assert!(gap < 0.03, "{name} {} on {}: {gap}", placement.name, robot.links[link].name);
            }
        }
    }
}

#[test]
fn colours_differ_in_lightness_between_neighbours() {
    // What is told apart without colour: relative luminance of linked neighbours differs by a ratio of 1.3.
    let luminance = |c: [f64; 4]| 0.2126 * c[0].powf(2.2) + 0.7152 * c[1].powf(2.2) + 0.0722 * c[2].powf(2.2);
    for name in Robot::preset_names() {
        let robot = preset(name);
        for joint in &robot.joints {
            let color = |link: usize| robot.links[link].visuals[0].color.expect("coloured");
            let (a, b) = (luminance(color(joint.parent)) + 0.05, luminance(color(joint.child)) + 0.05);
            assert!(a.max(b) / a.min(b) > 1.3, "{name} {}: {a} {b}", joint.name);
        }
    }
}
