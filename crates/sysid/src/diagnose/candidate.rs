//! A set of effects beside the base model, fitted to the fit runs and cross-validated inside them.

use crate::Error;
use crate::data::Data;
use crate::fit::{Difference, Fit, FitOptions, KnownColumns, dot, fit};
use nalgebra::{DMatrix, DVector};
use sealegs_model::{Excitation, Model};
use std::sync::Arc;

/// Stretches of each run that are left out one at a time, where the runs are few; else whole runs are: what
/// holds only at one amplitude must not hold up.
const STRETCHES: usize = 6;

/// From so many runs on whole runs are left out.
const ENOUGH_RUNS: usize = 3;

/// A fitted set of effects.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The effects' ids, in the catalogue's order.
    pub effects: Vec<String>,
    /// The model with them.
    pub model: Box<dyn Model>,
    /// Its fit on all fit runs.
    pub fit: Fit,
    /// How it predicts what was left out.
    pub validation: Validation,
    /// Whether the model was integrated as exactly as it can be; a search is content with less.
    pub exact: bool,
}

/// Gain of a step with which a fit in a search is content (see [`FitOptions::tolerance`]).
const TOLERANCE: f64 = 0.05;

/// The same where derivatives are dear; what is chosen is fitted on.
const ROUGH_TOLERANCE: f64 = 3.0;

/// How much work a fit in a search is worth.
#[derive(Debug, Clone)]
pub struct Effort {
    /// Steps at most.
    pub steps: usize,
    /// Derivatives at its end.
    pub difference: Difference,
    /// Derivatives that are known nearby, where the fit is to make do with them as far as they go (see
    /// [`FitOptions::secants`]).
    pub columns: Option<Arc<KnownColumns>>,
}

impl Effort {
    /// As many steps, every derivative by simulation.
    #[must_use]
    pub fn steps(steps: usize) -> Self {
        Self { steps, difference: Difference::Forward, columns: None }
    }
}

/// Prediction errors on left-out stretches of the fit runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Sum of squared residuals in noise units of each left-out stretch.
    pub stretches: Vec<f64>,
    /// Number of residuals in all of them.
    pub residuals: usize,
}

impl Validation {
    /// Mean squared residual, in squared noise units.
    #[must_use]
    pub fn mean_square(&self) -> f64 {
        self.stretches.iter().sum::<f64>() / self.residuals.max(1) as f64
    }
}

impl Candidate {
    /// The base model as it was fitted.
    #[must_use]
    pub fn of_base(base: &dyn Model, fit: Fit) -> Self {
        let validation = validate(&fit);
        Self { effects: Vec::new(), model: base.clone_box(), fit, validation, exact: false }
    }

    /// A set that was fitted with the model itself.
    #[must_use]
    pub fn exactly(effects: Vec<String>, model: Box<dyn Model>, fit: Fit) -> Self {
        let validation = validate(&fit);
        Self { effects, model, fit, validation, exact: true }
    }

    /// Fits the base model with these effects, from the given values where a parameter's name is known and
    /// from its guess where it is not.
    ///
    /// # Errors
    ///
    /// If an effect cannot be added or nothing can be simulated from there.
    pub fn fitted(
        data: &Data,
        base: &dyn Model,
        effects: &[String],
        seen: &Excitation,
        known: &[(String, f64)],
        effort: &Effort,
    ) -> Result<Self, Error> {
        let model = with_effects(base, effects, seen)?;
        let start = values_by_name(model.as_ref(), known);
        let options = FitOptions {
            start: Some(start),
            starts: 1,
            max_steps: effort.steps,
            tolerance: if effort.columns.is_some() { ROUGH_TOLERANCE } else { TOLERANCE },
            difference: effort.difference,
            secants: effort.columns.is_some(),
            columns: effort.columns.clone(),
            ..FitOptions::default()
        };
        let fit = fit(data, model.as_ref(), &options)?;
        let validation = validate(&fit);
        Ok(Self { effects: effects.to_vec(), model, fit, validation, exact: false })
    }

    /// Fitted values by the parameters' names.
    #[must_use]
    pub fn known(&self) -> Vec<(String, f64)> {
        self.fit.parameters.iter().map(|p| (p.name.clone(), p.value)).collect()
    }

    /// The derivatives of its fit, for fits nearby.
    #[must_use]
    pub fn columns(&self) -> Arc<KnownColumns> {
        Arc::new(KnownColumns::of(&self.fit))
    }

