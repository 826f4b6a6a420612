//! `sealegs export`: a bench, a leg or a robot as a file of other people's simulators, and what that file cannot hold.

use crate::failure::{OrBadInput, bad_input};
use crate::output::Destination;
use clap::{Args, ValueEnum};
use sealegs::actuator::bench::{Bench, BenchModel};
use sealegs::actuator::{ActuatorSpec, Kind, text};
use sealegs::leg::bench::{RobotFile, RobotModel};
use sealegs::leg::scenario::{self, Scenario};
use sealegs::model::Model;
use sealegs::sysid::campaign::RigValues;
use sealegs::sysid::{Campaign, campaign};
use sealegs::{ModelSource, bench_model, leg_model, robot_model};
use sealegs_export::{Exported, Fate, Format};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Write a bench, a leg or a robot for another simulator
#[derive(Args)]
pub struct Export {
    /// What is written: a campaign (its model on its bench), a model file as `sealegs add` writes it (an actuator, a scenario
    /// or a robot), or a preset
    what: String,
    /// For a campaign: another model than its own, as `sealegs add` writes it
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// For a campaign: the run whose rig, start and servo gain are written [default: its first]
    #[arg(long, value_name = "FILE")]
    run: Option<String>,
    /// The format
    #[arg(long, value_enum, value_name = "FORMAT")]
    to: To,
    /// Where to write it; what belongs beside it goes into the same folder
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    output: PathBuf,
    /// The bench of an actuator [default: locked, of a drive without a spring free]
    #[arg(long, value_enum)]
    bench: Option<Rig>,
    /// What an actuator's command is [default: current, of a servo position]
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
    /// A drive without a spring that moves nothing but its rotor
    Free,
}

/// What the command is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Input {
    /// Motor current, A
    Current,
    /// Motor force (N) or torque (N m)
    Effort,
    /// Voltage at the winding, V
    Voltage,
    /// Goal of a servo's own loop, rad
    Position,
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
    let what = what(&arguments.what)?;
    let refuse = |options: &[(&str, bool)], is: &str| match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(bad_input(format!("--{option}: '{}' is {is}", arguments.what))),
        None => Ok(()),
    };
    let bench = [("bench", arguments.bench.is_some()), ("input", arguments.input.is_some())];
    let campaign = [("model", arguments.model.is_some()), ("run", arguments.run.is_some())];
    match what {
        What::Actuator => {
            refuse(&campaign, "an actuator, and no campaign")?;
            of_actuator(arguments, format, stem)
        }
        What::Scenario => {
            refuse(&bench, "a leg's scenario")?;
            refuse(&campaign, "a leg's scenario, and no campaign")?;
            let scenario = Scenario::load(&arguments.what, &[]).or_bad_input()?;
            sealegs_export::leg(format, &scenario, stem).or_bad_input()
        }
        What::Robot => {
            refuse(&bench, "a robot's model file")?;
            refuse(&campaign, "a robot's model file, and no campaign")?;
            let model =
                RobotFile::load(Path::new(&arguments.what)).and_then(|file| RobotModel::new(file, &[]));
            let model = model.map_err(|e| bad_input(named(&arguments.what, &e.to_string())))?;
            sealegs_export::robot(format, &model, stem).or_bad_input()
        }
        What::Campaign => {
            refuse(&bench, "a campaign, which says it itself")?;
            of_campaign(arguments, format, stem)
        }
    }
}

/// A message that names a file, unless it does so already.
fn named(file: &str, message: &str) -> String {
    if message.contains(file) { message.to_owned() } else { format!("{file}: {message}") }
}

fn of_actuator(arguments: &Export, format: Format, stem: &str) -> anyhow::Result<Exported> {
    let spec = ActuatorSpec::load(&arguments.what, None).or_bad_input()?;
    let servo = spec.servo.is_some();
    let input = match (arguments.input, spec.kind) {
        (None, _) if servo => "position_rad",
        (None | Some(Input::Current), _) => "current_a",
        (Some(Input::Effort), Kind::Linear) => "motor_force_n",
        (Some(Input::Effort), Kind::Rotary) => "motor_torque_nm",
        (Some(Input::Voltage), _) => "voltage_v",
        (Some(Input::Position), _) => "position_rad",
    };
    let bench = match arguments.bench {
        Some(Rig::Locked) => Bench::Locked,
        Some(Rig::Pendulum) => bench_model::bench_of(campaign::Bench::Pendulum, &RigValues::default(), &spec)
            .map_err(|wrong| {
                let problem = format!("{} {}: export its campaign", wrong.key, wrong.problem);
                bad_input(format!("{}: --bench pendulum: {problem}", arguments.what))
            })?,
        None if !spec.is_rigid() => Bench::Locked,
        None | Some(Rig::Free) => Bench::Free { load: 0.0 },
    };
    let model =
        BenchModel::new(spec, bench).map_err(|e| bad_input(named(&arguments.what, &e.to_string())))?;
    if !model.inputs().contains(&input) {
        let takes = model.inputs().join(", ");
        return Err(bad_input(format!("{}: --input: takes no {input}; it takes {takes}", arguments.what)));
    }
    sealegs_export::bench(format, &model, input, stem).or_bad_input()
}

