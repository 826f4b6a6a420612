//! What the sensors and the logger make of a run: noise, counts, gain, bias, time stamps.

use super::Rig;
use super::draws::Draws;
use super::individual::{Individual, Stamp};
use super::rough::Rough;
use crate::{Beyond, Outputs};
use sealegs_actuator::ActuatorSpec;
use sealegs_model::{InputHold, Record, Signal};
use std::f64::consts::TAU;

/// Noise of a load cell, one standard deviation, N.
const FORCE_NOISE_N: f64 = 2.0;
/// Counts of the rotor's encoder per turn.
const ROTOR_COUNTS: f64 = 4096.0;
/// Counts of the joint's encoder per turn.
const JOINT_COUNTS: f64 = 65536.0;
/// Noise of the deflection sensor, one standard deviation, m.
const DEFLECTION_NOISE_M: f64 = 1e-6;
/// Rows of the longest burst of stale samples.
const LONGEST_BURST: f64 = 8.0;

/// How many times coarser rough encoders are: 64 counts a turn at the rotor, 1024 at the joint.
const COARSER: f64 = 64.0;
/// Share of rows with a spike in the load cell of link 1, where there are some, and their size, N.
const SPIKES: (f64, (f64, f64)) = (3e-3, (300.0, 500.0));
/// Share of repeated rows where there are some.
const REPEATED: f64 = 0.03;

/// Counts a turn of the encoders of rotor and joint.
fn counts(rough: &[Rough]) -> (f64, f64) {
    let coarser = if rough.contains(&Rough::CoarseEncoders) { COARSER } else { 1.0 };
    (ROTOR_COUNTS / coarser, JOINT_COUNTS / coarser)
}

/// The sensors of a bench: column and one standard deviation of its error. An encoder rounds to whole counts: an
/// error that is uniform within a count.
#[must_use]
pub(super) fn sensors(rig: Rig, deflection_sensor: bool, rough: &[Rough]) -> Vec<(&'static str, f64)> {
    let counted = |counts: f64| TAU / counts / 12f64.sqrt();
    let (rotor, joint) = counts(rough);
    let mut all = vec![("force_1_n", FORCE_NOISE_N)];
    if !rough.contains(&Rough::OneLoadCell) {
        all.push(("force_2_n", FORCE_NOISE_N));
    }
    all.push(("motor_angle_rad", counted(rotor)));
    if deflection_sensor {
        all.push(("spring_deflection_m", DEFLECTION_NOISE_M));
    }
    if rig == Rig::Pendulum {
        all.push(("joint_angle_rad", counted(joint)));
    }
    all
}

/// What stands in the file of a run.
pub(super) struct Logger<'a> {
    pub rig: Rig,
    pub spec: &'a ActuatorSpec,
    pub individual: &'a Individual,
    pub deflection_sensor: bool,
    pub beyond: Option<Beyond>,
    pub rough: &'a [Rough],
    pub seed: u64,
    pub period_s: f64,
}

