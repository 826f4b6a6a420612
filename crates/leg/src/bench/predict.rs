//! A robot's prediction for one record: its run, what the sensors show of it, and the signals inside.

use super::RobotModel;
use super::joint::{Column, Joint};
use super::observed::Pulls;
use super::parts::Asked;
use super::simulate::JointTrace;
use sealegs_actuator::bench::{Fed, command_times, search_step_without_springs};
use sealegs_actuator::plant::{Grid, Plant, sample};
use sealegs_model::{ModelError, Prediction, Record, Signal, internal};
use std::borrow::Cow;
use std::sync::Arc;

/// Share of the model's own step that play is followed with at least: teeth of 2000 N m/rad before 0.002 kg m^2 turn by 0.1
/// radian of their oscillation in it.
const OF_PLAY: f64 = 0.2;

/// A robot that has moved as a record's commands say.
pub(super) struct Ran {
    drives: Vec<Plant>,
    traces: Vec<Arc<JointTrace>>,
    grid: Grid,
    pulls: Option<Arc<Pulls>>,
}

impl RobotModel {
    /// The drives with parameter values in place, each told what it is in the record.
    fn drives(&self, values: &[f64], record: &Record) -> Result<Vec<Plant>, ModelError> {
        let plant = |joint: &Joint| {
            let input = joint.command_in(record)?.map_or(joint.effort(), |(input, _)| input);
            let mut plant = joint.model.plant(&joint.own(values), input)?;
            let gain = self.gains.get(&record.name).and_then(|gains| gains.get(&joint.name));
            if let Some((servo, gain)) = plant.servo.as_mut().zip(gain) {
                *servo = servo.times(*gain);
            }
            Ok(plant)
        };
        self.joints.iter().map(plant).collect()
    }

    /// A wanted step, s, made short enough to follow what springs and transmissions do. One that yields evenly is taken implicitly:
    /// what is faster than the model's own step shows leaves no trace in a joint's motion.
    fn step_with(&self, wanted_s: f64, drives: &[Plant]) -> f64 {
        let follow = |plant: &Plant| {
            let least = if plant.laws.spring_is_linear() { self.step_s } else { OF_PLAY * self.step_s };
            plant.step_following(wanted_s, least)
        };
        let step_s = drives.iter().map(follow).fold(wanted_s, f64::min);
        self.joints.iter().zip(drives).fold(step_s, |step_s, (joint, plant)| {
            // Beside a transmission that yields or has play the loop pushes the rotor alone.
            let inertia = if plant.rigid.is_some() { joint.least_inertia } else { joint.rotor_inertia() };
            plant.servo.map_or(step_s, |servo| servo.step_following(step_s, inertia))
        })
    }

    /// The motion over a record.
    ///
    /// # Errors
    ///
    /// As [`RobotModel::ran_from`].
    pub(super) fn ran(&self, values: &[f64], record: &Record) -> Result<Ran, ModelError> {
        self.ran_from(values, record, &self.start(values, record)?)
    }

    /// The motion over a record from this position and speed of every joint.
    ///
    /// # Errors
    ///
    /// [`ModelError::BadParameter`] for a record of fewer than two rows, and those of [`super::simulate::Machine::run`].
    pub(super) fn ran_from(
        &self,
        values: &[f64],
        record: &Record,
        start: &[(f64, f64)],
    ) -> Result<Ran, ModelError> {
        if record.len() < 2 {
            return Err(ModelError::BadParameter {
                name: format!("number of rows of {}", record.name),
                value: record.len() as f64,
                admitted: "at least 2",
            });
        }
        let drives = self.drives(values, record)?;
        let period_s = record.mean_period_s();
        let fewer = self.steps_per_sample.map_or(0.0, |n| search_step_without_springs(period_s, n));
        let step_s = self.step_with(self.step_s.max(fewer), &drives);
        let grid = Grid::covering(&record.time_s, step_s);
        let value =
            |name: &str| self.parameters.iter().position(|p| p.name == name).map_or(0.0, |i| values[i]);
        let told = command_times(record, value);
        let told = |i: usize, plant: &Plant| {
            let joint = &self.joints[i];
            Ok(match joint.command_in(record)? {
                Some((_, command)) => {
                    Fed::of(plant, record, (&told, command), |column| joint.beside(record, column), &grid)
                }
                None => Fed::default(),
            })
        };
        let pulls = self.observed.as_ref().and_then(|observed| observed.pulls(record, &grid));
        let asked = Asked { record, values, start, pulls: pulls.as_deref(), grid, told: &told };
        let (drives, traces) = self.moved(&asked, drives)?;
        Ok(Ran { drives, traces, grid, pulls })
    }

