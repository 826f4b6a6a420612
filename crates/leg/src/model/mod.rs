//! A leg as a model that diagnosis can compare with records: a scenario, its robot, and effects at their places.
//!
//! Commands come from the scenario's controller, or from a record's input columns: `<actuator>.current_a`
//! commands an actuator, `<joint>.target_rad` says where a joint is to be. A record tells by its name which scenario it
//! belongs to: runs of one campaign may differ in height, posture and motion. Time 0 of a record is the scenario's
//! start. A fitted value means the same part in every scenario: where a scenario's nominal value differs (another
//! spring setting), the fit's ratio to nominal is carried over.

mod experiments;
mod observed;
mod parameters;
mod predict;

use crate::LegError;
use crate::channel::{self, Channel};
use crate::effect::{self, EffectRef, LegSetting, Placed};
use crate::error::nearest;
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::simulation::{Mechanics, Simulation, load_robot};
use predict::Asked;
use sealegs_actuator::effect::{Effect, OwnEffect};
use sealegs_actuator::spec::{EffectSpec, EffectValue, SensorSpec};
use sealegs_model::{
    EffectCard, Excitation, InputHold, Law, Model, ModelError, Parameter, Prediction, Record,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The step of integration with which records are compared, s, where the scenarios' periods are multiples of it and
/// their own step is finer. Against another simulator at 20 us, a nominal drop of the THOR leg is within 0.037 of a
/// sensor's noise (root mean square of the worst channel), and one whose sole slides within about half of it
/// (`crates/reference/tests/legs.rs`); at 200 us a nominal drop was within 0.22. A search takes a quarter of a sampling period.
pub const COMPARISON_STEP_S: f64 = 1e-4;

/// The longest step that a search takes, s: in a drop the foot's contact is stiff.
const COARSEST_STEP_S: f64 = 5e-4;

/// A scenario with its robot, and the records that belong to it.
#[derive(Debug)]
struct Case {
    /// Name of the record; `None` for all that no other case names.
    record: Option<String>,
    scenario: Scenario,
    robot: Robot,
    channels: Vec<(String, Channel)>,
    /// The base parameters' values in this scenario; NaN where it has no such part.
    nominal: Vec<f64>,
    /// Whether it was not recorded but could be.
    planned: bool,
}

/// An effect that the model has, and where its parameters begin.
#[derive(Debug, Clone)]
struct Included {
    id: String,
    effect: EffectRef,
    first: usize,
    count: usize,
}

/// A leg that does what its scenarios say.
#[derive(Debug, Clone)]
pub struct LegModel {
    /// The first is for all records that have no scenario of their own.
    cases: Arc<Vec<Case>>,
    /// The base parameters' values that mean "nominal".
    reference: Arc<Vec<f64>>,
    parameters: Vec<Parameter>,
    included: Vec<Included>,
    own: Vec<Arc<dyn Effect>>,
    step_s: Option<f64>,
    /// Steps per sampling period where less exactness will do, see [`Model::coarser`].
    steps_per_sample: Option<f64>,
    /// How often the step is halved, see [`Model::finer`].
    halvings: i32,
    /// Measured motions to follow, see [`Model::observing`].
    observed: Option<Arc<observed::Observed>>,
    /// How many parameters behind the base model's are zeros of the joints' encoders: none but under an observer.
    encoder_zeros: usize,
}

impl LegModel {
    /// The leg of a scenario, with the effects that it names and those of its actuators' files.
    ///
    /// `runs` are scenarios of single records, by the records' names. `nominal` is the scenario against whose
    /// nominal values the parameters of `scenario` are ratios; it differs from `scenario` where that is a model
    /// which was fitted. `own` are effects of the user's beside those that the scenario embeds.
    ///
    /// # Errors
    ///
    /// Whatever is wrong with a scenario or its robot; [`LegError::Scenario`] for a run's scenario with effects.
    pub fn new(
        scenario: Scenario,
        nominal: &Scenario,
        runs: Vec<(String, Scenario)>,
        own: Vec<Arc<dyn Effect>>,
    ) -> Result<Self, LegError> {
        let first = load_robot(&scenario)?;
        let scenario = effect::with_effects_of_actuators(&scenario, &first)?;
        let own: Vec<Arc<dyn Effect>> = effect::own_effects(&scenario)?.into_iter().chain(own).collect();
        let parameters = parameters::of(&scenario, &first)?;
        let reference = parameters::nominal(&parameters, nominal, &load_robot(nominal)?)?;
        let mut cases = vec![Case::new(None, scenario, first, &parameters)?];
        for (record, scenario) in runs {
            if !scenario.effects.is_empty() {
                let problem = "a run's own scenario has effects; they belong into the campaign's".to_owned();
                return Err(LegError::scenario(&scenario.name, "effect", problem));
            }
            let robot = load_robot(&scenario)?;
            cases.push(Case::new(Some(record), scenario, robot, &parameters)?);
        }
        for (what, variant) in experiments::variants(&cases[0].scenario, &cases[0].robot) {
            let robot = cases[0].robot.clone();
            cases.push(Case { planned: true, ..Case::new(Some(what), variant, robot, &parameters)? });
        }
        let mut model = Self {
            cases: Arc::new(cases),
            reference: Arc::new(reference),
            parameters,
            included: Vec::new(),
            own,
            step_s: None,
            steps_per_sample: None,
            halvings: 0,
            observed: None,
            encoder_zeros: 0,
        };
        model.include_named()?;
        // What is wrong with a scenario beyond its text shows when it is put together.
        for case in model.cases.iter().filter(|c| !c.planned) {
            case.simulation(&case.scenario, &[])?;
        }
        Ok(model)
    }

    /// Includes the effects of the scenario's file with the values that it states.
    fn include_named(&mut self) -> Result<(), LegError> {
        let cases = self.cases.clone();
        let seen = Excitation::default();
        let leg = LegSetting { scenario: &cases[0].scenario, robot: &cases[0].robot, seen: &seen };
        // The same look-up as a run's, for the same messages.
        effect::of_scenario(&leg)?;
        let all = effect::candidates(&self.everything(), &self.own);
        for said in &cases[0].scenario.effects {
            let Some((card, effect)) = all.iter().find(|(card, _)| card.id == said.id) else { continue };
            let before = self.parameters.len();
            self.push(card.clone(), effect.clone());
            for parameter in &mut self.parameters[before..] {
                let Some(given) = said.parameters.get(&parameter.name[said.id.len() + 1..]) else { continue };
                said.state(*given, parameter);
            }
        }
        Ok(())
    }

    fn everything(&self) -> LegSetting<'_> {
        static NOTHING: Excitation =
            Excitation { measured: Vec::new(), ranges: Vec::new(), sample_period_s: 0.0 };
        LegSetting { scenario: &self.cases[0].scenario, robot: &self.cases[0].robot, seen: &NOTHING }
    }

    fn push(&mut self, card: EffectCard, effect: EffectRef) {
        let (id, first, count) = (card.id, self.parameters.len(), card.parameters.len());
        let named = |p: Parameter| Parameter { name: format!("{id}.{}", p.name), ..p };
        self.parameters.extend(card.parameters.into_iter().map(named));
        let place = id.split_once('/').map_or("", |(place, _)| place);
        let replaced: Vec<String> = effect.replaces().iter().map(|name| format!("{place}/{name}")).collect();
        self.parameters.iter_mut().filter(|p| replaced.contains(&p.name)).for_each(|p| p.fixed = true);
        self.included.push(Included { id, effect, first, count });
    }

    /// The same model with another step of integration, s, in place of the scenarios'; a divisor of their sample
    /// and controller periods.
    #[must_use]
    pub fn with_step(mut self, step_s: f64) -> Self {
        self.step_s = Some(step_s);
        self
    }

    /// The scenario of records that have none of their own.
    #[must_use]
    pub fn scenario(&self) -> &Scenario {
        &self.cases[0].scenario
    }

    /// What the actuators' files and the scenario know of sensors, by channel; the scenario goes before.
    #[must_use]
    pub fn sensors(&self) -> BTreeMap<String, SensorSpec> {
        let mut all = BTreeMap::new();
        for placement in &self.cases[0].robot.actuators {
            for (channel, sensor) in placement.spec.iter().flat_map(|s| &s.sensors) {
                all.insert(format!("{}.{channel}", placement.name), *sensor);
            }
        }
        for (channel, sensor) in &self.cases[0].scenario.sensors {
            let known: &mut SensorSpec = all.entry(channel.clone()).or_default();
            known.gain_std = sensor.gain_std.or(known.gain_std);
            known.bias_std = sensor.bias_std.or(known.bias_std);
        }
        all
    }

    /// As [`Model::with_effect`], still as a leg.
    ///
    /// # Errors
    ///
    /// As [`Model::with_effect`].
    pub fn including(&self, id: &str, seen: &Excitation) -> Result<Self, ModelError> {
        let candidates = effect::candidates(&LegSetting { seen, ..self.everything() }, &self.own);
        let taken = self.included.iter().any(|i| i.id == id);
        let Some((card, effect)) = candidates.iter().find(|(card, _)| card.id == id && !taken) else {
            let known = candidates.iter().map(|(card, _)| card.id.as_str());
            return Err(ModelError::UnknownEffect {
                id: id.to_owned(),
                suggestion: nearest(id, known).filter(|s| *s != id),
            });
        };
        let mut model = self.clone();
        model.push(card.clone(), effect.clone());
        Ok(model)
    }

    /// The scenario with these parameter values (in the order of the model's parameters) and their standard
    /// deviations (those that are missing or not positive are left out): what a file of this model says.
    #[must_use]
    pub fn fitted_scenario(&self, values: &[f64], stds: &[f64]) -> Scenario {
        let std = |i: usize| stds.get(i).copied().filter(|s| *s > 0.0 && s.is_finite());
        let mut scenario =
            parameters::applied(&self.cases[0], &self.parameters, &self.reference, values, &std);
        let of = |included: &Included| EffectSpec {
            id: included.id.clone(),
            parameters: (included.first..included.first + included.count)
                .map(|i| {
                    let symbol = self.parameters[i].name[included.id.len() + 1..].to_owned();
                    (symbol, EffectValue { value: values[i], std: std(i) })
                })
                .collect(),
            definition: included.effect.at_actuator().and_then(|e| e.definition().cloned()),
        };
        scenario.effects = self.included.iter().map(of).collect();
        scenario
    }

    /// The scenario of one of [`Model::experiments`], by its name.
    #[must_use]
    pub fn planned(&self, name: &str) -> Option<&Scenario> {
        let case = self.cases.iter().find(|case| case.planned && case.record.as_deref() == Some(name));
        case.map(|case| &case.scenario)
    }

    /// What keeps a record's input column from commanding this leg, if anything does.
    #[must_use]
    pub fn refuses_input(&self, record: &str, channel: &str) -> Option<String> {
        let case = self.case(record);
        predict::Input::of(channel, &case.robot).err()
    }

    fn case(&self, record: &str) -> &Case {
        let own = self.cases.iter().find(|c| c.record.as_deref() == Some(record));
        own.unwrap_or(&self.cases[0])
    }

    /// The effects with their values; where a parameter cannot be negative, what is below zero is taken as zero, as no law
    /// admits it. Bounds are no limit beside that: they are those of what the runs showed.
    fn placed(&self, values: &[f64]) -> Vec<Placed> {
        let inside = |(p, value): (&Parameter, &f64)| if p.min >= 0.0 { value.max(0.0) } else { *value };
        let of = |i: &Included| {
            let own = i.first..i.first + i.count;
            let values = self.parameters[own.clone()].iter().zip(&values[own]).map(inside);
            Placed::new(&i.id, i.effect.clone(), values.collect())
        };
        self.included.iter().map(of).collect()
    }

    /// What a run of a record shows with some values, as it is asked.
    fn predicted(&self, values: &[f64], record: &Record, asked: Asked) -> Result<Prediction, ModelError> {
        let case = self.case(&record.name);
        let mut scenario = parameters::applied(case, &self.parameters, &self.reference, values, &|_| None);
        scenario.step_s = match (self.step_s, self.steps_per_sample) {
            (Some(step_s), _) => step_s,
            (None, Some(steps)) => coarser_step(&scenario, record.mean_period_s() / steps),
            (None, None) => comparison_step(&scenario),
        };
        scenario.step_s *= 0.5_f64.powi(self.halvings);
        let effects = self.placed(values);
        match &self.observed {
            Some(observed) if observed.follows(record) => {
                let base = self.reference.len();
                let zeros_rad = &values[base..base + self.encoder_zeros];
                observed.predict(case, &scenario, (&effects, zeros_rad), record, asked)
            }
            _ => predict::predict(case, &scenario, &effects, record, asked),
        }
    }
}

