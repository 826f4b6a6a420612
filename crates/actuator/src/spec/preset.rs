//! The actuators that come with the program, embedded so that they load from any folder.

use super::ActuatorSpec;
use crate::ActuatorError;
use crate::text::nearest;

const PRESETS: [(&str, &str); 9] = [
    ("thor-linear", include_str!("../../../../assets/actuators/thor-linear.toml")),
    ("thor-hoekens", include_str!("../../../../assets/actuators/thor-hoekens.toml")),
    ("saffir-linear", include_str!("../../../../assets/actuators/saffir-linear.toml")),
    ("rmd-x8-rotary-sea", include_str!("../../../../assets/actuators/rmd-x8-rotary-sea.toml")),
    ("rigid-linear", include_str!("../../../../assets/actuators/rigid-linear.toml")),
    ("hobby-servo", include_str!("../../../../assets/actuators/hobby-servo.toml")),
    ("quasi-direct-drive", include_str!("../../../../assets/actuators/quasi-direct-drive.toml")),
    ("rigid-rotary", include_str!("../../../../assets/actuators/rigid-rotary.toml")),
    ("mass-spring-damper", include_str!("../../../../assets/actuators/mass-spring-damper.toml")),
];

impl ActuatorSpec {
    /// Names of the presets.
    #[must_use]
    pub fn preset_names() -> Vec<&'static str> {
        PRESETS.iter().map(|(name, _)| *name).collect()
    }

    /// The text of a preset's file, with the source of each number.
    #[must_use]
    pub fn preset_text(name: &str) -> Option<&'static str> {
        PRESETS.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
    }

    /// A preset by its name.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::UnknownActuator`] with the nearest name and the list.
    pub fn preset(name: &str) -> Result<Self, ActuatorError> {
        let text = Self::preset_text(name).ok_or_else(|| ActuatorError::UnknownActuator {
            name: name.to_owned(),
            suggestion: nearest(name, Self::preset_names()),
            known: Self::preset_names().into_iter().map(str::to_owned).collect(),
        })?;
        Self::from_toml(text, &format!("{name}.toml"))
    }
}
