//! A model that was made better: the errors without and with the effects that were added, and the file that follows.

use super::addition::{self, Added, Summary};
use super::confidence::Confidence;
use super::outcome::{ForceSaid, Outcome, OutcomeKind, Ranked, RungSaid, Side, Work, parameters, percent};
use super::provenance::Provenance;
use super::story::{Sides, Story};
use super::units::Units;
use super::{page, text};
use crate::campaign_model::{self, CampaignModel, inputs_of};
use crate::stoppable::{Stoppable, unless_stopped};
use crate::{Error, Options, Result, comparison};
use sealegs_actuator::effect::OwnEffect;
use sealegs_recorder::recording;
use sealegs_sysid::{Campaign, Role, units};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A model with effects added to it, both fitted to a campaign.
pub struct Addition {
    campaign: Campaign,
    model: Arc<dyn CampaignModel>,
    label: String,
    added: Added,
    summary: Summary,
    outcome: Outcome,
    command: String,
}

/// Adds effects to the campaign's model, or to that of the options, and fits everything together.
///
/// An effect is named by its id (`coulomb-friction`, `knee/coulomb-friction`), by several ids (`backlash+cogging`), or by
/// the file of a user's own effect.
///
/// ```no_run
/// use sealegs::{Campaign, add};
///
/// let campaign = Campaign::read("knee-bench".as_ref())?;
/// let better = add(&["coulomb-friction"], &campaign, "thor-linear")?;
/// let (before, after) = (&better.summary().base, &better.summary().after);
/// println!("{:?} -> {:?} noise units", before.holdout_error, after.holdout_error);
/// std::fs::write("better.toml", better.model_file(".".as_ref())?).expect("a place for the model");
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::UnknownEffect`] with the ids that the model can have, [`Error::BadEffect`], bad input in a file, a campaign
/// without fit runs, a model that cannot be simulated, [`Error::Stopped`].
pub fn add<E: AsRef<str>>(
    effects: &[E],
    campaign: &Campaign,
    options: impl Into<Options>,
) -> Result<Addition> {
    let mut options = options.into();
    let (effects, own) = named(effects)?;
    options.own_effects.extend(own);
    let mut campaign = campaign.clone();
    let model = campaign_model::of_source(&mut campaign, &options.model, &options.own_effects)?;
    campaign.require(Role::Fit)?;
    let per_unit = units::per_unit(&campaign, model.as_ref())?;
    let stoppable = Stoppable::new(per_unit.as_ref(), &options);
    let added = addition::add(&campaign, &stoppable, &effects, &|what| options.tell(&what));
    let added = unless_stopped(&options, added)?;
    let mut files: Vec<&Path> = options.own_effects.iter().map(PathBuf::as_path).collect();
    files.extend(options.model.file());
    let provenance = Provenance::of_campaign(&campaign, model.name(), &files)?;
    let label = options.model.label(&campaign);
    Ok(Addition::new(campaign, model.into(), added, (label, options.command_of("sealegs::add")), provenance))
}

impl Addition {
    /// What was added to the model of a campaign; of the texts the first says which model that was, the second by what command.
    pub(super) fn new(
        campaign: Campaign,
        model: Arc<dyn CampaignModel>,
        added: Added,
        (label, command): (String, String),
        provenance: Provenance,
    ) -> Self {
        let summary = added.summary(&campaign, provenance.clone());
        let outcome = outcome(&campaign, &added, provenance);
        Self { campaign, model, label, added, summary, outcome, command }
    }

    /// The result in numbers; what [`Addition::to_json`] writes.
    #[must_use]
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The result in one sentence with its numbers.
    #[must_use]
    pub fn sentence(&self) -> &str {
        &self.outcome.sentence
    }

    /// Both models with their fits.
    #[must_use]
    pub fn added(&self) -> &Added {
        &self.added
    }

    /// The units of the campaign, each with a model file of its own; empty where there are fewer than two.
    #[must_use]
    pub fn units(&self) -> Vec<String> {
        units::of_campaign(&self.campaign)
    }

    /// The text of a model file (an actuator's, for a leg a scenario's) with the effects and values, which loads again
    /// from `folder`; it says where its numbers come from.
    ///
    /// # Errors
    ///
    /// [`Error::SeveralUnits`] of a campaign that has them: [`Addition::model_file_of`] writes one unit's. Otherwise if the
    /// model would not load again.
    pub fn model_file(&self, folder: &Path) -> Result<String> {
        match self.units() {
            units if units.is_empty() => self.written(&self.added.fitted(), folder),
            units => Err(Error::SeveralUnits { campaign: self.campaign.file.clone(), units }),
        }
    }

    /// The text of one unit's model file: its own values and sensors, with the effects that all units share.
    ///
    /// # Errors
    ///
    /// [`Error::NoSuchUnit`] if the campaign has no unit of this name, or only one; otherwise if the model would not load
    /// again.
    pub fn model_file_of(&self, unit: &str, folder: &Path) -> Result<String> {
        let units = self.units();
        if !units.iter().any(|known| known == unit) {
            return Err(Error::NoSuchUnit {
                campaign: self.campaign.file.clone(),
                unit: unit.to_owned(),
                units,
            });
        }
        self.written(&self.added.of_unit(&self.campaign, unit), folder)
    }

    fn written(&self, fitted: &addition::Fitted, folder: &Path) -> Result<String> {
        let provenance = &self.summary.provenance;
        let from = [
            ("command", self.command.clone()),
            ("version", format!("sealegs {}", provenance.version)),
            ("model", self.label.clone()),
            inputs_of(provenance),
        ];
        self.model.better(fitted, &self.campaign, &from, folder)
    }

    /// The numbers as JSON, indented, with the keys of the data contract.
    ///
    /// # Errors
    ///
    /// None for what an addition holds.
    pub fn to_json(&self) -> Result<String> {
        crate::json(&self.summary)
    }

    /// Errors before and after, and the values, for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let added = &self.added;
        let mut out = String::new();
        let o = &mut out;
        let _ = writeln!(o, "{} with {}", added.before.model.name(), added.effects.join(" + "));
        let _ = writeln!(o, "\n  error in noise units      before      after");
        let (b, a) = (added.before.fit.error(), added.after.fit.error());
        let _ = writeln!(o, "  {:<22} {b:>9.3} {a:>10.3}", "fit runs");
        match (&added.before_holdout, &added.after_holdout) {
            (Some(b), Some(a)) => {
                let _ = writeln!(o, "  {:<22} {:>9.3} {:>10.3}", "held-out runs", b.rms, a.rms);
            }
            _ => {
                let _ = writeln!(o, "  no held-out runs: the error is that of the runs that were fitted");
            }
        }
        let _ = writeln!(o, "\n  parameters");
        out.push_str(&text::parameter_lines(&parameters(&added.after.fit)));
        if let Some(units) = &self.summary.units {
            out.push_str(&units.text("before", Some("after")));
        }
        out
    }

    /// The report as one HTML file without anything outside it.
    ///
    /// # Errors
    ///
    /// None for the campaign that was fitted.
    pub fn to_html(&self) -> Result<String> {
        Ok(page(&self.story()?))
    }

    /// Measured, before, after and residuals of every run and channel.
    ///
    /// # Errors
    ///
    /// None for the campaign that was fitted.
    pub fn recording(&self) -> Result<recording::Comparison> {
        Ok(comparison::recording(&self.story()?.compared, self.outcome.sentence.clone(), |part| &part.before))
    }

    fn story(&self) -> Result<Story<'_>> {
        let sides = Sides {
            base: &self.added.before,
            base_holdout: self.added.before_holdout.as_ref(),
            after: Some(&self.added.after),
            after_holdout: self.added.after_holdout.as_ref(),
        };
        Ok(Story::new(&self.campaign, &self.outcome, &sides, None, self.command.clone())?)
    }
}

impl std::fmt::Debug for Addition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Addition").field("summary", &self.summary).finish_non_exhaustive()
    }
}

/// Ids of the effects that are asked for, and the files of those that a user wrote.
///
/// # Errors
///
/// [`Error::BadEffect`] for an empty name, a file that is not there, or an effect that is named twice; bad input in an
/// effect's file.
pub fn named<E: AsRef<str>>(asked: &[E]) -> Result<(Vec<String>, Vec<PathBuf>)> {
    let bad = |effect: &str, problem| Error::BadEffect { effect: effect.to_owned(), problem };
    let (mut ids, mut own) = (Vec::new(), Vec::new());
    for argument in asked.iter().map(AsRef::as_ref) {
        let whole = Path::new(argument).is_file();
        let parts: Vec<&str> =
            if whole { vec![argument] } else { argument.split('+').map(str::trim).collect() };
        for part in parts {
            let path = Path::new(part);
            let id = if path.is_file() {
                own.push(path.to_owned());
                OwnEffect::load(path)?.included_id()
            } else if part.ends_with(".toml") {
                return Err(bad(part, "names no such file"));
            } else {
                part.to_owned()
            };
            if id.is_empty() {
                return Err(bad(argument, "names an effect with an empty name"));
            }
            if ids.contains(&id) {
                return Err(bad(&id, "is named twice"));
            }
            ids.push(id);
        }
    }
    Ok((ids, own))
}

/// The addition in the form that the report shows.
fn outcome(campaign: &Campaign, added: &Added, provenance: Provenance) -> Outcome {
    let base = Added::side(&added.before, added.before_holdout.as_ref());
    let after = Added::side(&added.after, added.after_holdout.as_ref());
    let floor = campaign.noise_floor();
    let excess = |error: f64| (error * error - floor * floor).max(0.0);
    let share = if excess(base.holdout_error) > 0.0 {
        (excess(after.holdout_error) / excess(base.holdout_error)).min(1.0)
    } else {
        0.0
    };
    let runs = if added.before_holdout.is_some() { "held-out" } else { "fit" };
    let sentence = format!(
        "Added {}: the error on the {runs} runs goes from {:.3} to {:.3} noise units (noise floor {floor:.2}); \
         {} of the residual energy above the noise floor is left.",
        added.effects.join(" + "),
        base.holdout_error,
        after.holdout_error,
        percent(share)
    );
    let left = |c: &sealegs_sysid::diagnose::Candidate| c.validation.mean_square();
    let residuals = added.before.validation.residuals as f64;
    let rung = |side: &Side, effects: &[String]| RungSaid {
        effects: effects.to_vec(),
        holdout_error: side.holdout_error,
        fit_error: side.fit_error,
    };
    Outcome {
        campaign: campaign.name.clone(),
        noise_floor: floor,
        ladder: vec![rung(&base, &[]), rung(&after, &added.effects)],
        traces: Vec::new(),
        missing_signals: Vec::new(),
        missing_after: Vec::new(),
        missing_force: added.force.as_ref().map(ForceSaid::of),
        law: None,
        ranking: vec![Ranked {
            effects: added.effects.clone(),
            holdout_error: after.holdout_error,
            evidence: 0.5 * (left(&added.before) - left(&added.after)) * residuals
                / left(&added.after).max(1.0),
            parameters: parameters(&added.after.fit),
        }],
        base,
        verdict: OutcomeKind::Added,
        effects: added.effects.clone(),
        indistinguishable: Vec::new(),
        same_by_another_name: Vec::new(),
        equally_good_choices: Vec::new(),
        after: Some(after),
        unexplained_share: share,
        next_experiment: String::new(),
        sentence,
        confidence: Confidence::default(),
        remainder: Vec::new(),
        units: Units::of_addition(campaign, added),
        splits: None,
        sanity: Vec::new(),
        notes: campaign.notes.clone(),
        work: Work { simulations: added.work.0, simulated_s: added.work.1, steps: 0, ended_early: false },
        provenance,
    }
}
