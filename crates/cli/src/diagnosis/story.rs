//! What a report and a recording show: two models on all runs, before and after, with where the first failed.

use super::outcome::Outcome;
use crate::comparison::{Compared, Part};
use sealegs_sysid::diagnose::{Candidate, Diagnosis, Experiment};
use sealegs_sysid::frequency::{self, ChannelResponse};
use sealegs_sysid::locate::locate;
use sealegs_sysid::{Campaign, Data, Error, Evaluation, Role, structure};

/// Everything that is shown.
pub struct Story<'a> {
    /// The numbers.
    pub outcome: &'a Outcome,
    /// The base model (before) and the model with effects (after, if there is one) on all runs; place,
    /// dependences and responses are those of the base model.
    pub compared: Compared<'a>,
    /// The responses of the model after.
    pub after_responses: Vec<ChannelResponse>,
    /// The experiment that is proposed.
    pub experiment: Option<&'a Experiment>,
    /// The command as it was given.
    pub command: String,
}

/// The two models of a story with their evaluations on the holdout runs.
pub struct Sides<'a> {
    /// The refitted base model.
    pub base: &'a Candidate,
    /// On the holdout runs.
    pub base_holdout: Option<&'a Evaluation>,
    /// The model with effects, if there is one to show.
    pub after: Option<&'a Candidate>,
    /// On the holdout runs.
    pub after_holdout: Option<&'a Evaluation>,
}

impl<'a> Sides<'a> {
    /// Those of a diagnosis.
    #[must_use]
    pub fn of(diagnosis: &'a Diagnosis) -> Self {
        let (verdict, tried) = (&diagnosis.verdict, &diagnosis.found.tried);
        let named = !verdict.effects.is_empty();
        Self {
            base: &tried[verdict.base.index],
            base_holdout: Some(&verdict.base_holdout),
            after: named.then(|| &tried[verdict.after.index]),
            after_holdout: named.then_some(&verdict.after_holdout),
        }
    }
}

impl<'a> Story<'a> {
    /// Puts it together from evaluations that are there already.
    ///
    /// # Errors
    ///
    /// What [`Data::new`] refuses.
    pub fn new(
        campaign: &'a Campaign,
        outcome: &'a Outcome,
        sides: &Sides,
        experiment: Option<&'a Experiment>,
        command: String,
    ) -> Result<Self, Error> {
        let model = sides.base.model.as_ref();
        let mut parts = vec![Part {
            role: Role::Fit,
            data: Data::new(campaign, Some(Role::Fit), model)?,
            before: sides.base.fit.evaluation.clone(),
            after: sides.after.map(|c| c.fit.evaluation.clone()),
        }];
        if let Some(before) = sides.base_holdout {
            parts.push(Part {
                role: Role::Holdout,
                data: Data::new(campaign, Some(Role::Holdout), model)?,
                before: before.clone(),
                after: sides.after_holdout.cloned(),
            });
        }
        let before: Vec<(&Data, &Evaluation)> = parts.iter().map(|p| (&p.data, &p.before)).collect();
        let after: Vec<(&Data, &Evaluation)> =
            parts.iter().filter_map(|p| Some((&p.data, p.after.as_ref()?))).collect();
        let after_responses = if after.is_empty() { Vec::new() } else { frequency::responses(&after) };
        let (location, tests, responses) =
            (locate(&before), structure::tests(&before), frequency::responses(&before));
        let compared = Compared {
            campaign,
            model: model.name(),
            floor: outcome.noise_floor,
            fit: Some(sides.base.fit.clone()),
            parts,
            location,
            tests,
            responses,
            work: (outcome.work.simulations, outcome.work.simulated_s),
        };
        Ok(Self { outcome, compared, after_responses, experiment, command })
    }
}
