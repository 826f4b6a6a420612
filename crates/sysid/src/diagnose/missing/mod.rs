//! What is missing at each port: the force that an observer needs to keep a model on the measured motion, and what each
//! sensor shows beyond it, with the uncertainty that the sensors' noise leaves.

pub(super) mod dependence;
pub(super) mod picture;
pub(super) mod regression;
pub(super) mod rows;

use crate::data::{Data, Evaluation};
use crate::diagnose::policy::{LITTLE_SEEN, PORT_FELT, STEPS_PER_SAMPLE};
use crate::diagnose::refine::Models;
use crate::diagnose::refine::starts::with_nominal_base;
use crate::diagnose::{Candidate, values_by_name, with_effects};
use crate::stats::{self, Noise};
use dependence::{Dependence, dependences};
use picture::MissingForce;
use rayon::prelude::*;
use regression::Nuisance;
use rows::{averaged, step};
use sealegs_model::{Model, Parameter, Prediction, Record, Signal, Unit, internal};

/// A missing signal at one port.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// The actuator or joint it belongs to; empty on a bench.
    pub place: String,
    /// `rotor`, `spring`, `output`, or `sensor/CHANNEL`, with `@UNIT` behind it where the campaign has several.
    pub port: String,
    /// Its unit.
    pub unit: String,
    /// Its values at the scored rows, run by run.
    pub runs: Vec<Vec<f64>>,
    /// Root mean square.
    pub rms: f64,
    /// Root mean square that the sensors' noise alone would leave.
    pub std: f64,
    /// Root mean square of the means of neighbours (rows of a regression), and what the noise leaves of that.
    pub slow: (f64, f64),
    /// Its values where the sensors' noise alone is missing, run by run; empty where that is not known.
    pub quiet: Vec<Vec<f64>>,
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
        self.over_noise() > PORT_FELT
    }

    /// It over what the sensors' noise alone would leave, fast or slow, whichever shows it more.
    #[must_use]
    pub fn over_noise(&self) -> f64 {
        let ratio = |(signal, noise): (f64, f64)| signal / noise.max(f64::MIN_POSITIVE);
        ratio((self.rms, self.std)).max(ratio(self.slow))
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
    let mut all = ports(data, &at.predictions);
    for signal in &mut all {
        let same = |m: &&Missing| m.place == signal.place && m.port == signal.port;
        let Some(quiet) = quiet.iter().find(same) else { continue };
        (signal.std, signal.slow.1) = (quiet.rms, quiet.slow.0);
        signal.quiet.clone_from(&quiet.runs);
    }
    all.extend(sensors(data, at));
    all
}

/// The signals of the ports in predictions.
pub(crate) fn ports(data: &Data, predictions: &[Prediction]) -> Vec<Missing> {
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
            let unit = if is_torque(data, &place, port) { "N m" } else { "N" };
            Some(signal(place, port.to_owned(), unit.to_owned(), runs, 0.0))
        })
        .collect()
}

/// Whether a port's signal is a torque: at an output, everywhere in a rotary actuator, and at a robot's joint that turns.
pub(crate) fn is_torque(data: &Data, place: &str, port: &str) -> bool {
    port == "output" || data.is_rotary(place)
}

/// What each sensor shows beyond the model that follows the motion, in its unit.
pub(crate) fn sensors(data: &Data, at: &Evaluation) -> Vec<Missing> {
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
            let of_unit = channel.unit.as_ref().map_or(String::new(), |unit| format!("@{unit}"));
            let port = format!("sensor/{name}{of_unit}");
            signal(place.to_owned(), port, unit.to_owned(), runs, channel.noise_std)
        })
        .collect()
}

