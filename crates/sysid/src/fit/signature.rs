//! What a small change of a model would do to the residual, beyond what the fitted parameters could do.
//!
//! Screening asks this of every effect: its signature is the difference that it makes to the prediction at
//! its guess. Gains, biases and the fitted parameters take up a part of it; the rest may or may not point
//! along the residual. All of it is linear algebra on simulations that are there already.

use super::Fit;
use super::jacobian::{self, JacobianBlock, dot};
use crate::data::Data;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sealegs_model::Prediction;

/// Signatures of some changes, the fit's parameters and the sensors projected out.
#[derive(Debug, Clone)]
pub struct Signatures {
    /// Scalar products of the projected signatures, in squared noise units.
    pub gram: DMatrix<f64>,
    /// Scalar products with the residual: the gradient of the cost by each signature's amplitude.
    pub gradient: DVector<f64>,
    /// Squared norms before the fitted parameters were projected out (sensors are): how much of a signature
    /// the base parameters can imitate.
    pub bare: DVector<f64>,
}

impl Signatures {
    /// Signatures of `changed` predictions, each for all runs, against those of the unchanged model: the fit's
    /// own, or others at the fit's values that are as exact as the changed ones.
    #[must_use]
    pub fn new(data: &Data, fit: &Fit, unchanged: &[Prediction], changed: &[&[Prediction]]) -> Self {
        let at = &fit.evaluation;
        let raw: Vec<JacobianBlock> = at
            .blocks
            .par_iter()
            .map(|block| {
                let run = &data.runs[block.run];
                let name = &run.names[block.slot];
                let channel = block.channel;
                let factor = -at.sensors[channel].gain / data.channels[channel].noise_std;
                let base = unchanged[block.run].output(name).unwrap_or(&[]);
                let columns = changed
                    .iter()
                    .map(|p| match p[block.run].output(name) {
                        Some(p) => run.rows().map(|i| factor * (p[i] - base[i])).collect(),
                        None => vec![0.0; block.residual.len()],
                    })
                    .collect();
                JacobianBlock { run: block.run, channel, columns }
            })
            .collect();
        let projected = jacobian::projected(data, at, &raw);
        let (bare, gradient) = jacobian::normal(&projected, &raw, at);
        let diagonal = DVector::from_fn(changed.len(), |i, _| bare[(i, i)]);
        // A parameter that a bound holds back takes no part of a signature: it cannot move to follow it.
        let held = |k: &usize| fit.parameters[fit.free[*k]].at_bound.is_some();
        let moving: Vec<usize> = (0..fit.free.len()).filter(|k| !held(k)).collect();
        let mut shared = DMatrix::<f64>::zeros(moving.len(), changed.len());
        for (own, other) in fit.jacobian.iter().zip(&raw) {
            for (row, &k) in moving.iter().enumerate() {
                for c in 0..changed.len() {
                    shared[(row, c)] += dot(&own.columns[k], &other.columns[c]);
                }
            }
        }
        let mut normal = fit.normal.select_rows(&moving).select_columns(&moving);
        for k in 0..moving.len() {
            normal[(k, k)] += 1e-12 + 1e-12 * normal[(k, k)];
        }
        let Some(cholesky) = normal.cholesky() else {
            return Self { gram: bare, gradient, bare: diagonal };
        };
        let taken = cholesky.solve(&shared);
        let gram = bare - shared.transpose() * &taken;
        let own = DVector::from_fn(moving.len(), |row, _| fit.gradient[moving[row]]);
        let gradient = gradient - taken.transpose() * own;
        Self { gram, gradient, bare: diagonal }
    }

    /// By how much the cost would fall with the best amplitudes of some signatures together, and those
    /// amplitudes (1: as strong as the guess). Linear: a first opinion, not a fit.
    #[must_use]
    pub fn drop(&self, chosen: &[usize]) -> (f64, Vec<f64>) {
        let n = chosen.len();
        let mut a = DMatrix::from_fn(n, n, |i, j| self.gram[(chosen[i], chosen[j])]);
        let g = DVector::from_fn(n, |i, _| self.gradient[chosen[i]]);
        let size = (0..n).map(|i| a[(i, i)]).fold(0.0, f64::max);
        for i in 0..n {
            a[(i, i)] += 1e-9 * size + f64::MIN_POSITIVE;
        }
        match a.cholesky() {
            Some(cholesky) => {
                let amplitude = -cholesky.solve(&g);
                (-0.5 * g.dot(&amplitude), amplitude.iter().copied().collect())
            }
            None => (0.0, vec![0.0; n]),
        }
    }

    /// By how much the cost would fall with the best wave of which two signatures are an even and an odd part (it, and it a quarter
    /// of a turn later); its amplitude, and its phase, rad.
    #[must_use]
    pub fn wave(&self, even: usize, odd: usize) -> (f64, f64, f64) {
        let (drop, parts) = self.drop(&[even, odd]);
        (drop, parts[0].hypot(parts[1]), parts[1].atan2(parts[0]))
    }

    /// How alike two signatures are after projection: 1 or -1 where one does what the other does.
    #[must_use]
    pub fn cosine(&self, a: usize, b: usize) -> f64 {
        let size = (self.gram[(a, a)] * self.gram[(b, b)]).sqrt();
        if size > 0.0 { self.gram[(a, b)] / size } else { 0.0 }
    }

    /// The size of a signature in noise units (root of the sum of squares) that nothing else can imitate.
    #[must_use]
    pub fn norm(&self, i: usize) -> f64 {
        self.gram[(i, i)].max(0.0).sqrt()
    }
}
