//! The robot as moving bodies: links that are fixed to each other become one body.

use crate::robot::{Inertial, JointKind, Robot};
use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

/// A rigid body that moves as one: a link with everything that is fixed to it.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    /// The name of the link whose frame the body has.
    pub name: String,
    /// The joint that carries it; `None` for the base.
    pub joint: Option<BodyJoint>,
    /// Mass properties in the body's frame; `None` if nothing in it has mass.
    pub inertial: Option<Inertial>,
}

/// The joint between a body and its parent.
#[derive(Debug, Clone)]
pub(crate) struct BodyJoint {
    /// Index of the parent body.
    pub parent: usize,
    /// Index of the joint in the robot.
    pub joint: usize,
    /// Its degree of freedom.
    pub dof: usize,
    /// `parent_from_child` at joint position zero, between the bodies' frames.
    pub origin: Isometry3<f64>,
    /// Axis in the child's frame.
    pub axis: Unit<Vector3<f64>>,
    /// Whether it slides instead of turning.
    pub slides: bool,
}

/// The bodies in topological order and where each link is in them.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    /// The bodies; the first is the base.
    pub bodies: Vec<Body>,
    /// For each link its body and `body_from_link`.
    pub links: Vec<(usize, Isometry3<f64>)>,
}

impl Tree {
    /// Joins the links of the robot that cannot move against each other.
    pub fn new(robot: &Robot) -> Self {
        let root = &robot.links[0];
        let mut bodies = vec![Body { name: root.name.clone(), joint: None, inertial: root.inertial.clone() }];
        let mut links = vec![(0, Isometry3::identity())];
        for (i, joint) in robot.joints.iter().enumerate() {
            let link = &robot.links[joint.child];
            let (parent, body_from_parent) = links[joint.parent];
            let origin = body_from_parent * joint.origin;
            match joint.dof {
                None => {
                    let merged = match (&bodies[parent].inertial, &link.inertial) {
                        (a, None) => a.clone(),
                        (None, Some(b)) => Some(b.seen_from(&origin)),
                        (Some(a), Some(b)) => Some(a.joined_with(&b.seen_from(&origin))),
                    };
                    bodies[parent].inertial = merged;
                    links.push((parent, origin));
                }
                Some(dof) => {
                    bodies.push(Body {
                        name: link.name.clone(),
                        joint: Some(BodyJoint {
                            parent,
                            joint: i,
                            dof,
                            origin,
                            axis: joint.axis,
                            slides: joint.kind == JointKind::Prismatic,
                        }),
                        inertial: link.inertial.clone(),
                    });
                    links.push((bodies.len() - 1, Isometry3::identity()));
                }
            }
        }
        Self { bodies, links }
    }

    /// Puts a point mass, kg, on a link's point (link frame, m); a negative mass is taken out.
    pub fn add_point_mass(&mut self, link: usize, mass_kg: f64, point: &Point3<f64>) {
        let (body, body_from_link) = self.links[link];
        let point = body_from_link * point;
        let inertial = &mut self.bodies[body].inertial;
        *inertial = Some(match inertial {
            Some(i) => i.with_point_mass(mass_kg, &point),
            None => Inertial { mass_kg, com: point, inertia: Matrix3::zeros() },
        });
    }

    /// A point of a link in its body's frame.
    pub fn in_body(&self, link: usize, point: &Point3<f64>) -> (usize, Point3<f64>) {
        let (body, body_from_link) = self.links[link];
        (body, body_from_link * point)
    }
}
