//! Poses, lengths and moment arms against geometry by hand and finite differences.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use super::*;

/// Postures spread over the joint limits by a fixed irrational step.
fn postures(robot: &Robot, count: usize) -> Vec<Vec<f64>> {
    let share = |n: usize, dof: usize| (0.5 + (n + 1) as f64 * 0.618_033_988_75 * (dof + 1) as f64).fract();
    (0..count)
        .map(|n| {
            robot
                .moving_joints()
                .enumerate()
                .map(|(dof, j)| j.limits.lower + share(n, dof) * (j.limits.upper - j.limits.lower))
                .collect()
        })
        .collect()
}

fn somewhere() -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(0.3, -0.7, 1.1),
        UnitQuaternion::from_euler_angles(0.2, -0.4, 2.0),
    )
}

#[test]
fn analytic_poses_of_a_plane_leg() {
    let robot = Robot::from_urdf(&leg(), "r.urdf", None).expect("good");
    for (hip, knee) in [(0.0, 0.0), (-0.6, 1.1), (0.4, 0.2)] {
        let base = somewhere();
        let posture = robot.posture(&base, &[hip, knee]);
        // A link at pitch a points along (-sin a, 0, -cos a): positive pitch swings it backward.
        let along = |a: f64| Vector3::new(-a.sin(), 0.0, -a.cos());
        let knee_at = Vector3::new(0.0, 0.0, -0.5) + 0.5 * along(hip);
        let tip = knee_at + 0.3 * along(hip + knee);
        let found = posture.point(2, &Point3::new(0.0, 0.0, -0.3));
        assert!((found - base * Point3::from(tip)).norm() < 1e-15);
    }
}

#[test]
fn analytic_poses_of_a_slide_on_a_turn() {
    let slide =
        hinge("slide", "base", "thigh").replace("\"revolute\"", "\"prismatic\"").replace("0 1 0", "0 0 2");
    let turn =
        hinge("turn", "thigh", "shank").replace("0 0 -0.5\"", "1 0 0\" rpy=\"0 0 1.5707963267948966\"");
    let urdf = robot(&(["base", "thigh", "shank"].map(link).concat() + &slide + &turn));
    let robot = Robot::from_urdf(&urdf, "r.urdf", None).expect("good");
    let posture = robot.posture(&Isometry3::identity(), &[0.2, 0.3]);
    // The axis is a direction: 0.2 m along z; then 1 m in x; the turned y axis is -x of the world.
    let found = posture.point(2, &Point3::new(0.0, 0.0, 1.0));
    let wanted = Point3::new(1.0, 0.3_f64.sin(), -0.3 + 0.3_f64.cos());
    assert!((found - wanted).norm() < 1e-15, "{found}");
}

#[test]
fn analytic_arm_of_a_rod_over_a_hinge() {
    let text = "[[actuator]]\nname = \"k\"\nkind = \"linear\"\nactuator = \"thor-linear\"\nlink_1 = \"thigh\"\n\
        point_1_m = [0, 0, -0.2]\nlink_2 = \"shank\"\npoint_2_m = [0.04, 0, 0]\n";
    let robot =
        Robot::from_urdf(&leg(), "r", None).expect("good").with_placement(text, "t", None).expect("good");
    for knee in [-0.5_f64, 0.0, 0.7] {
        // Triangle of sides 0.3 (knee to point 1, straight up) and 0.04 (forward, down by the knee angle).
        let gamma = std::f64::consts::FRAC_PI_2 + knee;
        let length = (0.3_f64.powi(2) + 0.04_f64.powi(2) - 2.0 * 0.3 * 0.04 * gamma.cos()).sqrt();
        let arm = 0.3 * 0.04 * gamma.sin() / length;
        let lever = robot.lever(0, &[0.9, knee]).expect("closes");
        assert!((lever.length_m - length).abs() < 1e-15 && (lever.arms[1] - arm).abs() < 1e-15);
        // The hip is not between the links.
        assert_eq!(lever.arms[0], 0.0);
        let posture = robot.posture(&somewhere(), &[0.9, knee]);
        let ends = robot.attachment(0, &posture, &[0.9, knee]).expect("closes").expect("a rod");
        assert!(((ends[1] - ends[0]).norm() - length).abs() < 1e-14);
    }
    assert_eq!(robot.joints_between(2, 1), [1]);
    assert_eq!(robot.joints_between(0, 2), [1, 0]);
}

