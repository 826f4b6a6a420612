//! Test benches: an actuator between two given links, as a model that diagnosis can compare with records.
//!
//! `locked` (high impedance): both links are held. `pendulum` (moving output): link 1, the spring side, is
//! held and the screw turns a lever with a mass that hangs in gravity. `free`: link 1 is held and the output moves a
//! mass or an inertia. Either link may also be a free mass. A drive without a spring turns pendulum or load directly.
//!
//! # Where a run begins
//!
//! A model starts at rest with its spring relaxed. A drive without a spring has no such place: its run begins where its
//! log does. [`RunSetup::of_record`] takes position and speed from the log's first rows, see
//! [`start_of`]. They are nuisances of the run: what is wrong of a position is the bias of the sensor that showed it, and a
//! speed is forgotten within the drive's mechanical time constant. Where the rows tell them only roughly, every simulation
//! begins where its own motion meets these rows best. A model knows its runs by their records' names.

mod begin;
mod channel;
mod drive;
mod fed;
mod kind;
mod linear;
mod observed;
mod pendulum;
mod run;
mod sensor;
mod signature;
mod start;
mod stated;
mod step;

pub use begin::{START_LIMIT, START_STEPS};
pub use channel::{ENABLE, INPUTS, OUTPUTS, SUPPLY, TEMPERATURE};
pub use fed::{Fed, command_times};
pub use kind::Bench;
pub use linear::StateSpace;
pub use pendulum::PendulumRig;
pub use run::{FirstRows, RunSetup};
pub use sensor::{Recording, Sensor, record};
pub use start::{LONGEST_S, Start, rows_within, start_of};
pub use step::search_step_without_springs;

use crate::effect::{CATALOGUE, Effect, OwnEffect, Setting, embedded, ids};
use crate::plant::{Grid, Plant, Trace};
use crate::spec::{EffectSpec, EffectValue, narrowed};
use crate::text::nearest;
use crate::{ActuatorError, ActuatorSpec, Configuration, Kind};
use sealegs_model::{EffectCard, Excitation, Law, Model, ModelError, Parameter, Prediction, Record};
use std::sync::Arc;

/// The integrator's greatest step, s, unless another is asked for.
pub const DEFAULT_STEP_S: f64 = 1e-4;

/// An included effect: which one, at which sensor if narrowed down, and where its parameters begin.
#[derive(Debug, Clone)]
struct Included {
    id: String,
    effect: EffectRef,
    channel: Option<String>,
    first: usize,
    count: usize,
}

/// An effect of the catalogue or a user's own.
#[derive(Debug, Clone)]
enum EffectRef {
    Known(&'static dyn Effect),
    Own(Arc<dyn Effect>),
}

impl EffectRef {
    fn get(&self) -> &dyn Effect {
        match self {
            Self::Known(effect) => *effect,
            Self::Own(effect) => effect.as_ref(),
        }
    }
}

/// An actuator on a bench.
#[derive(Debug, Clone)]
pub struct BenchModel {
    spec: Arc<ActuatorSpec>,
    bench: Bench,
    step_s: f64,
    /// Fewer steps than that per sampling period, where a search is content with them.
    steps_per_sample: Option<f64>,
    parameters: Vec<Parameter>,
    included: Vec<Included>,
    own: Vec<Arc<dyn Effect>>,
    /// Measured motions of records that simulations are pulled to.
    observed: Option<Arc<observed::Observed>>,
    /// What runs have of their own, by their records' names.
    runs: Vec<RunSetup>,
}

impl BenchModel {
    /// An actuator on a bench, with the effects that its file includes.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] if the file includes an effect that is not known or a parameter that the
    /// effect does not have.
    pub fn new(spec: ActuatorSpec, bench: Bench) -> Result<Self, ActuatorError> {
        Self::with_own_effects(spec, bench, Vec::new())
    }

    /// As [`BenchModel::new`], with effects of the user's own beside the catalogue's and beside those that the
    /// file defines itself.
    ///
    /// # Errors
    ///
    /// As [`BenchModel::new`], and those of [`crate::effect::OwnEffect::from_definition`].
    pub fn with_own_effects(
        spec: ActuatorSpec,
        bench: Bench,
        own: Vec<Arc<dyn Effect>>,
    ) -> Result<Self, ActuatorError> {
        bench.check(&spec)?;
        let parameters = spec.base_parameters();
        let own = embedded(&spec.effects, own)?;
        let mut model = Self {
            spec: Arc::new(spec),
            bench,
            step_s: DEFAULT_STEP_S,
            steps_per_sample: None,
            parameters,
            included: Vec::new(),
            own,
            observed: None,
            runs: Vec::new(),
        };
        model.take_stated()?;
        Ok(model)
    }

