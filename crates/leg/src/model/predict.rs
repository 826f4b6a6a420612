//! A leg's prediction for one record: the run, then what its sensors show at the record's time stamps.

use super::Case;
use crate::LegError;
use crate::channel::Channel;
use crate::dynamics::coupling::ActuatorInstant;
use crate::effect::Placed;
use crate::robot::Robot;
use crate::scenario::{MOST_STEPS, Scenario};
use crate::simulation::{EventLevel, Simulation};
use sealegs_actuator::plant::{Grid, mean_per_step, sample};
use sealegs_model::{ModelError, Prediction, Record, Signal, internal};

/// What an input column commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Input {
    /// An actuator's current, by its index among those with springs.
    Current(usize),
    /// A joint's position, by its degree of freedom.
    Target(usize),
}

impl Input {
    /// What a column's name stands for, or why it stands for nothing.
    pub fn of(channel: &str, robot: &Robot) -> Result<Self, String> {
        let sprung = || robot.actuators.iter().filter(|a| a.spec.is_some());
        if let Some(name) = channel.strip_suffix(".current_a") {
            return sprung().position(|a| a.name == name).map(Self::Current).ok_or_else(|| {
                let known: Vec<&str> = sprung().map(|a| a.name.as_str()).collect();
                format!("the robot '{}' has no actuator '{name}'; there are {}", robot.name, known.join(", "))
            });
        }
        let Some(name) = channel.strip_suffix(".target_rad") else {
            return Err("an input is '<actuator>.current_a' or '<joint>.target_rad'".to_owned());
        };
        let joint = robot.moving_joints().find(|j| j.name == name).and_then(|j| j.dof);
        joint.map(Self::Target).ok_or_else(|| {
            let known: Vec<&str> = robot.moving_joints().map(|j| j.name.as_str()).collect();
            format!("the robot '{}' has no moving joint '{name}'; there are {}", robot.name, known.join(", "))
        })
    }
}

/// Internal signals of each actuator, which effects choose their guesses by and what is missing may depend on.
pub(super) const INTERNALS: [&str; 7] = [
    internal::MOTOR_FORCE,
    internal::SCREW_SPEED,
    internal::SPRING_DEFLECTION,
    internal::SPRING_FORCE,
    internal::SCREW_POSITION,
    internal::ROTOR_ANGLE,
    internal::SCREW_FORCE,
];

/// Their values at an instant, of an actuator with a travel in m/rad.
pub(super) fn internals(a: &ActuatorInstant, travel_per_rad: f64) -> [f64; INTERNALS.len()] {
    [
        a.motor_force_n,
        a.rotor_speed_rad_s * travel_per_rad,
        a.deflection_m,
        a.spring_force_n,
        a.extension_m,
        a.rotor_angle_rad,
        a.force_2_n,
    ]
}

/// What is asked of a prediction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked<'a> {
    /// The outputs.
    pub channels: &'a [String],
    /// Whether internal signals and events are, too: most of a fit's simulations are for derivatives of the outputs.
    pub inside: bool,
}

/// What is wrong with a leg, as a model says it.
pub(super) fn model_error(error: LegError) -> ModelError {
    match error {
        LegError::NotFinite { time_s, what } => ModelError::NotFinite { time_s, what },
        other => ModelError::Setup { reason: other.to_string() },
    }
}

/// The grid of a record's simulation.
pub(super) fn grid(record: &Record, step_s: f64) -> Result<Grid, ModelError> {
    let end_s = record.time_s.last().copied().unwrap_or(0.0);
    if end_s / step_s > MOST_STEPS {
        let reason = format!("{}: ends at {end_s:e} s, more than {MOST_STEPS:e} steps", record.name);
        return Err(ModelError::Setup { reason });
    }
    Ok(Grid { start_s: 0.0, step_s, steps: (end_s / step_s - 1e-6).ceil().max(1.0) as usize })
}

