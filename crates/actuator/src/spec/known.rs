//! What is known beforehand of effects that a file does not include: `[known.<effect>]`, one table a parameter.
//!
//! A maker states the count of a drive or the play of a gear, and a search then need not, and must not, look for other
//! values: what explains the data with an impossible one is another effect.

use super::{ActuatorSpec, Kind, ParameterSpec};
use crate::ActuatorError;
use crate::effect::{ActuatorKind, CATALOGUE, Setting};
use crate::text::meant;
use sealegs_model::Parameter;

/// Standard deviations from a value with a tolerance that are admitted where no bounds are stated.
const WITHIN: f64 = 5.0;

/// Parameters of an effect with what is known of them in the place of guesses.
pub(crate) fn narrowed(spec: &ActuatorSpec, effect: &str, parameters: Vec<Parameter>) -> Vec<Parameter> {
    let family = effect.split('@').next().unwrap_or(effect);
    let Some(known) = spec.known.get(effect).or_else(|| spec.known.get(family)) else { return parameters };
    let narrow = |p: Parameter| match known.get(&p.name) {
        Some(said) => narrow(p, said),
        None => p,
    };
    parameters.into_iter().map(narrow).collect()
}

fn narrow(mut p: Parameter, said: &ParameterSpec) -> Parameter {
    if let Some(value) = said.value {
        (p.value, p.starts) = (value, Vec::new());
        p.prior_std = said.std.or(said.tolerance.map(|t| t * value.abs())).filter(|s| *s > 0.0);
        if let Some(std) = p.prior_std {
            (p.min, p.max) = (p.min.max(value - WITHIN * std), value + WITHIN * std);
            p.typical = std;
        }
        (p.min, p.max) = (p.min.min(value), p.max.max(value));
    }
    (p.min, p.max) = (said.min.unwrap_or(p.min), said.max.unwrap_or(p.max));
    p.value = p.value.clamp(p.min, p.max);
    p.starts.retain(|s| (p.min..=p.max).contains(s));
    p.scale = said.scale.unwrap_or(p.scale);
    p.freed_at_last &= said.fixed.is_none();
    p.fixed = said.fixed.unwrap_or(p.fixed);
    p
}

/// Checks the `[known]` tables of a file.
pub(super) fn validate(spec: &ActuatorSpec) -> Result<(), ActuatorError> {
    for (effect, parameters) in &spec.known {
        let family = effect.split('@').next().unwrap_or(effect);
        // What a command counts in depends on the campaign's input.
        let settings = [1.0, 2.0].map(|force_per_command| Setting {
            kind: if spec.kind == Kind::Rotary { ActuatorKind::Rotary } else { ActuatorKind::Linear },
            force_per_command,
            has_spring: !spec.is_rigid(),
            has_load: spec.is_rigid(),
            ..Setting::unknown()
        });
        let cards: Vec<_> = CATALOGUE.iter().flat_map(|e| settings.iter().map(|s| e.card(s))).collect();
        let cards: Vec<_> = cards.iter().filter(|c| c.id == family).collect();
        if cards.is_empty() {
            let ids: Vec<String> = CATALOGUE.iter().map(|e| e.card(&settings[0]).id).collect();
            let hint = meant(family, ids.iter().map(String::as_str));
            let admitted = format!("an effect of the catalogue{hint}");
            return Err(ActuatorError::value(format!("known.{effect}"), "a table", admitted));
        }
        for (name, said) in parameters {
            let place = |field: &str| format!("known.{effect}.{name}{field}");
            let mut names: Vec<&str> =
                cards.iter().flat_map(|c| c.parameters.iter().map(|p| p.name.as_str())).collect();
            names.dedup();
            if !names.contains(&name.as_str()) {
                let admitted = format!("one of {}", names.join(", "));
                return Err(ActuatorError::value(place(""), "a table", admitted));
            }
            let numbers = [("value", said.value), ("min", said.min), ("max", said.max)];
            for (field, v) in numbers.into_iter().filter_map(|(field, v)| Some((field, v?))) {
                if !v.is_finite() {
                    return Err(ActuatorError::value(place(&format!(".{field}")), v, "finite"));
                }
            }
            for (field, v) in [("tolerance", said.tolerance), ("std", said.std)] {
                if let Some(v) = v.filter(|v| !(*v >= 0.0 && v.is_finite())) {
                    let admitted = "zero or positive, and finite";
                    return Err(ActuatorError::value(place(&format!(".{field}")), v, admitted));
                }
            }
            let (least, most) = (said.min.unwrap_or(f64::NEG_INFINITY), said.max.unwrap_or(f64::INFINITY));
            let value = said.value.unwrap_or(least.max(most.min(0.0)));
            if !(least <= value && value <= most) {
                let admitted = format!("between min and max, {least} and {most}");
                return Err(ActuatorError::value(place(""), value, admitted));
            }
        }
    }
    Ok(())
}