    /// The same model with another greatest step of the integrator, s.
    #[must_use]
    pub fn with_step(mut self, step_s: f64) -> Self {
        self.step_s = step_s;
        self
    }

    /// The same model with what runs have of their own: rig, start and servo gain.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] for a rig that the actuator cannot be on.
    pub fn with_runs(mut self, runs: Vec<RunSetup>) -> Result<Self, ActuatorError> {
        for run in &runs {
            run.bench.check(&self.spec)?;
        }
        self.runs = runs;
        Ok(self)
    }

    /// The same model on another bench that its runs have, see [`RunSetup::bench`].
    #[must_use]
    pub fn on(&self, bench: Bench) -> Self {
        Self { bench, ..self.clone() }
    }

    /// What a run has of its own, if anything.
    #[must_use]
    pub fn run(&self, record: &str) -> Option<&RunSetup> {
        self.runs.iter().find(|run| run.record == record)
    }

    /// The bench of a run.
    fn bench_of(&self, record: &str) -> Bench {
        self.run(record).map_or(self.bench, |run| run.bench)
    }

    /// The included effects as a model file keeps them, for parameter `values` and standard deviations `stds`
    /// (in the order of the model's parameters; those that are missing or not positive are left out).
    #[must_use]
    pub fn effect_specs(&self, values: &[f64], stds: &[f64]) -> Vec<EffectSpec> {
        let of = |included: &Included| {
            let own = included.first..included.first + included.count;
            let symbol = |i: usize| self.parameters[i].name[included.id.len() + 1..].to_owned();
            let std = |i: usize| stds.get(i).copied().filter(|s| *s > 0.0 && s.is_finite());
            EffectSpec {
                id: included.id.clone(),
                parameters: own.map(|i| (symbol(i), EffectValue { value: values[i], std: std(i) })).collect(),
                definition: included.effect.get().definition().cloned(),
            }
        };
        self.included.iter().map(of).collect()
    }

    /// As [`Model::with_effect`], still as a bench.
    ///
    /// # Errors
    ///
    /// As [`Model::with_effect`].
    pub fn including(&self, id: &str, seen: &Excitation) -> Result<Self, ModelError> {
        let mut model = self.clone();
        model.include(id, seen)?;
        Ok(model)
    }

    /// The actuator's file.
    #[must_use]
    pub fn spec(&self) -> &ActuatorSpec {
        &self.spec
    }

    /// The bench.
    #[must_use]
    pub fn bench(&self) -> Bench {
        self.bench
    }

    /// All effects that could be added here, catalogue first, with their ids.
    fn candidates(&self, setting: &Setting) -> Vec<(String, EffectRef)> {
        let known = CATALOGUE.iter().map(|e| EffectRef::Known(*e));
        let own = self.own.iter().map(|e| EffectRef::Own(e.clone()));
        known
            .chain(own)
            .filter(|e| e.get().applies(setting))
            .flat_map(|e| ids(e.get(), setting).into_iter().map(move |id| (id, e.clone())))
            .collect()
    }

    /// An effect's card under its id, with what the file knows of its parameters.
    fn card(&self, id: &str, effect: &EffectRef, setting: &Setting) -> EffectCard {
        let card = effect.get().card(setting);
        EffectCard { id: id.to_owned(), parameters: narrowed(&self.spec, id, card.parameters), ..card }
    }

    fn include(&mut self, id: &str, seen: &Excitation) -> Result<(), ModelError> {
        let setting = self.setting(seen);
        let mut candidates = self.candidates(&setting);
        let taken = self.included.iter().any(|i| i.id == id);
        let found = candidates.iter().position(|(known, _)| known == id).filter(|_| !taken);
        let Some(found) = found else {
            let known: Vec<&str> = candidates.iter().map(|(known, _)| known.as_str()).collect();
            return Err(ModelError::UnknownEffect {
                id: id.to_owned(),
                suggestion: nearest(id, known).filter(|s| *s != id),
            });
        };
        let (id, effect) = candidates.swap_remove(found);
        let card = self.card(&id, &effect, &setting);
        let channel = id.split_once('@').map(|(_, channel)| channel.to_owned());
        self.included.push(Included {
            effect,
            channel,
            first: self.parameters.len(),
            count: card.parameters.len(),
            id: id.clone(),
        });
        self.parameters
            .extend(card.parameters.into_iter().map(|p| Parameter { name: format!("{id}.{}", p.name), ..p }));
        Ok(())
    }