/// A campaign's model on its bench.
fn of_campaign(arguments: &Export, format: Format, stem: &str) -> anyhow::Result<Exported> {
    let mut campaign = Campaign::read(Path::new(&arguments.what)).or_bad_input()?;
    let run = match &arguments.run {
        None => campaign.runs.first(),
        Some(name) => Some(campaign.runs.iter().find(|run| run.record.name == *name).ok_or_else(|| {
            let known: Vec<&str> = campaign.runs.iter().map(|run| run.record.name.as_str()).collect();
            bad_input(format!("--run: no run '{name}' in {}; there are {}", arguments.what, known.join(", ")))
        })?),
    };
    let record = run.map(|run| run.record.clone());
    let source = ModelSource::from(arguments.model.as_deref());
    match campaign.bench {
        campaign::Bench::Leg => {
            if arguments.run.is_some() {
                return Err(bad_input(format!("--run: '{}' is a leg's campaign", arguments.what)));
            }
            let model = leg_model::of_source(&mut campaign, &source, Vec::new()).or_bad_input()?;
            sealegs_export::leg(format, model.scenario(), stem).or_bad_input()
        }
        campaign::Bench::Robot => {
            let model = robot_model::of_source(&mut campaign, &source, &[]).or_bad_input()?;
            let model = match (&arguments.run, &record) {
                (Some(_), Some(record)) => model.starting_as(record).or_bad_input()?,
                _ => model,
            };
            sealegs_export::robot(format, &model, stem).or_bad_input()
        }
        _ => {
            let model = bench_model::of_source(&mut campaign, &source, Vec::new()).or_bad_input()?;
            let given = |input: &&&str| record.as_ref().is_some_and(|r| r.input(input).is_some());
            let input = model.inputs().iter().find(given).copied().ok_or_else(|| {
                let takes = model.inputs().join(", ");
                bad_input(format!("{}: its run has no input that the drive takes: {takes}", arguments.what))
            })?;
            let model = match &record {
                Some(record) => model.starting_as(record).or_bad_input()?,
                None => model,
            };
            let run = record.as_ref().map(|r| r.name.as_str());
            sealegs_export::on_run(format, &model, input, run, stem).or_bad_input()
        }
    }
}

/// What a name or a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Actuator,
    Scenario,
    Robot,
    Campaign,
}

/// What is to be written: a preset, or a file by the keys that it has.
fn what(name: &str) -> anyhow::Result<What> {
    let path = Path::new(name);
    if path.is_dir() {
        return Ok(What::Campaign);
    }
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("urdf")) {
        let how = "write `robot = \"ROBOT.urdf\"` and `actuator = \"DRIVE.toml\"` into a model file, or export its campaign";
        return Err(bad_input(format!("{name}: a URDF says nothing of its drives; {how}")));
    }
    if path.is_file() {
        let text = std::fs::read_to_string(path).map_err(|e| bad_input(format!("{name}: {e}")))?;
        // What is no TOML at all is told by whoever reads it as an actuator.
        let table = text.parse::<toml::Table>().unwrap_or_default();
        let has = |key: &str| table.contains_key(key);
        return Ok(match (has("run"), has("robot"), has("actuator")) {
            (true, ..) => What::Campaign,
            (_, true, true) => What::Robot,
            (_, true, false) => What::Scenario,
            _ => What::Actuator,
        });
    }
    let (scenarios, actuators) = (scenario::preset_names(), ActuatorSpec::preset_names());
    let is_path = name.ends_with(".toml") || path.components().count() > 1;
    if is_path || scenarios.contains(&name) || actuators.contains(&name) {
        return Ok(if scenarios.contains(&name) { What::Scenario } else { What::Actuator });
    }
    let known: Vec<&str> = actuators.into_iter().chain(scenarios).collect();
    let hint = text::meant(name, known.iter().copied());
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
