//! What a missing signal depends on: free-form curves over signals of the run, each one linear regression, judged on
//! blocks of the fit runs that are left out one at a time.
//!
//! A curve is a sum of hat functions with half of the knots at quantiles, of harmonics of the rotor's angle, of play operators
//! (Prandtl and Ishlinskii; Brokate and Sprekels 1996), or of the command's past. What wrong parameters of the
//! base model could do in its place is regressed along with it and counts for none of it.

use super::Candidate;
use super::missing::Missing;
use super::policy::{CURVE_BLOCKS, CURVE_ROWS, DEPENDS, RICHER};
use crate::data::Data;
use crate::stats;
use nalgebra::{DMatrix, DVector};
use sealegs_model::internal;
use std::ops::Range;

/// Knots of a curve.
const KNOTS: usize = 12;

/// Knots of a curve that is multiplied by another signal.
const FEW_KNOTS: usize = 6;

/// Harmonics of a turn of the rotor.
const HARMONICS: usize = 24;

/// Samples of the command's past.
const PAST: usize = 12;

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
    /// Share of the signal above its noise that it foresees on left-out blocks.
    pub explained: f64,
    /// Coefficients that it takes.
    pub coefficients: usize,
    /// Its curve, where it has one.
    pub curve: Option<Curve>,
}

/// Signals of the scored rows that a curve can be over, thinned to what a regression needs.
pub(super) struct Rows {
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

/// How a dependence is made of the rows' signals.
pub(super) struct Form {
    pub on: &'static str,
    over: &'static str,
    times: &'static str,
    pub columns: Vec<Vec<f64>>,
    /// Knots and the abscissa, for forms that are curves of hats.
    knots: Option<Vec<f64>>,
}

impl Form {
    /// Its smoothness, where its columns come after others.
    pub(super) fn smooth(&self, first: usize) -> Option<Smooth<'_>> {
        self.knots.as_ref().map(|knots| Smooth { first, knots })
    }
}

/// What a wrong base parameter would show in a missing signal.
#[derive(Debug, Clone)]
pub(super) struct Nuisance {
    /// Its change, run by run at the scored rows: by one standard deviation of what is known of the parameter, or by any
    /// amount where nothing is known.
    pub runs: Vec<Vec<f64>>,
    /// Whether anything is known.
    pub known: bool,
}

/// The weight of what is known of nuisances in normal equations, one for each that counts: the squares of a signal over its
/// independent samples. Without it links without mass would explain every torque: the command alone is left then.
pub(super) fn known_weights(nuisances: &[Nuisance], signal: &[f64]) -> Vec<f64> {
    let mean = stats::mean(signal);
    let signal: Vec<f64> = signal.iter().map(|v| v - mean).collect();
    let squares: f64 = signal.iter().map(|v| v * v).sum();
    let weight = squares / stats::independent(&signal).max(1.0);
    nuisances.iter().map(|n| if n.known { weight } else { 0.0 }).collect()
}

/// Adds weights to the diagonal of normal equations, to their first columns.
pub(super) fn add_known(weights: &[f64], a: &mut DMatrix<f64>) {
    weights.iter().enumerate().for_each(|(k, weight)| a[(k, k)] += weight);
}

/// Hats whose ordinates are held near straight lines (Eilers and Marx 1996): where a left-out stretch alone has reached, a
/// curve goes on as it was and does not fall to zero.
pub(super) struct Smooth<'a> {
    first: usize,
    knots: &'a [f64],
}

/// Weight of a departure from a straight line over the mean weight of an ordinate in the data.
const STRAIGHT: f64 = 1e-3;

impl Smooth<'_> {
    /// Adds the weight to the normal equations.
    pub(super) fn add_to(&self, a: &mut DMatrix<f64>) {
        let n = self.knots.len();
        let weight = STRAIGHT * (0..n).map(|k| a[(self.first + k, self.first + k)]).sum::<f64>() / n as f64;
        for k in 1..n.saturating_sub(1) {
            let (before, after) = (self.knots[k] - self.knots[k - 1], self.knots[k + 1] - self.knots[k]);
            let bend = [after / (before + after), -1.0, before / (before + after)];
            for i in 0..3 {
                for j in 0..3 {
                    a[(self.first + k - 1 + i, self.first + k - 1 + j)] += weight * bend[i] * bend[j];
                }
            }
        }
    }
}