    /// The plant for parameter `values` (in the order of the model's parameters) and an input channel.
    ///
    /// # Errors
    ///
    /// [`ModelError::BadParameter`] for a value that no actuator can have.
    pub fn plant(&self, values: &[f64], input: &str) -> Result<Plant, ModelError> {
        self.plant_on(self.bench, values, input)
    }

    fn plant_on(&self, bench: Bench, values: &[f64], input: &str) -> Result<Plant, ModelError> {
        let c = self.spec.coefficients();
        let value = |name: &str, otherwise: f64| {
            self.parameters.iter().position(|p| p.name == name).map_or(otherwise, |i| values[i])
        };
        for (name, must) in [("stiffness", true), ("reflected_inertia", true), ("damping", false)] {
            let v = value(name, 1.0);
            if !v.is_finite() || v < 0.0 || (must && v == 0.0) {
                let admitted = if must { "positive and finite" } else { "zero or positive, and finite" };
                return Err(ModelError::BadParameter { name: name.to_owned(), value: v, admitted });
            }
        }
        let inertia = value("reflected_inertia", c.reflected_inertia);
        let sprung = value("sprung_mass", c.sprung_mass);
        // The lumped model moves the whole mass with the spring.
        let (inertia, sprung) = match self.spec.configuration {
            Configuration::Lumped => (0.0, inertia + sprung),
            _ => (inertia, sprung),
        };
        let mut plant = Plant::new(
            inertia,
            sprung,
            value("damping", c.damping),
            if self.spec.is_rigid() { 0.0 } else { value("stiffness", c.stiffness) },
        );
        plant.travel_per_rad = value("travel_per_rad", self.spec.ratio());
        if self.spec.is_rigid() {
            plant.rigid = Some(bench.links().1);
        } else {
            (plant.link_1, plant.link_2) = bench.links();
        }
        self.drive(&mut plant, input, &value)?;
        for included in &self.included {
            let own = &values[included.first..included.first + included.count];
            included.effect.get().install(own, included.channel.as_deref(), &mut plant);
        }
        plant.part_at_transmission();
        Ok(plant)
    }

    /// The motion for parameter `values` over a record's input, before the sensors.
    ///
    /// # Errors
    ///
    /// Those of [`Model::predict`].
    pub fn simulate(&self, values: &[f64], record: &Record) -> Result<(Plant, Trace), ModelError> {
        let input = channel::input_of(record, self.inputs_of())?;
        if record.len() < 2 {
            return Err(ModelError::BadParameter {
                name: format!("number of rows of {}", record.name),
                value: record.len() as f64,
                admitted: "at least 2",
            });
        }
        let mut plant = self.plant_on(self.bench_of(&record.name), values, &input.channel)?;
        let run = self.run(&record.name);
        if let Some(run) = run {
            plant.start = run.start;
            if let Some(servo) = &mut plant.servo {
                *servo = servo.times(run.servo_gain);
            }
        }
        let rigid = plant.rigid.is_some();
        let wanted_s = step::of_record(record, self.step_s, self.steps_per_sample, rigid);
        // A series spring's linear part is exact at any step; a transmission's departs from it by its play.
        let step_s = if plant.is_parted() { plant.step_following(wanted_s, 0.0) } else { wanted_s };
        let step_s = plant.servo.map_or(step_s, |servo| {
            let load = if plant.is_parted() { 0.0 } else { self.bench_of(&record.name).links().1.mass_kg() };
            servo.step_following(step_s, self.spec.coefficients().reflected_inertia + load)
        });
        let value =
            |name: &str| self.parameters.iter().position(|p| p.name == name).map_or(0.0, |i| values[i]);
        let told = command_times(record, value);
        let command = (&*told, &input.values[..]);
        let fed =
            |plant: &Plant, grid: &Grid| Fed::of(plant, record, command, |name| record.input(name), grid);
        if let (Some(first), true) = (run.and_then(|run| run.first_rows.as_ref()), rigid) {
            let grid = Grid::covering(&record.time_s[..first.start.rows], step_s);
            let fed = fed(&plant, &grid);
            plant.start = begin::start(first, record, |start| {
                plant.start = start;
                let trace = plant.simulate_fed(grid, fed.feed()).ok()?;
                let time_s = &record.time_s[..first.start.rows];
                let channels = std::slice::from_ref(&first.channel);
                self.sensed(&plant, trace, record, time_s, channels).outputs.pop().map(|s| s.values)
            });
        }
        let grid = Grid::covering(&record.time_s, step_s);
        let fed = fed(&plant, &grid);
        let trace = match self.observed.as_ref().and_then(|o| o.observer(record, &plant, &grid, self)) {
            Some(observer) => plant.observe(grid, fed.feed(), &observer)?,
            None => plant.simulate_fed(grid, fed.feed())?,
        };
        Ok((plant, trace))
    }

