//! The missing force over what it depends on, in bins with their standard errors, beside what the named effects give there.
//!
//! Both are seen along the measured motion: the force that an observer needs with and without the effects, all other
//! values alike. Their difference is the effects' law, whatever its form and wherever it acts.

use super::dependence::{dependences, forms};
use super::regression::{Nuisance, known_weights, regressed};
use super::rows::{Rows, rows};
use super::{Missing, Port, is_torque, ports, sensors};
use crate::data::{Data, Evaluation};
use crate::diagnose::policy::DRAWN_ROWS;
use crate::diagnose::refine::Models;
use crate::diagnose::{Candidate, values_by_name, with_effects};
use crate::fit::Fit;
use crate::stats;
use sealegs_model::Unit;
use std::f64::consts::TAU;

/// Bins of equal width, and as many more edges at quantiles: where most samples are, the law is seen closely.
const EVEN_BINS: usize = 20;
const QUANTILES: usize = 12;

/// Share of the samples that is left out at either end of the abscissa.
const ENDS: f64 = 0.002;

/// Least distance of two edges, as a share of the range.
const APART: f64 = 0.004;

/// Fewest samples that make a bin.
const LEAST_ROWS: usize = 8;

/// Least share of a port's mean square that the effects must give for the port to be theirs.
const THEIRS: f64 = 0.25;

/// A missing force, or what a sensor shows too much, over what it depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct MissingForce {
    /// The port with its place.
    pub port: String,
    /// The unit of the ordinate.
    pub unit: String,
    /// What it depends on, as in [`crate::diagnose::Dependence::on`].
    pub on: String,
    /// The abscissa in words.
    pub over: String,
    /// The unit of the abscissa.
    pub over_unit: String,
    /// What the ordinate was divided by: `1`, `direction` (the sign of the speed), `deflection` or `command`.
    pub times: &'static str,
    /// The bins; two branches where the direction of the abscissa matters.
    pub branches: Vec<Branch>,
    /// What the sensors' noise alone leaves at the port, root mean square, in the port's unit.
    pub noise: f64,
    /// Share of the port's mean square that the named effects give; none where nothing is named.
    pub by_law: Option<f64>,
}

/// Bins that belong to one line.
#[derive(Debug, Clone, PartialEq)]
pub struct Branch {
    /// `growing` or `shrinking` abscissa; empty for the only branch.
    pub label: &'static str,
    /// The bins in ascending order.
    pub bins: Vec<Bin>,
}

/// A part of the abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Bin {
    /// Mean abscissa.
    pub x: f64,
    /// Mean of what is missing there.
    pub y: f64,
    /// Its standard error, from how much the visits of the bin differ (a cluster-robust variance, Liang and Zeger 1986:
    /// samples of one visit are not independent).
    pub std: f64,
    /// What the named effects give there.
    pub law: Option<f64>,
    /// Samples.
    pub rows: usize,
}

/// What the abscissa of a dependence is, at the thinned rows.
struct Abscissa {
    over: &'static str,
    unit: String,
    x: Vec<f64>,
    times: &'static str,
    factor: Option<Vec<f64>>,
    /// Whether it grows, where that matters.
    growing: Option<Vec<bool>>,
}

