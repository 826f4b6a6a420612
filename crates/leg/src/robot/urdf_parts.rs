//! Shapes and joints of a URDF: the parts of [`super::urdf`] that look at one element at a time.

use nalgebra::{Unit, Vector3};

use super::elements::{GeometryElement, JointElement, MaterialElement, ShapeElement};
use super::urdf::Reader;
use super::{Geometry, Joint, JointKind, JointLimits, RobotFault, Shape, mesh};
use crate::LegError;

impl Reader<'_> {
    /// The shapes of a link that can be read.
    pub(super) fn shapes(
        &mut self,
        element: &str,
        part: &str,
        shapes: Vec<ShapeElement>,
    ) -> Result<Vec<Shape>, LegError> {
        let mut read = Vec::with_capacity(shapes.len());
        for shape in shapes {
            let color = self.color(element, shape.material.as_ref());
            let geometry = match shape.geometry {
                Some(geometry) => self.geometry(element, part, geometry)?,
                None => None,
            };
            read.extend(geometry.map(|geometry| Shape {
                name: shape.name,
                origin: shape.origin,
                geometry,
                color,
            }));
        }
        Ok(read)
    }

    /// The colour of a material, which may be defined elsewhere under its name.
    fn color(&mut self, element: &str, material: Option<&MaterialElement>) -> Option<[f64; 4]> {
        let material = material?;
        let named = || self.urdf.materials.iter().find(|m| m.name == material.name)?.color;
        let color = material.color.or_else(named);
        if color.is_none() {
            self.remark(element, &format!("the material '{}' has no colour", material.name));
        }
        color
    }

    fn geometry(
        &mut self,
        element: &str,
        part: &str,
        geometry: GeometryElement,
    ) -> Result<Option<Geometry>, LegError> {
        let place = format!("{part} geometry");
        let positive = |sizes: &[f64]| match sizes.iter().find(|s| **s <= 0.0) {
            Some(bad) => {
                let fault = RobotFault::BadValue { value: *bad, admitted: "positive" };
                Err(self.error(element, &place, fault))
            }
            None => Ok(()),
        };
        Ok(Some(match geometry {
            GeometryElement::Box(size) => {
                positive(&size)?;
                Geometry::Box { half: size.map(|s| 0.5 * s) }
            }
            GeometryElement::Cylinder { radius, length } => {
                positive(&[radius, length])?;
                Geometry::Cylinder { radius_m: radius, length_m: length }
            }
            GeometryElement::Capsule { radius, length } => {
                positive(&[radius, length])?;
                Geometry::Capsule { radius_m: radius, length_m: length }
            }
            GeometryElement::Sphere(radius) => {
                positive(&[radius])?;
                Geometry::Sphere { radius_m: radius }
            }
            GeometryElement::Mesh { file, scale } => {
                match mesh::load(&file, scale, self.folder, self.options) {
                    Ok(mesh) => Geometry::Mesh(mesh),
                    Err(fault) => {
                        self.mendable(element, &place, fault, "left out")?;
                        return Ok(None);
                    }
                }
            }
        }))
    }

    /// A joint by its index, its links still to be filled in.
    pub(super) fn joint(&mut self, index: usize) -> Result<Joint, LegError> {
        let name = self.urdf.joints[index].name.clone();
        let element = format!("joint '{name}'");
        if let Some(leader) = self.urdf.joints[index].mimic.clone() {
            self.mendable(&element, "mimic", RobotFault::Mimic(leader), "it moves on its own")?;
        }
        let limits = self.limits(&element, index)?;
        let joint = &self.urdf.joints[index];
        let kind = self.kind(&element, joint)?;
        let axis = match (Unit::try_new(Vector3::from(joint.axis), 1e-9), kind) {
            (Some(axis), _) => axis,
            (None, JointKind::Fixed) => Vector3::x_axis(),
            (None, _) => return Err(self.error(&element, "axis", RobotFault::ZeroAxis)),
        };
        for value in [joint.damping, joint.friction] {
            if value < 0.0 {
                let fault = RobotFault::BadValue { value, admitted: "zero or positive" };
                return Err(self.error(&element, "dynamics", fault));
            }
        }
        Ok(Joint {
            name,
            kind,
            parent: 0,
            child: 0,
            origin: joint.origin,
            axis,
            limits,
            damping: joint.damping,
            friction: joint.friction,
            dof: None,
        })
    }

    fn kind(&self, element: &str, joint: &JointElement) -> Result<JointKind, LegError> {
        Ok(match joint.kind.as_str() {
            "fixed" => JointKind::Fixed,
            "revolute" => JointKind::Revolute,
            "continuous" => JointKind::Continuous,
            "prismatic" => JointKind::Prismatic,
            other => return Err(self.error(element, "", RobotFault::UnsupportedJoint(other.to_owned()))),
        })
    }

    fn limits(&mut self, element: &str, index: usize) -> Result<JointLimits, LegError> {
        let joint = &self.urdf.joints[index];
        let kind = self.kind(element, joint)?;
        let ranged = matches!(kind, JointKind::Revolute | JointKind::Prismatic);
        let Some(limit) = joint.limit else {
            if ranged {
                self.mendable(element, "", RobotFault::Missing("<limit>".to_owned()), "it has no limits")?;
            }
            return Ok(JointLimits::NONE);
        };
        if kind == JointKind::Fixed {
            return Ok(JointLimits::NONE);
        }
        let mut most = [("effort", limit.effort), ("velocity", limit.velocity)];
        for (what, given) in &mut most {
            match *given {
                Some(value) if value < 0.0 => {
                    let fault = RobotFault::BadValue { value, admitted: "zero or positive" };
                    return Err(self.error(element, "limit", fault));
                }
                // A zero that exporters write where nothing is known would lock the joint.
                Some(0.0) => {
                    self.remark(element, &format!("{what} limit 0 is read as none"));
                    *given = None;
                }
                Some(_) => {}
                None => {
                    let missing = RobotFault::Missing(format!("attribute '{what}'"));
                    self.mendable(element, "limit", missing, "read as none")?;
                }
            }
        }
        let [effort, velocity] = most.map(|(_, given)| given.unwrap_or(f64::INFINITY));
        let (lower, upper) = match (limit.lower, limit.upper) {
            _ if !ranged => (f64::NEG_INFINITY, f64::INFINITY),
            (None, None) => {
                let missing = RobotFault::Missing("both 'lower' and 'upper'".to_owned());
                self.mendable(element, "limit", missing, "it has no limits")?;
                (f64::NEG_INFINITY, f64::INFINITY)
            }
            (Some(0.0), Some(0.0)) => {
                self.remark(element, "lower and upper limit 0 are read as none");
                (f64::NEG_INFINITY, f64::INFINITY)
            }
            // The defaults of the URDF specification.
            (lower, upper) => (lower.unwrap_or(0.0), upper.unwrap_or(0.0)),
        };
        if lower > upper {
            return Err(self.error(element, "limit", RobotFault::LimitsCrossed { lower, upper }));
        }
        Ok(JointLimits { lower, upper, effort, velocity })
    }
}
