//! When one set of effects is better than another, and when data cannot tell.

use crate::data::Evaluation;
use crate::diagnose::Candidate;
use crate::diagnose::policy::{
    MOST_MEMORY, MOST_OPPOSED, WORTH_PER_PARAMETER, WORTH_SHARE, WORTH_SHARE_FITTED, WORTH_SQUARED_NOISE,
};
use crate::fit::Fit;
use crate::stats;

/// Mean squared error above the floor, in squared noise units.
pub(crate) fn excess(error: f64, floor: f64) -> f64 {
    (error.powi(2) - floor.powi(2)).max(0.0)
}

/// Mean squared difference of two evaluations' residuals.
pub(crate) fn mean_square_difference(a: &Evaluation, b: &Evaluation) -> f64 {
    let (mut squares, mut rows) = (0.0, 0usize);
    for (a, b) in a.blocks.iter().zip(&b.blocks) {
        squares += a.residual.iter().zip(&b.residual).map(|(x, y)| (x - y).powi(2)).sum::<f64>();
        rows += a.residual.len();
    }
    squares / rows.max(1) as f64
}

/// Gain of `better` over `worse` in the mean squared residual on left-out stretches.
pub(crate) fn gain(worse: &Candidate, better: &Candidate) -> f64 {
    worse.validation.mean_square() - better.validation.mean_square()
}

/// Whether `better` predicts left-out stretches clearly better than `worse`: by more than its further parameters would by
/// chance, by more than two integrators differ by, by a share of what is unexplained, and not here and there at the expense
/// of as much elsewhere. `floor` is the noise floor in noise units.
#[must_use]
pub fn clearly_better(worse: &Candidate, better: &Candidate, floor: f64) -> bool {
    let gain = gain(worse, better);
    let residuals = worse.validation.residuals as f64;
    let extra = (better.effect_parameters() as f64 - worse.effect_parameters() as f64).max(1.0);
    let unexplained = (worse.validation.mean_square() - floor * floor).max(0.0);
    if gain * residuals < WORTH_PER_PARAMETER * extra * better.validation.mean_square().max(1.0)
        || gain < WORTH_SQUARED_NOISE * floor * floor
        || gain < WORTH_SHARE * unexplained
        || opposed(worse, better) >= MOST_OPPOSED
    {
        return false;
    }
    // Left-out stretches are predicted by one linear step: where that is rough, what fits no better is no better.
    let fitted = 2.0 * (worse.fit.cost - better.fit.cost);
    let left = (2.0 * worse.fit.cost - floor * floor * residuals).max(0.0);
    // What stays remembers: its samples are worth far less than their number, as they are for standard errors.
    let memory =
        better.fit.std_inflation.powi(2).clamp(1.0, MOST_MEMORY * better.validation.mean_square().max(1.0));
    fitted >= WORTH_PER_PARAMETER * extra * memory.max(better.validation.mean_square())
        && fitted >= WORTH_SHARE_FITTED * left
}

/// Whether an effect gains more under the observer than its further parameters would by chance. There an error lasts for
/// one of the observer's time constants only, so that a run holds many independent stretches.
#[must_use]
pub(crate) fn is_seen(without: &Fit, with: &Fit) -> bool {
    let extra = with.free.len().saturating_sub(without.free.len()).max(1) as f64;
    let mean_square = with.error().powi(2).max(1.0);
    let memory = with.std_inflation.powi(2).clamp(mean_square, MOST_MEMORY * mean_square);
    2.0 * (without.cost - with.cost) >= WORTH_PER_PARAMETER * extra * memory
}

/// Whether `better` gains more in open loop than chance would give its further parameters, counting what a residual's
/// memory leaves of its samples: the log-likelihood ratio where the scale of each block of residuals is unknown. A position
/// that drifts over a whole run is one sample, and almost any further force takes some of it.
#[must_use]
pub(crate) fn is_beyond_chance(worse: &Candidate, better: &Candidate) -> bool {
    let extra = (better.effect_parameters() as f64 - worse.effect_parameters() as f64).max(1.0);
    let squares = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
    let blocks = worse.fit.evaluation.blocks.iter().zip(&better.fit.evaluation.blocks);
    let ratio: f64 = blocks
        .map(|(w, b)| (stats::independent(&w.residual), squares(&w.residual), squares(&b.residual)))
        .filter(|(_, w, b)| *w > 0.0 && *b > 0.0)
        .map(|(samples, w, b)| samples * (w / b).ln())
        .sum();
    ratio >= WORTH_PER_PARAMETER * extra
}

/// What `better` loses on some left-out stretches over what it gains on the others.
fn opposed(worse: &Candidate, better: &Candidate) -> f64 {
    let (mut for_it, mut against) = (0.0, 0.0);
    for (w, b) in worse.validation.stretches.iter().zip(&better.validation.stretches) {
        let change = w - b;
        if change > 0.0 {
            for_it += change;
        } else {
            against -= change;
        }
    }
    if for_it > 0.0 { against / for_it } else { f64::INFINITY }
}

/// On how many of the runs one evaluation leaves no more than another, and how many there are.
pub(crate) fn runs_helped(before: &Evaluation, after: &Evaluation) -> (usize, usize) {
    let runs = before.blocks.iter().map(|b| b.run).max().map_or(0, |r| r + 1);
    let squares = |e: &Evaluation, run: usize| -> f64 {
        e.blocks.iter().filter(|b| b.run == run).flat_map(|b| &b.residual).map(|r| r * r).sum()
    };
    ((0..runs).filter(|&run| squares(after, run) <= squares(before, run)).count(), runs)
}
