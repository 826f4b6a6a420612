//! How many counts a drive resolves its greatest command in: where a fit of a count starts.
//!
//! A drive of `N` counts shifts the last of them by one where `N` changes by one, so that some ten thousand numbers of counts
//! are to be told apart. What each leaves out of the command is known without a simulation. What short pulses on the command
//! change is simulated, and with that, linearly, by how much the cost falls with what is left out: the numbers that promise
//! most are simulated themselves.

use super::looks;
use crate::data::{Data, DataRun};
use crate::diagnose::Candidate;
use crate::diagnose::policy::SCREEN_STEPS_PER_SAMPLE;
use crate::diagnose::refine::count::is_count;
use crate::fit::{self, Difference, Signatures};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sealegs_model::{EffectCard, Excitation, Parameter, Prediction, Record};

/// Distance of the numbers of counts that are tried.
const COUNTS_APART: f64 = 0.5;

/// Fewest and most counts that are tried: coarser ones anybody sees, finer ones no bench feels.
const FEWEST_COUNTS: f64 = 10.0;
/// See [`FEWEST_COUNTS`].
const MOST_COUNTS: f64 = 8000.0;

/// Numbers of counts that are simulated themselves.
const SIMULATED: usize = 60;

/// What is simulated of the run that is explained worst, s, and its rows at most.
const EXCERPT_S: f64 = 6.0;
/// See [`EXCERPT_S`].
const EXCERPT_ROWS: usize = 20_000;

/// Time between pulses on the command, s: no drive with a spring follows faster.
const PULSE_S: f64 = 0.02;

/// How long before the first row that is scored they begin, s: what was commanded earlier has died away.
const MEMORY_S: f64 = 1.0;

/// Their size as a share of the greatest command.
const PULSE: f64 = 1e-3;

/// Values that are kept, and the least ratio between them.
const KEPT: usize = 4;
/// See [`KEPT`].
const APART: f64 = 1.003;

/// Starting values of an effect with a count that promise most on an excerpt, best first; none for other effects, or where
/// nothing can be simulated.
pub(crate) fn starts(data: &Data, beside: &Candidate, seen: &Excitation, card: &EffectCard) -> Vec<Vec<f64>> {
    let dear = beside.model.is_dear();
    match card.parameters.iter().position(is_count).filter(|_| !dear) {
        Some(of_count) => promising(data, beside, seen, card, of_count).unwrap_or_default(),
        None => Vec::new(),
    }
}

fn promising(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    card: &EffectCard,
    of_count: usize,
) -> Option<Vec<Vec<f64>>> {
    // The card's greatest value is a tenth of the greatest command.
    let peak = 10.0 * card.parameters[of_count].max;
    let blocks = &beside.fit.evaluation.blocks;
    let left = |run: usize| -> f64 {
        let of_run = || blocks.iter().filter(|b| b.run == run).flat_map(|b| &b.residual);
        of_run().map(|r| r * r).sum::<f64>() / of_run().count().max(1) as f64
    };
    let worst = (0..data.runs.len()).reduce(|a, b| if left(b) > left(a) { b } else { a })?;
    let run = &data.runs[worst];
    let first = run.rows().next().unwrap_or(0);
    let until_s = run.record.time_s.get(first).copied().unwrap_or(0.0) + EXCERPT_S;
    let rows = run.record.time_s.partition_point(|&t| t <= until_s).min(first + EXCERPT_ROWS);
    let record = Record { outputs: Vec::new(), ..run.record.at_rows(0..rows) };
    let excerpt = Data::from_parts(data.channels.clone(), vec![cut(run, &record)], data.floor);
    // What the base parameters can do in its place is left to them, as in all screening: without a count that it has, a
    // drive is fitted with another force constant.
    let there = &beside.fit.values;
    let fit = fit::at_values(&excerpt, beside.model.as_ref(), there, Difference::Forward).ok()?;
    let near = Candidate { fit, ..beside.clone() };
    let earlier = (MEMORY_S / record.mean_period_s()) as usize;
    let from = first.saturating_sub(earlier);
    let pulses = Pulses::new(&excerpt, &near, command(&record, card, peak)?, from, PULSE * peak)?;
    let numbers = evenly(COUNTS_APART, FEWEST_COUNTS, MOST_COUNTS);
    let all: Vec<(f64, bool)> = [false, true].iter().flat_map(|r| numbers.iter().map(|n| (*n, *r))).collect();
    let falls: Vec<f64> = all
        .par_iter()
        .map(|&(number, rounded)| pulses.fall(|u| counted(u, peak / number, rounded) - u))
        .collect();
    let mut order: Vec<usize> = (0..all.len()).filter(|&i| falls[i] > 0.0).collect();
    order.sort_by(|&a, &b| falls[b].total_cmp(&falls[a]));
    order.truncate(SIMULATED);
    // What else the effect has is where it begins, a truncation, or at its last start, rounded.
    let start = |(number, rounded): (f64, bool)| -> (usize, Vec<f64>) {
        let own = |(i, p): (usize, &Parameter)| match p.starts.last() {
            _ if i == of_count => peak / number,
            Some(&last) if rounded => last,
            _ => p.value,
        };
        (0, card.parameters.iter().enumerate().map(own).collect())
    };
    let tried: Vec<_> = order.into_iter().map(|i| start(all[i])).collect();
    let found = looks(&excerpt, &near, seen, std::slice::from_ref(card), &tried);
    data.add_work(&excerpt);
    let mut kept: Vec<Vec<f64>> = Vec::new();
    for start in found.into_iter().map(|look| look.start) {
        let near = |k: &Vec<f64>| (k[of_count] / start[of_count]).ln().abs() < APART.ln();
        if kept.len() < KEPT && !kept.iter().any(near) {
            kept.push(start);
        }
    }
    Some(kept)
}