impl Abscissa {
    /// `rotary` says that the actuator turns, `turns` that what moves at the port does.
    fn of(rows: &Rows, on: &str, (rotary, turns): (bool, bool), command: &str) -> Option<Self> {
        let (deflection, rate, force) = if rotary { ("rad", "rad/s", "N m") } else { ("m", "m/s", "N") };
        let (length, speed) = if turns { ("rad", "rad/s") } else { ("m", "m/s") };
        let plain = |over, unit: &str, x: &[f64]| Self {
            over,
            unit: unit.to_owned(),
            x: x.to_vec(),
            times: "1",
            factor: None,
            growing: None,
        };
        let times = |a: Self, times, factor: &[f64]| Self { times, factor: Some(factor.to_vec()), ..a };
        let direction = |a: Self| times(a, "direction", &rows.direction);
        let load: Vec<f64> = rows.load.iter().map(|f| f.abs()).collect();
        let turn: Vec<f64> = rows.angle.iter().map(|a| a.rem_euclid(TAU)).collect();
        let change: Vec<f64> = rows.past.first()?.iter().map(|v| -v).collect();
        Some(match on {
            "its own value" => plain("the channel's own value", "", &rows.own),
            "direction of motion" | "speed" => plain("speed", speed, &rows.speed),
            "position" => plain("position", length, &rows.position),
            "direction and position" => direction(plain("position", length, &rows.position)),
            "direction and load" => direction(plain("magnitude of the load", force, &load)),
            "direction and time" => direction(plain("time", "s", &rows.time)),
            "direction and travelled distance" => {
                direction(plain("travelled distance", length, &rows.travelled))
            }
            "rotor angle" => plain("rotor angle within a turn", "rad", &turn),
            "deflection" => plain("deflection", deflection, &rows.deflection),
            "rate of deflection" => plain("rate of deflection", rate, &rows.stretching),
            "deflection and time" => times(plain("time", "s", &rows.time), "deflection", &rows.deflection),
            "deflection and its history" => Self {
                growing: Some(rows.stretching.iter().map(|v| *v > 0.0).collect()),
                ..plain("deflection", deflection, &rows.deflection)
            },
            "load" => plain("load", force, &rows.load),
            "time" => plain("time", "s", &rows.time),
            "command" => plain("command", command, &rows.command),
            "command and time" => times(plain("time", "s", &rows.time), "command", &rows.command),
            "the command's past" => plain("change of the command in one sample", command, &change),
            _ => return None,
        })
    }

    /// The bins of a signal, of which the effects give `law`.
    fn branches(&self, y: &[f64], law: Option<&[f64]>, run: &[usize]) -> Vec<Branch> {
        let branch = |label, wanted: Option<bool>| {
            let is = |i: &usize| self.growing.as_ref().is_none_or(|g| wanted == Some(g[*i]));
            let rows: Vec<usize> = (0..y.len()).filter(is).collect();
            Branch { label, bins: bins(&rows, self, y, law, run) }
        };
        match self.growing {
            Some(_) => vec![branch("growing", Some(true)), branch("shrinking", Some(false))],
            None => vec![branch("", None)],
        }
    }

    /// The ordinate's unit for a signal in this one.
    fn ordinate(&self, unit: &str, command: &str, rotary: bool) -> String {
        match self.times {
            "deflection" => format!("{unit}/{}", if rotary { "rad" } else { "m" }),
            "command" => format!("{unit}/{command}"),
            _ => unit.to_owned(),
        }
    }
}

/// Edges of bins: of equal width, at quantiles, and at zero, where signs change.
fn edges(x: &[f64]) -> Vec<f64> {
    let finite: Vec<f64> = x.iter().copied().filter(|v| v.is_finite()).collect();
    let (low, high) = (stats::quantile(&finite, ENDS), stats::quantile(&finite, 1.0 - ENDS));
    if finite.is_empty() || high <= low || !(high - low).is_finite() {
        return Vec::new();
    }
    let gap = APART * (high - low);
    let even = (0..=EVEN_BINS).map(|i| low + (high - low) * i as f64 / EVEN_BINS as f64);
    let dense = (1..QUANTILES).map(|i| stats::quantile(&finite, i as f64 / QUANTILES as f64));
    let mut at: Vec<f64> = even.chain(dense).filter(|e| (low..=high).contains(e)).collect();
    if low < 0.0 && high > 0.0 {
        at.retain(|e| e.abs() > gap);
        at.push(0.0);
    }
    at.sort_by(f64::total_cmp);
    at.dedup_by(|b, a| *b - *a < gap && *b != 0.0);
    at
}

