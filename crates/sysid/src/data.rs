//! The runs, channels and rows on which a model is compared, and one evaluation of it there.

use crate::nuisance::{self, RunSums, Sensor, SensorPrior};
use crate::{Campaign, Error, Role, stats, units};
use rayon::prelude::*;
use sealegs_model::{Excitation, Model, Prediction, Record, SignalRange};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// An output channel that is compared: one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// The unit that it measures, where the campaign has several (see [`crate::units`]): each has its own sensors.
    pub unit: Option<String>,
    /// Noise, one standard deviation, in its unit: residuals are divided by it.
    pub noise_std: f64,
    /// The step of its values, where they lie on a grid that is coarser than the noise.
    pub quantum: Option<f64>,
    /// What is known of its sensor.
    pub prior: SensorPrior,
    /// Greatest magnitude that was measured.
    pub peak: f64,
}

/// A run that is compared.
#[derive(Debug, Clone)]
pub struct DataRun<'a> {
    /// The run's index in the campaign.
    pub index: usize,
    /// Its role.
    pub role: Role,
    /// All its rows: the model simulates from the first one.
    pub record: &'a Record,
    /// The rows that count, ascending and disjoint. Cross-validation narrows them.
    pub scored: Vec<Range<usize>>,
    /// Indices of its channels in [`Data::channels`].
    pub channels: Vec<usize>,
    /// Their names, as a prediction is asked for them.
    pub names: Vec<String>,
    /// Their measured values.
    pub measured: Vec<&'a [f64]>,
}

impl DataRun<'_> {
    /// Number of rows that count.
    #[must_use]
    pub fn scored_rows(&self) -> usize {
        self.scored.iter().map(Range::len).sum()
    }

    /// The rows that count.
    pub fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.scored.iter().cloned().flatten()
    }
}

/// What is compared, and a count of the work done on it.
#[derive(Debug)]
pub struct Data<'a> {
    /// The channels of all runs.
    pub channels: Vec<Channel>,
    /// The runs.
    pub runs: Vec<DataRun<'a>>,
    /// The campaign's noise floor (see [`Campaign::noise_floor`]).
    pub floor: f64,
    /// The model's places that are rotary (see [`Model::rotary_places`]).
    rotary: Vec<String>,
    simulations: AtomicU64,
    simulated_ms: AtomicU64,
    steps: AtomicU64,
}

impl Clone for Data<'_> {
    fn clone(&self) -> Self {
        let parts = Self::from_parts(self.channels.clone(), self.runs.clone(), self.floor);
        Self { rotary: self.rotary.clone(), ..parts }
    }
}

/// The residual of one run and channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Index of the run in [`Data::runs`].
    pub run: usize,
    /// Index of the channel in [`Data::channels`].
    pub channel: usize,
    /// Place of the channel in the run's own list, and so in its predictions.
    pub slot: usize,
    /// Measured minus predicted through the sensor, in noise units, at the scored rows.
    pub residual: Vec<f64>,
}

/// One evaluation of a model on the data.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// The parameter values.
    pub values: Vec<f64>,
    /// The raw predictions, run by run.
    pub predictions: Vec<Prediction>,
    /// The sensors with their best gain and bias, channel by channel.
    pub sensors: Vec<Sensor>,
    /// Residuals, ordered by run, then channel.
    pub blocks: Vec<Block>,
    /// Half the sum of squared residuals and squared prior rows (of sensors; a fit adds its parameters').
    pub cost: f64,
    /// Root mean square of all residuals, in noise units: 1 is the noise floor.
    pub rms: f64,
}

impl Evaluation {
    /// Number of residuals.
    #[must_use]
    pub fn residuals(&self) -> usize {
        self.blocks.iter().map(|b| b.residual.len()).sum()
    }
}

