//! Robots: what is read, what is refused and how it is said, where things are, and the shipped legs.

mod assets;
mod bad_placement;
mod bad_urdf;
mod faults;
mod kinematics;
mod meshes;
mod reading;

use sealegs_leg::LegError;
use sealegs_leg::robot::{LoadOptions, Robot, RobotFault};

/// A link with sensible mass properties.
fn link(name: &str) -> String {
    format!(
        "<link name=\"{name}\"><inertial><mass value=\"2\"/>\
         <inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.01\"/></inertial></link>\n"
    )
}

/// A hinge about y, half a metre below its parent's frame.
fn hinge(name: &str, parent: &str, child: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
         <origin xyz=\"0 0 -0.5\"/><axis xyz=\"0 1 0\"/>\
         <limit lower=\"-2\" upper=\"2\" effort=\"100\" velocity=\"5\"/></joint>\n"
    )
}

/// A URDF with this inside.
fn robot(inside: &str) -> String {
    format!("<robot name=\"r\">\n{inside}</robot>\n")
}

/// Base, thigh and shank with the hinges `hip` and `knee`.
fn leg() -> String {
    let links = ["base", "thigh", "shank"].map(link).concat();
    robot(&(links + &hinge("hip", "base", "thigh") + &hinge("knee", "thigh", "shank")))
}

/// What is wrong with a URDF: line, element, fault.
fn refusal(urdf: &str) -> (Option<u32>, String, RobotFault) {
    taken_apart(Robot::from_urdf(urdf, "r.urdf", None).expect_err("must be refused"))
}

/// As [`refusal`], of what a strict reader refuses and others mend.
fn strict_refusal(urdf: &str) -> (Option<u32>, String, RobotFault) {
    let strict = LoadOptions { strict: true, ..LoadOptions::default() };
    taken_apart(Robot::from_urdf_with(urdf, "r.urdf", None, &strict).expect_err("must be refused"))
}

fn taken_apart(error: LegError) -> (Option<u32>, String, RobotFault) {
    let message = error.to_string();
    match error {
        LegError::Robot { file, line, element, fault } => {
            let place = line.map_or(file.clone(), |l| format!("{file}:{l}"));
            assert_eq!(message, format!("{place}: {element}: {fault}"));
            assert!(!message.contains('\n'), "{message}");
            (line, element, *fault)
        }
        other => panic!("{other}"),
    }
}
