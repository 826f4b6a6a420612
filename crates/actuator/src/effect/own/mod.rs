//! A user's own effect: a file with a law as an expression, which enters diagnosis like any other effect.
//!
//! ```toml
//! id = "belt-drag"
//! acts-on = "rotor"                     # rotor | drive | spring | output
//! law = "a*y_dot + b*abs(F_bs)*tanh(y_dot/v0)"
//!
//! [parameters]
//! a = { guess = 10.0, min = 0.0, max = 1e4, unit = "N s/m" }
//! b = { guess = 0.01, min = 0.0, max = 1.0 }
//! v0 = { fixed = 1e-3 }
//! ```
//!
//! `summary`, `told-apart` and `cure` are texts for the effect's card, and may be left out.
//!
//! In place of a law and its parameters there may be a `[curve]` ([`sealegs_model::Law`]), as a diagnosis writes it that no
//! effect of the catalogue explains:
//!
//! ```toml
//! id = "unknown-at-spring"
//! acts-on = "spring"                    # also rotor | drive | output | sensor/force_1_n
//!
//! [curve]
//! over = "deflection"                   # what else: each place's own signals, see the message for another one
//! x = [-1e-3, 0.0, 1e-3]
//! y = [-30.0, 0.0, 80.0]
//! ```
//!
//! What the law gives, and of what (SI; for a rotary actuator N m and rad stand for N and m):
//!
//! | `acts-on` | the law is | variables |
//! |---|---|---|
//! | `rotor` | a resistance in N at the screw: positive opposes extension | `y`, `y_dot`, `theta`, `theta_dot` (rotor), `F_bs`, `t` |
//! | `drive` | the command that is left of `u`, in its unit | `u`, `F_m` (asked for), `y_dot`, `theta_dot` |
//! | `spring` | a force in N beside the spring, positive in compression | `delta`, `delta_dot`, `F_k` (the linear spring's) |
//! | `output` | a resistance at the output joint, N m (N without a lever) | `theta`, `theta_dot` (joint; `y`, `y_dot` along the axis), `t` |
//!
//! Functions: tanh, exp, ln, sin, cos, tan, atan, abs, sqrt, sign, square, min, max; the constant pi.
//!
//! A law is applied as a smooth force. A `sign(y_dot)` switches from step to step and does not hold at rest as the
//! catalogue's dry friction does: `tanh(y_dot/v0)` with a small `v0` creeps but is well behaved.

mod curve;
mod expression;
mod laws;

pub use expression::{Expression, Fault};

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Deserialize;

use super::setting::Setting;
use super::{CATALOGUE, Effect};
use crate::ActuatorError;
use crate::plant::{Link, Plant};
use crate::text::{line_of, parse_toml};
use curve::OnCurve;
use laws::{BesideSpring, InDrive, OnOutput, OnRotor};
use sealegs_model::{Curve, EffectCard, Law, Parameter};

/// Most parameters of one law.
const MOST_PARAMETERS: usize = 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Place {
    Rotor,
    Drive,
    Spring,
    Output,
}