/// The dependences of a missing signal, the one that foresees most first; empty where nothing does.
///
/// `nuisances` are what wrong base parameters would show in it.
#[must_use]
pub(super) fn dependences(
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
    // A method's own error is no white noise that a curve could not foresee: at least half of the signal counts.
    let signal = (alone - noise).max(0.5 * alone).max(f64::MIN_POSITIVE);
    let motor = mean(&rows.motor);
    let mut found: Vec<Dependence> = forms(&rows, missing.port.starts_with("sensor/"))
        .into_iter()
        .filter(|f| f.columns.iter().flatten().all(|v| v.is_finite()))
        .map(|mut form| {
            form.columns.iter_mut().for_each(|c| *c = mean(c));
            form
        })
        .filter(|form| !takes_command_away(form, (&base, &known), &target, &motor))
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
    // Of those that foresee about as much, the simplest first.
    if let Some(best) = found.first().map(|d| d.explained) {
        let near = found.iter().take_while(|d| d.explained > best - RICHER).count();
        found[..near].sort_by_key(|d| d.coefficients);
    }
    found
}

/// Share of the motor's force that a drive may lose: beyond it a curve over the command takes the command away, and links
/// without mass explain the rest.
pub(super) const MOST_LOST: f64 = 0.5;

/// Whether a curve over the command explains what is missing by taking the command away. Inertia, damping and command are
/// in balance: where little is known of the first two, nothing of all three fits any log.
fn takes_command_away(
    form: &Form,
    (base, known): (&[Vec<f64>], &[f64]),
    target: &[f64],
    motor: &[f64],
) -> bool {
    if !matches!(form.on, "command" | "command and time") || motor.len() != target.len() {
        return false;
    }
    let all: Vec<Vec<f64>> = base.iter().chain(&form.columns).cloned().collect();
    let (mut a, b) = normal(&all, target, 0..target.len());
    add_known(known, &mut a);
    let x = solve(&a, &b);
    let given = |i: usize| (base.len()..all.len()).map(|c| x[c] * all[c][i]).sum::<f64>();
    let (mut product, mut square) = (0.0, 0.0);
    for (i, m) in motor.iter().enumerate() {
        product += m * given(i);
        square += m * m;
    }
    product < -MOST_LOST * square
}

/// Of how many samples a row of a regression is the mean.
pub(super) fn step(runs: &[Vec<f64>]) -> usize {
    let total: usize = runs.iter().map(Vec::len).sum();
    (total as f64 / CURVE_ROWS).ceil().max(1.0) as usize
}

/// Neighbours within one run, as ranges of the runs' samples one after the other.
fn chunks(runs: &[Vec<f64>], every: usize) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    let of = move |run: &Vec<f64>| {
        let first = start;
        start += run.len();
        (first..start).step_by(every).map(move |i| i..(i + every).min(start)).collect::<Vec<_>>()
    };
    runs.iter().map(of).collect::<Vec<_>>().into_iter().flatten()
}

/// The means of neighbours of a column that stands along some runs, one after the other.
pub(super) fn averaged(column: &[f64], runs: &[Vec<f64>]) -> Vec<f64> {
    if column.len() != runs.iter().map(Vec::len).sum::<usize>() {
        return Vec::new();
    }
    chunks(runs, step(runs)).map(|r| column[r.clone()].iter().sum::<f64>() / r.len() as f64).collect()
}