/// The input that a drive takes in counts: of those at its place the one whose greatest magnitude is nearest to the greatest
/// command.
fn command(record: &Record, card: &EffectCard, peak: f64) -> Option<usize> {
    let place = card.id.rsplit_once('/').map_or(String::new(), |(place, _)| format!("{place}."));
    let off = |i: &usize| {
        let most = record.inputs[*i].values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        (most / peak).ln().abs()
    };
    let at_place = (0..record.inputs.len()).filter(|&i| record.inputs[i].channel.starts_with(&place));
    at_place.reduce(|a, b| if off(&b) < off(&a) { b } else { a })
}

/// What pulses on the command of a single run change: triangles, each as long to either side as they are apart, so that they add
/// up to any command that is slow beside them.
struct Pulses<'a> {
    command: &'a [f64],
    /// The rows of each with their weights in its mean.
    rows: Vec<Vec<(usize, f64)>>,
    /// How the cost changes with their sizes: its gradient and its curvature, with what the base parameters take up left to them.
    gradient: DVector<f64>,
    curvature: DMatrix<f64>,
}

impl<'a> Pulses<'a> {
    /// Pulses on an input about the rows from one on; `None` if they cannot be simulated.
    fn new(data: &Data<'a>, near: &Candidate, input: usize, from: usize, size: f64) -> Option<Self> {
        let (run, model) = (data.runs.first()?, near.model.coarser(SCREEN_STEPS_PER_SAMPLE));
        let (model, values) = (model.as_ref(), &near.fit.values);
        let unchanged = data.predict_outputs(model, values).ok()?;
        let rows = run.record.len();
        let apart = (PULSE_S / run.record.mean_period_s()).round().max(1.0) as usize;
        let pulses: Vec<Vec<(usize, f64)>> =
            (from / apart..rows.div_ceil(apart) + 1).map(|pulse| triangle(pulse, apart, rows)).collect();
        let changed = |pulse: &Vec<(usize, f64)>| {
            let mut record = run.record.clone();
            for (row, height) in pulse {
                record.inputs[input].values[*row] += size * height;
            }
            let pulsed = vec![DataRun { record: &record, ..run.clone() }];
            let pulsed = Data::from_parts(data.channels.clone(), pulsed, data.floor);
            let changed = pulsed.predict_outputs(model, values).ok();
            data.add_work(&pulsed);
            changed
        };
        let changed: Vec<Vec<Prediction>> = pulses.par_iter().map(changed).collect::<Option<_>>()?;
        let columns: Vec<&[Prediction]> = changed.iter().map(Vec::as_slice).collect();
        let signatures = Signatures::new(data, &near.fit, &unchanged, &columns);
        Some(Self {
            command: &run.record.inputs[input].values,
            rows: pulses.iter().map(|pulse| weights(pulse)).collect(),
            gradient: signatures.gradient / size,
            curvature: signatures.gram / (size * size),
        })
    }

