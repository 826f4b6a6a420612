//! The verdict: what the holdout runs, read here for the first time, say of the base model and of the set that was chosen.

use super::candidate::all_but;
use super::candidate::compare::{excess, runs_helped};
use super::policy::{
    ADEQUATE, EXPLAINED, HOLDS_UP, LEFT_SHARE, LITTLE_LEFT, MOST_OF_IT, NAMED_SHARE, STEP_SHARE, TIED_COST,
    WITHIN_UNCERTAINTY, WORTH_NAMING,
};
use super::refine::windows::in_windows;
use super::{Candidate, Found};
use crate::Error;
use crate::data::{Data, Evaluation};
use crate::locate::remainder;
use rayon::prelude::*;

/// Said where the fit runs are at the floor and the holdout runs are not.
const ONLY_HELD_OUT: &str = "The fit runs are at the noise floor: what is missing shows in held-out runs only. Give one of \
                             those where it shows the role 'fit', and diagnose again.";

/// Said where the error of the integration is a good part of what is left.
const RATTLES: &str = "Half the step changes the prediction by a good part of what is left: the motion amplifies small errors, \
                       as where play rattles, and no further effect can be told from that.";

/// Sets in a ranking.
const RANKED: usize = 16;

/// What was found out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VerdictKind {
    /// The refitted base model is at the noise floor.
    Adequate,
    /// The effects explain what the base model does not.
    MissingEffect,
    /// The effects help on held-out data, but a structured remainder stays.
    PartlyExplained,
    /// No known effect helps on held-out data.
    Unexplained,
}

impl VerdictKind {
    /// The name in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::MissingEffect => "missing-effect",
            Self::PartlyExplained => "partly-explained",
            Self::Unexplained => "unexplained",
        }
    }
}

/// A fitted set with its error on the holdout runs.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Index in [`Found::tried`].
    pub index: usize,
    /// Root mean square residual on the holdout runs, in noise units.
    pub holdout_error: f64,
    /// Half the fall of the sum of squared residuals on left-out stretches of the fit runs against the base
    /// model, in units of the mean squared residual that is left (at least 1): a log-likelihood ratio.
    pub evidence: f64,
}

/// A curve beyond the catalogue, judged (see [`Found::laws`]).
#[derive(Debug, Clone, PartialEq)]
pub struct LawJudged {
    /// Which of them.
    pub which: usize,
    /// Root mean square residual of the holdout runs with it, in noise units.
    pub holdout_error: f64,
    /// The same of the fit runs.
    pub fit_error: f64,
    /// Share of the energy above the floor that it takes on the holdout runs of what the set beside it leaves.
    pub explained: f64,
}

/// A step of the ladder from the base model to the named set.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// The effects so far, in the order of what they take.
    pub effects: Vec<String>,
    /// Root mean square residual of the holdout runs, in noise units.
    pub holdout_error: f64,
    /// The same of the fit runs.
    pub fit_error: f64,
}

/// The verdict with its numbers.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// What was found out.
    pub kind: VerdictKind,
    /// The effects that are named.
    pub effects: Vec<String>,
    /// Effects that help significantly and take less than 1 % of the base model's held-out error.
    pub traces: Vec<String>,
    /// The errors from the base model to the named set, one effect after the other.
    pub ladder: Vec<Rung>,
    /// Other sets that these data cannot tell from them.
    pub indistinguishable: Vec<Vec<String>>,
    /// Sets that are the named one by another name (see [`Found::same`]).
    pub same_by_another_name: Vec<Vec<String>>,
    /// Noise floor, in noise units.
    pub floor: f64,
    /// The base model.
    pub base: Judged,
    /// The named set; the base model where nothing is named.
    pub after: Judged,
    /// The base model on the holdout runs.
    pub base_holdout: Evaluation,
    /// The named set on the holdout runs.
    pub after_holdout: Evaluation,
    /// Part of the residual energy above the floor that is left.
    pub unexplained_share: f64,
    /// What is left and not explained, in sentences; empty where nothing is.
    pub remainder: Vec<String>,
    /// What the curve beyond the catalogue leaves, where there is one that helps.
    pub law: Option<LawJudged>,
    /// All sets worth showing, best first.
    pub ranking: Vec<Judged>,
}

