//! What is read from a good URDF, and what is named because it is not.

use std::f64::consts::FRAC_PI_2;

use sealegs_leg::robot::{Geometry, JointKind, Source};

use super::*;

fn read(urdf: &str) -> Robot {
    Robot::from_urdf(urdf, "r.urdf", None).expect("a good URDF")
}

#[test]
fn links_and_joints_in_topological_order() {
    // Written from the tip to the base.
    let links = ["shank", "thigh", "base"].map(link).concat();
    let robot = read(&robot(&(hinge("knee", "thigh", "shank") + &hinge("hip", "base", "thigh") + &links)));
    let names: Vec<&str> = robot.links.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["base", "thigh", "shank"]);
    for (i, joint) in robot.joints.iter().enumerate() {
        assert_eq!(joint.child, i + 1);
        assert!(joint.parent < joint.child);
        assert_eq!(joint.dof, Some(i));
    }
    assert_eq!((robot.dofs, robot.mass_kg()), (2, 6.0));
    assert_eq!(robot.source, Source::Text("r.urdf".to_owned()));
    assert!(robot.warnings.is_empty(), "{:?}", robot.warnings);
}

#[test]
fn every_kind_of_joint_with_limits_and_losses() {
    let links = ["a", "b", "c", "d", "e"].map(link).concat();
    let kinds =
        [("revolute", "a", "b"), ("continuous", "b", "c"), ("prismatic", "c", "d"), ("fixed", "d", "e")];
    let joints: String = kinds
        .iter()
        .map(|(kind, parent, child)| {
            hinge(kind, parent, child)
                .replace("\"revolute\"><", &format!("\"{kind}\"><"))
                .replace("<axis", "<dynamics damping=\"0.3\" friction=\"0.7\"/><axis")
        })
        .collect();
    let robot = read(&robot(&(links + &joints)));
    let found: Vec<JointKind> = robot.joints.iter().map(|j| j.kind).collect();
    use JointKind::{Continuous, Fixed, Prismatic, Revolute};
    assert_eq!(found, [Revolute, Continuous, Prismatic, Fixed]);
    assert_eq!(robot.dofs, 3);
    let [revolute, continuous, prismatic, fixed] = &robot.joints[..] else { panic!() };
    assert_eq!((revolute.limits.lower, revolute.limits.upper), (-2.0, 2.0));
    assert_eq!((revolute.limits.effort, revolute.limits.velocity), (100.0, 5.0));
    assert_eq!((revolute.damping, revolute.friction), (0.3, 0.7));
    assert_eq!(continuous.limits.lower, f64::NEG_INFINITY);
    assert_eq!(continuous.limits.effort, 100.0);
    assert_eq!(prismatic.limits.upper, 2.0);
    assert_eq!((fixed.dof, fixed.limits.effort), (None, f64::INFINITY));
}

#[test]
fn analytic_inertial_rotation_is_applied() {
    // A quarter turn about z swaps x and y; xy changes its sign.
    let turned = link("a")
        .replace("<mass", &format!("<origin xyz=\"1 2 3\" rpy=\"0 0 {FRAC_PI_2}\"/><mass"))
        .replace("ixx=\"0.02\"", "ixx=\"0.012\"")
        .replace("ixy=\"0\"", "ixy=\"0.001\"");
    let inertial = read(&robot(&turned)).links[0].inertial.clone().expect("has mass");
    assert_eq!(inertial.com.coords.as_slice(), [1.0, 2.0, 3.0]);
    let i = inertial.inertia;
    assert!((i[(0, 0)] - 0.02).abs() < 1e-15 && (i[(1, 1)] - 0.012).abs() < 1e-15);
    assert!((i[(0, 1)] + 0.001).abs() < 1e-15 && (i[(2, 2)] - 0.01).abs() < 1e-15);
}

#[test]
fn analytic_point_masses_go_in_and_out() {
    let body = read(&robot(&link("a"))).links[0].inertial.clone().expect("has mass");
    let point = nalgebra::Point3::new(0.0, 0.0, 0.3);
    let more = body.with_point_mass(1.0, &point);
    // 2 kg at the origin and 1 kg at 0.3 m: centre at 0.1 m; about it 2 * 0.1^2 + 1 * 0.2^2 = 0.06.
    assert!((more.com.z - 0.1).abs() < 1e-15);
    assert!((more.inertia[(0, 0)] - 0.08).abs() < 1e-15 && (more.inertia[(2, 2)] - 0.01).abs() < 1e-15);
    let back = more.with_point_mass(-1.0, &point);
    assert!((back.inertia - body.inertia).norm() < 1e-15 && back.com.coords.norm() < 1e-15);
    assert!(body.is_physical() && !body.with_point_mass(-1.9, &point).is_physical());
}

