//! The tables of an actuator file.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt;

use sealegs_model::Parameter;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

use crate::ActuatorError;
use crate::linkage::Hoekens;

/// What the actuator's output does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// It pushes along an axis: m and N.
    Linear,
    /// It turns about an axis: rad and N m.
    Rotary,
}

/// On which side of the transmission the spring sits, and whether rotor and sprung mass are told apart.
///
/// Link numbers here are the dissertation's drawings'. Benches and campaigns call the spring's side link 1 in every
/// configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Configuration {
    /// SMH: spring at link 1; motor, housing and screw are the sprung mass (THOR, SAFFiR).
    #[default]
    SprungMotorHousing,
    /// SBN: spring at link 2; ball nut and output tube are the sprung mass.
    SprungBallNut,
    /// The conventional model for comparison: the whole reflected inertia translates as sprung mass at link 1's
    /// spring, and the motor pushes it off link 2.
    Lumped,
}

/// The motor, at its rotor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// Torque per current `K_tau`, N m/A.
    pub torque_constant_nm_a: f64,
    /// Inertia of rotor and whatever turns with it `J`, kg m^2.
    pub rotor_inertia_kg_m2: f64,
    /// Viscous damping of rotor and transmission `b_r`, N m s.
    pub rotor_damping_nm_s: f64,
    /// The drive's limit `I_max`, A. The base model does not clip: `current-saturation` does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// Supply, V.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply_v: Option<f64>,
    /// Winding resistance, ohm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub winding_resistance_ohm: Option<f64>,
}

/// From the rotor's angle to the motion at the spring.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields, try_from = "TransmissionFile")]
pub enum Transmission {
    /// A belt and a ball screw.
    Screw {
        /// Rotor turns per screw turn `N_p`.
        belt_ratio: f64,
        /// Travel per screw turn `l`, m.
        screw_lead_m: f64,
    },
    /// A gear.
    Gear {
        /// Rotor turns per output turn.
        gear_ratio: f64,
    },
    /// None: rotor quantities are output quantities, r = 1.
    Direct,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TransmissionFile {
    r#type: String,
    belt_ratio: Option<f64>,
    screw_lead_m: Option<f64>,
    gear_ratio: Option<f64>,
}

impl TryFrom<TransmissionFile> for Transmission {
    type Error = String;

    fn try_from(file: TransmissionFile) -> Result<Self, String> {
        match (file.r#type.as_str(), file.belt_ratio, file.screw_lead_m, file.gear_ratio) {
            ("screw", Some(belt_ratio), Some(screw_lead_m), None) => {
                Ok(Self::Screw { belt_ratio, screw_lead_m })
            }
            ("screw", ..) => Err("a screw takes 'belt_ratio' and 'screw_lead_m'".to_owned()),
            ("gear", None, None, Some(gear_ratio)) => Ok(Self::Gear { gear_ratio }),
            ("gear", ..) => Err("a gear takes 'gear_ratio'".to_owned()),
            ("direct", None, None, None) => Ok(Self::Direct),
            ("direct", ..) => Err("a direct drive takes no ratio".to_owned()),
            (other, ..) => Err(format!("no transmission type '{other}'; known are screw, gear, direct")),
        }
    }
}

impl Transmission {
    /// Motion at the spring per rotor angle `r`: m/rad for a screw, rad/rad for a gear.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        match self {
            Self::Screw { belt_ratio, screw_lead_m } => screw_lead_m / (TAU * belt_ratio),
            Self::Gear { gear_ratio } => 1.0 / gear_ratio,
            Self::Direct => 1.0,
        }
    }

    pub(super) fn validate(&self, kind: Kind) -> Result<(), ActuatorError> {
        match self {
            Self::Screw { belt_ratio, screw_lead_m } => {
                positive("belt_ratio", *belt_ratio)?;
                positive("screw_lead_m", *screw_lead_m)?;
            }
            Self::Gear { gear_ratio } => positive("gear_ratio", *gear_ratio)?,
            Self::Direct => {}
        }
        match (self, kind) {
            (Self::Screw { .. }, Kind::Rotary) => {
                Err(ActuatorError::value("type", "screw", "gear or direct for a rotary actuator"))
            }
            (Self::Gear { .. }, Kind::Linear) => {
                Err(ActuatorError::value("type", "gear", "screw or direct for a linear actuator"))
            }
            _ => Ok(()),
        }
    }
}

