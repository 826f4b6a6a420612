//! The actuator file and its meaning: what a series elastic actuator is made of, what follows from it, and
//! what a fit may change.

mod known;
mod parameters;
mod parts;
mod preset;
mod servo;

pub(crate) use known::narrowed;
pub use parameters::{BASE_PARAMETERS, ParameterSpec, is_assumed_bound};
pub use parts::{
    Configuration, EffectSpec, EffectValue, Kind, LinkageSpec, Motor, Ratings, SensorSpec, Transmission,
};
pub use servo::{Feedback, ServoSpec};

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::ActuatorError;
use crate::spring::{Spring, SpringLimits};
use crate::text::{line_of, parse_toml};

/// An actuator as its file describes it: series elastic, or with `spring = "none"` a rigid drive. A model file written by `sealegs add` has the same form.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorSpec {
    /// Unique name.
    pub id: String,
    /// One line for lists.
    #[serde(default)]
    pub description: String,
    /// Along an axis or about one.
    pub kind: Kind,
    /// On which side of the transmission the spring sits.
    #[serde(default)]
    pub configuration: Configuration,
    /// Translating mass between spring and screw `m_s`, kg: motor, housing and screw (SMH) or nut and tube
    /// (SBN). Zero for a rotary actuator, whose inertia before the spring is all the rotor's.
    #[serde(default)]
    pub sprung_mass_kg: f64,
    /// Translating mass on the other side of the screw, kg: it moves with its link.
    #[serde(default)]
    pub unsprung_mass_kg: f64,
    /// The motor.
    pub motor: Motor,
    /// From the rotor to the spring.
    pub transmission: Transmission,
    /// The series spring, or `spring = "none"`.
    pub spring: Spring,
    /// The drive's own position loop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo: Option<ServoSpec>,
    /// What the maker allows.
    #[serde(default, skip_serializing_if = "Ratings::is_empty")]
    pub ratings: Ratings,
    /// A linkage at the output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linkage: Option<LinkageSpec>,
    /// What is known of each base parameter beside its nominal value.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, ParameterSpec>,
    /// What is known of the parameters of effects that the file does not include, by effect and parameter: a campaign
    /// on a bench looks for no other values.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub known: BTreeMap<String, BTreeMap<String, ParameterSpec>>,
    /// Physical effects beyond the base model, in the order of inclusion.
    #[serde(default, rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
    /// Gain and bias of the sensors, by channel.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sensors: BTreeMap<String, SensorSpec>,
    /// Where the numbers came from; kept as it is.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub provenance: BTreeMap<String, String>,
}

/// The numbers of the equations of motion, referred to the screw (linear: kg, N s/m, N/m, N/A) or to the
/// output (rotary: kg m^2, N m s/rad, N m/rad, N m/A).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Coefficients {
    /// Which side the spring is on.
    pub configuration: Configuration,
    /// Spring stiffness `k`; infinite where there is no spring.
    pub stiffness: f64,
    /// Reflected rotor inertia `m_J = J / r^2`.
    pub reflected_inertia: f64,
    /// Reflected motor damping `b = b_r / r^2`.
    pub damping: f64,
    /// Motor force per current `K_tau / r`.
    pub force_constant: f64,
    /// Sprung mass `m_s`.
    pub sprung_mass: f64,
    /// Unsprung mass of the actuator, which moves with the link on that side.
    pub unsprung_mass: f64,
}

impl Coefficients {
    /// `m_T = m_J + m_s`: what moves on the spring when both ends are held.
    #[must_use]
    pub fn total_mass(&self) -> f64 {
        self.reflected_inertia + self.sprung_mass
    }
}