impl Place {
    fn variables(self) -> &'static [&'static str] {
        match self {
            Self::Rotor => &["y", "y_dot", "theta", "theta_dot", "F_bs", "t"],
            Self::Drive => &["u", "F_m", "y_dot", "theta_dot"],
            Self::Spring => &["delta", "delta_dot", "F_k"],
            Self::Output => &["theta", "theta_dot", "y", "y_dot", "t"],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Rotor => "rotor",
            Self::Drive => "drive",
            Self::Spring => "spring",
            Self::Output => "output",
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct File {
    id: String,
    acts_on: Place,
    law: String,
    #[serde(default)]
    parameters: BTreeMap<String, ParameterFile>,
    summary: Option<String>,
    told_apart: Option<String>,
    cure: Option<String>,
}

/// A file whose law is a curve.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct CurveFile {
    id: String,
    /// Where on a leg `add` puts it.
    place: Option<String>,
    acts_on: String,
    curve: Curve,
    summary: Option<String>,
    told_apart: Option<String>,
    cure: Option<String>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct ParameterFile {
    guess: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    #[serde(default)]
    unit: String,
    fixed: Option<f64>,
    neutral: Option<f64>,
}

/// An effect that a user wrote.
#[derive(Debug, Clone)]
pub struct OwnEffect {
    id: String,
    summary: String,
    told_apart: String,
    cure: String,
    law: OwnLaw,
    parameters: Vec<Parameter>,
    definition: toml::Table,
    origin: String,
}

/// What the effect does.
#[derive(Debug, Clone)]
enum OwnLaw {
    /// What an expression gives.
    Expression(Written),
    /// What a curve gives.
    Curve(OnCurve),
}

/// An expression at its place.
#[derive(Debug, Clone)]
struct Written {
    place: Place,
    text: String,
    expression: Expression,
}

impl OwnEffect {
    /// Reads an effect from TOML; `file` is named in messages.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Syntax`] for text, keys and types, and for a law that does not parse, with line and
    /// column; [`ActuatorError::Value`] for an id that is taken, a bad number, a law that divides by zero or is
    /// not finite, or one that has no neutral values.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, ActuatorError> {
        let definition: toml::Table = parse_toml(text, file)?;
        let new = if definition.contains_key("curve") {
            Self::of_curve(parse_toml(text, file)?, definition, file)
        } else {
            Self::new(parse_toml(text, file)?, definition, file)
        };
        new.map_err(|error| match error {
            ActuatorError::Syntax { file, column, message, suggestion, .. } => {
                let (line, before) = law_place(text);
                ActuatorError::Syntax { file, line, column: before + column, message, suggestion }
            }
            ActuatorError::Value { field, value, admitted, .. } => ActuatorError::Value {
                file: file.to_owned(),
                line: line_of(text, &field),
                field,
                value,
                admitted,
            },
            other => other,
        })
    }

    /// Reads an effect from a file.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Unreadable`], or those of [`OwnEffect::from_toml`].
    pub fn load(path: &std::path::Path) -> Result<Self, ActuatorError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|error| ActuatorError::Unreadable { file: file.clone(), reason: error.to_string() })?;
        Self::from_toml(&text, &file)
    }

    /// An effect from the definition that a model file embeds; `origin` is named in messages.
    ///
    /// # Errors
    ///
    /// As [`OwnEffect::from_toml`].
    pub fn from_definition(definition: &toml::Table, origin: &str) -> Result<Self, ActuatorError> {
        let text = toml::to_string(definition)
            .map_err(|error| ActuatorError::value("definition", "a table", format!("plain TOML: {error}")))?;
        Self::from_toml(&text, origin)
    }

    /// An effect of a law that was read off a missing signal.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] for a law that no place of an actuator can carry.
    pub fn of_law(law: &Law) -> Result<Self, ActuatorError> {
        Self::from_definition(&curve::definition(law)?, &law.id)
    }

    fn of_curve(file: CurveFile, definition: toml::Table, origin: &str) -> Result<Self, ActuatorError> {
        check_id(&file.id)?;
        if let Some(place) = file.place.filter(|p| p.is_empty() || p.contains('/')) {
            return Err(ActuatorError::value("place", place, "the name of an actuator or a joint"));
        }
        let law = OnCurve::new(&file.acts_on, file.curve)?;
        Ok(Self {
            id: file.id,
            summary: file.summary.unwrap_or_else(|| "A curve that was read off a missing signal.".to_owned()),
            told_apart: file.told_apart.unwrap_or_else(|| "By its curve alone.".to_owned()),
            cure: file.cure.unwrap_or_else(|| {
                "Find what it stands for; until then compensate for the curve.".to_owned()
            }),
            parameters: law.parameters(),
            law: OwnLaw::Curve(law),
            definition,
            origin: origin.to_owned(),
        })
    }

    fn new(file: File, definition: toml::Table, origin: &str) -> Result<Self, ActuatorError> {
        check_id(&file.id)?;
        if file.parameters.len() > MOST_PARAMETERS {
            let admitted = format!("at most {MOST_PARAMETERS} parameters");
            return Err(ActuatorError::value("parameters", file.parameters.len(), admitted));
        }
        let variables = file.acts_on.variables();
        let mut parameters = Vec::new();
        for (name, said) in &file.parameters {
            parameters.push(parameter(name, said, variables)?);
        }
        let names: Vec<&str> =
            variables.iter().copied().chain(file.parameters.keys().map(String::as_str)).collect();
        let expression = Expression::parse(&file.law, &names).map_err(|fault| ActuatorError::Syntax {
            file: origin.to_owned(),
            line: 1,
            column: fault.character,
            message: format!("law, character {}: {}", fault.character, fault.message),
            suggestion: None,
        })?;
        let written = Written { place: file.acts_on, text: file.law, expression };
        let mut own = Self {
            id: file.id,
            summary: file.summary.unwrap_or_else(|| "An effect of the user's own.".to_owned()),
            told_apart: file
                .told_apart
                .unwrap_or_else(|| "By its own law; the file's `told-apart` says more.".to_owned()),
            cure: file.cure.unwrap_or_else(|| "Known to its author; the file's `cure` says it.".to_owned()),
            law: OwnLaw::Expression(written.clone()),
            parameters,
            definition,
            origin: origin.to_owned(),
        };
        written.check_finite(&own.parameters)?;
        written.find_neutral(&file.parameters, &mut own.parameters)?;
        Ok(own)
    }

    /// The effect's file as a table, to be embedded in a model file.
    #[must_use]
    pub fn table(&self) -> &toml::Table {
        &self.definition
    }

    /// The id under which a model includes it: with its place, where its file names one.
    #[must_use]
    pub fn included_id(&self) -> String {
        let place = self.definition.get("place").and_then(toml::Value::as_str);
        place.map_or_else(|| self.id.clone(), |place| format!("{place}/{}", self.id))
    }
}

