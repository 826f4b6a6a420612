//! Levenberg and Marquardt's search inside bounds.

use super::coordinates::{Bound, Coordinates};
use super::jacobian::{self, Difference, Directions, JacobianBlock};
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
    /// Forward far away; central once steps no longer keep their promise, as in a flat valley a forward
    /// difference's error is larger than the slope.
    difference: Difference,
    /// Columns taken last, bare and projected, for the steps of the next differences.
    last: Option<(Vec<JacobianBlock>, Vec<JacobianBlock>)>,
}

/// Above this error, in noise units, the model is wrong and its residual remembers: samples are then worth far
/// less than their number, and a gain of [`RELATIVE`] of the cost is nothing.
const WRONG: f64 = 1.5;
/// See [`WRONG`].
const RELATIVE: f64 = 1e-5;

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
        Ok(Self {
            u,
            evaluation,
            cost,
            steps: 0,
            converged: coordinates.len() == 0,
            damping: 1e-3,
            difference: Difference::Forward,
            last: None,
        })
    }

    /// Derivatives here: bare, and with what the sensors can take up projected out.
    pub fn derivatives(
        &self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        how: Difference,
    ) -> (Vec<JacobianBlock>, Vec<JacobianBlock>) {
        let along = |how, directions: &Directions| {
            let raw = jacobian::raw(data, model, &self.evaluation, coordinates, &self.u, how, directions);
            let mut projected = raw.clone();
            jacobian::project(data, &self.evaluation, &mut projected);
            (raw, projected)
        };
        let principal = |(raw, projected): &(Vec<JacobianBlock>, Vec<JacobianBlock>)| {
            Directions::principal(coordinates, &self.u, raw, projected, how)
        };
        match &self.last {
            Some(last) => along(how, &principal(last)),
            None if how == Difference::Forward => along(how, &Directions::first(coordinates)),
            None => {
                let rough = along(Difference::Forward, &Directions::first(coordinates));
                along(how, &principal(&rough))
            }
        }
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
            let (raw, projected) = self.derivatives(data, model, coordinates, self.difference);
            let (mut a, mut g) = jacobian::normal(&projected, &raw, &self.evaluation);
            self.last = Some((raw, projected));
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
        let mut enough = tolerance * self.evaluation.rms.powi(2).max(1.0);
        if self.evaluation.rms > WRONG {
            enough = enough.max(RELATIVE * self.cost);
        }
        while self.damping < MOST_DAMPING {
            let (moved, promised) = match proposal(coordinates, &self.u, a, g, self.damping) {
                Proposal::Step(moved, promised) => (moved, promised),
                Proposal::Singular => {
                    self.damping = (self.damping * 30.0).max(1e-10);
                    continue;
                }
                Proposal::Stuck => break,
            };
            if promised < enough {
                break;
            }
            let values = coordinates.values(&moved, &self.evaluation.values);
            let tried = data.evaluate(model, &values).ok();
            let cost = tried.as_ref().map_or(f64::INFINITY, |e| e.cost + coordinates.prior_cost(&values));
            let gained = self.cost - cost;
            if let Some(evaluation) = tried.filter(|_| gained > 0.0) {
                (self.u, self.evaluation, self.cost) = (moved, evaluation, cost);
                // A step that kept its promise deserves more trust. Valleys that only a prior closes are
                // a million times flatter than their walls: damping must be able to vanish.
                let kept = gained / promised;
                if kept < 0.5 {
                    self.difference = Difference::Central;
                }
                self.damping *= match kept {
                    r if r > 0.5 => 0.03,
                    r if r > 0.2 => 0.3,
                    _ => 4.0,
                };
                self.damping = self.damping.max(1e-12);
                self.converged = gained < enough;
                return;
            }
            self.damping = (self.damping * 30.0).max(1e-10);
        }
        // Nothing helps, as far as forward differences can tell.
        self.damping = 1e-3;
        self.converged = self.difference == Difference::Central;
        self.difference = Difference::Central;
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

/// What the normal equations propose.
enum Proposal {
    /// Where the damped step leads, inside the bounds, and by how much the cost should fall.
    Step(Vec<f64>, f64),
    /// No coordinate can move.
    Stuck,
    /// Nearly the same columns, and rounding made the matrix indefinite: more damping is needed.
    Singular,
}

/// The damped step inside the bounds.
fn proposal(
    coordinates: &Coordinates,
    u: &[f64],
    a: &DMatrix<f64>,
    g: &DVector<f64>,
    damping: f64,
) -> Proposal {
    // What neither data nor prior feels stays where it is: a typical change must move the residuals at all.
    let mut moving: Vec<usize> =
        (0..u.len()).filter(|&k| a[(k, k)] > 1e-9 && !outward(coordinates, k, u[k], -g[k])).collect();
    // A step that leads out of the box at a coordinate on the bound is taken again without it.
    for _ in 0..=u.len() {
        if moving.is_empty() {
            return Proposal::Stuck;
        }
        let n = moving.len();
        let mut damped = DMatrix::from_fn(n, n, |i, j| a[(moving[i], moving[j])]);
        for i in 0..n {
            damped[(i, i)] *= 1.0 + damping;
        }
        let rhs = DVector::from_fn(n, |i, _| -g[moving[i]]);
        let Some(cholesky) = damped.cholesky() else { return Proposal::Singular };
        let mut step = cholesky.solve(&rhs);
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
        return Proposal::Step(moved, promised);
    }
    Proposal::Stuck
}

/// Whether a move from a bound leads out.
fn outward(coordinates: &Coordinates, k: usize, u: f64, direction: f64) -> bool {
    match coordinates.bound(k, u) {
        Some(Bound::Min) => direction < 0.0,
        Some(Bound::Max) => direction > 0.0,
        None => false,
    }
}