/// Judges what was found on the fit runs on the holdout runs, once.
pub(super) fn judge(data: &Data, holdout: &Data, found: &Found) -> Result<Verdict, Error> {
    let floor = holdout.floor;
    let held_out = |i: usize| found.tried[i].held_out(holdout);
    let base = &found.tried[0];
    let base_holdout = held_out(0)?;
    let (named_set, mut traces) = named(found, &held_out, (base_holdout.rms, floor));
    let missing = excess(base_holdout.rms, floor);
    let share_of = |at: &Evaluation| {
        if missing > 0.0 { (excess(at.rms, floor) / missing).min(1.0) } else { 0.0 }
    };
    let kind_of = |index: usize, at: &Evaluation| -> Result<VerdictKind, Error> {
        let chosen = &found.tried[index];
        let share = share_of(at);
        let left = (at.rms - floor) / (base_holdout.rms - floor).max(1e-9);
        Ok(if chosen.effects.is_empty() {
            let near = base_holdout.rms <= EXPLAINED * floor
                && excess(base_holdout.rms, floor)
                    <= WITHIN_UNCERTAINTY * uncertainty(holdout, base, &base_holdout)?;
            let fits = base.fit.error() <= ADEQUATE * floor && (base_holdout.rms <= ADEQUATE * floor || near);
            if fits { VerdictKind::Adequate } else { VerdictKind::Unexplained }
        } else if at.rms <= EXPLAINED * floor || left < LEFT_SHARE {
            VerdictKind::MissingEffect
        } else {
            let (helped, all) = runs_helped(&base_holdout, at);
            let helps = share <= 1.0 - MOST_OF_IT || (share <= 1.0 - WORTH_NAMING && helped == all);
            let in_windows = || holds_up_in_windows(data, holdout, base, chosen).unwrap_or(false);
            let partly = helps && (holds_up(share, base, chosen, floor) || in_windows());
            if partly { VerdictKind::PartlyExplained } else { VerdictKind::Unexplained }
        })
    };
    // What the held-out runs cannot be simulated with explains nothing of them.
    let (mut index, mut chosen_holdout) =
        held_out(named_set).map_or_else(|_| (0, base_holdout.clone()), |at| (named_set, at));
    let mut kind = kind_of(index, &chosen_holdout)?;
    if kind == VerdictKind::Unexplained {
        // Of a set that does not hold up as a whole a part may: the greatest one, where the members leave one after the other
        // that the fit runs miss least. If none does, the best single effect may; where a curve takes the place of all sets,
        // if that predicts the held-out runs worse.
        let mut part = None;
        let is_part = |i: &usize| *i != named_set && !found.tried[*i].effects.is_empty();
        let by_fit_runs = |i: usize| found.tried[i].validation.mean_square();
        for smaller in steps_to(found, named_set, &by_fit_runs).into_iter().rev().filter(is_part) {
            let Ok(at) = held_out(smaller) else { continue };
            let of_part = kind_of(smaller, &at)?;
            if of_part != VerdictKind::Unexplained {
                part = Some((smaller, at, of_part));
                break;
            }
        }
        let curve = found.laws.iter().find(|law| law.beside == 0 && named_set == 0);
        let of_curve = curve.map_or(f64::INFINITY, |law| error_of(law.with.held_out(holdout)));
        if let Some(single) = best_single(found).filter(|_| part.is_none())
            && let Ok(at) = held_out(single)
            && at.rms < of_curve
        {
            // A set that was chosen is clearly better than the base model; of one that was not that is asked here.
            let of_single = kind_of(single, &at)?;
            if of_single != VerdictKind::Unexplained && share_of(&at) <= 1.0 - MOST_OF_IT {
                part = Some((single, at, of_single));
            }
        }
        if let Some(part) = part {
            (index, chosen_holdout, kind) = part;
            traces.clear();
        }
    }
    let share = share_of(&chosen_holdout);
    let says = matches!(kind, VerdictKind::MissingEffect | VerdictKind::PartlyExplained);
    let judged = |index: usize, evaluation: &Evaluation| {
        let c = &found.tried[index];
        let compared = if c.exact { &base.validation } else { &found.base_as_searched };
        let fall = compared.mean_square() - c.validation.mean_square();
        let left = c.validation.mean_square().max(1.0);
        let evidence = 0.5 * fall * c.validation.residuals as f64 / left;
        Judged { index, holdout_error: evaluation.rms, evidence }
    };
    let mut order: Vec<usize> = (1..found.tried.len()).collect();
    let mean = |i: usize| found.tried[i].validation.mean_square();
    order.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
    order.truncate(RANKED);
    let ranking: Vec<Option<Judged>> =
        order.par_iter().map(|&i| held_out(i).ok().map(|e| judged(i, &e))).collect();
    let base_judged = judged(0, &base_holdout);
    let ladder = if says { ladder(found, index, &held_out) } else { rungs(found, &[0], &held_out) };
    let (after, after_holdout) = if says {
        (judged(index, &chosen_holdout), chosen_holdout)
    } else {
        (base_judged.clone(), base_holdout.clone())
    };
    let open = matches!(kind, VerdictKind::PartlyExplained | VerdictKind::Unexplained);
    let mut remainder = if open { remainder(&[(holdout, &after_holdout)]) } else { Vec::new() };
    if open && found.tried[after.index].fit.error() <= ADEQUATE * floor {
        remainder.insert(0, ONLY_HELD_OUT.to_owned());
    }
    let step_error = || found.tried[after.index].step_error(holdout, &after_holdout);
    if open && step_error() >= STEP_SHARE * excess(after_holdout.rms, floor) {
        remainder.insert(0, RATTLES.to_owned());
    }
    let effects = if says { found.tried[index].effects.clone() } else { Vec::new() };
    let sets = |indices: &[usize]| -> Vec<Vec<String>> {
        // Beside a set that lost a trace its ties have lost theirs; more effects with no more parameters are no more.
        let parameters = |i: usize| found.tried[i].effect_parameters();
        let of_size = |i: &&usize| {
            let more = found.tried[**i].effects.len() > effects.len() && parameters(**i) > parameters(index);
            !more && **i != index
        };
        indices.iter().filter(of_size).map(|&i| found.tried[i].effects.clone()).collect()
    };
    let named = if says { index } else { 0 };
    let law = match found.laws.iter().position(|law| law.beside == named) {
        Some(which) => {
            let with = &found.laws[which].with;
            let (rms, without) = (error_of(with.held_out(holdout)), error_of(held_out(named)));
            let explained = 1.0 - excess(rms, floor) / excess(without, floor).max(f64::MIN_POSITIVE);
            let judged = LawJudged { which, holdout_error: rms, fit_error: with.fit.error(), explained };
            (explained >= WORTH_NAMING).then_some(judged)
        }
        None => None,
    };
    let (tied, same) =
        if says && index == named_set { (sets(&found.tied), sets(&found.same)) } else { Default::default() };
    Ok(Verdict {
        kind,
        effects,
        traces: if says { traces } else { Vec::new() },
        ladder,
        indistinguishable: tied,
        same_by_another_name: same,
        floor,
        base: base_judged,
        after,
        base_holdout,
        after_holdout,
        unexplained_share: if says { share } else { 1.0 },
        remainder,
        law,
        ranking: ranking.into_iter().flatten().collect(),
    })
}

