//! The actuators' catalogue at the actuators of a leg, and their sensors' effects at every place that is measured.

use super::LegSetting;
use crate::dynamics::coupling::carries_series;
use crate::simulation::{actuator_coefficients, actuator_spec};
use sealegs_actuator::effect::{ActuatorKind, CommandKind, Effect, Scope, Setting, ids, is_of_actuator};
use sealegs_actuator::plant::Plant;
use sealegs_actuator::{ActuatorSpec, Coefficients, Kind};
use sealegs_model::{EffectCard, Excitation, Parameter, SignalRange, internal};

/// The effect that needs a place between screw and link 2.
const SERIES_COMPLIANCE: &str = "series-compliance";

/// Most starting values of one parameter, and only one parameter of an effect has them: a simulation of a leg is
/// dear.
const MOST_STARTS: usize = 5;

/// The seen signals of one place, under the names that they have on a bench.
fn seen_at(place: &str, seen: &Excitation) -> Excitation {
    let own =
        |name: &str| name.strip_prefix(place).and_then(|rest| rest.strip_prefix('.')).map(str::to_owned);
    let mut ranges: Vec<SignalRange> = seen
        .ranges
        .iter()
        .filter_map(|r| own(&r.name).map(|name| SignalRange { name, ..r.clone() }))
        .collect();
    // Where no current flows the spring's force is the measure of what a friction would be felt beside.
    let peak = |name: &str| ranges.iter().find(|r| r.name == name).map_or(0.0, SignalRange::peak);
    let spring = peak(internal::SPRING_FORCE);
    if peak(internal::MOTOR_FORCE) < 0.1 * spring {
        ranges.retain(|r| r.name != internal::MOTOR_FORCE);
        let name = internal::MOTOR_FORCE.to_owned();
        ranges.push(SignalRange { name, min: -spring, max: spring, rms: spring });
    }
    Excitation {
        measured: seen.measured.iter().filter_map(|c| own(c)).collect(),
        ranges,
        sample_period_s: seen.sample_period_s,
    }
}

/// What effects choose their guesses by at a place; `None` for a place without an actuator, which has sensors only.
pub(super) fn setting(place: &str, leg: &LegSetting) -> Setting {
    let found = actuator(place, leg);
    let (kind, c, travel) = match &found {
        Some((spec, c)) => (spec.kind, *c, spec.ratio()),
        None => return Setting { seen: seen_at(place, leg.seen), ..Setting::unknown() },
    };
    Setting {
        kind: if kind == Kind::Rotary { ActuatorKind::Rotary } else { ActuatorKind::Linear },
        stiffness: c.stiffness,
        has_spring: true,
        has_load: false,
        command: CommandKind::Unknown,
        winding: None,
        total_mass: c.total_mass(),
        unsprung_mass: c.unsprung_mass,
        travel_per_rad: travel,
        force_per_command: c.force_constant,
        output_arm_m: None,
        output_moves: true,
        base_is_held: false,
        seen: seen_at(place, leg.seen),
    }
}

/// The actuator at a place as the scenario has it.
fn actuator(place: &str, leg: &LegSetting) -> Option<(ActuatorSpec, Coefficients)> {
    let own = leg.robot.actuators[leg.robot.actuator_index(place)?].spec.as_ref()?;
    let spec = actuator_spec(leg.scenario, place, own).ok()?;
    let c = actuator_coefficients(leg.scenario, place, &spec).ok()?;
    Some((spec, c))
}

/// The ids, without the place, under which an effect of the actuators' catalogue can be at a place.
pub(super) fn ids_at(effect: &dyn Effect, place: &str, leg: &LegSetting, setting: &Setting) -> Vec<String> {
    let is_actuator = leg.robot.actuator_index(place).is_some();
    // What acts on a bench's output acts on a leg's joints, which are no part of the actuator.
    let without_output = Setting { output_moves: false, ..setting.clone() };
    if (effect.scope() == Scope::One && !is_actuator)
        || !effect.applies(&without_output)
        || !is_of_actuator(effect)
    {
        return Vec::new();
    }
    let mut ids = ids(effect, setting);
    let carries = actuator(place, leg).is_some_and(|(spec, _)| carries_series(spec.configuration));
    if !carries {
        ids.retain(|id| id != SERIES_COMPLIANCE);
    }
    ids
}

/// The card of an effect of the actuators' catalogue, with few starting values; a periodic one keeps all its periods,
/// between which no search finds its way.
pub(super) fn card(effect: &dyn Effect, setting: &Setting) -> EffectCard {
    let card = effect.card(setting);
    if card.is_periodic() {
        return card;
    }
    EffectCard { parameters: few_starts(card.parameters), ..card }
}

/// Keeps starting values of the parameter that has most of them, spread evenly over what there is.
fn few_starts(mut parameters: Vec<Parameter>) -> Vec<Parameter> {
    let most = (0..parameters.len()).rev().max_by_key(|&i| parameters[i].starts.len());
    for (i, p) in parameters.iter_mut().enumerate() {
        if Some(i) != most {
            p.starts.clear();
        } else if p.starts.len() > MOST_STARTS {
            let step = p.starts.len() as f64 / MOST_STARTS as f64;
            p.starts = (0..MOST_STARTS).map(|k| p.starts[((k as f64 + 0.5) * step) as usize]).collect();
        }
    }
    parameters
}

/// An actuator on its own into which effects are put; their laws are then the leg's.
pub(crate) fn plant(c: Option<(&Coefficients, f64)>) -> Plant {
    let Some((c, travel_per_rad)) = c else { return Plant::new(1.0, 0.0, 0.0, 1.0) };
    let mut plant = Plant::new(c.reflected_inertia, c.sprung_mass, c.damping, c.stiffness);
    plant.travel_per_rad = travel_per_rad;
    plant.force_per_command = c.force_constant;
    plant
}
