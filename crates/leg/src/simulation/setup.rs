//! From a scenario to a leg that is ready to run: robot, actuators, start posture, base height.

use super::sample::{ActuatorModel, LegDescription};
use crate::LegError;
use crate::dynamics::contact::{Contact, SolePoint, sole_points};
use crate::dynamics::coupling::{Actuator, place_sprung_mass};
use crate::dynamics::drive::{Servo, ServoLaw};
use crate::dynamics::engine::{Base, Engine, Mechanics};
use crate::dynamics::tree::Tree;
use crate::error::nearest;
use crate::robot::{Drive, Inertial, LoadOptions, Robot};
use crate::scenario::{BaseSpec, Scenario};
use nalgebra::{Isometry3, Translation3};
use sealegs_actuator::{ActuatorSpec, Coefficients, Configuration};
use std::path::Path;

/// The parts of a simulation, built and posed but not yet started.
pub(super) struct Parts {
    pub leg: LegDescription,
    pub tree: Tree,
    pub engine: Engine,
    pub actuators: Vec<Actuator>,
    pub servos: Vec<Servo>,
    pub contact: Option<Contact>,
    /// Masses of the bodies as a controller knows them, where they are others.
    pub known_bodies: Option<Vec<Option<Inertial>>>,
    pub start_q: Vec<f64>,
    pub start_speed: Vec<f64>,
}

/// The robot of a scenario.
pub(crate) fn load_robot(scenario: &Scenario) -> Result<Robot, LegError> {
    let beside = |file: &str| match &scenario.folder {
        Some(folder) if folder.join(file).is_file() => folder.join(file),
        _ => Path::new(file).to_owned(),
    };
    let placement = scenario.placement.as_deref().map(beside);
    let options = LoadOptions { strict: scenario.strict, ..LoadOptions::from_environment() };
    let name = beside(&scenario.robot);
    let robot = Robot::load_with(&name.to_string_lossy(), placement.as_deref(), &options)?;
    Ok(if scenario.mirrored { robot.mirrored() } else { robot })
}

impl Parts {
    /// `known` is the robot as a controller knows it, where it differs.
    pub fn new(
        scenario: &Scenario,
        robot: Robot,
        known: Option<Robot>,
        mechanics: Mechanics,
    ) -> Result<Self, LegError> {
        check_names(scenario, &robot)?;
        let mut robot = robot;
        let mut models = Vec::new();
        for placement in &mut robot.actuators {
            let Some(spec) = placement.spec.as_ref() else { continue };
            let spec = actuator_spec(scenario, &placement.name, spec)?;
            let coefficients = actuator_coefficients(scenario, &placement.name, &spec)?;
            if coefficients.configuration == Configuration::Lumped {
                // The lumped mass has no weight of its own: the link keeps what it has.
                placement.sprung_mass_in = None;
            }
            models.push(ActuatorModel {
                name: placement.name.clone(),
                id: spec.id.clone(),
                spring_setting: spec.spring.setting(),
                coefficients,
                nominal: spec.coefficients(),
                limits: sealegs_actuator::spring::SpringLimits {
                    stiffness: coefficients.stiffness,
                    ..spec.spring_limits()
                },
                travel_per_rad: spec.ratio(),
                current_limit_a: scenario
                    .actuator
                    .get(&placement.name)
                    .and_then(|o| o.current_limit_a)
                    .or(spec.motor.current_limit_a)
                    .unwrap_or(f64::INFINITY),
                length: placement.length,
            });
            placement.spec = Some(spec);
        }
        let (robot, tree) = bodies(robot, &models)?;
        let known_bodies = match known {
            Some(known) => Some(bodies(known, &models)?.1.bodies.into_iter().map(|b| b.inertial).collect()),
            None => None,
        };
        check_bodies(scenario, &robot, &tree)?;
        let by_joint = |map: &std::collections::BTreeMap<String, f64>| -> Vec<f64> {
            robot.moving_joints().map(|j| map.get(&j.name).copied().unwrap_or(0.0)).collect()
        };
        let start_q = by_joint(&scenario.start.posture_rad);
        let start_speed = by_joint(&scenario.start.speed_rad_s);
        robot.check_strokes(&start_q, "the scenario's start")?;

        // A robot that hangs in the air needs none, and hulls of fine meshes take their time.
        let lands = scenario.ground.is_some() || matches!(scenario.base, BaseSpec::Rail { .. });
        let points = if lands { all_sole_points(&robot, &tree) } else { Vec::new() };
        let ground = scenario.ground;
        let (base, height) = match scenario.base {
            BaseSpec::Fixed { height_m } => (Base::Fixed, height_m),
            BaseSpec::Rail { carriage_mass_kg } => {
                (Base::Rail { carriage_mass_kg }, base_height(scenario, &robot, &tree, &points, &start_q))
            }
        };
        let world_from_base = Isometry3::from_parts(Translation3::new(0.0, 0.0, height), Default::default());
        let gravity = -scenario.gravity_m_s2;
        let mut engine =
            Engine::new(mechanics, &tree, base, &world_from_base, robot.dofs, gravity, scenario.step_s);
        let rest = nalgebra::DVector::zeros(engine.coordinates());
        engine.set_state(&start_q, 0.0, &rest, &rest);

        let mut actuators = Vec::new();
        let mut servos = Vec::new();
        let mut coefficients = models.iter().map(|m| m.coefficients);
        for placement in &robot.actuators {
            if let Drive::RigidPosition { joint } = &placement.drive {
                servos.push(servo(&robot, &tree, *joint, &placement.name));
            } else if let Some(c) = coefficients.next() {
                actuators.extend(Actuator::place(&robot, &tree, placement, c, &engine)?);
            }
        }
        let contact = ground.map(|g| Contact::new(g, points, &engine));
        let leg = LegDescription {
            scenario: scenario.name.clone(),
            joints: robot.moving_joints().map(|j| j.name.clone()).collect(),
            actuators: models,
            drives: servos.iter().map(|s| s.name.clone()).collect(),
            ground,
            sample_period_s: scenario.sample_period_s,
            duration_s: scenario.duration_s,
            robot,
        };
        Ok(Self { leg, tree, engine, actuators, servos, contact, known_bodies, start_q, start_speed })
    }
}

