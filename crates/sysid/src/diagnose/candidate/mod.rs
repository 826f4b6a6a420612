//! A set of effects beside the base model, fitted to the fit runs and cross-validated inside them.

pub(super) mod compare;
pub(super) mod validation;

use crate::Error;
use crate::data::{Data, Evaluation};
use crate::fit::{Fit, FitOptions, KnownColumns, fit};
use compare::mean_square_difference;
use sealegs_model::{EffectCard, Excitation, Model, Parameter, Scale};
use std::f64::consts::TAU;
use std::sync::Arc;
use validation::{Validation, validate};

/// Values by the parameters' full names.
pub type Known = Vec<(String, f64)>;

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

    /// A model with effects fitted as the options say.
    ///
    /// # Errors
    ///
    /// As [`fit`].
    pub fn fitted(
        data: &Data,
        effects: Vec<String>,
        model: Box<dyn Model>,
        options: &FitOptions,
    ) -> Result<Self, Error> {
        let fit = fit(data, model.as_ref(), options)?;
        let validation = validate(data, model.as_ref(), &effects, &fit);
        Ok(Self { effects, model, fit, validation, exact: false })
    }

    /// Mean squared difference of a prediction of some runs and that with half the step, in squared noise units; 0 where the
    /// model's own step is converged.
    #[must_use]
    pub fn step_error(&self, data: &Data, at: &Evaluation) -> f64 {
        let finer = self
            .model
            .finer()
            .and_then(|finer| data.judge(finer.as_ref(), &self.fit.values, self.fit.sensors()).ok());
        finer.map_or(0.0, |finer| mean_square_difference(&finer, at))
    }

    /// What it leaves of runs that it was not fitted to, each sensor as it was fitted.
    ///
    /// # Errors
    ///
    /// If a run cannot be simulated.
    pub(crate) fn held_out(&self, holdout: &Data) -> Result<Evaluation, Error> {
        holdout.judge(self.model.as_ref(), &self.fit.values, self.fit.sensors())
    }

    /// Fitted values by the parameters' names.
    #[must_use]
    pub fn known(&self) -> Vec<(String, f64)> {
        self.fit.known()
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

    /// What it leaves above the noise, as a cost.
    pub(crate) fn cost_above(&self, floor: f64) -> f64 {
        (self.fit.cost - 0.5 * floor.powi(2) * self.validation.residuals as f64).max(0.0)
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

/// A model's values: the known ones by name, its own nominal ones otherwise, and where it leaves nothing to choose.
#[must_use]
pub fn values_by_name(model: &dyn Model, known: &[(String, f64)]) -> Vec<f64> {
    let open = |p: &Parameter| !p.fixed || p.freed_at_last || !p.starts.is_empty();
    let value = |p: &Parameter| known.iter().find(|(n, _)| *n == p.name && open(p)).map(|(_, v)| *v);
    model.parameters().iter().map(|p| value(p).unwrap_or(p.value)).collect()
}

/// Values with each phase, and each place along a period, within half a period of zero: the others mean the same. A value
/// whose bounds forbid that stays.
pub(crate) fn within_half_a_period(parameters: &[Parameter], values: &[f64]) -> Vec<f64> {
    let period = |name: &str| {
        let (effect, own) = name.rsplit_once('.')?;
        if own == EffectCard::PHASE {
            return Some(TAU);
        }
        let is_period =
            |p: &Parameter| symbol(&p.name, effect).is_some_and(|s| s.starts_with(EffectCard::PERIOD));
        let at = parameters.iter().position(is_period)?;
        own.starts_with(EffectCard::PLACE).then(|| values[at])
    };
    let nearest = |(p, value): (&Parameter, &f64)| {
        let nearest = period(&p.name).map(|period| value - period * (value / period).round());
        nearest.filter(|v| !p.fixed && (p.min..=p.max).contains(v)).unwrap_or(*value)
    };
    parameters.iter().zip(values).map(nearest).collect()
}

/// What an effect calls one of its parameters, if it is its own.
pub(crate) fn symbol<'a>(parameter: &'a str, effect: &str) -> Option<&'a str> {
    parameter.strip_prefix(effect)?.strip_prefix('.')
}

/// A set in a sentence.
#[must_use]
pub fn in_words(set: &[String]) -> String {
    if set.is_empty() { "the base model".to_owned() } else { set.join(" + ") }
}

/// A set without one of its members.
pub(crate) fn all_but(effects: &[String], leaving: &str) -> Vec<String> {
    effects.iter().filter(|e| *e != leaving).cloned().collect()
}

/// Whether the effect vanishes in proportion to this parameter.
pub(crate) fn is_amplitude(p: &Parameter) -> bool {
    p.neutral == Some(0.0) && !p.fixed && p.scale == Scale::Linear
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_phase_and_a_place_are_told_within_half_a_period_of_zero() {
        let new = |name: &str| Parameter::new(name, "", 0.0, -100.0, 100.0);
        let mut bounded = new("other.phase_rad");
        bounded.min = 3.0;
        let parameters =
            [new("place_m"), new("wave.period_m"), new("wave.place_m"), new("ripple.phase_rad"), bounded];
        let told = within_half_a_period(&parameters, &[7.0, 3.0, 7.0, -5.0, 5.0]);
        assert_eq!(told, [7.0, 3.0, 1.0, TAU - 5.0, 5.0]);
    }
}
