//! `sealegs bench`: an actuator on a test bench, driven by a command, as CSV, recording and report.

mod excitation;
mod recording;
mod report;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sealegs::BenchBuilder;
use sealegs::actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs::actuator::excitation::Profile;
use sealegs::actuator::{ActuatorSpec, Kind};
use sealegs::model::{InputHold, Model, Prediction, Record, Signal};

use crate::failure::{OrBadInput, bad_input};
use crate::output::Destination;

/// Run an actuator on a test bench.
#[derive(Args)]
pub struct BenchArguments {
    /// The bench
    bench: Rig,
    /// Actuator: a preset or a file
    #[arg(long, default_value = "thor-linear")]
    actuator: String,
    /// Spring setting, as the actuator takes it (`compliant`, `80mm`)
    #[arg(long)]
    spring: Option<String>,
    /// Command, several add up: `step`, `sine`, `chirp`, `noise`, `multisine` or `table` with its numbers, for
    /// example `chirp,amplitude=2,from_hz=0.1,to_hz=100,duration_s=20,logarithmic=true`,
    /// `noise,rms=1,bandwidth_hz=150,seed=1` or `table,file=my.csv,column=current_a`
    #[arg(long, value_name = "SHAPE,KEY=VALUE...")]
    excitation: Vec<String>,
    /// What the command is
    #[arg(long, value_enum)]
    input: Option<Input>,
    /// Length, s
    #[arg(long, default_value_t = 20.0, value_name = "S")]
    duration: f64,
    /// Samples of command and sensors per second
    #[arg(long, default_value_t = 1000.0, value_name = "HZ")]
    rate: f64,
    /// How the command behaves between its samples
    #[arg(long, value_enum, default_value_t = Hold::ZeroOrder)]
    hold: Hold,
    /// Standard deviation of noise on forces and torques, N or N m
    #[arg(long, default_value_t = 0.0)]
    force_noise: f64,
    /// Step of the readings of forces and torques, N or N m; zero for none
    #[arg(long, default_value_t = 0.0)]
    force_resolution: f64,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Greatest step of the integration, s
    #[arg(long, default_value_t = sealegs::actuator::bench::DEFAULT_STEP_S, value_name = "S")]
    step: f64,
    /// Write the samples as CSV with the columns of a campaign (`-` for standard output)
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write a recording for Rerun
    #[arg(long, value_name = "FILE.rrd")]
    rrd: Option<PathBuf>,
    /// Write a report
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// The benches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Rig {
    /// Both ends held: high impedance
    Locked,
    /// Spring side held, screw side on the lever of a pendulum: moving output
    Pendulum,
}

/// What the command is.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Input {
    /// Motor current, A
    Current,
    /// Motor force (N) or torque (N m)
    Effort,
}

/// How the command behaves between its samples.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Hold {
    /// Constant until the next
    ZeroOrder,
    /// A straight line to the next
    Linear,
}