/// The step with which a scenario is compared, s.
fn comparison_step(scenario: &Scenario) -> f64 {
    let divides = |period_s: f64| {
        let steps = period_s / COMPARISON_STEP_S;
        (steps - steps.round()).abs() < 1e-6 * steps
    };
    let coarser = scenario.step_s < COMPARISON_STEP_S;
    if coarser && divides(1.0 / scenario.controller.rate_hz) { COMPARISON_STEP_S } else { scenario.step_s }
}

/// The longest step up to `most_s` that divides the controller's period, s; that of a comparison where it would save
/// little.
fn coarser_step(scenario: &Scenario, most_s: f64) -> f64 {
    let period_s = 1.0 / scenario.controller.rate_hz;
    let most_s = most_s.min(COARSEST_STEP_S);
    let coarser = period_s / (period_s / most_s - 1e-9).ceil().max(1.0);
    let exact = comparison_step(scenario);
    if coarser > 1.5 * exact { coarser } else { exact }
}

impl Case {
    /// A simulation of its robot as fits take it, in a scenario with the parameters' values in it.
    fn simulation(&self, scenario: &Scenario, effects: &[Placed]) -> Result<Simulation, LegError> {
        Simulation::with_effects(scenario, self.robot.clone(), effects, Mechanics::Equations)
    }

