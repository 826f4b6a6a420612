//! What a record tells a drive, and feeds it with, over the steps of a grid.

use super::{ENABLE, SUPPLY, TEMPERATURE, command_times};
use crate::plant::{Feed, Grid, Plant, mean_per_step};
use sealegs_model::{InputHold, Record};
use std::borrow::Cow;

/// When a logger's commands were in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamps {
    /// Whether a row is stamped at the end of the period in which its command was held.
    pub lead: bool,
    /// By how much the commands' clock is late, s.
    pub skew_s: f64,
}

impl Stamps {
    /// Those of a record, for values of a model's base parameters by their names.
    pub fn of(record: &Record, value: impl Fn(&str) -> f64) -> Self {
        Self {
            lead: record.hold == InputHold::ZeroOrder && value("command_lead") > 0.5,
            skew_s: value("clock_skew") * record.mean_period_s(),
        }
    }
}

/// What a [`Feed`] borrows.
#[derive(Debug, Clone, Default)]
pub struct Fed {
    commands: Vec<f64>,
    enable: Option<Vec<f64>>,
    supply_v: Option<Vec<f64>>,
    temperature_c: Option<Vec<f64>>,
}

impl Fed {
    /// What a record feeds a drive with: its `command` and what `beside` finds by the names of a bench's columns
    /// ([`sealegs_model::columns::BESIDE`]).
    pub fn of<'a>(
        plant: &Plant,
        (record, stamps): (&'a Record, Stamps),
        command: &[f64],
        beside: impl Fn(&str) -> Option<&'a [f64]>,
        grid: &Grid,
    ) -> Self {
        let own = &record.time_s;
        let time_s: Cow<'_, [f64]> = if stamps.lead || stamps.skew_s != 0.0 {
            Cow::Owned(command_times(own, stamps.lead, stamps.skew_s))
        } else {
            Cow::Borrowed(own)
        };
        let stages = &plant.laws.command_stages;
        let held = |time_s: &[f64], values| mean_per_step(time_s, values, InputHold::ZeroOrder, &[], grid);
        let driven = |name: &str| beside(name).filter(|_| plant.winding.is_some());
        // The signal that switches the drive on comes as late as the command, the supply is measured.
        let (mut late, mut unused) = (time_s.to_vec(), command.to_vec());
        stages.iter().for_each(|stage| stage.apply(&mut late, &mut unused));
        let felt = plant.laws.rotor_friction.iter().any(|law| law.feels_temperature());
        Self {
            commands: mean_per_step(&time_s, command, record.hold, stages, grid),
            enable: driven(ENABLE).map(|on| held(&late, on)),
            supply_v: driven(SUPPLY).map(|volts| held(own, volts)),
            temperature_c: beside(TEMPERATURE).filter(|_| felt).map(|t| held(own, t)),
        }
    }

    /// For a simulation.
    #[must_use]
    pub fn feed(&self) -> Feed<'_> {
        Feed {
            commands: &self.commands,
            enable: self.enable.as_deref(),
            supply_v: self.supply_v.as_deref(),
            temperature_c: self.temperature_c.as_deref(),
        }
    }
}
