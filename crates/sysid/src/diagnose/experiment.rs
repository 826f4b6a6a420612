//! The next experiment: the excitation, inside the rig's limits, under which rival explanations would differ
//! most, after each of them has been allowed to refit its parameters within what is known of them.

use super::excitations::{Excite, library};
use super::{Candidate, Diagnosis, VerdictKind};
use crate::data::Data;
use crate::{Campaign, Error, Role, stats};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sealegs_model::{InputHold, Prediction, Record, Signal};

/// Longest experiment that is proposed, s.
const LONGEST_S: f64 = 20.0;

/// Shortest experiment that is proposed, s.
const SHORTEST_S: f64 = 4.0;

/// Outputs may exceed what the campaign showed by this factor at most.
const BEYOND_SEEN: f64 = 1.2;

/// The same where a run has no amplitude that could be lowered: joints that rested are to move.
const BEYOND_SEEN_IN_RUNS: f64 = 3.0;

/// Rivals that are told apart from the named set at once.
const MOST_RIVALS: usize = 3;

/// Excitations that are examined with refitted parameters, out of those that differ most without.
const EXAMINED: usize = 4;

/// The same where each run simulates a whole leg.
const EXAMINED_RUNS: usize = 2;

/// Difference between rivals, in noise units over all samples together, that settles the matter.
const SETTLES: f64 = 10.0;

/// What the rig bears beside what the campaign showed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Greatest magnitude of the input, in the input channel's unit, if it is rated.
    pub input: Option<f64>,
}

/// An experiment that is proposed.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// What to do and why, with numbers.
    pub sentence: String,
    /// What the rig is to do.
    pub play: Play,
    /// The rivals that it is to tell apart; the first is the named set. A set without effects is the base.
    pub rivals: Vec<Vec<String>>,
    /// Root mean square difference between the named set and its nearest rival in noise units, after
    /// refitting.
    pub difference: f64,
}

/// What a rig is to do in an experiment.
#[derive(Debug, Clone, PartialEq)]
pub enum Play {
    /// To play an input.
    Input {
        /// The input channel.
        channel: String,
        /// Time stamps, s.
        time_s: Vec<f64>,
        /// Values at them, in the channel's unit.
        values: Vec<f64>,
    },
    /// One of [`sealegs_model::Model::experiments`], by its name.
    Run(String),
}

/// The experiment that would tell most after this diagnosis; `None` if there is nothing to play or nothing
/// can be simulated.
///
/// # Errors
///
/// What [`Data::new`] refuses.
pub fn next_experiment(
    campaign: &Campaign,
    diagnosis: &Diagnosis,
    limits: Limits,
) -> Result<Option<Experiment>, Error> {
    let base = &diagnosis.found.tried[0];
    let data = Data::new(campaign, Some(Role::Fit), base.model.as_ref())?;
    let Some(rig) = Rig::of(&data, limits) else { return Ok(None) };
    let rivals = rivals(diagnosis);
    if rivals.len() < 2 {
        return Ok(None);
    }
    let runs = base.model.experiments();
    let mut trials: Vec<Trial> = if runs.is_empty() {
        library(&rig.excite).into_par_iter().filter_map(|e| rig.trial(&data, &rivals, e)).collect()
    } else {
        runs.into_par_iter().filter_map(|record| rig.run(&data, &rivals, record)).collect()
    };
    // Ties in the order of the library.
    trials.sort_by(|a, b| b.apart.total_cmp(&a.apart));
    trials.truncate(if rig.input.is_empty() { EXAMINED_RUNS } else { EXAMINED });
    let examined: Vec<(Trial, f64)> = trials
        .into_iter()
        .filter_map(|t| rig.refitted(&data, &rivals, &t.record).map(|apart| (t, apart)))
        .collect();
    let best = examined.into_iter().reduce(|a, b| if b.1 > a.1 { b } else { a });
    Ok(best.map(|(trial, apart)| rig.experiment(diagnosis, &rivals, trial, apart)))
}