/// The moving bodies of a robot with the sprung masses of its actuators where the engine is to carry them.
fn bodies(robot: Robot, models: &[ActuatorModel]) -> Result<(Robot, Tree), LegError> {
    let robot = robot.without_sprung_masses()?;
    let mut tree = Tree::new(&robot);
    let sprung = robot.actuators.iter().filter(|p| !matches!(p.drive, Drive::RigidPosition { .. }));
    for (placement, model) in sprung.zip(models) {
        place_sprung_mass(&mut tree, placement, &model.coefficients);
    }
    Ok((robot, tree))
}

/// Every joint or actuator that the scenario names must be there.
fn check_names(scenario: &Scenario, robot: &Robot) -> Result<(), LegError> {
    let joints: Vec<&str> = robot.moving_joints().map(|j| j.name.as_str()).collect();
    let actuators: Vec<&str> = robot.actuators.iter().map(|a| a.name.as_str()).collect();
    let look = |table: &str, name: &str, known: &[&str], what: &str| {
        if known.contains(&name) {
            return Ok(());
        }
        let hint = nearest(name, known.iter().copied()).map_or_else(
            || format!("; there are {}", known.join(", ")),
            |s| format!("; did you mean '{s}'?"),
        );
        let problem = format!("the robot '{}' has no {what} '{name}'{hint}", robot.name);
        Err(LegError::scenario(&scenario.name, &format!("{table}.{name}"), problem))
    };
    for name in scenario.start.posture_rad.keys() {
        look("start.posture_rad", name, &joints, "moving joint")?;
    }
    for name in scenario.start.speed_rad_s.keys() {
        look("start.speed_rad_s", name, &joints, "moving joint")?;
    }
    for name in scenario.motion.keys() {
        look("motion", name, &joints, "moving joint")?;
    }
    for name in scenario.controller.joints.keys() {
        look("controller.joints", name, &joints, "moving joint")?;
    }
    for name in scenario.actuator.keys() {
        look("actuator", name, &actuators, "actuator")?;
    }
    for name in scenario.current.keys().chain(scenario.current_file.keys()) {
        look("current", name, &actuators, "actuator")?;
    }
    Ok(())
}

/// The actuator with the scenario's spring setting and configuration.
pub(crate) fn actuator_spec(
    scenario: &Scenario,
    name: &str,
    spec: &ActuatorSpec,
) -> Result<ActuatorSpec, LegError> {
    let own = scenario.actuator.get(name);
    let setting = own.and_then(|o| o.spring.as_ref()).or(scenario.actuators.spring.as_ref());
    let mut spec = match setting {
        Some(setting) => spec.with_spring_setting(setting)?,
        None => spec.clone(),
    };
    if let Some(configuration) = scenario.actuators.configuration {
        spec.configuration = configuration;
    }
    Ok(spec)
}

