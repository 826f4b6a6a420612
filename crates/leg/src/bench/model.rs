//! The robot with its drives as a model: parameters and effects by joint and link.

use super::begin::Begin;
use super::joint::{Column, Joint, refused_with_spring};
use super::links::{self, LinkMass, LinkParameters};
use super::observed::Observed;
use super::parts::Parts;
use super::stated::{with_drives_effects, with_embedded};
use super::{RobotFile, alike};
use crate::LegError;
use crate::dynamics::equations::MovingBodies;
use crate::effect::link_mass;
use crate::error::{meant, nearest};
use crate::robot::{JointKind, JointLimits, Robot};
use nalgebra::Cholesky;
use sealegs_actuator::bench::{Bench, BenchModel};
use sealegs_actuator::effect::Effect;
use sealegs_actuator::spec::{EffectSpec, EffectValue, SensorSpec};
use sealegs_actuator::{ActuatorSpec, Kind};
use sealegs_model::{EffectCard, Excitation, Model, ModelError, Parameter, Prediction, Record};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The integrator's greatest step, s.
const STEP_S: f64 = 5e-4;

/// Free parameters beyond which a search takes derivatives over and does not look at everything: two joints have some 13, three
/// 19, and with each joint come as many effects again.
const MANY_PARAMETERS: usize = 15;

/// Parameters of a joint's drive that are the whole logger's, and not a joint's.
const SHARED: [&str; 2] = ["command_lead", "clock_skew"];

/// Sampling periods that an error is remembered at least: a pull that forgets within a row overshoots the next one, and of half a row
/// it diverged.
const LEAST_MEMORY_PERIODS: f64 = 3.0;

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// At a joint's drive.
    Joint(usize),
    /// At the drives of all joints alike.
    AllJoints,
    /// At a link, by its place among [`RobotModel::links`].
    Link(usize),
}

/// A robot on a fixed base or a rail with a drive on every joint, with or without a spring.
#[derive(Debug, Clone)]
pub struct RobotModel {
    pub(super) file: Arc<RobotFile>,
    pub(super) name: String,
    pub(super) robot: Arc<Robot>,
    pub(super) tree: MovingBodies,
    pub(super) joints: Vec<Joint>,
    /// The robot as its URDF and its drives' files have it, without the values and effects of its own file.
    pub(super) plain: Option<Arc<Self>>,
    /// Factors of the servos' proportional gains by the record's name and the joint; 1 where none is there.
    pub(super) gains: BTreeMap<String, BTreeMap<String, f64>>,
    pub(super) links: Vec<LinkParameters>,
    pub(super) parts: Parts,
    pub(super) parameters: Vec<Parameter>,
    /// Included effects: where, and the id there.
    pub(super) included: Vec<(Place, String)>,
    /// What the included effects change of links.
    pub(super) loads: Vec<LinkMass>,
    /// Where runs begin, by the records' names.
    pub(super) starts: BTreeMap<String, Begin>,
    pub(super) step_s: f64,
    pub(super) steps_per_sample: Option<f64>,
    /// What the joints are pulled to, under an observer.
    pub(super) observed: Option<Arc<Observed>>,
}

