//! The columns of a bench: which the model takes and predicts, and how they follow from the motion.

use super::Bench;
use crate::Kind;
use crate::plant::{Plant, Trace, sample};
use sealegs_model::{ModelError, Prediction, Record, Signal, internal};

/// Input columns; a record has exactly one of them.
pub const INPUTS: [&str; 3] = ["current_a", "motor_force_n", "motor_torque_nm"];

/// Output columns of any bench.
pub const OUTPUTS: [&str; 8] = [
    "force_1_n",
    "force_2_n",
    "motor_angle_rad",
    "spring_deflection_m",
    "joint_angle_rad",
    "output_torque_nm",
    "spring_torque_nm",
    "spring_deflection_rad",
];

pub(super) fn predicts(channel: &str, kind: Kind, bench: &Bench) -> bool {
    match channel {
        "motor_angle_rad" => true,
        "joint_angle_rad" => matches!(bench, Bench::Pendulum(_)),
        "force_1_n" | "force_2_n" | "spring_deflection_m" => kind == Kind::Linear,
        "output_torque_nm" | "spring_torque_nm" | "spring_deflection_rad" => kind == Kind::Rotary,
        _ => false,
    }
}

/// The one input column of a record.
pub(super) fn input_of(record: &Record) -> Result<&Signal, ModelError> {
    let mut inputs = record.inputs.iter().filter(|s| INPUTS.contains(&s.channel.as_str()));
    match (inputs.next(), inputs.next()) {
        (Some(input), None) => Ok(input),
        (first, second) => Err(ModelError::NoInput {
            record: record.name.clone(),
            wanted: INPUTS.map(str::to_owned).to_vec(),
            found: first.into_iter().chain(second).map(|s| s.channel.clone()).collect(),
        }),
    }
}

/// The times from which each command was in force: its own time stamp, or, for a logger that stamps a row
/// at the end of the period in which its command was held (`lead`), the time stamp before; `skew_s` later.
pub(super) fn command_times(time_s: &[f64], lead: bool, skew_s: f64) -> Vec<f64> {
    if !lead {
        return time_s.iter().map(|t| t + skew_s).collect();
    }
    let first = time_s[0] - (time_s[1] - time_s[0]);
    std::iter::once(&first).chain(&time_s[..time_s.len() - 1]).map(|t| t + skew_s).collect()
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
    let internals = internals(plant, &trace, arm_m, time_s);
    let outputs = channels
        .iter()
        .map(|channel| {
            let (dense, scale) = match channel.as_str() {
                "force_1_n" | "output_torque_nm" => (&mut trace.force_1, 1.0),
                "force_2_n" => (&mut trace.force_2, 1.0),
                "motor_angle_rad" => (&mut trace.screw_position, 1.0 / plant.travel_per_rad),
                "joint_angle_rad" => (&mut trace.link_2_position, 1.0 / arm_m),
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
    Prediction { outputs, internals, events: Vec::new() }
}

/// The deflection's own values, which the screw's extension stands for where nothing else moves.
fn deflection(trace: &mut Trace) -> &mut Vec<f64> {
    if trace.deflection.is_empty() { &mut trace.screw_position } else { &mut trace.deflection }
}

fn internals(plant: &Plant, trace: &Trace, arm_m: f64, time_s: &[f64]) -> Vec<Signal> {
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
    add(internal::SPRING_DEFLECTION, sample(trace.spring_deflection(), grid, time_s, 0.0));
    add(internal::MOTOR_FORCE, sample(&trace.motor_force, grid, time_s, 0.0));
    if !trace.link_2_position.is_empty() {
        let angle = sample(&trace.link_2_position, grid, time_s, 0.0);
        add(internal::JOINT_ANGLE, angle.iter().map(|x| x / arm_m).collect());
    }
    signals
}
