//! The signals of a run that a missing signal may depend on, at the rows of a regression.

use super::Missing;
use crate::data::Data;
use crate::diagnose::Candidate;
use crate::diagnose::policy::{CURVE_BLOCKS, CURVE_ROWS};
use sealegs_model::internal;
use std::ops::Range;

/// Samples of the command's past.
const PAST: usize = 12;

/// Play operators, whose widths are even parts of the deepest deflection.
const PLAYS: usize = 6;

/// Signals of the scored rows that a curve can be over, thinned to what a regression needs.
pub(crate) struct Rows {
    pub speed: Vec<f64>,
    pub direction: Vec<f64>,
    pub position: Vec<f64>,
    pub angle: Vec<f64>,
    pub load: Vec<f64>,
    pub deflection: Vec<f64>,
    pub stretching: Vec<f64>,
    pub time: Vec<f64>,
    pub travelled: Vec<f64>,
    pub plays: Vec<Vec<f64>>,
    pub command: Vec<f64>,
    pub motor: Vec<f64>,
    pub past: Vec<Vec<f64>>,
    pub own: Vec<f64>,
    /// The row's block.
    pub block: Vec<usize>,
}

/// The signals of a port's place, thinned.
pub(crate) fn rows(data: &Data, observed: &Candidate, missing: &Missing, step: usize) -> Rows {
    let predictions = &observed.fit.evaluation.predictions;
    // A unit's sensor has not measured the others' runs.
    let is_there = |run: usize| !missing.runs[run].is_empty();
    let thinned = |values: &[f64], run: usize| -> Vec<f64> {
        if !is_there(run) {
            return Vec::new();
        }
        let rows: Vec<usize> = data.runs[run].rows().collect();
        rows.iter().step_by(step).map(|&i| values.get(i).copied().unwrap_or(0.0)).collect()
    };
    let of = |name: &str| -> Vec<f64> {
        (0..predictions.len())
            .flat_map(|run| thinned(predictions[run].internal_at(&missing.place, name).unwrap_or(&[]), run))
            .collect()
    };
    let each = |f: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> {
        (0..data.runs.len()).flat_map(|run| thinned(&f(run), run)).collect()
    };
    let inside = |run: usize, name: &str| -> Vec<f64> {
        let rows = data.runs[run].record.len();
        let values = predictions[run].internal_at(&missing.place, name);
        values.map_or_else(|| vec![0.0; rows], <[f64]>::to_vec)
    };
    let output = missing.port == "output";
    let speed_name = if output { internal::JOINT_ANGLE } else { internal::SCREW_SPEED };
    let speed_of = |run: usize| -> Vec<f64> {
        if output {
            rate(&inside(run, speed_name), &data.runs[run].record.time_s)
        } else {
            inside(run, speed_name)
        }
    };
    let speed = each(&speed_of);
    // Below a hundredth of the usual speed a direction is noise.
    let slow = 0.01 * (speed.iter().map(|v| v * v).sum::<f64>() / speed.len().max(1) as f64).sqrt() + 1e-12;
    let mut deepest: f64 = 0.0;
    let deflection = of(internal::SPRING_DEFLECTION);
    deflection.iter().for_each(|d| deepest = deepest.max(d.abs()));
    let command_of = |run: usize| -> Vec<f64> {
        let inputs = &data.runs[run].record.inputs;
        let own = inputs.iter().find(|s| s.channel.starts_with(missing.place.as_str())).or(inputs.first());
        own.map_or_else(|| inside(run, internal::MOTOR_FORCE), |s| s.values.clone())
    };
    let late = |run: usize, by: usize| -> Vec<f64> {
        let u = command_of(run);
        (0..u.len()).map(|i| u[i.saturating_sub(by)] - u[i]).collect()
    };
    let mut block = Vec::new();
    for run in (0..data.runs.len()).filter(|&run| is_there(run)) {
        let rows = data.runs[run].scored_rows().div_ceil(step);
        let blocks = (CURVE_BLOCKS / data.runs.len() as f64).ceil().max(2.0) as usize;
        block.extend((0..rows).map(|i| run * blocks + i * blocks / rows.max(1)));
    }
    let channel = missing.port.strip_prefix("sensor/").unwrap_or("");
    let channel = channel.split('@').next().unwrap_or(channel);
    let full =
        if missing.place.is_empty() { channel.to_owned() } else { format!("{}.{channel}", missing.place) };
    let position = if output { of(internal::JOINT_ANGLE) } else { of(internal::SCREW_POSITION) };
    Rows {
        direction: speed.iter().map(|v| (v / slow).tanh()).collect(),
        position,
        angle: of(internal::ROTOR_ANGLE),
        load: of(internal::SCREW_FORCE),
        stretching: each(&|run| {
            rate(&inside(run, internal::SPRING_DEFLECTION), &data.runs[run].record.time_s)
        }),
        plays: (1..=PLAYS)
            .map(|k| {
                let width = deepest * k as f64 / (PLAYS + 1) as f64;
                each(&|run| play(&inside(run, internal::SPRING_DEFLECTION), width))
            })
            .collect(),
        time: each(&|run| data.runs[run].record.time_s.clone()),
        travelled: each(&|run| {
            let (mut sum, time_s) = (0.0, &data.runs[run].record.time_s);
            let way = |(i, v): (usize, &f64)| {
                sum += v.abs() * (time_s[i] - time_s[i.saturating_sub(1)]);
                sum
            };
            speed_of(run).iter().enumerate().map(way).collect()
        }),
        command: each(&command_of),
        motor: of(internal::MOTOR_FORCE),
        past: (1..=PAST).map(|by| each(&|run| late(run, by))).collect(),
        own: each(&|run| predictions[run].output(&full).map_or_else(Vec::new, <[f64]>::to_vec)),
        speed,
        deflection,
        block,
    }
}

