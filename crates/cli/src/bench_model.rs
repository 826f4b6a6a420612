//! The model of a campaign: its bench with its actuator, or with another actuator file.

use crate::failure::{OrBadInput, bad_input};
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs_actuator::effect::{Effect, OwnEffect};
use sealegs_model::Model;
use sealegs_sysid::{Campaign, campaign};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The nominal model of a campaign's bench and actuator, or of the actuator file `model` on that bench.
///
/// What the actuator's file says of its sensors becomes part of the campaign.
///
/// # Errors
///
/// Bad input: an unknown actuator, a file with an error in it, a bench that needs another kind of actuator.
pub fn of_campaign(campaign: &mut Campaign, model: Option<&Path>) -> anyhow::Result<BenchModel> {
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
) -> anyhow::Result<BenchModel> {
    let bench = match campaign.bench {
        campaign::Bench::Locked => Bench::Locked,
        campaign::Bench::Pendulum => Bench::Pendulum(PendulumRig::default()),
        _ => {
            return Err(bad_input(format!(
                "{}: bench \"{}\" is not one that this command can model yet",
                campaign.file.display(),
                campaign.bench.as_str()
            )));
        }
    };
    let spec = match model {
        Some(path) => ActuatorSpec::load(&path.to_string_lossy(), None).or_bad_input()?,
        None => ActuatorSpec::load(&campaign.actuator, Some(campaign.folder()))
            .map_err(|e| bad_input(format!("{}: actuator: {e}", campaign.file.display())))?,
    };
    for (channel, sensor) in &spec.sensors {
        campaign.state_sensor(channel, sensor.gain_std, sensor.bias_std);
    }
    let own = own
        .iter()
        .map(|path| OwnEffect::load(path).map(|effect| Arc::new(effect) as Arc<dyn Effect>).or_bad_input())
        .collect::<anyhow::Result<Vec<_>>>()?;
    let file = model.unwrap_or(&campaign.file).display().to_string();
    let model =
        BenchModel::with_own_effects(spec, bench, own).map_err(|e| bad_input(format!("{file}: {e}")))?;
    campaign.check_against(&model as &dyn Model).or_bad_input()?;
    Ok(model)
}