/// The named set and its ties; without ties the best other set of the ranking.
fn rivals(diagnosis: &Diagnosis) -> Vec<&Candidate> {
    let (verdict, tried) = (&diagnosis.verdict, &diagnosis.found.tried);
    let first = match verdict.kind {
        // What was chosen by the fit runs but did not help, if anything, is the nearest thing to an answer.
        VerdictKind::Unexplained => diagnosis.found.chosen,
        _ => verdict.after.index,
    };
    let mut all: Vec<usize> = vec![first];
    all.extend(
        verdict
            .indistinguishable
            .iter()
            .filter_map(|set| tried.iter().position(|c| c.effects == *set))
            .take(MOST_RIVALS),
    );
    if all.len() < 2 {
        let own = &tried[first].effects;
        let holds_own = |i: usize| own.iter().all(|e| tried[i].effects.contains(e));
        let ranked = verdict.ranking.iter().map(|r| r.index).chain([0]);
        let mut others = ranked.filter(|&i| i != first);
        // A set that holds the named one beside something idle is no rival where the base is not named.
        let rival = if own.is_empty() { others.next() } else { others.find(|&i| !holds_own(i)) };
        all.extend(rival);
    }
    all.into_iter().map(|i| &tried[i]).collect()
}

/// What an experiment has to keep to.
struct Rig {
    input: String,
    hold: InputHold,
    excite: Excite,
    /// Greatest magnitude of each channel that the campaign showed.
    shown: Vec<f64>,
}

/// An excitation with what the rivals predict.
struct Trial {
    description: String,
    record: Record,
    /// Least root mean square difference over the pairs, noise units.
    apart: f64,
}

impl Rig {
    fn of(data: &Data, limits: Limits) -> Option<Self> {
        let record = data.runs.first()?.record;
        let shown: Vec<f64> = data.channels.iter().map(|c| c.peak).collect();
        let Some(input) = record.inputs.first() else {
            return Some(Self { input: String::new(), hold: record.hold, excite: Excite::default(), shown });
        };
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
        Some(Self {
            input: input.channel.clone(),
            hold: record.hold,
            excite: Excite {
                amplitude,
                centre,
                duration_s: longest.clamp(SHORTEST_S, LONGEST_S),
                period_s: round_period(stats::median(&periods)),
            },
            shown,
        })
    }

    fn record(&self, values: Vec<f64>) -> Record {
        Record {
            name: "planned experiment".to_owned(),
            time_s: (0..values.len()).map(|i| i as f64 * self.excite.period_s).collect(),
            hold: self.hold,
            inputs: vec![Signal { channel: self.input.clone(), values }],
            outputs: Vec::new(),
        }
    }

    fn predict(&self, data: &Data, c: &Candidate, values: &[f64], record: &Record) -> Option<Prediction> {
        let names: Vec<String> = data.channels.iter().map(|c| c.name.clone()).collect();
        c.model.predict(values, record, &names).ok()
    }

    /// The rivals' predictions under an excitation, weakened until no output leaves what the campaign showed.
    fn trial(
        &self,
        data: &Data,
        rivals: &[&Candidate],
        (description, values): (String, Vec<f64>),
    ) -> Option<Trial> {
        let mut values = values;
        let mut share = 1.0;
        for _ in 0..3 {
            let record = self.record(values.clone());
            let predicted: Vec<Prediction> = rivals
                .iter()
                .map(|c| self.predict(data, c, &c.fit.values, &record))
                .collect::<Option<_>>()?;
            let excess = self.excess(data, &predicted);
            if excess <= 1.0 {
                let apart = self.apart(data, &predicted);
                let description = if share < 1.0 {
                    format!(
                        "{description} (at {:.0} % of that, so that outputs stay within {BEYOND_SEEN} times what was seen)",
                        100.0 * share
                    )
                } else {
                    description
                };
                return apart.is_finite().then_some(Trial { description, record, apart });
            }
            let weaker = 0.95 / excess;
            share *= weaker;
            values.iter_mut().for_each(|v| *v = self.excite.centre + weaker * (*v - self.excite.centre));
        }
        None
    }