fn signal(place: String, port: String, unit: String, runs: Vec<Vec<f64>>, std: f64) -> Missing {
    let all: Vec<f64> = runs.iter().flatten().map(|v| v * v).collect();
    let slow = stats::rms(&averaged(&runs.concat(), &runs));
    let white = std / (step(&runs) as f64).sqrt();
    Missing {
        place,
        port,
        unit,
        rms: stats::mean(&all).sqrt(),
        std,
        slow: (slow, white),
        quiet: Vec::new(),
        runs,
    }
}

/// What the observer finds missing in the model's own prediction under the sensors' noise. An observed model has parameters of
/// its own, the zeros of sensors, so that each takes the others by name.
fn noise_alone(data: &Data, observed: &Candidate, open: &dyn Model) -> Vec<Missing> {
    let known = observed.known();
    let mut noise = Noise::new(1);
    let mut noisy = |s: &Signal| {
        let std = data.channels.iter().find(|c| c.name == s.channel).map_or(0.0, |c| c.noise_std);
        let values = s.values.iter().map(|v| v + std * noise.normal()).collect();
        Signal { channel: s.channel.clone(), values }
    };
    let Ok(predicted) = data.predict(open, &values_by_name(open, &known)) else { return Vec::new() };
    let records: Vec<Record> = data
        .runs
        .iter()
        .zip(&predicted)
        .map(|(run, p)| Record { outputs: p.outputs.iter().map(&mut noisy).collect(), ..run.record.clone() })
        .collect();
    let again = open.observing(&records.iter().collect::<Vec<_>>());
    let predicted =
        again.and_then(|model| data.predict(model.as_ref(), &values_by_name(model.as_ref(), &known)).ok());
    predicted.map_or_else(Vec::new, |p| ports(data, &p))
}

/// A port with what its missing signal depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// The missing signal.
    pub missing: Missing,
    /// What it depends on, the dependence that predicts most first; empty where nothing is felt, or nothing predicts it.
    pub depends: Vec<Dependence>,
    /// The missing signal over the first of them.
    pub force: Option<MissingForce>,
}

/// Size of the step by which a base parameter is moved for its column, as a share of its typical change.
const STEP: f64 = 1e-2;

/// What is missing at every port of the base model beside the effects of a candidate, and what that depends on; empty where
/// the model has no observer. Ports with the greatest signal over its uncertainty come first.
#[must_use]
pub fn look(models: &Models, candidate: &Candidate) -> Vec<Port> {
    let known = with_nominal_base(models.exact, &candidate.known());
    // What is missing is seen beside values that it has not driven away: where a fit leaves much, beside the stated ones.
    let fitted =
        models.observing(candidate, &known).filter(|c| c.fit.error() <= LITTLE_SEEN * models.data.floor);
    let Some(observed) = fitted.or_else(|| models.as_stated(candidate, &known)) else { return Vec::new() };
    let open = models.exact.coarser(STEPS_PER_SAMPLE);
    let Ok(open) = with_effects(open.as_ref(), &candidate.effects, &models.seen) else {
        return Vec::new();
    };
    let data = models.data;
    let all = missing(data, &observed, open.as_ref());
    // What a wrong parameter of the base model would show at each port.
    let parameters = observed.model.parameters();
    let moved: Vec<(&Parameter, Vec<Missing>)> = observed
        .fit
        .free
        .par_iter()
        .filter_map(|&i| {
            let mut values = observed.fit.values.clone();
            values[i] += STEP * parameters[i].typical;
            let predictions = data.predict(observed.model.as_ref(), &values).ok()?;
            let at = data.evaluate_prediction(&values, predictions);
            let all = ports(data, &at.predictions).into_iter().chain(sensors(data, &at));
            Some((&parameters[i], all.collect()))
        })
        .collect();
    let mut looked: Vec<Port> = all
        .into_par_iter()
        .enumerate()
        .map(|(i, missing)| {
            // Both lists hold the same ports in the same order.
            let nuisance = |(parameter, moved): &(&Parameter, Vec<Missing>)| -> Option<Nuisance> {
                let moved = moved.get(i)?;
                let known = parameter.prior_std.map(|std| std / (STEP * parameter.typical));
                let size = known.unwrap_or(1.0);
                let difference = |(a, b): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                    a.iter().zip(b).map(|(a, b)| size * (a - b)).collect()
                };
                let runs: Vec<_> = moved.runs.iter().zip(&missing.runs).map(difference).collect();
                let finite = runs.iter().flatten().all(|v| v.is_finite());
                finite.then_some(Nuisance { runs, known: known.is_some() })
            };
            let nuisances: Vec<Nuisance> = moved.iter().filter_map(nuisance).collect();
            let depends = if missing.is_felt() {
                dependences(data, &observed, &missing, &nuisances)
            } else {
                Vec::new()
            };
            let first = depends.first().map(|d| d.on);
            let force = first.and_then(|on| picture::of_port(data, &observed, &missing, &nuisances, on));
            Port { missing, depends, force }
        })
        .collect();
    let felt = |p: &Port| p.missing.over_noise();
    looked.sort_by(|a, b| felt(b).total_cmp(&felt(a)));
    // A missing force shows in every sensor behind it: a sensor's own fault comes first only where the balance says so.
    let place = |p: &Port| usize::from(p.missing.port.starts_with("sensor/"));
    looked.sort_by_key(place);
    let faulty = looked.iter().position(|p| is_sensor_fault(&looked, p));
    if let Some(first) = faulty {
        let port = looked.remove(first);
        looked.insert(0, port);
    }
    looked
}