/// A set's error on the held-out runs: what cannot be simulated with it explains nothing of them.
fn error_of(held_out: Result<Evaluation, Error>) -> f64 {
    held_out.map_or(f64::INFINITY, |at| at.rms)
}

/// The single effect that predicts left-out stretches of the fit runs best, of equals the one with fewest parameters.
fn best_single(found: &Found) -> Option<usize> {
    let mean = |i: usize| found.tried[i].validation.mean_square();
    let singles = || (1..found.tried.len()).filter(|&i| found.tried[i].effects.len() == 1);
    let least = singles().map(mean).fold(f64::INFINITY, f64::min);
    let equal = singles().filter(|&i| mean(i) <= TIED_COST * least);
    equal.min_by(|&a, &b| {
        let parameters = |i: usize| found.tried[i].effect_parameters();
        parameters(a).cmp(&parameters(b)).then(mean(a).total_cmp(&mean(b)))
    })
}

type HeldOut<'a> = dyn Fn(usize) -> Result<Evaluation, Error> + 'a;

/// The chosen set without its traces, and these.
fn named(found: &Found, held_out: &HeldOut, (base, floor): (f64, f64)) -> (usize, Vec<String>) {
    let (mut index, mut traces) = (found.chosen, Vec::new());
    let least = NAMED_SHARE * (base - floor).max(0.0);
    loop {
        let effects = &found.tried[index].effects;
        if effects.len() < 2 {
            return (index, traces);
        }
        let error = error_of(held_out(index));
        let mut next: Option<(usize, &String, f64)> = None;
        for effect in effects {
            let Some(rest) = found.index_of(&all_but(effects, effect)) else { continue };
            let taken = error_of(held_out(rest)) - error;
            if taken < least && next.is_none_or(|(.., other)| taken < other) {
                next = Some((rest, effect, taken));
            }
        }
        let Some((rest, effect, _)) = next else { return (index, traces) };
        traces.push(effect.clone());
        index = rest;
    }
}

