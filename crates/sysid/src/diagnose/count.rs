//! Counts: parameters along which a prediction jumps, such as the resolution of a drive, found by simulating many values.
//!
//! The cost has a narrow minimum at the truth and many local ones beside it, and no derivative shows the way. A drive that
//! resolves its greatest command in `N` counts shifts the last of them by one where `N` changes by one: the values
//! that are tried are even in `N`. A fit holds such parameters and moves all others; in between they are searched
//! again nearby.

use super::Candidate;
use super::candidate::{symbol, values_by_name};
use super::compare::{excess, mean_square_difference};
use super::screen::looks;
use crate::Error;
use crate::data::{Data, DataRun};
use crate::fit::{self, Difference, Fit, FitOptions};
use rayon::prelude::*;
use sealegs_model::{EffectCard, Excitation, Model, Parameter, Record, Scale, Signal};

/// A logarithmic parameter with more starts than that, and a neutral value, is a count.
const STARTS: usize = 24;

/// Distance of the values that are tried, in counts of the greatest command.
const COUNTS_APART: f64 = 0.5;

/// Counts of the greatest command with which a simulation tells what one of them changes.
const ALL_COUNTS: f64 = 800.0;

/// Fewest and most counts that are tried: coarser ones anybody sees, finer ones no bench feels.
const FEWEST_COUNTS: f64 = 10.0;
/// See [`FEWEST_COUNTS`].
const MOST_COUNTS: f64 = 8000.0;

/// Ratio by which the number of counts that would leave as much as there is to explain may be off.
const ROUGHLY: f64 = 2.0;

/// Ratio between the numbers of counts that are tried to see how much counts toward zero hold back, and by which the best of
/// them may be off: half of a count is a bias, which is known better than that.
const TRUNCATED_RATIO: f64 = 1.05;
/// See [`TRUNCATED_RATIO`].
const TRUNCATED_ROUGHLY: f64 = 1.25;

/// Share of what is left that the best of them must take for the numbers about it to be tried: counts toward zero that were
/// there took 0.77 and 0.96, a mounting that moves left 0.004 to them.
const TRUNCATED_WORTH: f64 = 0.1;

/// Counts of the greatest command up to which one that is off by half of [`TRUNCATED_RATIO`] may take nothing.
const COARSE_COUNTS: f64 = 200.0;

/// What is simulated for it of the run that is explained worst, s.
const EXCERPT_S: f64 = 6.0;

/// Values that are kept, and the least ratio between them.
const KEPT: usize = 4;
/// See [`KEPT`].
const APART: f64 = 1.003;

/// Neighbourhoods in which a value is searched again: half-width as a ratio, and points to each side.
const NEARBY: [(f64, i32); 5] = [(0.02, 20), (0.002, 16), (0.0002, 8), (2e-5, 8), (2e-6, 8)];

/// First shift by which the margin of a value is measured, as a ratio, and the ratio of each to the one before.
const LEAST_SHIFT: f64 = 1e-8;
/// See [`LEAST_SHIFT`].
const FURTHER: f64 = 1.5;

/// Times that it is searched and all others are fitted.
const ROUNDS: usize = 3;

/// Whether derivatives say nothing of a parameter.
pub(super) fn is_count(p: &Parameter) -> bool {
    p.starts.len() >= STARTS && p.scale == Scale::Logarithmic && p.neutral.is_some()
}

/// The parameters of a model that a fit holds: all those of effects with a count.
pub(super) fn held(model: &dyn Model) -> Vec<String> {
    let effect =
        |p: &Parameter| p.name.rsplit_once('.').map_or(String::new(), |(effect, _)| format!("{effect}."));
    let counts: Vec<String> = model.parameters().iter().filter(|p| is_count(p)).map(effect).collect();
    let names = model.parameters().iter().map(|p| &p.name);
    names.filter(|n| counts.iter().any(|effect| n.starts_with(effect.as_str()))).cloned().collect()
}

/// Fits a model, its counts held; the standard error of a count is how far it can be moved until the error
/// rises as for one standard deviation, for derivatives see no further than the next jump. A last fit goes on from there
/// with what is free at last only.
///
/// # Errors
///
/// As [`fit::fit`].
pub fn fit_holding(data: &Data, model: &dyn Model, options: &FitOptions) -> Result<Fit, Error> {
    let held = held(model);
    let searching = FitOptions { held: held.clone(), last: false, ..options.clone() };
    let mut fitted = fit::fit(data, model, &searching)?;
    if options.last && model.parameters().iter().any(|p| p.freed_at_last) {
        let start = Some(fitted.values.clone());
        fitted = fit::fit(data, model, &FitOptions { start, starts: 1, last: true, ..searching })?;
    }
    if held.is_empty() {
        return Ok(fitted);
    }
    let there = FitOptions { start: Some(fitted.values), starts: 1, max_steps: 0, ..options.clone() };
    let (steps, converged) = (fitted.steps, fitted.converged);
    let mut fit = Fit { steps, converged, ..fit::fit(data, model, &there)? };
    for (i, p) in model.parameters().iter().enumerate().filter(|(_, p)| is_count(p) && !p.fixed) {
        fit.parameters[i].std = margin(data, model, &fit, i, p);
    }
    Ok(fit)
}

