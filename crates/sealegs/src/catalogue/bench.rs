//! The benches on which the actuators' effects are shown, and how they are driven.

use super::{Entry, Home, Signature, changes, most_telling, residual, shown_at};
use crate::Result;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, OUTPUTS, PendulumRig, TEMPERATURE};
use sealegs_actuator::effect::{CATALOGUE, Setting};
use sealegs_model::{
    EffectCard, Excitation, InputHold, Model, ModelError, Prediction, Record, Signal, SignalRange,
};
use std::f64::consts::TAU;

/// A bench on which effects can be shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rig {
    /// THOR's actuator on the pendulum, driven by a current.
    Sprung,
    /// A small gear motor that swings a weight, driven by a voltage.
    Voltage,
    /// The same with its own position loop, driven by a goal.
    Servo,
    /// The same driven by a torque.
    Torque,
}

/// The small gear motor: values of the size of a hobby servo's.
const GEAR_MOTOR: &str = r#"
id = "gear-motor"
description = "A small gear motor that swings a weight"
kind = "rotary"
spring = "none"
[motor]
torque_constant_nm_a = 0.35
winding_resistance_ohm = 3.4
supply_v = 7.4
rotor_inertia_kg_m2 = 0.001
rotor_damping_nm_s = 0.01
[transmission]
type = "direct"
"#;

/// Its position loop: duty per rad of error.
const LOOP: &str = "[servo]\nproportional_per_rad = 0.6\n";

/// The weight that it swings: 0.5 kg at 0.1 m.
const WEIGHT: PendulumRig = PendulumRig { arm_m: 1.0, length_m: 0.1, mass_kg: 0.5, rod_mass_kg: 0.0 };

/// Greatest motor force on THOR's bench, N: a third of what the actuator is rated for.
const FORCE_N: f64 = 1000.0;

/// Greatest voltage at the gear motor, V.
const VOLTAGE_V: f64 = 5.0;

/// Greatest goal of the servo, rad.
const GOAL_RAD: f64 = 0.5;

/// Greatest torque of the gear motor, N m: a third of what holds the weight level, so that it swings and does not turn over.
const TORQUE_NM: f64 = 0.15;

/// Samples per second.
const RATE_HZ: f64 = 1000.0;

/// How long a run lasts, s.
const DURATION_S: f64 = 2.0;

/// Until when the command is a sine, s; steps follow.
const SINE_UNTIL_S: f64 = 1.2;

/// Between two steps, s.
const STEP_S: f64 = 0.2;

/// Temperature at the beginning of a run, degrees Celsius, and by how much it rises, K.
const COLD_C: f64 = 25.0;
const WARMING_K: f64 = 30.0;

/// A rig with what was seen of it.
struct Ready {
    model: BenchModel,
    record: Record,
    seen: Excitation,
    channels: Vec<String>,
    predicted: Prediction,
}

impl Rig {
    const ALL: [Self; 4] = [Self::Sprung, Self::Voltage, Self::Servo, Self::Torque];

    fn words(self) -> &'static str {
        match self {
            Self::Sprung => "thor-linear on the pendulum bench, a sine of 1 Hz and then steps of the current",
            Self::Voltage => {
                "a small gear motor that swings a weight, a sine of 1 Hz and then steps of the voltage"
            }
            Self::Servo => "a servo that swings a weight, a sine of 1 Hz and then steps of its goal",
            Self::Torque => {
                "a small gear motor that swings a weight, a sine of 1 Hz and then steps of the torque"
            }
        }
    }

    fn ready(self) -> Result<Ready> {
        let (spec, rig) = match self {
            Self::Sprung => (ActuatorSpec::preset("thor-linear")?, PendulumRig::default()),
            Self::Voltage | Self::Torque => (ActuatorSpec::from_toml(GEAR_MOTOR, "gear motor")?, WEIGHT),
            Self::Servo => (ActuatorSpec::from_toml(&format!("{GEAR_MOTOR}{LOOP}"), "servo")?, WEIGHT),
        };
        let (input, peak) = match self {
            Self::Sprung => ("current_a", FORCE_N / spec.coefficients().force_constant),
            Self::Voltage => ("voltage_v", VOLTAGE_V),
            Self::Servo => ("position_rad", GOAL_RAD),
            Self::Torque => ("joint_torque_nm", TORQUE_NM),
        };
        let model = BenchModel::new(spec, Bench::Pendulum(rig))?;
        let record = driven(input, peak);
        let channels: Vec<String> =
            OUTPUTS.iter().filter(|c| model.predicts(c)).map(|c| (*c).to_owned()).collect();
        let predicted = model.predict(&values(&model), &record, &channels)?;
        let seen = seen(&record, &predicted);
        Ok(Ready { model, record, seen, channels, predicted })
    }
}

