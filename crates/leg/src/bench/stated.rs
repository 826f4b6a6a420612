//! What a robot's file states of its parameters and effects, put into the model.

use super::joint::Joint;
use super::{RobotFile, RobotModel};
use crate::LegError;
use crate::error::meant;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::effect::{Effect, OwnEffect};
use sealegs_actuator::spec::EffectSpec;
use sealegs_model::{Excitation, SignalRange};
use std::sync::Arc;

impl RobotModel {
    /// Puts the values and effects of the file into the model.
    pub(super) fn take_stated(&mut self) -> Result<(), LegError> {
        let file = self.file.clone();
        let bad = |field: String, problem: String| LegError::scenario(&file.robot, &field, problem);
        for (name, given) in &file.parameters {
            let Some(p) = self.parameters.iter_mut().find(|p| p.name == *name) else {
                let hint = meant(name, self.parameters.iter().map(|p| p.name.as_str()));
                return Err(bad(format!("parameters.{name}"), format!("no such parameter{hint}")));
            };
            if !given.value.is_finite() {
                return Err(bad(format!("parameters.{name}"), format!("is {}; must be finite", given.value)));
            }
            p.value = given.value;
            p.prior_std = given.std.filter(|s| *s > 0.0).or(p.prior_std);
            (p.min, p.max) = (p.min.min(given.value), p.max.max(given.value));
        }
        // What a command counts in names some parameters: a limit is one of the joints' efforts, or a current as in the catalogue.
        let command = |joint: &Joint| SignalRange { name: joint.command(), min: -1.0, max: 1.0, rms: 1.0 };
        let commanded =
            Excitation { ranges: self.joints.iter().map(command).collect(), ..Excitation::default() };
        for effect in &file.effects {
            let before = self.parameters.len();
            let including = |seen| {
                let with = self.including(&effect.id, seen);
                with.map_err(|e| bad(format!("effect.{}", effect.id), e.to_string()))
            };
            let has = |model: &Self, name| {
                let full = format!("{}.{name}", effect.id);
                model.parameters[before..].iter().any(|p| p.name == full)
            };
            let mut with = including(&commanded)?;
            if !effect.parameters.keys().all(|name| has(&with, name)) {
                with = including(&Excitation::default())?;
            }
            *self = with;
            effect.state_all(&mut self.parameters[before..]).map_err(|(name, all)| {
                let problem = format!("no parameter of this effect, which has {all}");
                bad(format!("effect.{}.{name}", effect.id), problem)
            })?;
        }
        Ok(())
    }
}

/// A robot's file with the effects of its joints' drives, which are taken from these: at their joints and before its own, which go
/// before one of the same id.
pub(super) fn with_drives_effects(
    mut file: RobotFile,
    drives: &mut [ActuatorSpec],
    joints: &[String],
) -> RobotFile {
    let mut of_drives = Vec::new();
    for (drive, joint) in drives.iter_mut().zip(joints) {
        let effects = std::mem::take(&mut drive.effects).into_iter();
        let placed = effects.map(|e| EffectSpec { id: format!("{joint}/{}", e.id), ..e });
        of_drives.extend(placed.filter(|e| file.effects.iter().all(|own| own.id != e.id)));
    }
    file.effects.splice(0..0, of_drives);
    file
}

/// The own effects that a file's effects define, beside those `given`, each id once.
pub(super) fn with_embedded(
    file: &RobotFile,
    given: &[Arc<dyn Effect>],
) -> Result<Vec<Arc<dyn Effect>>, LegError> {
    let mut own = given.to_vec();
    let mut known: Vec<&toml::Value> =
        given.iter().filter_map(|e| e.definition().and_then(|d| d.get("id"))).collect();
    for effect in &file.effects {
        let Some(definition) = &effect.definition else { continue };
        let id = definition.get("id");
        if id.is_none_or(|id| !known.contains(&id)) {
            let origin = format!("effect.{}.definition", effect.id);
            own.push(Arc::new(OwnEffect::from_definition(definition, &origin)?));
            known.extend(id);
        }
    }
    Ok(own)
}
