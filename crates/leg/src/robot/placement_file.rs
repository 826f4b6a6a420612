//! The placement file: TOML beside the URDF that says which actuator sits where.
//!
//! ```toml
//! [[actuator]]
//! name = "ankle_left"          # unique
//! kind = "linear"              # linear | hoekens | position-drive
//! actuator = "thor-linear"     # a preset, or a file seen from this one
//! spring = "compliant"         # a setting of its spring; without it the actuator file's own
//! link_1 = "shank"             # spring side
//! point_1_m = [-0.05, 0.045, -0.15]
//! link_2 = "foot"              # screw side
//! point_2_m = [-0.06, 0.045, 0.0]
//! length_m = [0.20, 0.31]      # without it the actuator's min_length_m and stroke_m
//! sprung_mass_in = "shank"     # only if that link's mass contains the sprung mass
//!
//! [[actuator]]
//! name = "knee"
//! kind = "hoekens"             # the linkage itself is in the actuator's file
//! actuator = "thor-hoekens"
//! link_1 = "thigh"             # carries the actuator
//! link_2 = "shank"             # turns with the crank
//! joint = "knee"
//! crank_angle_at_zero_rad = 1.15
//! sign = -1                    # +1: positive joint motion lengthens the actuator
//! length_mid_m = 0.33
//! point_1_m = [-0.06, 0.0, -0.07]
//! axis_1 = [0.0, 0.0, -1.0]
//!
//! [[actuator]]
//! name = "hip_yaw"
//! kind = "position-drive"      # rigid: the joint follows its command
//! joint = "hip_yaw"
//! ```

use std::path::Path;

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use sealegs_actuator::spec::LinkageSpec;
use sealegs_actuator::text::parse_toml;
use sealegs_actuator::{ActuatorError, ActuatorSpec};
use serde::Deserialize;
use toml::Spanned;

use super::{Drive, HoekensMount, LengthRange, Placement, Robot, RobotFault};
use crate::LegError;
use crate::error::nearest;

/// Attachment points closer than this are one point: no actuator is so short.
const COINCIDE_M: f64 = 1e-3;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    actuator: Vec<Spanned<Entry>>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "kebab-case")]
enum Kind {
    Linear,
    Hoekens,
    PositionDrive,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    kind: Kind,
    actuator: Option<String>,
    spring: Option<String>,
    link_1: Option<String>,
    point_1_m: Option<[f64; 3]>,
    link_2: Option<String>,
    point_2_m: Option<[f64; 3]>,
    joint: Option<String>,
    crank_angle_at_zero_rad: Option<f64>,
    sign: Option<f64>,
    length_mid_m: Option<f64>,
    axis_1: Option<[f64; 3]>,
    length_m: Option<[f64; 2]>,
    sprung_mass_in: Option<String>,
}

impl Robot {
    /// This robot with the actuators of a placement file in place of those it had. `file` is what messages
    /// call it, `folder` is where actuator files are looked for.
    ///
    /// # Errors
    ///
    /// [`LegError::Robot`] or [`LegError::Actuator`] with file and line.
    pub fn with_placement(mut self, text: &str, file: &str, folder: Option<&Path>) -> Result<Self, LegError> {
        let parsed: File = parse_toml(text, file)?;
        self.actuators.clear();
        for spanned in &parsed.actuator {
            let entry = spanned.get_ref();
            let start = spanned.span().start;
            let line = text.get(..start).map(|before| before.matches('\n').count() as u32 + 1);
            let fault = |(field, fault): (String, RobotFault)| LegError::Robot {
                file: file.to_owned(),
                line,
                element: format!("actuator '{}' {field}", entry.name).trim_end().to_owned(),
                fault: Box::new(fault),
            };
            let placement = Resolver { robot: &self, entry, folder }.placement().map_err(fault)?;
            let contained_in = placement.sprung_mass_in;
            self.actuators.push(placement);
            if let Some(link) = contained_in {
                self.without_contained(link).map_err(|f| fault(("sprung_mass_in".to_owned(), f)))?;
            }
        }
        Ok(self)
    }
}

/// A fault with the field that it belongs to.
type Faulty<T> = Result<T, (String, RobotFault)>;

fn invalid<T>(field: &str, problem: impl Into<String>) -> Faulty<T> {
    Err((field.to_owned(), RobotFault::Invalid(problem.into())))
}

struct Resolver<'a> {
    robot: &'a Robot,
    entry: &'a Entry,
    folder: Option<&'a Path>,
}

