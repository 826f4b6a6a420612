//! What can be wrong with the description of a robot.

use crate::error::did_you_mean;

/// A fault in a URDF, a mesh or a placement file, with the values at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RobotFault {
    /// The text is no XML at all.
    #[error("no XML: {0}")]
    NotXml(String),
    /// Elements are inside each other without end.
    #[error("elements are nested more than {0} deep")]
    NestedTooDeep(u32),
    /// The XML is no URDF, or a value in it cannot be read.
    #[error("{0}")]
    NotUrdf(String),
    /// A required element or attribute is missing.
    #[error("{0} is missing")]
    Missing(String),
    /// A name was given twice.
    #[error("the name '{0}' is used twice")]
    Duplicate(String),
    /// A link that is named is not there.
    #[error("no link '{name}'{}", did_you_mean(suggestion.as_deref()))]
    UnknownLink {
        /// What was named.
        name: String,
        /// The nearest link.
        suggestion: Option<String>,
    },
    /// A joint that is named is not there.
    #[error("no joint '{name}'{}", did_you_mean(suggestion.as_deref()))]
    UnknownJoint {
        /// What was named.
        name: String,
        /// The nearest joint.
        suggestion: Option<String>,
    },
    /// A link has two parents.
    #[error("link '{link}' is the child of '{first}' and of '{second}': a robot must be a tree")]
    TwoParents {
        /// The link.
        link: String,
        /// One joint.
        first: String,
        /// The other joint.
        second: String,
    },
    /// Links form a ring.
    #[error("links form a cycle: {}", .0.join(" -> "))]
    Cycle(Vec<String>),
    /// More than one link has no parent.
    #[error("more than one root: {}", .0.join(", "))]
    Roots(Vec<String>),
    /// There is no link.
    #[error("there is no link")]
    NoLink,
    /// A joint type that the simulation cannot honour.
    #[error("joint type '{0}' is not supported, and leaving it out would change the robot")]
    UnsupportedJoint(String),
    /// A joint that is to follow another.
    #[error("following joint '{0}' is not supported")]
    Mimic(String),
    /// A number outside of what is admitted.
    #[error("{value}: must be {admitted}")]
    BadValue {
        /// The value.
        value: f64,
        /// What is admitted.
        admitted: &'static str,
    },
    /// The axis has no direction.
    #[error("the axis is zero")]
    ZeroAxis,
    /// The lower limit lies above the upper.
    #[error("lower limit {lower} is above upper limit {upper}")]
    LimitsCrossed {
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// No body can have this inertia.
    #[error("no body has the principal moments {0:?} kg m^2: {1}")]
    ImpossibleInertia([f64; 3], &'static str),
    /// A mesh could not be read.
    #[error("mesh '{file}': {problem}")]
    Mesh {
        /// The file as the URDF names it.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// A value or a choice that does not fit.
    #[error("{0}")]
    Invalid(String),
    /// The actuator that is named, or its spring's setting.
    #[error(transparent)]
    Actuator(Box<sealegs_actuator::ActuatorError>),
    /// The two attachment points are the same point.
    #[error("both attachment points lie at the same place ({distance_m} m apart)")]
    PointsCoincide {
        /// Their distance, m.
        distance_m: f64,
    },
    /// No joint lies between the two links.
    #[error("no moving joint lies between '{link_1}' and '{link_2}'")]
    NothingToDrive {
        /// Link 1.
        link_1: String,
        /// Link 2.
        link_2: String,
    },
    /// The actuator cannot be that long or that short.
    #[error("length {length_m:.4} m at {posture} is outside {min_m:.4}..{max_m:.4} m that its stroke allows")]
    OutOfStroke {
        /// The length that the posture asks for, m.
        length_m: f64,
        /// Least length, m.
        min_m: f64,
        /// Greatest length, m.
        max_m: f64,
        /// Which posture, for example `the start posture`.
        posture: String,
    },
    /// A link would be left with impossible mass properties.
    #[error("taking {mass_kg} kg of sprung mass out of link '{link}' leaves nothing that a body can be")]
    SprungMassTooLarge {
        /// The link.
        link: String,
        /// The sprung mass, kg.
        mass_kg: f64,
    },
}
