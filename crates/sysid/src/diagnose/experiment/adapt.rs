//! What is left of the difference between two predictions when one of them adapts its parameters.

use crate::diagnose::Candidate;
use crate::fit::dot;
use nalgebra::{DMatrix, DVector};

/// The columns of a rival as independent unknowns of size one: `J L` with the correlations `L L'`.
pub(crate) fn independent(columns: &[Vec<f64>], rival: &Candidate) -> Vec<Vec<f64>> {
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
    DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 + 1e-6 } else { rival.fit.correlation(i, j) })
}

/// Squared difference that is left when a rival moves its parameters towards the other's prediction: the
/// minimum of `|d - J z|^2 + z' R^-1 z` for columns by one standard error and correlations `R`.
pub(crate) fn adapted(difference: &[f64], columns: &[Vec<f64>], rival: &Candidate) -> f64 {
    let n = columns.len();
    let total: f64 = difference.iter().map(|d| d * d).sum();
    if n == 0 {
        return total;
    }
    let prior = correlation(rival, n).cholesky().map_or_else(|| DMatrix::identity(n, n), |c| c.inverse());
    let a = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j])) + prior;
    let g = DVector::from_fn(n, |i, _| dot(&columns[i], difference));
    let gained = a.cholesky().map_or(0.0, |a| g.dot(&a.solve(&g)));
    (total - gained).max(0.0)
}
