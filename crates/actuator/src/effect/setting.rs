//! What an effect is asked to fit into: the kind of actuator, the bench and how hard it was driven.

use crate::plant::Winding;
use sealegs_model::{Excitation, Parameter, Scale, internal};
use std::f64::consts::TAU;

/// Linear (N, m) or rotary (N m, rad at the output).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActuatorKind {
    /// Forces in N, lengths in m.
    Linear,
    /// Torques in N m, angles in rad, at the output.
    Rotary,
}

/// What the input of the runs at hand is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// No run is known: an effect may belong to any command.
    Unknown,
    /// A motor current.
    Current,
    /// A motor force or torque.
    Effort,
    /// A voltage at the motor.
    Voltage,
    /// The goal of a servo's own loop.
    Goal,
}

/// A kind of quantity whose unit depends on whether the actuator is linear or rotary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Force or torque.
    Force,
    /// Position or angle.
    Length,
    /// Speed.
    Speed,
    /// Force per length.
    Stiffness,
    /// Force per cubed length.
    CubicStiffness,
    /// Force per speed.
    Damping,
    /// Force per squared speed.
    QuadraticDrag,
    /// Force per acceleration.
    Inertia,
}

impl Quantity {
    /// Suffix of a parameter's name, and the unit as printed.
    fn unit(self, kind: ActuatorKind) -> (&'static str, &'static str) {
        use ActuatorKind::{Linear, Rotary};
        match (self, kind) {
            (Self::Force, Linear) => ("_n", "N"),
            (Self::Force, Rotary) => ("_nm", "N m"),
            (Self::Length, Linear) => ("_m", "m"),
            (Self::Length, Rotary) => ("_rad", "rad"),
            (Self::Speed, Linear) => ("_m_s", "m/s"),
            (Self::Speed, Rotary) => ("_rad_s", "rad/s"),
            (Self::Stiffness, Linear) => ("_n_m", "N/m"),
            (Self::Stiffness, Rotary) => ("_nm_rad", "N m/rad"),
            (Self::CubicStiffness, Linear) => ("_n_m3", "N/m^3"),
            (Self::CubicStiffness, Rotary) => ("_nm_rad3", "N m/rad^3"),
            (Self::Damping, Linear) => ("_n_s_m", "N s/m"),
            (Self::Damping, Rotary) => ("_nm_s_rad", "N m s/rad"),
            (Self::QuadraticDrag, Linear) => ("_n_s2_m2", "N s^2/m^2"),
            (Self::QuadraticDrag, Rotary) => ("_nm_s2_rad2", "N m s^2/rad^2"),
            (Self::Inertia, Linear) => ("_mass_kg", "kg"),
            (Self::Inertia, Rotary) => ("_inertia_kg_m2", "kg m^2"),
        }
    }
}

/// The actuator, the bench and the excitation that an effect is to suit.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Linear or rotary.
    pub kind: ActuatorKind,
    /// Nominal stiffness, N/m; where there is no spring the greatest force over the travel that was seen, a scale.
    pub stiffness: f64,
    /// Whether there is a spring.
    pub has_spring: bool,
    /// Whether a drive without a spring turns a load that may move on its own.
    pub has_load: bool,
    /// What the input is.
    pub command: CommandKind,
    /// The winding of a motor whose command is a voltage or a goal, or may be one.
    pub winding: Option<Winding>,
    /// Nominal total moving mass `m_T`, kg.
    pub total_mass: f64,
    /// Nominal unsprung mass of the actuator, kg; 0 where it is not known.
    pub unsprung_mass: f64,
    /// Screw travel per rotor angle, m/rad.
    pub travel_per_rad: f64,
    /// Motor force per unit of command: N/A for a current, 1 for a force, N/V for a voltage and for a goal.
    pub force_per_command: f64,
    /// Arm of the output lever, m, where there is a pendulum.
    pub output_arm_m: Option<f64>,
    /// Whether link 2 moves.
    pub output_moves: bool,
    /// Whether link 1, the spring side, is held by a bench.
    pub base_is_held: bool,
    /// The runs at hand.
    pub seen: Excitation,
}

impl Setting {
    /// A unit actuator of which nothing is known: for what a card says whatever the setting.
    #[must_use]
    pub fn unknown() -> Self {
        Self {
            kind: ActuatorKind::Linear,
            stiffness: 1.0,
            has_spring: true,
            has_load: false,
            command: CommandKind::Unknown,
            winding: None,
            total_mass: 1.0,
            unsprung_mass: 0.0,
            travel_per_rad: 1.0,
            force_per_command: 1.0,
            output_arm_m: None,
            output_moves: false,
            base_is_held: true,
            seen: Excitation::default(),
        }
    }

    /// The measured output channels.
    #[must_use]
    pub fn measured(&self) -> &[String] {
        &self.seen.measured
    }

