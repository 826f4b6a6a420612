//! Geodesic acceleration: a step's second-order correction, at the price of one simulation.
//!
//! Where two parameters do nearly the same (a spring and a compliance in series with it), values that leave the same error lie on
//! a curve. A straight step along it ends where the error is higher, damping shortens it until it is not, and the search takes
//! hundreds of steps. What the straight step's prediction missed tells the curvature: half the second directional
//! derivative. The damped equations, solved for that in place of the residual, lead back to the curve (Transtrum and
//! Sethna 2012, arXiv:1201.5885).

use super::coordinates::Coordinates;
use super::jacobian::{JacobianBlock, dot};
use crate::data::Evaluation;
use nalgebra::{DMatrix, DVector};

/// Longest correction as a share of the step, each coordinate by its own curvature: beyond it the second order says
/// nothing either.
const LONGEST: f64 = 0.4;

/// Where the accelerated step ends that goes with a straight one from `u` to `to`; `None` where the correction would not be
/// small beside the step.
///
/// `columns` are the projected derivatives at `u`, `a` the curvature there with its priors, `here` and `there` the
/// residuals at both ends.
pub(super) fn accelerated(
    coordinates: &Coordinates,
    (u, here): (&[f64], &Evaluation),
    (to, there): (&[f64], &Evaluation),
    columns: &[JacobianBlock],
    (a, damping): (&DMatrix<f64>, f64),
) -> Option<Vec<f64>> {
    let step: Vec<f64> = to.iter().zip(u).map(|(b, a)| b - a).collect();
    let moving: Vec<usize> = (0..u.len()).filter(|&k| step[k] != 0.0).collect();
    let mut missed = vec![0.0; u.len()];
    for ((block, before), after) in columns.iter().zip(&here.blocks).zip(&there.blocks) {
        let mut rest: Vec<f64> = after.residual.iter().zip(&before.residual).map(|(b, a)| b - a).collect();
        for &k in &moving {
            rest.iter_mut().zip(&block.columns[k]).for_each(|(r, c)| *r -= step[k] * c);
        }
        for &k in &moving {
            missed[k] += dot(&block.columns[k], &rest);
        }
    }
    let n = moving.len();
    let mut damped = DMatrix::from_fn(n, n, |i, j| a[(moving[i], moving[j])]);
    for i in 0..n {
        damped[(i, i)] *= 1.0 + damping;
    }
    let wanted = DVector::from_fn(n, |i, _| -missed[moving[i]]);
    let correction = damped.cholesky()?.solve(&wanted);
    let size = |of: &dyn Fn(usize) -> f64| -> f64 {
        (0..n).map(|i| a[(moving[i], moving[i])] * of(i).powi(2)).sum::<f64>().sqrt()
    };
    let (long, short) = (size(&|i| step[moving[i]]), size(&|i| correction[i]));
    if !short.is_finite() || short > LONGEST * long {
        return None;
    }
    let mut end = to.to_vec();
    for (i, &k) in moving.iter().enumerate() {
        end[k] = coordinates.coordinate(k, coordinates.value(k, to[k] + correction[i]));
    }
    Some(end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Block;
    use sealegs_model::Parameter;

    /// Rosenbrock's function as residuals, `10 (y - x^2)` and `1 - x`.
    fn evaluation(u: &[f64]) -> Evaluation {
        let residual = vec![10.0 * (u[1] - u[0] * u[0]), 1.0 - u[0]];
        let cost = 0.5 * dot(&residual, &residual);
        let block = Block { run: 0, channel: 0, slot: 0, residual };
        Evaluation {
            values: u.to_vec(),
            predictions: Vec::new(),
            sensors: Vec::new(),
            blocks: vec![block],
            cost,
            rms: cost.sqrt(),
        }
    }

    #[test]
    fn analytic_an_accelerated_step_ends_where_the_error_is_lowest_across() {
        let mut parameters =
            [Parameter::new("x", "", 1.0, -9.0, 9.0), Parameter::new("y", "", 1.0, -9.0, 9.0)];
        parameters.iter_mut().for_each(|p| p.typical = 1.0);
        let coordinates = Coordinates::new(&parameters);
        let u = [0.8, 0.64];
        let columns = vec![vec![-20.0 * u[0], -1.0], vec![10.0, 0.0]];
        let a = DMatrix::from_fn(2, 2, |i, j| dot(&columns[i], &columns[j]));
        let block = JacobianBlock { run: 0, channel: 0, columns };
        // Along the tangent of y = x^2, where the error is lowest across, to x = 1: there that, and the minimum, is at y = 1.
        let to = [1.0, 0.64 + 2.0 * 0.8 * 0.2];
        let (here, there) = (evaluation(&u), evaluation(&to));
        assert!(there.cost > 0.9 * here.cost, "the straight step gains little");
        let end =
            accelerated(&coordinates, (&u, &here), (&to, &there), std::slice::from_ref(&block), (&a, 0.0))
                .expect("a small correction");
        assert!((end[0] - 1.0).abs() < 1e-9 && (end[1] - 1.0).abs() < 1e-9, "{end:?}");
        // Eleven times as far the second order is no longer small beside the step.
        let far = [3.0, 0.64 + 2.0 * 0.8 * 2.2];
        assert_eq!(
            accelerated(&coordinates, (&u, &here), (&far, &evaluation(&far)), &[block], (&a, 0.0)),
            None
        );
    }
}
