//! The verdict: what the holdout runs say of the base model and of the sets that were found.

use super::Candidate;
use super::compare::runs_helped;
use super::left::excess;
use super::search::Found;
use crate::Error;
use crate::data::{Data, Evaluation};
use crate::locate::remainder;
use rayon::prelude::*;

/// Error above the floor, as a ratio, up to which a model is called adequate.
const ADEQUATE: f64 = 1.05;

/// Error above the floor, as a ratio, up to which a model with effects has explained everything.
const EXPLAINED: f64 = 1.25;

/// Share of the unexplained energy on held-out runs that effects must remove to be named at all.
const WORTH_NAMING: f64 = 0.25;

/// The same from which on they are named even if one of the held-out runs gains nothing.
const MOST_OF_IT: f64 = 0.5;

/// Share of what is missing that a set which does not explain the fit runs may leave on held-out runs, in units of the
/// share that it leaves there: what bends to the runs that it was fitted to and not to others is not the law.
const HOLDS_UP: f64 = 3.0;

/// Share that it may leave on held-out runs in any case.
const LITTLE_LEFT: f64 = 0.1;

/// Mean squared error above the floor on held-out runs, in units of what the fitted values' own uncertainty makes
/// one expect there, up to which it says nothing against the model: few directions make most of it.
const WITHIN: f64 = 3.0;

/// Share of what is missing on the fit runs that a set may leave to be spoken of though it is not named.
const FAR_LESS: f64 = 0.5;

/// Said where the fit runs are at the floor and the holdout runs are not.
const ONLY_HELD_OUT: &str = "The fit runs are at the noise floor: what is missing shows in held-out runs only. Give one of \
                             those where it shows the role 'fit', and diagnose again.";

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

/// The verdict with its numbers.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// What was found out.
    pub kind: VerdictKind,
    /// The effects that are named.
    pub effects: Vec<String>,
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
    /// All sets worth showing, best first.
    pub ranking: Vec<Judged>,
}

/// Share of the energy that a named set leaves of the held-out runs, up to which a part of it leaves clearly less.
const CLEARLY_LESS: f64 = 0.9;

/// Sets in a ranking.
const RANKED: usize = 16;

/// Judges what was found on the holdout runs, once.
pub(super) fn judge(holdout: &Data, found: &Found) -> Result<Verdict, Error> {
    let floor = holdout.floor;
    let base = &found.tried[0];
    let judged = |index: usize, evaluation: &Evaluation| {
        let c = &found.tried[index];
        let left = c.validation.mean_square().max(1.0);
        let compared = if c.exact { &base.validation } else { &found.base_as_searched };
        let fall = compared.mean_square() - c.validation.mean_square();
        Judged {
            index,
            holdout_error: evaluation.rms,
            evidence: 0.5 * fall * c.validation.residuals as f64 / left,
        }
    };
    let base_holdout = base.held_out(holdout)?;
    let chosen = &found.tried[found.chosen];
    let chosen_holdout = chosen.held_out(holdout)?;

    let excess = |e: &Evaluation| excess(e.rms, floor);
    let share = if excess(&base_holdout) > 0.0 {
        (excess(&chosen_holdout) / excess(&base_holdout)).min(1.0)
    } else {
        0.0
    };
    let at_floor = |e: &Evaluation, ratio: f64| e.rms <= ratio * floor;
    // What holds up on some of the held-out runs only is no law.
    let helps_everywhere = || {
        let (helped, all) = runs_helped(&base_holdout, &chosen_holdout);
        helped == all
    };
    let kind = if chosen.effects.is_empty() {
        let fits = base.fit.error() <= ADEQUATE * floor
            && (at_floor(&base_holdout, ADEQUATE)
                || at_floor(&base_holdout, EXPLAINED)
                    && excess(&base_holdout) <= WITHIN * uncertainty(holdout, base, &base_holdout)?);
        if fits { VerdictKind::Adequate } else { VerdictKind::Unexplained }
    } else if at_floor(&chosen_holdout, EXPLAINED) {
        VerdictKind::MissingEffect
    } else if holds_up(share, base, chosen, floor)
        && (share <= 1.0 - MOST_OF_IT || (share <= 1.0 - WORTH_NAMING && helps_everywhere()))
    {
        VerdictKind::PartlyExplained
    } else {
        VerdictKind::Unexplained
    };
    let named = matches!(kind, VerdictKind::MissingEffect | VerdictKind::PartlyExplained);

    let mut order: Vec<usize> = (1..found.tried.len()).collect();
    order.sort_by(|&a, &b| {
        let m = |i: usize| found.tried[i].validation.mean_square();
        m(a).total_cmp(&m(b))
    });
    order.truncate(RANKED);
    let ranking: Vec<Option<Judged>> =
        order.par_iter().map(|&i| found.tried[i].held_out(holdout).ok().map(|e| judged(i, &e))).collect();
    let base_judged = judged(0, &base_holdout);
    let (after, after_holdout) = if named {
        (judged(found.chosen, &chosen_holdout), chosen_holdout)
    } else {
        (base_judged.clone(), base_holdout.clone())
    };
    let left = matches!(kind, VerdictKind::PartlyExplained | VerdictKind::Unexplained);
    let mut remainder = if left { remainder(&[(holdout, &after_holdout)]) } else { Vec::new() };
    if left && found.tried[after.index].fit.error() <= ADEQUATE * floor {
        remainder.insert(0, ONLY_HELD_OUT.to_owned());
    }
    if left {
        let ranked: Vec<&Judged> = ranking.iter().flatten().collect();
        remainder.extend(unconfirmed(&ranked, found, &after, floor));
        remainder.extend(better_alone(&ranked, found, &after, floor));
    }
    let sets = |indices: &[usize]| indices.iter().map(|&i| found.tried[i].effects.clone()).collect();
    Ok(Verdict {
        kind,
        remainder,
        effects: if named { chosen.effects.clone() } else { Vec::new() },
        indistinguishable: if named { sets(&found.tied) } else { Vec::new() },
        same_by_another_name: if named { sets(&found.same) } else { Vec::new() },
        floor,
        base: base_judged,
        after,
        base_holdout,
        after_holdout,
        unexplained_share: if named { share } else { 1.0 },
        ranking: ranking.into_iter().flatten().collect(),
    })
}

