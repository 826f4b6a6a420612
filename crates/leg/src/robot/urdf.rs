//! From URDF text to a robot without actuators: urdf-rs reads the values, the checks are ours.

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Point3, SymmetricEigen, Translation3, Unit, UnitQuaternion, Vector3};
use urdf_rs::JointType;

use super::tree::{self, Edge};
use super::xml::{self, Survey};
use super::{
    Geometry, Inertial, Joint, JointKind, JointLimits, Link, Robot, RobotFault, Shape, Source, mesh,
};
use crate::LegError;
use crate::error::nearest;

impl Robot {
    /// A robot without actuators from URDF text. `file` is what messages call it, `folder` is where meshes
    /// are looked for.
    ///
    /// Lengths are metres, angles radians. A floating or planar joint is left out, with a warning, where it
    /// only ties an empty root link to the robot (the scenario says how the base is held); anywhere else it
    /// is an error, for without it the robot would be another one. `mimic` is not honoured: the joint moves
    /// freely and a warning says so, as for every other element that is not read.
    ///
    /// # Errors
    ///
    /// [`LegError::Robot`] with file, line and element.
    pub fn from_urdf(text: &str, file: &str, folder: Option<&Path>) -> Result<Self, LegError> {
        let survey = xml::survey(text, file)?;
        let urdf = urdf_rs::read_from_string(text).map_err(|e| LegError::Robot {
            file: file.to_owned(),
            line: None,
            element: "URDF".to_owned(),
            fault: Box::new(RobotFault::NotUrdf(e.to_string())),
        })?;
        let mut reader = Reader { file, folder, survey, urdf };
        reader.drop_base_joint()?;
        reader.robot()
    }
}

struct Reader<'a> {
    file: &'a str,
    folder: Option<&'a Path>,
    survey: Survey,
    urdf: urdf_rs::Robot,
}