    /// Greatest motor force seen, N.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.seen.peak_or(internal::MOTOR_FORCE, 1.0)
    }

    /// Greatest screw speed seen, m/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.seen.peak_or(internal::SCREW_SPEED, self.length() * (self.stiffness / self.total_mass).sqrt())
    }

    /// Greatest spring deflection seen, m; where there is no spring the greatest travel.
    #[must_use]
    pub fn length(&self) -> f64 {
        if !self.has_spring {
            return self.travel();
        }
        self.seen.peak_or(internal::SPRING_DEFLECTION, self.force() / self.stiffness)
    }

    /// How far the output moved, from one end to the other, m.
    #[must_use]
    pub fn travel(&self) -> f64 {
        self.moved(internal::SCREW_POSITION).unwrap_or(1.0)
    }

    /// How many turns the rotor made, from one end to the other; `None` where it was not seen to turn.
    #[must_use]
    pub fn turns(&self) -> Option<f64> {
        self.moved(internal::ROTOR_ANGLE).map(|angle| angle / TAU)
    }

    /// How far a signal went, from one end to the other; `None` where it was not seen to move.
    fn moved(&self, signal: &str) -> Option<f64> {
        self.seen.range(signal).map(|r| r.max - r.min).filter(|far| *far > 0.0)
    }

    /// Whether a bridge drives the motor with a duty, or may do so.
    #[must_use]
    pub fn has_bridge(&self) -> bool {
        let may = matches!(self.command, CommandKind::Voltage | CommandKind::Goal | CommandKind::Unknown);
        may && !self.has_spring && self.winding.is_some()
    }

    /// Greatest command seen, in its own unit.
    #[must_use]
    pub fn command(&self) -> f64 {
        self.force() / self.force_per_command
    }

    /// A stiffness of the transmission of a drive without a spring, guessed at so many times the greatest force over the travel
    /// that was seen, searched from 3 to 3000 of them. Below the least the load would swing on it over a third of the travel; beyond the
    /// greatest it yields by less than a three thousandth.
    #[must_use]
    pub fn transmission_stiffness(&self, guess: f64) -> Parameter {
        let k = self.stiffness;
        let p = self.magnitude("stiffness", Quantity::Stiffness, guess * k, 3.0 * k, 3000.0 * k);
        with_neutral(p, f64::INFINITY)
    }

    /// The unit of a quantity here.
    #[must_use]
    pub fn unit(&self, quantity: Quantity) -> &'static str {
        quantity.unit(self.kind).1
    }

    /// Natural frequency of the locked actuator, Hz.
    #[must_use]
    pub fn natural_hz(&self) -> f64 {
        (self.stiffness / self.total_mass).sqrt() / std::f64::consts::TAU
    }

    /// Half the sampling frequency, Hz.
    #[must_use]
    pub fn nyquist_hz(&self) -> f64 {
        if self.seen.sample_period_s > 0.0 { 0.5 / self.seen.sample_period_s } else { 500.0 }
    }

    /// A delay in s that vanishes at 0, guessed from the sampling period.
    #[must_use]
    pub fn delay(&self) -> Parameter {
        let period = self.seen.sample_period_s.max(1e-4);
        let delay = Parameter::new("delay_s", "s", 1.5 * period, 0.0, 100.0 * period);
        with_starts(Parameter { neutral: Some(0.0), typical: period, ..delay }, [5.0 * period, 15.0 * period])
    }

    /// A parameter `<symbol><unit suffix>` that vanishes at 0: bounds 0 to `max`, first guess `guess`.
    #[must_use]
    pub fn amount(&self, symbol: &str, quantity: Quantity, guess: f64, max: f64) -> Parameter {
        let (suffix, unit) = quantity.unit(self.kind);
        Parameter {
            neutral: Some(0.0),
            typical: guess,
            ..Parameter::new(format!("{symbol}{suffix}"), unit, guess, 0.0, max)
        }
    }

    /// A positive parameter whose order of magnitude is unknown: searched in ratios.
    #[must_use]
    pub fn magnitude(&self, symbol: &str, quantity: Quantity, guess: f64, min: f64, max: f64) -> Parameter {
        let (suffix, unit) = quantity.unit(self.kind);
        magnitude(&format!("{symbol}{suffix}"), unit, guess, min, max)
    }
}

/// A positive parameter in a unit that does not depend on the kind of actuator, searched in ratios.
#[must_use]
pub fn magnitude(name: &str, unit: &str, guess: f64, min: f64, max: f64) -> Parameter {
    Parameter {
        scale: Scale::Logarithmic,
        typical: 0.3 * guess,
        ..Parameter::new(name, unit, guess, min, max)
    }
}

/// The ratio of what there is to what is stated, from a fifth to five times it: searched from a guess and another start, on the
/// other side of 1, where its effect vanishes.
#[must_use]
pub(super) fn ratio_to_stated(name: &str, guess: f64, other: f64) -> Parameter {
    let ratio = Parameter { typical: 0.05, ..magnitude(name, "", guess, 0.2, 5.0) };
    with_starts(with_neutral(ratio, 1.0), [other])
}

/// A parameter with further values worth starting from.
#[must_use]
pub fn with_starts(mut parameter: Parameter, starts: impl IntoIterator<Item = f64>) -> Parameter {
    parameter.starts = starts.into_iter().filter(|s| (parameter.min..=parameter.max).contains(s)).collect();
    parameter
}

/// A parameter with the value at which its effect vanishes.
#[must_use]
pub fn with_neutral(mut parameter: Parameter, neutral: f64) -> Parameter {
    parameter.neutral = Some(neutral);
    parameter
}