/// A finished run on a bench.
pub struct BenchRun {
    /// The model that ran.
    pub model: BenchModel,
    /// Time and command.
    pub record: Record,
    /// What the sensors showed.
    pub outputs: Vec<Signal>,
    /// What is inside, and what the reader should know.
    pub prediction: Prediction,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input: an unknown actuator, setting or shape, a number that makes no sense, a file that cannot be written.
pub fn run(arguments: &BenchArguments) -> anyhow::Result<u8> {
    let csv = Destination::optional(arguments.csv.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    if arguments.rrd.as_deref() == Some(Path::new("-")) {
        return Err(bad_input("--rrd -: a recording goes to a file"));
    }
    let done = simulate(arguments)?;
    if let Some(destination) = csv {
        destination.write(csv_text(&done)?.as_bytes())?;
    }
    if let Some(destination) = rrd {
        if let Some(part) = destination.part() {
            recording::write(&done, part)?;
        }
        destination.finish()?;
    }
    if let Some(destination) = report {
        destination.write(report::html(&done)?.as_bytes())?;
    }
    let to_stdout = |p: &Option<PathBuf>| p.as_deref() == Some(Path::new("-"));
    if !to_stdout(&arguments.csv) && !to_stdout(&arguments.report) {
        write!(std::io::stdout().lock(), "{}", summary(&done))?;
    }
    Ok(0)
}

fn simulate(arguments: &BenchArguments) -> anyhow::Result<BenchRun> {
    let positive = |name: &str, value: f64| {
        let good = value > 0.0 && value.is_finite();
        good.then_some(()).ok_or_else(|| bad_input(format!("--{name} {value}: must be positive and finite")))
    };
    positive("duration", arguments.duration)?;
    positive("rate", arguments.rate)?;
    positive("step", arguments.step)?;
    for (name, value) in
        [("force-noise", arguments.force_noise), ("force-resolution", arguments.force_resolution)]
    {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(bad_input(format!("--{name} {value}: must be zero or positive, and finite")));
        }
    }
    let samples = arguments.duration * arguments.rate;
    if !(2.0..=2e7).contains(&samples) {
        return Err(bad_input(format!(
            "--duration times --rate is {samples}: 2 to 20 000 000 samples are possible"
        )));
    }
    let mut spec = ActuatorSpec::load(&arguments.actuator, None).or_bad_input()?;
    if let Some(setting) = &arguments.spring {
        spec = spec.with_spring_setting(setting).or_bad_input()?;
    }
    let bench = match arguments.bench {
        Rig::Locked => Bench::Locked,
        Rig::Pendulum => Bench::Pendulum(PendulumRig::default()),
    };
    let channel = match (arguments.input, spec.kind) {
        (None | Some(Input::Current), _) => "current_a",
        (Some(Input::Effort), Kind::Linear) => "motor_force_n",
        (Some(Input::Effort), Kind::Rotary) => "motor_torque_nm",
    };
    let per_command = if channel == "current_a" { 1.0 } else { spec.coefficients().force_constant };
    let profiles = if arguments.excitation.is_empty() {
        usual(arguments, per_command)
    } else {
        arguments
            .excitation
            .iter()
            .map(|text| excitation::parse(text, channel))
            .collect::<anyhow::Result<_>>()?
    };
    let time_s: Vec<f64> = (0..samples as usize).map(|i| i as f64 / arguments.rate).collect();
    let mut command = vec![0.0; time_s.len()];
    for profile in &profiles {
        command.iter_mut().zip(&time_s).for_each(|(c, t)| *c += profile.at(*t));
    }
    let hold = match arguments.hold {
        Hold::ZeroOrder => InputHold::ZeroOrder,
        Hold::Linear => InputHold::Linear,
    };
    let builder = BenchBuilder::of_spec(spec, bench).step_s(arguments.step).hold(hold);
    let ideal = builder.run(channel, time_s, command)?;
    let outputs = ideal.prediction.outputs.iter().enumerate();
    let outputs = outputs.map(|(i, s)| sensed(arguments, s, i)).collect();
    Ok(BenchRun { model: ideal.model, record: ideal.record, outputs, prediction: ideal.prediction })
}

/// The excitations of the dissertation's two identifications, in A or in the unit of the motor's effort.
fn usual(arguments: &BenchArguments, per_ampere: f64) -> Vec<Profile> {
    match arguments.bench {
        Rig::Locked => vec![
            Profile::Chirp {
                amplitude: 2.0 * per_ampere,
                from_hz: 0.1,
                to_hz: 150f64.min(0.4 * arguments.rate),
                duration_s: arguments.duration,
                logarithmic: true,
            },
            Profile::Noise { rms: per_ampere, bandwidth_hz: 150f64.min(0.4 * arguments.rate), seed: 1 },
        ],
        // 841 N on THOR: 3.5 A, which the dissertation calls 3 A.
        Rig::Pendulum => vec![Profile::Noise {
            rms: 3.5 * per_ampere,
            bandwidth_hz: 150f64.min(0.4 * arguments.rate),
            seed: 1,
        }],
    }
}

/// A channel with the noise and the resolution of its sensor.
fn sensed(arguments: &BenchArguments, ideal: &Signal, index: usize) -> Signal {
    let is_force = ideal.channel.ends_with("_n") || ideal.channel.ends_with("_nm");
    let mut values = ideal.values.clone();
    if is_force && arguments.force_noise > 0.0 {
        // White at the sampling rate: band-limited to half of it and taken at the samples.
        let seed = arguments.seed.wrapping_mul(1000).wrapping_add(index as u64);
        let noise = Profile::Noise { rms: arguments.force_noise, bandwidth_hz: 0.5, seed };
        values.iter_mut().enumerate().for_each(|(i, v)| *v += noise.at(i as f64));
    }
    if is_force && arguments.force_resolution > 0.0 {
        values
            .iter_mut()
            .for_each(|v| *v = arguments.force_resolution * (*v / arguments.force_resolution).round());
    }
    Signal { channel: ideal.channel.clone(), values }
}

fn csv_text(done: &BenchRun) -> anyhow::Result<String> {
    let mut text = String::from("time_s");
    let columns: Vec<&Signal> = done.record.inputs.iter().chain(&done.outputs).collect();
    for column in &columns {
        write!(text, ",{}", column.channel)?;
    }
    text.push('\n');
    for (i, t) in done.record.time_s.iter().enumerate() {
        write!(text, "{t}")?;
        for column in &columns {
            write!(text, ",{}", column.values[i])?;
        }
        text.push('\n');
    }
    Ok(text)
}

/// Root mean square, least and greatest value.
pub fn extremes(values: &[f64]) -> (f64, f64, f64) {
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (rms, low, high)
}

fn summary(done: &BenchRun) -> String {
    let mut out = format!("{}, spring {}\n", done.model.name(), done.model.spec().spring.setting());
    for signal in done.record.inputs.iter().chain(&done.outputs) {
        let (rms, low, high) = extremes(&signal.values);
        out.push_str(&format!("  {:22} rms {rms:12.5}  from {low:12.5} to {high:12.5}\n", signal.channel));
    }
    for event in &done.prediction.events {
        out.push_str(&format!("  {event}\n"));
    }
    out
}
