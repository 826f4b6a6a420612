//! A diagnosis that owns what it is about: a typed verdict, from which JSON, text, report, recording and plan are made.

use super::addition::Added;
use super::better::Addition;
use super::drift::Astray;
use super::outcome::Outcome;
use super::progress::Searching;
use super::provenance::Provenance;
use super::story::{Sides, Story};
use super::{page, plan, text};
use crate::campaign_model::{self, CampaignModel};
use crate::stoppable::{SearchEnd, Stoppable, unless_stopped};
use crate::{Error, Options, Result, comparison};
use sealegs_model::{Excitation, Model};
use sealegs_recorder::recording;
use sealegs_sysid::diagnose::{self, Experiment, VerdictKind};
use sealegs_sysid::{Campaign, Role, sanity, units};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Which physical effect a model lacks, or that none is missing or none is known.
#[derive(Debug)]
pub struct Diagnosis {
    campaign: Campaign,
    model: Arc<dyn CampaignModel>,
    found: diagnose::Diagnosis,
    experiment: Option<Experiment>,
    outcome: Outcome,
    label: String,
    command: String,
    took: Duration,
}

/// Finds the physical effect that the campaign's model, or that of the options, lacks.
///
/// Where a joint under a force goes astray in open loop and nothing explains that, its runs are cut into pieces that each begin
/// at the measured state, and it is diagnosed again; where the refitted model misses by more than the joint moves they are cut
/// before anything is searched. The first reason of its confidence says so.
///
/// A campaign of a bench takes seconds to minutes, one of a leg minutes; [`Options::on_progress`] tells what is tried,
/// [`Options::search_at_most`] and [`Stop::end_search`](crate::Stop::end_search) end its search with what was found until then, and
/// [`Options::stop`] ends all of it.
///
/// ```no_run
/// use sealegs::{Campaign, Options, diagnose};
///
/// let campaign = Campaign::read("knee-bench".as_ref())?;
/// let verdict = diagnose(&campaign, Options::new().own_effect("belt-drag.toml"))?;
/// println!("{}", verdict.sentence());
/// for effect in &verdict.outcome().effects {
///     println!("missing: {effect}");
/// }
/// std::fs::write("diagnose.html", verdict.to_html()?).expect("a place for the report");
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// Bad input in the model's or an effect's file, a campaign without fit or holdout runs, a model that cannot be
/// simulated, a log that is not what its header says ([`Error::WrongLog`](crate::Error::WrongLog), unless
/// [`Options::force`]), [`Error::Stopped`](crate::Error::Stopped).
pub fn diagnose(campaign: &Campaign, options: impl Into<Options>) -> Result<Diagnosis> {
    let (started, options) = (Instant::now(), options.into());
    let until = options.search_at_most.map(|most| started + most);
    let whole = Ready::of(campaign.clone(), &options)?;
    let diverges = whole.diverges(&options)?;
    let in_time = match &diverges {
        Some(astray) => in_pieces(campaign, astray, &options, until)?,
        None => None,
    };
    let mut diagnosis = match in_time {
        Some(diagnosis) => diagnosis,
        None => whole.diagnosed(&options, until)?,
    };
    let again = diverges.is_none() && !diagnosis.outcome.work.ended_early;
    if let Some(astray) = diagnosis.hidden_by_drift().filter(|_| again) {
        diagnosis = in_pieces(campaign, &astray, &options, until)?.unwrap_or(diagnosis);
    }
    Ok(Diagnosis { took: started.elapsed(), ..diagnosis })
}

/// The diagnosis of a campaign's runs in pieces. None where they say no more than whole runs, or cannot be simulated: that takes
/// nothing from a verdict on whole runs.
fn in_pieces(
    campaign: &Campaign,
    astray: &Astray,
    options: &Options,
    until: Option<Instant>,
) -> Result<Option<Diagnosis>> {
    options.tell(&format!("diagnosing in pieces of {:.1} s", astray.piece_s));
    match Ready::of(campaign.cut_into(astray.piece_s), options)
        .and_then(|ready| ready.diagnosed(options, until))
    {
        Ok(mut found) if found.found.verdict.kind != VerdictKind::Unexplained => {
            found.outcome.confidence.reasons.insert(0, astray.cut());
            Ok(Some(found))
        }
        Err(Error::Stopped) => Err(Error::Stopped),
        Ok(_) | Err(_) => Ok(None),
    }
}

/// A campaign with its model, and what is wrong with its log.
struct Ready {
    campaign: Campaign,
    model: Box<dyn CampaignModel>,
    /// The model with values for each unit.
    per_unit: Box<dyn Model>,
    wrong: Vec<sanity::Finding>,
}

