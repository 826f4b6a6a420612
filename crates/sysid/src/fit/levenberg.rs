//! Levenberg and Marquardt's search inside bounds.

use super::coordinates::{Bound, Coordinates};
use super::jacobian::{self, Difference};
use crate::Error;
use crate::data::{Data, Evaluation};
use nalgebra::{DMatrix, DVector};
use sealegs_model::Model;

/// A search and where it has got to; it can be continued.
pub(super) struct Search {
    pub u: Vec<f64>,
    pub evaluation: Evaluation,
    /// Cost with the parameters' priors.
    pub cost: f64,
    pub steps: usize,
    pub converged: bool,
    damping: f64,
}

/// Steps are given up when damping has grown beyond this.
const MOST_DAMPING: f64 = 1e9;

impl Search {
    pub fn new(
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        start: &[f64],
    ) -> Result<Self, Error> {
        let u = coordinates.coordinates(start);
        let values = coordinates.values(&u, start);
        let evaluation = data.evaluate(model, &values)?;
        let cost = evaluation.cost + coordinates.prior_cost(&values);
        Ok(Self { u, evaluation, cost, steps: 0, converged: coordinates.len() == 0, damping: 1e-3 })
    }

    /// Takes at most `steps` further steps.
    pub fn run(
        &mut self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        steps: usize,
        tolerance: f64,
    ) {
        for _ in 0..steps {
            if self.converged {
                return;
            }
            self.steps += 1;
            let raw = jacobian::raw(data, model, &self.evaluation, coordinates, &self.u, Difference::Forward);
            let mut projected = raw.clone();
            jacobian::project(data, &self.evaluation, &mut projected);
            let (mut a, mut g) = jacobian::normal(&projected, &raw, &self.evaluation);
            drop((raw, projected));
            add_priors(coordinates, &self.u, &mut a, &mut g);
            self.step(data, model, coordinates, &a, &g, tolerance);
        }
    }

    /// One accepted step, or the end.
    fn step(
        &mut self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        a: &DMatrix<f64>,
        g: &DVector<f64>,
        tolerance: f64,
    ) {
        let enough = tolerance * self.evaluation.rms.powi(2).max(1.0);
        while self.damping < MOST_DAMPING {
            let Some((moved, promised)) = proposal(coordinates, &self.u, a, g, self.damping) else { break };
            if promised < enough {
                break;
            }
            let values = coordinates.values(&moved, &self.evaluation.values);
            let tried = data.evaluate(model, &values).ok();
            let cost = tried.as_ref().map_or(f64::INFINITY, |e| e.cost + coordinates.prior_cost(&values));
            let gained = self.cost - cost;
            if let Some(evaluation) = tried.filter(|_| gained > 0.0) {
                (self.u, self.evaluation, self.cost) = (moved, evaluation, cost);
                // A step that kept its promise deserves more trust.
                self.damping *= if gained > 0.75 * promised {
                    0.1
                } else if gained > 0.25 * promised {
                    1.0
                } else {
                    4.0
                };
                self.damping = self.damping.max(1e-9);
                self.converged = gained < enough;
                return;
            }
            self.damping = (self.damping * 10.0).max(1e-3);
        }
        self.damping = 1e-3;
        self.converged = true;
    }
}

/// Adds each parameter's prior row to the normal equations.
pub(super) fn add_priors(coordinates: &Coordinates, u: &[f64], a: &mut DMatrix<f64>, g: &mut DVector<f64>) {
    for (k, &x) in u.iter().enumerate() {
        if let Some((row, slope)) = coordinates.prior_row(k, x) {
            a[(k, k)] += slope * slope;
            g[k] += slope * row;
        }
    }
}

/// Where a damped step leads, inside the bounds, and by how much the cost should fall; `None` if no
/// coordinate can move.
fn proposal(
    coordinates: &Coordinates,
    u: &[f64],
    a: &DMatrix<f64>,
    g: &DVector<f64>,
    damping: f64,
) -> Option<(Vec<f64>, f64)> {
    // What neither data nor prior feels stays where it is: a typical change must move the residuals at all.
    let mut moving: Vec<usize> =
        (0..u.len()).filter(|&k| a[(k, k)] > 1e-9 && !outward(coordinates, k, u[k], -g[k])).collect();
    // A step that leads out of the box at a coordinate on the bound is taken again without it.
    for _ in 0..=u.len() {
        if moving.is_empty() {
            return None;
        }
        let n = moving.len();
        let mut damped = DMatrix::from_fn(n, n, |i, j| a[(moving[i], moving[j])]);
        for i in 0..n {
            damped[(i, i)] *= 1.0 + damping;
        }
        let rhs = DVector::from_fn(n, |i, _| -g[moving[i]]);
        let mut step = damped.cholesky()?.solve(&rhs);
        let excess = (0..n).map(|i| step[i].abs() / coordinates.largest_step(moving[i])).fold(1.0, f64::max);
        step /= excess;
        let blocked = (0..n).find(|&i| outward(coordinates, moving[i], u[moving[i]], step[i]));
        if let Some(i) = blocked {
            moving.remove(i);
            continue;
        }
        let mut moved = u.to_vec();
        for (i, &k) in moving.iter().enumerate() {
            moved[k] = coordinates.coordinate(k, coordinates.value(k, u[k] + step[i]));
        }
        let d = DVector::from_fn(u.len(), |k, _| moved[k] - u[k]);
        let promised = -(g.dot(&d) + 0.5 * d.dot(&(a * &d)));
        return Some((moved, promised));
    }
    None
}

/// Whether a move from a bound leads out.
fn outward(coordinates: &Coordinates, k: usize, u: f64, direction: f64) -> bool {
    match coordinates.bound(k, u) {
        Some(Bound::Min) => direction < 0.0,
        Some(Bound::Max) => direction > 0.0,
        None => false,
    }
}