impl RobotModel {
    /// The robot of a file with its effects and values, and `own` effects of the user's at every joint.
    ///
    /// # Errors
    ///
    /// Whatever is wrong with URDF or actuator files; [`LegError::Scenario`] for a robot that does not move, a drive of
    /// the wrong kind, and a parameter or effect that it cannot have.
    pub fn new(file: RobotFile, own: &[Arc<dyn Effect>]) -> Result<Self, LegError> {
        let robot = Robot::load(&file.urdf().display().to_string(), None)?;
        let urdf = file.robot.clone();
        let bad = |field: String, problem: String| LegError::scenario(&urdf, &field, problem);
        let moving = |robot: &Robot| robot.moving_joints().map(|j| j.name.clone()).collect::<Vec<_>>();
        let stray = |table: &str, joint: &str, names: &[String]| {
            let hint = meant(joint, names.iter().map(String::as_str));
            bad(format!("{table}.{joint}"), format!("no such joint moves{hint}"))
        };
        let names = moving(&robot);
        for (joint, position) in &file.hold {
            let Some(held) = robot.moving_joints().find(|j| j.name == *joint) else {
                return Err(stray("hold", joint, &names));
            };
            if !position.is_finite() || !held.limits.contain(*position) {
                let JointLimits { lower, upper, .. } = held.limits;
                let problem = format!("{position} is outside of the joint's limits, {lower} to {upper}");
                return Err(bad(format!("hold.{joint}"), problem));
            }
        }
        let robot = robot.holding(&file.hold);
        if robot.dofs == 0 {
            return Err(bad("joint".to_owned(), "none of them moves".to_owned()));
        }
        let tree = MovingBodies::of(&robot);
        let mut equations = tree.equations();
        tree.at(&vec![0.0; robot.dofs], &vec![0.0; robot.dofs], &mut equations);
        let names = moving(&robot);
        if let Some(joint) = file.drive.keys().find(|joint| !names.contains(joint)) {
            return Err(stray("drive", joint, &names));
        }
        let mut drives: Vec<ActuatorSpec> = names
            .iter()
            .map(|joint| ActuatorSpec::load(file.drive_of(joint), Some(&file.folder)))
            .collect::<Result<_, _>>()?;
        let file = with_drives_effects(file, &mut drives, &names);
        let own = with_embedded(&file, own)?;
        let mut parameters: Vec<Parameter> = Vec::new();
        let mut joints = Vec::new();
        for (i, (joint, mut spec)) in robot.moving_joints().zip(drives).enumerate() {
            let drive = file.drive_of(&joint.name);
            let slides = joint.kind == JointKind::Prismatic;
            if slides != (spec.kind == Kind::Linear) {
                let kind = if slides { "linear: the joint slides" } else { "rotary: the joint turns" };
                // One `actuator` cannot suit joints of both kinds.
                let hint = format!(
                    "; name another one in the robot's file: [drive] {} = \"DRIVE.toml\"",
                    joint.name
                );
                return Err(bad(format!("drive.{}", joint.name), format!("'{drive}' must be {kind}{hint}")));
            }
            let load = equations.mass[(i, i)];
            // What the URDF states of the joint's viscous loss is its own, beside the drive's where no spring parts them.
            let sprung = !spec.is_rigid();
            if !sprung {
                spec.motor.rotor_damping_nm_s += joint.damping * spec.ratio() * spec.ratio();
            }
            let model = BenchModel::with_own_effects(spec, Bench::Free { load }, own.clone())?;
            let mut at = Vec::new();
            for p in Model::parameters(&model) {
                let shared = SHARED.contains(&p.name.as_str());
                let name = if shared { p.name.clone() } else { format!("{}/{}", joint.name, p.name) };
                if let Some(known) = parameters.iter().position(|k| k.name == name) {
                    at.push(known);
                    continue;
                }
                at.push(parameters.len());
                parameters.push(Parameter { name, ..p.clone() });
            }
            let (damping, refused) =
                if sprung { (joint.damping, refused_with_spring()) } else { (0.0, Vec::new()) };
            let name = joint.name.clone();
            joints.push(Joint { name, slides, sprung, damping, refused, model, at, least_inertia: 0.0 });
        }
        for (i, joint) in joints.iter_mut().enumerate() {
            joint.least_inertia = joint.rotor_inertia();
            equations.mass[(i, i)] += joint.least_inertia;
        }
        if let Some(factor) = Cholesky::new(equations.mass) {
            let inverse = factor.inverse();
            joints.iter_mut().enumerate().for_each(|(i, joint)| joint.least_inertia = 1.0 / inverse[(i, i)]);
        }
        let links = links::parameters(&robot, &tree, &mut parameters);
        let parts = Parts::of(&tree);
        let mut model = Self {
            name: robot.name.clone(),
            robot: Arc::new(robot),
            tree,
            joints,
            plain: None,
            gains: BTreeMap::new(),
            links,
            parts,
            parameters,
            included: Vec::new(),
            loads: Vec::new(),
            starts: BTreeMap::new(),
            step_s: STEP_S,
            steps_per_sample: None,
            observed: None,
            file: Arc::new(file),
        };
        model.plain = Some(Arc::new(model.clone()));
        model.take_stated()?;
        Ok(model)
    }

