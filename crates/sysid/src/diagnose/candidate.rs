//! A set of effects beside the base model, fitted to the fit runs and cross-validated inside them.

use super::rugged;
use super::validation::{Validation, validate};
use crate::Error;
use crate::data::{Data, Evaluation};
use crate::fit::{Difference, Fit, FitOptions, KnownColumns, fit};
use sealegs_model::{Excitation, Model};
use std::sync::Arc;

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
    /// Whether what is held in a search only is free (see [`FitOptions::last`]).
    pub last: bool,
}

impl Effort {
    /// As many steps, every derivative by simulation.
    #[must_use]
    pub fn steps(steps: usize) -> Self {
        Self { steps, difference: Difference::Forward, columns: None, last: false }
    }
}

impl Candidate {
    /// The base model as it was fitted.
    #[must_use]
    pub fn of_base(data: &Data, base: &dyn Model, fit: Fit) -> Self {
        let validation = validate(data, base, &[], &fit);
        Self { effects: Vec::new(), model: base.clone_box(), fit, validation, exact: false }
    }

    /// A set that was fitted with the model itself.
    #[must_use]
    pub fn exactly(data: &Data, effects: Vec<String>, model: Box<dyn Model>, fit: Fit) -> Self {
        let validation = validate(data, model.as_ref(), &effects, &fit);
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
            held: rugged::held(model.as_ref()),
            last: effort.last,
            ..FitOptions::default()
        };
        let fit = fit(data, model.as_ref(), &options)?;
        let validation = validate(data, model.as_ref(), effects, &fit);
        Ok(Self { effects: effects.to_vec(), model, fit, validation, exact: false })
    }

    /// What it leaves of runs that it was not fitted to, each sensor as it was fitted.
    ///
    /// # Errors
    ///
    /// If a run cannot be simulated.
    pub(super) fn held_out(&self, holdout: &Data) -> Result<Evaluation, Error> {
        holdout.judge(self.model.as_ref(), &self.fit.values, self.fit.sensors())
    }

    /// Fitted values by the parameters' names.
    #[must_use]
    pub fn known(&self) -> Vec<(String, f64)> {
        self.named(&self.fit.values)
    }

    /// Values of its model by the parameters' names.
    #[must_use]
    pub fn named(&self, values: &[f64]) -> Vec<(String, f64)> {
        self.fit.parameters.iter().zip(values).map(|(p, v)| (p.name.clone(), *v)).collect()
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
        self.model.parameters().iter().filter(|p| !p.fixed && p.name.contains('.')).count()
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

/// What an effect calls one of its parameters, if it is its own.
pub(super) fn symbol<'a>(parameter: &'a str, effect: &str) -> Option<&'a str> {
    parameter.strip_prefix(effect)?.strip_prefix('.')
}
