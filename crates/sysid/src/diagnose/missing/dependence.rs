//! What a missing signal depends on: free-form curves over signals of the run, each one linear regression, judged on
//! blocks of the fit runs that are left out one at a time.
//!
//! A curve is a sum of hat functions with half of the knots at quantiles, of harmonics of the rotor's angle, of play operators
//! (Prandtl and Ishlinskii; Brokate and Sprekels 1996), or of the command's past. What wrong parameters of the
//! base model could do in its place is regressed along with it and counts for none of it.

use super::Missing;
use super::regression::{Nuisance, Smooth, hats, known_weights, left_out, quantiles, regressed};
use super::rows::{Rows, averaged, chunks, rows, step};
use crate::data::Data;
use crate::diagnose::Candidate;
use crate::diagnose::policy::{DEPENDS, MOST_LOST, RICHER};
use nalgebra::DMatrix;
use sealegs_model::internal;

/// Knots of a curve.
const KNOTS: usize = 12;

/// Knots of a curve that is multiplied by another signal.
const FEW_KNOTS: usize = 6;

/// Harmonics of a turn of the rotor.
const HARMONICS: usize = 24;

/// Points at which a curve is drawn.
const DRAWN: usize = 41;

/// A curve over one signal, as it is drawn and written as a law.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The signal on the abscissa, by its name in the model, or the input channel's.
    pub over: String,
    /// What the curve is multiplied by: `1`, `direction` (the sign of the speed) or `deflection`.
    pub times: &'static str,
    /// Abscissas, ascending.
    pub x: Vec<f64>,
    /// The curve there, in the port's unit (over the unit of the deflection where it is multiplied by it).
    pub y: Vec<f64>,
    /// One standard error of it.
    pub std: Vec<f64>,
    /// Its points, between which it is straight: abscissas and ordinates, without the step.
    pub points: (Vec<f64>, Vec<f64>),
    /// What is added times the sign of the abscissa, in the port's unit; 0 where the form has no such step.
    pub step: f64,
}

/// One dependence of a missing signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Dependence {
    /// On what: `speed`, `direction of motion`, `position`, ...
    pub on: &'static str,
    /// Share of the signal above its noise that it predicts on left-out blocks.
    pub explained: f64,
    /// Coefficients that it takes.
    pub coefficients: usize,
    /// Its curve, where it has one.
    pub curve: Option<Curve>,
}

/// How a dependence is made of the rows' signals.
pub(crate) struct Form {
    pub on: &'static str,
    over: &'static str,
    pub times: &'static str,
    pub columns: Vec<Vec<f64>>,
    /// Knots and the abscissa, for forms that are curves of hats.
    pub knots: Option<Vec<f64>>,
}

impl Form {
    /// Its smoothness, where its columns come after others.
    pub(crate) fn smooth(&self, first: usize) -> Option<Smooth<'_>> {
        self.knots.as_ref().map(|knots| Smooth { first, knots })
    }
}

