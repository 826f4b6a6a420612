//! What a record tells a drive, and feeds it with, over the steps of a grid.

use crate::plant::{Feed, Grid, Plant, after, at_step_starts, mean_per_step};
use sealegs_model::columns::{ENABLE, FEEDFORWARD, GOAL_SPEED, GRAVITY, SUPPLY, TEMPERATURE};
use sealegs_model::{InputHold, Record};
use std::borrow::Cow;

/// The times from which each command of a record was in force, for values of a model's base parameters by their names: its own
/// time stamp, or, for a logger that stamps a row at the end of the period in which its command was held (`command_lead`), the
/// time stamp before; `clock_skew` periods later.
#[must_use]
pub fn command_times(record: &Record, value: impl Fn(&str) -> f64) -> Cow<'_, [f64]> {
    let time_s = &record.time_s;
    let lead = record.hold == InputHold::ZeroOrder && value("command_lead") > 0.5;
    let skew_s = value("clock_skew") * record.mean_period_s();
    match lead {
        false if skew_s == 0.0 => Cow::Borrowed(time_s),
        false => time_s.iter().map(|t| t + skew_s).collect(),
        true => {
            let first = time_s[0] - (time_s[1] - time_s[0]);
            std::iter::once(&first).chain(&time_s[..time_s.len() - 1]).map(|t| t + skew_s).collect()
        }
    }
}

/// What a [`Feed`] borrows.
#[derive(Debug, Clone, Default)]
pub struct Fed {
    commands: Vec<f64>,
    added: Option<Vec<f64>>,
    goal_speed: Option<Vec<f64>>,
    feedforward: Option<Vec<f64>>,
    enable: Option<Vec<f64>>,
    supply_v: Option<Vec<f64>>,
    temperature_c: Option<Vec<f64>>,
}

impl Fed {
    /// What a record feeds a drive with: its `command`, in force from the times `told` ([`command_times`]), and what `beside`
    /// finds by the names of a bench's columns ([`sealegs_model::columns::BESIDE`]).
    pub fn of<'a>(
        plant: &Plant,
        record: &'a Record,
        (told, command): (&[f64], &[f64]),
        beside: impl Fn(&str) -> Option<&'a [f64]> + Copy,
        grid: &Grid,
    ) -> Self {
        let stages = &plant.laws.command_stages;
        let held = |time_s: &[f64], values| mean_per_step(time_s, values, InputHold::ZeroOrder, &[], grid);
        let driven = |name: &str| beside(name).filter(|_| plant.winding.is_some() || plant.servo.is_some());
        let samples = plant.servo.is_some_and(|servo| servo.period_s.is_some());
        let commanded = |values: &[f64]| match samples && record.hold == InputHold::ZeroOrder {
            true => at_step_starts(told, values, stages, grid),
            false => mean_per_step(told, values, record.hold, stages, grid),
        };
        let commands_torque = plant.servo.is_some_and(|servo| servo.commands_torque());
        let beside_goal = |name: &str| beside(name).filter(|_| commands_torque).map(commanded);
        // The signal that switches the drive on comes as late as the command, the supply is measured.
        let switched = |on| {
            let (late, _) = after(stages, told, command);
            held(&late, on)
        };
        let felt = plant.laws.rotor_friction.iter().any(|law| law.feels_temperature());
        Self {
            commands: commanded(command),
            // It follows the joint, and is computed many times between two rows.
            added: GRAVITY
                .into_iter()
                .find_map(beside)
                .filter(|_| plant.servo.is_none() && plant.winding.is_none())
                .map(|added| mean_per_step(&record.time_s, added, InputHold::Linear, &[], grid)),
            goal_speed: beside_goal(GOAL_SPEED),
            feedforward: beside_goal(FEEDFORWARD),
            enable: driven(ENABLE).map(switched),
            supply_v: driven(SUPPLY).map(|volts| held(&record.time_s, volts)),
            temperature_c: beside(TEMPERATURE).filter(|_| felt).map(|t| held(&record.time_s, t)),
        }
    }

    /// For a simulation.
    #[must_use]
    pub fn feed(&self) -> Feed<'_> {
        Feed {
            commands: &self.commands,
            added: self.added.as_deref(),
            goal_speed: self.goal_speed.as_deref(),
            feedforward: self.feedforward.as_deref(),
            enable: self.enable.as_deref(),
            supply_v: self.supply_v.as_deref(),
            temperature_c: self.temperature_c.as_deref(),
        }
    }
}
