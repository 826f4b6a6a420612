//! The model of a campaign, whatever it was recorded on, and what commands ask of it beside predictions.

use crate::diagnosis::addition::Fitted;
use crate::diagnosis::provenance::{Input, Provenance};
use crate::{Error, ModelSource, Result, bench_model, leg_model, robot_model};
use sealegs_actuator::effect::{Effect, OwnEffect};
use sealegs_actuator::spec::SensorSpec;
use sealegs_model::{Model, Record};
use sealegs_sysid::diagnose::{Experiment, Limits};
use sealegs_sysid::{Campaign, campaign};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A model that came from a file and can be written to one.
pub trait CampaignModel: Model {
    /// What the file says of a channel's sensor.
    fn sensor(&self, channel: &str) -> Option<SensorSpec>;

    /// What the rig bears, in the unit of the campaign's input; `None` where one input alone makes no run, as of a robot whose
    /// joints move together.
    fn limits(&self, campaign: &Campaign) -> Option<Limits>;

    /// The text of a file with which the experiment can be made: an input to play, or a scenario.
    ///
    /// # Errors
    ///
    /// If a scenario cannot be written.
    fn plan(&self, experiment: &Experiment, folder: &Path) -> Result<Option<String>>;

    /// The text of a model file with the effects and values that were added, which loads again; `folder` is where it
    /// will lie. Of a campaign of several units it is one unit's.
    ///
    /// # Errors
    ///
    /// If it would not load.
    fn better(
        &self,
        added: &Fitted,
        campaign: &Campaign,
        provenance: &[(&str, String)],
        folder: &Path,
    ) -> Result<String>;
}

/// The nominal model of a campaign's bench and actuator or of its scenario, or of the file `model` in its place.
///
/// What the model's file says of its sensors becomes part of the campaign.
///
/// # Errors
///
/// Bad input: an unknown actuator or scenario, a file with an error in it, a bench that needs another kind of
/// actuator, a run that the model cannot predict.
pub fn of_campaign(campaign: &mut Campaign, model: Option<&Path>) -> Result<Box<dyn CampaignModel>> {
    with_own_effects(campaign, model, &[])
}

/// As [`of_campaign`], with the user's own effects in these files beside the catalogue's.
///
/// # Errors
///
/// As [`of_campaign`], and for an effect file with an error in it.
pub fn with_own_effects(
    campaign: &mut Campaign,
    model: Option<&Path>,
    own: &[PathBuf],
) -> Result<Box<dyn CampaignModel>> {
    of_source(campaign, &ModelSource::from(model), own)
}

/// As [`with_own_effects`], of a model that may be no file.
///
/// # Errors
///
/// As [`with_own_effects`], and a model of another kind than the campaign's.
pub fn of_source(
    campaign: &mut Campaign,
    model: &ModelSource,
    own: &[PathBuf],
) -> Result<Box<dyn CampaignModel>> {
    let own = own
        .iter()
        .map(|path| Ok(Arc::new(OwnEffect::load(path)?) as Arc<dyn Effect>))
        .collect::<Result<Vec<_>>>()?;
    let model: Box<dyn CampaignModel> = match campaign.bench {
        campaign::Bench::Leg => Box::new(leg_model::of_source(campaign, model, own)?),
        campaign::Bench::Robot => Box::new(robot_model::of_source(campaign, model, &own)?),
        _ => Box::new(bench_model::of_source(campaign, model, own)?),
    };
    let seen: &dyn Model = model.as_ref();
    campaign.check_against(seen)?;
    Ok(model)
}

/// Refuses a run with an input column that commands nothing; `reason` says why, of a run's record and a channel.
///
/// # Errors
///
/// [`Error::RefusedInput`] for the first of them.
pub(crate) fn check_inputs(
    campaign: &Campaign,
    reason: impl Fn(&Record, &str) -> Option<String>,
) -> Result<()> {
    for run in &campaign.runs {
        for input in &run.record.inputs {
            if let Some(reason) = reason(&run.record, &input.channel) {
                let (file, channel) = (run.path.clone(), input.channel.clone());
                return Err(Error::RefusedInput { file, channel, reason });
            }
        }
    }
    Ok(())
}