impl Written {
    /// Signs and sizes of the variables at which a law must be finite: rest, and ordinary and small motion.
    fn probes(&self) -> Vec<Vec<f64>> {
        let count = self.place.variables().len();
        let mut probes = vec![vec![0.0; count]];
        for (i, size) in [1.0, 1e-3, 30.0].into_iter().enumerate() {
            for signs in 0..(1 << count) {
                let value = |k: usize| {
                    let sign = if signs >> k & 1 == 1 { -1.0 } else { 1.0 };
                    // No two variables of the same size, so that nothing cancels by chance.
                    sign * size * (1.0 + 0.37 * (k + i) as f64)
                };
                probes.push((0..count).map(value).collect());
            }
        }
        probes
    }

    fn check_finite(&self, parameters: &[Parameter]) -> Result<(), ActuatorError> {
        let guess: Vec<f64> = parameters.iter().map(|p| p.value).collect();
        let mut sets = vec![guess.clone()];
        for (i, p) in parameters.iter().enumerate().filter(|(_, p)| !p.fixed) {
            for bound in [p.min, p.max] {
                let mut values = guess.clone();
                values[i] = bound;
                sets.push(values);
            }
        }
        for set in &sets {
            for probe in self.probes() {
                let all: Vec<f64> = probe.iter().chain(set).copied().collect();
                if let Err(fault) = self.expression.checked(&all) {
                    let names = self.place.variables().iter().copied();
                    let names = names.chain(parameters.iter().map(|p| p.name.as_str()));
                    let at: Vec<String> = names.zip(&all).map(|(n, v)| format!("{n} = {v}")).collect();
                    let admitted = format!(
                        "finite wherever it may be asked; at character {}: {}, with {}",
                        fault.character,
                        fault.message,
                        at.join(", ")
                    );
                    return Err(ActuatorError::value("law", format!("\"{}\"", self.text), admitted));
                }
            }
        }
        Ok(())
    }

