//! What a rig can do next, and how far apart rival explanations would come under it.

use super::Limits;
use super::adapt::{adapted, independent};
use super::excitations::Excite;
use crate::data::Data;
use crate::diagnose::Candidate;
use crate::stats;
use rayon::prelude::*;
use sealegs_model::{Prediction, Record, Signal, Unit};

/// Longest excitation, s.
const LONGEST_S: f64 = 20.0;

/// Shortest excitation, s.
const SHORTEST_S: f64 = 4.0;

/// Outputs may exceed what the campaign showed by this factor at most.
const BEYOND_SEEN: f64 = 1.2;

/// The same where a run has no amplitude that could be lowered: joints that rested are to move.
const BEYOND_SEEN_IN_RUNS: f64 = 3.0;

/// A rig as a campaign shows it.
pub(crate) struct Rig<'a> {
    data: &'a Data<'a>,
    /// The outputs' names, channel by channel.
    names: Vec<String>,
}

/// What a rig would do, with how far apart the rivals predict it.
pub(crate) struct Trial {
    /// In words.
    pub description: String,
    /// The run without its outputs.
    pub record: Record,
    /// Least root mean square difference over the pairs, noise units.
    pub apart: f64,
}

impl<'a> Rig<'a> {
    pub fn of(data: &'a Data<'a>) -> Self {
        Self { data, names: data.channels.iter().map(|c| c.name.clone()).collect() }
    }

    /// What the input has been seen to bear; `None` if there is none, or none that ever changed inside the limits.
    pub fn excite(&self, limits: Limits) -> Option<Excite> {
        let data = self.data;
        let input = data.runs.first()?.record.inputs.first()?;
        let inputs =
            || data.runs.iter().flat_map(|r| &r.record.inputs).flat_map(|s| s.values.iter().copied());
        let (low, high) = inputs().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let limit = limits.input.filter(|l| *l > 0.0).unwrap_or(f64::INFINITY);
        let (low, high) = (low.max(-limit), high.min(limit));
        if high <= low {
            return None;
        }
        // One-sided commands stay one-sided; all others swing about zero.
        let centre = 0.5 * (low + high);
        let one_sided = centre.abs() > 0.5 * (high - low) * 0.8;
        let (centre, amplitude) =
            if one_sided { (centre, 0.5 * (high - low)) } else { (0.0, high.abs().min(low.abs())) };
        let amplitude = if amplitude > 0.0 { amplitude } else { 0.5 * (high - low) };
        let periods: Vec<f64> =
            data.runs.iter().flat_map(|r| r.record.time_s.windows(2).map(|w| w[1] - w[0])).collect();
        let longest = data
            .runs
            .iter()
            .filter_map(|r| r.record.time_s.last().zip(r.record.time_s.first()).map(|(b, a)| b - a))
            .fold(0.0, f64::max);
        Some(Excite {
            amplitude,
            centre,
            duration_s: longest.clamp(SHORTEST_S, LONGEST_S),
            period_s: round_period(stats::median(&periods)),
            unit: Unit::of_channel(&input.channel).map_or("", Unit::symbol),
        })
    }

    /// A run that plays values on the input.
    fn record(&self, period_s: f64, values: Vec<f64>) -> Option<Record> {
        let like = self.data.runs.first()?.record;
        let channel = like.inputs.first()?.channel.clone();
        Some(Record {
            cut: false,
            name: "planned experiment".to_owned(),
            time_s: (0..values.len()).map(|i| i as f64 * period_s).collect(),
            hold: like.hold,
            inputs: vec![Signal { channel, values }],
            outputs: Vec::new(),
        })
    }

    fn predict(&self, c: &Candidate, values: &[f64], record: &Record) -> Option<Prediction> {
        c.model.predict(values, record, &self.names).ok()
    }

    /// The rivals' predictions of a run; `None` unless each has one.
    fn predicted(&self, rivals: &[&Candidate], record: &Record) -> Option<Vec<Prediction>> {
        rivals.iter().map(|c| self.predict(c, &c.fit.values, record)).collect()
    }

    /// A trial of an excitation, weakened until no output leaves what the campaign showed.
    pub fn excited(
        &self,
        rivals: &[&Candidate],
        excite: &Excite,
        (description, values): (String, Vec<f64>),
    ) -> Option<Trial> {
        let mut values = values;
        let mut share = 1.0;
        for _ in 0..3 {
            let record = self.record(excite.period_s, values.clone())?;
            let predicted = self.predicted(rivals, &record)?;
            let excess = self.excess(&predicted, BEYOND_SEEN);
            if excess <= 1.0 {
                let description = if share < 1.0 {
                    format!(
                        "{description} (at {:.0} % of that, so that outputs stay within {BEYOND_SEEN} times what was seen)",
                        100.0 * share
                    )
                } else {
                    description
                };
                return self.trial(description, record, &predicted);
            }
            let weaker = 0.95 / excess;
            share *= weaker;
            values.iter_mut().for_each(|v| *v = excite.centre + weaker * (*v - excite.centre));
        }
        None
    }