impl Ready {
    /// Refuses a campaign that cannot be diagnosed.
    fn of(mut campaign: Campaign, options: &Options) -> Result<Self> {
        let model = campaign_model::of_source(&mut campaign, &options.model, &options.own_effects)?;
        campaign.require(Role::Fit)?;
        campaign.require(Role::Holdout)?;
        let per_unit = units::per_unit(&campaign, model.as_ref())?;
        let wrong = sanity::look(&campaign, &Stoppable::new(per_unit.as_ref(), options));
        crate::sanity::gate(&campaign.file, &wrong, options.force)?;
        Ok(Self { campaign, model, per_unit, wrong })
    }

    /// How far the refitted model goes astray, where it misses by more than a joint moves.
    fn diverges(&self, options: &Options) -> Result<Option<Astray>> {
        let stoppable = Stoppable::new(self.model.as_ref(), options);
        unless_stopped(options, Ok::<_, Error>(Astray::after_a_fit(&self.campaign, &stoppable)))
    }

    /// The diagnosis, whose search ends at a time at the latest.
    fn diagnosed(self, options: &Options, until: Option<Instant>) -> Result<Diagnosis> {
        let Self { mut campaign, model, per_unit, wrong } = self;
        let end = SearchEnd::new(options, until);
        let stoppable = Stoppable::searched(per_unit.as_ref(), options, &end);
        let searching = Searching::of(options, &end);
        let found = diagnose::diagnose(&campaign, &stoppable, &|doing, spent| searching.tell(&doing, spent));
        let found = unless_stopped(options, found)?;
        options.tell("planning the next experiment");
        let limits = model.limits(&campaign);
        let experiment =
            limits.map_or(Ok(None), |limits| diagnose::next_experiment(&campaign, &found, limits));
        let experiment = unless_stopped(options, experiment)?;
        let provenance = Provenance::of_campaign(&campaign, model.name(), &options.files())?;
        let kind = found.verdict.kind;
        let next = match &experiment {
            Some(e) => e.sentence.clone(),
            None if kind == VerdictKind::Unexplained => {
                "No effect is named, so there is nothing for an experiment to tell apart.".to_owned()
            }
            None if limits.is_none() => plan::moved_otherwise(&found.verdict),
            None => "There is nothing to tell apart, so no experiment is proposed.".to_owned(),
        };
        if matches!(kind, VerdictKind::Unexplained | VerdictKind::PartlyExplained) {
            let channels =
                campaign.runs.iter().flat_map(|run| &run.record.outputs).map(|s| s.channel.as_str());
            let notes = not_tried(model.as_ref(), &channels.collect::<Vec<_>>());
            campaign.notes.extend(notes);
        }
        let outcome = Outcome::new(&campaign, &found, (next, end.has_cut()), wrong, provenance);
        let (label, command) = (options.model.label(&campaign), options.command_of("sealegs::diagnose"));
        let took = Duration::ZERO;
        Ok(Diagnosis { campaign, model: model.into(), found, experiment, outcome, label, command, took })
    }
}

/// What the catalogue does not offer a model, of what is common at joints: whoever reads that no effect explains the runs must
/// not take it for excluded.
fn not_tried(model: &dyn Model, measured: &[&str]) -> Vec<String> {
    let cards = model.effects(&Excitation::default());
    let offers = |family: &str| cards.iter().any(|c| c.id.rsplit('/').next() == Some(family));
    let parted = "play and compliance between motor and joint were not tried: the bench states no load apart from what the drive \
                  moves itself";
    let mounted = "a mounting that yields (base-motion) was not tried: only benches of one drive with a series spring have it";
    let at_joints = "encoders are taken to show the joints: one on the motor's side of a gear is motor_angle_rad (of a robot's joint \
                     JOINT.motor_angle_rad), times the ratio where it is logged at the output; play behind it shows in no other way";
    let shows = |ending: &str| measured.iter().any(|channel| channel.ends_with(ending));
    let notes = [
        (offers("backlash") && shows("angle_rad") && !shows("motor_angle_rad")).then_some(at_joints),
        (!offers("backlash") && !offers("series-compliance")).then_some(parted),
        (!offers("base-motion")).then_some(mounted),
    ];
    notes.into_iter().flatten().map(str::to_owned).collect()
}

impl Diagnosis {
    /// How far a joint under a force goes astray in open loop, where nothing is named for that, or what is named misses by more than
    /// the joint moves: an arm that stands upright falls with the true model, too, and says nothing of what is missing. Not where
    /// its runs are short already.
    fn hidden_by_drift(&self) -> Option<Astray> {
        let astray = self.outcome.astray(&self.campaign).filter(Astray::is_worth_cutting)?;
        let hidden = match self.found.verdict.kind {
            VerdictKind::Unexplained => true,
            VerdictKind::PartlyExplained => astray.share > 1.0,
            VerdictKind::Adequate | VerdictKind::MissingEffect => false,
        };
        hidden.then_some(astray)
    }

