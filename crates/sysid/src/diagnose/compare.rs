//! When one set of effects is better than another, and when data cannot tell.

use super::Candidate;
use crate::data::Evaluation;

/// Least gain in the mean squared residual, in squared noise units, that is worth an effect: less is within
/// what two integrators of the same physics differ by.
pub(super) const WORTH_SQUARED_NOISE: f64 = 0.006;

/// Least share of what is still unexplained on left-out stretches that is worth an effect.
pub(super) const WORTH_SHARE: f64 = 0.03;

/// The same of what a fit leaves, which is known better.
const WORTH_SHARE_FITTED: f64 = 0.05;

/// Least gain in the sum of squared residuals per further parameter, in squared noise units.
const WORTH_PER_PARAMETER: f64 = 15.0;

/// Share of what is gained on some left-out stretches that may be lost on others.
const MOST_OPPOSED: f64 = 0.4;

/// Gain of `better` over `worse` in the mean squared residual on left-out stretches.
#[must_use]
pub fn gain(worse: &Candidate, better: &Candidate) -> f64 {
    worse.validation.mean_square() - better.validation.mean_square()
}

/// Fall of the cost that is the least worth one more effect beside a candidate.
#[must_use]
pub fn worth(beside: &Candidate, floor: f64) -> f64 {
    0.5 * WORTH_SQUARED_NOISE * floor * floor * beside.validation.residuals as f64
}

/// Whether `better` predicts left-out stretches clearly better than `worse`: on the whole, and not here and there at the
/// expense of as much elsewhere. `floor` is the noise floor in noise units.
#[must_use]
pub fn clearly_better(worse: &Candidate, better: &Candidate, floor: f64) -> bool {
    better_on_the_whole(worse, better, floor) && opposed(worse, better) < MOST_OPPOSED
}

/// Whether `better` predicts left-out stretches better than `worse` by more than its further parameters would by chance,
/// by more than rounding of physics, and by a share of what is unexplained.
pub(super) fn better_on_the_whole(worse: &Candidate, better: &Candidate, floor: f64) -> bool {
    let gain = gain(worse, better);
    let residuals = worse.validation.residuals as f64;
    let extra = (better.effect_parameters() as f64 - worse.effect_parameters() as f64).max(1.0);
    let unexplained = (worse.validation.mean_square() - floor * floor).max(0.0);
    if gain * residuals < WORTH_PER_PARAMETER * extra * worse.validation.mean_square().max(1.0)
        || gain < WORTH_SQUARED_NOISE * floor * floor
        || gain < WORTH_SHARE * unexplained
    {
        return false;
    }
    // Left-out stretches are foreseen by one linear step: where that is rough, what fits no better is no better.
    let fitted = 2.0 * (worse.fit.cost - better.fit.cost);
    let left = (2.0 * worse.fit.cost - floor * floor * residuals).max(0.0);
    fitted >= WORTH_PER_PARAMETER * extra * better.validation.mean_square().max(1.0)
        && fitted >= WORTH_SHARE_FITTED * left
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
pub(super) fn runs_helped(before: &Evaluation, after: &Evaluation) -> (usize, usize) {
    let runs = before.blocks.iter().map(|b| b.run).max().map_or(0, |r| r + 1);
    let squares = |e: &Evaluation, run: usize| -> f64 {
        e.blocks.iter().filter(|b| b.run == run).flat_map(|b| &b.residual).map(|r| r * r).sum()
    };
    ((0..runs).filter(|&run| squares(after, run) <= squares(before, run)).count(), runs)
}
