//! A joint of a robot with its drive: its columns, and what was seen of it.

use sealegs_actuator::bench::BenchModel;
use sealegs_actuator::effect::{CATALOGUE, Setting, is_of_joint};
use sealegs_model::columns::BESIDE;
use sealegs_model::{Excitation, Model, ModelError, Record, SignalRange};

/// A joint with its drive.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    pub name: String,
    pub slides: bool,
    /// Whether a spring is between rotor and link.
    pub sprung: bool,
    /// What the URDF states of viscous damping, where it is not the drive's own: behind a spring, N m s/rad.
    pub damping: f64,
    /// Effects that a bench of its drive has and this joint cannot.
    pub refused: Vec<String>,
    pub model: BenchModel,
    /// What its torque accelerates at the posture zero while all others are free to move, as the robot is stated, kg m^2 (kg).
    pub least_inertia: f64,
    /// Where each of the drive's parameters is among the robot's.
    pub at: Vec<usize>,
}

/// Which column of a joint a channel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    Position,
    Speed,
    /// The rotor's own angle.
    Motor,
    /// What passes from the drive to the link.
    Effort,
    Deflection,
    /// Inferred from the deflection.
    SpringTorque,
}

impl Column {
    /// Of motion, which every joint has.
    pub const MOTION: [Self; 3] = [Self::Position, Self::Speed, Self::Motor];
}

/// Effects of the catalogue that a drive with a spring cannot have at a joint.
pub(super) fn refused_with_spring() -> Vec<String> {
    let refused = CATALOGUE.iter().filter(|effect| !is_of_joint(**effect));
    refused.map(|effect| effect.card(&Setting::unknown()).id).collect()
}

impl Joint {
    /// The columns that may command it, the drive's own first, and what each is called on a bench of the drive alone.
    pub fn commands(&self) -> Vec<(String, &'static str)> {
        let effort = if self.slides { "force_n" } else { "torque_nm" };
        let all = [
            ("position_rad", "position_rad"),
            ("voltage_v", "voltage_v"),
            (effort, self.effort()),
            ("current_a", "current_a"),
        ];
        let taken = all.into_iter().filter(|(_, input)| self.model.inputs().contains(input));
        taken.map(|(what, input)| (format!("{}.{what}", self.name), input)).collect()
    }

    /// The column that commands it where no record says which.
    pub fn command(&self) -> String {
        self.commands().swap_remove(0).0
    }