/// The numbers of an actuator with the scenario's parameters in place of its own.
pub(crate) fn actuator_coefficients(
    scenario: &Scenario,
    name: &str,
    spec: &ActuatorSpec,
) -> Result<Coefficients, LegError> {
    let mut c = spec.coefficients();
    let parameters = scenario.actuator.get(name).map(|o| &o.parameters);
    for (parameter, given) in parameters.into_iter().flatten() {
        let value = given.value;
        match parameter.as_str() {
            "stiffness" => c.stiffness = value,
            "stiffness_ratio" => c.stiffness *= value,
            "reflected_inertia" => c.reflected_inertia = value,
            "damping" => c.damping = value,
            "force_constant" => c.force_constant = value,
            "motor_gain" => c.force_constant *= value,
            "sprung_mass" => c.sprung_mass = value,
            other => {
                let known = [
                    "stiffness",
                    "reflected_inertia",
                    "damping",
                    "force_constant",
                    "motor_gain",
                    "sprung_mass",
                ];
                let hint = nearest(other, known).map_or_else(
                    || format!("; there are {}", known.join(", ")),
                    |s| format!("; did you mean '{s}'?"),
                );
                let field = format!("actuator.{name}.parameters.{other}");
                return Err(LegError::scenario(&scenario.name, &field, format!("no such parameter{hint}")));
            }
        }
    }
    Ok(c)
}

/// Every body that moves needs mass; without joints and rail there is nothing to simulate.
fn check_bodies(scenario: &Scenario, robot: &Robot, tree: &Tree) -> Result<(), LegError> {
    let fault = |problem: String| Err(LegError::scenario(&scenario.name, "robot", problem));
    for body in tree.bodies.iter().skip(1) {
        let physical = body.inertial.as_ref().is_some_and(crate::robot::Inertial::is_physical);
        if !physical {
            return fault(format!("link '{}' moves but has no mass that a body can have", body.name));
        }
    }
    match scenario.base {
        BaseSpec::Fixed { .. } if robot.dofs == 0 => fault("no joint of the robot moves".to_owned()),
        BaseSpec::Rail { carriage_mass_kg }
            if carriage_mass_kg + tree.bodies[0].inertial.as_ref().map_or(0.0, |i| i.mass_kg) <= 0.0 =>
        {
            fault("base.carriage_mass_kg = 0 and a base link without mass cannot move on a rail".to_owned())
        }
        _ => Ok(()),
    }
}

/// Sole points of all leaf links that have collision shapes: the feet.
fn all_sole_points(robot: &Robot, tree: &Tree) -> Vec<SolePoint> {
    let is_parent =
        |body: usize| tree.bodies.iter().any(|b| b.joint.as_ref().is_some_and(|j| j.parent == body));
    let mut points = Vec::new();
    for (link, &(body, body_from_link)) in robot.links.iter().zip(&tree.links) {
        if is_parent(body) {
            continue;
        }
        for shape in &link.collisions {
            points.extend(sole_points(body, &(body_from_link * shape.origin), shape));
        }
    }
    points
}

/// The height at which the lowest sole point is `drop_height_m` above the ground, measured vertically.
fn base_height(scenario: &Scenario, robot: &Robot, tree: &Tree, points: &[SolePoint], q: &[f64]) -> f64 {
    let posture = robot.posture(&Isometry3::identity(), q);
    let ground = scenario.ground.unwrap_or_default();
    let normal: nalgebra::Vector3<f64> = ground.normal().into();
    let lowest = points
        .iter()
        .map(|p| {
            // A body's frame is the frame of its first link.
            let link = tree.links.iter().position(|l| l.0 == p.body).unwrap_or(0);
            (posture.world_from_link[link] * p.center).coords.dot(&normal) - p.radius_m
        })
        .fold(f64::INFINITY, f64::min);
    let lowest = if lowest.is_finite() { lowest } else { 0.0 };
    ground.height_m + scenario.start.drop_height_m - lowest / normal.z
}

fn servo(robot: &Robot, tree: &Tree, joint: usize, name: &str) -> Servo {
    let joint = &robot.joints[joint];
    let body = tree.links[joint.child].0;
    Servo {
        name: name.to_owned(),
        body,
        parent: tree.links[joint.parent].0,
        slides: joint.kind == crate::robot::JointKind::Prismatic,
        dof: joint.dof.unwrap_or_default(),
        law: ServoLaw::default(),
        target_rad: 0.0,
        limit_nm: joint.limits.effort,
        torque_nm: 0.0,
        before: [0.0; 2],
    }
}
