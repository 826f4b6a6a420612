//! Simulated experiments: what a logger would write of a bench, through sensors with errors.

use super::{BenchModel, channel};
use crate::excitation::{Profile, gaussian};
use sealegs_model::{InputHold, Model, ModelError, Record, Signal};

/// A sensor on one channel. What is zero or `None` is absent.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// The output channel that it measures.
    pub channel: String,
    /// Its own sampling frequency, Hz, where it is slower than the logger: its last sample is held.
    pub rate_hz: Option<f64>,
    /// Standard deviation of white noise on every sample, in the channel's unit.
    pub noise_std: f64,
    /// Size of a count, in the channel's unit; values are rounded to whole counts.
    pub resolution: f64,
    /// How old a sample's value is, s.
    pub delay_s: f64,
}

impl Sensor {
    /// A sensor without errors.
    #[must_use]
    pub fn ideal(channel: &str) -> Self {
        Self { channel: channel.to_owned(), rate_hz: None, noise_std: 0.0, resolution: 0.0, delay_s: 0.0 }
    }

    fn check(&self) -> Result<(), ModelError> {
        let bad = |what: &str, value: f64, admitted| {
            Err(ModelError::BadParameter {
                name: format!("{what} of sensor {}", self.channel),
                value,
                admitted,
            })
        };
        for (what, value) in
            [("noise", self.noise_std), ("resolution", self.resolution), ("delay", self.delay_s)]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return bad(what, value, "zero or positive, and finite");
            }
        }
        match self.rate_hz {
            Some(rate) if !(rate > 0.0 && rate.is_finite()) => bad("rate", rate, "positive and finite"),
            _ => Ok(()),
        }
    }
}

/// How an experiment is run and logged.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The record's name.
    pub name: String,
    /// The input column: `current_a`, `motor_force_n` or `motor_torque_nm`.
    pub input: String,
    /// The logger's sampling frequency, Hz; the command is held from each of its samples to the next.
    pub rate_hz: f64,
    /// Duration, s; the last sample is at or before it.
    pub duration_s: f64,
    /// Seed of all noise.
    pub seed: u64,
}

/// Most samples of one record: half an hour at 10 kHz and some.
const MOST_SAMPLES: f64 = 2e7;