impl<'a> Data<'a> {
    /// The runs of a campaign with one role (or all), on every output channel that the model predicts.
    ///
    /// # Errors
    ///
    /// [`Error::NoRun`] if there is no run of the role; whatever [`Campaign::check_against`] refuses.
    pub fn new(campaign: &'a Campaign, role: Option<Role>, model: &dyn Model) -> Result<Self, Error> {
        campaign.check_against(model)?;
        if let Some(role) = role {
            campaign.require(role)?;
        }
        let mut channels: Vec<Channel> = Vec::new();
        let mut runs = Vec::new();
        let several = !units::of_campaign(campaign).is_empty();
        for (index, run) in campaign.runs.iter().enumerate() {
            if role.is_some_and(|r| r != run.role) {
                continue;
            }
            let outputs: Vec<_> = run.record.outputs.iter().filter(|s| model.predicts(&s.channel)).collect();
            let unit = run.unit.as_ref().filter(|_| several);
            let is = |c: &Channel, name: &str| c.name == name && c.unit.as_ref() == unit;
            for signal in &outputs {
                if !channels.iter().any(|c| is(c, &signal.channel)) {
                    channels.push(channel(campaign, &signal.channel, unit));
                }
            }
            runs.push(DataRun {
                index,
                role: run.role,
                record: &run.record,
                scored: run.counted(),
                channels: outputs
                    .iter()
                    .filter_map(|s| channels.iter().position(|c| is(c, &s.channel)))
                    .collect(),
                names: outputs.iter().map(|s| s.channel.clone()).collect(),
                measured: outputs.iter().map(|s| s.values.as_slice()).collect(),
            });
        }
        let parts = Self::from_parts(channels, runs, campaign.noise_floor());
        Ok(Self { rotary: model.rotary_places(), ..parts })
    }

    /// Data of these channels and runs with a noise floor.
    #[must_use]
    pub fn from_parts(channels: Vec<Channel>, runs: Vec<DataRun<'a>>, floor: f64) -> Self {
        let none = || AtomicU64::new(0);
        let rotary = Vec::new();
        Self { channels, runs, floor, rotary, simulations: none(), simulated_ms: none(), steps: none() }
    }

    /// Whether the model's signals at a place are angular; a bench's only actuator has no name.
    #[must_use]
    pub fn is_rotary(&self, place: &str) -> bool {
        self.rotary.iter().any(|of| of == place)
    }

    /// The same with other rows counted, run by run: for cross-validation inside the runs.
    #[must_use]
    pub fn with_scored(&self, scored: Vec<Vec<Range<usize>>>) -> Self {
        let mut data = self.clone();
        for (run, rows) in data.runs.iter_mut().zip(scored) {
            run.scored = rows;
        }
        data
    }

    /// Simulations done so far, and the seconds of experiment that they covered.
    #[must_use]
    pub fn work(&self) -> (u64, f64) {
        let ms = self.simulated_ms.load(Ordering::Relaxed);
        (self.simulations.load(Ordering::Relaxed), ms as f64 * 1e-3)
    }