/// The dependences of a missing signal, the one that predicts most first; empty where nothing does.
///
/// `nuisances` are what wrong base parameters would show in it.
#[must_use]
pub(crate) fn dependences(
    data: &Data,
    observed: &Candidate,
    missing: &Missing,
    nuisances: &[Nuisance],
) -> Vec<Dependence> {
    let mean = |column: &[f64]| averaged(column, &missing.runs);
    let target = mean(&missing.runs.concat());
    if target.len() < 10 * KNOTS {
        return Vec::new();
    }
    let mut rows = rows(data, observed, missing, 1);
    let every = step(&missing.runs);
    rows.block = chunks(&missing.runs, every).map(|r| rows.block[r.start]).collect();
    let mut base: Vec<Vec<f64>> = nuisances.iter().map(|n| mean(&n.runs.concat())).collect();
    base.push(vec![1.0; target.len()]);
    let known = known_weights(nuisances, &target);
    // The noise as the base parameters leave it, too: what the observer itself is off follows the motion.
    let quiet = mean(&missing.quiet.concat());
    let noise = if quiet.len() == target.len() {
        left_out(&base, &quiet, &rows.block, (&known_weights(nuisances, &quiet), None))
    } else {
        target.len() as f64 * missing.slow.1.powi(2)
    };
    let alone = left_out(&base, &target, &rows.block, (&known, None));
    // A method's own error is no white noise that a curve could not predict: at least half of the signal counts.
    let signal = (alone - noise).max(0.5 * alone).max(f64::MIN_POSITIVE);
    let motor = mean(&rows.motor);
    let mut found: Vec<Dependence> = forms(&rows, missing.port.starts_with("sensor/"))
        .into_iter()
        .filter(|f| f.columns.iter().flatten().all(|v| v.is_finite()))
        .map(|mut form| {
            form.columns.iter_mut().for_each(|c| *c = mean(c));
            form
        })
        .filter(|form| !cancels_command(form, (&base, &known), &target, &motor))
        .map(|form| {
            let all: Vec<Vec<f64>> = base.iter().chain(&form.columns).cloned().collect();
            let left = left_out(&all, &target, &rows.block, (&known, form.smooth(base.len())));
            let explained = ((alone - left) / signal).clamp(0.0, 1.0);
            let curve = form.knots.as_ref().map(|knots| curve(&form, knots, (&base, &known), &target));
            Dependence { on: form.on, explained, coefficients: form.columns.len(), curve }
        })
        .filter(|d| d.explained > DEPENDS)
        .collect();
    found.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    // Of those that predict about as much, the simplest first.
    if let Some(best) = found.first().map(|d| d.explained) {
        let near = found.iter().take_while(|d| d.explained > best - RICHER).count();
        found[..near].sort_by_key(|d| d.coefficients);
    }
    found
}

/// Whether a curve over the command explains what is missing by taking the command away. Inertia, damping and command are
/// in balance: where little is known of the first two, nothing of all three fits any log.
fn cancels_command(form: &Form, (base, known): (&[Vec<f64>], &[f64]), target: &[f64], motor: &[f64]) -> bool {
    if !matches!(form.on, "command" | "command and time") || motor.len() != target.len() {
        return false;
    }
    let all: Vec<Vec<f64>> = base.iter().chain(&form.columns).cloned().collect();
    let (_, x) = regressed(&all, target, (known, None));
    let given = |i: usize| (base.len()..all.len()).map(|c| x[c] * all[c][i]).sum::<f64>();
    let (mut product, mut square) = (0.0, 0.0);
    for (i, m) in motor.iter().enumerate() {
        product += m * given(i);
        square += m * m;
    }
    product < -MOST_LOST * square
}

