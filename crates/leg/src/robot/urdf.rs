//! From URDF text to a robot without actuators: what is there, what is mended, what is refused.

use std::path::Path;

use nalgebra::{Matrix3, Point3, SymmetricEigen};

use super::elements::{self, Elements, InertialElement, LinkElement};
use super::tree::{self, Edge};
use super::xml::{self, Survey};
use super::{Inertial, JointKind, Link, LoadOptions, Robot, RobotFault, Source, mend};
use crate::LegError;
use crate::error::nearest;

/// A mass that is negative by no more than this, kg, is a rounded zero.
const ROUNDED_MASS_KG: f64 = 1e-9;

impl Robot {
    /// A robot without actuators from URDF text, its faults mended with a remark. `file` is what messages call it,
    /// `folder` is where meshes are looked for.
    ///
    /// Lengths are metres, angles radians. Each of these leaves a sentence in [`Robot::warnings`]:
    ///
    /// - A link without mass joins what it is fixed to. A body that a joint moves and that no body can be is mended
    ///   as MuJoCo's compiler does with `boundmass`, `boundinertia` and `balanceinertia`.
    /// - A joint without limits has none, whatever its type; both limits 0 are none, too.
    /// - A floating or planar joint is left out where it only ties an empty root link to the robot (the scenario
    ///   says how the base is held); anywhere else it is an error, for without it the robot would be another one.
    /// - `mimic` is not honoured: the joint moves on its own.
    /// - A mesh that is not there or cannot be read costs the picture.
    /// - Every other element that is not read.
    ///
    /// # Errors
    ///
    /// [`LegError::Robot`] with file, line and element.
    pub fn from_urdf(text: &str, file: &str, folder: Option<&Path>) -> Result<Self, LegError> {
        Self::from_urdf_with(text, file, folder, &LoadOptions::default())
    }

    /// As [`Robot::from_urdf`], with options.
    ///
    /// # Errors
    ///
    /// As [`Robot::from_urdf`], and with [`LoadOptions::strict`] whatever would be mended.
    pub fn from_urdf_with(
        text: &str,
        file: &str,
        folder: Option<&Path>,
        options: &LoadOptions,
    ) -> Result<Self, LegError> {
        let document = xml::parse(text, file)?;
        let survey = xml::survey(&document, file)?;
        let urdf = elements::read(document.root_element());
        let mut reader = Reader { file, folder, options, survey, urdf };
        reader.drop_base_joint()?;
        reader.robot()
    }
}

/// What reading a robot needs at hand.
pub(super) struct Reader<'a> {
    pub file: &'a str,
    pub folder: Option<&'a Path>,
    pub options: &'a LoadOptions,
    pub survey: Survey,
    pub urdf: Elements,
}