impl Logger<'_> {
    /// The record of a run's true signals under a command.
    pub fn write(&self, name: &str, command: &[f64], truth: &Outputs) -> Record {
        let time_s: Vec<f64> = (0..command.len()).map(|n| n as f64 * self.period_s).collect();
        let stale = self.stale(name, command.len());
        let (rotor, joint) = counts(self.rough);
        let outputs = sensors(self.rig, self.deflection_sensor, self.rough)
            .into_iter()
            .map(|(channel, noise_std)| {
                let mut draws = Draws::of(self.seed, &format!("{name} {channel}"));
                let mut values: Vec<f64> = match channel {
                    "force_1_n" => self.load_cell(0, &truth.force_1, &time_s, &mut draws),
                    "force_2_n" => self.load_cell(1, &truth.force_2, &time_s, &mut draws),
                    "spring_deflection_m" => {
                        truth.deflection.iter().map(|x| x + noise_std * draws.normal()).collect()
                    }
                    "motor_angle_rad" => encoder(&truth.extension, self.spec.ratio(), rotor),
                    _ => encoder(&truth.link_2, self.rig.arm_m(), joint),
                };
                if channel == "force_1_n" && self.rough.contains(&Rough::Spikes) {
                    self.glitch(name, &mut values);
                }
                for n in 1..values.len() {
                    if stale[n] {
                        values[n] = values[n - 1];
                    }
                }
                Signal { channel: channel.to_owned(), values }
            })
            .collect();
        let logged = match self.individual.stamp {
            Stamp::Start => command.to_vec(),
            // The row closes the period in which the command before acted.
            Stamp::End => std::iter::once(0.0).chain(command[..command.len() - 1].iter().copied()).collect(),
        };
        Record {
            cut: false,
            name: name.to_owned(),
            time_s,
            hold: InputHold::ZeroOrder,
            inputs: vec![Signal { channel: "current_a".to_owned(), values: logged }],
            outputs,
        }
    }

    fn load_cell(&self, cell: usize, force: &[f64], time_s: &[f64], draws: &mut Draws) -> Vec<f64> {
        let (gain, bias) = (self.individual.gain[cell], self.individual.bias_n[cell]);
        let shown = |f: f64, t: f64, noise: f64| {
            let felt = match self.beyond {
                Some(Beyond::DeadBandLoadCell { band_n }) if cell == 0 => {
                    f.signum() * (f.abs() - band_n).max(0.0)
                }
                _ => f,
            };
            let value = gain * felt + bias + FORCE_NOISE_N * noise;
            match self.beyond {
                Some(Beyond::ClippedLoadCell { limit_n }) if cell == 0 => value.clamp(-limit_n, limit_n),
                Some(Beyond::DriftingBias { amplitude_n, period_s }) if cell == 0 => {
                    value + amplitude_n * (TAU * t / period_s).sin()
                }
                _ => value,
            }
        };
        force.iter().zip(time_s).map(|(f, t)| shown(*f, *t, draws.normal())).collect()
    }

    /// Adds spikes of either sign, at least a few rows apart.
    fn glitch(&self, name: &str, values: &mut [f64]) {
        let mut draws = Draws::of(self.seed, &format!("{name} spikes"));
        let (share, (low, high)) = SPIKES;
        let mut n = 0;
        loop {
            // On average one in every 1 / share rows.
            n += 10 + draws.between(0.0, 2.0 * (1.0 / share - 10.0)) as usize;
            let Some(value) = values.get_mut(n) else { break };
            *value += draws.between(low, high) * draws.one_of(&[-1.0, 1.0]);
        }
    }

    /// Which rows repeat the one before.
    fn stale(&self, name: &str, rows: usize) -> Vec<bool> {
        let mut stale = vec![false; rows];
        let share = match self.beyond {
            Some(Beyond::StaleSamples { share }) => share,
            _ if self.rough.contains(&Rough::RepeatedRows) => REPEATED,
            _ => 0.0,
        };
        if share > 0.0 {
            let mut draws = Draws::of(self.seed, &format!("{name} stale"));
            // Of `mean` rows each, so that the share of all rows comes out.
            let mean = 0.5 * (1.0 + LONGEST_BURST);
            let mut n = 0;
            while n < rows {
                n += 1 + (draws.between(0.0, 2.0) * mean * (1.0 - share) / share) as usize;
                let burst = 1 + draws.between(0.0, LONGEST_BURST) as usize;
                stale.iter_mut().skip(n).take(burst).for_each(|s| *s = true);
                n += burst;
            }
        }
        stale
    }
}

/// An encoder's angle in rad for a travel, rounded to whole counts.
fn encoder(travel: &[f64], per_rad: f64, counts: f64) -> Vec<f64> {
    let count = TAU / counts;
    travel.iter().map(|x| (x / per_rad / count).round() * count).collect()
}
