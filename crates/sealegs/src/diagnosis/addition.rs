//! Adding effects to a model: the joint fit from several starts, and the model file that follows.

use super::outcome::{ParameterValue, Side, parameters, sensors};
use super::provenance::Provenance;
use super::units::Units;
use crate::{Error, Result};
use schemars::JsonSchema;
use sealegs_model::{Excitation, Model, ModelError, Parameter};
use sealegs_sysid::diagnose::{Candidate, Diagnosis, MissingForce, Models, missing_force};
use sealegs_sysid::fit::FittedParameter;
use sealegs_sysid::nuisance::Sensor;
use sealegs_sysid::{Campaign, Data, Evaluation, Role, units};
use serde::Serialize;

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
    /// What is missing without them and what they give, where the runs measure a motion to follow.
    pub force: Option<MissingForce>,
    /// Without them on the holdout runs, if there are any.
    pub before_holdout: Option<Evaluation>,
    /// With them.
    pub after_holdout: Option<Evaluation>,
    /// Simulations done, and the seconds of experiment that they covered.
    pub work: (u64, f64),
}

/// What a model file is written from: a model's values after effects were added to it, of one unit where there are several.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The effects, in the order in which they were asked for.
    pub effects: Vec<String>,
    /// What the fit runs measured and how hard they drove the model.
    pub seen: Excitation,
    /// The unit, where the campaign has several.
    pub unit: Option<String>,
    /// The parameters as they were fitted, in the order of the model with the effects.
    pub parameters: Vec<FittedParameter>,
    /// The same as the model states them.
    pub stated: Vec<Parameter>,
    /// The sensors.
    pub sensors: Vec<Sensor>,
    /// Root mean square residual of the fit runs without and with the effects, in noise units.
    pub fit_error: (f64, f64),
    /// The same of the holdout runs, if there are any.
    pub holdout_error: Option<(f64, f64)>,
}

impl Fitted {
    /// A model with the effects, in their order.
    pub(crate) fn included_in<M: Clone>(
        &self,
        model: &M,
        including: impl Fn(&M, &str, &Excitation) -> std::result::Result<M, ModelError>,
    ) -> std::result::Result<M, ModelError> {
        self.effects.iter().try_fold(model.clone(), |with_them, id| including(&with_them, id, &self.seen))
    }

    /// The values in the order of the model with the effects.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// One standard error of each.
    #[must_use]
    pub fn stds(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.std).collect()
    }
}

/// The result as `--json` writes it; `base` and `after` are those of `diagnose`.
#[derive(Debug, Clone, Serialize, JsonSchema)]
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
    /// What became of each unit, where the campaign has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// Where the numbers come from.
    pub provenance: Provenance,
}

/// A model with its errors; without holdout runs there is no error on them.
#[derive(Debug, Clone, Serialize, JsonSchema)]
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
    /// The set that a verdict names, as it was fitted there; `None` where nothing is named.
    #[must_use]
    pub fn of_verdict(found: &Diagnosis) -> Option<Self> {
        let (tried, verdict) = (&found.found.tried, &found.verdict);
        (!verdict.effects.is_empty()).then(|| Self {
            effects: verdict.effects.clone(),
            before: tried[0].clone(),
            after: tried[verdict.after.index].clone(),
            seen: found.seen.clone(),
            force: found.force.clone(),
            before_holdout: Some(verdict.base_holdout.clone()),
            after_holdout: Some(verdict.after_holdout.clone()),
            work: (found.simulations, found.simulated_s),
        })
    }

    /// The result in a few numbers.
    #[must_use]
    pub fn summary(&self, campaign: &Campaign, provenance: Provenance) -> Summary {
        Summary {
            campaign: campaign.name.clone(),
            effects: self.effects.clone(),
            noise_floor: campaign.noise_floor(),
            base: SideOfAdd::of(&self.before, self.before_holdout.as_ref()),
            after: SideOfAdd::of(&self.after, self.after_holdout.as_ref()),
            units: Units::of_addition(campaign, self),
            provenance,
        }
    }

    /// What the model file is written from.
    #[must_use]
    pub fn fitted(&self) -> Fitted {
        Fitted {
            effects: self.effects.clone(),
            seen: self.seen.clone(),
            unit: None,
            parameters: self.after.fit.parameters.clone(),
            stated: self.after.model.parameters().to_vec(),
            sensors: self.after.fit.sensors().to_vec(),
            fit_error: (self.before.fit.error(), self.after.fit.error()),
            holdout_error: self
                .before_holdout
                .as_ref()
                .zip(self.after_holdout.as_ref())
                .map(|(b, a)| (b.rms, a.rms)),
        }
    }

    /// What one unit's model file is written from: its own values, its own sensors, its own errors, and the effects that it
    /// shares.
    #[must_use]
    pub fn of_unit(&self, campaign: &Campaign, unit: &str) -> Fitted {
        let whole = self.fitted();
        let own = |name: &str| units::split(name).1.is_none_or(|of| of == unit);
        let plain = |name: &str| units::split(name).0.to_owned();
        let error = |role, before, after| {
            Some((
                units::error_of(campaign, role, before, unit)?,
                units::error_of(campaign, role, after, unit)?,
            ))
        };
        let (before, after) = (&self.before.fit.evaluation, &self.after.fit.evaluation);
        let holdout = self.before_holdout.as_ref().zip(self.after_holdout.as_ref());
        Fitted {
            unit: Some(unit.to_owned()),
            parameters: whole
                .parameters
                .into_iter()
                .filter(|p| own(&p.name))
                .map(|p| FittedParameter { name: plain(&p.name), ..p })
                .collect(),
            stated: whole
                .stated
                .into_iter()
                .filter(|p| own(&p.name))
                .map(|p| Parameter { name: plain(&p.name), ..p })
                .collect(),
            sensors: whole.sensors.into_iter().filter(|s| s.unit.as_deref() == Some(unit)).collect(),
            fit_error: error(Role::Fit, before, after).unwrap_or(whole.fit_error),
            holdout_error: holdout.and_then(|(before, after)| error(Role::Holdout, before, after)),
            ..whole
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
            channels: Vec::new(),
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
    if effects.is_empty() {
        return Err(Error::NoEffect);
    }
    let data = Data::new(campaign, Some(Role::Fit), model)?;
    tell("refitting the model as it is".to_owned());
    let mut models = Models::new(&data, model);
    let base = models.base()?;
    check(model, effects, &models.seen)?;
    tell(format!("fitting {}", effects.join(" + ")));
    let after = models.with_effects(&base, effects).ok_or_else(|| ModelError::Setup {
        reason: format!("{} cannot be simulated with {}", model.name(), effects.join(" + ")),
    })?;
    let before = models.polished(&base);
    let force = missing_force(&models, &after, &[]);
    let seen = models.seen;
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
    Ok(Added { effects: effects.to_vec(), seen, force, before, after, before_holdout, after_holdout, work })
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
