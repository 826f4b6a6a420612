//! The model of a campaign that was recorded on a bench: its actuator, or another actuator file, on that bench.

use crate::campaign_model::{CampaignModel, note_down, note_sensors, notes_of, was_fitted_here};
use crate::diagnosis::addition::Fitted;
use crate::diagnosis::plan;
use crate::{Error, ModelSource, Result};
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig, RunSetup};
use sealegs_actuator::effect::Effect;
use sealegs_actuator::spec::SensorSpec;
use sealegs_actuator::{ActuatorSpec, Kind};
use sealegs_sysid::campaign::RigValues;
use sealegs_sysid::diagnose::{Experiment, Limits};
use sealegs_sysid::{Campaign, campaign};
use std::path::Path;
use std::sync::Arc;

/// The nominal model of a campaign's bench and actuator, or of the actuator file `model` on that bench, with the
/// user's own effects beside the catalogue's.
///
/// What the actuator's file says of its sensors becomes part of the campaign.
///
/// # Errors
///
/// Bad input: an unknown actuator, a file with an error in it, a bench that needs another kind of actuator.
pub fn of_campaign(
    campaign: &mut Campaign,
    model: Option<&Path>,
    own: Vec<Arc<dyn Effect>>,
) -> Result<BenchModel> {
    of_source(campaign, &ModelSource::from(model), own)
}

/// As [`of_campaign`], of an actuator that may be no file.
///
/// # Errors
///
/// As [`of_campaign`], and a scenario in place of an actuator.
pub fn of_source(
    campaign: &mut Campaign,
    model: &ModelSource,
    own: Vec<Arc<dyn Effect>>,
) -> Result<BenchModel> {
    let spec = match model {
        ModelSource::File(path) => ActuatorSpec::load(&path.to_string_lossy(), None)?,
        ModelSource::Actuator(spec) => (**spec).clone(),
        ModelSource::Scenario(_) => {
            return Err(Error::WrongModel {
                model: model.label(campaign),
                bench: campaign.bench.as_str(),
                needed: "an actuator",
            });
        }
        ModelSource::Campaign => ActuatorSpec::load(&campaign.actuator, Some(campaign.folder()))
            .map_err(|e| campaign.bad_model(e.to_string()))?,
    };
    let spec = match was_fitted_here(&spec.provenance, model, campaign)? {
        true => spec.without_fitted_std(),
        false => spec,
    };
    let runs = runs_of(campaign, &spec)?;
    let bench = runs.first().map_or(Bench::Locked, |run| run.bench);
    for (channel, sensor) in &spec.sensors {
        campaign.state_sensor(channel, sensor.gain_std, sensor.bias_std);
    }
    let file = match model {
        ModelSource::Campaign => campaign.file.clone(),
        other => other.label(campaign).into(),
    };
    BenchModel::with_own_effects(spec, bench, own)
        .and_then(|model| model.with_runs(runs))
        .map_err(|e| Error::ModelFile { file, source: Box::new(e) })
}

/// Every run's own rig and start.
fn runs_of(campaign: &Campaign, spec: &ActuatorSpec) -> Result<Vec<RunSetup>> {
    let mut runs: Vec<RunSetup> = Vec::new();
    for run in &campaign.runs {
        if runs.iter().any(|known| known.record == run.record.name) {
            continue;
        }
        let bench = bench_of(campaign.bench, &run.rig, spec)
            .map_err(|wrong| campaign.bad_key(wrong.key, wrong.problem))?;
        let gain = run.rig.servo_gain.unwrap_or(1.0);
        runs.push(RunSetup::of_record(&run.record, spec, bench, gain));
    }
    Ok(runs)
}

/// A number of a rig that is missing, or that the actuator cannot use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrongRig {
    /// Its key in a campaign file.
    pub key: &'static str,
    /// What is wrong, to be read after the key.
    pub problem: String,
}

