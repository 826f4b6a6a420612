//! Runs of a model without any file: an actuator on a bench, a leg in a scenario.

use crate::{Error, Result};
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, DEFAULT_STEP_S, OUTPUTS};
use sealegs_leg::scenario::Scenario;
use sealegs_model::{InputHold, Model, Prediction, Record, Signal};
use std::fmt::Display;

/// An actuator on a bench, ready to be run.
///
/// ```
/// use sealegs::{BenchBuilder, actuator::bench::Bench};
///
/// let time_s: Vec<f64> = (0..1000).map(|i| 1e-3 * f64::from(i)).collect();
/// let current_a: Vec<f64> = time_s.iter().map(|t| (20.0 * t).sin()).collect();
/// let run = BenchBuilder::new("thor-linear", Bench::Locked)?.spring("stiff")?.run("current_a", time_s, current_a)?;
/// let force_n = run.output("force_1_n").expect("a locked bench has it");
/// assert_eq!(force_n.len(), 1000);
/// # Ok::<(), sealegs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BenchBuilder {
    spec: ActuatorSpec,
    bench: Bench,
    step_s: f64,
    hold: InputHold,
}

impl BenchBuilder {
    /// An actuator by the name of its preset or file.
    ///
    /// # Errors
    ///
    /// [`Error::Actuator`] if there is none of this name, or its file has an error in it.
    pub fn new(actuator: &str, bench: Bench) -> Result<Self> {
        Ok(Self::of_spec(ActuatorSpec::load(actuator, None)?, bench))
    }

    /// An actuator that was made elsewhere.
    #[must_use]
    pub fn of_spec(spec: ActuatorSpec, bench: Bench) -> Self {
        Self { spec, bench, step_s: DEFAULT_STEP_S, hold: InputHold::ZeroOrder }
    }

    /// A setting of the spring, as the actuator takes it (`compliant`, `80mm`).
    ///
    /// # Errors
    ///
    /// [`Error::Actuator`] with what the spring takes.
    pub fn spring(mut self, setting: &str) -> Result<Self> {
        self.spec = self.spec.with_spring_setting(setting)?;
        Ok(self)
    }

    /// The integrator's greatest step, s.
    #[must_use]
    pub fn step_s(mut self, step_s: f64) -> Self {
        self.step_s = step_s;
        self
    }

    /// What the command does between its samples; without this it is held (zero order).
    #[must_use]
    pub fn hold(mut self, hold: InputHold) -> Self {
        self.hold = hold;
        self
    }

    /// The model, for a comparison of one's own.
    ///
    /// # Errors
    ///
    /// If the actuator's file includes an effect that is not known.
    pub fn model(&self) -> Result<BenchModel> {
        Ok(BenchModel::new(self.spec.clone(), self.bench)?.with_step(self.step_s))
    }

    /// Runs it from rest under a command: `current_a`, `motor_force_n`, or `motor_torque_nm` of a rotary actuator, one
    /// value for each time stamp.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] if there are not as many values as time stamps; [`Error::Model`] if the actuator takes no such
    /// command or its state runs away.
    pub fn run(&self, channel: &str, time_s: Vec<f64>, command: Vec<f64>) -> Result<BenchRun> {
        if time_s.len() != command.len() {
            let (rows, expected) = (command.len(), time_s.len());
            return Err(Error::Length { channel: channel.to_owned(), rows, expected });
        }
        let record = Record {
            cut: false,
            name: "bench".to_owned(),
            time_s,
            hold: self.hold,
            inputs: vec![Signal { channel: channel.to_owned(), values: command }],
            outputs: Vec::new(),
        };
        let model = self.model()?;
        let channels: Vec<String> =
            OUTPUTS.iter().filter(|c| model.predicts(c)).map(|c| (*c).to_owned()).collect();
        let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
        let prediction = model.predict(&values, &record, &channels)?;
        Ok(BenchRun { model, record, prediction })
    }
}

/// A run on a bench.
#[derive(Debug, Clone)]
pub struct BenchRun {
    /// What was run.
    pub model: BenchModel,
    /// Time stamps and the command.
    pub record: Record,
    /// Every channel of the bench, ideal sensors' readings, and remarks on limits that were exceeded.
    pub prediction: Prediction,
}

impl BenchRun {
    /// The values of a channel, in its unit, one for each time stamp.
    #[must_use]
    pub fn output(&self, channel: &str) -> Option<&[f64]> {
        self.prediction.output(channel)
    }
}

/// A scenario of a leg, changed key by key.
///
/// ```
/// use sealegs::ScenarioBuilder;
///
/// let recorded = ScenarioBuilder::new("thor-drop").set("start.drop_height_m", 0.05).set("duration_s", 0.2).build()?.run()?;
/// println!("{:.0} N", recorded.result.peaks.ground_force_n.value);
/// # Ok::<(), sealegs::Error>(())
/// ```
#[derive(Debug, Clone)]
#[must_use]
pub struct ScenarioBuilder {
    name: String,
    set: Vec<String>,
}

impl ScenarioBuilder {
    /// A scenario by the name of its preset or file.
    pub fn new(name_or_file: impl Into<String>) -> Self {
        Self { name: name_or_file.into(), set: Vec::new() }
    }

    /// Another value of a key, dotted (`base.carriage_mass_kg`).
    pub fn set(mut self, key: &str, value: impl Display) -> Self {
        self.set.push(format!("{key}={value}"));
        self
    }

    /// The robot, by the name of its preset or its URDF.
    pub fn robot(self, name_or_file: &str) -> Self {
        self.set("robot", name_or_file)
    }

    /// Checks all keys.
    ///
    /// # Errors
    ///
    /// [`Error::Leg`] naming the file and the key.
    pub fn build(&self) -> Result<Scenario> {
        Ok(Scenario::load(&self.name, &self.set)?)
    }
}