/// The forms that are tried.
pub(crate) fn forms(rows: &Rows, sensor: bool) -> Vec<Form> {
    let by = |column: Vec<f64>, factor: &[f64]| -> Vec<f64> {
        column.iter().zip(factor).map(|(a, b)| a * b).collect()
    };
    let curve = |on, over, x: &[f64], knots: usize| {
        let knots = quantiles(x, knots);
        Form { on, over, times: "1", columns: hats(x, &knots), knots: Some(knots) }
    };
    let times = |on, over, times, x: &[f64], factor: &[f64]| {
        // Dirt or a dent on a screw is a narrow bump.
        let knots = quantiles(x, if over == internal::SCREW_POSITION { KNOTS } else { FEW_KNOTS });
        let columns = hats(x, &knots).into_iter().map(|c| by(c, factor)).collect();
        Form { on, over, times, columns, knots: Some(knots) }
    };
    let plain = |on, columns| Form { on, over: "", times: "1", columns, knots: None };
    let mut forms = Vec::new();
    if sensor {
        forms.push(curve("its own value", "own", &rows.own, KNOTS));
    }
    let direction = &rows.direction;
    forms.push(Form {
        on: "direction of motion",
        over: internal::SCREW_SPEED,
        times: "1",
        columns: vec![direction.clone()],
        knots: None,
    });
    let mut speed = curve("speed", internal::SCREW_SPEED, &rows.speed, KNOTS);
    speed.columns.push(direction.clone());
    forms.push(speed);
    forms.push(curve("position", internal::SCREW_POSITION, &rows.position, KNOTS));
    forms.push(times(
        "direction and position",
        internal::SCREW_POSITION,
        "direction",
        &rows.position,
        direction,
    ));
    let load: Vec<f64> = rows.load.iter().map(|f| f.abs()).collect();
    forms.push(times("direction and load", internal::SCREW_FORCE, "direction", &load, direction));
    forms.push(times("direction and time", "time_s", "direction", &rows.time, direction));
    forms.push(times(
        "direction and travelled distance",
        "travelled",
        "direction",
        &rows.travelled,
        direction,
    ));
    let turns = (1..=HARMONICS).flat_map(|n| {
        let wave = |f: fn(f64) -> f64| rows.angle.iter().map(|a| f(n as f64 * a)).collect::<Vec<f64>>();
        [wave(f64::sin), wave(f64::cos)]
    });
    forms.push(plain("rotor angle", turns.collect()));
    forms.push(curve("deflection", internal::SPRING_DEFLECTION, &rows.deflection, KNOTS));
    forms.push(curve("rate of deflection", "deflection_rate", &rows.stretching, FEW_KNOTS));
    forms.push(times("deflection and time", "time_s", "deflection", &rows.time, &rows.deflection));
    forms.push(plain("deflection and its history", rows.plays.clone()));
    forms.push(curve("load", internal::SCREW_FORCE, &rows.load, KNOTS));
    forms.push(curve("time", "time_s", &rows.time, KNOTS));
    forms.push(curve("command", "command", &rows.command, KNOTS));
    forms.push(times("command and time", "time_s", "command", &rows.time, &rows.command));
    forms.push(plain("the command's past", rows.past.clone()));
    forms
}

/// The curve of a form of hats with its standard error, from all rows.
fn curve(form: &Form, knots: &[f64], (base, known): (&[Vec<f64>], &[f64]), target: &[f64]) -> Curve {
    let all: Vec<Vec<f64>> = base.iter().chain(&form.columns).cloned().collect();
    let (a, x) = regressed(&all, target, (known, form.smooth(base.len())));
    let squares: f64 = (0..target.len())
        .map(|i| (target[i] - (0..all.len()).map(|c| x[c] * all[c][i]).sum::<f64>()).powi(2))
        .sum();
    let variance = squares / (target.len() - all.len()).max(1) as f64;
    let n = all.len();
    let mut regular = a;
    (0..n).for_each(|k| regular[(k, k)] *= 1.0 + 1e-6);
    let inverse = regular.try_inverse().unwrap_or_else(|| DMatrix::zeros(n, n));
    let (low, high) = (knots[0], knots[knots.len() - 1]);
    let at: Vec<f64> = (0..DRAWN).map(|i| low + (high - low) * i as f64 / (DRAWN - 1) as f64).collect();
    let drawn = hats(&at, knots);
    let extra = form.columns.len() - knots.len();
    let value = |i: usize| -> f64 {
        let hat: f64 = (0..knots.len()).map(|k| x[base.len() + k] * drawn[k][i]).sum();
        // Beside the hats of the speed there is its direction.
        hat + if extra > 0 { x[n - 1] * at[i].signum() } else { 0.0 }
    };
    let error = |i: usize| -> f64 {
        let mut sum = 0.0;
        for k in 0..knots.len() {
            for l in 0..knots.len() {
                sum += drawn[k][i] * drawn[l][i] * inverse[(base.len() + k, base.len() + l)];
            }
        }
        (variance * sum.max(0.0)).sqrt()
    };
    Curve {
        over: form.over.to_owned(),
        times: form.times,
        y: (0..DRAWN).map(value).collect(),
        std: (0..DRAWN).map(error).collect(),
        x: at,
        points: (knots.to_vec(), x.as_slice()[base.len()..base.len() + knots.len()].to_vec()),
        step: if extra > 0 { x[n - 1] } else { 0.0 },
    }
}
