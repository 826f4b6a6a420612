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
mod file;
mod laws;
mod written;

pub use expression::{Expression, Fault};

use std::sync::Arc;

use super::Effect;
use super::setting::Setting;
use crate::ActuatorError;
use crate::plant::Plant;
use crate::text::{line_of, parse_toml};
use curve::OnCurve;
use file::{CurveFile, File, MOST_PARAMETERS, Place, check_id, law_place, parameter};
use sealegs_model::{EffectCard, Law, Parameter};
use written::Written;

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