    /// A simulation of a record whose channels are all known.
    fn traced(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<(Plant, Trace), ModelError> {
        match channels.iter().find(|channel| !self.predicts(channel)) {
            Some(channel) => Err(ModelError::UnknownChannel { channel: channel.clone() }),
            None => self.simulate(values, record),
        }
    }

    /// What the sensors show of a simulation at some times of a record.
    fn sensed(
        &self,
        plant: &Plant,
        trace: Trace,
        record: &Record,
        time_s: &[f64],
        channels: &[String],
    ) -> Prediction {
        let arm_m = self.bench_of(&record.name).arm_m();
        // What the logger was told, not what a fit found since.
        let nominal_stiffness = self.spec.spring.stiffness();
        channel::sense(plant, trace, arm_m, nominal_stiffness, time_s, channels)
    }
}

impl Model for BenchModel {
    fn name(&self) -> String {
        format!("{} on the {} bench", self.spec.id, self.bench.label())
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn inputs(&self) -> &[&'static str] {
        self.inputs_of()
    }

    fn predicts(&self, channel: &str) -> bool {
        channel::predicts(channel, &self.spec, &self.bench)
    }

    fn rotary_places(&self) -> Vec<String> {
        (self.spec.kind == Kind::Rotary).then(String::new).into_iter().collect()
    }

    fn included(&self) -> Vec<String> {
        self.included.iter().map(|i| i.id.clone()).collect()
    }

    fn effects(&self, seen: &Excitation) -> Vec<EffectCard> {
        let setting = self.setting(seen);
        self.candidates(&setting)
            .into_iter()
            .filter(|(id, _)| self.included.iter().all(|i| i.id != *id))
            .map(|(id, effect)| self.card(&id, &effect, &setting))
            .collect()
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
        let (plant, trace) = self.traced(values, record, channels)?;
        let arm_m = self.bench_of(&record.name).arm_m();
        let (start_s, step_s) = (trace.grid.start_s, trace.grid.step_s);
        let events = self.spec.spring_limits().over_run(start_s, step_s, &trace.force_1);
        let mut internals = channel::internals(&plant, &trace, arm_m, &record.time_s);
        let missing = self.observed.as_ref().map(|o| o.missing(record, &plant, &trace, arm_m));
        internals.extend(missing.into_iter().flatten());
        let sensed = self.sensed(&plant, trace, record, &record.time_s, channels);
        Ok(Prediction { internals, events: events.iter().map(ToString::to_string).collect(), ..sensed })
    }

    fn predict_outputs(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        let (plant, trace) = self.traced(values, record, channels)?;
        Ok(self.sensed(&plant, trace, record, &record.time_s, channels))
    }

    fn coarser(&self, steps_per_sample: f64) -> Box<dyn Model> {
        Box::new(Self { steps_per_sample: Some(steps_per_sample), ..self.clone() })
    }

    fn observing(&self, records: &[&Record]) -> Option<Box<dyn Model>> {
        let observed = observed::Observed::of(records, self.spec.is_rigid())?;
        Some(Box::new(Self { observed: Some(Arc::new(observed)), ..self.clone() }))
    }

    fn knowing(&self, law: &Law) -> Option<Box<dyn Model>> {
        let mut model = self.clone();
        model.own.push(Arc::new(OwnEffect::of_law(law).ok()?));
        let setting = model.setting(&Excitation::default());
        let known = model.candidates(&setting).iter().any(|(id, _)| *id == law.effect());
        known.then(|| Box::new(model) as Box<dyn Model>)
    }

    fn clone_box(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}