/// Runs a case's scenario, already with parameter values in it, to the end of a record.
pub(super) fn predict(
    case: &Case,
    scenario: &Scenario,
    effects: &[Placed],
    record: &Record,
    asked: Asked,
) -> Result<Prediction, ModelError> {
    let wanted: Vec<(&str, Channel)> = asked
        .channels
        .iter()
        .map(|channel| {
            let known = case.channels.iter().find(|(name, _)| name == channel);
            known
                .map(|(name, of)| (name.as_str(), *of))
                .ok_or_else(|| ModelError::UnknownChannel { channel: channel.clone() })
        })
        .collect::<Result<_, _>>()?;
    let mut simulation = case.simulation(scenario, effects).map_err(model_error)?;
    let step_s = scenario.step_s;
    let grid = grid(record, step_s)?;
    give_inputs(&mut simulation, case, record, &grid)?;

    let travel: Vec<f64> = simulation.leg().actuators.iter().map(|a| a.travel_per_rad).collect();
    let mut dense: Vec<Vec<f64>> = wanted.iter().map(|_| Vec::with_capacity(grid.steps + 1)).collect();
    let room = || (0..INTERNALS.len() * travel.len()).map(|_| Vec::with_capacity(grid.steps + 1));
    let mut inside: Vec<Vec<f64>> = if asked.inside { room().collect() } else { Vec::new() };
    let mut events = Vec::new();
    for _ in 0..=grid.steps {
        let step = simulation.advance_watched(|instant| {
            for ((_, channel), values) in wanted.iter().zip(&mut dense) {
                values.push(channel.at(instant));
            }
            for (i, a) in instant.actuators.iter().enumerate().filter(|_| asked.inside) {
                let now = internals(a, travel[i]);
                for (values, value) in inside[INTERNALS.len() * i..].iter_mut().zip(now) {
                    values.push(value);
                }
            }
        });
        step.map_err(model_error)?;
        let faults = simulation.events().iter().filter(|e| asked.inside && e.level() == EventLevel::Error);
        for event in faults {
            events.push(format!("{:.4} s: {} {}", event.time_s, event.subject, event.text));
        }
    }
    let outputs = wanted
        .iter()
        .zip(dense)
        .map(|((name, _), mut values)| {
            let (place, ending) = name.split_once('.').unwrap_or(("", name));
            for stage in simulation.sensor_stages(place).iter().filter(|s| s.concerns(ending)) {
                stage.apply(&mut values, step_s);
            }
            Signal { channel: (*name).to_owned(), values: sample(&values, &grid, &record.time_s, 0.0) }
        })
        .collect();
    let names = simulation.leg().actuators.iter().flat_map(|a| INTERNALS.map(|n| format!("{}.{n}", a.name)));
    let internals = names
        .zip(inside)
        .map(|(channel, values)| Signal { channel, values: sample(&values, &grid, &record.time_s, 0.0) })
        .collect();
    let steps = (grid.steps * travel.len()) as u64;
    Ok(Prediction { outputs, internals, events, steps })
}

/// Puts a record's input columns in the place of the controller's commands.
fn give_inputs(
    simulation: &mut Simulation,
    case: &Case,
    record: &Record,
    grid: &Grid,
) -> Result<(), ModelError> {
    for input in &record.inputs {
        match Input::of(&input.channel, &case.robot) {
            Ok(Input::Current(actuator)) => {
                let stages = simulation.laws(actuator).map_or(&[][..], |laws| &laws.command_stages);
                // The leapfrog's velocities belong to the middles between the steps.
                let around = Grid { start_s: grid.start_s - 0.5 * grid.step_s, ..*grid };
                let commands = mean_per_step(&record.time_s, &input.values, record.hold, stages, &around);
                simulation.give_currents(actuator, commands);
            }
            Ok(Input::Target(dof)) => {
                simulation.give_target(dof, record.time_s.clone(), input.values.clone());
            }
            Err(reason) => {
                return Err(ModelError::Setup { reason: format!("column '{}': {reason}", input.channel) });
            }
        }
    }
    Ok(())
}