/// The bins of some rows. A bin's value is the slope of `y` on the factor through zero: its mean where there is none.
fn bins(rows: &[usize], over: &Abscissa, y: &[f64], law: Option<&[f64]>, run: &[usize]) -> Vec<Bin> {
    let edges = edges(&rows.iter().map(|&i| over.x[i]).collect::<Vec<_>>());
    if edges.len() < 3 {
        return Vec::new();
    }
    let factor = |i: usize| over.factor.as_ref().map_or(1.0, |f| f[i]);
    let place = |i: usize| {
        let (x, last) = (over.x[i], edges[edges.len() - 1]);
        (x >= edges[0] && x <= last).then(|| edges.partition_point(|e| *e <= x).clamp(1, edges.len() - 1) - 1)
    };
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); edges.len() - 1];
    for &i in rows {
        if let Some(bin) = place(i) {
            members[bin].push(i);
        }
    }
    let whole: f64 = rows.iter().map(|&i| factor(i).powi(2)).sum::<f64>() / rows.len() as f64;
    members
        .into_iter()
        .filter(|m| m.len() >= LEAST_ROWS)
        .filter_map(|m| {
            let squares: f64 = m.iter().map(|&i| factor(i).powi(2)).sum();
            // Where the factor is next to nothing, what it multiplies is not seen.
            if squares < 1e-3 * whole * m.len() as f64 {
                return None;
            }
            let slope = |v: &[f64]| m.iter().map(|&i| factor(i) * v[i]).sum::<f64>() / squares;
            let value = slope(y);
            let mut visits: Vec<f64> = Vec::new();
            for (k, &i) in m.iter().enumerate() {
                let score = factor(i) * (y[i] - value * factor(i));
                let goes_on = k > 0 && m[k - 1] + 1 == i && run[m[k - 1]] == run[i];
                match visits.last_mut().filter(|_| goes_on) {
                    Some(sum) => *sum += score,
                    None => visits.push(score),
                }
            }
            let n = visits.len() as f64;
            let spread: f64 = visits.iter().map(|s| s * s).sum();
            let variance = if visits.len() > 1 {
                n / (n - 1.0) * spread / squares.powi(2)
            } else {
                // One visit says nothing of how much visits differ: its own scatter, as if it were one sample.
                m.iter().map(|&i| (y[i] - value * factor(i)).powi(2)).sum::<f64>() / squares
            };
            Some(Bin {
                x: m.iter().map(|&i| over.x[i]).sum::<f64>() / m.len() as f64,
                y: value,
                std: variance.sqrt(),
                law: law.map(slope),
                rows: m.len(),
            })
        })
        .collect()
}

/// The unit of the commands, and whether the actuator turns and what moves at the port does.
fn units(data: &Data, missing: &Missing) -> (String, (bool, bool)) {
    let input = data.runs.first().and_then(|r| r.record.inputs.first());
    let command = input.and_then(|s| Unit::of_channel(&s.channel).ok()).map_or("", Unit::symbol);
    (
        command.to_owned(),
        (is_torque(data, &missing.place, "rotor"), is_torque(data, &missing.place, &missing.port)),
    )
}

/// Every how many samples of a signal are taken, and those samples with their runs.
fn thinned(runs: &[Vec<f64>]) -> (usize, Vec<f64>, Vec<usize>) {
    let total: usize = runs.iter().map(Vec::len).sum();
    let every = (total as f64 / DRAWN_ROWS).ceil().max(1.0) as usize;
    let values = runs.iter().flat_map(|r| r.iter().step_by(every).copied()).collect();
    let run = runs.iter().enumerate().flat_map(|(k, r)| vec![k; r.len().div_ceil(every)]).collect();
    (every, values, run)
}