    /// The result in numbers; what [`Diagnosis::to_json`] writes.
    #[must_use]
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// The verdict in one sentence with its numbers.
    #[must_use]
    pub fn sentence(&self) -> &str {
        &self.outcome.sentence
    }

    /// Every candidate that was fitted, and how the verdict follows.
    #[must_use]
    pub fn found(&self) -> &diagnose::Diagnosis {
        &self.found
    }

    /// The campaign, with what the model's file says of its sensors and with remarks.
    #[must_use]
    pub fn campaign(&self) -> &Campaign {
        &self.campaign
    }

    /// The model that was started from.
    #[must_use]
    pub fn model(&self) -> &dyn CampaignModel {
        self.model.as_ref()
    }

    /// The experiment that would tell more, where one is proposed.
    #[must_use]
    pub fn experiment(&self) -> Option<&Experiment> {
        self.experiment.as_ref()
    }

    /// The next experiment as the text of a file that can be played, which will lie in `folder`: CSV of an input, or a
    /// leg's scenario. None where none is proposed.
    ///
    /// # Errors
    ///
    /// If the scenario cannot be written.
    pub fn plan(&self, folder: &Path) -> Result<Option<String>> {
        self.experiment.as_ref().map_or(Ok(None), |experiment| self.model.plan(experiment, folder))
    }

    /// The model with the effects that are named, at the values of the verdict: what [`add`](crate::add) gives, without another
    /// fit. None where nothing is named.
    #[must_use]
    pub fn better(&self) -> Option<Addition> {
        let added = Added::of_verdict(&self.found)?;
        let said = (self.label.clone(), self.command.clone());
        let (campaign, model) = (self.campaign.clone(), self.model.clone());
        Some(Addition::new(campaign, model, added, said, self.outcome.provenance.clone()))
    }

    /// The file of the law beyond the catalogue, an effect that `add` takes. None where there is none that helps.
    ///
    /// # Errors
    ///
    /// None for what a diagnosis holds.
    pub fn law_file(&self) -> Result<Option<String>> {
        self.outcome.law.as_ref().map(|law| law.file(&self.outcome.campaign)).transpose()
    }

    /// The numbers as JSON, indented, with the keys of the data contract.
    ///
    /// # Errors
    ///
    /// None for what a diagnosis holds.
    pub fn to_json(&self) -> Result<String> {
        crate::json(&self.outcome)
    }

    /// Everything for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        text::of(&self.outcome, self.took)
    }

    /// The report as one HTML file without anything outside it.
    ///
    /// # Errors
    ///
    /// None for the campaign that was diagnosed.
    pub fn to_html(&self) -> Result<String> {
        Ok(page(&self.story()?))
    }

    /// Measured, before, after and residuals of every run and channel.
    ///
    /// # Errors
    ///
    /// None for the campaign that was diagnosed.
    pub fn recording(&self) -> Result<recording::Comparison> {
        let o = &self.outcome;
        let said = format!("{}\n\n{}\n\n{}", o.sentence, o.remainder.join(" "), o.next_experiment);
        Ok(comparison::recording(&self.story()?.compared, said, |part| &part.before))
    }

    fn story(&self) -> Result<Story<'_>> {
        let sides = Sides::of(&self.found);
        let command = self.command.clone();
        Ok(Story::new(&self.campaign, &self.outcome, &sides, self.experiment.as_ref(), command)?)
    }
}

#[cfg(test)]
mod tests {
    use super::not_tried;
    use sealegs_actuator::ActuatorSpec;
    use sealegs_actuator::bench::{Bench, BenchModel};

    #[test]
    fn a_drive_that_does_not_part_from_its_load_says_that_play_and_compliance_were_not_tried() {
        let model = |preset, bench| {
            BenchModel::new(ActuatorSpec::preset(preset).expect("a preset"), bench).expect("a model")
        };
        let bare = not_tried(&model("rigid-rotary", Bench::Free { load: 0.0 }), &["joint_angle_rad"]);
        assert!(
            bare.len() == 2 && bare[0].contains("no load") && bare[1].contains("base-motion"),
            "{bare:?}"
        );
        let loaded =
            |measured: &str| not_tried(&model("rigid-rotary", Bench::Free { load: 0.1 }), &[measured]);
        let behind = loaded("joint_angle_rad");
        assert!(behind.len() == 2 && behind[0].contains("JOINT.motor_angle_rad"), "{behind:?}");
        let before = loaded("motor_angle_rad");
        assert!(before.len() == 1 && before[0].contains("base-motion"), "{before:?}");
        assert!(not_tried(&model("thor-linear", Bench::Locked), &["motor_angle_rad"]).is_empty());
    }
}