/// Slopes of one signal on another between which they are the same.
const SAME: (f64, f64) = (0.7, 1.3);

/// Share of a signal's square that the other must explain for that.
const MOSTLY: f64 = 0.5;

/// Whether a load cell's own error makes what is missing at its spring: a force that is really there acts on the rotor and on
/// the other load cell as well, an error of the cell is missing in the balance of the rotor by just as much.
fn is_sensor_fault(ports: &[Port], cell: &Port) -> bool {
    let at =
        |name: &str| ports.iter().find(|p| p.missing.place == cell.missing.place && p.missing.port == name);
    if !matches!(cell.missing.port.as_str(), "sensor/force_1_n" | "sensor/output_torque_nm")
        || !cell.missing.is_felt()
    {
        return false;
    }
    let (Some(rotor), Some(spring)) = (at("rotor"), at("spring")) else { return false };
    let same = |a: &Missing, b: &Missing| {
        let (slope, share) = regression(&a.runs, &b.runs);
        (SAME.0..SAME.1).contains(&slope) && share > MOSTLY
    };
    let other = at("sensor/force_2_n").is_some_and(|two| same(&spring.missing, &two.missing));
    spring.missing.is_felt() && same(&spring.missing, &rotor.missing) && !other
}

/// Slope of `b` on `a` and the share of its square that it explains.
fn regression(a: &[Vec<f64>], b: &[Vec<f64>]) -> (f64, f64) {
    let pairs = || a.iter().zip(b).flat_map(|(a, b)| a.iter().zip(b));
    let sum = |f: fn(f64, f64) -> f64| pairs().map(|(a, b)| f(*a, *b)).sum::<f64>();
    let (aa, ab, bb) = (sum(|a, _| a * a), sum(|a, b| a * b), sum(|_, b| b * b));
    if aa > 0.0 && bb > 0.0 { (ab / aa, ab * ab / (aa * bb)) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::regression;

    #[test]
    fn analytic_a_line_is_found_and_explains_what_it_should() {
        let a = vec![vec![1.0, -1.0, 2.0, -2.0]];
        let b = vec![vec![2.0, -2.0, 4.0, -4.0]];
        assert_eq!(regression(&a, &b), (2.0, 1.0));
        let crossed = vec![vec![1.0, 1.0, -0.5, -0.5]];
        assert!(regression(&a, &crossed).1 < 1e-12);
    }
}
