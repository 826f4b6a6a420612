//! A robot's model file: its URDF, the drives of its joints, fitted values and effects.

use crate::LegError;
use sealegs_actuator::spec::{EffectSpec, EffectValue, SensorSpec};
use sealegs_actuator::text::parse_toml;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A robot with its drives as its file describes it. What `sealegs add` writes has the same form.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotFile {
    /// The URDF, beside this file.
    pub robot: String,
    /// The drive of every joint that `drive` does not name: a preset or a file beside this one.
    pub actuator: String,
    /// Other drives, by joint.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub drive: BTreeMap<String, String>,
    /// Joints that stand still, and where, rad or m: a hand, wheels, a head.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub hold: BTreeMap<String, f64>,
    /// Measured or fitted values of base parameters by their names, `elbow/damping`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, EffectValue>,
    /// Effects at joints.
    #[serde(default, rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
    /// What is known of the sensors, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sensors: BTreeMap<String, SensorSpec>,
    /// Where the numbers came from; kept as it is.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub provenance: BTreeMap<String, String>,
    /// The folder that paths are seen from.
    #[serde(skip)]
    pub folder: PathBuf,
}

impl RobotFile {
    /// A URDF with one kind of drive on all joints, paths seen from `folder`.
    #[must_use]
    pub fn of_urdf(robot: &str, actuator: &str, folder: &Path) -> Self {
        Self {
            robot: robot.to_owned(),
            actuator: actuator.to_owned(),
            folder: folder.to_owned(),
            ..Self::default()
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    ///
    /// [`LegError::Io`]; [`LegError::Actuator`] for text that is no such file, with line and key.
    pub fn load(path: &Path) -> Result<Self, LegError> {
        let name = path.display().to_string();
        let text =
            std::fs::read_to_string(path).map_err(|source| LegError::Io { path: name.clone(), source })?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self::parse(&text, &name, folder)
    }

    /// As [`RobotFile::load`] of text; `name` is named in messages, paths are seen from `folder`.
    ///
    /// # Errors
    ///
    /// [`LegError::Actuator`] for text that is no such file, with line and key.
    pub fn parse(text: &str, name: &str, folder: &Path) -> Result<Self, LegError> {
        let file: Self = parse_toml(text, name)?;
        for (index, effect) in file.effects.iter().enumerate() {
            effect.validate(index)?;
        }
        Ok(Self { folder: folder.to_owned(), ..file })
    }

    /// The file as TOML that [`RobotFile::load`] reads back, its paths seen from another folder.
    ///
    /// # Errors
    ///
    /// [`LegError::Io`] if a path cannot be found.
    pub fn to_toml_in(&self, folder: &Path) -> Result<String, LegError> {
        let mut moved = self.clone();
        let files = [&mut moved.robot, &mut moved.actuator].into_iter().chain(moved.drive.values_mut());
        for file in files {
            let path = self.folder.join(&*file);
            if path.is_file() {
                *file = seen_from(&path, folder)?;
            }
        }
        toml::to_string_pretty(&moved).map_err(|e| LegError::scenario(&moved.robot, "file", e.to_string()))
    }

    /// The path of the URDF.
    #[must_use]
    pub fn urdf(&self) -> PathBuf {
        self.folder.join(&self.robot)
    }

    /// The drive of a joint, as [`sealegs_actuator::ActuatorSpec::load`] takes it.
    #[must_use]
    pub fn drive_of(&self, joint: &str) -> &str {
        self.drive.get(joint).unwrap_or(&self.actuator)
    }

    /// The same without what a fit knew of its values.
    #[must_use]
    pub fn without_fitted_std(&self) -> Self {
        let mut plain = self.clone();
        plain.parameters.values_mut().for_each(|given| given.std = None);
        plain.effects.iter_mut().flat_map(|e| e.parameters.values_mut()).for_each(|given| given.std = None);
        plain
    }
}

/// A file as it is called in a folder: its name where it lies there, else its whole path.
fn seen_from(path: &Path, folder: &Path) -> Result<String, LegError> {
    let whole = |path: &Path| {
        path.canonicalize().map_err(|source| LegError::Io { path: path.display().to_string(), source })
    };
    let (file, folder) = (whole(path)?, whole(folder)?);
    Ok(file.strip_prefix(&folder).unwrap_or(&file).display().to_string())
}