/// What the maker allows. Force and speed of a rotary actuator have their own keys.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ratings {
    /// Peak force, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_force_n: Option<f64>,
    /// Continuous force, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous_force_n: Option<f64>,
    /// Greatest speed, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed_m_s: Option<f64>,
    /// Stroke, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stroke_m: Option<f64>,
    /// Distance between the attachment points with the screw fully in, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_length_m: Option<f64>,
    /// Peak torque of a rotary actuator, N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_torque_nm: Option<f64>,
    /// Continuous torque of a rotary actuator, N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub continuous_torque_nm: Option<f64>,
    /// Greatest speed of a rotary actuator, rad/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed_rad_s: Option<f64>,
}

impl Ratings {
    /// Whether nothing is rated.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Peak force, N, or torque, N m.
    #[must_use]
    pub fn peak(&self, kind: Kind) -> Option<f64> {
        match kind {
            Kind::Linear => self.peak_force_n,
            Kind::Rotary => self.peak_torque_nm,
        }
    }

    pub(super) fn validate(&self, kind: Kind) -> Result<(), ActuatorError> {
        let linear = [
            ("peak_force_n", self.peak_force_n),
            ("continuous_force_n", self.continuous_force_n),
            ("max_speed_m_s", self.max_speed_m_s),
            ("stroke_m", self.stroke_m),
            ("min_length_m", self.min_length_m),
        ];
        let rotary = [
            ("peak_torque_nm", self.peak_torque_nm),
            ("continuous_torque_nm", self.continuous_torque_nm),
            ("max_speed_rad_s", self.max_speed_rad_s),
        ];
        for (field, value) in linear.into_iter().chain(rotary) {
            optional_positive(field, value)?;
        }
        let (stray, whose) = match kind {
            Kind::Linear => (&rotary[..], "absent: it belongs to a rotary actuator"),
            Kind::Rotary => (&linear[..], "absent: it belongs to a linear actuator"),
        };
        match stray.iter().find_map(|(field, value)| value.map(|v| (field, v))) {
            Some((field, value)) => Err(ActuatorError::value(*field, value, whose)),
            None => Ok(()),
        }
    }
}

/// A linkage between the actuator's output and the joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum LinkageSpec {
    /// The inverted Hoekens linkage: the screw pushes the tracer, the crank turns with the joint.
    InvertedHoekens(Hoekens),
}

impl LinkageSpec {
    pub(super) fn validate(&self) -> Result<(), ActuatorError> {
        let Self::InvertedHoekens(linkage) = self;
        positive("crank_m", linkage.crank_m)?;
        positive("ground", linkage.ground)?;
        positive("coupler", linkage.coupler)?;
        positive("rocker", linkage.rocker)?;
        positive("tracer", linkage.tracer)
    }
}

/// A physical effect beyond the base model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectSpec {
    /// Its id in the catalogue, with its place where it has one: `sensor-lag@output_torque_nm`.
    pub id: String,
    /// Its parameters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, EffectValue>,
    /// For an effect that a user wrote: its definition, as in its own file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub definition: Option<toml::Table>,
}

/// How far a bound that was only guessed lies from a value that a file states, at least, as a ratio.
const BOUND_RATIO: f64 = 10.0;

impl EffectSpec {
    /// Puts the values that the file states into the effect's own parameters, whose names begin with its id.
    ///
    /// # Errors
    ///
    /// The name of the first value that belongs to none of them, and the names that they have.
    pub fn state_all(&self, own: &mut [Parameter]) -> Result<(), (&str, String)> {
        for (name, given) in &self.parameters {
            let full = format!("{}.{name}", self.id);
            let Some(parameter) = own.iter_mut().find(|p| p.name == full) else {
                let all: Vec<&str> = own.iter().filter_map(|p| Some(p.name.rsplit_once('.')?.1)).collect();
                return Err((name, all.join(", ")));
            };
            self.state(*given, parameter);
        }
        Ok(())
    }

    /// Puts a value that the file states into a parameter of this effect.
    ///
    /// The catalogue guesses starts, and bounds that have a unit, from the runs at hand, of which a file says nothing:
    /// the value is the only start, and bounds give way until ten times and a tenth of it lie between. A bound without
    /// a unit belongs to the law, and one of a user's own effect was stated: these give way to the value alone.
    pub fn state(&self, given: EffectValue, parameter: &mut Parameter) {
        let value = given.value;
        parameter.value = value;
        parameter.prior_std = given.std.filter(|s| *s > 0.0);
        let guessed = !parameter.unit.is_empty() && self.definition.is_none();
        let within = if guessed { [value, BOUND_RATIO * value, value / BOUND_RATIO] } else { [value; 3] };
        (parameter.min, parameter.max) =
            within.iter().fold((parameter.min, parameter.max), |(low, high), v| (low.min(*v), high.max(*v)));
        if !parameter.fixed {
            parameter.starts.clear();
        }
        parameter.typical = (0.1 * value.abs()).max(1e-3 * parameter.typical);
    }

