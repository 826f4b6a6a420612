//! When one set of effects is better than another, and when data cannot tell.

use super::Candidate;

/// Least gain in the mean squared residual, in squared noise units, that is worth an effect: less is within
/// what two integrators of the same physics differ by.
pub(super) const WORTH_SQUARED_NOISE: f64 = 0.006;

/// Least share of what is still unexplained on left-out stretches that is worth an effect.
pub(super) const WORTH_SHARE: f64 = 0.03;

/// The same of what a fit leaves, which is known better.
const WORTH_SHARE_FITTED: f64 = 0.05;

/// Least gain in the sum of squared residuals per further parameter, in squared noise units.
const WORTH_PER_PARAMETER: f64 = 15.0;

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

/// Whether `better` predicts left-out stretches clearly better than `worse`: by more than its further
/// parameters would by chance, by more than rounding of physics, by a share of what is unexplained, and
/// not here and there at the expense of as much elsewhere. `floor` is the noise floor in noise units.
#[must_use]
pub fn clearly_better(worse: &Candidate, better: &Candidate, floor: f64) -> bool {
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
    if fitted < WORTH_PER_PARAMETER * extra * better.validation.mean_square().max(1.0)
        || fitted < WORTH_SHARE_FITTED * left
    {
        return false;
    }
    let (mut for_it, mut against) = (0.0, 0.0);
    for (w, b) in worse.validation.stretches.iter().zip(&better.validation.stretches) {
        let change = w - b;
        if change > 0.0 {
            for_it += change;
        } else {
            against -= change;
        }
    }
    against < 0.4 * for_it
}