/// The forms that are tried.
pub(super) fn forms(rows: &Rows, sensor: bool) -> Vec<Form> {
    let by = |column: Vec<f64>, factor: &[f64]| -> Vec<f64> {
        column.iter().zip(factor).map(|(a, b)| a * b).collect()
    };
    let curve = |on, over, x: &[f64], knots: usize| {
        let knots = quantiles(x, knots);
        Form { on, over, times: "1", columns: hats(x, &knots), knots: Some(knots) }
    };
    let times = |on, over, times, x: &[f64], factor: &[f64]| {
        let knots = quantiles(x, FEW_KNOTS);
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

/// The signals of a port's place, thinned.
pub(super) fn rows(data: &Data, observed: &Candidate, missing: &Missing, step: usize) -> Rows {
    let predictions = &observed.fit.evaluation.predictions;
    let thinned = |values: &[f64], run: usize| -> Vec<f64> {
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
    for run in 0..data.runs.len() {
        let rows = data.runs[run].scored_rows().div_ceil(step);
        let blocks = (CURVE_BLOCKS / data.runs.len() as f64).ceil().max(2.0) as usize;
        block.extend((0..rows).map(|i| run * blocks + i * blocks / rows.max(1)));
    }
    let channel = missing.port.strip_prefix("sensor/").unwrap_or("");
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
        plays: (1..=FEW_KNOTS)
            .map(|k| {
                let width = deepest * k as f64 / (FEW_KNOTS + 1) as f64;
                each(&|run| play(&inside(run, internal::SPRING_DEFLECTION), width))
            })
            .collect(),
        time: each(&|run| data.runs[run].record.time_s.clone()),
        travelled: each(&|run| {
            let mut sum = 0.0;
            speed_of(run)
                .iter()
                .map(|v| {
                    sum += v.abs();
                    sum
                })
                .collect()
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

/// Knots, each once: half of them at quantiles, where the samples are, half of them even, as what bends only far out (a sensor
/// at its range, a spring beyond a stop) has few samples there.
fn quantiles(x: &[f64], knots: usize) -> Vec<f64> {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    // The ends are in both halves.
    let dense = knots / 2 + 1;
    let even = knots - dense + 2;
    let along = |k: usize| k as f64 / (even - 1) as f64;
    let mut at: Vec<f64> = (0..dense).map(|k| sorted[k * last / (dense - 1)]).collect();
    at.extend((0..even).map(|k| sorted[0] + along(k) * (sorted[last] - sorted[0])));
    at.sort_by(f64::total_cmp);
    // A knot near an end has few samples of its own, and a fit would let its ordinate run away.
    let apart = 3e-2 * (sorted[last] - sorted[0]);
    at.dedup_by(|b, a| *b - *a <= apart);
    at
}

/// Hat functions at knots, one column each.
fn hats(x: &[f64], knots: &[f64]) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; x.len()]; knots.len()];
    for (i, &v) in x.iter().enumerate() {
        let k = knots.partition_point(|&knot| knot <= v).clamp(1, knots.len().max(2) - 1);
        if knots.len() < 2 {
            columns[0][i] = 1.0;
            continue;
        }
        let along = ((v - knots[k - 1]) / (knots[k] - knots[k - 1])).clamp(0.0, 1.0);
        columns[k - 1][i] = 1.0 - along;
        columns[k][i] = along;
    }
    columns
}

/// `A` and `b` of the normal equations over some rows, columns in their own size.
pub(super) fn normal(
    columns: &[Vec<f64>],
    target: &[f64],
    rows: impl Iterator<Item = usize>,
) -> (DMatrix<f64>, DVector<f64>) {
    let n = columns.len();
    let (mut a, mut b) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for i in rows {
        for k in 0..n {
            let c = columns[k][i];
            if c == 0.0 {
                continue;
            }
            b[k] += c * target[i];
            for l in k..n {
                a[(k, l)] += c * columns[l][i];
            }
        }
    }
    for k in 0..n {
        for l in 0..k {
            a[(k, l)] = a[(l, k)];
        }
    }
    (a, b)
}

/// Solves the normal equations; directions about which nothing is known stay at zero.
pub(super) fn solve(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = b.len();
    let scale: Vec<f64> = (0..n).map(|k| 1.0 / a[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let mut scaled = DMatrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]);
    (0..n).for_each(|k| scaled[(k, k)] += 1e-6);
    let right = DVector::from_fn(n, |i, _| b[i] * scale[i]);
    let solution = scaled.cholesky().map_or_else(|| DVector::zeros(n), |c| c.solve(&right));
    DVector::from_fn(n, |i, _| solution[i] * scale[i])
}

/// Sum of squares that is left of blocks, each foreseen by the others; `known` are the weights of what is known of the first
/// columns.
fn left_out(
    columns: &[Vec<f64>],
    target: &[f64],
    block: &[usize],
    (known, smooth): (&[f64], Option<Smooth>),
) -> f64 {
    let n = columns.len();
    let blocks = block.iter().max().map_or(0, |b| b + 1);
    let of = |k: usize| (0..target.len()).filter(move |&i| block[i] == k);
    let parts: Vec<_> = (0..blocks).map(|k| normal(columns, target, of(k))).collect();
    let zero = (DMatrix::zeros(n, n), DVector::zeros(n));
    let (a, b) = parts.iter().fold(zero, |(a, b), part| (a + &part.0, b + &part.1));
    let mut squares = 0.0;
    for (k, part) in parts.iter().enumerate() {
        let mut rest = &a - &part.0;
        add_known(known, &mut rest);
        if let Some(smooth) = &smooth {
            smooth.add_to(&mut rest);
        }
        let x = solve(&rest, &(&b - &part.1));
        for i in of(k) {
            let said: f64 = (0..n).map(|c| x[c] * columns[c][i]).sum();
            squares += (target[i] - said).powi(2);
        }
    }
    squares
}

/// The curve of a form of hats with its standard error, from all rows.
fn curve(form: &Form, knots: &[f64], (base, known): (&[Vec<f64>], &[f64]), target: &[f64]) -> Curve {
    let all: Vec<Vec<f64>> = base.iter().chain(&form.columns).cloned().collect();
    let (mut a, b) = normal(&all, target, 0..target.len());
    add_known(known, &mut a);
    if let Some(smooth) = form.smooth(base.len()) {
        smooth.add_to(&mut a);
    }
    let x = solve(&a, &b);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Noise;

    #[test]
    fn analytic_hats_reproduce_a_line_and_sum_to_one() {
        let x: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01 - 1.0).collect();
        let knots = quantiles(&x, KNOTS);
        let columns = hats(&x, &knots);
        for i in 0..x.len() {
            let line: f64 = (0..knots.len()).map(|k| columns[k][i] * knots[k]).sum();
            let one: f64 = (0..knots.len()).map(|k| columns[k][i]).sum();
            assert!((line - x[i]).abs() < 1e-12 && (one - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_curve_foresees_left_out_blocks_and_noise_does_not() {
        let mut noise = Noise::new(1);
        let x: Vec<f64> = (0..4000).map(|_| 2.0 * noise.uniform() - 1.0).collect();
        let target: Vec<f64> = x.iter().map(|v| v.abs() + 0.1 * noise.normal()).collect();
        let block: Vec<usize> = (0..4000).map(|i| i / 400).collect();
        let one = vec![vec![1.0; 4000]];
        let knots = quantiles(&x, KNOTS);
        let with: Vec<Vec<f64>> = one.iter().cloned().chain(hats(&x, &knots)).collect();
        let (alone, left) =
            (left_out(&one, &target, &block, (&[], None)), left_out(&with, &target, &block, (&[], None)));
        // |x| has the variance 1/12; the noise 0.01, and the hats cost 12 of 4000 degrees of freedom.
        assert!((left / 4000.0 - 0.01).abs() < 0.001 && alone / 4000.0 > 0.08, "{left} {alone}");
        let pure: Vec<f64> = (0..4000).map(|_| noise.normal()).collect();
        assert!(
            left_out(&with, &pure, &block, (&[], None)) >= 0.999 * left_out(&one, &pure, &block, (&[], None))
        );
    }

    #[test]
    fn analytic_a_curve_goes_on_straight_where_a_left_out_block_alone_has_reached() {
        // y = 3 x with a column of x beside the hats; the last block alone goes beyond 1.
        let x: Vec<f64> =
            (0..1000).map(|i| f64::from(i % 100) * if i < 900 { 0.01 } else { 0.02 } - 0.5).collect();
        let target: Vec<f64> = x.iter().map(|v| 3.0 * v).collect();
        let block: Vec<usize> = (0..1000).map(|i| i / 100).collect();
        let knots = quantiles(&x, KNOTS);
        let columns: Vec<Vec<f64>> = [x.clone()].into_iter().chain(hats(&x, &knots)).collect();
        let left = left_out(&columns, &target, &block, (&[], Some(Smooth { first: 1, knots: &knots })));
        assert!((left / 1000.0).sqrt() < 1e-3, "{left}");
    }

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
