//! The base parameters: a fixed vocabulary of what a fit may change in the plain actuator.

use sealegs_model::{Parameter, Scale};
use serde::{Deserialize, Serialize};

use super::{ActuatorSpec, Kind};
use crate::ActuatorError;
use crate::text::meant;

/// Name, unit of a linear actuator and unit of a rotary one, in the order of
/// [`ActuatorSpec::base_parameters`].
pub const BASE_PARAMETERS: [(&str, &str, &str); 11] = [
    ("stiffness", "N/m", "N m/rad"),
    ("reflected_inertia", "kg", "kg m^2"),
    ("damping", "N s/m", "N m s/rad"),
    ("force_constant", "N/A", "N m/A"),
    ("winding_resistance", "ohm", "ohm"),
    ("motor_gain", "", ""),
    ("sprung_mass", "kg", ""),
    ("travel_per_rad", "m/rad", ""),
    ("input_offset", "", ""),
    ("command_lead", "samples", "samples"),
    ("clock_skew", "samples", "samples"),
];

/// What is known of a base parameter beside what the physics gives: `[parameters.<name>]`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterSpec {
    /// A measured or fitted value in place of what the physics gives.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// One standard deviation from individual to individual, as a ratio of the nominal value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// One standard deviation of what a fit knows of the value, in its unit; goes before `tolerance`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
    /// Least admitted value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Greatest admitted value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Never changed by a fit. Without it, `motor_gain` and `sprung_mass` are fixed unless something else is
    /// said of them, and all others are free; so is the `motor_gain` of a loop that commands a torque.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed: Option<bool>,
    /// How a search steps: `linear` or `logarithmic`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<Scale>,
}

/// Greatest skew between the clocks of command and sensors, in sampling periods: loggers read their sensors anywhere
/// between two commands.
const CLOCK_SKEW: f64 = 0.5;

/// Without `min` and `max`: this far from the nominal value, as ratios.
const BOUNDS_LINEAR: (f64, f64) = (0.5, 1.5);
/// The same for a quantity of which only the order of magnitude is guessed.
const BOUNDS_LOGARITHMIC: (f64, f64) = (1e-4, 1e4);

/// Whether a value at a bound stands where a bound is assumed that no file states: so many times its nominal value.
#[must_use]
pub fn is_assumed_bound(ratio: f64) -> bool {
    let [(a, b), (c, d)] = [BOUNDS_LINEAR, BOUNDS_LOGARITHMIC];
    // A search keeps a hair's breadth from its bounds.
    [a, b, c, d].iter().any(|bound| (ratio / bound - 1.0).abs() < 1e-3)
}

impl ActuatorSpec {
    /// The parameters of the plain actuator, nominal values being what the physics gives, in the fixed order of
    /// [`BASE_PARAMETERS`]; a rotary actuator has no `sprung_mass`, a drive without a spring neither that nor a
    /// `stiffness`, and only a drive without a spring whose file gives one has a `winding_resistance`.
    ///
    /// `force_constant` is felt only where the input is a current, `motor_gain` only where it is a motor force
    /// or torque. `input_offset` is a constant beside the command, in its unit. `command_lead` is a choice
    /// between 0 (a row's command is in force from its time stamp on, the sensors are read before it acts) and
    /// 1 (it was in force during the period that ends at the time stamp); both are tried in a fit, and where
    /// they fit equally well the one that the file states is kept, otherwise 1, so that a delay counts from the start
    /// of the period.
    /// `clock_skew` is a small lateness of the command against the sensors, in sampling periods.
    #[must_use]
    pub fn base_parameters(&self) -> Vec<Parameter> {
        let c = self.coefficients();
        let gain = self.parameters.get("motor_gain").and_then(|p| p.value).unwrap_or(1.0);
        let said =
            |name: &str, otherwise: f64| self.parameters.get(name).and_then(|p| p.value).unwrap_or(otherwise);
        let nominal = [
            c.stiffness,
            c.reflected_inertia,
            c.damping,
            c.force_constant,
            said("winding_resistance", self.motor.winding_resistance_ohm.unwrap_or(f64::NAN)),
            gain,
            c.sprung_mass,
            said("travel_per_rad", self.ratio()),
            said("input_offset", 0.0),
            said("command_lead", 0.0),
            said("clock_skew", 0.0),
        ];
        BASE_PARAMETERS
            .into_iter()
            .zip(nominal)
            .filter(|((name, ..), _)| match *name {
                "stiffness" => !self.is_rigid(),
                "sprung_mass" => self.kind == Kind::Linear && !self.is_rigid(),
                "travel_per_rad" => self.kind == Kind::Linear,
                "winding_resistance" => self.is_rigid() && self.motor.winding_resistance_ohm.is_some(),
                _ => true,
            })
            .map(|((name, linear, rotary), value)| {
                let unit = if self.kind == Kind::Linear { linear } else { rotary };
                let strength = (name == "motor_gain" && self.has_torque_loop()).then(motor_strength);
                parameter(name, unit, value, self.parameters.get(name).or(strength.as_ref()))
            })
            .collect()
    }
}

