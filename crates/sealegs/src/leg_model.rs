//! The model of a campaign that was recorded on a leg: its scenario, or another scenario file, and its runs' own.

use crate::campaign_model::{
    CampaignModel, check_inputs, note_down, note_sensors, notes_of, was_fitted_here,
};
use crate::diagnosis::addition::Fitted;
use crate::diagnosis::plan;
use crate::{Error, ModelSource, Result};
use sealegs_actuator::effect::Effect;
use sealegs_actuator::spec::SensorSpec;
use sealegs_leg::model::LegModel;
use sealegs_leg::scenario::Scenario;
use sealegs_sysid::Campaign;
use sealegs_sysid::diagnose::{Experiment, Limits, Play};
use std::path::Path;
use std::sync::Arc;

/// The leg of a campaign's scenario, or of the scenario file `model`, with the user's own effects beside the
/// catalogues'. Runs with a scenario of their own keep it.
///
/// What the actuators' files and the scenario say of sensors becomes part of the campaign.
///
/// # Errors
///
/// Bad input: an unknown scenario, a file with an error in it, an input column that commands nothing.
pub fn of_campaign(
    campaign: &mut Campaign,
    model: Option<&Path>,
    own: Vec<Arc<dyn Effect>>,
) -> Result<LegModel> {
    of_source(campaign, &ModelSource::from(model), own)
}

/// As [`of_campaign`], of a scenario that may be no file.
///
/// # Errors
///
/// As [`of_campaign`], and an actuator in place of a scenario.
pub fn of_source(
    campaign: &mut Campaign,
    model: &ModelSource,
    own: Vec<Arc<dyn Effect>>,
) -> Result<LegModel> {
    let nominal = beside(campaign, campaign.scenario.as_deref().unwrap_or_default())
        .map_err(|e| campaign.bad_model(e.to_string()))?;
    let scenario = match model {
        ModelSource::File(path) => Scenario::load(&path.to_string_lossy(), &[])?,
        ModelSource::Scenario(scenario) => (**scenario).clone(),
        ModelSource::Actuator(_) => {
            return Err(Error::WrongModel {
                model: model.label(campaign),
                bench: campaign.bench.as_str(),
                needed: "a scenario",
            });
        }
        ModelSource::Campaign => nominal.clone(),
    };
    let scenario = match was_fitted_here(&scenario.provenance, model, campaign)? {
        true => scenario.without_fitted_std(),
        false => scenario,
    };
    let mut runs: Vec<(String, Scenario)> = Vec::new();
    for run in &campaign.runs {
        let Some(name) = run.scenario.as_deref() else { continue };
        let record = &run.record.name;
        if runs.iter().all(|(known, _)| known != record) {
            let scenario = beside(campaign, name).map_err(|e| Error::RunScenario {
                file: campaign.file.clone(),
                run: record.clone(),
                source: Box::new(e),
            })?;
            runs.push((record.clone(), scenario));
        }
    }
    let model = LegModel::new(scenario, &nominal, runs, own)?;
    check_inputs(campaign, |record, channel| model.refuses_input(&record.name, channel))?;
    for (channel, sensor) in model.sensors() {
        campaign.state_sensor(&channel, sensor.gain_std, sensor.bias_std);
    }
    Ok(model)
}

/// A scenario as a campaign names it: a file beside it, or a preset.
fn beside(campaign: &Campaign, name: &str) -> std::result::Result<Scenario, sealegs_leg::LegError> {
    let path = campaign.folder().join(name);
    if path.is_file() { Scenario::load(&path.to_string_lossy(), &[]) } else { Scenario::load(name, &[]) }
}

impl CampaignModel for LegModel {
    fn sensor(&self, channel: &str) -> Option<SensorSpec> {
        self.scenario().sensors.get(channel).copied()
    }

    /// A leg's experiments are scenarios: there is no input to limit.
    fn limits(&self, _campaign: &Campaign) -> Option<Limits> {
        Some(Limits::default())
    }

    fn plan(&self, experiment: &Experiment, folder: &Path) -> Result<Option<String>> {
        let Play::Run(name) = &experiment.play else { return Ok(plan::csv(experiment)) };
        let Some(planned) = self.planned(name) else { return Ok(None) };
        let mut scenario = planned.clone();
        scenario.move_to(folder)?;
        Ok(Some(toml::to_string_pretty(&scenario).map_err(Error::model_file)?))
    }

    fn better(
        &self,
        added: &Fitted,
        campaign: &Campaign,
        provenance: &[(&str, String)],
        folder: &Path,
    ) -> Result<String> {
        let with_them = added.included_in(self, Self::including)?;
        let mut scenario = with_them.fitted_scenario(&added.values(), &added.stds());
        note_sensors(&mut scenario.sensors, added);
        note_down(&mut scenario.provenance, notes_of(added, campaign, provenance));
        scenario.move_to(folder)?;
        // Whoever gets the file must be able to load it.
        let text = toml::to_string_pretty(&scenario).map_err(Error::model_file)?;
        Scenario::from_toml(&text, "the model file to be written", &[]).map_err(Error::model_file)?;
        Ok(text)
    }
}