    /// By how much the cost falls where every sample of the command changes as given.
    fn fall(&self, change: impl Fn(f64) -> f64) -> f64 {
        let changes: Vec<f64> = self.command.iter().map(|u| change(*u)).collect();
        let mean = |pulse: &Vec<(usize, f64)>| pulse.iter().map(|(row, w)| w * changes[*row]).sum::<f64>();
        let sizes = DVector::from_iterator(self.rows.len(), self.rows.iter().map(mean));
        -(self.gradient.dot(&sizes) + 0.5 * sizes.dot(&(&self.curvature * &sizes)))
    }
}

/// The rows of a pulse with its heights, 1 in its middle.
fn triangle(pulse: usize, apart: usize, rows: usize) -> Vec<(usize, f64)> {
    let middle = pulse * apart;
    let height = |row: usize| 1.0 - row.abs_diff(middle) as f64 / apart as f64;
    (middle.saturating_sub(apart)..(middle + apart).min(rows)).map(|row| (row, height(row))).collect()
}

/// Heights as shares of their sum.
fn weights(pulse: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let sum: f64 = pulse.iter().map(|(_, height)| height).sum();
    pulse.iter().map(|&(row, height)| (row, if sum > 0.0 { height / sum } else { 0.0 })).collect()
}

/// A command in whole counts, rounded or truncated toward zero.
fn counted(command: f64, count: f64, rounded: bool) -> f64 {
    let counts = command.abs() / count;
    command.signum() * count * if rounded { (counts + 0.5).floor() } else { counts.floor() }
}

/// Numbers from the first to the last, so far apart.
fn evenly(apart: f64, first: f64, last: f64) -> Vec<f64> {
    let steps = ((last - first) / apart).floor() as i32;
    (0..=steps).map(|i| first + apart * f64::from(i)).collect()
}

/// A run as far as a shorter record goes.
fn cut<'a>(run: &DataRun<'a>, record: &'a Record) -> DataRun<'a> {
    let rows = record.len();
    let until = |r: &std::ops::Range<usize>| r.start.min(rows)..r.end.min(rows);
    DataRun {
        record,
        scored: run.scored.iter().map(until).filter(|r| !r.is_empty()).collect(),
        measured: run.measured.iter().map(|m| &m[..rows]).collect(),
        ..run.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Role;
    use crate::fit::FitOptions;
    use crate::toy::{Toy, campaign, run};

    #[test]
    fn counts_truncate_or_round() {
        assert_eq!([0.27, -0.27, 0.04].map(|u| counted(u, 0.125, false)), [0.25, -0.25, 0.0]);
        assert_eq!([0.32, -0.32, 0.04].map(|u| counted(u, 0.125, true)), [0.375, -0.375, 0.0]);
    }

    #[test]
    fn pulses_add_up_to_a_constant() {
        let mut sum = vec![0.0; 50];
        for pulse in 0..=50_usize.div_ceil(8) {
            triangle(pulse, 8, 50).into_iter().for_each(|(row, height)| sum[row] += height);
        }
        assert!(sum.iter().all(|s| (s - 1.0).abs() < 1e-12), "{sum:?}");
    }

    /// A linear model: what its rectified command changes, by pulses as by simulation.
    #[test]
    fn what_a_command_changes_adds_up_from_pulses() {
        let toy = Toy::new();
        let record = run(&[1.0, 4.0, 400.0], 400, 1, (0.1, 1e-4), (1.0, 0.0), 1.0);
        let campaign = campaign(vec![(Role::Fit, record)], (0.1, 1e-4));
        let data = Data::new(&campaign, Some(Role::Fit), &toy).expect("a fit run");
        let at = fit::fit(&data, &toy, &FitOptions::default()).expect("a fit");
        let near = Candidate::exactly(&data, Vec::new(), Box::new(toy), at);
        let pulses = Pulses::new(&data, &near, 0, 0, 1e-3).expect("it can be simulated");
        let mut changed = data.runs[0].record.clone();
        changed.inputs[0].values.iter_mut().for_each(|u| *u += 0.1 * u.abs());
        let more = vec![DataRun { record: &changed, ..data.runs[0].clone() }];
        let more = Data::from_parts(data.channels.clone(), more, data.floor);
        let predicted = [&data, &more]
            .map(|data| data.predict_outputs(near.model.as_ref(), &near.fit.values).expect("it runs"));
        let signatures = Signatures::new(&data, &near.fit, &predicted[0], &[&predicted[1]]);
        let truth = -(signatures.gradient[0] + 0.5 * signatures.gram[(0, 0)]);
        let fall = pulses.fall(|u| 0.1 * u.abs());
        assert!(truth < -100.0 && (fall - truth).abs() < 0.05 * truth.abs(), "{fall} {truth}");
    }
}