impl Reader<'_> {
    /// An error at `element`, at the line of `part` of it, or of the element itself.
    fn error(&self, element: &str, part: &str, fault: RobotFault) -> LegError {
        let whole = format!("{element} {part}");
        let whole = whole.trim_end();
        LegError::Robot {
            file: self.file.to_owned(),
            line: self.survey.line(whole).or_else(|| self.survey.line(element)),
            element: whole.to_owned(),
            fault: Box::new(fault),
        }
    }

    fn warn(&mut self, element: &str, what: &str) {
        let line = self.survey.line(element).map_or_else(String::new, |l| format!(":{l}"));
        self.survey.warnings.push(format!("{}{line}: {element}: {what}", self.file));
    }

    fn link_index(&self, joint: &str, name: &str) -> Result<usize, LegError> {
        self.urdf.links.iter().position(|l| l.name == name).ok_or_else(|| {
            let suggestion = nearest(name, self.urdf.links.iter().map(|l| l.name.as_str()));
            let fault = RobotFault::UnknownLink { name: name.to_owned(), suggestion };
            self.error(&format!("joint '{joint}'"), "", fault)
        })
    }

    /// Leaves out a floating or planar joint between an empty root and the robot.
    fn drop_base_joint(&mut self) -> Result<(), LegError> {
        let loose = |j: &urdf_rs::Joint| {
            matches!(j.joint_type, JointType::Floating | JointType::Planar | JointType::Spherical)
        };
        while let Some(index) = self.urdf.joints.iter().position(loose) {
            let joint = self.urdf.joints[index].clone();
            let root = joint.parent.link.clone();
            let kind = format!("{:?}", joint.joint_type).to_lowercase();
            let empty = |l: &urdf_rs::Link| {
                l.name == root
                    && l.visual.is_empty()
                    && l.collision.is_empty()
                    && !self.survey.inertials.contains(&l.name)
            };
            let uses = self.urdf.joints.iter().filter(|j| j.parent.link == root || j.child.link == root);
            if kind == "spherical" || uses.count() > 1 || !self.urdf.links.iter().any(empty) {
                let fault = RobotFault::UnsupportedJoint(kind);
                return Err(self.error(&format!("joint '{}'", joint.name), "", fault));
            }
            self.urdf.joints.remove(index);
            self.urdf.links.retain(|l| l.name != root);
            let what = format!(
                "the {kind} joint and the empty link '{root}' are left out: the scenario says how '{}' is held",
                joint.child.link
            );
            self.warn(&format!("joint '{}'", joint.name), &what);
        }
        Ok(())
    }

    fn robot(&mut self) -> Result<Robot, LegError> {
        let edges = (self.urdf.joints.iter())
            .map(|j| {
                let parent = self.link_index(&j.name, &j.parent.link)?;
                let child = self.link_index(&j.name, &j.child.link)?;
                Ok(Edge { name: j.name.clone(), parent, child })
            })
            .collect::<Result<Vec<_>, LegError>>()?;
        let names: Vec<&str> = self.urdf.links.iter().map(|l| l.name.as_str()).collect();
        let (root, carriers) =
            tree::order(&names, &edges).map_err(|(element, fault)| self.error(&element, "", fault))?;

        let urdf_links: Vec<usize> =
            std::iter::once(root).chain(carriers.iter().map(|j| edges[*j].child)).collect();
        let mut place = vec![0; urdf_links.len()];
        urdf_links.iter().enumerate().for_each(|(new, old)| place[*old] = new);
        let links = urdf_links.iter().map(|l| self.link(*l)).collect::<Result<Vec<_>, _>>()?;
        let mut joints = Vec::with_capacity(carriers.len());
        let mut dofs = 0;
        for index in carriers {
            let mut joint = self.joint(index)?;
            joint.parent = place[edges[index].parent];
            joint.child = place[edges[index].child];
            if joint.kind != JointKind::Fixed {
                joint.dof = Some(dofs);
                dofs += 1;
            }
            joints.push(joint);
        }
        self.check_moved_mass(&links, &joints)?;
        Ok(Robot {
            name: self.urdf.name.clone(),
            links,
            joints,
            dofs,
            actuators: Vec::new(),
            warnings: std::mem::take(&mut self.survey.warnings),
            source: Source::Text(self.file.to_owned()),
        })
    }

    /// A moving joint without any mass behind it has no equation of motion.
    fn check_moved_mass(&self, links: &[Link], joints: &[Joint]) -> Result<(), LegError> {
        let mut behind: Vec<bool> = links.iter().map(|l| l.inertial.is_some()).collect();
        for joint in joints.iter().rev() {
            if joint.dof.is_some() && !behind[joint.child] {
                let missing = RobotFault::Missing("the mass of what this joint moves".to_owned());
                return Err(self.error(&format!("joint '{}'", joint.name), "", missing));
            }
            behind[joint.parent] |= behind[joint.child];
        }
        Ok(())
    }

    fn link(&mut self, index: usize) -> Result<Link, LegError> {
        let link = self.urdf.links[index].clone();
        let element = format!("link '{}'", link.name);
        let inertial = match self.survey.inertials.contains(&link.name) {
            true => Some(self.inertial(&element, &link.inertial)?),
            false => None,
        };
        let (mut visuals, mut collisions) = (Vec::new(), Vec::new());
        for v in &link.visual {
            let color = self.color(&element, v.material.as_ref());
            visuals.extend(self.shape(
                &element,
                "visual",
                v.name.as_deref(),
                &v.origin,
                &v.geometry,
                color,
            )?);
        }
        for c in &link.collision {
            let shape = self.shape(&element, "collision", c.name.as_deref(), &c.origin, &c.geometry, None)?;
            collisions.extend(shape);
        }
        Ok(Link { name: link.name, inertial, visuals, collisions })
    }

    fn inertial(&self, element: &str, inertial: &urdf_rs::Inertial) -> Result<Inertial, LegError> {
        let mass_kg = inertial.mass.value;
        if mass_kg <= 0.0 {
            let fault = RobotFault::BadValue { value: mass_kg, admitted: "positive" };
            return Err(self.error(element, "inertial mass", fault));
        }
        let i = &inertial.inertia;
        let inertia = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        let mut moments: [f64; 3] = SymmetricEigen::new(inertia).eigenvalues.into();
        moments.sort_by(f64::total_cmp);
        let impossible = if moments[0] <= 0.0 {
            Some("each must be positive")
        } else if moments[2] > (moments[0] + moments[1]) * (1.0 + Inertial::TRIANGLE_TOLERANCE) {
            Some("the largest exceeds the sum of the other two")
        } else {
            None
        };
        if let Some(why) = impossible {
            let fault = RobotFault::ImpossibleInertia(moments, why);
            return Err(self.error(element, "inertial inertia", fault));
        }
        let link_from_inertial = pose(&inertial.origin);
        let r = link_from_inertial.rotation.to_rotation_matrix();
        Ok(Inertial {
            mass_kg,
            com: Point3::from(link_from_inertial.translation.vector),
            inertia: r * inertia * r.transpose(),
        })
    }

    /// The colour of a material, which may be defined elsewhere under its name.
    fn color(&mut self, element: &str, material: Option<&urdf_rs::Material>) -> Option<[f64; 4]> {
        let material = material?;
        let named = || self.urdf.materials.iter().find(|m| m.name == material.name)?.color.as_ref();
        let color = material.color.as_ref().or_else(named).map(|c| *c.rgba);
        if color.is_none() {
            self.warn(element, &format!("the material '{}' has no colour", material.name));
        }
        color
    }

    fn shape(
        &mut self,
        element: &str,
        part: &str,
        name: Option<&str>,
        origin: &urdf_rs::Pose,
        geometry: &urdf_rs::Geometry,
        color: Option<[f64; 4]>,
    ) -> Result<Option<Shape>, LegError> {
        let positive = |sizes: &[f64]| match sizes.iter().find(|s| **s <= 0.0) {
            Some(bad) => {
                let fault = RobotFault::BadValue { value: *bad, admitted: "positive" };
                Err(self.error(element, &format!("{part} geometry"), fault))
            }
            None => Ok(()),
        };
        let geometry = match *geometry {
            urdf_rs::Geometry::Box { size } => {
                positive(&*size)?;
                Geometry::Box { half: size.map(|s| 0.5 * s) }
            }
            urdf_rs::Geometry::Cylinder { radius, length } => {
                positive(&[radius, length])?;
                Geometry::Cylinder { radius_m: radius, length_m: length }
            }
            urdf_rs::Geometry::Capsule { radius, length } => {
                positive(&[radius, length])?;
                Geometry::Capsule { radius_m: radius, length_m: length }
            }
            urdf_rs::Geometry::Sphere { radius } => {
                positive(&[radius])?;
                Geometry::Sphere { radius_m: radius }
            }
            urdf_rs::Geometry::Mesh { ref filename, scale } => {
                let scale = scale.map_or([1.0; 3], |s| *s);
                let read = mesh::load(filename, scale, self.folder);
                match read.map_err(|f| self.error(element, &format!("{part} geometry"), f))? {
                    Some(mesh) => Geometry::Mesh(mesh),
                    None => {
                        let what =
                            format!("the {part} mesh '{filename}' is neither STL nor OBJ and is left out");
                        self.warn(element, &what);
                        return Ok(None);
                    }
                }
            }
        };
        Ok(Some(Shape { name: name.unwrap_or_default().to_owned(), origin: pose(origin), geometry, color }))
    }

    fn joint(&mut self, index: usize) -> Result<Joint, LegError> {
        let joint = self.urdf.joints[index].clone();
        let element = format!("joint '{}'", joint.name);
        let kind = match joint.joint_type {
            JointType::Fixed => JointKind::Fixed,
            JointType::Revolute => JointKind::Revolute,
            JointType::Continuous => JointKind::Continuous,
            JointType::Prismatic => JointKind::Prismatic,
            other => {
                let fault = RobotFault::UnsupportedJoint(format!("{other:?}").to_lowercase());
                return Err(self.error(&element, "", fault));
            }
        };
        let axis = match (Unit::try_new(Vector3::from(*joint.axis.xyz), 1e-9), kind) {
            (Some(axis), _) => axis,
            (None, JointKind::Fixed) => Vector3::x_axis(),
            (None, _) => return Err(self.error(&element, "axis", RobotFault::ZeroAxis)),
        };
        let limits = self.limits(&element, &joint, kind)?;
        let dynamics = joint.dynamics.unwrap_or_default();
        for value in [dynamics.damping, dynamics.friction] {
            if value < 0.0 {
                let fault = RobotFault::BadValue { value, admitted: "zero or positive" };
                return Err(self.error(&element, "dynamics", fault));
            }
        }
        Ok(Joint {
            name: joint.name,
            kind,
            parent: 0,
            child: 0,
            origin: pose(&joint.origin),
            axis,
            limits,
            damping: dynamics.damping,
            friction: dynamics.friction,
            dof: None,
        })
    }

    fn limits(
        &mut self,
        element: &str,
        joint: &urdf_rs::Joint,
        kind: JointKind,
    ) -> Result<JointLimits, LegError> {
        let given = self.survey.limits.contains(&joint.name);
        if kind == JointKind::Fixed || (kind == JointKind::Continuous && !given) {
            return Ok(JointLimits::NONE);
        }
        if !given {
            return Err(self.error(element, "", RobotFault::Missing("<limit>".to_owned())));
        }
        let limit = &joint.limit;
        for value in [limit.effort, limit.velocity] {
            if value < 0.0 {
                let fault = RobotFault::BadValue { value, admitted: "zero or positive" };
                return Err(self.error(element, "limit", fault));
            }
        }
        // A zero that exporters write where nothing is known would lock the joint.
        let mut positive = |value: f64, what: &str| {
            if value > 0.0 {
                return value;
            }
            self.warn(element, &format!("{what} limit 0 is read as none"));
            f64::INFINITY
        };
        let effort = positive(limit.effort, "effort");
        let velocity = positive(limit.velocity, "velocity");
        if kind == JointKind::Continuous {
            return Ok(JointLimits { effort, velocity, ..JointLimits::NONE });
        }
        let (lower, upper) = (limit.lower, limit.upper);
        if lower > upper {
            return Err(self.error(element, "limit", RobotFault::LimitsCrossed { lower, upper }));
        }
        Ok(JointLimits { lower, upper, effort, velocity })
    }
}

/// URDF's `rpy` turns about the fixed axes x, then y, then z.
fn pose(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *pose.rpy;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(*pose.xyz)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}
