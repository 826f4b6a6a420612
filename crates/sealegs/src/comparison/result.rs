//! A comparison that owns what it is about: typed numbers, from which JSON, text, report and recording are made.

use super::{Compared, Part, Summary, compare as compared, page, recording, text};
use crate::campaign_model::{self, CampaignModel};
use crate::diagnosis::provenance::Provenance;
use crate::stoppable::{Stoppable, unless_stopped};
use crate::{Options, Result};
use sealegs_recorder::recording;
use sealegs_sysid::diagnose::missing_signals;
use sealegs_sysid::{Campaign, Data, Evaluation, Fit, Role, units};
use std::time::{Duration, Instant};

/// Where a model fails on a campaign, and by how much.
#[derive(Debug)]
pub struct Comparison {
    campaign: Campaign,
    model: Box<dyn CampaignModel>,
    fit: Option<Fit>,
    evaluated: Vec<(Role, Evaluation, Option<Evaluation>)>,
    summary: Summary,
    work: (u64, f64),
    command: String,
    took: Duration,
}

/// Compares a campaign with its model, or with that of the options, after the model's own parameters were refitted.
///
/// ```
/// use sealegs::{Campaign, compare};
///
/// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/campaigns/bench-knee");
/// let campaign = Campaign::read(folder.as_ref())?;
/// let comparison = compare(&campaign, "thor-linear")?;
/// println!("{}", comparison.sentence());
/// assert!(comparison.summary().base.holdout_error > Some(1.0));
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// Bad input in the model's or an effect's file, a campaign without fit runs if there is to be a refit, a model that
/// cannot be simulated, [`Error::Stopped`](crate::Error::Stopped).
pub fn compare(campaign: &Campaign, options: impl Into<Options>) -> Result<Comparison> {
    let (started, options) = (Instant::now(), options.into());
    let mut campaign = campaign.clone();
    let model = campaign_model::of_source(&mut campaign, &options.model, &options.own_effects)?;
    options.tell("refitting the model's own parameters");
    let per_unit = units::per_unit(&campaign, model.as_ref())?;
    let stoppable = Stoppable::new(per_unit.as_ref(), &options);
    let done = unless_stopped(&options, compared(&campaign, &stoppable, model.as_ref(), options.as_is))?;
    options.tell("estimating what is missing at each port");
    let ports = match done.part(Role::Fit) {
        Some(part) => unless_stopped(&options, missing_signals(&part.data, &stoppable, done.fit.as_ref()))?,
        None => Vec::new(),
    };
    let provenance = Provenance::of_campaign(&campaign, model.name(), &options.files())?;
    let summary = Summary::new(&done, &ports, provenance);
    let Compared { fit, parts, work, .. } = done;
    let evaluated = parts.into_iter().map(|p| (p.role, p.before, p.after)).collect();
    Ok(Comparison {
        fit,
        evaluated,
        summary,
        work,
        model,
        campaign,
        command: options.command_of("sealegs::compare"),
        took: started.elapsed(),
    })
}

impl Comparison {
    /// The result in numbers; what [`Comparison::to_json`] writes.
    #[must_use]
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The result in one sentence.
    #[must_use]
    pub fn sentence(&self) -> &str {
        &self.summary.sentence
    }

    /// The campaign, with what the model's file says of its sensors and with remarks.
    #[must_use]
    pub fn campaign(&self) -> &Campaign {
        &self.campaign
    }

    /// The model as it was given.
    #[must_use]
    pub fn model(&self) -> &dyn CampaignModel {
        self.model.as_ref()
    }

    /// The numbers as JSON, indented, with the keys of the data contract.
    ///
    /// # Errors
    ///
    /// None for what a comparison holds.
    pub fn to_json(&self) -> Result<String> {
        crate::json(&self.summary)
    }

    /// Everything for a terminal.
    ///
    /// # Errors
    ///
    /// None for the campaign that was compared.
    pub fn to_text(&self) -> Result<String> {
        Ok(text(&self.view()?, &self.summary, self.took))
    }

    /// The report as one HTML file without anything outside it.
    ///
    /// # Errors
    ///
    /// None for the campaign that was compared.
    pub fn to_html(&self) -> Result<String> {
        Ok(page(&self.view()?, &self.summary, &self.command))
    }

    /// Measured, predicted and residual of every run and channel.
    ///
    /// # Errors
    ///
    /// None for the campaign that was compared.
    pub fn recording(&self) -> Result<recording::Comparison> {
        let view = self.view()?;
        Ok(recording(&view, view.sentence(), |part| part.shown()))
    }

    fn view(&self) -> Result<Compared<'_>> {
        let parts = self.evaluated.iter().map(|(role, before, after)| {
            let data = Data::new(&self.campaign, Some(*role), self.model.as_ref())?;
            Ok(Part { role: *role, data, before: before.clone(), after: after.clone() })
        });
        let parts = parts.collect::<Result<Vec<_>>>()?;
        let sanity = self.summary.sanity.clone();
        Ok(Compared::of(&self.campaign, self.model.name(), self.fit.clone(), parts, sanity, self.work))
    }
}
