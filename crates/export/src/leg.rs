//! The leg of a scenario as links, joints and actuators with their effects, from which every writer writes.

use crate::ExportError;
use crate::bench::{BenchDescription, Output};
use crate::term::{Included, Term, parameters_of};
use nalgebra::{Isometry3, Matrix3, Point3};
use sealegs_actuator::{Configuration, Kind};
use sealegs_leg::dynamics::contact::Ground;
use sealegs_leg::model::LegModel;
use sealegs_leg::robot::{Drive, Inertial, Placement, Robot};
use sealegs_leg::scenario::{BaseSpec, Scenario, SpringStart};
use sealegs_leg::simulation::{ActuatorModel, Simulation};
use sealegs_model::Model;
use std::collections::BTreeMap;

/// An actuator of the leg.
#[derive(Debug, Clone)]
pub struct LegActuator {
    pub placement: Placement,
    /// Its numbers and effects, as if on a bench with both ends held; `inertia` is the rotor's with the sprung mass that
    /// moves with it.
    pub drive: BenchDescription,
    /// Greatest current, A; infinite where nothing limits it.
    pub current_limit_a: f64,
    /// Weight of the sprung mass of a linkage along the axis at the start, N: it is at `x_1 + L - y`, so that the spring's
    /// deflection lifts it.
    pub weight_on_spring: f64,
}

/// A leg.
#[derive(Debug, Clone)]
pub struct LegDescription {
    pub name: String,
    /// The robot, its links with the sprung masses of its actuators and, on a rail, the carriage.
    pub robot: Robot,
    pub actuators: Vec<LegActuator>,
    /// Effects of places that are no actuators, or of the leg itself: id and term.
    pub others: Vec<(String, Term)>,
    /// Whether the base slides on a vertical rail.
    pub rail: bool,
    /// `world_from_base` at the start.
    pub world_from_base: Isometry3<f64>,
    /// Joint positions at the start, by degree of freedom, rad.
    pub start_q: Vec<f64>,
    pub loaded_start: bool,
    pub gravity_m_s2: f64,
    pub ground: Option<Ground>,
}

impl LegDescription {
    /// The leg that a scenario runs.
    ///
    /// # Errors
    ///
    /// [`ExportError::Leg`].
    pub fn of(scenario: &Scenario) -> Result<Self, ExportError> {
        let mut simulation = Simulation::new(scenario)?;
        let said = simulation.leg().clone();
        // The first step's sample is the start.
        simulation.advance(true)?;
        let world_from_base = simulation.sample().world_from_link[0];
        let model = LegModel::new(scenario.clone(), scenario, Vec::new(), Vec::new())?;
        let mut robot = said.robot;
        let start_q: Vec<f64> = {
            let posture = &scenario.start.posture_rad;
            robot.moving_joints().map(|j| posture.get(&j.name).copied().unwrap_or(0.0)).collect()
        };
        let posture = robot.posture(&world_from_base, &start_q);
        let rail = match scenario.base {
            BaseSpec::Rail { carriage_mass_kg } if carriage_mass_kg > 0.0 => {
                let com = robot.links[0].inertial.as_ref().map_or(Point3::origin(), |i| i.com);
                add_mass(&mut robot, 0, carriage_mass_kg, &com);
                true
            }
            BaseSpec::Rail { .. } => true,
            BaseSpec::Fixed { .. } => false,
        };
        let mut effects = effects(&model);
        let sprung = robot.actuators.clone().into_iter().filter(|p| p.spec.is_some());
        let mut actuators = Vec::new();
        for (placement, model) in sprung.zip(&said.actuators) {
            place_sprung_mass(&mut robot, &placement, model);
            let terms = effects.remove(&placement.name).unwrap_or_default();
            let index = robot.actuator_index(&placement.name).unwrap_or_default();
            let upwards = match robot.attachment(index, &posture, &start_q)? {
                Some([end_1, end_2]) => (end_2 - end_1).normalize().z,
                None => 0.0,
            };
            let mut drive = drive(&placement, model, terms, scenario.gravity_m_s2, upwards);
            let hoekens = matches!(placement.drive, Drive::Hoekens(_));
            let weight_on_spring = match model.coefficients.configuration {
                Configuration::SprungMotorHousing if hoekens => std::mem::take(&mut drive.offset_force),
                _ => 0.0,
            };
            actuators.push(LegActuator {
                drive,
                weight_on_spring,
                current_limit_a: model
                    .current_limit_a
                    .min(scenario.controller.current_limit_a.unwrap_or(f64::INFINITY)),
                placement,
            });
        }
        let others = effects
            .into_iter()
            .flat_map(|(place, terms)| terms.into_iter().map(move |e| (format!("{place}/{}", e.id), e.term)));
        Ok(Self {
            name: format!("{} in the scenario {}", robot.name, scenario.name),
            others: others.collect(),
            start_q,
            actuators,
            rail,
            world_from_base,
            loaded_start: scenario.start.springs == SpringStart::Balanced,
            gravity_m_s2: scenario.gravity_m_s2,
            ground: said.ground,
            robot,
        })
    }