    /// The same model with another greatest step, s.
    #[must_use]
    pub fn with_step(mut self, step_s: f64) -> Self {
        self.step_s = step_s;
        self
    }

    /// The file that it was made from.
    #[must_use]
    pub fn file(&self) -> &RobotFile {
        &self.file
    }

    /// What the drives' files and the robot's file know of sensors, by column; the robot's goes before.
    #[must_use]
    pub fn sensors(&self) -> BTreeMap<String, SensorSpec> {
        let mut all = BTreeMap::new();
        for joint in &self.joints {
            for column in joint.columns() {
                if let Some(sensor) = joint.model.spec().sensors.get(joint.at_drive(column)) {
                    all.insert(joint.channel(column), *sensor);
                }
            }
        }
        all.extend(self.file.sensors.clone());
        all
    }

    /// The file with these parameter values and their standard deviations (those that are missing or not positive are
    /// left out).
    #[must_use]
    pub fn fitted_file(&self, values: &[f64], stds: &[f64]) -> RobotFile {
        let of = |i: usize| EffectValue {
            value: values[i],
            std: stds.get(i).copied().filter(|s| *s > 0.0 && s.is_finite()),
        };
        let mut file = self.file.as_ref().clone();
        for (i, p) in self.parameters.iter().enumerate() {
            let base = !p.name.contains('.');
            if base && (!p.fixed || values[i] != p.value) {
                file.parameters.insert(p.name.clone(), of(i));
            }
        }
        let at_joint = |joint: &Joint| {
            let own = |all: &[f64]| {
                joint.at.iter().map(|i| all.get(*i).copied().unwrap_or(0.0)).collect::<Vec<_>>()
            };
            joint.model.effect_specs(&own(values), &own(stds))
        };
        let effect = |(place, id): &(Place, String)| {
            let placed = self.placed(*place, id);
            let joint = match *place {
                Place::Link(link) => {
                    return self.load_at(link).map(|load| load.spec(placed, &self.parameters, of));
                }
                Place::Joint(joint) => joint,
                Place::AllJoints => 0,
            };
            let spec = at_joint(&self.joints[joint]).into_iter().find(|spec| spec.id == *id);
            spec.map(|spec| EffectSpec { id: placed, ..spec })
        };
        file.effects = self.included.iter().filter_map(effect).collect();
        file
    }

    /// As [`Model::with_effect`], still as a robot.
    ///
    /// # Errors
    ///
    /// As [`Model::with_effect`].
    pub fn including(&self, id: &str, seen: &Excitation) -> Result<Self, ModelError> {
        let mut model = self.clone();
        model.include(id, seen)?;
        Ok(model)
    }

