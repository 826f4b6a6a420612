//! The model of a campaign that was recorded on a robot: its URDF and drives, or its own model file.

use crate::campaign_model::{
    CampaignModel, check_inputs, note_down, note_sensors, notes_of, was_fitted_here,
};
use crate::diagnosis::addition::Fitted;
use crate::diagnosis::plan;
use crate::{Error, ModelSource, Result, robot_columns};
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::effect::Effect;
use sealegs_actuator::spec::SensorSpec;
use sealegs_leg::bench::{RobotFile, RobotModel};
use sealegs_model::Model;
use sealegs_sysid::Campaign;
use sealegs_sysid::campaign::Run;
use sealegs_sysid::diagnose::{Experiment, Limits};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a campaign on a robot takes as a model.
const NEEDED: &str = "a model file with `robot = \"ROBOT.urdf\"` and `actuator = \"DRIVE.toml\"`, or a URDF whose drives are \
                      the campaign's; without any it takes its own";

/// The robot of a campaign, or of the model file `model`, with the user's own effects beside the catalogue's.
///
/// What the drives' files and the robot's file say of sensors becomes part of the campaign.
///
/// # Errors
///
/// Bad input: a URDF or actuator file with an error in it, a drive with a spring, an input column that commands no joint.
pub fn of_source(
    campaign: &mut Campaign,
    model: &ModelSource,
    own: &[Arc<dyn Effect>],
) -> Result<RobotModel> {
    let stated = campaign.robot.clone().unwrap_or_default();
    let is_model_file = |name: &str| name.ends_with(".toml");
    let without_drive = |urdf: &str| {
        campaign.bad_model(format!("'{urdf}' is a URDF: 'actuator' must name the drive of its joints"))
    };
    let wrong = |campaign: &Campaign| Error::WrongModel {
        model: model.label(campaign),
        bench: campaign.bench.as_str(),
        needed: NEEDED,
    };
    let file = match model {
        // A URDF alone has the drives that the campaign names.
        ModelSource::File(path) if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("urdf")) => {
            let urdf = path.canonicalize().unwrap_or_else(|_| path.clone()).display().to_string();
            if campaign.actuator.is_empty() {
                return Err(without_drive(&urdf).into());
            }
            RobotFile::of_urdf(&urdf, &campaign.actuator, campaign.folder())
        }
        ModelSource::File(path) => {
            let is_drive = || ActuatorSpec::load(&path.display().to_string(), None).is_ok();
            match RobotFile::load(path) {
                // A drive alone says nothing of the links that it moves.
                Err(_) if is_drive() => return Err(wrong(campaign)),
                loaded => loaded?,
            }
        }
        ModelSource::Actuator(_) | ModelSource::Scenario(_) => {
            return Err(wrong(campaign));
        }
        ModelSource::Campaign if is_model_file(&stated) => {
            let path = campaign.folder().join(&stated);
            let is_drive = || ActuatorSpec::load(&path.display().to_string(), None).is_ok();
            match RobotFile::load(&path) {
                Err(_) if is_drive() => {
                    let problem = format!(
                        "'{stated}' is a drive's file: it says nothing of the links. 'robot' names the URDF, with \
                         actuator = \"{stated}\" beside it; or a robot's file with `robot = \"ROBOT.urdf\"`, \
                         `actuator = \"{stated}\"` and other drives under [drive]"
                    );
                    return Err(campaign.bad_model(problem).into());
                }
                loaded => loaded.map_err(|e| campaign.bad_model(e.to_string()))?,
            }
        }
        ModelSource::Campaign if campaign.actuator.is_empty() => {
            return Err(without_drive(&stated).into());
        }
        ModelSource::Campaign => RobotFile::of_urdf(&stated, &campaign.actuator, campaign.folder()),
    };
    let file = robot_columns::completed(campaign, file);
    let file = match was_fitted_here(&file.provenance, model, campaign)? {
        true => file.without_fitted_std(),
        false => file,
    };
    let named: PathBuf = match model {
        ModelSource::Campaign => campaign.file.clone(),
        other => other.label(campaign).into(),
    };
    let model =
        RobotModel::new(file, own).map_err(|e| Error::RobotFile { file: named, source: Box::new(e) })?;
    robot_columns::check(campaign, model.robot())?;
    compensate_gravity(campaign, &model)?;
    check_inputs(campaign, |record, channel| model.refuses_input(record, channel))?;
    for (channel, sensor) in model.sensors() {
        campaign.state_sensor(&channel, sensor.gain_std, sensor.bias_std);
    }
    let records: Vec<_> = campaign.runs.iter().map(|run| &run.record).collect();
    let servos = model.servos();
    for joint in campaign.runs.iter().flat_map(|run| run.rig.servo_gains.keys()) {
        if !servos.contains(joint) {
            let known = if servos.is_empty() { "none".to_owned() } else { servos.join(", ") };
            let problem = format!("servo_gain: '{joint}' is no joint with a servo (known: {known})");
            return Err(campaign.bad_model(problem).into());
        }
    }
    let of_run = |run: &Run| servos.iter().map(|j| (j.clone(), run.rig.servo_gain_of(j))).collect();
    let gains = campaign.runs.iter().map(|run| (run.record.name.clone(), of_run(run))).collect();
    Ok(model.with_servo_gains(gains).for_records(&records))
}