    /// What that column is called on a bench of the drive alone.
    pub fn input(&self) -> &'static str {
        self.commands()[0].1
    }

    /// What an effort is called on a bench of the drive alone.
    pub fn effort(&self) -> &'static str {
        match (self.slides, self.sprung) {
            (true, _) => "motor_force_n",
            (false, true) => "motor_torque_nm",
            (false, false) => "joint_torque_nm",
        }
    }

    /// Inertia of its rotor at the joint, as the drive's file has it, kg m^2 (kg).
    pub fn rotor_inertia(&self) -> f64 {
        self.model.spec().coefficients().reflected_inertia
    }

    /// Whether a record commands a goal of the drive's own loop.
    pub fn follows_goal(&self, record: &Record) -> bool {
        matches!(self.command_in(record), Ok(Some(("position_rad", _))))
    }

    /// The columns that its sensors can show.
    pub fn columns(&self) -> impl Iterator<Item = Column> + use<> {
        let of_spring = match (self.sprung, self.slides) {
            (false, _) => &[][..],
            (true, true) => &[Column::Deflection],
            (true, false) => &[Column::Deflection, Column::SpringTorque],
        };
        Column::MOTION.into_iter().chain([Column::Effort]).chain(of_spring.iter().copied())
    }

    /// The command in a record with its name on a bench of the drive alone; `None` for a joint that is told nothing.
    ///
    /// # Errors
    ///
    /// [`ModelError::NoInput`] for two commands at once.
    pub fn command_in<'a>(
        &self,
        record: &'a Record,
    ) -> Result<Option<(&'static str, &'a [f64])>, ModelError> {
        let mut told = self.told_in(record);
        match (told.next(), told.next()) {
            (first, None) => Ok(first.map(|(_, input, values)| (input, values))),
            (first, second) => Err(ModelError::NoInput {
                record: record.name.clone(),
                wanted: self.commands().into_iter().map(|(name, _)| name).collect(),
                found: first.into_iter().chain(second).map(|(name, ..)| name).collect(),
            }),
        }
    }

    /// Another column of a record that commands the joint, where this one does.
    pub fn commanded_beside(&self, record: &Record, channel: &str) -> Option<String> {
        let commands = self.commands().iter().any(|(name, _)| name == channel);
        self.told_in(record).map(|(name, ..)| name).find(|name| commands && name != channel)
    }

    /// All commands in a record, each with its name on a bench of the drive alone.
    fn told_in<'a>(
        &self,
        record: &'a Record,
    ) -> impl Iterator<Item = (String, &'static str, &'a [f64])> + use<'a> {
        self.commands().into_iter().filter_map(|(name, input)| {
            let values = record.input(&name)?;
            Some((name, input, values))
        })
    }

    /// What a record holds beside the command, by the name of a bench's column: of this joint, or of all.
    pub fn beside<'a>(&self, record: &'a Record, column: &str) -> Option<&'a [f64]> {
        record.input(&format!("{}.{column}", self.name)).or_else(|| record.input(column))
    }

    /// Whether the drive reads a column, command or beside it.
    pub fn reads(&self, channel: &str) -> bool {
        let own = channel.strip_prefix(&self.name).and_then(|rest| rest.strip_prefix('.'));
        BESIDE.contains(&own.unwrap_or(channel)) || self.commands().iter().any(|(name, _)| name == channel)
    }

    /// Values of the drive's parameters, out of those of the robot's.
    pub fn own(&self, values: &[f64]) -> Vec<f64> {
        self.at.iter().map(|i| values[*i]).collect()
    }

    /// What a column is called.
    pub fn channel(&self, column: Column) -> String {
        let at_drive = self.at_drive(column);
        format!("{}.{}", self.name, at_drive.strip_prefix("joint_").unwrap_or(at_drive))
    }

    /// What a column is called on a bench of the drive alone.
    pub fn at_drive(&self, column: Column) -> &'static str {
        match (column, self.slides) {
            (Column::Position, false) => "joint_angle_rad",
            (Column::Position, true) => "position_m",
            (Column::Speed, false) => "speed_rad_s",
            (Column::Speed, true) => "speed_m_s",
            (Column::Motor, _) => "motor_angle_rad",
            (Column::Effort, false) => "output_torque_nm",
            // Where a spring carries a mass, its two sides feel different forces.
            (Column::Effort, true) if self.sprung => "force_1_n",
            (Column::Effort, true) => "force_2_n",
            (Column::Deflection, false) => "spring_deflection_rad",
            (Column::Deflection, true) => "spring_deflection_m",
            (Column::SpringTorque, _) => "spring_torque_nm",
        }
    }

    /// What was seen at this joint, by the names of the drive's own bench.
    pub fn seen(&self, seen: &Excitation) -> Excitation {
        let prefix = format!("{}.", self.name);
        let measured = self.columns().filter(|c| seen.measured.contains(&self.channel(*c)));
        let commands = self.commands();
        let name = |range: &SignalRange| {
            let command = commands.iter().find(|(name, _)| *name == range.name).map(|(_, input)| *input);
            let beside = || BESIDE.contains(&range.name.as_str()).then_some(range.name.as_str());
            command.or_else(|| range.name.strip_prefix(&prefix)).or_else(beside).map(str::to_owned)
        };
        Excitation {
            measured: measured.map(|c| self.at_drive(c).to_owned()).collect(),
            ranges: seen
                .ranges
                .iter()
                .filter_map(|range| Some(SignalRange { name: name(range)?, ..range.clone() }))
                .collect(),
            sample_period_s: seen.sample_period_s,
        }
    }
}
