//! What a campaign holds, before any fit: clocks, sensors, excitation, and what the runs can identify.
//!
//! Identifiability is judged at the nominal values: sensitivities of the predictions by central differences,
//! against the channels' noise and what is known beforehand, with the sensors' gain and bias free. A
//! parameter's achievable standard error is that of a perfect model; an effect is visible if the difference
//! that it makes at its guess, after the base parameters have imitated as much of it as they can, is larger
//! than noise. Nonlinear laws are judged at that one strength only.

mod excitation;

pub(crate) use excitation::band;
pub use excitation::{Excited, of_run};

use crate::campaign::{FEWEST_ROWS, quantum};
use crate::data::Data;
use crate::fit::{self, Difference, Fit, Signatures};
use crate::{Campaign, Error, stats};
use rayon::prelude::*;
use sealegs_model::{Model, Prediction};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// A column of a run, as a sensor's output.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The run's name.
    pub run: String,
    /// The column.
    pub channel: String,
    /// Least and greatest value.
    pub range: (f64, f64),
    /// Root mean square.
    pub rms: f64,
    /// The sensor's quantum, where its values lie on a grid that is not just the file's last digit.
    pub quantum: Option<f64>,
    /// Share of samples that sit exactly on the least or greatest value in stretches of three or more: a
    /// sensor or drive at its limit.
    pub saturated_share: f64,
}

/// What the data would say of a parameter, if the model were right.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterCheck {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The nominal value.
    pub value: f64,
    /// What is known beforehand, one standard deviation.
    pub prior_std: Option<f64>,
    /// The standard error that these runs allow, what is known beforehand included.
    pub std: f64,
    /// Whether the runs add anything to what was known.
    pub identifiable: bool,
}

/// What the data would say of an effect at the strength of its guess.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCheck {
    /// Its id.
    pub id: String,
    /// The strength that it was tried at: name, value and unit of each parameter.
    pub at: Vec<(String, f64, String)>,
    /// Size of what it changes that nothing in the base model can imitate, in noise units (root of the sum
    /// of squares over all samples); `None` if it could not be simulated.
    pub visible: Option<f64>,
    /// Share of its change that the base parameters imitate.
    pub imitated_share: f64,
    /// Other effects that make the same change up to 2 % of its size: in these runs only a tie is possible.
    pub alike: Vec<String>,
}

impl EffectCheck {
    /// A change of ten noise units in all is found without doubt.
    pub const CLEARLY_VISIBLE: f64 = 10.0;

    /// Whether these runs can find it at this strength.
    #[must_use]
    pub fn identifiable(&self) -> bool {
        self.visible.is_some_and(|v| v > Self::CLEARLY_VISIBLE)
    }
}

/// Everything that [`check`] finds.
#[derive(Debug, Clone)]
pub struct Check {
    /// Each run's columns: input, outputs, unknown ones.
    pub columns: Vec<Column>,
    /// How each run was excited, in the order of the campaign's runs.
    pub excited: Vec<Excited>,
    /// Where simulations are dear: the seconds of each fit run, from the first that counts, on which parameters and effects
    /// were judged. `None`: on the whole runs.
    pub judged_on_first_s: Option<f64>,
    /// The model's free parameters; empty without a model.
    pub parameters: Vec<ParameterCheck>,
    /// Pairs of parameters whose errors would be correlated by more than 0.95.
    pub correlated: Vec<(String, String, f64)>,
    /// The effects that the model could have.
    pub effects: Vec<EffectCheck>,
    /// Simulations done.
    pub simulations: u64,
}

/// Time that parameters and effects may take on the whole fit runs, s: beyond it nobody waits for a table, and a check is
/// there before a diagnosis, not in its place.
const PATIENCE_S: f64 = 30.0;

/// The part of each run that they are judged on else, s: some moves of an arm. What a part shows the whole shows, too; what
/// it does not show may still be in the rest.
const SHORT_S: f64 = 10.0;

/// Looks at the runs, and through a model at what they can identify.
///
/// Identifiability is judged on the fit runs, if there are any, else on all.
///
/// # Errors
///
/// Those of [`Data::new`]; [`Error::Model`] if the nominal model cannot be simulated.
pub fn check(campaign: &Campaign, model: &dyn Model) -> Result<Check, Error> {
    check_within(campaign, model, PATIENCE_S, &|_| {})
}

