//! An effect at its place: which there are, what a scenario's file names, and putting them in.

use super::at_actuator::{self, card, ids_at, setting};
use super::{Build, CATALOGUE, LegEffect, LegSetting};
use crate::LegError;
use crate::error::meant;
use crate::robot::Robot;
use crate::scenario::Scenario;
use sealegs_actuator::Coefficients;
use sealegs_actuator::effect::{self, Effect, OwnEffect, Setting, is_of_actuator};
use sealegs_actuator::plant::Plant;
use sealegs_actuator::spec::EffectSpec;
use sealegs_model::{EffectCard, Excitation};
use std::sync::Arc;

/// An effect of one of the catalogues, or a user's own.
#[derive(Debug, Clone)]
pub(crate) enum EffectRef {
    Actuator(&'static dyn Effect),
    Own(Arc<dyn Effect>),
    Leg(&'static dyn LegEffect),
}

impl EffectRef {
    /// The actuator's effect, if it is one.
    pub fn at_actuator(&self) -> Option<&dyn Effect> {
        match self {
            Self::Actuator(effect) => Some(*effect),
            Self::Own(effect) => Some(effect.as_ref()),
            Self::Leg(_) => None,
        }
    }

    /// The base parameters that it takes the place of (see [`LegEffect::replaces`]), by their names without the place.
    pub fn replaces(&self) -> &'static [&'static str] {
        if let Self::Leg(effect) = self { effect.replaces() } else { &[] }
    }
}

/// An effect at its place with the values of its parameters.
#[derive(Debug, Clone)]
pub(crate) struct Placed {
    pub effect: EffectRef,
    pub place: String,
    /// The sensor's channel without its place, where the id is narrowed down.
    pub channel: Option<String>,
    pub values: Vec<f64>,
}

/// Place and rest of an id.
fn split(id: &str) -> Option<(&str, &str)> {
    id.split_once('/')
}

/// All effects that a leg could have, with their cards, whose ids carry the place.
pub(crate) fn candidates(leg: &LegSetting, own: &[Arc<dyn Effect>]) -> Vec<(EffectCard, EffectRef)> {
    let mut all = Vec::new();
    let mut places: Vec<String> = leg.robot.actuators.iter().map(|a| a.name.clone()).collect();
    for channel in &leg.seen.measured {
        if let Some((place, _)) = channel.split_once('.')
            && !places.iter().any(|p| p == place)
        {
            places.push(place.to_owned());
        }
    }
    let settings: Vec<_> = places.iter().map(|place| setting(place, leg)).collect();
    let known = effect::CATALOGUE.iter().map(|e| EffectRef::Actuator(*e));
    let own = own.iter().map(|e| EffectRef::Own(e.clone()));
    for effect in known.chain(own) {
        for (place, setting) in places.iter().zip(&settings) {
            let Some(at_actuator) = effect.at_actuator() else { continue };
            for id in ids_at(at_actuator, place, leg, setting) {
                let card = card(at_actuator, setting);
                all.push((EffectCard { id: format!("{place}/{id}"), ..card }, effect.clone()));
            }
        }
    }
    for effect in CATALOGUE {
        for place in effect.places(leg) {
            let card = effect.card(&place, leg);
            all.push((EffectCard { id: format!("{place}/{}", card.id), ..card }, EffectRef::Leg(*effect)));
        }
    }
    all
}

impl Placed {
    /// An effect by its id.
    pub fn new(id: &str, effect: EffectRef, values: Vec<f64>) -> Self {
        let (place, rest) = split(id).unwrap_or(("", id));
        let channel = rest.split_once('@').map(|(_, channel)| channel.to_owned());
        Self { effect, place: place.to_owned(), channel, values }
    }

