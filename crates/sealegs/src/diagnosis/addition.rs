//! Adding effects to a model: the joint fit from several starts, and the model file that follows.

use super::outcome::{ParameterValue, Side, parameters, sensors};
use super::provenance::Provenance;
use crate::{Error, Result};
use schemars::JsonSchema;
use sealegs_model::{Excitation, Model, ModelError};
use sealegs_sysid::diagnose::{Candidate, MissingForce, Models, missing_force};
use sealegs_sysid::{Campaign, Data, Evaluation, Role};
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
