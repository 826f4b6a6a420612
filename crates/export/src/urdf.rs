//! URDF: links with inertias and shapes, joints with damping, friction and limits.

use crate::Exported;
use crate::rigid::{RigidJoint, RigidRobot};
use crate::text::{escaped, num, nums, xml_head};
use nalgebra::Isometry3;
use sealegs_leg::robot::{Geometry, Inertial, JointKind, Shape};
use std::fmt::Write;

/// Effort and speed of a joint that nothing limits: URDF asks for numbers.
const UNLIMITED: f64 = 1e9;

pub fn write(robot: &RigidRobot, _stem: &str) -> Exported {
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    out.push_str(&xml_head(&format!("{} as URDF, written by sealegs", robot.title), &robot.notes));
    let o = &mut out;
    let _ = writeln!(o, "<robot name=\"{}\">", escaped(&robot.name));
    for link in &robot.links {
        let _ = writeln!(o, "  <link name=\"{}\">", escaped(&link.name));
        if let Some(i) = &link.inertial {
            let _ = writeln!(o, "    {}", inertial(i));
        }
        for (tag, shapes) in [("visual", &link.visuals), ("collision", &link.collisions)] {
            for shape in shapes {
                let _ = writeln!(o, "    <{tag}>{}</{tag}>", geometry(shape));
            }
        }
        let _ = writeln!(o, "  </link>");
    }
    for j in &robot.joints {
        joint(o, robot, j);
    }
    out.push_str("</robot>\n");
    Exported { text: out, beside: Vec::new(), notes: robot.notes.clone() }
}

fn joint(o: &mut String, robot: &RigidRobot, j: &RigidJoint) {
    let limited = j.limits.lower.is_finite() && j.limits.upper.is_finite();
    let kind = match j.kind {
        JointKind::Fixed => "fixed",
        JointKind::Prismatic => "prismatic",
        JointKind::Revolute if limited => "revolute",
        JointKind::Revolute | JointKind::Continuous => "continuous",
    };
    let name = |i: usize| escaped(&robot.links[i].name);
    let _ = writeln!(
        o,
        "  <joint name=\"{}\" type=\"{kind}\">\n    {}\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>",
        escaped(&j.name),
        origin(&j.origin),
        name(j.parent),
        name(j.child)
    );
    if kind != "fixed" {
        let finite = |v: f64, otherwise: f64| num(if v.is_finite() { v } else { otherwise });
        let range = match kind {
            "continuous" => String::new(),
            _ => format!(
                " lower=\"{}\" upper=\"{}\"",
                finite(j.limits.lower, -UNLIMITED),
                finite(j.limits.upper, UNLIMITED)
            ),
        };
        let _ = writeln!(
            o,
            "    <axis xyz=\"{}\"/>\n    <limit{range} effort=\"{}\" velocity=\"{}\"/>\n    <dynamics damping=\"{}\" \
             friction=\"{}\"/>",
            nums(j.axis.as_slice()),
            finite(j.limits.effort, UNLIMITED),
            finite(j.limits.velocity, UNLIMITED),
            num(j.damping),
            num(j.friction)
        );
    }
    o.push_str("  </joint>\n");
}

fn origin(at: &Isometry3<f64>) -> String {
    let (roll, pitch, yaw) = at.rotation.euler_angles();
    format!(
        "<origin xyz=\"{}\" rpy=\"{}\"/>",
        nums(at.translation.vector.as_slice()),
        nums(&[roll, pitch, yaw])
    )
}

fn inertial(i: &Inertial) -> String {
    let m = &i.inertia;
    format!(
        "<inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" \
         izz=\"{}\"/></inertial>",
        nums(i.com.coords.as_slice()),
        num(i.mass_kg),
        num(m[(0, 0)]),
        num(m[(0, 1)]),
        num(m[(0, 2)]),
        num(m[(1, 1)]),
        num(m[(1, 2)]),
        num(m[(2, 2)])
    )
}

fn geometry(shape: &Shape) -> String {
    let of = match &shape.geometry {
        Geometry::Box { half } => format!("<box size=\"{}\"/>", nums(&half.map(|h| 2.0 * h))),
        Geometry::Cylinder { radius_m, length_m } | Geometry::Capsule { radius_m, length_m } => {
            format!("<cylinder radius=\"{}\" length=\"{}\"/>", num(*radius_m), num(*length_m))
        }
        Geometry::Sphere { radius_m } => format!("<sphere radius=\"{}\"/>", num(*radius_m)),
        Geometry::Mesh(mesh) => format!("<mesh filename=\"{}\"/>", escaped(&mesh.file)),
    };
    format!("{}<geometry>{of}</geometry>", origin(&shape.origin))
}
