//! SDF 1.9: links with inertias and shapes, joints with damping, friction, limits and a spring about zero.

use crate::Exported;
use crate::rigid::{RigidJoint, RigidRobot};
use crate::text::{escaped, num, nums, xml_head};
use nalgebra::Isometry3;
use sealegs_leg::robot::{Geometry, JointKind, Link, Shape};
use std::fmt::Write;

pub fn write(robot: &RigidRobot, _stem: &str) -> Exported {
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    out.push_str(&xml_head(&format!("{} as SDF, written by sealegs", robot.title), &robot.notes));
    let o = &mut out;
    let _ = writeln!(o, "<sdf version=\"1.9\">\n  <model name=\"{}\">", escaped(&robot.name));
    let _ = writeln!(
        o,
        "    <joint name=\"to_world\" type=\"fixed\"><parent>world</parent><child>{}</child></joint>",
        escaped(&robot.links[0].name)
    );
    for (i, link) in robot.links.iter().enumerate() {
        let carrier = robot.joints.iter().find(|j| j.child == i);
        write_link(o, link, carrier, &robot.root);
    }
    for joint in &robot.joints {
        write_joint(o, robot, joint);
    }
    out.push_str("  </model>\n</sdf>\n");
    Exported { text: out, beside: Vec::new(), notes: robot.notes.clone() }
}

/// A link's pose is that of the joint that carries it.
fn write_link(o: &mut String, link: &Link, carrier: Option<&RigidJoint>, root: &Isometry3<f64>) {
    let _ = writeln!(o, "    <link name=\"{}\">", escaped(&link.name));
    match carrier {
        Some(joint) => {
            let _ = writeln!(o, "      <pose relative_to=\"{}\">0 0 0 0 0 0</pose>", escaped(&joint.name));
        }
        None => {
            let _ = writeln!(o, "      <pose>{}</pose>", pose(root));
        }
    }
    if let Some(i) = &link.inertial {
        let m = &i.inertia;
        let _ = writeln!(
            o,
            "      <inertial><pose>{} 0 0 0</pose><mass>{}</mass><inertia><ixx>{}</ixx><ixy>{}</ixy><ixz>{}</ixz><iyy>{}</iyy>\
             <iyz>{}</iyz><izz>{}</izz></inertia></inertial>",
            nums(i.com.coords.as_slice()),
            num(i.mass_kg),
            num(m[(0, 0)]),
            num(m[(0, 1)]),
            num(m[(0, 2)]),
            num(m[(1, 1)]),
            num(m[(1, 2)]),
            num(m[(2, 2)])
        );
    }
    for (tag, shapes) in [("visual", &link.visuals), ("collision", &link.collisions)] {
        for (n, shape) in shapes.iter().enumerate() {
            let _ = writeln!(
                o,
                "      <{tag} name=\"{tag}_{n}\"><pose>{}</pose><geometry>{}</geometry></{tag}>",
                pose(&shape.origin),
                geometry(shape)
            );
        }
    }
    let _ = writeln!(o, "    </link>");
}

fn write_joint(o: &mut String, robot: &RigidRobot, j: &RigidJoint) {
    let kind = match j.kind {
        JointKind::Fixed => "fixed",
        JointKind::Prismatic => "prismatic",
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
    };
    let (parent, child) = (escaped(&robot.links[j.parent].name), escaped(&robot.links[j.child].name));
    let _ = writeln!(
        o,
        "    <joint name=\"{}\" type=\"{kind}\">\n      <pose relative_to=\"{parent}\">{}</pose>\n      <parent>{parent}</parent>\n      \
         <child>{child}</child>",
        escaped(&j.name),
        pose(&j.origin)
    );
    if kind != "fixed" {
        let limits = [
            ("lower", j.limits.lower),
            ("upper", j.limits.upper),
            ("effort", j.limits.effort),
            ("velocity", j.limits.velocity),
        ];
        // What is not stated is not limited.
        let limits: String = (limits.iter().filter(|(_, v)| v.is_finite()))
            .map(|(tag, v)| format!("<{tag}>{}</{tag}>", num(*v)))
            .collect();
        let spring = j.drive.map_or(0.0, |d| d.spring);
        let spring = match spring {
            0.0 => String::new(),
            k => format!(
                "<spring_reference>0</spring_reference><spring_stiffness>{}</spring_stiffness>",
                num(k)
            ),
        };
        let _ = writeln!(
            o,
            "      <axis>\n        <xyz>{}</xyz>\n        <limit>{limits}</limit>\n        <dynamics><damping>{}</damping><friction>{}</friction>\
             {spring}</dynamics>\n      </axis>",
            nums(j.axis.as_slice()),
            num(j.damping),
            num(j.friction)
        );
    }
    let _ = writeln!(o, "    </joint>");
}

fn pose(at: &Isometry3<f64>) -> String {
    let (roll, pitch, yaw) = at.rotation.euler_angles();
    format!("{} {}", nums(at.translation.vector.as_slice()), nums(&[roll, pitch, yaw]))
}

fn geometry(shape: &Shape) -> String {
    match &shape.geometry {
        Geometry::Box { half } => format!("<box><size>{}</size></box>", nums(&half.map(|h| 2.0 * h))),
        Geometry::Cylinder { radius_m, length_m } => {
            format!(
                "<cylinder><radius>{}</radius><length>{}</length></cylinder>",
                num(*radius_m),
                num(*length_m)
            )
        }
        Geometry::Capsule { radius_m, length_m } => {
            format!(
                "<capsule><radius>{}</radius><length>{}</length></capsule>",
                num(*radius_m),
                num(*length_m)
            )
        }
        Geometry::Sphere { radius_m } => format!("<sphere><radius>{}</radius></sphere>", num(*radius_m)),
        Geometry::Mesh(mesh) => format!("<mesh><uri>{}</uri></mesh>", escaped(&mesh.file)),
    }
}
