//! A leg as the reference has it: from a scenario and its robot, with the parameters of an individual and effects.

use super::bodies::MOST_JOINTS;
use super::ground::Ground;
use super::solve::MOST;
use crate::Reference;
use nalgebra::{Isometry3, Point3, Vector3};
use sealegs_actuator::bench::Bench;
use sealegs_actuator::{ActuatorSpec, Configuration};
use sealegs_leg::LegError;
use sealegs_leg::robot::{Drive, Geometry, Robot};
use sealegs_leg::scenario::{BaseSpec, Scenario};

/// Most actuators.
pub(super) const MOST_ACTUATORS: usize = MOST - MOST_JOINTS;

/// How an individual leg differs from the nominal one; ratios are to the nominal value.
#[derive(Debug, Clone, PartialEq)]
pub struct LegIndividual {
    /// Spring stiffness, reflected inertia, damping and force constant of every actuator, in the robot's order.
    pub actuators: Vec<[f64; 4]>,
    /// Stiffness and damping of the sole's contact.
    pub contact: [f64; 2],
}

impl LegIndividual {
    /// The names of [`LegIndividual::actuators`]' numbers, as a model calls them.
    pub const OF_ACTUATOR: [&'static str; 4] =
        ["stiffness", "reflected_inertia", "damping", "force_constant"];

    /// The names of [`LegIndividual::contact`]'s numbers.
    pub const OF_CONTACT: [&'static str; 2] = ["contact_stiffness", "contact_damping"];

    /// The nominal leg.
    #[must_use]
    pub fn nominal(actuators: usize) -> Self {
        Self { actuators: vec![[1.0; 4]; actuators], contact: [1.0; 2] }
    }
}

/// A leg with everything that may act in it, and what its controller believes of it.
#[derive(Debug, Clone)]
pub struct LegReference {
    pub(super) scenario: Scenario,
    pub(super) robot: Robot,
    /// The robot as its controller knows it.
    pub(super) known_robot: Robot,
    /// The actuators with their effects.
    pub(super) parts: Vec<Reference>,
    /// The actuators as the controller knows them.
    pub(super) known: Vec<Reference>,
    /// Greatest currents, A.
    pub(super) limits_a: Vec<f64>,
    pub(super) rail: bool,
    pub(super) carriage_kg: f64,
    pub(super) gravity: Vector3<f64>,
    pub(super) base_height: f64,
    pub(super) ground: Option<Ground>,
    /// Joint positions at the start, rad.
    pub(super) start_q: Vec<f64>,
    /// Joint speeds at the start, rad/s.
    pub(super) start_speed: Vec<f64>,
    /// Bodies' coordinates, and those with the actuators'.
    pub(super) bodies: usize,
    pub(super) count: usize,
}

/// The actuator at the spring setting that holds in a scenario.
fn spec_in(scenario: &Scenario, name: &str, spec: &ActuatorSpec) -> Result<ActuatorSpec, LegError> {
    let own = scenario.actuator.get(name).and_then(|o| o.spring.as_ref());
    match own.or(scenario.actuators.spring.as_ref()) {
        Some(setting) => Ok(spec.with_spring_setting(setting)?),
        None => Ok(spec.clone()),
    }
}

impl LegReference {
    /// The leg of a scenario. Parameters and effects that the scenario itself states are not looked at.
    ///
    /// # Errors
    ///
    /// [`LegError::Scenario`] for what this simulator does not have: sliding joints, joint friction, rigid drives,
    /// other configurations than a sprung motor housing, a slope, a foot that is no box.
    pub fn new(scenario: &Scenario, robot: Robot, individual: &LegIndividual) -> Result<Self, LegError> {
        let refused = |what: &str| {
            let problem = format!("the reference simulator has no {what}");
            Err(LegError::Scenario { file: scenario.name.clone(), field: "robot".to_owned(), problem })
        };
        let rail = matches!(scenario.base, BaseSpec::Rail { .. });
        let bodies = robot.dofs + usize::from(rail);
        let (mut parts, mut known, mut limits_a) = (Vec::new(), Vec::new(), Vec::new());
        for (placement, ratios) in robot.actuators.iter().zip(&individual.actuators) {
            let Some(spec) = &placement.spec else { return refused("rigid drives") };
            let spec = spec_in(scenario, &placement.name, spec)?;
            let configuration = scenario.actuators.configuration.unwrap_or(spec.configuration);
            if configuration != Configuration::SprungMotorHousing || placement.sprung_mass_in.is_some() {
                return refused("configuration but a sprung motor housing whose mass is in no link");
            }
            let nominal = Reference::of(&spec, Bench::Locked, "current_a");
            let [stiffness, rotor, damping, force] = *ratios;
            parts.push(Reference {
                stiffness: nominal.stiffness * stiffness,
                rotor: nominal.rotor * rotor,
                damping: nominal.damping * damping,
                force_per_command: nominal.force_per_command * force,
                ..nominal.clone()
            });
            known.push(nominal);
            let own = scenario.actuator.get(&placement.name).and_then(|o| o.current_limit_a);
            let drive = own.or(spec.motor.current_limit_a).unwrap_or(f64::INFINITY);
            limits_a.push(drive.min(scenario.controller.current_limit_a.unwrap_or(f64::INFINITY)));
        }
        if parts.len() != robot.actuators.len() || parts.len() > MOST_ACTUATORS || bodies > MOST_JOINTS {
            return refused("room for so many joints and actuators");
        }
        if robot
            .moving_joints()
            .any(|j| j.friction != 0.0 || j.kind == sealegs_leg::robot::JointKind::Prismatic)
        {
            return refused("sliding joints and no friction at joints");
        }
        let by_joint = |values: &std::collections::BTreeMap<String, f64>| -> Vec<f64> {
            robot.moving_joints().map(|j| values.get(&j.name).copied().unwrap_or(0.0)).collect()
        };
        let start_q = by_joint(&scenario.start.posture_rad);
        let start_speed = by_joint(&scenario.start.speed_rad_s);
        let link = robot.links.len() - 1;
        let corners = sole(&robot, link);
        let (base_height, carriage_kg) = match scenario.base {
            BaseSpec::Fixed { height_m } => (height_m, 0.0),
            BaseSpec::Rail { carriage_mass_kg } => {
                let posture = robot.posture(&Isometry3::identity(), &start_q);
                let heights = corners.iter().flatten().map(|p| posture.point(link, p).z);
                let lowest = heights.fold(f64::INFINITY, f64::min);
                let lowest = if lowest.is_finite() { lowest } else { 0.0 };
                let ground = scenario.ground.map_or(0.0, |g| g.height_m);
                (ground + scenario.start.drop_height_m - lowest, carriage_mass_kg)
            }
        };
        let ground = match (scenario.ground, corners) {
            (None, _) => None,
            (Some(law), Some(corners)) if law.slope_rad == 0.0 => {
                let mut law = law;
                law.stiffness_n_m_n *= individual.contact[0];
                law.damping_s_m *= individual.contact[1];
                Some(Ground { law, link, corners })
            }
            _ => return refused("slope and no foot but a box"),
        };
        Ok(Self {
            rail,
            carriage_kg,
            gravity: Vector3::new(0.0, 0.0, -scenario.gravity_m_s2),
            base_height,
            ground,
            start_q,
            start_speed,
            bodies,
            count: bodies + parts.len(),
            parts,
            known,
            limits_a,
            known_robot: robot.clone(),
            robot,
            scenario: scenario.clone(),
        })
    }

    /// The same leg with an effect of the catalogue at its place, by its scoped id (`knee/coulomb-friction`) and its
    /// values in the order of its card.
    ///
    /// # Panics
    ///
    /// For an id or place that it does not know: a mistake in a program, not in an input.
    #[must_use]
    pub fn with(mut self, id: &str, values: &[f64]) -> Self {
        let Some((place, effect)) = id.split_once('/') else { panic!("'{id}' has no place") };
        match effect {
            "contact-compliance" => {
                if let Some(ground) = &mut self.ground {
                    ground.law.stiffness_n_m_n *= values[0];
                    ground.law.damping_s_m = (ground.law.damping_s_m + values[1]).max(0.0);
                }
            }
            "ground-friction" => {
                if let Some(ground) = &mut self.ground {
                    ground.law.friction = (ground.law.friction + values[0]).max(0.0);
                }
            }
            "link-mass" => {
                let link = self.robot.link_index(place).unwrap_or_else(|| panic!("no link '{place}'"));
                let Some(own) = &mut self.robot.links[link].inertial else { panic!("'{place}' has no mass") };
                // A mass that is spread as the link's own, unless the inertia's ratio is said.
                let spread = values.get(3).copied().unwrap_or(1.0);
                own.inertia *= spread * (own.mass_kg + values[0]) / own.mass_kg;
                own.mass_kg += values[0];
                own.com += Vector3::new(values[1], 0.0, values[2]);
            }
            _ => {
                let at = self.robot.actuator_index(place).unwrap_or_else(|| panic!("no actuator '{place}'"));
                let part = self.parts[at].clone();
                self.parts[at] = match effect {
                    "spring-setting" => Reference { stiffness: part.stiffness * values[0], ..part },
                    _ => part.with(effect, values),
                };
            }
        }
        let ends = self.parts.iter().filter(|part| part.series.is_some()).count();
        self.count = self.bodies + self.parts.len() + ends;
        assert!(self.count <= MOST, "no room for so many compliances");
        self
    }

    /// The coordinate of an actuator's screw end against link 2, if a compliance lets it move.
    pub(super) fn screw_end(&self, actuator: usize) -> Option<usize> {
        let compliant = |part: &Reference| part.series.is_some();
        let before = self.parts[..actuator].iter().filter(|part| compliant(part)).count();
        compliant(&self.parts[actuator]).then_some(self.bodies + self.parts.len() + before)
    }

    /// The places of actuators, in the robot's order.
    pub fn actuators(&self) -> impl Iterator<Item = &str> {
        self.robot.actuators.iter().map(|a| a.name.as_str())
    }

    /// The base parameters by the names that a model gives them.
    #[must_use]
    pub fn base_parameters(&self) -> Vec<(String, f64)> {
        let mut all = Vec::new();
        for (placement, part) in self.robot.actuators.iter().zip(&self.parts) {
            let values = [part.stiffness, part.rotor, part.damping, part.force_per_command];
            for (name, value) in LegIndividual::OF_ACTUATOR.into_iter().zip(values) {
                all.push((format!("{}/{name}", placement.name), value));
            }
        }
        if let Some(ground) = &self.ground {
            let values = [ground.law.stiffness_n_m_n, ground.law.damping_s_m];
            for (name, value) in LegIndividual::OF_CONTACT.into_iter().zip(values) {
                all.push((format!("foot/{name}"), value));
            }
        }
        all
    }

    /// Which drive an actuator has.
    pub(super) fn drive(&self, actuator: usize) -> &Drive {
        &self.robot.actuators[actuator].drive
    }
}

/// The lower corners of a box of a foot.
fn sole(robot: &Robot, link: usize) -> Option<[Point3<f64>; 4]> {
    let [shape] = robot.links[link].collisions.as_slice() else { return None };
    let Geometry::Box { half: [x, y, z] } = shape.geometry else { return None };
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    Some(corners.map(|(sx, sy)| shape.origin * Point3::new(sx * x, sy * y, -z)))
}