/// As [`check`], telling what it does.
///
/// # Errors
///
/// As [`check`].
pub fn check_telling(
    campaign: &Campaign,
    model: &dyn Model,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Check, Error> {
    check_within(campaign, model, PATIENCE_S, tell)
}

/// As [`check`], telling what it does, with so many seconds for parameters and effects on the whole fit runs; where they would
/// take longer they are judged on the first ten seconds of each.
///
/// # Errors
///
/// As [`check`].
pub fn check_within(
    campaign: &Campaign,
    model: &dyn Model,
    patience_s: f64,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Check, Error> {
    let role = campaign.require(crate::Role::Fit).is_ok().then_some(crate::Role::Fit);
    let nominal: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let all = Data::new(campaign, None, model)?;
    tell("simulating every run once");
    let started = Instant::now();
    let predictions = all.predict(model, &nominal)?;
    let once_s = started.elapsed().as_secs_f64();
    let excited =
        campaign.runs.iter().zip(&predictions).map(|(run, p)| of_run(&run.record, run.scored.clone(), p));
    let whole = Data::new(campaign, role, model)?;
    // Central differences of every free parameter, and every effect once.
    let free = model.parameters().iter().filter(|p| !p.fixed).count();
    let seen = whole.excitation(predictions_of(&whole, &all, &predictions));
    let simulations = 2 * free + model.effects(&seen).len();
    let share = seconds(&whole) / seconds(&all).max(f64::MIN_POSITIVE);
    let short = (once_s * share * simulations as f64 > patience_s).then(|| first_of_each(campaign, SHORT_S));
    let data = match &short {
        Some(short) => Data::new(short, role, model)?,
        None => whole,
    };
    tell("judging every parameter");
    let base = fit::at_values(&data, model, &nominal, Difference::Central)?;
    let effects = effects(&data, model, &base, tell);
    Ok(Check {
        columns: columns(campaign),
        judged_on_first_s: short.is_some().then_some(SHORT_S),
        excited: excited.collect(),
        parameters: parameters(model, &base),
        correlated: base
            .correlations(0.95)
            .into_iter()
            .map(|c| (base.parameters[c.first].name.clone(), base.parameters[c.second].name.clone(), c.value))
            .collect(),
        effects,
        simulations: data.work().0 + all.work().0,
    })
}

/// Seconds of experiment in the data's runs.
fn seconds(data: &Data) -> f64 {
    data.runs.iter().map(|run| run.record.duration_s()).sum()
}

/// The predictions of some runs out of those of all.
fn predictions_of<'p>(
    some: &Data,
    all: &Data,
    predictions: &'p [Prediction],
) -> impl Iterator<Item = &'p Prediction> {
    let at = |index: usize| all.runs.iter().position(|run| run.index == index);
    some.runs.iter().filter_map(move |run| Some(&predictions[at(run.index)?]))
}

/// The campaign with so many seconds of each run that count, from the first one on; what is before them stays.
fn first_of_each(campaign: &Campaign, seconds: f64) -> Campaign {
    let mut short = campaign.clone();
    for run in &mut short.runs {
        let time = &run.record.time_s;
        let end = time[run.scored.start] + seconds;
        let rows = time.partition_point(|&t| t <= end).max(run.scored.start + FEWEST_ROWS).min(time.len());
        run.record.time_s.truncate(rows);
        let record = &mut run.record;
        for signal in record.inputs.iter_mut().chain(&mut record.outputs).chain(&mut run.unknown) {
            signal.values.truncate(rows);
        }
        run.scored.end = run.scored.end.min(rows);
    }
    short
}

fn columns(campaign: &Campaign) -> Vec<Column> {
    let jobs: Vec<_> = campaign
        .runs
        .iter()
        .flat_map(|r| r.record.inputs.iter().chain(&r.record.outputs).chain(&r.unknown).map(move |s| (r, s)))
        .collect();
    jobs.into_par_iter()
        .map(|(run, signal)| {
            let values = &signal.values;
            let range =
                values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
            let coarse = quantum(values).filter(|q| !is_decimal(*q));
            Column {
                run: run.record.name.clone(),
                channel: signal.channel.clone(),
                range,
                rms: stats::rms(values),
                quantum: coarse,
                saturated_share: saturated(values, range),
            }
        })
        .collect()
}

