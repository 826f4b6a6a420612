//! What is missing at each port: the force that an observer needs to keep a model on the measured motion, and what each
//! sensor shows beyond it, with the uncertainty that the sensors' noise leaves.

use super::Candidate;
use super::policy::PORT_FELT;
use crate::data::{Data, Evaluation};
use crate::stats::{self, Noise};
use sealegs_model::{Model, Prediction, Record, Signal, Unit, internal};

/// A missing signal at one port.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// The actuator or joint it belongs to; empty on a bench.
    pub place: String,
    /// `rotor`, `spring`, `output`, or `sensor/CHANNEL`.
    pub port: String,
    /// Its unit.
    pub unit: String,
    /// Its values at the scored rows, run by run.
    pub runs: Vec<Vec<f64>>,
    /// Root mean square.
    pub rms: f64,
    /// Root mean square that the sensors' noise alone would leave.
    pub std: f64,
}

impl Missing {
    /// The port with its place.
    #[must_use]
    pub fn name(&self) -> String {
        if self.place.is_empty() { self.port.clone() } else { format!("{}/{}", self.place, self.port) }
    }

    /// Whether it is more than noise.
    #[must_use]
    pub fn is_felt(&self) -> bool {
        self.rms > PORT_FELT * self.std
    }
}

/// The missing signals of a model that is fitted under its observer: those of its ports, then those of the sensors.
///
/// A port's uncertainty is what the same observer finds missing in a run of the model itself to which the sensors' noise
/// is added; `open` is that model without an observer.
#[must_use]
pub fn missing(data: &Data, observed: &Candidate, open: &dyn Model) -> Vec<Missing> {
    let at = &observed.fit.evaluation;
    let quiet = noise_alone(data, observed, open);
    let mut all = ports(data, at, &at.predictions);
    for signal in &mut all {
        let same = |m: &&Missing| m.place == signal.place && m.port == signal.port;
        signal.std = quiet.iter().find(same).map_or(0.0, |m| m.rms);
    }
    all.extend(sensors(data, at));
    all
}

/// The signals of the ports in predictions.
fn ports(data: &Data, at: &Evaluation, predictions: &[Prediction]) -> Vec<Missing> {
    let Some(first) = predictions.first() else { return Vec::new() };
    let names = first.internals.iter().map(|s| &s.channel).filter(|c| c.contains(internal::MISSING));
    names
        .filter_map(|name| {
            let (place, port) = name.split_once(internal::MISSING)?;
            let place = place.trim_end_matches('.').to_owned();
            let runs: Vec<Vec<f64>> = predictions
                .iter()
                .zip(&data.runs)
                .map(|(p, run)| {
                    let values = p.internal(name).unwrap_or(&[]);
                    run.rows().filter_map(|i| values.get(i).copied()).collect()
                })
                .collect();
            let unit = if is_torque(at, port) { "N m" } else { "N" };
            Some(signal(place, port.to_owned(), unit.to_owned(), runs, 0.0))
        })
        .collect()
}

/// Whether a port's signal is a torque: at an output, and everywhere in a rotary actuator.
fn is_torque(at: &Evaluation, port: &str) -> bool {
    port == "output" || at.sensors.iter().any(|s| s.channel.ends_with("torque_nm"))
}

/// What each sensor shows beyond the model that follows the motion, in its unit.
fn sensors(data: &Data, at: &Evaluation) -> Vec<Missing> {
    data.channels
        .iter()
        .enumerate()
        .map(|(c, channel)| {
            let of = |run: usize| -> Vec<f64> {
                let block = at.blocks.iter().find(|b| b.run == run && b.channel == c);
                block.map_or_else(Vec::new, |b| b.residual.iter().map(|r| r * channel.noise_std).collect())
            };
            let runs = (0..data.runs.len()).map(of).collect();
            let unit = Unit::of_channel(&channel.name).map_or("", Unit::symbol);
            let (place, name) = channel.name.rsplit_once('.').unwrap_or(("", &channel.name));
            signal(place.to_owned(), format!("sensor/{name}"), unit.to_owned(), runs, channel.noise_std)
        })
        .collect()
}

fn signal(place: String, port: String, unit: String, runs: Vec<Vec<f64>>, std: f64) -> Missing {
    let all: Vec<f64> = runs.iter().flatten().map(|v| v * v).collect();
    Missing { place, port, unit, runs, rms: stats::mean(&all).sqrt(), std }
}

/// What the observer finds missing in the model's own prediction under the sensors' noise.
fn noise_alone(data: &Data, observed: &Candidate, open: &dyn Model) -> Vec<Missing> {
    let (at, values) = (&observed.fit.evaluation, &observed.fit.values);
    let mut noise = Noise::new(1);
    let mut noisy = |s: &Signal| {
        let std = data.channels.iter().find(|c| c.name == s.channel).map_or(0.0, |c| c.noise_std);
        let values = s.values.iter().map(|v| v + std * noise.normal()).collect();
        Signal { channel: s.channel.clone(), values }
    };
    let Ok(predicted) = data.predict(open, values) else { return Vec::new() };
    let records: Vec<Record> = data
        .runs
        .iter()
        .zip(&predicted)
        .map(|(run, p)| Record { outputs: p.outputs.iter().map(&mut noisy).collect(), ..run.record.clone() })
        .collect();
    let again = open.observing(&records.iter().collect::<Vec<_>>());
    let predicted = again.and_then(|model| data.predict(model.as_ref(), values).ok());
    predicted.map_or_else(Vec::new, |p| ports(data, at, &p))
}
