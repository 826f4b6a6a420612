//! What may be fitted of a robot's links: mass, centre of mass and moment of inertia, each near what the URDF says, or far from
//! it, as an effect.

use crate::dynamics::equations::MovingBodies;
use crate::effect::link_mass::{self, LinkChange};
use crate::robot::Robot;
use sealegs_actuator::spec::{EffectSpec, EffectValue};
use sealegs_model::{EffectCard, Parameter};

/// One standard deviation of a link's mass and of its centre's distance from the joint, as ratios: estimates of what a
/// drawing says of a built link with its cables and screws.
const TOLERANCE: f64 = 0.05;

/// The same of the moments about the centre of mass, which nobody weighs.
const MOMENT_TOLERANCE: f64 = 0.2;

/// Standard deviations that are admitted.
const WITHIN: f64 = 5.0;

/// The parameters of one moving body, by their places among the robot's.
#[derive(Debug, Clone)]
pub(super) struct LinkParameters {
    body: usize,
    name: String,
    mass_kg: f64,
    com_m: f64,
    mass: usize,
    /// `None` where the centre of mass lies on the joint.
    com: Option<usize>,
    moment: usize,
}

/// Adds the parameters of every moving body that has a mass: `<link>/mass` (kg), `<link>/com_distance` (m, of the centre of
/// mass from the joint) and `<link>/moment_ratio` (of the moments about the centre of mass to the URDF's). Links on fixed
/// joints count to the link that carries them.
pub(super) fn parameters(
    robot: &Robot,
    tree: &MovingBodies,
    all: &mut Vec<Parameter>,
) -> Vec<LinkParameters> {
    let mut links = Vec::new();
    for (body, joint) in robot.moving_joints().enumerate() {
        let (mass_kg, com_m) = (tree.mass_kg(body), tree.com_m(body));
        if mass_kg <= 0.0 {
            continue;
        }
        let name = &robot.links[joint.child].name;
        let mut add = |what: &str, unit: &str, value: f64, tolerance: f64| {
            let std = tolerance * value;
            let low = (value - WITHIN * std).max(0.01 * value);
            let p = Parameter::new(format!("{name}/{what}"), unit, value, low, value + WITHIN * std);
            all.push(Parameter { prior_std: Some(std), ..p });
            all.len() - 1
        };
        links.push(LinkParameters {
            body,
            name: name.clone(),
            mass_kg,
            com_m,
            mass: add("mass", "kg", mass_kg, TOLERANCE),
            com: (com_m > 0.0).then(|| add("com_distance", "m", com_m, TOLERANCE)),
            moment: add("moment_ratio", "", 1.0, MOMENT_TOLERANCE),
        });
    }
    links
}

impl LinkParameters {
    /// The body, which the joint of the same number moves.
    pub fn body(&self) -> usize {
        self.body
    }

    /// The link that the joint moves.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The card of the effect of another mass at it.
    pub fn card(&self) -> EffectCard {
        LinkChange::IN_SPACE.card(self.mass_kg)
    }

    /// Where its parameters are among the robot's.
    pub fn at(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.mass), self.com, Some(self.moment)].into_iter().flatten()
    }

    /// Puts the values into a tree.
    pub fn apply(&self, values: &[f64], tree: &mut MovingBodies) {
        let com = self.com.map_or(1.0, |at| values[at] / self.com_m);
        tree.scale(self.body, values[self.mass] / self.mass_kg, com, values[self.moment]);
    }
}

/// The effect of another mass, as of a tool or a payload, at a link.
#[derive(Debug, Clone)]
pub(super) struct LinkMass {
    body: usize,
    /// Its parameters, by their places among the robot's.
    at: std::ops::Range<usize>,
}

impl LinkMass {
    /// The effect at a link, whose parameters are added to the robot's.
    pub fn at_link(link: &LinkParameters, all: &mut Vec<Parameter>) -> Self {
        let first = all.len();
        let id = format!("{}/{}", link.name, link_mass::ID);
        let named = |p: Parameter| Parameter { name: format!("{id}.{}", p.name), ..p };
        all.extend(link.card().parameters.into_iter().map(named));
        Self { body: link.body, at: first..all.len() }
    }

    /// The body, which the joint of the same number moves.
    pub fn body(&self) -> usize {
        self.body
    }

    /// Where its parameters are among the robot's.
    pub fn at(&self) -> std::ops::Range<usize> {
        self.at.clone()
    }

    /// Puts the values into a tree.
    pub fn apply(&self, values: &[f64], tree: &mut MovingBodies) {
        let mut inertial = tree.inertial(self.body);
        LinkChange::IN_SPACE.apply(&values[self.at()], &mut inertial);
        tree.set_inertial(self.body, &inertial);
    }

    /// The effect as a file states it, with values of which `of` tells each by its place among the robot's.
    pub fn spec(&self, id: String, names: &[Parameter], of: impl Fn(usize) -> EffectValue) -> EffectSpec {
        let own = |i: usize| names[i].name[id.len() + 1..].to_owned();
        let parameters = self.at().map(|i| (own(i), of(i))).collect();
        EffectSpec { id, parameters, definition: None }
    }
}
