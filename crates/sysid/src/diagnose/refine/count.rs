//! Counts: parameters along which a prediction jumps, such as the resolution of a drive.
//!
//! The cost has a narrow minimum at the truth and many local ones beside it, and no derivative shows the way. A fit holds such
//! parameters where they start (see [`crate::diagnose::screen::counting`]) and moves all others; in between they are searched again nearby.

use crate::Error;
use crate::data::Data;
use crate::diagnose::Candidate;
use crate::fit::{self, Fit, FitOptions};
use rayon::prelude::*;
use sealegs_model::{Model, Parameter, Scale};

/// A logarithmic parameter with more starts than that, and a neutral value, is a count.
const STARTS: usize = 24;

/// Neighbourhoods in which a value is searched again: half-width as a ratio, and points to each side.
const NEARBY: [(f64, i32); 5] = [(0.02, 20), (0.002, 16), (0.0002, 8), (2e-5, 8), (2e-6, 8)];

/// First shift by which the margin of a value is measured, as a ratio, and the ratio of each to the one before.
const LEAST_SHIFT: f64 = 1e-8;
/// See [`LEAST_SHIFT`].
const FURTHER: f64 = 1.5;

/// Times that it is searched and all others are fitted.
const ROUNDS: usize = 3;

/// Whether derivatives say nothing of a parameter.
pub(crate) fn is_count(p: &Parameter) -> bool {
    p.starts.len() >= STARTS && p.scale == Scale::Logarithmic && p.neutral.is_some()
}

/// The parameters of a model that a fit holds: all those of effects with a count.
pub(crate) fn held(model: &dyn Model) -> Vec<String> {
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
