//! The next experiment: the excitation, inside the rig's limits, under which rival explanations would differ
//! most, after each of them has been allowed to refit its parameters within what is known of them.

pub(super) mod adapt;
pub(super) mod excitations;
pub(super) mod rig;

use crate::data::Data;
use crate::diagnose::candidate::in_words;
use crate::diagnose::policy::SCREEN_STEPS_PER_SAMPLE;
use crate::diagnose::{Candidate, Diagnosis, VerdictKind};
use crate::{Campaign, Error, Role};
use excitations::library;
use rayon::prelude::*;
use rig::{Rig, Trial};

/// Rivals that are told apart from the named set at once.
const MOST_RIVALS: usize = 3;

/// Excitations that are examined with refitted parameters, out of those that differ most without.
const EXAMINED: usize = 4;

/// The same where each run simulates a whole leg.
const EXAMINED_RUNS: usize = 1;

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
    let rivals = rivals(diagnosis);
    if rivals.len() < 2 {
        return Ok(None);
    }
    let rig = Rig::of(&data);
    let runs = base.model.experiments();
    // A run of a whole leg is dear, and how far rivals come apart is wanted to a tenth.
    let coarse =
        |c: &&Candidate| Candidate { model: c.model.coarser(SCREEN_STEPS_PER_SAMPLE), ..(*c).clone() };
    let coarser: Vec<Candidate> = rivals.iter().filter(|_| !runs.is_empty()).map(coarse).collect();
    let rivals = if runs.is_empty() { rivals } else { coarser.iter().collect() };
    let (mut trials, examined): (Vec<Trial>, usize) = if runs.is_empty() {
        let Some(excite) = rig.excite(limits) else { return Ok(None) };
        let excitations = library(&excite).into_par_iter();
        (excitations.filter_map(|e| rig.excited(&rivals, &excite, e)).collect(), EXAMINED)
    } else {
        (runs.into_par_iter().filter_map(|record| rig.run(&rivals, record)).collect(), EXAMINED_RUNS)
    };
    // Ties in the order of the library.
    trials.sort_by(|a, b| b.apart.total_cmp(&a.apart));
    trials.truncate(examined);
    let examined =
        trials.into_iter().filter_map(|t| rig.refitted(&rivals, &t.record).map(|apart| (t, apart)));
    let best = examined.reduce(|a, b| if b.1 > a.1 { b } else { a });
    Ok(best.map(|(trial, apart)| propose(diagnosis, &rivals, trial, apart)))
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
        let mut others = ranked.filter(|&i| i != first && !diagnosis.found.same.contains(&i));
        // A set that holds the named one beside something idle is no rival where the base is not named.
        let rival = if own.is_empty() { others.next() } else { others.find(|&i| !holds_own(i)) };
        all.extend(rival);
    }
    all.into_iter().map(|i| &tried[i]).collect()
}

/// A trial as an experiment, in words.
fn propose(diagnosis: &Diagnosis, rivals: &[&Candidate], trial: Trial, apart: f64) -> Experiment {
    let names: Vec<String> = rivals.iter().map(|c| in_words(&c.effects)).collect();
    let who = match names.as_slice() {
        [a, b] => format!("{a} and {b}"),
        [first, middle @ .., last] => format!("{first}, {} and {last}", middle.join(", ")),
        _ => String::new(),
    };
    let rows = trial.record.len() as f64;
    let play = match trial.record.inputs.first() {
        Some(input) => {
            let period_s = trial.record.mean_period_s();
            format!(
                "play {} on {} for {:.0} s at {:.0} Hz",
                trial.description,
                input.channel,
                rows * period_s,
                1.0 / period_s
            )
        }
        None => trial.description.clone(),
    };
    let tied = !diagnosis.verdict.indistinguishable.is_empty();
    let settles = apart * rows.sqrt() > SETTLES;
    let digits = if apart < 100.0 { 2 } else { 0 };
    let apart_text = format!("{apart:.digits$} noise units RMS");
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