    /// The rivals' predictions of a run of the rig's own; none if an output would leave what the campaign showed.
    fn run(&self, data: &Data, rivals: &[&Candidate], record: Record) -> Option<Trial> {
        let predicted: Vec<Prediction> =
            rivals.iter().map(|c| self.predict(data, c, &c.fit.values, &record)).collect::<Option<_>>()?;
        let apart = self.apart(data, &predicted);
        let shown = self.excess(data, &predicted) <= BEYOND_SEEN_IN_RUNS / BEYOND_SEEN;
        (shown && apart.is_finite()).then(|| Trial { description: record.name.clone(), record, apart })
    }

    /// Least root mean square difference over the pairs of predictions, noise units.
    fn apart(&self, data: &Data, predicted: &[Prediction]) -> f64 {
        let rows: Vec<Vec<f64>> = predicted.iter().map(|p| self.rows(data, p)).collect();
        let mut apart = f64::INFINITY;
        for (i, a) in rows.iter().enumerate() {
            for b in &rows[i + 1..] {
                let squares: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
                apart = apart.min((squares / a.len().max(1) as f64).sqrt());
            }
        }
        apart
    }

    /// Greatest ratio of a predicted output to what is admitted.
    fn excess(&self, data: &Data, predicted: &[Prediction]) -> f64 {
        let mut worst = 0.0f64;
        for p in predicted {
            for (c, channel) in data.channels.iter().enumerate() {
                let Some(values) = p.output(&channel.name) else { continue };
                let peak = values
                    .iter()
                    .fold(0.0f64, |m, v| if v.is_finite() { m.max(v.abs()) } else { f64::INFINITY });
                if self.shown[c] > 0.0 {
                    worst = worst.max(peak / (BEYOND_SEEN * self.shown[c]));
                }
            }
        }
        worst
    }