/// The errors from the base model to a set.
fn ladder(found: &Found, last: usize, held_out: &HeldOut) -> Vec<Rung> {
    rungs(found, &steps_to(found, last, &|i| error_of(held_out(i))), held_out)
}

/// The sets from the base model to one: at each step the effect without which the next smaller set leaves least, as far as
/// these were fitted.
fn steps_to(found: &Found, last: usize, left: &dyn Fn(usize) -> f64) -> Vec<usize> {
    let mut steps = vec![last];
    while let Some(&index) = steps.last().filter(|&&i| !found.tried[i].effects.is_empty()) {
        let effects = &found.tried[index].effects;
        let without = effects.iter().filter_map(|e| found.index_of(&all_but(effects, e)));
        match without.map(|i| (i, left(i))).min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((next, _)) => steps.push(next),
            None => steps.push(0),
        }
    }
    steps.reverse();
    steps
}

fn rungs(found: &Found, steps: &[usize], held_out: &HeldOut) -> Vec<Rung> {
    let mut order: Vec<String> = Vec::new();
    steps
        .iter()
        .filter_map(|&i| {
            let set = &found.tried[i];
            order.extend(set.effects.iter().filter(|e| !order.contains(e)).cloned().collect::<Vec<_>>());
            let holdout_error = held_out(i).ok()?.rms;
            Some(Rung { effects: order.clone(), holdout_error, fit_error: set.fit.error() })
        })
        .collect()
}

/// Whether effects gain something on the fit runs, and that holds up on the held-out ones, of whose energy a share is left.
fn holds_up(share: f64, base: &Candidate, with: &Candidate, floor: f64) -> bool {
    let left = |c: &Candidate| excess(c.fit.error(), floor);
    with.fit.error() <= EXPLAINED * floor
        || (left(with) < left(base) && (share <= LITTLE_LEFT || share * left(base) <= HOLDS_UP * left(with)))
}

/// The same in windows (see [`in_windows`]): where open loop amplifies errors, what is left there grows with every run that
/// the values were not fitted to, whatever is right about the effects. `None` where the model has none.
fn holds_up_in_windows(data: &Data, holdout: &Data, base: &Candidate, with: &Candidate) -> Option<bool> {
    let share = |data: &Data| {
        let left = |c: &Candidate| {
            let windows = in_windows(data, c.model.as_ref())?;
            let at = data.judge(windows.as_ref(), &c.fit.values, c.fit.sensors()).ok()?;
            Some(excess(at.rms, data.floor))
        };
        Some(left(with)? / left(base)?.max(f64::MIN_POSITIVE))
    };
    let of_fit = share(data)?;
    Some(of_fit < 1.0 && share(holdout)? <= HOLDS_UP * of_fit)
}

/// The mean squared error, in squared noise units, that the uncertainty of a fit's values makes one expect on held-out
/// runs: `tr(J C J') / N` with the fit's covariance `C` and differences by a standard error for `J`.
fn uncertainty(holdout: &Data, candidate: &Candidate, at: &Evaluation) -> Result<f64, Error> {
    let fit = &candidate.fit;
    let residual = |values: &[f64]| -> Result<Vec<f64>, Error> {
        let moved = holdout.judge(candidate.model.as_ref(), values, fit.sensors())?;
        Ok(moved.blocks.into_iter().flat_map(|b| b.residual).collect())
    };
    let here: Vec<f64> = at.blocks.iter().flat_map(|b| b.residual.iter().copied()).collect();
    let columns: Vec<Vec<f64>> = fit
        .free
        .par_iter()
        .map(|&i| {
            let (p, std) = (&candidate.model.parameters()[i], fit.parameters[i].std);
            let mut values = fit.values.clone();
            let up = values[i] + std <= p.max;
            values[i] = (values[i] + if up { std } else { -std }).clamp(p.min, p.max);
            let sign = if up { 1.0 } else { -1.0 };
            Ok(residual(&values)?.iter().zip(&here).map(|(a, b)| sign * (a - b)).collect())
        })
        .collect::<Result<_, Error>>()?;
    let mut sum = 0.0;
    for (i, a) in columns.iter().enumerate() {
        for (j, b) in columns.iter().enumerate() {
            sum += fit.correlation(i, j) * crate::fit::dot(a, b);
        }
    }
    Ok(sum.max(0.0) / here.len().max(1) as f64)
}
