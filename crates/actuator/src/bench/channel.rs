//! The columns of a bench: which the model takes and predicts, and how they follow from the motion.

use super::Bench;
use crate::plant::{Link, Plant, Trace, sample};
use crate::{ActuatorSpec, Kind};
pub use sealegs_model::columns::{ENABLE, INPUTS, OUTPUTS, SUPPLY, TEMPERATURE};
use sealegs_model::{ModelError, Prediction, Record, Signal, internal};

/// What a motor can be commanded by.
pub(super) enum Side {
    /// With a series spring: current and effort.
    Elastic,
    /// Without one.
    Rigid,
    /// And with a winding that is known.
    Voltage,
    /// And with its own position loop.
    Servo,
    /// Or with one that commands a torque.
    Impedance,
}

/// The input columns in the order of preference.
pub(super) fn inputs(side: Side) -> &'static [&'static str] {
    match side {
        Side::Elastic => &["current_a", "motor_force_n", "motor_torque_nm"],
        Side::Rigid => &["current_a", "motor_force_n", "motor_torque_nm", "joint_torque_nm"],
        Side::Voltage => &["voltage_v", "current_a", "motor_force_n", "motor_torque_nm", "joint_torque_nm"],
        Side::Impedance => {
            &["position_rad", "current_a", "motor_force_n", "motor_torque_nm", "joint_torque_nm"]
        }
        Side::Servo => {
            &["position_rad", "voltage_v", "current_a", "motor_force_n", "motor_torque_nm", "joint_torque_nm"]
        }
    }
}

pub(super) fn predicts(channel: &str, spec: &ActuatorSpec, bench: &Bench) -> bool {
    let (linear, rigid) = (spec.kind == Kind::Linear, spec.is_rigid());
    let pendulum = matches!(bench, Bench::Pendulum(_));
    let free = matches!(bench, Bench::Free { .. });
    match channel {
        "motor_angle_rad" => true,
        "joint_angle_rad" => pendulum || (!linear && free),
        "position_m" => linear && free,
        "speed_m_s" => linear && free && rigid,
        "speed_rad_s" => rigid && (pendulum || !linear),
        "force_2_n" => linear,
        "force_1_n" | "spring_deflection_m" => linear && !rigid,
        "output_torque_nm" => !linear,
        "spring_torque_nm" | "spring_deflection_rad" => !linear && !rigid,
        _ => false,
    }
}

/// The one input column of a record out of those that are `wanted`.
pub(super) fn input_of<'a>(record: &'a Record, wanted: &[&str]) -> Result<&'a Signal, ModelError> {
    let mut inputs = record.inputs.iter().filter(|s| wanted.contains(&s.channel.as_str()));
    match (inputs.next(), inputs.next()) {
        (Some(input), None) => Ok(input),
        (first, second) => Err(ModelError::NoInput {
            record: record.name.clone(),
            wanted: wanted.iter().map(|w| (*w).to_owned()).collect(),
            found: first.into_iter().chain(second).map(|s| s.channel.clone()).collect(),
        }),
    }
}

/// What the sensors show at the time stamps.
pub(super) fn sense(
    plant: &Plant,
    mut trace: Trace,
    arm_m: f64,
    nominal_stiffness: f64,
    time_s: &[f64],
    channels: &[String],
) -> Prediction {
    let grid = trace.grid;
    let outputs = channels
        .iter()
        .map(|channel| {
            let (dense, scale) = match channel.as_str() {
                "output_torque_nm" if plant.rigid.is_some() => (&mut trace.force_2, 1.0),
                "force_1_n" | "output_torque_nm" => (&mut trace.force_1, 1.0),
                "force_2_n" => (&mut trace.force_2, 1.0),
                "motor_angle_rad" => (&mut trace.screw_position, 1.0 / plant.travel_per_rad),
                "joint_angle_rad" | "position_m" if plant.rigid.is_some() => {
                    (&mut trace.screw_position, 1.0 / arm_m)
                }
                "joint_angle_rad" | "position_m" => (&mut trace.link_2_position, 1.0 / arm_m),
                "speed_m_s" | "speed_rad_s" if plant.is_parted() => (&mut trace.link_2_speed, 1.0 / arm_m),
                "speed_m_s" | "speed_rad_s" => (&mut trace.screw_speed, 1.0 / arm_m),
                // The logger's torque is the deflection times the stiffness that it was told.
                "spring_torque_nm" => (deflection(&mut trace), nominal_stiffness),
                _ => (deflection(&mut trace), 1.0),
            };
            let stages: Vec<_> = plant.laws.sensor_stages.iter().filter(|s| s.concerns(channel)).collect();
            let mut values = if stages.is_empty() {
                sample(dense, &grid, time_s, 0.0)
            } else {
                let mut dense = dense.clone();
                for stage in stages {
                    stage.apply(&mut dense, grid.step_s);
                }
                sample(&dense, &grid, time_s, 0.0)
            };
            if scale != 1.0 {
                values.iter_mut().for_each(|v| *v *= scale);
            }
            Signal { channel: channel.clone(), values }
        })
        .collect();
    Prediction { outputs, steps: grid.steps as u64, ..Prediction::default() }
}

/// The deflection's own values, which the screw's extension stands for where nothing else moves.
fn deflection(trace: &mut Trace) -> &mut Vec<f64> {
    if trace.deflection.is_empty() { &mut trace.screw_position } else { &mut trace.deflection }
}

/// What the bench knows beside what its sensors show, at the time stamps.
pub(super) fn internals(plant: &Plant, trace: &Trace, arm_m: f64, time_s: &[f64]) -> Vec<Signal> {
    let grid = &trace.grid;
    let mut signals = Vec::with_capacity(8);
    let mut add = |name: &str, values: Vec<f64>| {
        signals.push(Signal { channel: name.to_owned(), values });
    };
    let speed = sample(&trace.screw_speed, grid, time_s, 0.0);
    let position = sample(&trace.screw_position, grid, time_s, 0.0);
    let per_travel = 1.0 / plant.travel_per_rad;
    add(internal::ROTOR_ANGLE, position.iter().map(|y| y * per_travel).collect());
    add(internal::ROTOR_SPEED, speed.iter().map(|v| v * per_travel).collect());
    add(internal::SCREW_SPEED, speed);
    add(internal::SCREW_POSITION, position);
    add(internal::SCREW_FORCE, sample(&trace.force_2, grid, time_s, 0.0));
    if plant.rigid.is_none() {
        add(internal::SPRING_DEFLECTION, sample(trace.spring_deflection(), grid, time_s, 0.0));
    }
    add(internal::MOTOR_FORCE, sample(&trace.motor_force, grid, time_s, 0.0));
    let joint = match plant.rigid {
        Some(Link::Pendulum { .. }) => &trace.screw_position,
        _ => &trace.link_2_position,
    };
    if !joint.is_empty() {
        let angle = sample(joint, grid, time_s, 0.0);
        add(internal::JOINT_ANGLE, angle.iter().map(|x| x / arm_m).collect());
    }
    signals
}