    /// Integration steps of all simulations so far (see [`Prediction::steps`]).
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps.load(Ordering::Relaxed)
    }

    /// Counts the work that was done on a part of these data.
    pub fn add_work(&self, part: &Data) {
        let add = |to: &AtomicU64, of: &AtomicU64| {
            to.fetch_add(of.load(Ordering::Relaxed), Ordering::Relaxed);
        };
        add(&self.simulations, &part.simulations);
        add(&self.simulated_ms, &part.simulated_ms);
        add(&self.steps, &part.steps);
    }

    /// Predicts one run.
    ///
    /// # Errors
    ///
    /// [`Error::Model`] with the run's name; also if a predicted value is not finite.
    pub fn predict_run(&self, run: usize, model: &dyn Model, values: &[f64]) -> Result<Prediction, Error> {
        self.simulated(run, |record, channels| model.predict(values, record, channels))
    }

    /// The outputs of [`Data::predict_run`] alone.
    ///
    /// # Errors
    ///
    /// As [`Data::predict_run`].
    pub fn predict_outputs_of_run(
        &self,
        run: usize,
        model: &dyn Model,
        values: &[f64],
    ) -> Result<Prediction, Error> {
        self.simulated(run, |record, channels| model.predict_outputs(values, record, channels))
    }

    fn simulated(
        &self,
        run: usize,
        simulate: impl FnOnce(&Record, &[String]) -> Result<Prediction, sealegs_model::ModelError>,
    ) -> Result<Prediction, Error> {
        let r = &self.runs[run];
        self.simulations.fetch_add(1, Ordering::Relaxed);
        let span = r.record.duration_s();
        self.simulated_ms.fetch_add((1e3 * span) as u64, Ordering::Relaxed);
        let failed = |source| Error::Model { run: r.record.name.clone(), source };
        let prediction = simulate(r.record, &r.names).map_err(failed)?;
        self.steps.fetch_add(prediction.steps, Ordering::Relaxed);
        for signal in &prediction.outputs {
            if let Some(i) = signal.values.iter().position(|v| !v.is_finite()) {
                let time_s = r.record.time_s[i];
                return Err(failed(sealegs_model::ModelError::NotFinite {
                    time_s,
                    what: signal.channel.clone(),
                }));
            }
        }
        Ok(prediction)
    }

    /// Predicts every run, in parallel.
    ///
    /// # Errors
    ///
    /// The first run's, in the order of the runs.
    pub fn predict(&self, model: &dyn Model, values: &[f64]) -> Result<Vec<Prediction>, Error> {
        let all: Vec<_> =
            (0..self.runs.len()).into_par_iter().map(|run| self.predict_run(run, model, values)).collect();
        all.into_iter().collect()
    }

    /// The outputs of [`Data::predict`] alone.
    ///
    /// # Errors
    ///
    /// As [`Data::predict`].
    pub fn predict_outputs(&self, model: &dyn Model, values: &[f64]) -> Result<Vec<Prediction>, Error> {
        let runs = (0..self.runs.len()).into_par_iter();
        let all: Vec<_> = runs.map(|run| self.predict_outputs_of_run(run, model, values)).collect();
        all.into_iter().collect()
    }

    /// Predicts, solves the sensors' gain and bias on these data, and returns the residual.
    ///
    /// # Errors
    ///
    /// As [`Data::predict`].
    pub fn evaluate(&self, model: &dyn Model, values: &[f64]) -> Result<Evaluation, Error> {
        Ok(self.evaluate_prediction(values, self.predict(model, values)?))
    }

    /// As [`Data::evaluate`], of predictions that are there already.
    #[must_use]
    pub fn evaluate_prediction(&self, values: &[f64], predictions: Vec<Prediction>) -> Evaluation {
        let sensors = (0..self.channels.len()).map(|c| self.solve_sensor(c, &predictions)).collect();
        self.with_sensors(values, predictions, sensors)
    }

    /// Judges a model on held-out data with the sensors of fitted data: gains as they are, each run's
    /// zero by its quiet start (see [`crate::nuisance`]).
    ///
    /// Channels are matched by name; one that was never fitted keeps gain 1 and gets no common bias.
    ///
    /// # Errors
    ///
    /// As [`Data::predict`].
    pub fn judge(&self, model: &dyn Model, values: &[f64], fitted: &[Sensor]) -> Result<Evaluation, Error> {
        Ok(self.judge_prediction(values, self.predict(model, values)?, fitted))
    }

    /// As [`Data::judge`], of predictions that are there already.
    #[must_use]
    pub fn judge_prediction(
        &self,
        values: &[f64],
        predictions: Vec<Prediction>,
        fitted: &[Sensor],
    ) -> Evaluation {
        let mut sensors: Vec<Sensor> = self
            .channels
            .iter()
            .map(|c| match fitted.iter().find(|s| s.channel == c.name && s.unit == c.unit) {
                Some(sensor) => Sensor { run_bias: Vec::new(), prior_cost: 0.0, ..sensor.clone() },
                None => c.sensor(&[]),
            })
            .collect();
        for (c, sensor) in sensors.iter_mut().enumerate() {
            let noise = self.channels[c].noise_std;
            for (run, data) in self.runs.iter().enumerate() {
                let Some(slot) = data.channels.iter().position(|&x| x == c) else { continue };
                let Some(predicted) = predictions[run].output(&data.names[slot]) else { continue };
                let quiet = match data.record.inputs.first() {
                    Some(input) => nuisance::quiet_start(&input.values, predicted, noise),
                    None => 0,
                };
                let measured = data.measured[slot];
                let zero = nuisance::judge_zero(sensor, noise, measured, predicted, quiet);
                let off = || data.rows().map(|i| measured[i] - sensor.gain * predicted[i] - zero).collect();
                let within = self.channels[c].quantum.map_or(0.0, |q| nuisance::within_a_step(off(), q));
                sensor.run_bias.push((run, zero + within));
            }
        }
        self.with_sensors(values, predictions, sensors)
    }

    fn solve_sensor(&self, channel: usize, predictions: &[Prediction]) -> Sensor {
        let mut sums = Vec::new();
        for (run, data) in self.runs.iter().enumerate() {
            let Some(slot) = data.channels.iter().position(|&c| c == channel) else { continue };
            let Some(predicted) = predictions[run].output(&data.names[slot]) else { continue };
            let mut s = RunSums::default();
            for i in data.rows() {
                s.add(predicted[i], data.measured[slot][i]);
            }
            sums.push((run, s));
        }
        self.channels[channel].sensor(&sums)
    }

    fn with_sensors(&self, values: &[f64], predictions: Vec<Prediction>, sensors: Vec<Sensor>) -> Evaluation {
        let mut blocks = Vec::new();
        for (run, data) in self.runs.iter().enumerate() {
            for (slot, &c) in data.channels.iter().enumerate() {
                let Some(predicted) = predictions[run].output(&data.names[slot]) else { continue };
                let (gain, zero) = (sensors[c].gain, sensors[c].bias_of(run));
                let per_noise = 1.0 / self.channels[c].noise_std;
                let measured = data.measured[slot];
                let residual =
                    data.rows().map(|i| (measured[i] - gain * predicted[i] - zero) * per_noise).collect();
                blocks.push(Block { run, channel: c, slot, residual });
            }
        }
        let squares: f64 = blocks.iter().map(|b| b.residual.iter().map(|r| r * r).sum::<f64>()).sum();
        let count: usize = blocks.iter().map(|b| b.residual.len()).sum();
        let cost = 0.5 * squares + sensors.iter().map(|s| s.prior_cost).sum::<f64>();
        let rms = (squares / count.max(1) as f64).sqrt();
        Evaluation { values: values.to_vec(), predictions, sensors, blocks, cost, rms }
    }

    /// What the runs measured and how hard they drove the model: ranges of inputs, of measured outputs and
    /// of the model's internal signals, from one prediction for each run.
    #[must_use]
    pub fn excitation<'p>(&self, predictions: impl IntoIterator<Item = &'p Prediction>) -> Excitation {
        let mut ranges: Vec<SignalRange> = Vec::new();
        let mut weight: Vec<f64> = Vec::new();
        let mut widen = |name: &str, values: &[f64]| {
            let (min, max) =
                values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
            let (squares, count) = (values.iter().map(|v| v * v).sum::<f64>(), values.len() as f64);
            match ranges.iter().position(|r| r.name == name) {
                Some(i) => {
                    let r = &mut ranges[i];
                    r.min = r.min.min(min);
                    r.max = r.max.max(max);
                    r.rms = ((r.rms * r.rms * weight[i] + squares) / (weight[i] + count)).sqrt();
                    weight[i] += count;
                }
                None if count > 0.0 => {
                    ranges.push(SignalRange {
                        name: name.to_owned(),
                        min,
                        max,
                        rms: (squares / count).sqrt(),
                    });
                    weight.push(count);
                }
                None => {}
            }
        };
        for (run, prediction) in self.runs.iter().zip(predictions) {
            for signal in run.record.inputs.iter().chain(&prediction.internals) {
                widen(&signal.channel, &signal.values);
            }
            for (name, measured) in run.names.iter().zip(&run.measured) {
                widen(name, measured);
            }
        }
        let periods: Vec<f64> = self.runs.iter().map(|r| stats::median_period(&r.record.time_s)).collect();
        let mut measured: Vec<String> = Vec::new();
        for channel in &self.channels {
            if !measured.contains(&channel.name) {
                measured.push(channel.name.clone());
            }
        }
        Excitation { measured, ranges, sample_period_s: stats::median(&periods) }
    }
}

impl Channel {
    /// Its name with that of its unit, as tables show it.
    #[must_use]
    pub fn label(&self) -> String {
        units::channel_of(&self.name, self.unit.as_deref()).into_owned()
    }

    /// Its sensor, as some runs show it.
    fn sensor(&self, sums: &[(usize, RunSums)]) -> Sensor {
        let sensor = nuisance::solve(&self.name, self.noise_std, self.prior, sums);
        Sensor { unit: self.unit.clone(), ..sensor }
    }
}

/// Noise, prior and size of a channel, the same for all roles and units.
fn channel(campaign: &Campaign, name: &str, unit: Option<&String>) -> Channel {
    Channel {
        name: name.to_owned(),
        unit: unit.cloned(),
        noise_std: campaign.noise_std(name).map_or(1.0, |n| n.std),
        quantum: campaign.noise_std(name).and_then(|n| n.quantum),
        prior: campaign.sensor_prior(name),
        peak: campaign.peak(name),
    }
}