impl ActuatorSpec {
    /// Screw extension per rotor angle `r = l / (2 pi N_p)`, m/rad (eq 3-2); output angle per rotor angle for a
    /// gear; 1 for a direct drive.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.transmission.ratio()
    }

    /// The nominal coefficients: what the physics gives, unless `[parameters.<name>] value` replaces it.
    #[must_use]
    pub fn coefficients(&self) -> Coefficients {
        let nominal =
            |name: &str, physics: f64| self.parameters.get(name).and_then(|p| p.value).unwrap_or(physics);
        let r = self.ratio();
        Coefficients {
            configuration: self.configuration,
            stiffness: nominal("stiffness", self.spring.stiffness()),
            reflected_inertia: nominal("reflected_inertia", self.motor.rotor_inertia_kg_m2 / (r * r)),
            damping: nominal("damping", self.motor.rotor_damping_nm_s / (r * r)),
            force_constant: nominal("force_constant", self.motor.torque_constant_nm_a / r),
            sprung_mass: nominal("sprung_mass", self.sprung_mass_kg),
            unsprung_mass: self.unsprung_mass_kg,
        }
    }

    /// Whether there is no spring: the rotor turns its load directly.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        self.spring == Spring::None
    }

    /// Speed at which the back-EMF equals the supply, m/s (rad/s for a rotary actuator): `r V / K_tau`. An ideal
    /// motor without load; `None` without a supply.
    #[must_use]
    pub fn no_load_speed(&self) -> Option<f64> {
        self.motor.supply_v.map(|volts| self.ratio() * volts / self.motor.torque_constant_nm_a)
    }

    /// What the spring can bear, with the actuator's rated peak, and the stiffness that the model uses.
    #[must_use]
    pub fn spring_limits(&self) -> SpringLimits {
        SpringLimits {
            stiffness: self.coefficients().stiffness,
            ..self.spring.limits(self.ratings.peak(self.kind))
        }
    }

    /// The same actuator with its spring at another setting (see [`Spring::with_setting`]). A stiffness that
    /// was measured or fitted at the old setting no longer holds and is dropped.
    ///
    /// # Errors
    ///
    /// Those of [`Spring::with_setting`].
    pub fn with_spring_setting(&self, setting: &str) -> Result<Self, ActuatorError> {
        Ok(self.with_spring(self.spring.with_setting(setting)?))
    }

    /// The same actuator with another spring; a stiffness measured or fitted with the old one is dropped. With the spring
    /// and the setting that it has, nothing changes: what the file states at its own setting is what that setting is.
    #[must_use]
    pub fn with_spring(&self, spring: Spring) -> Self {
        if spring == self.spring {
            return self.clone();
        }
        let mut changed = Self { spring, ..self.clone() };
        if let Some(stiffness) = changed.parameters.get_mut("stiffness") {
            *stiffness = ParameterSpec { value: None, std: None, min: None, max: None, ..stiffness.clone() };
        }
        changed
    }

    /// Reads an actuator from TOML; `file` is named in messages.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Syntax`] for text, keys and types; [`ActuatorError::Value`] for a number that no
    /// actuator can have.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, ActuatorError> {
        let spec: Self = parse_toml(text, file)?;
        spec.validate().map_err(|error| match error {
            ActuatorError::Value { field, value, admitted, .. } => ActuatorError::Value {
                file: file.to_owned(),
                line: line_of(text, &field),
                field,
                value,
                admitted,
            },
            other => other,
        })?;
        Ok(spec)
    }

    /// The actuator as TOML that [`ActuatorSpec::from_toml`] reads back to the same value.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string_pretty(self)
            .unwrap_or_else(|error| unreachable!("a spec has only string keys and plain values: {error}"))
    }

    /// Loads a user's file, if `name_or_path` is one (seen from `relative_to`, if given), else a preset.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::UnknownActuator`] with the list of presets, [`ActuatorError::Unreadable`], or those
    /// of [`ActuatorSpec::from_toml`].
    pub fn load(name_or_path: &str, relative_to: Option<&Path>) -> Result<Self, ActuatorError> {
        let path = relative_to.map_or_else(|| name_or_path.into(), |folder| folder.join(name_or_path));
        if path.is_file() {
            let file = path.display().to_string();
            let text = std::fs::read_to_string(&path).map_err(|error| ActuatorError::Unreadable {
                file: file.clone(),
                reason: error.to_string(),
            })?;
            return Self::from_toml(&text, &file);
        }
        if name_or_path.ends_with(".toml") || name_or_path.contains(std::path::MAIN_SEPARATOR) {
            return Err(ActuatorError::Unreadable {
                file: path.display().to_string(),
                reason: "no such file".to_owned(),
            });
        }
        Self::preset(name_or_path)
    }

    /// The same actuator without what a fit knew of its values (`std`): their tolerances hold again, if there are any.
    #[must_use]
    pub fn without_fitted_std(&self) -> Self {
        let mut plain = self.clone();
        plain.parameters.values_mut().for_each(|said| said.std = None);
        plain.effects.iter_mut().flat_map(|e| e.parameters.values_mut()).for_each(|given| given.std = None);
        plain
    }

    /// Whether the drive follows a goal by a loop that commands a torque.
    #[must_use]
    pub fn has_torque_loop(&self) -> bool {
        self.servo.as_ref().is_some_and(ServoSpec::commands_torque)
    }

    /// What a drive without a spring must not have, and what its servo needs.
    fn validate_rigid(&self) -> Result<(), ActuatorError> {
        if self.sprung_mass_kg != 0.0 {
            let admitted = "zero where there is no spring";
            return Err(ActuatorError::value("sprung_mass_kg", self.sprung_mass_kg, admitted));
        }
        let Some(servo) = &self.servo else { return Ok(()) };
        servo.validate().map_err(|error| match error {
            ActuatorError::Value { file, line, field, value, admitted } => {
                ActuatorError::Value { file, line, field: format!("servo.{field}"), value, admitted }
            }
            other => other,
        })?;
        if self.kind != Kind::Rotary {
            return Err(ActuatorError::value(
                "kind",
                "linear",
                "rotary for a servo with its own position loop",
            ));
        }
        if servo.commands_torque() {
            return Ok(());
        }
        let needed = [
            ("motor.winding_resistance_ohm", self.motor.winding_resistance_ohm),
            ("motor.supply_v", self.motor.supply_v),
        ];
        match needed.iter().find(|(_, value)| value.is_none()) {
            Some((field, _)) => {
                Err(ActuatorError::value(*field, "nothing", "given: a servo's loop sets a voltage"))
            }
            None => Ok(()),
        }
    }

    /// Checks every number, for a spec that was changed after reading.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] whose field is its path in the file.
    pub fn validate(&self) -> Result<(), ActuatorError> {
        let within = |table: &'static str| {
            move |error: ActuatorError| match error {
                ActuatorError::Value { file, line, field, value, admitted } => {
                    ActuatorError::Value { file, line, field: format!("{table}.{field}"), value, admitted }
                }
                other => other,
            }
        };
        if self.id.is_empty() {
            return Err(ActuatorError::value("id", "\"\"", "a name"));
        }
        for (field, mass) in
            [("sprung_mass_kg", self.sprung_mass_kg), ("unsprung_mass_kg", self.unsprung_mass_kg)]
        {
            if !(mass >= 0.0 && mass.is_finite()) {
                return Err(ActuatorError::value(field, mass, "zero or positive, and finite"));
            }
            if self.kind == Kind::Rotary && mass != 0.0 {
                return Err(ActuatorError::value(field, mass, "zero for a rotary actuator"));
            }
        }
        self.motor.validate().map_err(within("motor"))?;
        self.transmission.validate(self.kind).map_err(within("transmission"))?;
        self.spring.validate().map_err(within("spring"))?;
        if self.is_rigid() {
            self.validate_rigid()?;
        } else if let Some(servo) = &self.servo {
            let (field, gain) = match servo.proportional_nm_per_rad {
                Some(gain) => ("servo.proportional_nm_per_rad", gain),
                None => ("servo.proportional_per_rad", servo.proportional_per_rad),
            };
            let admitted = "absent: a position loop is known of a drive without a spring only";
            return Err(ActuatorError::value(field, gain, admitted));
        } else if (self.kind == Kind::Rotary) != matches!(self.spring, Spring::Torsion(_)) {
            return Err(ActuatorError::value(
                "spring.type",
                if self.kind == Kind::Rotary { "a linear spring" } else { "torsion" },
                "torsion for a rotary actuator and only for one",
            ));
        }
        self.ratings.validate(self.kind).map_err(within("ratings"))?;
        if let Some(linkage) = &self.linkage {
            linkage.validate().map_err(within("linkage"))?;
        }
        parameters::validate(self)?;
        known::validate(self)?;
        for (index, effect) in self.effects.iter().enumerate() {
            effect.validate(index)?;
        }
        for (channel, sensor) in &self.sensors {
            sensor.validate(channel)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