impl Reader<'_> {
    /// An error at `element`, at the line of `part` of it, or of the element itself.
    pub fn error(&self, element: &str, part: &str, fault: RobotFault) -> LegError {
        let whole = format!("{element} {part}");
        let whole = whole.trim_end();
        LegError::Robot {
            file: self.file.to_owned(),
            line: self.survey.line(whole).or_else(|| self.survey.line(element)),
            element: whole.to_owned(),
            fault: Box::new(fault),
        }
    }

    /// A fault that costs no more than `cost`: a remark, or the error where the file is read strictly.
    pub fn mendable(
        &mut self,
        element: &str,
        part: &str,
        fault: RobotFault,
        cost: &str,
    ) -> Result<(), LegError> {
        let error = self.error(element, part, fault);
        if self.options.strict {
            return Err(error);
        }
        self.survey.warnings.push(format!("{error}: {cost}"));
        Ok(())
    }

    /// A remark at an element.
    pub fn remark(&mut self, element: &str, what: &str) {
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
        let loose = |kind: &str| matches!(kind, "floating" | "planar");
        while let Some(index) = self.urdf.joints.iter().position(|j| loose(&j.kind)) {
            let joint = &self.urdf.joints[index];
            let (name, kind) = (joint.name.clone(), joint.kind.clone());
            let (root, child) = (joint.parent.clone(), joint.child.clone());
            let empty = |l: &LinkElement| {
                l.name == root && l.visuals.is_empty() && l.collisions.is_empty() && l.inertial.is_none()
            };
            let uses = self.urdf.joints.iter().filter(|j| j.parent == root || j.child == root);
            if uses.count() > 1 || !self.urdf.links.iter().any(empty) {
                let fault = RobotFault::UnsupportedJoint(kind);
                return Err(self.error(&format!("joint '{name}'"), "", fault));
            }
            self.urdf.joints.remove(index);
            self.urdf.links.retain(|l| l.name != root);
            let what = format!(
                "the {kind} joint and the empty link '{root}' are left out: the scenario says how '{child}' is held"
            );
            self.remark(&format!("joint '{name}'"), &what);
        }
        Ok(())
    }

    fn robot(&mut self) -> Result<Robot, LegError> {
        let edges = (self.urdf.joints.iter())
            .map(|j| {
                let parent = self.link_index(&j.name, &j.parent)?;
                let child = self.link_index(&j.name, &j.child)?;
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
        let mut elements: Vec<Option<LinkElement>> =
            std::mem::take(&mut self.urdf.links).into_iter().map(Some).collect();
        let mut links = Vec::with_capacity(urdf_links.len());
        for index in urdf_links {
            let element = elements[index].take().expect("the order names each link once");
            links.push(self.link(element)?);
        }
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
        let mut robot = Robot {
            name: std::mem::take(&mut self.urdf.name),
            links,
            joints,
            dofs,
            actuators: Vec::new(),
            warnings: Vec::new(),
            source: Source::Text(self.file.to_owned()),
        };
        self.check_masses(&mut robot)?;
        robot.warnings = std::mem::take(&mut self.survey.warnings);
        Ok(robot)
    }

    /// Every body that a joint moves needs mass and an inertia.
    fn check_masses(&mut self, robot: &mut Robot) -> Result<(), LegError> {
        if self.options.strict {
            return self.check_moved_mass(robot);
        }
        let fixed = robot.joints.iter().filter(|j| j.kind == JointKind::Fixed).map(|j| &robot.links[j.child]);
        let massless: Vec<String> = fixed
            .filter(|l| l.inertial.as_ref().is_none_or(|i| i.mass_kg == 0.0))
            .map(|l| format!("'{}'", l.name))
            .collect();
        if !massless.is_empty() {
            let links = massless.join(", ");
            let what = format!("without mass, and part of the link that they are fixed to: {links}");
            self.survey.warnings.push(format!("{}: {what}", self.file));
        }
        let remarks = mend::mend(robot).map_err(|(link, fault)| {
            self.error(&format!("link '{}'", robot.links[link].name), "inertial inertia", fault)
        })?;
        for (link, what) in remarks {
            self.remark(&format!("link '{}'", robot.links[link].name), &what);
        }
        Ok(())
    }

    /// A moving joint without any mass behind it has no equation of motion.
    fn check_moved_mass(&self, robot: &Robot) -> Result<(), LegError> {
        let mut behind: Vec<bool> = robot.links.iter().map(|l| l.inertial.is_some()).collect();
        for joint in robot.joints.iter().rev() {
            if joint.dof.is_some() && !behind[joint.child] {
                let missing = RobotFault::Missing("the mass of what this joint moves".to_owned());
                return Err(self.error(&format!("joint '{}'", joint.name), "", missing));
            }
            behind[joint.parent] |= behind[joint.child];
        }
        Ok(())
    }

    fn link(&mut self, link: LinkElement) -> Result<Link, LegError> {
        let element = format!("link '{}'", link.name);
        let inertial = match &link.inertial {
            Some(inertial) => self.inertial(&element, inertial)?,
            None => None,
        };
        let visuals = self.shapes(&element, "visual", link.visuals)?;
        let collisions = self.shapes(&element, "collision", link.collisions)?;
        Ok(Link { name: link.name, inertial, visuals, collisions })
    }

    /// The mass properties of a link as it states them; `None` where all are zero.
    fn inertial(&self, element: &str, inertial: &InertialElement) -> Result<Option<Inertial>, LegError> {
        let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let strict = self.options.strict;
        if inertial.mass_kg < -ROUNDED_MASS_KG || (strict && inertial.mass_kg <= 0.0) {
            let fault = RobotFault::BadValue { value: inertial.mass_kg, admitted: "positive" };
            return Err(self.error(element, "inertial mass", fault));
        }
        if strict && let Some(fault) = impossible(inertia) {
            return Err(self.error(element, "inertial inertia", fault));
        }
        let mass_kg = inertial.mass_kg.max(0.0);
        if mass_kg == 0.0 && inertia == Matrix3::zeros() {
            return Ok(None);
        }
        let own = Inertial { mass_kg, com: Point3::origin(), inertia };
        Ok(Some(own.seen_from(&inertial.origin)))
    }
}

/// Why no body can have this inertia, if none can.
fn impossible(inertia: Matrix3<f64>) -> Option<RobotFault> {
    let mut moments: [f64; 3] = SymmetricEigen::new(inertia).eigenvalues.into();
    moments.sort_by(f64::total_cmp);
    let why = if moments[0] <= 0.0 {
        "each must be positive"
    } else if moments[2] > (moments[0] + moments[1]) * (1.0 + Inertial::TRIANGLE_TOLERANCE) {
        "the largest exceeds the sum of the other two"
    } else {
        return None;
    };
    Some(RobotFault::ImpossibleInertia(moments, why))
}