/// What is said of the set that foresees the fit runs best, where it leaves far less of them than what is named and
/// the held-out runs, which do not confirm it as a whole, keep it from being named.
fn unconfirmed(ranked: &[&Judged], found: &Found, named: &Judged, floor: f64) -> Option<String> {
    let best = ranked.first().filter(|best| best.index != named.index)?;
    let (with, without) = (&found.tried[best.index], &found.tried[named.index]);
    let far_less = excess(with.fit.error(), floor) <= FAR_LESS * excess(without.fit.error(), floor);
    far_less.then(|| {
        format!(
            "On the fit runs {} would leave {:.1} noise units instead of {:.1}; the held-out runs do not bear it out \
             ({:.1} instead of {:.1}).",
            with.effects.join(" + "),
            with.fit.error(),
            without.fit.error(),
            best.holdout_error,
            named.holdout_error
        )
    })
}

/// What is said of a part of the named set that leaves clearly less of the held-out runs than the whole.
fn better_alone(ranked: &[&Judged], found: &Found, named: &Judged, floor: f64) -> Option<String> {
    let whole = &found.tried[named.index];
    let part_of = |part: &[String]| {
        !part.is_empty() && part.len() < whole.effects.len() && part.iter().all(|e| whole.effects.contains(e))
    };
    let parts = ranked.iter().filter(|j| part_of(&found.tried[j.index].effects));
    let part = parts.min_by(|a, b| a.holdout_error.total_cmp(&b.holdout_error))?;
    let clearly = excess(part.holdout_error, floor) <= CLEARLY_LESS * excess(named.holdout_error, floor);
    let alone = &found.tried[part.index];
    clearly.then(|| {
        format!(
            "On the held-out runs {} alone leaves {:.1} noise units, less than {:.1}; it is the fit runs that ask for \
             the rest ({:.1} with it, {:.1} without).",
            alone.effects.join(" + "),
            part.holdout_error,
            named.holdout_error,
            whole.fit.error(),
            alone.fit.error()
        )
    })
}

/// Whether what effects gain on the fit runs holds up on the held-out ones, of whose energy a share is left.
fn holds_up(share: f64, base: &Candidate, with: &Candidate, floor: f64) -> bool {
    let left = |c: &Candidate| excess(c.fit.error(), floor);
    with.fit.error() <= EXPLAINED * floor
        || share <= LITTLE_LEFT
        || share * left(base) <= HOLDS_UP * left(with)
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