/// The picture of a port beside a model that lacks something unknown: what wrong base parameters could do is taken off.
pub(crate) fn of_port(
    data: &Data,
    observed: &Candidate,
    missing: &Missing,
    nuisances: &[Nuisance],
    on: &str,
) -> Option<MissingForce> {
    let (every, mut y, run) = thinned(&missing.runs);
    let rows = rows(data, observed, missing, every);
    let mut columns: Vec<Vec<f64>> = nuisances.iter().map(|n| thinned(&n.runs).1).collect();
    let taken_off = columns.len();
    columns.push(vec![1.0; y.len()]);
    let form = forms(&rows, missing.port.starts_with("sensor/")).into_iter().find(|f| f.on == on)?;
    let smooth = columns.len();
    columns.extend(form.columns.iter().cloned());
    let (_, fitted) = regressed(&columns, &y, (&known_weights(nuisances, &y), form.smooth(smooth)));
    for i in 0..y.len() {
        y[i] -= (0..taken_off).map(|k| fitted[k] * columns[k][i]).sum::<f64>();
    }
    drawn(data, missing, &rows, on, (&y, None, &run))
}

/// What is drawn of a signal at thinned rows.
fn drawn(
    data: &Data,
    missing: &Missing,
    rows: &Rows,
    on: &str,
    (y, law, run): (&[f64], Option<&[f64]>, &[usize]),
) -> Option<MissingForce> {
    let (command, turning) = units(data, missing);
    let mut over = Abscissa::of(rows, on, turning, &command)?;
    if on == "its own value" {
        over.unit.clone_from(&missing.unit);
    }
    let branches = over.branches(y, law, run);
    let by_law = law.map(|law| {
        let left: f64 = y.iter().zip(law).map(|(y, l)| (y - l).powi(2)).sum();
        1.0 - left / y.iter().map(|v| v * v).sum::<f64>().max(f64::MIN_POSITIVE)
    });
    branches.iter().any(|b| b.bins.len() > 2).then(|| MissingForce {
        port: missing.name(),
        unit: over.ordinate(&missing.unit, &command, turning.0),
        on: on.to_owned(),
        over: over.over.to_owned(),
        over_unit: over.unit,
        times: over.times,
        branches,
        noise: missing.std,
        by_law,
    })
}