/// A run of a sine and then of steps to both sides.
fn driven(input: &str, peak: f64) -> Record {
    let time_s: Vec<f64> = (0..(DURATION_S * RATE_HZ) as usize).map(|i| i as f64 / RATE_HZ).collect();
    let command = |t: &f64| {
        if *t < SINE_UNTIL_S {
            return peak * (TAU * t).sin();
        }
        let step = ((t - SINE_UNTIL_S) / STEP_S) as usize;
        0.6 * peak * if step.is_multiple_of(2) { 1.0 } else { -1.0 }
    };
    let values = time_s.iter().map(command).collect();
    let temperature = time_s.iter().map(|t| COLD_C + WARMING_K * t / DURATION_S).collect();
    Record {
        cut: false,
        name: "signature".to_owned(),
        time_s,
        hold: InputHold::ZeroOrder,
        inputs: vec![
            Signal { channel: input.to_owned(), values },
            Signal { channel: TEMPERATURE.to_owned(), values: temperature },
        ],
        outputs: Vec::new(),
    }
}

/// What a run drove its model to.
pub(super) fn seen(record: &Record, predicted: &Prediction) -> Excitation {
    let range = |s: &Signal| {
        let (min, max) =
            s.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
        let squares: f64 = s.values.iter().map(|v| v * v).sum();
        SignalRange { name: s.channel.clone(), min, max, rms: (squares / s.values.len() as f64).sqrt() }
    };
    Excitation {
        measured: predicted.outputs.iter().map(|s| s.channel.clone()).collect(),
        ranges: record
            .inputs
            .iter()
            .chain(&predicted.internals)
            .chain(&predicted.outputs)
            .map(range)
            .collect(),
        sample_period_s: record.mean_period_s(),
    }
}

fn values(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

/// The actuators' catalogue in its own order, each effect on the first rig that can have it.
pub(super) fn entries() -> Result<Vec<Entry>> {
    let mut cards = Vec::new();
    for rig in Rig::ALL {
        let ready = rig.ready()?;
        cards.extend(ready.model.effects(&ready.seen).into_iter().map(|card| (rig, card)));
    }
    let unknown = Setting::unknown();
    let entry = |id: String| {
        let (rig, card) = cards.iter().find(|(_, card)| card.id == id)?;
        Some(Entry { card: card.clone(), home: Home::Bench(*rig), on_leg: false })
    };
    Ok(CATALOGUE.iter().filter_map(|effect| entry(effect.card(&unknown).id)).collect())
}

pub(super) fn signature(rig: Rig, card: &EffectCard) -> Result<Signature> {
    let ready = rig.ready()?;
    let own = shown_at(card);
    let with = ready.model.with_effect(&card.id, &ready.seen)?;
    let all = [values(&ready.model), own.clone()].concat();
    let truth = with.predict(&all, &ready.record, &ready.channels)?;
    let change = most_telling(changes(&truth, &ready.predicted, &ready.record.time_s))
        .ok_or_else(|| ModelError::Setup { reason: format!("{} shows in no channel", card.id) })?;
    let law = ready.model.law_graph(&card.id, &ready.seen, &own, &ready.record.inputs[0].channel)?;
    Ok(Signature { values: own, law, run: rig.words().to_owned(), residual: residual(change) })
}