/// Rate of a signal by central differences.
fn rate(values: &[f64], time_s: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
            if b > a { (values[b] - values[a]) / (time_s[b] - time_s[a]) } else { 0.0 }
        })
        .collect()
}

/// A play operator: follows its input with slack `width` to either side.
fn play(input: &[f64], width: f64) -> Vec<f64> {
    let mut at = 0.0_f64;
    input
        .iter()
        .map(|&x| {
            at = at.clamp(x - width, x + width);
            at
        })
        .collect()
}

/// Of how many samples a row of a regression is the mean.
pub(crate) fn step(runs: &[Vec<f64>]) -> usize {
    let total: usize = runs.iter().map(Vec::len).sum();
    (total as f64 / CURVE_ROWS).ceil().max(1.0) as usize
}

/// Neighbours within one run, as ranges of the runs' samples one after the other.
pub(crate) fn chunks(runs: &[Vec<f64>], every: usize) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    let of = move |run: &Vec<f64>| {
        let first = start;
        start += run.len();
        (first..start).step_by(every).map(move |i| i..(i + every).min(start)).collect::<Vec<_>>()
    };
    runs.iter().map(of).collect::<Vec<_>>().into_iter().flatten()
}

/// The means of neighbours of a column that stands along some runs, one after the other.
pub(crate) fn averaged(column: &[f64], runs: &[Vec<f64>]) -> Vec<f64> {
    if column.len() != runs.iter().map(Vec::len).sum::<usize>() {
        return Vec::new();
    }
    chunks(runs, step(runs)).map(|r| column[r.clone()].iter().sum::<f64>() / r.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_neighbours_of_different_runs_are_not_averaged() {
        let runs = vec![vec![0.0; 3], vec![0.0; 4]];
        let ranges: Vec<_> = chunks(&runs, 2).collect();
        assert_eq!(ranges, [0..2, 2..3, 3..5, 5..7]);
        let long = vec![vec![0.0; 3000]];
        let means = averaged(&(0..3000).map(f64::from).collect::<Vec<_>>(), &long);
        assert_eq!((means.len(), means[0], means[1499]), (1500, 0.5, 2998.5));
    }

    #[test]
    fn analytic_a_play_operator_follows_behind_its_slack() {
        assert_eq!(play(&[0.0, 2.0, 1.5, -1.0], 0.5), [0.0, 1.5, 1.5, -0.5]);
    }
}