/// The picture beside named effects, at the port where they act: what is missing without them, and what they give, with
/// the fitted values of the model that has them. `ports_of_base` are those of the base model, the most important first; of an
/// empty list every port is one.
///
/// `None` where the runs measure no motion that could be followed.
#[must_use]
pub fn missing_force(models: &Models, chosen: &Candidate, ports_of_base: &[Port]) -> Option<MissingForce> {
    let (data, observed) = (models.data, models.observed.as_deref()?);
    let known = chosen.known();
    let seen = |effects: &[String]| -> Option<(Evaluation, Vec<Missing>)> {
        let model = with_effects(observed, effects, &models.seen).ok()?;
        let at = data.evaluate(model.as_ref(), &values_by_name(model.as_ref(), &known)).ok()?;
        let all = ports(data, &at.predictions).into_iter().chain(sensors(data, &at)).collect();
        Some((at, all))
    };
    let (without, lacking) = seen(&[])?;
    let (_, having) = seen(&chosen.effects)?;
    let places: Vec<&str> =
        chosen.effects.iter().filter_map(|e| e.split_once('/').map(|(place, _)| place)).collect();
    let stated: Vec<&Missing> = ports_of_base.iter().map(|p| &p.missing).collect();
    let order = if stated.is_empty() { lacking.iter().collect() } else { stated };
    let mut best: Option<(f64, &Missing, &Missing, f64)> = None;
    for port in order {
        let same = |m: &&Missing| m.place == port.place && m.port == port.port;
        let (Some(a), Some(b)) = (lacking.iter().find(same), having.iter().find(same)) else { continue };
        let elsewhere = !places.is_empty() && !places.contains(&port.place.as_str());
        if elsewhere || a.rms <= 0.0 {
            continue;
        }
        let share = 1.0 - (b.rms / a.rms).powi(2);
        if best.is_none_or(|(s, ..)| s < THEIRS && share > s) {
            best = Some((share, a, b, port.std));
        }
    }
    let (_, a, b, noise) = best?;
    let missing = Missing { std: noise, ..a.clone() };
    let fit = Fit { evaluation: without, ..chosen.fit.clone() };
    let candidate = Candidate { fit, ..chosen.clone() };
    let (every, y, run) = thinned(&missing.runs);
    let law: Vec<f64> = y.iter().zip(thinned(&b.runs).1).map(|(a, b)| a - b).collect();
    let rows = rows(data, &candidate, &missing, every);
    // What the law itself depends on; the port's own dependence where that has no form.
    let difference = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
    let given = Missing { runs: a.runs.iter().zip(&b.runs).map(difference).collect(), std: 0.0, ..a.clone() };
    let of_law = dependences(data, &candidate, &given, &[]).first().map(|d| d.on);
    let stated = ports_of_base.iter().find(|p| p.missing.name() == missing.name());
    let of_port = || stated.and_then(|p| p.depends.first()).map(|d| d.on);
    let of_signal = || dependences(data, &candidate, &missing, &[]).first().map(|d| d.on);
    let on = of_law.or_else(of_port).or_else(of_signal)?;
    drawn(data, &missing, &rows, on, (&y, Some(&law), &run))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Noise;

    fn over(x: Vec<f64>, factor: Option<Vec<f64>>) -> Abscissa {
        Abscissa { over: "speed", unit: "m/s".into(), x, times: "1", factor, growing: None }
    }

    #[test]
    fn dry_friction_is_a_step_at_zero_within_its_standard_errors() {
        let mut noise = Noise::new(3);
        let x: Vec<f64> = (0..6000).map(|i| (0.01 * f64::from(i)).sin()).collect();
        let law: Vec<f64> = x.iter().map(|v| 5.0 * v.signum()).collect();
        let y: Vec<f64> = law.iter().map(|v| v + noise.normal()).collect();
        let branches = over(x, None).branches(&y, Some(&law), &vec![0; 6000]);
        let bins = &branches[0].bins;
        assert!(branches.len() == 1 && bins.len() > 20, "{}", bins.len());
        for bin in bins {
            assert!((bin.law.unwrap() - 5.0 * bin.x.signum()).abs() < 0.2, "{bin:?}");
            assert!((bin.y - 5.0 * bin.x.signum()).abs() < 5.0 * bin.std + 1e-9, "{bin:?}");
            // White noise of size one in some visits of one oscillation each.
            assert!(bin.std < 3.0 / (bin.rows as f64).sqrt(), "{bin:?}");
        }
    }

    #[test]
    fn samples_of_one_visit_count_once() {
        // Four visits of one bin, each off by its own amount: the error is that of four numbers, not of 400.
        let x: Vec<f64> = (0..800).map(|i| if (i / 100) % 2 == 0 { 0.25 } else { 0.75 }).collect();
        let off = [1.0, -1.0, 1.0, -1.0];
        let y: Vec<f64> = (0..800).map(|i| if (i / 100) % 2 == 0 { off[i / 200] } else { 0.0 }).collect();
        let branches = over(x, None).branches(&y, None, &vec![0; 800]);
        let bin = branches[0].bins.iter().find(|b| b.x < 0.5).unwrap();
        assert!((bin.std - (1.0_f64 / 3.0).sqrt()).abs() < 1e-9 && bin.y.abs() < 1e-12, "{bin:?}");
    }

    #[test]
    fn a_signal_that_is_multiplied_shows_its_slope() {
        let x: Vec<f64> = (0..1000).map(|i| 0.02 * f64::from(i)).collect();
        let factor: Vec<f64> = (0..1000).map(|i| (0.37 * f64::from(i)).sin()).collect();
        let y: Vec<f64> = x.iter().zip(&factor).map(|(t, f)| (3.0 + 0.1 * t) * f).collect();
        let branches = over(x, Some(factor)).branches(&y, None, &vec![0; 1000]);
        assert!(branches[0].bins.iter().all(|b| (b.y - 3.0 - 0.1 * b.x).abs() < 0.05), "{branches:?}");
    }
}