/// How far a parameter can be moved to the side where it can go further, until the cost rises as for one standard
/// deviation of noise that explains what is left.
fn margin(data: &Data, model: &dyn Model, fit: &Fit, index: usize, p: &Parameter) -> f64 {
    let at = fit.values[index];
    let size = at.abs().max(LEAST_SHIFT * (p.max - p.min));
    let most = fit.evaluation.cost + 0.5 * fit.error().powi(2).max(1.0);
    let reach = |sign: f64| {
        let shifts =
            (0..).map(|k| size * LEAST_SHIFT * FURTHER.powi(k)).take_while(|shift| *shift < p.max - p.min);
        shifts.map(|shift| (shift, at + sign * shift)).find_map(|(shift, value)| {
            let mut moved = fit.values.clone();
            moved[index] = value;
            let risen = !(p.min..=p.max).contains(&value)
                || data.evaluate(model, &moved).map_or(true, |e| e.cost > most);
            risen.then_some(shift)
        })
    };
    let reaches: Vec<Option<f64>> = [-1.0, 1.0].into_par_iter().map(reach).collect();
    reaches.into_iter().map(|r| r.unwrap_or(p.max - p.min)).fold(0.0, f64::max)
}

/// Starting values of an effect with a count that promise most on an excerpt, best first; none for other
/// effects, or where nothing can be simulated.
pub(super) fn starts(data: &Data, beside: &Candidate, seen: &Excitation, card: &EffectCard) -> Vec<Vec<f64>> {
    let dear = fit::has_many_parameters(beside.model.as_ref());
    let Some(counted) = card.parameters.iter().position(is_count).filter(|_| !dear) else {
        return Vec::new();
    };
    let blocks = &beside.fit.evaluation.blocks;
    let left = |run: usize| -> f64 {
        let of_run = || blocks.iter().filter(|b| b.run == run).flat_map(|b| &b.residual);
        of_run().map(|r| r * r).sum::<f64>() / of_run().count().max(1) as f64
    };
    let Some(worst) = (0..data.runs.len()).reduce(|a, b| if left(b) > left(a) { b } else { a }) else {
        return Vec::new();
    };
    let run = &data.runs[worst];
    let first = run.rows().next().unwrap_or(0);
    let record = head(run.record, run.record.time_s.get(first).copied().unwrap_or(0.0) + EXCERPT_S);
    let excerpt = Data::from_parts(data.channels.clone(), vec![cut(run, &record)], data.floor);
    // The card's greatest value is a tenth of the greatest command.
    let peak = 10.0 * card.parameters[counted].max;
    // What the base parameters can do in its place is left to them, as in all screening: without a count that it has, a
    // drive is fitted with another force constant.
    let Ok(fit) = fit::at_values(&excerpt, beside.model.as_ref(), &beside.fit.values, Difference::Forward)
    else {
        return Vec::new();
    };
    let near = Candidate { fit, ..beside.clone() };
    let Some(about) = as_many_as_explain(&excerpt, &near, seen, card, peak / ALL_COUNTS) else {
        return Vec::new();
    };
    // What else the effect has is where it begins, a truncation, or at its last start, rounded.
    let with = |counts: Vec<f64>, rounded: bool| -> Vec<(usize, Vec<f64>)> {
        let with = |counts: f64| {
            let own = |(i, p): (usize, &Parameter)| match p.starts.last() {
                _ if i == counted => peak / counts,
                Some(&last) if rounded => last,
                _ => p.value,
            };
            (0, card.parameters.iter().enumerate().map(own).collect())
        };
        counts.into_iter().map(with).collect()
    };
    let best_first =
        |tried: &[(usize, Vec<f64>)]| looks(&excerpt, &near, seen, std::slice::from_ref(card), tried);
    // Counts toward zero hold back as friction does, which tells about how many there are.
    let truncated = best_first(&with(apart_by(TRUNCATED_RATIO, FEWEST_COUNTS, MOST_COUNTS), false));
    let residuals: usize = near.fit.evaluation.blocks.iter().map(|b| b.residual.len()).sum();
    let noise = 0.5 * excerpt.floor.powi(2) * residuals as f64;
    let worth = TRUNCATED_WORTH * (near.fit.cost - noise).max(0.0);
    let truncated = truncated.first().filter(|look| look.drop > worth).map(|look| peak / look.start[counted]);
    // Other effects beside it leave more to explain than the counts do: all coarse ones are tried, and finer ones only
    // around the numbers that would explain what is left.
    let around = |counts: f64, ratio: f64, least: f64| {
        evenly((counts / ratio).max(least + COUNTS_APART), (counts * ratio).min(MOST_COUNTS))
    };
    let mut tried = with(evenly(FEWEST_COUNTS, COARSE_COUNTS), false);
    tried.extend(with(evenly(FEWEST_COUNTS, ALL_COUNTS), true));
    tried.extend(with(around(about, ROUGHLY, ALL_COUNTS), true));
    tried.extend(truncated.map_or(Vec::new(), |n| with(around(n, TRUNCATED_ROUGHLY, COARSE_COUNTS), false)));
    let found = best_first(&tried);
    data.add_work(&excerpt);
    let mut kept: Vec<Vec<f64>> = Vec::new();
    for start in found.into_iter().map(|look| look.start) {
        let near = |k: &Vec<f64>| (k[counted] / start[counted]).ln().abs() < APART.ln();
        if kept.len() < KEPT && !kept.iter().any(near) {
            kept.push(start);
        }
    }
    kept
}