    /// What the sensors show of a motion at a record's time stamps.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownChannel`].
    pub(super) fn outputs(
        &self,
        ran: &Ran,
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        let (grid, time_s) = (&ran.grid, &record.time_s);
        let mut outputs = Vec::with_capacity(channels.len());
        for channel in channels {
            let Some((i, column)) = self.find(channel) else {
                return Err(ModelError::UnknownChannel { channel: channel.clone() });
            };
            let (joint, drive, trace) = (&self.joints[i], &ran.drives[i], &ran.traces[i]);
            let (dense, scale, ahead_s) = match column {
                Column::Position => (Cow::from(&trace.position), 1.0, 0.0),
                Column::Speed => (Cow::from(&trace.speed), 1.0, 0.0),
                Column::Motor => (Cow::from(trace.rotor_position()), 1.0 / drive.travel_per_rad, 0.0),
                // It is known over steps, and stands at their ends.
                Column::Effort => (Cow::from(&trace.load), 1.0, 0.5 * grid.step_s),
                Column::Deflection => (Cow::from(trace.deflection()), 1.0, 0.0),
                // The logger's torque is the deflection times the stiffness that it was told.
                Column::SpringTorque => {
                    (Cow::from(trace.deflection()), joint.model.spec().spring.stiffness(), 0.0)
                }
            };
            let at_drive = joint.at_drive(column);
            let stages: Vec<_> = drive.laws.sensor_stages.iter().filter(|s| s.concerns(at_drive)).collect();
            let mut values = if stages.is_empty() {
                sample(&dense, grid, time_s, ahead_s)
            } else {
                let mut dense = dense.into_owned();
                stages.iter().for_each(|stage| stage.apply(&mut dense, grid.step_s));
                sample(&dense, grid, time_s, ahead_s)
            };
            if scale != 1.0 {
                values.iter_mut().for_each(|value| *value *= scale);
            }
            outputs.push(Signal { channel: channel.clone(), values });
        }
        let steps = (grid.steps * ran.drives.len()) as u64;
        Ok(Prediction { outputs, steps, ..Prediction::default() })
    }

    /// The signals inside at a record's time stamps, by joint; and what is missing there, under an observer that shows it.
    pub(super) fn internals(&self, ran: &Ran, record: &Record) -> Vec<Signal> {
        let (grid, time_s) = (&ran.grid, &record.time_s);
        let mut internals = Vec::with_capacity(7 * ran.traces.len());
        for (joint, trace) in self.joints.iter().zip(&ran.traces) {
            for (name, dense) in [
                (internal::SCREW_SPEED, trace.rotor_speed()),
                (internal::SCREW_POSITION, trace.rotor_position()),
                (internal::SCREW_FORCE, &trace.load),
                (internal::MOTOR_FORCE, &trace.motor),
                (internal::JOINT_ANGLE, &trace.position),
                (internal::JOINT_SPEED, &trace.speed),
            ] {
                let channel = format!("{}.{name}", joint.name);
                internals.push(Signal { channel, values: sample(dense, grid, time_s, 0.0) });
            }
        }
        let shown = ran.pulls.as_ref().filter(|_| self.observed.as_ref().is_some_and(|o| o.shows_missing()));
        if let Some(pulls) = shown {
            for (i, trace) in ran.traces.iter().enumerate() {
                let channel = format!("{}.{}rotor", self.joints[i].name, internal::MISSING);
                let damping = ran.drives[i].damping;
                let values = pulls.missing(i, trace, damping, time_s, grid);
                internals.push(Signal { channel, values });
            }
        }
        internals
    }
}