#[test]
fn shapes_and_colours() {
    let shapes = "<visual name=\"v\"><origin xyz=\"0 0 1\"/><geometry><box size=\"1 2 3\"/></geometry>\
        <material name=\"own\"><color rgba=\"1 0 0 0.5\"/></material></visual>\
        <visual><geometry><cylinder radius=\"0.1\" length=\"0.4\"/></geometry><material name=\"shared\"/></visual>\
        <visual><geometry><capsule radius=\"0.1\" length=\"0.4\"/></geometry></visual>\
        <collision><geometry><sphere radius=\"0.2\"/></geometry></collision></link>";
    let shared = "<material name=\"shared\"><color rgba=\"0 1 0 1\"/></material>";
    let robot = read(&robot(&(shared.to_owned() + &link("a").replace("</link>", shapes))));
    let [a, b, c] = &robot.links[0].visuals[..] else { panic!() };
    assert_eq!((a.name.as_str(), a.origin.translation.z), ("v", 1.0));
    assert_eq!(a.geometry, Geometry::Box { half: [0.5, 1.0, 1.5] });
    assert_eq!(a.color, Some([1.0, 0.0, 0.0, 0.5]));
    assert_eq!(b.geometry, Geometry::Cylinder { radius_m: 0.1, length_m: 0.4 });
    assert_eq!(b.color, Some([0.0, 1.0, 0.0, 1.0]));
    assert_eq!((&c.geometry, c.color), (&Geometry::Capsule { radius_m: 0.1, length_m: 0.4 }, None));
    assert_eq!(robot.links[0].collisions[0].geometry, Geometry::Sphere { radius_m: 0.2 });
    assert!(robot.warnings.is_empty());
}

#[test]
fn what_is_not_supported_is_named_with_its_line() {
    let extra = "<transmission name=\"t\"/>\n<gazebo/>\n<gazebo reference=\"a\"/>\n";
    let urdf = leg()
        .replace("</robot>", &format!("{extra}</robot>"))
        .replacen("<axis", "<mimic joint=\"knee\" multiplier=\"2\"/><axis", 1)
        .replacen("<axis", "<safety_controller k_velocity=\"1\"/><axis", 1);
    let warnings = read(&urdf).warnings;
    for wanted in [
        "r.urdf:5: joint 'hip' mimic: following joint 'knee' is not supported: it moves on its own",
        "r.urdf:5: <safety_controller> in joint 'hip' is not supported",
        "r.urdf:7: <transmission> in <robot> is not supported",
        "r.urdf:8: <gazebo> in <robot> is not supported and was not read (and 1 more)",
    ] {
        assert!(warnings.iter().any(|w| w.starts_with(wanted)), "{wanted}: {warnings:#?}");
    }
    assert_eq!(warnings.len(), 4, "{warnings:#?}");
}

#[test]
fn odd_limits_meshes_and_materials_are_named() {
    let urdf = leg().replacen("effort=\"100\"", "effort=\"0\"", 1).replacen(
        "</link>",
        "<visual><geometry><mesh filename=\"a.ply\"/></geometry><material name=\"nowhere\"/></visual></link>",
        1,
    );
    let robot = read(&urdf);
    assert_eq!(robot.joints[0].limits.effort, f64::INFINITY);
    assert!(robot.links[0].visuals.is_empty());
    let all = robot.warnings.join("\n");
    for wanted in [
        "effort limit 0 is read as none",
        "mesh 'a.ply': neither STL nor OBJ nor DAE: left out",
        "'nowhere' has no colour",
    ] {
        assert!(all.contains(wanted), "{wanted}: {all}");
    }
}

#[test]
fn a_floating_base_is_left_to_the_scenario() {
    for kind in ["floating", "planar"] {
        let world = format!(
            "<link name=\"world\"/>\n<joint name=\"free\" type=\"{kind}\"><parent link=\"world\"/><child link=\"base\"/></joint>\n"
        );
        let robot = read(&leg().replacen("<link", &format!("{world}<link"), 1));
        assert_eq!((robot.links[0].name.as_str(), robot.dofs), ("base", 2));
        assert_eq!(robot.warnings.len(), 1);
        assert!(robot.warnings[0].starts_with(&format!("r.urdf:3: joint 'free': the {kind} joint")));
    }
}
