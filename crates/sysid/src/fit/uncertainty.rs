//! Standard errors of fitted parameters that hold where the model is wrong, too.

use super::coordinates::Coordinates;
use super::jacobian::{JacobianBlock, dot, gram};
use crate::data::{Data, Evaluation};
use nalgebra::{DMatrix, DVector};

/// What [`covariance`] finds.
pub(super) struct Spread {
    /// By values of the free parameters.
    pub covariance: DMatrix<f64>,
    /// Whether the data say anything about each.
    pub felt: Vec<bool>,
    /// Root mean square ratio to the standard errors of white noise.
    pub inflation: f64,
}

/// Stretches into which each run is cut for the spread of the score.
const STRETCHES: usize = 16;

/// A residual below this, in noise units, is taken for noise.
pub(super) const AT_THE_FLOOR: f64 = 1.1;

/// Covariance of the free parameters' values. In `normal`, the curvature of the cost, priors count `doubt` times.
pub(super) fn covariance(
    data: &Data,
    at: &Evaluation,
    projected: &[JacobianBlock],
    coordinates: &Coordinates,
    u: &[f64],
    (normal, doubt): (&DMatrix<f64>, f64),
) -> Spread {
    let n = u.len();
    let slopes: Vec<f64> = (0..n).map(|k| coordinates.slope(k, u[k])).collect();
    // The bounds are knowledge, too, and keep the matrix regular where the data are silent: a range as a
    // standard deviation of its twelfth's root.
    let mut regular = normal.clone();
    let range: Vec<f64> = coordinates
        .free
        .iter()
        .map(|&i| (coordinates.parameters[i].max - coordinates.parameters[i].min) / 12f64.sqrt())
        .collect();
    for k in 0..n {
        regular[(k, k)] += (slopes[k] / range[k]).powi(2).max(1e-12);
    }
    let Some(inverse) = regular.clone().cholesky().map(|c| c.inverse()) else {
        let covariance = DMatrix::from_diagonal(&DVector::from_fn(n, |k, _| range[k].powi(2)));
        return Spread { covariance, felt: vec![false; n], inflation: 1.0 };
    };
    let mut spread = inverse.clone();
    if at.rms > AT_THE_FLOOR {
        // Priors and bounds scatter as they say; the data as they show.
        let from_data = scatter(data, at, projected, n);
        let mut middle = &regular - gram(projected, n);
        middle *= doubt;
        middle += from_data;
        let sandwich = &inverse * middle * &inverse;
        for k in 0..n {
            // Few stretches can underestimate by chance: never below what noise of the residual's size gives.
            let least = inverse[(k, k)] * at.rms.powi(2).min(1e12);
            let prior = coordinates.prior_row(k, u[k]).map_or(f64::INFINITY, |(_, slope)| slope.powi(-2));
            let wanted = sandwich[(k, k)].max(least.min(prior)).max(inverse[(k, k)]);
            spread[(k, k)] = wanted;
        }
        // Correlations are the sandwich's own.
        for k in 0..n {
            for l in 0..n {
                if k != l {
                    let own = (sandwich[(k, k)] * sandwich[(l, l)]).sqrt();
                    let correlation = if own > 0.0 { (sandwich[(k, l)] / own).clamp(-1.0, 1.0) } else { 0.0 };
                    spread[(k, l)] = correlation * (spread[(k, k)] * spread[(l, l)]).sqrt();
                }
            }
        }
    }
    let felt = (0..n)
        .map(|k| {
            let std = spread[(k, k)].sqrt() * slopes[k];
            match coordinates.parameters[coordinates.free[k]].prior_std {
                Some(prior) => std < 0.8 * prior,
                None => std < range[k] / 3.0,
            }
        })
        .collect();
    let ratios: f64 = (0..n).map(|k| spread[(k, k)] / inverse[(k, k)]).sum();
    let inflation = if n == 0 { 1.0 } else { (ratios / n as f64).sqrt() };
    let covariance = DMatrix::from_fn(n, n, |k, l| spread[(k, l)] * slopes[k] * slopes[l]);
    Spread { covariance, felt, inflation }
}

/// Sum over stretches of the runs of the outer product of their scores `J'r`; all channels of a run share
/// a stretch, as they share the model's error.
fn scatter(data: &Data, at: &Evaluation, projected: &[JacobianBlock], n: usize) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(n, n);
    for run in 0..data.runs.len() {
        let mut scores = vec![DVector::<f64>::zeros(n); STRETCHES];
        for (block, residual) in projected.iter().zip(&at.blocks).filter(|(b, _)| b.run == run) {
            let rows = residual.residual.len();
            for (s, score) in scores.iter_mut().enumerate() {
                let part = s * rows / STRETCHES..(s + 1) * rows / STRETCHES;
                for k in 0..n {
                    score[k] += dot(&block.columns[k][part.clone()], &residual.residual[part.clone()]);
                }
            }
        }
        for score in &scores {
            sum += score * score.transpose();
        }
    }
    sum
}