    fn bad(&self, name: &str, value: f64, admitted: &str) -> ActuatorError {
        ActuatorError::value(format!("effect.{}.parameters.{name}", self.id), value, admitted)
    }

    /// Checks its numbers; `index` is its place in the file, from 0.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`].
    pub fn validate(&self, index: usize) -> Result<(), ActuatorError> {
        if self.id.is_empty() {
            return Err(ActuatorError::value(format!("effect {} id", index + 1), "\"\"", "a name"));
        }
        for (name, parameter) in &self.parameters {
            if !parameter.value.is_finite() {
                return Err(self.bad(name, parameter.value, "finite"));
            }
            if let Some(std) = parameter.std.filter(|s| !(*s >= 0.0 && s.is_finite())) {
                return Err(self.bad(name, std, "a standard deviation: zero or positive, and finite"));
            }
        }
        Ok(())
    }
}

/// A parameter of an effect: in a file a plain number, or `{ value, std }`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EffectValue {
    /// Its value, SI.
    pub value: f64,
    /// One standard deviation of what a fit knows of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
}

impl<'de> Deserialize<'de> for EffectValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrTable;

        impl<'de> Visitor<'de> for NumberOrTable {
            type Value = EffectValue;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or { value, std }")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<EffectValue, E> {
                Ok(EffectValue { value, std: None })
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<EffectValue, E> {
                Ok(EffectValue { value: value as f64, std: None })
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<EffectValue, A::Error> {
                #[derive(Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Table {
                    value: f64,
                    std: Option<f64>,
                }
                let Table { value, std } =
                    Deserialize::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(EffectValue { value, std })
            }
        }

        deserializer.deserialize_any(NumberOrTable)
    }
}

/// A sensor's errors: `measured = gain * true + bias`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSpec {
    /// Gain; 1 unless it was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// One standard deviation of what is known of the gain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_std: Option<f64>,
    /// Bias in the channel's unit; 0 unless it was fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias: Option<f64>,
    /// One standard deviation of what is known of the bias, in the channel's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_std: Option<f64>,
    /// How far the biases of single runs scatter about `bias`, one standard deviation, where runs were fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bias_spread: Option<f64>,
}

impl SensorSpec {
    /// Checks its numbers and the name of its channel.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`].
    pub fn validate(&self, channel: &str) -> Result<(), ActuatorError> {
        if let Err(unknown) = sealegs_model::Unit::of_channel(channel) {
            return Err(ActuatorError::value("sensors", channel, format!("channel names: {unknown}")));
        }
        let field = |name: &str| format!("sensors.{channel}.{name}");
        if let Some(gain) = self.gain.filter(|g| !g.is_finite() || *g == 0.0) {
            return Err(ActuatorError::value(field("gain"), gain, "finite and not zero"));
        }
        if let Some(bias) = self.bias.filter(|b| !b.is_finite()) {
            return Err(ActuatorError::value(field("bias"), bias, "finite"));
        }
        let stds =
            [("gain_std", self.gain_std), ("bias_std", self.bias_std), ("bias_spread", self.bias_spread)];
        for (name, std) in stds {
            if let Some(std) = std.filter(|s| !(*s >= 0.0 && s.is_finite())) {
                return Err(ActuatorError::value(field(name), std, "zero or positive, and finite"));
            }
        }
        Ok(())
    }
}

impl Motor {
    pub(super) fn validate(&self) -> Result<(), ActuatorError> {
        positive("torque_constant_nm_a", self.torque_constant_nm_a)?;
        positive("rotor_inertia_kg_m2", self.rotor_inertia_kg_m2)?;
        if !(self.rotor_damping_nm_s >= 0.0 && self.rotor_damping_nm_s.is_finite()) {
            return Err(ActuatorError::value(
                "rotor_damping_nm_s",
                self.rotor_damping_nm_s,
                "zero or positive, and finite",
            ));
        }
        optional_positive("current_limit_a", self.current_limit_a)?;
        optional_positive("supply_v", self.supply_v)?;
        optional_positive("winding_resistance_ohm", self.winding_resistance_ohm)
    }
}

pub(super) fn positive(field: &str, value: f64) -> Result<(), ActuatorError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(ActuatorError::value(field, value, "positive and finite"))
    }
}

pub(super) fn optional_positive(field: &str, value: Option<f64>) -> Result<(), ActuatorError> {
    value.map_or(Ok(()), |v| positive(field, v))
}