/// What is known of the torque that a motor gives over the one that a loop commands, where the file says nothing: torque constants vary
/// by a tenth from motor to motor, an estimate.
fn motor_strength() -> ParameterSpec {
    ParameterSpec { tolerance: Some(0.1), ..ParameterSpec::default() }
}

fn parameter(name: &str, unit: &str, value: f64, said: Option<&ParameterSpec>) -> Parameter {
    let usually_fixed =
        matches!(name, "motor_gain" | "sprung_mass" | "travel_per_rad" | "input_offset" | "command_lead");
    let known = said.cloned().unwrap_or_default();
    let scale = known.scale.unwrap_or_default();
    let (low, high) = match scale {
        Scale::Linear => BOUNDS_LINEAR,
        Scale::Logarithmic => BOUNDS_LOGARITHMIC,
    };
    let mut parameter = Parameter::new(
        name,
        unit,
        value,
        known.min.unwrap_or(low * value),
        known.max.unwrap_or(high * value),
    );
    parameter.prior_std = known.std.or(known.tolerance.map(|t| t * value)).filter(|s| *s > 0.0);
    parameter.fixed = known.fixed.unwrap_or(usually_fixed && said.is_none_or(|s| *s == value_only(s)));
    parameter.scale = scale;
    if name == "clock_skew" {
        // Below one sample an offset is a matter of the clocks; anything longer is a delay, and an effect.
        (parameter.min, parameter.max, parameter.typical) = (-CLOCK_SKEW, CLOCK_SKEW, 0.1 * CLOCK_SKEW);
        parameter.prior_std = parameter.prior_std.or(Some(0.5 * CLOCK_SKEW));
        return parameter;
    }
    if name == "command_lead" {
        // A choice, not a quantity: was a row stamped when its command began or when it ended?
        parameter.max = 1.0;
        parameter.starts = if known.value.is_some_and(|v| v < 0.5) { vec![0.0, 1.0] } else { vec![1.0, 0.0] };
        parameter.fixed = true;
    }
    if value == 0.0 {
        // Nothing to take a ratio of: the span of the bounds, or one unit, is a typical change.
        parameter.typical =
            if parameter.max > parameter.min { 0.1 * (parameter.max - parameter.min) } else { 1.0 };
    }
    parameter
}

/// The same statement reduced to its value: a bare value does not free a parameter that is usually fixed.
fn value_only(said: &ParameterSpec) -> ParameterSpec {
    ParameterSpec { value: said.value, ..ParameterSpec::default() }
}

/// Checks the `[parameters]` tables of a file.
pub(super) fn validate(spec: &ActuatorSpec) -> Result<(), ActuatorError> {
    let names = BASE_PARAMETERS.map(|(name, ..)| name);
    for (name, said) in &spec.parameters {
        if !names.contains(&name.as_str()) {
            let hint = meant(name, names);
            return Err(ActuatorError::value(
                format!("parameters.{name}"),
                "a table",
                format!("one of {}{hint}", names.join(", ")),
            ));
        }
        let check = |field: &str, value: Option<f64>, ok: fn(f64) -> bool, admitted: &str| match value {
            Some(v) if !(v.is_finite() && ok(v)) => {
                Err(ActuatorError::value(format!("parameters.{name}.{field}"), v, admitted))
            }
            _ => Ok(()),
        };
        if matches!(name.as_str(), "input_offset" | "clock_skew") {
            check("value", said.value, |_| true, "finite")?;
        } else if matches!(name.as_str(), "damping" | "sprung_mass" | "command_lead") {
            check("value", said.value, |v| v >= 0.0, "zero or positive, and finite")?;
        } else {
            check("value", said.value, |v| v > 0.0, "positive and finite")?;
        }
        check("tolerance", said.tolerance, |v| v >= 0.0, "zero or positive, and finite")?;
        check("std", said.std, |v| v >= 0.0, "zero or positive, and finite")?;
        let signed = matches!(name.as_str(), "input_offset" | "clock_skew");
        let least: fn(f64) -> bool = if signed { |_| true } else { |v| v >= 0.0 };
        check("min", said.min, least, if signed { "finite" } else { "zero or positive, and finite" })?;
        check("max", said.max, |v| v > 0.0, "positive and finite")?;
        if said.scale == Some(Scale::Logarithmic) {
            check("min", said.min, |v| v > 0.0, "positive on a logarithmic scale")?;
        }
    }
    for p in spec.base_parameters() {
        if p.scale == Scale::Logarithmic && p.value <= 0.0 {
            return Err(ActuatorError::value(
                format!("parameters.{}.scale", p.name),
                "logarithmic",
                "linear for a value of zero",
            ));
        }
        if !p.value.is_finite() {
            return Err(ActuatorError::value(format!("parameters.{}", p.name), p.value, "finite"));
        }
        if !(p.min <= p.value && p.value <= p.max) {
            return Err(ActuatorError::value(
                format!("parameters.{}", p.name),
                format!("{} (nominal)", p.value),
                format!("between min and max, {} and {}", p.min, p.max),
            ));
        }
    }
    Ok(())
}
