//! `sealegs export`: a bench or a leg as a file of other people's simulators, and what that file cannot hold.

use crate::failure::{OrBadInput, bad_input};
use crate::output::Destination;
use clap::{Args, ValueEnum};
use sealegs::actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs::actuator::{ActuatorSpec, Kind, text};
use sealegs::leg::scenario::{self, Scenario};
use sealegs_export::{Exported, Fate, Format};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Write a bench or a leg for another simulator
#[derive(Args)]
pub struct Export {
    /// The model: an actuator file (as `sealegs add` writes it), a scenario file, or a preset of either
    model: String,
    /// The format
    #[arg(long, value_enum, value_name = "FORMAT")]
    to: To,
    /// Where to write it; what belongs beside it goes into the same folder
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    output: PathBuf,
    /// The bench of an actuator [default: locked]
    #[arg(long, value_enum)]
    bench: Option<Rig>,
    /// What an actuator's command is [default: current]
    #[arg(long, value_enum)]
    input: Option<Input>,
}

/// The formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum To {
    /// MuJoCo
    Mjcf,
    /// ROS
    Urdf,
    /// Isaac Lab, with a URDF beside it
    Isaaclab,
    /// Gazebo
    Sdf,
}

impl From<To> for Format {
    fn from(to: To) -> Self {
        match to {
            To::Mjcf => Self::Mjcf,
            To::Urdf => Self::Urdf,
            To::Isaaclab => Self::IsaacLab,
            To::Sdf => Self::Sdf,
        }
    }
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Input {
    /// Motor current, A
    Current,
    /// Motor force (N) or torque (N m)
    Effort,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input: an unknown model, a file with an error in it, an option that the model does not take, a file that cannot be
/// written.
pub fn run(arguments: &Export) -> anyhow::Result<u8> {
    if arguments.output == Path::new("-") {
        return Err(bad_input("-o -: name a file, for others may belong beside it"));
    }
    let stem = arguments.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let exported = exported(arguments, &stem)?;
    let mut files = vec![(arguments.output.clone(), exported.text.as_str())];
    for (name, text) in &exported.beside {
        files.push((arguments.output.with_file_name(name), text));
    }
    if files[1..].iter().any(|(path, _)| *path == arguments.output) {
        let problem = "a file of that name belongs beside it; take another ending";
        return Err(bad_input(format!("{}: {problem}", arguments.output.display())));
    }
    let places = files.iter().map(|(path, _)| Destination::new(path)).collect::<anyhow::Result<Vec<_>>>()?;
    for (place, (_, text)) in places.into_iter().zip(&files) {
        place.write(text.as_bytes())?;
    }
    let paths: Vec<&Path> = files.iter().map(|(path, _)| path.as_path()).collect();
    std::io::stdout().write_all(summary(&exported, &paths).as_bytes())?;
    Ok(0)
}

fn exported(arguments: &Export, stem: &str) -> anyhow::Result<Exported> {
    let format = Format::from(arguments.to);
    if is_scenario(&arguments.model)? {
        for (option, given) in [("bench", arguments.bench.is_some()), ("input", arguments.input.is_some())] {
            if given {
                return Err(bad_input(format!("--{option}: '{}' is a leg's scenario", arguments.model)));
            }
        }
        let scenario = Scenario::load(&arguments.model, &[]).or_bad_input()?;
        return sealegs_export::leg(format, &scenario, stem).or_bad_input();
    }
    let spec = ActuatorSpec::load(&arguments.model, None).or_bad_input()?;
    let input = match (arguments.input, spec.kind) {
        (None | Some(Input::Current), _) => "current_a",
        (Some(Input::Effort), Kind::Linear) => "motor_force_n",
        (Some(Input::Effort), Kind::Rotary) => "motor_torque_nm",
    };
    let bench = match arguments.bench {
        None | Some(Rig::Locked) => Bench::Locked,
        Some(Rig::Pendulum) => Bench::Pendulum(PendulumRig::default()),
    };
    let model = BenchModel::new(spec, bench).map_err(|e| bad_input(format!("{}: {e}", arguments.model)))?;
    sealegs_export::bench(format, &model, input, stem).or_bad_input()
}

/// Whether a name is a scenario's rather than an actuator's: a preset, or a file that names its robot.
fn is_scenario(name: &str) -> anyhow::Result<bool> {
    let path = Path::new(name);
    if path.is_file() {
        let text = std::fs::read_to_string(path).map_err(|e| bad_input(format!("{name}: {e}")))?;
        // What is no TOML at all is told by whoever reads it as an actuator.
        return Ok(text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("robot")));
    }
    let (scenarios, actuators) = (scenario::preset_names(), ActuatorSpec::preset_names());
    let is_path = name.ends_with(".toml") || path.components().count() > 1;
    if is_path || scenarios.contains(&name) || actuators.contains(&name) {
        return Ok(scenarios.contains(&name));
    }
    let known: Vec<&str> = actuators.into_iter().chain(scenarios).collect();
    let hint = text::nearest(name, known.iter().copied());
    let hint = hint.map(|n| format!("; did you mean '{n}'?")).unwrap_or_default();
    Err(bad_input(format!("no actuator and no scenario '{name}'{hint}; there are {}", known.join(", "))))
}

fn summary(exported: &Exported, paths: &[&Path]) -> String {
    let mut out = String::new();
    let names: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
    let _ = writeln!(out, "written to {}", names.join(", "));
    for note in &exported.notes {
        let _ = writeln!(out, "  {note}");
    }
    let lost = exported.notes.iter().filter(|n| n.fate == Fate::Lost).count();
    let near = exported.notes.iter().filter(|n| n.fate == Fate::Approximate).count();
    let _ = writeln!(out, "{lost} parts are lost, {near} are near only");
    out
}