    /// A thorough fit of a model like this one, from a start nearby.
    #[must_use]
    pub fn onward(&self, model: &dyn Model, start: Vec<f64>) -> FitOptions {
        let usual = FitOptions::of(model);
        let columns = usual.secants.then(|| self.columns());
        FitOptions { start: Some(start), starts: 1, columns, ..usual }
    }

    /// Number of parameters that the effects add and a fit may change.
    #[must_use]
    pub fn effect_parameters(&self) -> usize {
        self.fit.parameters.iter().filter(|p| !p.fixed && p.name.contains('.')).count()
    }
}

/// The base model with effects, added in the given order.
///
/// # Errors
///
/// [`Error::Model`] if one cannot be added.
pub fn with_effects(
    base: &dyn Model,
    effects: &[String],
    seen: &Excitation,
) -> Result<Box<dyn Model>, Error> {
    let mut model = base.clone_box();
    for effect in effects {
        model =
            model.with_effect(effect, seen).map_err(|source| Error::Model { run: base.name(), source })?;
    }
    Ok(model)
}

/// A model's values: the known ones by name, its own nominal ones otherwise.
#[must_use]
pub fn values_by_name(model: &dyn Model, known: &[(String, f64)]) -> Vec<f64> {
    let value = |name: &str| known.iter().find(|(n, _)| n == name).map(|(_, v)| *v);
    model.parameters().iter().map(|p| value(&p.name).unwrap_or(p.value)).collect()
}

/// Leaves out one stretch of one run at a time, or one run, and predicts it with the parameters that the rest would have
/// given: one Gauss-Newton step from the fit to everything, which is exact where the residual is linear in
/// the parameters.
fn validate(fit: &Fit) -> Validation {
    let p = fit.free.len();
    let mut stretches = Vec::new();
    let mut residuals = 0;
    let runs = fit.evaluation.blocks.iter().map(|b| b.run).max().map_or(0, |r| r + 1);
    for run in 0..runs {
        let blocks: Vec<usize> =
            (0..fit.evaluation.blocks.len()).filter(|&b| fit.evaluation.blocks[b].run == run).collect();
        let rows = blocks.iter().map(|&b| fit.evaluation.blocks[b].residual.len()).max().unwrap_or(0);
        let parts = if runs >= ENOUGH_RUNS { 1 } else { STRETCHES };
        for stretch in 0..parts {
            let from = rows * stretch / parts;
            let to = rows * (stretch + 1) / parts;
            let mut left = fit.normal.clone();
            let mut gradient = DVector::<f64>::zeros(p);
            for &b in &blocks {
                let columns = &fit.jacobian[b].columns;
                let residual = &fit.evaluation.blocks[b].residual[from..to];
                for i in 0..p {
                    let ci = &columns[i][from..to];
                    gradient[i] += dot(ci, residual);
                    for j in 0..=i {
                        let product = dot(ci, &columns[j][from..to]);
                        left[(i, j)] -= product;
                        if i != j {
                            left[(j, i)] -= product;
                        }
                    }
                }
            }
            // What is at a bound stays there.
            for k in 0..p {
                if fit.parameters[fit.free[k]].at_bound.is_some() {
                    left.row_mut(k).fill(0.0);
                    left.column_mut(k).fill(0.0);
                    left[(k, k)] = 1.0;
                    gradient[k] = 0.0;
                }
            }
            let shift = solve(left, &gradient);
            let mut squares = 0.0;
            for &b in &blocks {
                let residual = &fit.evaluation.blocks[b].residual[from..to];
                let columns = &fit.jacobian[b].columns;
                for (n, r) in residual.iter().enumerate() {
                    let moved: f64 = (0..p).map(|k| columns[k][from + n] * shift[k]).sum();
                    squares += (r + moved).powi(2);
                }
                residuals += residual.len();
            }
            stretches.push(squares);
        }
    }
    Validation { stretches, residuals }
}

/// Solves a positive definite system; directions about which nothing is known stay where they are.
fn solve(mut a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = b.len();
    for k in 0..n {
        // A thousandth of a typical change is never reason to move.
        a[(k, k)] += 1e-3 + 1e-9 * a[(k, k)].abs();
    }
    a.cholesky().map_or_else(|| DVector::zeros(n), |c| c.solve(b))
}
