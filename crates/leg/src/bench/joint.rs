//! A joint of a robot with its drive: its columns, and what was seen of it.

use sealegs_actuator::bench::BenchModel;
use sealegs_actuator::bench::TEMPERATURE;
use sealegs_model::{Excitation, SignalRange};

/// A joint with its drive.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    pub name: String,
    pub slides: bool,
    pub model: BenchModel,
    /// Where each of the drive's parameters is among the robot's.
    pub at: Vec<usize>,
}

/// Which column of a joint a channel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    Position,
    Speed,
}

impl Joint {
    /// The column that commands it.
    pub fn command(&self) -> String {
        format!("{}.{}", self.name, if self.slides { "force_n" } else { "torque_nm" })
    }

    /// What that column is called on a bench of the drive alone.
    pub fn input(&self) -> &'static str {
        if self.slides { "motor_force_n" } else { "joint_torque_nm" }
    }

    /// Values of the drive's parameters, out of those of the robot's.
    pub fn own(&self, values: &[f64]) -> Vec<f64> {
        self.at.iter().map(|i| values[*i]).collect()
    }

    /// What a column is called.
    pub fn channel(&self, column: Column) -> String {
        let what = match (column, self.slides) {
            (Column::Position, false) => "angle_rad",
            (Column::Position, true) => "position_m",
            (Column::Speed, false) => "speed_rad_s",
            (Column::Speed, true) => "speed_m_s",
        };
        format!("{}.{what}", self.name)
    }

    /// What a column is called on a bench of the drive alone.
    pub fn at_drive(&self, column: Column) -> &'static str {
        match (column, self.slides) {
            (Column::Position, false) => "joint_angle_rad",
            (Column::Position, true) => "position_m",
            (Column::Speed, false) => "speed_rad_s",
            (Column::Speed, true) => "speed_m_s",
        }
    }

    /// What was seen at this joint, by the names of the drive's own bench.
    pub fn seen(&self, seen: &Excitation) -> Excitation {
        let prefix = format!("{}.", self.name);
        let columns = [Column::Position, Column::Speed];
        let measured = columns.into_iter().filter(|c| seen.measured.contains(&self.channel(*c)));
        // A joint's thermometer is not fed to its drive: nothing may be asked to follow it.
        let own = seen.ranges.iter().filter_map(|r| Some((r.name.strip_prefix(&prefix)?, r)));
        let own = own.filter(|(name, _)| *name != TEMPERATURE);
        let ranges = own.map(|(name, range)| SignalRange {
            name: if self.command() == range.name { self.input() } else { name }.to_owned(),
            ..range.clone()
        });
        Excitation {
            measured: measured.map(|c| self.at_drive(c).to_owned()).collect(),
            ranges: ranges.collect(),
            sample_period_s: seen.sample_period_s,
        }
    }
}
