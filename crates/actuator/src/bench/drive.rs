//! What drives the motor on a bench: current, effort, voltage, or a servo's goal; and how effects are told of it.

use super::channel::{self, Side};
use super::{Bench, BenchModel};
use crate::effect::Effect;
use crate::effect::{ActuatorKind, CommandKind, PwmDeadZone, Setting, TransportDelay, limit_current};
use crate::plant::{Link, Plant, Servo, Winding};
use crate::spec::Feedback;
use crate::{Coefficients, Kind};
use sealegs_model::{Excitation, ModelError, SignalRange, internal};

impl BenchModel {
    /// The input columns that the actuator can take.
    pub(super) fn inputs_of(&self) -> &'static [&'static str] {
        channel::inputs(if self.spec.has_torque_loop() {
            Side::Impedance
        } else if self.spec.servo.is_some() {
            Side::Servo
        } else if self.spec.is_rigid() && self.spec.motor.winding_resistance_ohm.is_some() {
            Side::Voltage
        } else if self.spec.is_rigid() {
            Side::Rigid
        } else {
            Side::Elastic
        })
    }

    /// The winding where the command is a voltage or a goal; `None` where the file does not give what it takes, or the loop commands
    /// a torque.
    fn winding(&self, c: &Coefficients) -> Option<Winding> {
        if self.spec.has_torque_loop() {
            return None;
        }
        let (resistance_ohm, supply_v) = (self.spec.motor.winding_resistance_ohm?, self.spec.motor.supply_v?);
        Some(Winding { force_per_current: c.force_constant, resistance_ohm, supply_v })
    }

    /// The setting that effects choose their guesses by.
    pub(super) fn setting(&self, seen: &Excitation) -> Setting {
        let c = self.spec.coefficients();
        let rigid = self.spec.is_rigid();
        let named = |name: &str| seen.ranges.iter().any(|r| r.name.starts_with(name));
        let command = if ["motor_force_n", "motor_torque_nm", "joint_torque_nm"].into_iter().any(named) {
            CommandKind::Effort
        } else if named("voltage_v") {
            CommandKind::Voltage
        } else if named("position_rad") || (self.spec.servo.is_some() && !named("current_a")) {
            CommandKind::Goal
        } else if named("current_a") {
            CommandKind::Current
        } else {
            CommandKind::Unknown
        };
        let winding = self.winding(&c);
        let load = self.bench.links().1;
        let travel = seen.range(internal::SCREW_POSITION).map_or(0.0, |r: &SignalRange| r.max - r.min);
        let scale = seen.peak_or(internal::MOTOR_FORCE, 1.0) / if travel > 0.0 { travel } else { 1.0 };
        Setting {
            kind: match self.spec.kind {
                Kind::Linear => ActuatorKind::Linear,
                Kind::Rotary => ActuatorKind::Rotary,
            },
            stiffness: if rigid { scale } else { c.stiffness },
            has_spring: !rigid,
            has_load: rigid && load.mass_kg() > 0.0 && load.mass_kg().is_finite(),
            command,
            winding,
            total_mass: c.total_mass() + if rigid { load.mass_kg() } else { 0.0 },
            unsprung_mass: c.unsprung_mass,
            travel_per_rad: self.spec.ratio(),
            force_per_command: match (command, winding) {
                (CommandKind::Effort, _) => 1.0,
                (CommandKind::Voltage | CommandKind::Goal, Some(w)) => w.force_per_current / w.resistance_ohm,
                (CommandKind::Goal, None) => 1.0,
                _ => c.force_constant,
            },
            output_arm_m: match self.bench {
                Bench::Pendulum(rig) => Some(rig.arm_m),
                _ => None,
            },
            output_moves: rigid || load != Link::Fixed,
            base_is_held: self.bench.links().0 == Link::Fixed,
            seen: seen.clone(),
        }
    }

    /// Puts what the command on a channel drives into a plant; `value` looks a base parameter up.
    pub(super) fn drive(
        &self,
        plant: &mut Plant,
        input: &str,
        value: &dyn Fn(&str, f64) -> f64,
    ) -> Result<(), ModelError> {
        let constant = value("force_constant", self.spec.coefficients().force_constant);
        plant.command_offset = value("input_offset", 0.0);
        match input {
            "current_a" => plant.force_per_command = constant,
            "position_rad" if self.spec.has_torque_loop() => {
                plant.force_per_command = value("motor_gain", 1.0);
                self.close_loop(plant, constant, None)?;
            }
            "voltage_v" | "position_rad" => {
                let stated = self.spec.motor.winding_resistance_ohm;
                let resistance_ohm = value("winding_resistance", stated.unwrap_or(f64::NAN));
                if !(resistance_ohm > 0.0 && resistance_ohm.is_finite()) {
                    return Err(ModelError::BadParameter {
                        name: "winding_resistance".to_owned(),
                        value: resistance_ohm,
                        admitted: "positive and finite where the command is a voltage or a goal",
                    });
                }
                let supply_v = self.spec.motor.supply_v.unwrap_or(f64::NAN);
                plant.drive_by(Winding { force_per_current: constant, resistance_ohm, supply_v });
                if input == "position_rad" {
                    self.close_loop(plant, constant, Some(supply_v))?;
                }
            }
            _ => plant.force_per_command = value("motor_gain", 1.0),
        }
        Ok(())
    }

    /// The servo's loop with what else its drive does, in the order of the signal's way.
    fn close_loop(&self, plant: &mut Plant, constant: f64, supply_v: Option<f64>) -> Result<(), ModelError> {
        let Some(servo) = &self.spec.servo else {
            let reason = format!("{} has no [servo] that could follow a position_rad", self.spec.id);
            return Err(ModelError::Setup { reason });
        };
        plant.servo = Some(Servo {
            // Of the two kinds of gains one is there.
            proportional: servo.proportional_nm_per_rad.unwrap_or(servo.proportional_per_rad),
            derivative: servo.derivative_nm_s_per_rad + servo.derivative_s_per_rad,
            integral: servo.integral_per_rad_s,
            limit: match supply_v {
                Some(_) => servo.duty_limit,
                None => servo.torque_limit_nm.unwrap_or(f64::INFINITY),
            },
            dead_band: servo.dead_band_rad,
            feedback_delay_s: servo.feedback_delay_s,
            sees_rotor: servo.feedback == Feedback::Motor,
            period_s: servo.rate_hz.map(|rate| 1.0 / rate),
            goal_offset: plant.command_offset,
            supply_v,
        });
        // The offset is the goal's: none is left for the voltage that the loop makes of it.
        plant.command_offset = 0.0;
        if servo.command_delay_s > 0.0 {
            TransportDelay.install(&[servo.command_delay_s], None, plant);
        }
        if servo.duty_dead_zone > 0.0 {
            PwmDeadZone.install(&[servo.duty_dead_zone], None, plant);
        }
        if let Some(limit_a) = servo.current_limit_a {
            limit_current(plant, constant * limit_a);
        }
        Ok(())
    }
}
