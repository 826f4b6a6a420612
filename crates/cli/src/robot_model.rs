//! The model of a campaign that was recorded on a robot with torque drives: its URDF and drives, or its own model file.

use crate::campaign_model::{CampaignModel, note_down, notes_of, was_fitted_here};
use crate::diagnosis::addition::Added;
use crate::diagnosis::plan;
use crate::failure::{OrBadInput, bad_input};
use sealegs_actuator::effect::Effect;
use sealegs_actuator::spec::SensorSpec;
use sealegs_leg::bench::{RobotFile, RobotModel};
use sealegs_model::Model;
use sealegs_sysid::Campaign;
use sealegs_sysid::diagnose::{Experiment, Limits};
use std::path::Path;
use std::sync::Arc;

/// The robot of a campaign, or of the model file `model`, with the user's own effects beside the catalogue's.
///
/// What the drives' files and the robot's file say of sensors becomes part of the campaign.
///
/// # Errors
///
/// Bad input: a URDF or actuator file with an error in it, a drive with a spring, an input column that commands no joint.
pub fn of_campaign(
    campaign: &mut Campaign,
    model: Option<&Path>,
    own: &[Arc<dyn Effect>],
) -> anyhow::Result<RobotModel> {
    let stated = campaign.robot.clone().unwrap_or_default();
    let is_model_file = |name: &str| name.ends_with(".toml");
    let file = match model {
        Some(path) => RobotFile::load(path).or_bad_input()?,
        None if is_model_file(&stated) => RobotFile::load(&campaign.folder().join(&stated))
            .map_err(|e| campaign.bad_model(e.to_string()))
            .or_bad_input()?,
        None if campaign.actuator.is_empty() => {
            let problem = format!("'{stated}' is a URDF: 'actuator' must name the drive of its joints");
            return Err(campaign.bad_model(problem)).or_bad_input();
        }
        None => RobotFile::of_urdf(&stated, &campaign.actuator, campaign.folder()),
    };
    let file = match was_fitted_here(&file.provenance, model, campaign)? {
        true => file.without_fitted_std(),
        false => file,
    };
    let records: Vec<_> = campaign.runs.iter().map(|run| run.record.clone()).collect();
    let named = model.unwrap_or(&campaign.file).display().to_string();
    let model = RobotModel::new(file, own).map_err(|e| bad_input(format!("{named}: {e}")))?;
    for run in &campaign.runs {
        for input in &run.record.inputs {
            if let Some(reason) = model.refuses_input(&input.channel) {
                let file = run.path.display();
                return Err(bad_input(format!("{file}, line 1, column '{}': {reason}", input.channel)));
            }
        }
    }
    for (channel, sensor) in model.sensors() {
        campaign.state_sensor(&channel, sensor.gain_std, sensor.bias_std);
    }
    Ok(model.with_starts(&records))
}

impl CampaignModel for RobotModel {
    fn sensor(&self, channel: &str) -> Option<SensorSpec> {
        self.sensors().get(channel).copied()
    }

    /// Joints have inputs of different sizes: what the runs showed is the limit.
    fn limits(&self, _campaign: &Campaign) -> Limits {
        Limits::default()
    }

    fn plan(&self, experiment: &Experiment, _folder: &Path) -> anyhow::Result<Option<String>> {
        Ok(plan::csv(experiment))
    }

    fn better(
        &self,
        added: &Added,
        campaign: &Campaign,
        provenance: &[(&str, String)],
        folder: &Path,
    ) -> anyhow::Result<String> {
        let fit = &added.after.fit;
        let mut with_them = self.clone();
        for effect in &added.effects {
            with_them = with_them.including(effect, &added.seen)?;
        }
        let stds: Vec<f64> = fit.parameters.iter().map(|p| p.std).collect();
        let mut file = with_them.fitted_file(&fit.values, &stds);
        for sensor in fit.sensors() {
            let said = file.sensors.entry(sensor.channel.clone()).or_default();
            said.gain = Some(sensor.gain);
            said.bias = Some(sensor.bias);
            said.bias_spread = Some(sensor.bias_spread).filter(|s| s.is_finite());
        }
        note_down(&mut file.provenance, notes_of(added, campaign, provenance));
        let text = file.to_toml_in(folder)?;
        // Whoever gets the file must be able to load it.
        let again = RobotFile::parse(&text, "the model file to be written", folder)?;
        let again = RobotModel::new(again, &[])?;
        anyhow::ensure!(again.included() == with_them.included(), "the model file would lose an effect");
        Ok(text)
    }
}