    fn include(&mut self, id: &str, seen: &Excitation) -> Result<(), ModelError> {
        let unknown = |suggestion| ModelError::UnknownEffect { id: id.to_owned(), suggestion };
        if alike::is_alike(id) {
            let first = self.parameters.len();
            for joint in 0..self.joints.len() {
                self.include_at(joint, id, seen, first, str::to_owned)?;
            }
            self.included.push((Place::AllJoints, id.to_owned()));
            return Ok(());
        }
        let of_link = id.strip_suffix(link_mass::ID).and_then(|place| place.strip_suffix('/'));
        if let Some(link) = of_link.and_then(|name| self.links.iter().position(|l| l.name() == name)) {
            if self.load_at(link).is_some() {
                return Err(unknown(None));
            }
            self.included.push((Place::Link(link), link_mass::ID.to_owned()));
            self.loads.push(LinkMass::at_link(&self.links[link], &mut self.parameters));
            return Ok(());
        }
        let joint = id.split_once('/').and_then(|(place, rest)| {
            self.joints.iter().position(|j| j.name == place).map(|joint| (joint, rest))
        });
        let Some((joint, rest)) = joint else {
            let known: Vec<String> = self.effects(seen).into_iter().map(|card| card.id).collect();
            return Err(unknown(nearest(id, known.iter().map(String::as_str))));
        };
        let (place, first) = (self.joints[joint].name.clone(), self.parameters.len());
        let named = |parameter: &str| format!("{place}/{parameter}");
        self.include_at(joint, rest, seen, first, named).map_err(|error| match error {
            ModelError::UnknownEffect { suggestion, .. } => {
                unknown(suggestion.map(|s| format!("{place}/{s}")))
            }
            other => other,
        })?;
        self.included.push((Place::Joint(joint), rest.to_owned()));
        Ok(())
    }

    /// Puts an effect into the drive of a joint. Its parameters are the robot's from `first` on, called as `named` says where they are
    /// not there yet.
    fn include_at(
        &mut self,
        joint: usize,
        id: &str,
        seen: &Excitation,
        first: usize,
        named: impl Fn(&str) -> String,
    ) -> Result<(), ModelError> {
        let joint = &mut self.joints[joint];
        if joint.refused.iter().any(|refused| refused == id) {
            let reason = format!("a drive with a spring at a robot's joint cannot have the effect '{id}'");
            return Err(ModelError::Setup { reason });
        }
        let with = joint.model.including(id, &joint.seen(seen))?;
        let before = Model::parameters(&joint.model).len();
        for (i, p) in Model::parameters(&with)[before..].iter().enumerate() {
            joint.at.push(first + i);
            if self.parameters.len() == first + i {
                self.parameters.push(Parameter { name: named(&p.name), ..p.clone() });
            }
        }
        joint.model = with;
        Ok(())
    }

    /// What an included effect changes of a link's mass.
    fn load_at(&self, link: usize) -> Option<&LinkMass> {
        self.loads.iter().find(|load| load.body() == self.links[link].body())
    }

    /// What an effect is called at its place.
    fn placed(&self, place: Place, id: &str) -> String {
        match place {
            Place::Joint(joint) => format!("{}/{id}", self.joints[joint].name),
            Place::AllJoints => id.to_owned(),
            Place::Link(link) => format!("{}/{id}", self.links[link].name()),
        }
    }

    /// The joints whose drive is a servo with its own position loop.
    #[must_use]
    pub fn servos(&self) -> Vec<String> {
        let servos = self.joints.iter().filter(|joint| joint.model.spec().servo.is_some());
        servos.map(|joint| joint.name.clone()).collect()
    }

    /// The same robot whose servos have other proportional gains in some records: factors by the record's name and the joint.
    #[must_use]
    pub fn with_servo_gains(mut self, gains: BTreeMap<String, BTreeMap<String, f64>>) -> Self {
        let plain = |plain: Arc<Self>| Arc::new(Self { gains: gains.clone(), ..plain.as_ref().clone() });
        self.plain = self.plain.map(plain);
        self.gains = gains;
        self
    }

    /// The links with parameter values in place.
    pub(super) fn tree_at(&self, values: &[f64]) -> MovingBodies {
        let mut tree = self.tree.clone();
        self.links.iter().for_each(|link| link.apply(values, &mut tree));
        self.loads.iter().for_each(|load| load.apply(values, &mut tree));
        tree
    }