    /// Mass of everything, kg.
    #[cfg(test)]
    pub fn mass_kg(&self) -> f64 {
        self.robot.mass_kg()
    }
}

/// The effects by place.
fn effects(model: &LegModel) -> BTreeMap<String, Vec<Included>> {
    let mut by_place: BTreeMap<String, Vec<Included>> = BTreeMap::new();
    let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    for id in model.included() {
        let said = model.scenario().effects.iter().find(|e| e.id == id);
        let parameters = parameters_of(&id, model.parameters(), &values);
        let (place, own) = id.split_once('/').unwrap_or(("", id.as_str()));
        let term = Term::of(own, &parameters, said.and_then(|e| e.definition.as_ref()));
        by_place.entry(place.to_owned()).or_default().push(Included { id: own.to_owned(), term });
    }
    by_place
}

/// An actuator whose axis has the upward component `upwards`: the weight of its sprung mass, which is at `x_2 - y` of a rod
/// or at `x_1 + y` of a sprung ball nut, pushes on the screw.
fn drive(
    placement: &Placement,
    model: &ActuatorModel,
    effects: Vec<Included>,
    gravity_m_s2: f64,
    upwards: f64,
) -> BenchDescription {
    let c = &model.coefficients;
    let side = match c.configuration {
        Configuration::SprungMotorHousing => 1.0,
        Configuration::SprungBallNut => -1.0,
        // The lumped model's mass has no weight.
        Configuration::Lumped => 0.0,
    };
    BenchDescription {
        name: placement.name.clone(),
        kind: Kind::Linear,
        input: "current_a".to_owned(),
        inertia: c.total_mass(),
        sprung_mass: c.sprung_mass,
        damping: c.damping,
        stiffness: c.stiffness,
        nominal_stiffness: model.nominal.stiffness,
        travel_per_rad: model.travel_per_rad,
        gain: c.force_constant,
        offset_force: side * c.sprung_mass * gravity_m_s2 * upwards,
        gravity_m_s2,
        output: Output::Held,
        channels: Vec::new(),
        effects,
        sensors: BTreeMap::new(),
        logger: (false, 0.0),
    }
}

fn add_mass(robot: &mut Robot, link: usize, mass_kg: f64, at: &Point3<f64>) {
    let inertial = &mut robot.links[link].inertial;
    *inertial = Some(match inertial {
        Some(i) => i.with_point_mass(mass_kg, at),
        // A point on a body that has nothing else: moments as good as none.
        None => Inertial { mass_kg, com: *at, inertia: Matrix3::identity() * 1e-9 * mass_kg },
    });
}

/// Puts a sprung mass where the simulation carries it: at the screw side's attachment of a rod (the spring side's for a
/// sprung ball nut), at the mount of a linkage; the lumped model's has no weight and no place.
fn place_sprung_mass(robot: &mut Robot, placement: &Placement, model: &ActuatorModel) {
    let (link, at) = match (&placement.drive, model.coefficients.configuration) {
        (_, Configuration::Lumped) | (Drive::RigidPosition { .. }, _) => return,
        (Drive::Linear { point_2, .. }, Configuration::SprungMotorHousing) => (placement.link_2, *point_2),
        (Drive::Linear { point_1, .. }, _) => (placement.link_1, *point_1),
        (Drive::Hoekens(mount), _) => (placement.link_1, mount.point_1),
    };
    add_mass(robot, link, model.coefficients.sprung_mass, &at);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_lost_or_counted_twice() {
        let scenario = Scenario::load("thor-drop", &[]).unwrap();
        let leg = LegDescription::of(&scenario).unwrap();
        // The URDF's links, six sprung masses (Table 5), the carriage.
        let links = Robot::load("thor-leg", None).unwrap().mass_kg();
        assert!((leg.mass_kg() - (links + 6.0 * 0.6461 + 20.0)).abs() < 1e-12, "{}", leg.mass_kg());
        assert!(leg.rail && leg.actuators.len() == 6 && leg.others.is_empty());
        assert!(leg.robot.links.iter().all(|l| l.inertial.as_ref().is_none_or(Inertial::is_physical)));
    }

    #[test]
    fn effects_go_to_their_actuator_or_stay_with_their_place() {
        let text = sealegs_leg::scenario::preset_text("thor-drop").unwrap();
        let text = format!(
            "{text}\n[[effect]]\nid = \"knee/coulomb-friction\"\nparameters = {{ force_n = 40.0 }}\n[[effect]]\nid = \
             \"foot/ground-friction\"\nparameters = {{ }}\n"
        );
        let leg = LegDescription::of(&Scenario::from_toml(&text, "mine.toml", &[]).unwrap()).unwrap();
        let knee = leg.actuators.iter().find(|a| a.placement.name == "knee").unwrap();
        assert_eq!(knee.drive.sum(Term::dry_friction), 40.0);
        assert_eq!(leg.others.len(), 1);
    }
}