/// Adds to the commands what the robot's controller adds to them, if the campaign says so; once.
fn compensate_gravity(campaign: &mut Campaign, model: &RobotModel) -> Result<()> {
    if !std::mem::take(&mut campaign.gravity_compensated) {
        return Ok(());
    }
    let changed = campaign.runs.iter_mut().map(|run| model.compensate_gravity(&mut run.record));
    let joints = changed.collect::<std::result::Result<Vec<_>, _>>();
    let refused = |problem: String| campaign.bad_key("gravity_compensated", problem);
    let joints = joints.map_err(|missing| {
        refused(format!("a run has no column '{missing}', and gravity depends on where every joint is"))
    })?;
    let Some(most) = joints.into_iter().max().filter(|most| *most > 0) else {
        return Err(
            refused("no column commands a torque: there is nothing to add gravity to".to_owned()).into()
        );
    };
    let robot = &model.robot().name;
    campaign.notes.push(format!(
        "the commands of {most} joints have the torques added that hold {robot} against gravity at the measured positions"
    ));
    Ok(())
}

impl CampaignModel for RobotModel {
    fn sensor(&self, channel: &str) -> Option<SensorSpec> {
        self.sensors().get(channel).copied()
    }

    /// What the runs showed of the only input.
    fn limits(&self, campaign: &Campaign) -> Option<Limits> {
        let one = |run: &Run| run.record.inputs.len() == 1;
        campaign.runs.iter().all(one).then(Limits::default)
    }

    fn plan(&self, experiment: &Experiment, _folder: &Path) -> Result<Option<String>> {
        Ok(plan::csv(experiment))
    }

    fn better(
        &self,
        added: &Fitted,
        campaign: &Campaign,
        provenance: &[(&str, String)],
        folder: &Path,
    ) -> Result<String> {
        let with_them = added.included_in(self, Self::including)?;
        let mut file = with_them.fitted_file(&added.values(), &added.stds());
        note_sensors(&mut file.sensors, added);
        note_down(&mut file.provenance, notes_of(added, campaign, provenance));
        let text = file.to_toml_in(folder)?;
        // Whoever gets the file must be able to load it.
        let again =
            RobotFile::parse(&text, "the model file to be written", folder).map_err(Error::model_file)?;
        let again = RobotModel::new(again, &[]).map_err(Error::model_file)?;
        if again.included() != with_them.included() {
            return Err(Error::model_file("it would lose an effect"));
        }
        Ok(text)
    }
}