#[test]
fn gradients_are_finite_differences_of_lengths() {
    for name in Robot::preset_names() {
        let robot = Robot::load(name, None).expect("a preset");
        for q in postures(&robot, 40) {
            let arms = robot.moment_arms(&q).expect("closes");
            for (i, placement) in robot.actuators.iter().enumerate() {
                for dof in 0..robot.dofs {
                    let at = |step: f64| {
                        let mut moved = q.clone();
                        moved[dof] += step;
                        robot.lever(i, &moved).expect("closes").length_m
                    };
                    // Fourth order: error h^4 x''''' / 30 about 1e-14, rounding 1e-16 / h about 1e-13.
                    let h = 1e-3;
                    let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
                    let error = (arms[(i, dof)] - slope).abs();
                    assert!(error < 1e-8, "{name} {} dof {dof}: {error:e}", placement.name);
                }
            }
        }
    }
}

#[test]
fn the_mirrored_leg_mirrors_points_lengths_and_arms() {
    let flip = |p: Point3<f64>| Point3::new(p.x, -p.y, p.z);
    for name in Robot::preset_names() {
        let left = Robot::load(name, None).expect("a preset");
        let right = left.mirrored();
        for q in postures(&left, 10) {
            let (l, r) =
                (left.posture(&Isometry3::identity(), &q), right.posture(&Isometry3::identity(), &q));
            for i in 0..left.links.len() {
                let corner = Point3::new(0.1, 0.2, 0.3);
                assert!((flip(l.point(i, &corner)) - r.point(i, &flip(corner))).norm() < 1e-15);
                let com = |robot: &Robot| robot.links[i].inertial.as_ref().expect("has mass").com;
                assert!((flip(l.point(i, &com(&left))) - r.point(i, &com(&right))).norm() < 1e-15);
            }
            let arms = |robot: &Robot| robot.moment_arms(&q).expect("closes");
            assert!((arms(&left) - arms(&right)).norm() < 1e-14);
            for i in 0..left.actuators.len() {
                let ends = |robot: &Robot, posture| robot.attachment(i, posture, &q).expect("closes");
                let (Some(a), Some(b)) = (ends(&left, &l), ends(&right, &r)) else { continue };
                assert!((flip(a[0]) - b[0]).norm() < 1e-15 && (flip(a[1]) - b[1]).norm() < 1e-15);
            }
        }
        // Twice mirrored is the same robot but for its name.
        let mut again = right.mirrored();
        again.name.clone_from(&left.name);
        assert_eq!(again, left);
    }
}

#[test]
fn analytic_mirror_of_inertia_and_of_a_turned_shape() {
    let turned = link("a").replace("ixy=\"0\" ixz=\"0\"", "ixy=\"0.001\" ixz=\"0.002\"").replace(
        "</link>",
        "<visual><origin xyz=\"0.1 0.2 0.3\" rpy=\"0.3 0.4 0.5\"/><geometry><sphere radius=\"1\"/></geometry></visual></link>",
    );
    let left = Robot::from_urdf(&robot(&turned), "r", None).expect("good");
    let right = left.mirrored();
    let inertia = right.links[0].inertial.as_ref().expect("has mass").inertia;
    assert_eq!((inertia[(0, 1)], inertia[(0, 2)]), (-0.001, 0.002));
    // Roll and yaw change sign, pitch does not.
    let (roll, pitch, yaw) = right.links[0].visuals[0].origin.rotation.euler_angles();
    assert!((roll + 0.3).abs() < 1e-15 && (pitch - 0.4).abs() < 1e-15 && (yaw + 0.5).abs() < 1e-15);
}