    /// Finds where the effect vanishes: what the file says, else all parameters zero that may be zero.
    fn find_neutral(
        &self,
        said: &BTreeMap<String, ParameterFile>,
        parameters: &mut [Parameter],
    ) -> Result<(), ActuatorError> {
        let told = said.values().any(|p| p.neutral.is_some());
        let neutral: Vec<Option<f64>> = parameters
            .iter()
            .map(|p| match said.get(&p.name).and_then(|s| s.neutral) {
                Some(neutral) => Some(neutral),
                None if told || p.fixed || p.min > 0.0 || p.max < 0.0 => None,
                None => Some(0.0),
            })
            .collect();
        let at: Vec<f64> = parameters.iter().zip(&neutral).map(|(p, n)| n.unwrap_or(p.value)).collect();
        let law = self.expression.bind(self.place.variables().len(), &at);
        for probe in self.probes() {
            // A drive leaves the command as it is, everything else gives no force.
            let without = if self.place == Place::Drive { probe[0] } else { 0.0 };
            if law.value(&probe) != without {
                let admitted = if self.place == Place::Drive { "'u'" } else { "zero" };
                return Err(ActuatorError::value(
                    "law",
                    format!("\"{}\"", self.text),
                    format!(
                        "{admitted} where its parameters are neutral: let those that switch it off reach 0 \
                         within min and max, or give them 'neutral'"
                    ),
                ));
            }
        }
        for (parameter, neutral) in parameters.iter_mut().zip(neutral) {
            parameter.neutral = neutral;
        }
        Ok(())
    }
}

fn check_id(id: &str) -> Result<(), ActuatorError> {
    let word = |w: &str| !w.is_empty() && w.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    if id.len() > 64 || !id.split('-').all(word) {
        return Err(ActuatorError::value("id", format!("\"{id}\""), "lower-case words joined by '-'"));
    }
    let setting = Setting::unknown();
    if CATALOGUE.iter().any(|e| e.card(&setting).id == id) {
        return Err(ActuatorError::value("id", format!("\"{id}\""), "another name than the catalogue's"));
    }
    Ok(())
}

fn parameter(name: &str, said: &ParameterFile, variables: &[&str]) -> Result<Parameter, ActuatorError> {
    let field = |key: &str| format!("parameters.{name}.{key}");
    let starts = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !starts || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Err(ActuatorError::value("parameters", format!("\"{name}\""), "letters, digits and '_'"));
    }
    if variables.contains(&name) || expression::is_reserved(name) {
        return Err(ActuatorError::value("parameters", name, "no name of a variable or function"));
    }
    let given = [("guess", said.guess), ("min", said.min), ("max", said.max), ("neutral", said.neutral)];
    for (key, value) in given.into_iter().chain([("fixed", said.fixed)]) {
        if let Some(value) = value.filter(|v| !v.is_finite()) {
            return Err(ActuatorError::value(field(key), value, "finite"));
        }
    }
    if let Some(value) = said.fixed {
        if let Some((key, Some(other))) = given.into_iter().find(|(_, v)| v.is_some()) {
            return Err(ActuatorError::value(field(key), other, "absent beside 'fixed'"));
        }
        return Ok(Parameter { fixed: true, ..Parameter::new(name, &said.unit, value, value, value) });
    }
    let missing = |key: &str| ActuatorError::value(field(key), "nothing", "given, or 'fixed' in place of it");
    let guess = said.guess.ok_or_else(|| missing("guess"))?;
    let min = said.min.ok_or_else(|| missing("min"))?;
    let max = said.max.ok_or_else(|| missing("max"))?;
    if !(min <= guess && guess <= max && min < max) {
        return Err(ActuatorError::value(
            field("guess"),
            guess,
            format!("between min and max, {min} and {max}"),
        ));
    }
    if let Some(neutral) = said.neutral.filter(|n| !(min..=max).contains(n)) {
        return Err(ActuatorError::value(field("neutral"), neutral, format!("between {min} and {max}")));
    }
    Ok(Parameter::new(name, &said.unit, guess, min, max))
}

