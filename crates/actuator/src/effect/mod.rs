//! The catalogue of physical effects: one file each, and the registry that lists them.
//!
//! A new effect is one file here, its `mod` line, and one entry in [`CATALOGUE`]. The tests over the whole
//! registry then apply to it: unique id, units, neutral values that change nothing, passivity, recovery.
//! A user writes an effect of their own without recompiling, as a file with an expression: [`OwnEffect`].

mod backlash;
mod base_motion;
mod cable_stiffness;
mod carried;
mod command_quantisation;
mod coulomb_friction;
mod current_saturation;
mod dahl_friction;
mod direction_dependent_friction;
mod directional_efficiency;
mod feedback_delay;
mod hardening_spring;
mod load_dependent_friction;
mod load_mismatch;
mod motor_strength;
mod output_friction;
mod output_offset;
mod own;
mod position_dependent_friction;
mod presliding_friction;
mod pwm_dead_zone;
mod quadratic_drag;
mod sensor_delay;
mod sensor_lag;
mod series_compliance;
mod setting;
mod signature;
mod spring_damping;
mod spring_hysteresis;
mod stribeck_friction;
mod structural_mode;
mod supply_sag;
mod temperature_friction;
mod torque_ripple;
mod transport_delay;
mod voltage_saturation;
mod warming_friction;
mod wobbling_mass;

pub use carried::{is_of_actuator, is_of_joint};
pub(crate) use current_saturation::limit_current;
pub(crate) use own::embedded;
pub use own::{Expression, Fault, OwnEffect};
pub(crate) use pwm_dead_zone::PwmDeadZone;
pub use setting::{ActuatorKind, CommandKind, Quantity, Setting, magnitude, with_neutral, with_starts};
pub(crate) use signature::law;
pub use signature::{Curve, Graph, GraphAxis};
pub(crate) use transport_delay::TransportDelay;

use crate::plant::Plant;
use sealegs_model::EffectCard;
use std::fmt::Debug;

/// Where an effect's id may be narrowed down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// It acts at one place.
    One,
    /// On all sensors, or on one: `id@channel`.
    Sensors,
    /// On all force and torque sensors, or on one: `id@channel`.
    ForceSensors,
}

/// What [`Effect::friction_bound`] may depend on: extension and speed of the screw (m, m/s) and the force in it (N).
pub const FRICTION_NAMES: [&str; 3] = ["y", "y_dot", "F_bs"];

/// A physical effect that an actuator can have.
pub trait Effect: Debug + Send + Sync {
    /// Id, law, parameters with guesses that suit the setting.
    fn card(&self, setting: &Setting) -> EffectCard;

    /// Puts the effect with these parameter values (in the card's order) into a plant. `channel` is the
    /// sensor's channel where the id is narrowed down.
    fn install(&self, values: &[f64], channel: Option<&str>, plant: &mut Plant);

    /// Where the id may be narrowed down.
    fn scope(&self) -> Scope {
        Scope::One
    }

    /// The file of an effect that a user wrote, to be kept in a model file; the catalogue's have none.
    fn definition(&self) -> Option<&toml::Table> {
        None
    }

    /// Of a dry friction of the rotor its bound at these values as an expression, in the words of a user's own law
    /// ([`FRICTION_NAMES`]): other simulators evaluate it in a callback. `None` for everything else, and for what a
    /// writer of `sealegs-export` has an element of its own for.
    fn friction_bound(&self, _values: &[f64]) -> Option<String> {
        None
    }

    /// Whether it makes sense in this setting at all (a pendulum's friction needs a pendulum).
    fn applies(&self, _setting: &Setting) -> bool {
        true
    }
}

/// Every effect that the product knows, in the order of the printed catalogue.
pub static CATALOGUE: &[&dyn Effect] = &[
    &coulomb_friction::CoulombFriction,
    &presliding_friction::PreslidingFriction,
    &dahl_friction::DahlFriction,
    &stribeck_friction::StribeckFriction,
    &load_dependent_friction::LoadDependentFriction,
    &direction_dependent_friction::DirectionDependentFriction,
    &position_dependent_friction::PositionDependentFriction,
    &directional_efficiency::DirectionalEfficiency,
    &warming_friction::WarmingFriction,
    &temperature_friction::TemperatureFriction,
    &quadratic_drag::QuadraticDrag,
    &torque_ripple::TorqueRipple,
    &motor_strength::MotorStrength,
    &current_saturation::CurrentSaturation,
    &voltage_saturation::VoltageSaturation,
    &pwm_dead_zone::PwmDeadZone,
    &supply_sag::SupplySag,
    &transport_delay::TransportDelay,
    &feedback_delay::FeedbackDelay,
    &command_quantisation::CommandQuantisation,
    &hardening_spring::HardeningSpring,
    &spring_damping::SpringDamping,
    &spring_hysteresis::SpringHysteresis,
    &backlash::Backlash,
    &series_compliance::SeriesComplianceEffect,
    &base_motion::BaseMotion,
    &structural_mode::StructuralMode,
    &sensor_lag::SensorLag,
    &sensor_delay::SensorDelay,
    &output_friction::OutputFriction,
    &output_offset::OutputOffset,
    &cable_stiffness::CableStiffness,
    &load_mismatch::LoadMismatch,
    &wobbling_mass::WobblingMassEffect,
];

/// Whether a channel is a force or a torque by its unit.
fn is_force(channel: &str) -> bool {
    channel.ends_with("_n") || channel.ends_with("_nm")
}

/// The ids under which an effect can be added where these channels are measured: its own, then one for
/// each sensor that it can be narrowed down to.
#[must_use]
pub fn ids(effect: &dyn Effect, setting: &Setting) -> Vec<String> {
    let id = effect.card(setting).id;
    let narrowed = |wanted: fn(&str) -> bool| {
        let channels: Vec<&String> = setting.measured().iter().filter(|c| wanted(c)).collect();
        let mut ids = Vec::new();
        if !channels.is_empty() {
            ids.push(id.clone());
        }
        // With a single sensor the narrowed id would say the same thing twice.
        if channels.len() > 1 {
            ids.extend(channels.iter().map(|c| format!("{id}@{c}")));
        }
        ids
    };
    match effect.scope() {
        Scope::One => vec![id],
        Scope::Sensors => narrowed(|_| true),
        Scope::ForceSensors => narrowed(is_force),
    }
}