impl Resolver<'_> {
    fn placement(&self) -> Faulty<Placement> {
        let entry = self.entry;
        if self.robot.actuator_index(&entry.name).is_some() {
            return Err(("name".to_owned(), RobotFault::Duplicate(entry.name.clone())));
        }
        self.check_keys()?;
        if entry.kind == Kind::PositionDrive {
            return self.position_drive();
        }
        let (link_1, link_2) = (self.link("link_1", &entry.link_1)?, self.link("link_2", &entry.link_2)?);
        let spec = self.spec()?;
        let drive = match entry.kind {
            Kind::Linear => self.linear(&spec, link_1, link_2)?,
            _ => self.hoekens(&spec, link_1, link_2)?,
        };
        let sprung_mass_in = match &entry.sprung_mass_in {
            None => None,
            some => Some(self.link("sprung_mass_in", some)?),
        };
        // A linkage's actuator is carried by link 1 as a whole.
        let may_contain = |l: usize| l == link_1 || (l == link_2 && entry.kind == Kind::Linear);
        if sprung_mass_in.is_some_and(|l| !may_contain(l)) {
            return invalid("sprung_mass_in", "must be link_1, or for a linear actuator link_2");
        }
        Ok(Placement {
            name: entry.name.clone(),
            actuator: entry.actuator.clone().unwrap_or_default(),
            spring_setting: entry.spring.clone().unwrap_or_default(),
            length: self.length(&spec)?,
            spec: Some(spec),
            link_1,
            link_2,
            drive,
            sprung_mass_in,
        })
    }

    /// Keys that belong to another kind of drive would be ignored: that is an error.
    fn check_keys(&self) -> Faulty<()> {
        let e = self.entry;
        let (linear, hoekens) = (e.kind == Kind::Linear, e.kind == Kind::Hoekens);
        let spring_driven = linear || hoekens;
        let keys = [
            ("actuator", e.actuator.is_some(), spring_driven, spring_driven),
            ("spring", e.spring.is_some(), spring_driven, false),
            ("link_1", e.link_1.is_some(), spring_driven, spring_driven),
            ("link_2", e.link_2.is_some(), spring_driven, spring_driven),
            ("point_1_m", e.point_1_m.is_some(), spring_driven, spring_driven),
            ("point_2_m", e.point_2_m.is_some(), linear, linear),
            ("joint", e.joint.is_some(), !linear, !linear),
            ("crank_angle_at_zero_rad", e.crank_angle_at_zero_rad.is_some(), hoekens, hoekens),
            ("sign", e.sign.is_some(), hoekens, hoekens),
            ("length_mid_m", e.length_mid_m.is_some(), hoekens, hoekens),
            ("axis_1", e.axis_1.is_some(), hoekens, hoekens),
            ("length_m", e.length_m.is_some(), spring_driven, false),
            ("sprung_mass_in", e.sprung_mass_in.is_some(), spring_driven, false),
        ];
        for (key, given, taken, required) in keys {
            if required && !given {
                return Err((String::new(), RobotFault::Missing(format!("'{key}'"))));
            }
            if given && !taken {
                return invalid(key, "has no meaning for this kind of drive");
            }
        }
        Ok(())
    }

    fn position_drive(&self) -> Faulty<Placement> {
        let joint = self.joint()?;
        let (link_1, link_2) = (self.robot.joints[joint].parent, self.robot.joints[joint].child);
        Ok(Placement {
            name: self.entry.name.clone(),
            actuator: String::new(),
            spring_setting: String::new(),
            spec: None,
            link_1,
            link_2,
            drive: Drive::RigidPosition { joint },
            length: LengthRange { min_m: f64::NEG_INFINITY, max_m: f64::INFINITY },
            sprung_mass_in: None,
        })
    }

    fn linear(&self, spec: &ActuatorSpec, link_1: usize, link_2: usize) -> Faulty<Drive> {
        if spec.linkage.is_some() {
            return invalid("kind", format!("'{}' drives a linkage: kind = \"hoekens\"", spec.id));
        }
        let point_1 = self.point("point_1_m", self.entry.point_1_m)?;
        let point_2 = self.point("point_2_m", self.entry.point_2_m)?;
        self.check_between(link_1, link_2)?;
        let zero = vec![0.0; self.robot.dofs];
        let posture = self.robot.posture(&Isometry3::identity(), &zero);
        let distance_m = (posture.point(link_2, &point_2) - posture.point(link_1, &point_1)).norm();
        if distance_m < COINCIDE_M {
            return Err((String::new(), RobotFault::PointsCoincide { distance_m }));
        }
        Ok(Drive::Linear { point_1, point_2 })
    }

    fn hoekens(&self, spec: &ActuatorSpec, link_1: usize, link_2: usize) -> Faulty<Drive> {
        let Some(LinkageSpec::InvertedHoekens(linkage)) = spec.linkage else {
            return invalid("actuator", format!("'{}' has no linkage", spec.id));
        };
        let joint = self.joint()?;
        let ends = [self.robot.joints[joint].parent, self.robot.joints[joint].child];
        if ends != [link_1, link_2] && ends != [link_2, link_1] {
            return invalid("joint", "a linkage's joint must join link_1 and link_2 directly");
        }
        let sign = self.entry.sign.unwrap_or_default();
        if sign.abs() != 1.0 {
            return Err(("sign".to_owned(), RobotFault::BadValue { value: sign, admitted: "1 or -1" }));
        }
        let axis = self.entry.axis_1.unwrap_or_default();
        self.finite("axis_1", &axis)?;
        let Some(axis_1) = Unit::try_new(Vector3::from(axis), 1e-9) else {
            return Err(("axis_1".to_owned(), RobotFault::ZeroAxis));
        };
        let crank_angle_at_zero_rad = self.entry.crank_angle_at_zero_rad.unwrap_or_default();
        let length_mid_m = self.entry.length_mid_m.unwrap_or_default();
        self.finite("crank_angle_at_zero_rad", &[crank_angle_at_zero_rad])?;
        self.finite("length_mid_m", &[length_mid_m])?;
        let point_1 = self.point("point_1_m", self.entry.point_1_m)?;
        let mount =
            HoekensMount { joint, linkage, crank_angle_at_zero_rad, sign, length_mid_m, point_1, axis_1 };
        Ok(Drive::Hoekens(mount))
    }

    fn link(&self, field: &str, name: &Option<String>) -> Faulty<usize> {
        let name = name.as_deref().unwrap_or_default();
        self.robot.link_index(name).ok_or_else(|| {
            let suggestion = nearest(name, self.robot.links.iter().map(|l| l.name.as_str()));
            (field.to_owned(), RobotFault::UnknownLink { name: name.to_owned(), suggestion })
        })
    }

    /// The moving joint that is named.
    fn joint(&self) -> Faulty<usize> {
        let name = self.entry.joint.as_deref().unwrap_or_default();
        let joint = self.robot.joint_index(name).ok_or_else(|| {
            let suggestion = nearest(name, self.robot.joints.iter().map(|j| j.name.as_str()));
            ("joint".to_owned(), RobotFault::UnknownJoint { name: name.to_owned(), suggestion })
        })?;
        match self.robot.joints[joint].dof {
            Some(_) => Ok(joint),
            None => invalid("joint", format!("'{name}' is fixed")),
        }
    }

    fn point(&self, field: &str, point: Option<[f64; 3]>) -> Faulty<Point3<f64>> {
        let point = point.unwrap_or_default();
        self.finite(field, &point)?;
        Ok(Point3::from(point))
    }

    fn finite(&self, field: &str, values: &[f64]) -> Faulty<()> {
        match values.iter().find(|v| !v.is_finite()) {
            Some(bad) => Err((field.to_owned(), RobotFault::BadValue { value: *bad, admitted: "finite" })),
            None => Ok(()),
        }
    }

    fn check_between(&self, link_1: usize, link_2: usize) -> Faulty<()> {
        if self.robot.joints_between(link_1, link_2).iter().any(|j| self.robot.joints[*j].dof.is_some()) {
            return Ok(());
        }
        let name = |l: usize| self.robot.links[l].name.clone();
        Err((String::new(), RobotFault::NothingToDrive { link_1: name(link_1), link_2: name(link_2) }))
    }

    fn spec(&self) -> Faulty<ActuatorSpec> {
        let at = |field: &'static str| {
            move |e: ActuatorError| (field.to_owned(), RobotFault::Actuator(Box::new(e)))
        };
        let name = self.entry.actuator.as_deref().unwrap_or_default();
        let spec = ActuatorSpec::load(name, self.folder).map_err(at("actuator"))?;
        if spec.kind != sealegs_actuator::Kind::Linear {
            return invalid("actuator", format!("'{name}' is rotary: only linear actuators span two links"));
        }
        if spec.is_rigid() {
            return invalid(
                "actuator",
                format!("'{name}' has no spring: a leg's actuators are series elastic"),
            );
        }
        match &self.entry.spring {
            Some(setting) => spec.with_spring_setting(setting).map_err(at("spring")),
            None => Ok(spec),
        }
    }

    /// From the entry, else from the actuator's ratings, else any length.
    fn length(&self, spec: &ActuatorSpec) -> Faulty<LengthRange> {
        let rated = spec.ratings.min_length_m.zip(spec.ratings.stroke_m);
        let Some([min_m, max_m]) = self.entry.length_m.or(rated.map(|(min, stroke)| [min, min + stroke]))
        else {
            return Ok(LengthRange::ANY);
        };
        if !(min_m > 0.0 && min_m.is_finite()) {
            let fault = RobotFault::BadValue { value: min_m, admitted: "positive and finite" };
            return Err(("length_m".to_owned(), fault));
        }
        if min_m.partial_cmp(&max_m) != Some(std::cmp::Ordering::Less) {
            let fault = RobotFault::BadValue { value: max_m, admitted: "above the least length" };
            return Err(("length_m".to_owned(), fault));
        }
        Ok(LengthRange { min_m, max_m })
    }
}