/// Runs a bench with parameter `values` (in the order of the model's parameters) under a command and records what
/// the `sensors` show. The same seed gives the same bits.
///
/// # Errors
///
/// [`ModelError::BadParameter`] for a number that no sensor or logger has, [`ModelError::UnknownChannel`], or
/// those of [`Model::predict`].
pub fn record(
    model: &BenchModel,
    values: &[f64],
    command: &Profile,
    recording: &Recording,
    sensors: &[Sensor],
) -> Result<Record, ModelError> {
    for (name, value) in [("rate", recording.rate_hz), ("duration", recording.duration_s)] {
        if !(value > 0.0 && value.is_finite()) {
            let name = format!("{name} of {}", recording.name);
            return Err(ModelError::BadParameter { name, value, admitted: "positive and finite" });
        }
    }
    let samples = (recording.duration_s * recording.rate_hz + 1e-9).floor() + 1.0;
    if !(2.0..=MOST_SAMPLES).contains(&samples) {
        let name = format!("number of samples of {}", recording.name);
        return Err(ModelError::BadParameter { name, value: samples, admitted: "2 to 20 million" });
    }
    for sensor in sensors {
        sensor.check()?;
        if !model.predicts(&sensor.channel) {
            return Err(ModelError::UnknownChannel { channel: sensor.channel.clone() });
        }
    }
    let time_s: Vec<f64> = (0..samples as usize).map(|n| n as f64 / recording.rate_hz).collect();
    let input = Signal { channel: recording.input.clone(), values: command.sample(&time_s) };
    let mut record = Record {
        cut: false,
        name: recording.name.clone(),
        time_s,
        hold: InputHold::ZeroOrder,
        inputs: vec![input],
        outputs: Vec::new(),
    };
    let (plant, trace) = model.simulate(values, &record)?;
    let arm_m = model.bench_of(&record.name).arm_m();
    let stiffness = model.spec.coefficients().stiffness;
    for (index, sensor) in sensors.iter().enumerate() {
        // The number of the sensor's own latest sample and the time that it tells of.
        let sample = |t: &f64| match sensor.rate_hz {
            Some(rate) => (t * rate + 1e-9).floor(),
            None => (t * recording.rate_hz).round(),
        };
        let rate = sensor.rate_hz.unwrap_or(recording.rate_hz);
        let numbers: Vec<f64> = record.time_s.iter().map(sample).collect();
        let told: Vec<f64> = numbers.iter().map(|n| n / rate - sensor.delay_s).collect();
        let channels = std::slice::from_ref(&sensor.channel);
        let mut sensed = channel::sense(&plant, trace.clone(), arm_m, stiffness, &told, channels).outputs;
        let Some(mut signal) = sensed.pop() else { continue };
        // Every sensor has its own stream of noise; a held sample keeps its noise.
        let seed = recording.seed.wrapping_add((index as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03));
        for (value, number) in signal.values.iter_mut().zip(&numbers) {
            if sensor.noise_std > 0.0 {
                *value += sensor.noise_std * gaussian(seed, *number as i64);
            }
            if sensor.resolution > 0.0 {
                *value = (*value / sensor.resolution).round() * sensor.resolution;
            }
        }
        record.outputs.push(signal);
    }
    Ok(record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ActuatorSpec;
    use crate::bench::Bench;

    fn run(sensors: &[Sensor], seed: u64) -> Record {
        let spec = ActuatorSpec::preset("thor-linear").expect("preset");
        let model = BenchModel::new(spec, Bench::Locked).expect("good");
        let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
        let command = Profile::Sine { amplitude: 3.0, frequency_hz: 4.0, phase_rad: 0.0 };
        let recording = Recording {
            name: "run".to_owned(),
            input: "current_a".to_owned(),
            rate_hz: 1000.0,
            duration_s: 2.0,
            seed,
        };
        record(&model, &values, &command, &recording, sensors).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn noise_is_seeded_and_of_its_size() {
        let noisy = Sensor { noise_std: 2.0, ..Sensor::ideal("force_1_n") };
        let pair = [noisy.clone(), Sensor { channel: "force_2_n".to_owned(), ..noisy }];
        let (a, b, c) = (run(&pair, 1), run(&pair, 1), run(&pair, 2));
        assert_eq!(a, b);
        assert_ne!(a.outputs, c.outputs);
        let truth = run(&[Sensor::ideal("force_1_n"), Sensor::ideal("force_2_n")], 0);
        let off = |i: usize| -> Vec<f64> {
            a.outputs[i].values.iter().zip(&truth.outputs[i].values).map(|(a, t)| a - t).collect()
        };
        let (first, second) = (off(0), off(1));
        let mean = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / x.len() as f64;
        // 2001 samples: 1.6 % standard error of the rms, 2.2 % of the correlation.
        assert!((mean(&first, &first).sqrt() / 2.0 - 1.0).abs() < 0.06);
        assert!((mean(&first, &second) / 4.0).abs() < 0.08);
    }

    #[test]
    fn analytic_resolution_rate_and_delay() {
        let truth = run(&[Sensor::ideal("motor_angle_rad")], 0).outputs.swap_remove(0).values;
        let with = |sensor: Sensor| run(&[sensor], 0).outputs.swap_remove(0).values;
        let counts = with(Sensor { resolution: 0.5, ..Sensor::ideal("motor_angle_rad") });
        for (got, truth) in counts.iter().zip(&truth) {
            assert!((got - truth).abs() <= 0.25 + 1e-12 && (got / 0.5).fract() == 0.0);
        }
        let slow = with(Sensor { rate_hz: Some(100.0), ..Sensor::ideal("motor_angle_rad") });
        let late = with(Sensor { delay_s: 0.003, ..Sensor::ideal("motor_angle_rad") });
        for n in 20..truth.len() {
            assert!((slow[n] - truth[n - n % 10]).abs() < 1e-9);
            assert!((late[n] - truth[n - 3]).abs() < 1e-9);
        }
    }

    #[test]
    fn bad_sensors_are_refused() {
        let spec = ActuatorSpec::preset("thor-linear").expect("preset");
        let model = BenchModel::new(spec, Bench::Locked).expect("good");
        let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
        let command = Profile::Step { amplitude: 1.0, start_s: 0.0, end_s: None };
        let good = Recording {
            name: "run".to_owned(),
            input: "current_a".to_owned(),
            rate_hz: 1000.0,
            duration_s: 0.1,
            seed: 0,
        };
        let refused = |recording: &Recording, sensor: Sensor| {
            record(&model, &values, &command, recording, &[sensor]).is_err()
        };
        let force = Sensor::ideal("force_1_n");
        assert!(!refused(&good, force.clone()));
        assert!(refused(&good, Sensor::ideal("joint_angle_rad")));
        assert!(refused(&good, Sensor { noise_std: -1.0, ..force.clone() }));
        assert!(refused(&good, Sensor { rate_hz: Some(0.0), ..force.clone() }));
        assert!(refused(&Recording { rate_hz: f64::NAN, ..good.clone() }, force.clone()));
        assert!(refused(&Recording { duration_s: 1e9, ..good.clone() }, force.clone()));
        assert!(refused(&Recording { input: "volts".to_owned(), ..good }, force));
    }
}