/// Numbers of counts of the greatest command that are tried, from the first to the last.
fn evenly(first: f64, last: f64) -> Vec<f64> {
    let steps = ((last - first) / COUNTS_APART).floor();
    let all = if steps < 0.0 { 0 } else { steps as i32 + 1 };
    (0..all).map(|i| first + COUNTS_APART * f64::from(i)).collect()
}

/// Numbers of counts that are tried, each a ratio beyond the one before.
fn apart_by(ratio: f64, first: f64, last: f64) -> Vec<f64> {
    let steps = ((last / first).ln() / ratio.ln()).floor() as i32;
    (0..=steps).map(|i| first * ratio.powi(i)).collect()
}

/// About how many counts of the greatest command change as much as a candidate leaves above the noise: what a count
/// changes is in proportion to it. They are rounded (the last start of what else an effect has), for what truncated
/// ones change beside it a gain and an offset take up. `None` if it leaves nothing, or nothing can be simulated.
fn as_many_as_explain(
    data: &Data,
    near: &Candidate,
    seen: &Excitation,
    card: &EffectCard,
    count: f64,
) -> Option<f64> {
    let model = near.model.with_effect(&card.id, seen).ok()?;
    let mut values = values_by_name(model.as_ref(), &near.known());
    for (value, p) in values.iter_mut().zip(model.parameters()) {
        if symbol(&p.name, &card.id).is_some() {
            *value = if is_count(p) { count } else { p.starts.last().copied().unwrap_or(p.value) };
        }
    }
    let counted = data.evaluate(model.as_ref(), &values).ok()?;
    let left = excess(near.fit.error(), data.floor);
    (left > 0.0).then(|| (mean_square_difference(&counted, &near.fit.evaluation) / left).sqrt() * ALL_COUNTS)
}

/// A record up to a time.
fn head(record: &Record, until_s: f64) -> Record {
    let rows = record.time_s.partition_point(|&t| t <= until_s);
    let inputs = record
        .inputs
        .iter()
        .map(|s| Signal { channel: s.channel.clone(), values: s.values[..rows].to_vec() });
    Record {
        name: record.name.clone(),
        time_s: record.time_s[..rows].to_vec(),
        hold: record.hold,
        inputs: inputs.collect(),
        outputs: Vec::new(),
    }
}

/// A run as far as a shorter record goes.
fn cut<'a>(run: &DataRun<'a>, record: &'a Record) -> DataRun<'a> {
    let rows = record.len();
    DataRun {
        record,
        scored: run
            .scored
            .iter()
            .map(|r| r.start.min(rows)..r.end.min(rows))
            .filter(|r| !r.is_empty())
            .collect(),
        measured: run.measured.iter().map(|m| &m[..rows]).collect(),
        ..run.clone()
    }
}

/// A candidate whose count was searched again nearby, `fitted` from the better value each time.
#[must_use]
pub fn tuned(
    data: &Data,
    mut candidate: Candidate,
    fitted: impl Fn(&Candidate, &[(String, f64)]) -> Option<Candidate>,
) -> Candidate {
    let Some(counted) = candidate.model.parameters().iter().position(is_count) else { return candidate };
    for _ in 0..ROUNDS {
        let before = candidate.fit.cost;
        for (width, points) in NEARBY {
            let (fit, model) = (&candidate.fit, candidate.model.as_ref());
            let p = &model.parameters()[counted];
            let moved: Vec<Vec<f64>> = (-points..=points)
                .map(|i| {
                    let mut values = fit.values.clone();
                    values[counted] *= 1.0 + width * f64::from(i) / f64::from(points);
                    values
                })
                .filter(|v| (p.min..=p.max).contains(&v[counted]))
                .collect();
            let costs: Vec<f64> = moved
                .par_iter()
                .map(|values| data.evaluate(model, values).map_or(f64::INFINITY, |e| e.cost))
                .collect();
            let Some(best) = (0..costs.len()).reduce(|a, b| if costs[b] < costs[a] { b } else { a }) else {
                continue;
            };
            if moved[best][counted] == candidate.fit.values[counted] {
                continue;
            }
            let known = candidate.named(&moved[best]);
            if let Some(better) = fitted(&candidate, &known).filter(|f| f.fit.cost < candidate.fit.cost) {
                candidate = better;
            }
        }
        if candidate.fit.cost > (1.0 - 1e-3) * before {
            break;
        }
    }
    candidate
}