    /// Puts one of the leg's own effects in; those of actuators wait for [`at_place`].
    pub fn install(&self, leg: &mut Build) {
        if let EffectRef::Leg(effect) = &self.effect {
            effect.install(&self.values, &self.place, leg);
        }
    }
}

/// What effects make of a place, as an actuator on its own, with the numbers of the one that is there.
pub(crate) fn at_place(effects: &[Placed], place: &str, actuator: Option<(&Coefficients, f64)>) -> Plant {
    let mut plant = at_actuator::plant(actuator);
    for placed in effects.iter().filter(|e| e.place == place) {
        if let Some(effect) = placed.effect.at_actuator() {
            effect.install(&placed.values, placed.channel.as_deref(), &mut plant);
        }
    }
    plant
}

/// Why no actuator of a leg can have an effect of the actuators' catalogue, if so.
fn refused(id: &str) -> Option<String> {
    let known = effect::CATALOGUE.iter().find(|e| e.card(&Setting::unknown()).id == id)?;
    if is_of_actuator(*known) {
        return None;
    }
    let at_leg = if CATALOGUE.iter().any(|own| own.id() == id) {
        "; a leg has it at its own places, such as its joints"
    } else {
        ""
    };
    Some(format!(
        "its actuator's file has the effect '{id}', which acts on a bench beside the actuator{at_leg}"
    ))
}

/// The scenario with the effects of the actuators' own files beside those that it names itself, which go before.
///
/// # Errors
///
/// [`LegError::Scenario`] for an effect of a bench that no leg can have.
pub(crate) fn with_effects_of_actuators(scenario: &Scenario, robot: &Robot) -> Result<Scenario, LegError> {
    let mut all = scenario.clone();
    for placement in &robot.actuators {
        for effect in placement.spec.iter().flat_map(|spec| &spec.effects) {
            if let Some(problem) = refused(&effect.id) {
                return Err(LegError::scenario(&scenario.name, &placement.name, problem));
            }
            let id = format!("{}/{}", placement.name, effect.id);
            if all.effects.iter().all(|named| named.id != id) {
                all.effects.push(EffectSpec { id, ..effect.clone() });
            }
        }
    }
    Ok(all)
}

/// The effects that a scenario's file names.
///
/// # Errors
///
/// [`LegError::Scenario`] for an id or parameter that the leg does not have, with the nearest one.
pub(crate) fn of_scenario(leg: &LegSetting) -> Result<Vec<Placed>, LegError> {
    let scenario = leg.scenario;
    if scenario.effects.is_empty() {
        return Ok(Vec::new());
    }
    let own = own_effects(scenario)?;
    let seen = Excitation { measured: all_channels(leg), ..leg.seen.clone() };
    let all = candidates(&LegSetting { seen: &seen, ..*leg }, &own);
    let mut placed: Vec<Placed> = Vec::new();
    for (index, said) in scenario.effects.iter().enumerate() {
        let fault = |field: String, problem: String| Err(LegError::scenario(&scenario.name, &field, problem));
        let Some((card, effect)) = all.iter().find(|(card, _)| card.id == said.id) else {
            let known = all.iter().map(|(card, _)| card.id.as_str());
            let hint = meant(&said.id, known);
            let field = format!("effect {} id", index + 1);
            return fault(field, format!("this leg can have no effect '{}'{hint}", said.id));
        };
        if scenario.effects[..index].iter().any(|e| e.id == said.id) {
            return fault(format!("effect {} id", index + 1), format!("'{}' is named twice", said.id));
        }
        for name in said.parameters.keys() {
            if !card.parameters.iter().any(|p| p.name == *name) {
                let names: Vec<&str> = card.parameters.iter().map(|p| p.name.as_str()).collect();
                let problem = format!("the effect has no such parameter; there are {}", names.join(", "));
                return fault(format!("effect.{}.parameters.{name}", said.id), problem);
            }
        }
        let value = |name: &str, guess: f64| said.parameters.get(name).map_or(guess, |v| v.value);
        let values = card.parameters.iter().map(|p| value(&p.name, p.value)).collect();
        placed.push(Placed::new(&said.id, effect.clone(), values));
    }
    Ok(placed)
}

/// The user's own effects that a scenario's file embeds, each once.
///
/// # Errors
///
/// Those of [`OwnEffect::from_definition`].
pub(crate) fn own_effects(scenario: &Scenario) -> Result<Vec<Arc<dyn Effect>>, LegError> {
    let mut own: Vec<Arc<dyn Effect>> = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    for said in &scenario.effects {
        let Some(definition) = &said.definition else { continue };
        let name = definition.get("id").and_then(toml::Value::as_str).unwrap_or_default();
        if !names.contains(&name) {
            names.push(name);
            let origin = format!("effect.{}.definition", said.id);
            own.push(Arc::new(OwnEffect::from_definition(definition, &origin)?));
        }
    }
    Ok(own)
}

/// Every channel that the leg could have measured.
fn all_channels(leg: &LegSetting) -> Vec<String> {
    let joints: Vec<String> = leg.robot.moving_joints().map(|j| j.name.clone()).collect();
    let actuators: Vec<String> = leg.robot.actuators.iter().map(|a| a.name.clone()).collect();
    crate::channel::all(&joints, &actuators).into_iter().map(|(name, _)| name).collect()
}