/// Whether a quantum is a power of ten, and so the file's last digit rather than a sensor's.
fn is_decimal(quantum: f64) -> bool {
    let exponent = quantum.log10();
    (exponent - exponent.round()).abs() < 1e-4
}

/// Share of samples on an extreme value in stretches of at least three, the value being no rest at zero.
fn saturated(values: &[f64], (min, max): (f64, f64)) -> f64 {
    if min == max {
        return 0.0;
    }
    let size = min.abs().max(max.abs());
    let mut count = 0;
    let mut at = 0;
    while at < values.len() {
        let stretch = values[at..].iter().take_while(|&&v| v == values[at]).count();
        let extreme = values[at] == max || values[at] == min;
        if extreme && stretch >= 3 && values[at].abs() > 0.1 * size {
            count += stretch;
        }
        at += stretch;
    }
    count as f64 / values.len() as f64
}

/// Achievable standard errors: of white noise at its stated size, whatever the nominal model's residual.
fn parameters(model: &dyn Model, base: &Fit) -> Vec<ParameterCheck> {
    let n = base.free.len();
    let mut normal = base.normal.clone();
    let range: Vec<f64> = base
        .free
        .iter()
        .map(|&i| (model.parameters()[i].max - model.parameters()[i].min) / 12f64.sqrt())
        .collect();
    for k in 0..n {
        normal[(k, k)] += (base.slopes[k] / range[k]).powi(2).max(1e-12);
    }
    let inverse = normal.cholesky().map(|c| c.inverse());
    base.free
        .iter()
        .enumerate()
        .map(|(k, &i)| {
            let p = &model.parameters()[i];
            let std = inverse.as_ref().map_or(range[k], |m| m[(k, k)].max(0.0).sqrt() * base.slopes[k].abs());
            ParameterCheck {
                name: p.name.clone(),
                unit: p.unit.clone(),
                value: p.value,
                prior_std: p.prior_std,
                std,
                identifiable: match p.prior_std {
                    Some(prior) => std < 0.8 * prior,
                    None => std < range[k] / 3.0,
                },
            }
        })
        .collect()
}

fn effects(data: &Data, model: &dyn Model, base: &Fit, tell: &(dyn Fn(&str) + Sync)) -> Vec<EffectCheck> {
    let seen = data.excitation(&base.evaluation.predictions);
    let cards = model.effects(&seen);
    let done = AtomicUsize::new(0);
    let simulated: Vec<Option<Vec<Prediction>>> = cards
        .par_iter()
        .map(|card| {
            let number = 1 + done.fetch_add(1, Ordering::Relaxed);
            tell(&format!("simulating effect {number} of {}: {}", cards.len(), card.id));
            let with = model.with_effect(&card.id, &seen).ok()?;
            let values: Vec<f64> = with.parameters().iter().map(|p| p.value).collect();
            data.predict(&*with, &values).ok()
        })
        .collect();
    let tried: Vec<usize> = (0..cards.len()).filter(|&i| simulated[i].is_some()).collect();
    let changed: Vec<&[Prediction]> = simulated.iter().filter_map(|p| p.as_deref()).collect();
    let signatures = Signatures::new(data, base, &base.evaluation.predictions, &changed);
    let place = |i: usize| tried.iter().position(|&t| t == i);
    (0..cards.len())
        .map(|i| {
            let card = &cards[i];
            let own = place(i);
            let imitated = own.map_or(0.0, |k| {
                let bare = signatures.bare[k];
                if bare > 0.0 { (1.0 - signatures.gram[(k, k)] / bare).clamp(0.0, 1.0) } else { 0.0 }
            });
            let alike = own.map_or_else(Vec::new, |k| {
                (0..tried.len())
                    .filter(|&other| other != k)
                    // 2 % of size apart: what is left of one after the other is below that.
                    .filter(|&other| signatures.cosine(k, other).abs() > (1.0f64 - 0.02f64.powi(2)).sqrt())
                    .filter(|&other| signatures.norm(other) > EffectCheck::CLEARLY_VISIBLE)
                    .map(|other| cards[tried[other]].id.clone())
                    .collect()
            });
            EffectCheck {
                id: card.id.clone(),
                at: card.parameters.iter().map(|p| (p.name.clone(), p.value, p.unit.clone())).collect(),
                visible: own.map(|k| signatures.norm(k)),
                imitated_share: imitated,
                alike,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests;
