//! Adding effects to a model: the joint fit from several starts, and the model file that follows.

use super::outcome::{ParameterValue, Side, parameters, sensors};
use super::provenance::Provenance;
use crate::{Error, Result};
use sealegs_model::{EffectCard, Excitation, Model, ModelError, Parameter};
use sealegs_sysid::diagnose::{
    Candidate, Options, Promise, Starts, fit_holding, reconciled, screen, tuned, with_effects,
};
use sealegs_sysid::{Campaign, Data, Evaluation, Fit, FitOptions, Role, fit};
use serde::Serialize;

/// Starting values of an effect that are simulated before any is fitted.
const STARTS: usize = 200;

/// The most promising ones, which are fitted.
const FITTED: usize = 3;

/// Most steps of a fit before it is finished.
const STEPS: usize = 20;

/// A model before and after effects were added to it, both fitted.
pub struct Added {
    /// The effects, in the order in which they were asked for.
    pub effects: Vec<String>,
    /// Without them.
    pub before: Candidate,
    /// With them.
    pub after: Candidate,
    /// What the fit runs measured and how hard they drove the model.
    pub seen: Excitation,
    /// Without them on the holdout runs, if there are any.
    pub before_holdout: Option<Evaluation>,
    /// With them.
    pub after_holdout: Option<Evaluation>,
    /// Simulations done, and the seconds of experiment that they covered.
    pub work: (u64, f64),
}

/// The result as `--json` writes it; `base` and `after` are those of `diagnose`.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// The campaign's name.
    pub campaign: String,
    /// The effects.
    pub effects: Vec<String>,
    /// 1, or what repeats of runs leave between them, noise units.
    pub noise_floor: f64,
    /// Without them.
    pub base: SideOfAdd,
    /// With them.
    pub after: SideOfAdd,
    /// Where the numbers come from.
    pub provenance: Provenance,
}

/// A model with its errors; without holdout runs there is no error on them.
#[derive(Debug, Clone, Serialize)]
pub struct SideOfAdd {
    /// Root mean square residual of the fit runs, in noise units.
    pub fit_error: f64,
    /// The same of the holdout runs.
    pub holdout_error: Option<f64>,
    /// Its parameters.
    pub parameters: Vec<ParameterValue>,
}

impl SideOfAdd {
    fn of(candidate: &Candidate, holdout: Option<&Evaluation>) -> Self {
        Self {
            fit_error: candidate.fit.error(),
            holdout_error: holdout.map(|h| h.rms),
            parameters: parameters(&candidate.fit),
        }
    }
}

impl Added {
    /// The result in a few numbers.
    #[must_use]
    pub fn summary(&self, campaign: &Campaign, provenance: Provenance) -> Summary {
        Summary {
            campaign: campaign.name.clone(),
            effects: self.effects.clone(),
            noise_floor: campaign.noise_floor(),
            base: SideOfAdd::of(&self.before, self.before_holdout.as_ref()),
            after: SideOfAdd::of(&self.after, self.after_holdout.as_ref()),
            provenance,
        }
    }

    /// One side as reports show it; where there is no holdout run the fit runs stand in.
    #[must_use]
    pub fn side(candidate: &Candidate, holdout: Option<&Evaluation>) -> Side {
        Side {
            holdout_error: holdout.map_or(candidate.fit.error(), |h| h.rms),
            fit_error: candidate.fit.error(),
            parameters: parameters(&candidate.fit),
            sensors: sensors(&candidate.fit),
        }
    }
}

/// Fits a model, adds effects, and fits everything together.
///
/// # Errors
///
/// Bad input for an unknown effect, with the nearest name; otherwise if nothing can be simulated.
pub fn add(
    campaign: &Campaign,
    model: &dyn Model,
    effects: &[String],
    tell: &dyn Fn(String),
) -> Result<Added> {
    let data = Data::new(campaign, Some(Role::Fit), model)?;
    tell("refitting the model as it is".to_owned());
    let base_fit = fit::fit(&data, model, &FitOptions::of(model))?;
    let seen = data.excitation(&base_fit.evaluation.predictions);
    check(model, effects, &seen)?;
    let before = Candidate::of_base(&data, model, base_fit);
    let mut after: Option<Candidate> = None;
    // What an effect shows may depend on another one being there already.
    let backwards: Vec<String> = effects.iter().rev().cloned().collect();
    let orders = if effects.len() > 1 { vec![effects.to_vec(), backwards] } else { vec![effects.to_vec()] };
    for order in orders {
        let grown = grow(&data, model, &before, &order, &seen, tell)?;
        if after.as_ref().is_none_or(|a| grown.fit.cost < a.fit.cost) {
            after = Some(grown);
        }
    }
    let after = after.ok_or_else(|| Error::NoEffect)?;
    tell("fitting everything together".to_owned());
    let after = if fit::has_many_parameters(model) { after } else { reconciled(&data, model, &seen, after) };
    let after = finished(&data, model, effects, &seen, after)?;
    let mut work = data.work();
    let (mut before_holdout, mut after_holdout) = (None, None);
    if campaign.runs_of(Role::Holdout).next().is_some() {
        let holdout = Data::new(campaign, Some(Role::Holdout), model)?;
        let judge = |c: &Candidate| holdout.judge(c.model.as_ref(), &c.fit.values, c.fit.sensors());
        before_holdout = Some(judge(&before)?);
        after_holdout = Some(judge(&after)?);
        let more = holdout.work();
        work = (work.0 + more.0, work.1 + more.1);
    }
    Ok(Added { effects: effects.to_vec(), seen, before, after, before_holdout, after_holdout, work })
}