/// Whether the model file with this provenance was fitted to one of the campaign's fit runs.
///
/// What such a fit knew of its values came from these very rows: taken for known beforehand it would count them twice,
/// and every interval would come out too narrow. A remark in the campaign says that it is not.
pub(crate) fn was_fitted_here(
    provenance: &BTreeMap<String, String>,
    model: &ModelSource,
    campaign: &mut Campaign,
) -> Result<bool> {
    let Some(inputs) = provenance.get(INPUTS) else { return Ok(false) };
    let runs = campaign.runs_of(campaign::Role::Fit).map(Input::of_run).collect::<Result<Vec<_>>>()?;
    let own = runs.iter().any(|run| inputs.contains(&run.sha256));
    if own {
        let label = model.label(campaign);
        campaign.notes.push(format!(
            "{label}: was fitted to runs of this campaign; its standard errors are not used as priors"
        ));
    }
    Ok(own)
}

/// The files that a model was fitted to, as a model file keeps them.
#[must_use]
pub fn inputs_of(provenance: &Provenance) -> (&'static str, String) {
    let hashes = provenance.inputs.iter().map(|i| format!("{} sha256:{}", i.file, i.sha256));
    (INPUTS, hashes.collect::<Vec<_>>().join("; "))
}

/// Keeps what a fit found of the sensors among what a model file says of them.
pub(crate) fn note_sensors(known: &mut BTreeMap<String, SensorSpec>, added: &Fitted) {
    for sensor in &added.sensors {
        let said = known.entry(sensor.channel.clone()).or_default();
        said.gain = Some(sensor.gain);
        said.bias = Some(sensor.bias);
        said.bias_spread = Some(sensor.bias_spread).filter(|s| s.is_finite());
    }
}

/// Puts notes into a model file's provenance. What it was fitted to before stays beside what it was fitted to now.
pub(crate) fn note_down(provenance: &mut BTreeMap<String, String>, notes: Vec<(String, String)>) {
    for (key, note) in notes {
        let note = match provenance.get(&key).filter(|_| key == INPUTS) {
            Some(earlier) if earlier.contains(&note) => earlier.clone(),
            Some(earlier) => format!("{earlier}; {note}"),
            None => note,
        };
        provenance.insert(key, note);
    }
}

/// The key of [`inputs_of`] in a model file's provenance.
const INPUTS: &str = "inputs";

/// The errors of a model without and with what was added, as a model file keeps them.
#[must_use]
pub(crate) fn notes_of(
    added: &Fitted,
    campaign: &Campaign,
    provenance: &[(&str, String)],
) -> Vec<(String, String)> {
    let errors = |before: f64, after: f64| format!("{before:.4} before, {after:.4} after, in noise units");
    let mut notes = vec![
        ("effects_added".to_owned(), added.effects.join(", ")),
        ("fitted_to".to_owned(), campaign.name.clone()),
        ("error_on_fit_runs".to_owned(), errors(added.fit_error.0, added.fit_error.1)),
    ];
    if let Some((before, after)) = added.holdout_error {
        notes.push(("error_on_holdout_runs".to_owned(), errors(before, after)));
    }
    notes.extend(added.unit.iter().map(|unit| ("unit".to_owned(), unit.clone())));
    notes.extend(provenance.iter().map(|(key, value)| ((*key).to_owned(), value.clone())));
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_model_was_fitted_to_first_is_not_forgotten() {
        let mut provenance = BTreeMap::new();
        let notes = |inputs: &str| {
            vec![("version".to_owned(), "1".to_owned()), (INPUTS.to_owned(), inputs.to_owned())]
        };
        for inputs in ["a.csv sha256:1", "b.csv sha256:2", "b.csv sha256:2"] {
            note_down(&mut provenance, notes(inputs));
        }
        assert_eq!(provenance[INPUTS], "a.csv sha256:1; b.csv sha256:2");
        assert_eq!(provenance["version"], "1");
    }
}
