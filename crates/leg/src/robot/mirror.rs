//! The other leg: a robot reflected at its x-z plane.

use nalgebra::{Isometry3, Matrix3, Point3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3};

use super::{Drive, Geometry, Inertial, JointKind, Link, Mesh, Robot, Shape};

impl Robot {
    /// The mirror image at the plane y = 0: the right leg made from the left one.
    ///
    /// Turning axes are mirrored such that the same joint positions give the mirrored posture (so that
    /// positive roll and yaw are abduction and outward turn on both sides) and limits stay as they are.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mut robot = self.clone();
        robot.name = format!("{}-mirrored", self.name);
        robot.links.iter_mut().for_each(mirror_link);
        for joint in &mut robot.joints {
            joint.origin = pose(&joint.origin);
            let axis = vector(&joint.axis);
            joint.axis = Unit::new_unchecked(match joint.kind {
                JointKind::Prismatic => axis,
                // A reflection turns a rotation by q about a into one by -q about the reflected a.
                _ => -axis,
            });
        }
        for actuator in &mut robot.actuators {
            match &mut actuator.drive {
                Drive::Linear { point_1, point_2 } => {
                    *point_1 = point(point_1);
                    *point_2 = point(point_2);
                }
                Drive::Hoekens(mount) => {
                    mount.point_1 = point(&mount.point_1);
                    mount.axis_1 = Unit::new_unchecked(vector(&mount.axis_1));
                }
                Drive::RigidPosition { .. } => {}
            }
        }
        robot
    }
}

fn vector(v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(v.x, -v.y, v.z)
}

fn point(p: &Point3<f64>) -> Point3<f64> {
    Point3::new(p.x, -p.y, p.z)
}

/// `M R M` and `M t` with `M = diag(1, -1, 1)`; the rotation's axis is a pseudovector.
fn pose(p: &Isometry3<f64>) -> Isometry3<f64> {
    let q = p.rotation.quaternion();
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(q.w, -q.i, q.j, -q.k));
    Isometry3::from_parts(Translation3::from(vector(&p.translation.vector)), rotation)
}

fn mirror_link(link: &mut Link) {
    if let Some(Inertial { com, inertia, .. }) = &mut link.inertial {
        *com = point(com);
        let m = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
        *inertia = m * *inertia * m;
    }
    for shape in link.visuals.iter_mut().chain(&mut link.collisions) {
        mirror_shape(shape);
    }
}

/// Primitives are their own mirror image; a mesh is reflected point by point.
fn mirror_shape(shape: &mut Shape) {
    shape.origin = pose(&shape.origin);
    if let Geometry::Mesh(Mesh { vertices, triangles, .. }) = &mut shape.geometry {
        vertices.iter_mut().for_each(|v| v[1] = -v[1]);
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}