/// The bench of a campaign with a run's masses and lengths, for this actuator.
///
/// # Errors
///
/// [`WrongRig`] if a number is missing, or is one of the other kind of actuator.
pub fn bench_of(
    bench: campaign::Bench,
    rig: &RigValues,
    spec: &ActuatorSpec,
) -> std::result::Result<Bench, WrongRig> {
    let missing = |key, why: &str| WrongRig { key, problem: format!("is missing: {why}") };
    Ok(match bench {
        campaign::Bench::Pendulum => {
            let usual = PendulumRig::default();
            let own = rig.length_m.is_some() || rig.mass_kg.is_some() || rig.rod_mass_kg.is_some();
            // A rotary drive turns the pendulum itself; a linear one pushes its lever.
            let turns = spec.kind == Kind::Rotary;
            if turns && rig.length_m.is_none() {
                return Err(missing(
                    "length_m",
                    "a drive that turns a pendulum directly needs its rig's numbers",
                ));
            }
            Bench::Pendulum(PendulumRig {
                arm_m: rig.arm_m.unwrap_or(if turns { 1.0 } else { usual.arm_m }),
                length_m: rig.length_m.unwrap_or(usual.length_m),
                mass_kg: rig.mass_kg.unwrap_or(if own { 0.0 } else { usual.mass_kg }),
                rod_mass_kg: rig.rod_mass_kg.unwrap_or(0.0),
            })
        }
        campaign::Bench::Free => {
            let (load, key, other) = match spec.kind {
                Kind::Linear => (rig.mass_kg, "mass_kg", rig.inertia_kg_m2.map(|_| "inertia_kg_m2")),
                Kind::Rotary => (rig.inertia_kg_m2, "inertia_kg_m2", rig.mass_kg.map(|_| "mass_kg")),
            };
            if let Some(other) = other {
                let problem = format!("is given; the actuator takes '{key}'");
                return Err(WrongRig { key: other, problem });
            }
            if load.is_none() && !spec.is_rigid() {
                return Err(missing(key, "behind a spring the output must have a mass"));
            }
            Bench::Free { load: load.unwrap_or(0.0) }
        }
        _ => Bench::Locked,
    })
}

impl CampaignModel for BenchModel {
    fn sensor(&self, channel: &str) -> Option<SensorSpec> {
        self.spec().sensors.get(channel).copied()
    }

    fn limits(&self, campaign: &Campaign) -> Option<Limits> {
        Some(plan::limits(self.spec(), campaign))
    }

    fn plan(&self, experiment: &Experiment, _folder: &Path) -> Result<Option<String>> {
        Ok(plan::csv(experiment))
    }

    fn better(
        &self,
        added: &Fitted,
        campaign: &Campaign,
        provenance: &[(&str, String)],
        _folder: &Path,
    ) -> Result<String> {
        let mut spec = self.spec().clone();
        for (p, known) in added.parameters.iter().zip(&added.stated) {
            if p.name.contains('.') {
                continue;
            }
            let discrete = p.fixed && !known.starts.is_empty();
            if (p.fixed && !discrete) || (discrete && p.value == p.nominal) {
                continue;
            }
            let said = spec.parameters.entry(p.name.clone()).or_default();
            said.value = Some(p.value);
            if !discrete {
                said.std = Some(p.std).filter(|s| *s > 0.0 && s.is_finite());
                if p.name != "clock_skew" {
                    said.min = Some(known.min.min(p.value));
                    said.max = Some(known.max.max(p.value));
                }
            }
        }
        let with_them = added.included_in(self, Self::including)?;
        spec.effects = with_them.effect_specs(&added.values(), &added.stds());
        note_sensors(&mut spec.sensors, added);
        note_down(&mut spec.provenance, notes_of(added, campaign, provenance));
        // Whoever gets the file must be able to load it.
        let text = spec.to_toml();
        ActuatorSpec::from_toml(&text, "the model file to be written").map_err(Error::model_file)?;
        Ok(text)
    }
}