    /// A trial of a run of the rig's own; none if an output would leave what the campaign showed.
    pub fn run(&self, rivals: &[&Candidate], record: Record) -> Option<Trial> {
        let predicted = self.predicted(rivals, &record)?;
        let bears = self.excess(&predicted, BEYOND_SEEN_IN_RUNS) <= 1.0;
        bears.then(|| self.trial(record.name.clone(), record, &predicted)).flatten()
    }

    fn trial(&self, description: String, record: Record, predicted: &[Prediction]) -> Option<Trial> {
        let apart = self.apart(predicted);
        apart.is_finite().then_some(Trial { description, record, apart })
    }

    /// Least root mean square difference over the pairs of predictions, noise units.
    fn apart(&self, predicted: &[Prediction]) -> f64 {
        let rows: Vec<Vec<f64>> = predicted.iter().map(|p| self.rows(p)).collect();
        let mut apart = f64::INFINITY;
        for (i, a) in rows.iter().enumerate() {
            for b in &rows[i + 1..] {
                let squares: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
                apart = apart.min((squares / a.len().max(1) as f64).sqrt());
            }
        }
        apart
    }

    /// Greatest ratio of a predicted output to so many times what the campaign showed.
    fn excess(&self, predicted: &[Prediction], times: f64) -> f64 {
        let mut worst = 0.0f64;
        for p in predicted {
            for channel in &self.data.channels {
                let Some(values) = p.output(&channel.name) else { continue };
                let peak = values
                    .iter()
                    .fold(0.0f64, |m, v| if v.is_finite() { m.max(v.abs()) } else { f64::INFINITY });
                if channel.peak > 0.0 {
                    worst = worst.max(peak / (times * channel.peak));
                }
            }
        }
        worst
    }

    /// All channels of a prediction in noise units, each without its mean, which the sensor's bias takes up.
    fn rows(&self, p: &Prediction) -> Vec<f64> {
        let mut rows = Vec::new();
        for channel in &self.data.channels {
            let Some(values) = p.output(&channel.name) else { continue };
            let mean = stats::mean(values);
            let n = values.len() as f64;
            let kept = 1.0 / (1.0 + n * (channel.prior.run_bias_std / channel.noise_std).powi(2));
            rows.extend(values.iter().map(|v| (v - (1.0 - kept) * mean) / channel.noise_std));
        }
        rows
    }

    /// How far the named set and the nearest of its rivals would come apart: the root mean square difference,
    /// in noise units, that is left when one of them is the truth, with any values that the campaign admits,
    /// and the other adapts, within the same.
    pub fn refitted(&self, rivals: &[&Candidate], record: &Record) -> Option<f64> {
        let each: Vec<(Vec<f64>, Vec<Vec<f64>>)> =
            rivals.par_iter().map(|c| self.sensitivities(c, record)).collect::<Option<_>>()?;
        // The named set against each of its rivals; either may be the truth.
        let pair = |truth: usize, model: usize| -> f64 {
            let difference: Vec<f64> = each[truth].0.iter().zip(&each[model].0).map(|(a, b)| a - b).collect();
            let known = |vector: &[f64]| adapted(vector, &each[model].1, rivals[model]);
            let spread: f64 = independent(&each[truth].1, rivals[truth]).iter().map(|c| known(c)).sum();
            ((known(&difference) + spread) / difference.len().max(1) as f64).sqrt()
        };
        let apart = (1..rivals.len()).map(|j| pair(0, j).max(pair(j, 0))).fold(f64::INFINITY, f64::min);
        apart.is_finite().then_some(apart)
    }

    /// A rival's prediction, and how it changes with each free parameter by one standard error (by a typical
    /// change where the campaign says less than that).
    fn sensitivities(&self, c: &Candidate, record: &Record) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let here = self.rows(&self.predict(c, &c.fit.values, record)?);
        let columns = c
            .fit
            .free
            .iter()
            .map(|&i| {
                let (p, std) = (&c.model.parameters()[i], c.fit.parameters[i].std);
                let step = if std > 0.0 && std.is_finite() {
                    std.min(p.typical.abs().max(1e-300))
                } else {
                    return vec![0.0; here.len()];
                };
                let moved = |by: f64| -> Option<(f64, Vec<f64>)> {
                    let mut values = c.fit.values.clone();
                    values[i] = (values[i] + by).clamp(p.min, p.max);
                    let reached = values[i] - c.fit.values[i];
                    (reached.abs() > 0.1 * by.abs()).then_some(())?;
                    Some((reached, self.rows(&self.predict(c, &values, record)?)))
                };
                match moved(step).or_else(|| moved(-step)) {
                    Some((reached, rows)) => {
                        rows.iter().zip(&here).map(|(a, b)| (a - b) / reached * step).collect()
                    }
                    None => vec![0.0; here.len()],
                }
            })
            .collect();
        Some((here, columns))
    }
}

/// A sampling period as a logger is set: a whole number of microseconds where it is near one.
fn round_period(period_s: f64) -> f64 {
    let us = (period_s * 1e6).round() * 1e-6;
    if us > 0.0 && (us - period_s).abs() < 0.01 * period_s { us } else { period_s.max(1e-6) }
}