/// Whether the model can have all of these effects.
fn check(model: &dyn Model, effects: &[String], seen: &Excitation) -> Result<()> {
    let mut with = model.clone_box();
    for effect in effects {
        if with.included().contains(effect) {
            return Err(Error::AlreadyIncluded { model: model.name(), effect: effect.clone() });
        }
        with = with.with_effect(effect, seen).map_err(|source| match source {
            ModelError::UnknownEffect { .. } => {
                let known = with.effects(seen).into_iter().map(|c| c.id).collect();
                Error::UnknownEffect { source, known }
            }
            other => other.into(),
        })?;
    }
    Ok(())
}

/// Adds one effect after the other, each from its most promising starting values.
fn grow(
    data: &Data,
    model: &dyn Model,
    before: &Candidate,
    order: &[String],
    seen: &Excitation,
    tell: &dyn Fn(String),
) -> Result<Candidate> {
    let mut grown = before.clone();
    for effect in order {
        tell(format!("trying starting values of {effect}"));
        let cards: Vec<EffectCard> =
            grown.model.effects(seen).into_iter().filter(|c| c.id == *effect).collect();
        let promises: Vec<Promise> =
            screen(data, &grown, seen, &cards, Starts { most: STARTS, first: STARTS });
        let mut set = grown.effects.clone();
        set.push(effect.clone());
        let effort = Options::of(model).effort(&grown, STEPS);
        let mut best: Option<Candidate> = None;
        for (_, start) in promises.iter().flat_map(|p| p.starts.iter().take(FITTED)) {
            let mut known = grown.known();
            known.extend(start.iter().cloned());
            let Ok(fitted) = Candidate::fitted(data, model, &set, seen, &known, &effort) else { continue };
            if best.as_ref().is_none_or(|b| fitted.fit.cost < b.fit.cost) {
                best = Some(fitted);
            }
        }
        let best = match best {
            Some(best) => best,
            // Nothing was promised: the effect's own guess is as good as any.
            None => Candidate::fitted(data, model, &set, seen, &grown.known(), &effort)?,
        };
        grown = if fit::has_many_parameters(model) {
            best
        } else {
            tuned(data, best, |_, known| Candidate::fitted(data, model, &set, seen, known, &effort).ok())
        };
    }
    Ok(grown)
}

/// The candidate with its effects in the order asked for, fitted to the end, every discrete choice of the
/// base model tried again.
fn finished(
    data: &Data,
    base: &dyn Model,
    effects: &[String],
    seen: &Excitation,
    candidate: Candidate,
) -> Result<Candidate> {
    let model = with_effects(base, effects, seen)?;
    let known = candidate.known();
    let mut best: Option<Fit> = None;
    let mut attempt = |start: Vec<f64>| -> Result<bool> {
        let options = FitOptions { last: true, ..candidate.onward(base, start) };
        let fitted = fit_holding(data, model.as_ref(), &options)?;
        if best.as_ref().is_none_or(|b| fitted.cost < b.cost) {
            best = Some(fitted);
        }
        Ok(best.iter().flat_map(|b| b.sensors()).any(|s| s.gain_at_limit))
    };
    for choice in fit::choices(base) {
        let start = |from_fit: bool| -> Vec<f64> {
            let value = |(i, p): (usize, &Parameter)| {
                let discrete = p.fixed && !p.starts.is_empty() && i < choice.len();
                let fitted = known.iter().find(|(name, _)| *name == p.name).map_or(p.value, |(_, v)| *v);
                if discrete || (i < choice.len() && !from_fit) { choice[i] } else { fitted }
            };
            model.parameters().iter().enumerate().map(value).collect()
        };
        // Without its effects a model may have driven a sensor's gain to its limit, and a search that
        // starts there stays: the nominal values are another place to start from.
        if attempt(start(true))? {
            attempt(start(false))?;
        }
    }
    let fit = best.ok_or_else(|| Error::NoEffect)?;
    Ok(Candidate::exactly(data, effects.to_vec(), model, fit))
}