    /// All channels of a prediction in noise units, each without its mean, which the sensor's bias takes up.
    fn rows(&self, data: &Data, p: &Prediction) -> Vec<f64> {
        let mut rows = Vec::new();
        for channel in &data.channels {
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
    fn refitted(&self, data: &Data, rivals: &[&Candidate], record: &Record) -> Option<f64> {
        let each: Vec<(Vec<f64>, Vec<Vec<f64>>)> =
            rivals.par_iter().map(|c| self.sensitivities(data, c, record)).collect::<Option<_>>()?;
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
    fn sensitivities(
        &self,
        data: &Data,
        c: &Candidate,
        record: &Record,
    ) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let here = self.rows(data, &self.predict(data, c, &c.fit.values, record)?);
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
                    Some((reached, self.rows(data, &self.predict(data, c, &values, record)?)))
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

    fn experiment(
        &self,
        diagnosis: &Diagnosis,
        rivals: &[&Candidate],
        trial: Trial,
        apart: f64,
    ) -> Experiment {
        let name = |c: &Candidate| match c.effects.as_slice() {
            [] => "the base model".to_owned(),
            set => set.join(" + "),
        };
        let names: Vec<String> = rivals.iter().map(|c| name(c)).collect();
        let who = match names.as_slice() {
            [a, b] => format!("{a} and {b}"),
            [first, middle @ .., last] => format!("{first}, {} and {last}", middle.join(", ")),
            _ => String::new(),
        };
        let rows = trial.record.len() as f64;
        let play = if self.input.is_empty() {
            trial.description.clone()
        } else {
            format!(
                "play {} on {} for {:.0} s at {:.0} Hz",
                trial.description,
                self.input,
                rows * self.excite.period_s,
                1.0 / self.excite.period_s
            )
        };
        let tied = !diagnosis.verdict.indistinguishable.is_empty();
        let settles = apart * rows.sqrt() > SETTLES;
        let apart_text = format!("{apart:.2} noise units RMS");
        let sentence = match (diagnosis.verdict.kind, tied) {
            (_, true) if settles => format!(
                "To tell {who} apart, {play}: the nearest two then come apart by {apart_text}, even after either has refitted its parameters within what is known."
            ),
            (_, true) => format!(
                "Inside these limits no excitation tells {who} apart: the best, to {play}, leaves {apart_text} between them. \
                 Raise the amplitude, measure another channel, or lower the noise."
            ),
            (VerdictKind::Adequate, false) => format!(
                "Nothing is left to tell apart. To challenge the model further, {play}: {who} would differ by {apart_text} there."
            ),
            (VerdictKind::Unexplained, false) => format!(
                "To see more of what is unexplained, {play}: {who}, the nearest explanations, differ most there ({apart_text})."
            ),
            (_, false) => format!(
                "These data tell the candidates apart; to confirm, {play}: {who}, the next best, differ by {apart_text} there."
            ),
        };
        let play = match trial.record.inputs.into_iter().next() {
            Some(input) => {
                Play::Input { channel: input.channel, time_s: trial.record.time_s, values: input.values }
            }
            None => Play::Run(trial.record.name),
        };
        let rivals = rivals.iter().map(|c| c.effects.clone()).collect();
        Experiment { sentence, play, rivals, difference: apart }
    }
}

/// The columns of a rival as independent unknowns of size one: `J L` with the correlations `L L'`.
fn independent(columns: &[Vec<f64>], rival: &Candidate) -> Vec<Vec<f64>> {
    let n = columns.len();
    let Some(root) = correlation(rival, n).cholesky() else { return columns.to_vec() };
    let root = root.l();
    let rows = columns.first().map_or(0, Vec::len);
    (0..n)
        .map(|k| {
            let mut sum = vec![0.0; rows];
            for i in k..n {
                for (s, v) in sum.iter_mut().zip(&columns[i]) {
                    *s += root[(i, k)] * v;
                }
            }
            sum
        })
        .collect()
}

/// Correlations of the free parameters' errors, kept regular.
fn correlation(rival: &Candidate, n: usize) -> DMatrix<f64> {
    let c = &rival.fit.covariance;
    DMatrix::from_fn(n, n, |i, j| {
        let size = (c[(i, i)] * c[(j, j)]).sqrt();
        match (i == j, size > 0.0) {
            (true, _) => 1.0 + 1e-6,
            (false, true) => (c[(i, j)] / size).clamp(-1.0, 1.0),
            (false, false) => 0.0,
        }
    })
}

/// Squared difference that is left when a rival moves its parameters towards the other's prediction: the
/// minimum of `|d - J z|^2 + z' R^-1 z` for columns by one standard error and correlations `R`.
fn adapted(difference: &[f64], columns: &[Vec<f64>], rival: &Candidate) -> f64 {
    let n = columns.len();
    let total: f64 = difference.iter().map(|d| d * d).sum();
    if n == 0 {
        return total;
    }
    let prior = correlation(rival, n).cholesky().map_or_else(|| DMatrix::identity(n, n), |c| c.inverse());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let a = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j])) + prior;
    let g = DVector::from_fn(n, |i, _| dot(&columns[i], difference));
    let gained = a.cholesky().map_or(0.0, |a| g.dot(&a.solve(&g)));
    (total - gained).max(0.0)
}

/// A sampling period as a logger is set: a whole number of microseconds where it is near one.
fn round_period(period_s: f64) -> f64 {
    let us = (period_s * 1e6).round() * 1e-6;
    if us > 0.0 && (us - period_s).abs() < 0.01 * period_s { us } else { period_s.max(1e-6) }
}