    /// The joints' position channels.
    pub(super) fn positions(&self) -> Vec<String> {
        self.joints.iter().map(|j| j.channel(Column::Position)).collect()
    }

    /// Every channel that the robot's sensors can show.
    pub(super) fn find(&self, channel: &str) -> Option<(usize, Column)> {
        let of = |(i, joint): (usize, &Joint)| {
            joint.columns().find(|c| joint.channel(*c) == channel).map(|c| (i, c))
        };
        self.joints.iter().enumerate().find_map(of)
    }
}

impl Model for RobotModel {
    fn name(&self) -> String {
        format!("{} with its drives", self.name)
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn inputs(&self) -> &[&'static str] {
        &[]
    }

    fn predicts(&self, channel: &str) -> bool {
        self.find(channel).is_some()
    }

    fn rotary_places(&self) -> Vec<String> {
        self.joints.iter().filter(|joint| !joint.slides).map(|joint| joint.name.clone()).collect()
    }

    fn included(&self) -> Vec<String> {
        self.included.iter().map(|(joint, id)| self.placed(*joint, id)).collect()
    }

    fn effects(&self, seen: &Excitation) -> Vec<EffectCard> {
        let of = |joint: &Joint| {
            let cards = joint.model.effects(&joint.seen(seen)).into_iter();
            cards.filter(|card| !joint.refused.contains(&card.id)).collect()
        };
        let by_joint: Vec<Vec<EffectCard>> = self.joints.iter().map(of).collect();
        let alike = alike::cards(&by_joint);
        let placed = |(joint, cards): (&Joint, Vec<EffectCard>)| {
            let at = |card: EffectCard| EffectCard { id: format!("{}/{}", joint.name, card.id), ..card };
            cards.into_iter().map(at).collect::<Vec<_>>()
        };
        let of_link = |link: usize| {
            let card = self.links[link].card();
            EffectCard { id: self.placed(Place::Link(link), &card.id), ..card }
        };
        let of_links = (0..self.links.len()).filter(|link| self.load_at(*link).is_none()).map(of_link);
        alike.into_iter().chain(self.joints.iter().zip(by_joint).flat_map(placed)).chain(of_links).collect()
    }

    fn with_effect(&self, id: &str, seen: &Excitation) -> Result<Box<dyn Model>, ModelError> {
        Ok(Box::new(self.including(id, seen)?))
    }

    fn predict(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        let ran = self.ran(values, record)?;
        let internals = self.internals(&ran, record);
        Ok(Prediction { internals, ..self.outputs(&ran, record, channels)? })
    }

    fn predict_outputs(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        self.outputs(&self.ran(values, record)?, record, channels)
    }

    fn is_dear(&self) -> bool {
        self.parameters.iter().filter(|p| !p.fixed).count() > MANY_PARAMETERS
    }

    fn coarser(&self, steps_per_sample: f64) -> Box<dyn Model> {
        Box::new(Self { steps_per_sample: Some(steps_per_sample), ..self.clone() })
    }

    fn observing(&self, records: &[&Record]) -> Option<Box<dyn Model>> {
        let observed = Observed::of(records, &self.positions(), None)?;
        Some(Box::new(Self { observed: Some(Arc::new(observed)), ..self.clone() }))
    }

    /// `None` where loops of the joints' own hold their positions: an error does not grow there.
    fn forgetting(&self, records: &[&Record], memory_s: f64) -> Option<Box<dyn Model>> {
        // A piece of a run forgets at its end.
        if self.has_loop(records) || records.iter().any(|record| record.cut) {
            return None;
        }
        let period_s = records.iter().map(|record| record.mean_period_s()).fold(0.0, f64::max);
        let memory_s = memory_s.max(LEAST_MEMORY_PERIODS * period_s);
        let observed = Observed::of(records, &self.positions(), Some(1.0 / memory_s))?;
        Some(Box::new(Self { observed: Some(Arc::new(observed)), ..self.clone() }))
    }

    fn clone_box(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}