/// Line of the law in a file, and how many columns come before its text.
fn law_place(text: &str) -> (usize, usize) {
    let line = line_of(text, "law").unwrap_or(1);
    let written = text.lines().nth(line - 1).unwrap_or_default();
    let quote = written.char_indices().find(|(_, c)| *c == '"' || *c == '\'').map_or(0, |(i, _)| i);
    (line, written[..quote].chars().count() + 1)
}

impl Written {
    fn install(&self, values: &[f64], plant: &mut Plant) {
        let law = self.expression.bind(self.place.variables().len(), values);
        let per_travel = 1.0 / plant.travel_per_rad;
        match self.place {
            Place::Rotor => plant.laws.rotor_forces.push(Box::new(OnRotor { law, per_travel })),
            Place::Drive => {
                let force_per_command = plant.force_per_command;
                plant.laws.drive_limits.push(Box::new(InDrive { law, per_travel, force_per_command }));
            }
            Place::Spring => {
                plant.laws.spring_forces.push(Box::new(BesideSpring { law, stiffness: plant.stiffness }));
            }
            Place::Output => {
                let link = plant.rigid.unwrap_or(plant.link_2);
                let arm = if let Link::Pendulum { arm_m, .. } = link { arm_m } else { 1.0 };
                plant.output_forces.push(Box::new(OnOutput { law, arm }));
            }
        }
    }
}

impl Effect for OwnEffect {
    fn card(&self, _setting: &Setting) -> EffectCard {
        let (place, equation, symbols, validity) = match &self.law {
            OwnLaw::Expression(written) => (
                written.place.name(),
                written.text.clone(),
                format!("variables: {}", written.place.variables().join(", ")),
                "The user's own law, applied as a smooth force: it does not hold at rest.",
            ),
            OwnLaw::Curve(curve) => (
                curve.place(),
                curve.equation(),
                "y1, y2, ...: the curve at its points; size: a factor of all; dry: dry friction beside it"
                    .to_owned(),
                "Straight lines between the points; what lies beyond them was not seen.",
            ),
        };
        EffectCard {
            id: self.id.clone(),
            summary: self.summary.clone(),
            acts_on: place.to_owned(),
            equation,
            validity: validity.to_owned(),
            reference: self.origin.clone(),
            symbols,
            told_apart: self.told_apart.clone(),
            cure: self.cure.clone(),
            parameters: self.parameters.clone(),
            passive: false,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        match &self.law {
            OwnLaw::Expression(written) => written.install(values, plant),
            OwnLaw::Curve(curve) => curve.install(values, plant),
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        let (output_moves, spring) = match &self.law {
            OwnLaw::Expression(w) => (w.place == Place::Output, w.place == Place::Spring),
            OwnLaw::Curve(curve) => curve.needs(),
        };
        (!output_moves || setting.output_moves) && (!spring || setting.has_spring)
    }

    fn definition(&self) -> Option<&toml::Table> {
        Some(&self.definition)
    }
}

/// The own effects that the effects of a model file embed, beside those `given`, each id once.
///
/// # Errors
///
/// Those of [`OwnEffect::from_definition`], and [`ActuatorError::Value`] for a definition under another id.
pub(crate) fn embedded(
    effects: &[crate::spec::EffectSpec],
    given: Vec<Arc<dyn Effect>>,
) -> Result<Vec<Arc<dyn Effect>>, ActuatorError> {
    let mut own = given;
    for effect in effects {
        let Some(definition) = &effect.definition else { continue };
        let origin = format!("effect.{}.definition", effect.id);
        let defined = OwnEffect::from_definition(definition, &origin)?;
        if defined.id != effect.id {
            return Err(ActuatorError::value(
                format!("{origin}.id"),
                &defined.id,
                format!("'{}'", effect.id),
            ));
        }
        let setting = Setting::unknown();
        if own.iter().all(|e| e.card(&setting).id != defined.id) {
            own.push(Arc::new(defined));
        }
    }
    Ok(own)
}

#[cfg(test)]
mod tests;