    fn new(
        record: Option<String>,
        scenario: Scenario,
        robot: Robot,
        parameters: &[Parameter],
    ) -> Result<Self, LegError> {
        let joints: Vec<&str> = robot.moving_joints().map(|j| j.name.as_str()).collect();
        let sprung = robot.actuators.iter().filter(|a| a.spec.is_some());
        let actuators: Vec<&str> = sprung.map(|a| a.name.as_str()).collect();
        let channels = channel::all(&joints, &actuators);
        let nominal = parameters::nominal(parameters, &scenario, &robot)?;
        Ok(Self { record, channels, nominal, scenario, robot, planned: false })
    }
}

impl Model for LegModel {
    fn name(&self) -> String {
        let case = &self.cases[0];
        format!("{} in the scenario {}", case.robot.name, case.scenario.name)
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn inputs(&self) -> &[&'static str] {
        &[]
    }

    fn predicts(&self, channel: &str) -> bool {
        self.cases.iter().any(|case| case.channels.iter().any(|(name, _)| name == channel))
    }

    fn included(&self) -> Vec<String> {
        self.included.iter().map(|i| i.id.clone()).collect()
    }

    fn effects(&self, seen: &Excitation) -> Vec<EffectCard> {
        effect::candidates(&LegSetting { seen, ..self.everything() }, &self.own)
            .into_iter()
            .map(|(card, _)| card)
            .filter(|card| self.included.iter().all(|i| i.id != card.id))
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
        self.predicted(values, record, Asked { channels, inside: true })
    }

    fn predict_outputs(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        self.predicted(values, record, Asked { channels, inside: false })
    }

    fn observing(&self, records: &[&Record]) -> Option<Box<dyn Model>> {
        let observed = Arc::new(observed::Observed::of(&self.cases, records)?);
        let mut model = Self { observed: Some(observed), ..self.clone() };
        if self.encoder_zeros == 0 {
            let (zeros, base) = (observed::zeros(&self.cases[0]), self.reference.len());
            model.encoder_zeros = zeros.len();
            model.parameters.splice(base..base, zeros);
            model.included.iter_mut().for_each(|i| i.first += model.encoder_zeros);
        }
        Some(Box::new(model))
    }

    fn experiments(&self) -> Vec<Record> {
        let planned = self.cases.iter().filter(|case| case.planned);
        planned
            .map(|case| {
                let (period_s, duration_s) = (case.scenario.sample_period_s, case.scenario.duration_s);
                let samples = (duration_s / period_s).floor() as usize;
                Record {
                    cut: false,
                    name: case.record.clone().unwrap_or_default(),
                    time_s: (0..=samples).map(|i| i as f64 * period_s).collect(),
                    hold: InputHold::ZeroOrder,
                    inputs: Vec::new(),
                    outputs: Vec::new(),
                }
            })
            .collect()
    }

    fn is_dear(&self) -> bool {
        true
    }

    fn coarser(&self, steps_per_sample: f64) -> Box<dyn Model> {
        Box::new(Self { steps_per_sample: Some(steps_per_sample), halvings: 0, ..self.clone() })
    }

    fn finer(&self) -> Option<Box<dyn Model>> {
        Some(Box::new(Self { steps_per_sample: None, halvings: self.halvings + 1, ..self.clone() }))
    }

    fn knowing(&self, law: &Law) -> Option<Box<dyn Model>> {
        let mut model = self.clone();
        model.own.push(Arc::new(OwnEffect::of_law(law).ok()?));
        let known = effect::candidates(&self.everything(), &model.own);
        known.iter().any(|(card, _)| card.id == law.effect()).then(|| Box::new(model) as Box<dyn Model>)
    }

    fn clone_box(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}
