//! Places, inertias and shapes of links as MuJoCo writes them.

use crate::text::{num, nums};
use nalgebra::Isometry3;
use sealegs_leg::robot::{Geometry, Inertial, Robot, Shape};
use std::fmt::Write;

pub fn quat(at: &Isometry3<f64>) -> String {
    let q = at.rotation.quaternion();
    nums(&[q.w, q.i, q.j, q.k])
}

pub fn place(at: &Isometry3<f64>) -> String {
    format!("pos=\"{}\" quat=\"{}\"", nums(at.translation.vector.as_slice()), quat(at))
}

pub fn inertial(i: &Inertial) -> String {
    let m = &i.inertia;
    let full = [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]];
    format!(
        "<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>",
        nums(i.com.coords.as_slice()),
        num(i.mass_kg),
        nums(&full)
    )
}

/// A body that stands for a coordinate: it slides, and its inertia is the joint's armature.
pub fn coordinate(o: &mut String, indent: &str, name: &str, mass_kg: f64, attributes: &str) {
    let mass = num(mass_kg);
    let _ = writeln!(
        o,
        "{indent}<body name=\"{name}\">\n{indent}  <inertial pos=\"0 0 0\" mass=\"{mass}\" diaginertia=\"{mass} {mass} \
         {mass}\"/>\n{indent}  <joint name=\"{name}\" type=\"slide\" axis=\"1 0 0\"{attributes}/>\n{indent}</body>"
    );
}

pub fn geom(o: &mut String, indent: &str, shape: &Shape, more: &str) {
    let (kind, size) = match &shape.geometry {
        Geometry::Box { half } => ("box", nums(half)),
        Geometry::Cylinder { radius_m, length_m } => ("cylinder", nums(&[*radius_m, 0.5 * length_m])),
        Geometry::Capsule { radius_m, length_m } => ("capsule", nums(&[*radius_m, 0.5 * length_m])),
        Geometry::Sphere { radius_m } => ("sphere", num(*radius_m)),
        Geometry::Mesh(_) => return,
    };
    let color = shape.color.map_or_else(String::new, |c| format!(" rgba=\"{}\"", nums(&c)));
    // Inertias are stated: shapes weigh nothing.
    let _ = writeln!(
        o,
        "{indent}  <geom type=\"{kind}\" size=\"{size}\" {} mass=\"0\" {more}{color}/>",
        place(&shape.origin)
    );
}

/// Whether a link has a mesh for a shape, which a file for MuJoCo leaves out.
pub fn has_mesh(robot: &Robot) -> bool {
    let shapes = robot.links.iter().flat_map(|l| l.visuals.iter().chain(&l.collisions));
    shapes.into_iter().any(|s| matches!(s.geometry, Geometry::Mesh(_)))
}
