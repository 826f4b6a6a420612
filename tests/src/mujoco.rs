//! MuJoCo as a judge of exported models: where its Python is, and what its simulation shows of a bench.

use sealegs_actuator::bench::{Bench, BenchModel, OUTPUTS};
use sealegs_actuator::plant::{Grid, mean_per_step};
use sealegs_actuator::spec::ParameterSpec;
use sealegs_actuator::{ActuatorSpec, Kind};
use sealegs_export::{Exported, Format};
use sealegs_leg::bench::RobotModel;
use sealegs_model::{EffectCard, Excitation, Model, ModelError, Parameter, Prediction, Record, Signal};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The versions that read what is exported.
const WANTED: &str = "mujoco>=4,<5";

/// Set to anything, it makes a missing MuJoCo an error.
const REQUIRED: &str = "SEALEGS_REQUIRE_MUJOCO";

/// A Python that has MuJoCo: the system's, or one in a virtual environment in `folder`, which is made on first use.
/// `None`, and a word on standard error, where there is neither.
///
/// # Panics
///
/// Where there is none and `SEALEGS_REQUIRE_MUJOCO` is set.
#[must_use]
pub fn python(folder: &Path) -> Option<PathBuf> {
    // Tests run side by side, and one installation is enough.
    static FOUND: OnceLock<Option<PathBuf>> = OnceLock::new();
    FOUND.get_or_init(|| found(folder)).clone()
}

fn found(folder: &Path) -> Option<PathBuf> {
    let knows = |python: &Path| {
        let asked = "import mujoco; assert mujoco.__version__.split('.')[0] == '4'";
        Command::new(python).args(["-c", asked]).output().is_ok_and(|o| o.status.success())
    };
    let system = PathBuf::from("python3");
    if knows(&system) {
        return Some(system);
    }
    let place = folder.join("mujoco-python");
    let own = place.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if knows(&own) {
        return Some(own);
    }
    let runs = |program: &Path, arguments: &[&str]| {
        Command::new(program).args(arguments).output().is_ok_and(|o| o.status.success())
    };
    let made = runs(&system, &["-m", "venv", &place.display().to_string()])
        && runs(&own, &["-m", "pip", "install", "--quiet", WANTED, "numpy"]);
    if made && knows(&own) {
        return Some(own);
    }
    assert!(std::env::var_os(REQUIRED).is_none(), "no Python with MuJoCo 4 and none could be installed");
    // Not by a macro, whose output a test that passes would hide.
    let _ =
        writeln!(std::io::stderr(), "SKIPPED: no Python with MuJoCo 4, and none could be installed by pip");
    None
}

/// A bench to be run: the exported files and the commands.
pub struct BenchJob {
    /// What was exported as MJCF.
    pub exported: Exported,
    /// The runs.
    pub runs: Vec<RunJob>,
}

/// A run of a bench or a robot.
#[derive(Serialize)]
pub struct RunJob {
    /// The control of every step, by actuator.
    pub controls: BTreeMap<String, Vec<f64>>,
    /// The step, s.
    pub step_s: f64,
    /// Steps from one row to the next.
    pub per_row: usize,
    /// The key where it begins; at rest at zero if `None`.
    pub key: Option<String>,
}

/// What MuJoCo says of a leg.
#[derive(Debug, Deserialize)]
pub struct Weighed {
    /// Mass of all bodies, kg.
    pub mass_kg: f64,
    /// Degrees of freedom.
    pub dofs: usize,
    /// Actuators.
    pub actuators: usize,
    /// Height of the first body at every step, m.
    pub heights_m: Vec<f64>,
    /// Positions of the joints at the end, rad or m.
    pub joints: BTreeMap<String, f64>,
    /// Greatest joint speed.
    pub speed: f64,
    /// Time reached, s.
    pub time_s: f64,
    /// Warnings of the engine.
    pub warnings: usize,
}

#[derive(Serialize)]
struct Job {
    benches: Vec<BenchFiles>,
    legs: Vec<LegFile>,
}

#[derive(Serialize)]
struct BenchFiles {
    xml: PathBuf,
    python: PathBuf,
    runs: Vec<RunJob>,
}

#[derive(Serialize)]
struct LegFile {
    file: PathBuf,
    steps: usize,
}

#[derive(Deserialize)]
struct Answer {
    benches: Vec<Vec<BTreeMap<String, Vec<f64>>>>,
    legs: Vec<Weighed>,
}

/// Signals by channel, for each run of each bench.
pub type Shown = Vec<Vec<Vec<Signal>>>;

/// Runs benches, and steps legs (file name, text, steps), in MuJoCo.
///
/// # Panics
///
/// Where a file does not load or a simulation fails: the message is Python's.
#[must_use]
pub fn run(python: &Path, benches: Vec<BenchJob>, legs: &[(&str, &str, usize)]) -> (Shown, Vec<Weighed>) {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: String| folder.path().join(name);
    let write = |path: &Path, text: &str| std::fs::write(path, text).expect("a file");
    let mut job = Job { benches: Vec::new(), legs: Vec::new() };
    for (i, bench) in benches.into_iter().enumerate() {
        let (xml, beside) = (at(format!("bench_{i}.xml")), at(format!("bench_{i}.py")));
        write(&xml, &bench.exported.text);
        write(&beside, &bench.exported.beside[0].1);
        job.benches.push(BenchFiles { xml, python: beside, runs: bench.runs });
    }
    for (name, text, steps) in legs {
        let file = at((*name).to_owned());
        write(&file, text);
        job.legs.push(LegFile { file, steps: *steps });
    }
    let (job_file, answer) = (at("job.json".to_owned()), at("answer.json".to_owned()));
    write(&job_file, &serde_json::to_string(&job).expect("plain numbers"));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("mujoco/run.py");
    let done = Command::new(python).arg(script).arg(&job_file).arg(&answer).output().expect("python starts");
    assert!(done.status.success(), "MuJoCo: {}", String::from_utf8_lossy(&done.stderr));
    let answer: Answer =
        serde_json::from_str(&std::fs::read_to_string(answer).expect("an answer")).expect("JSON");
    let signals = |run: BTreeMap<String, Vec<f64>>| {
        run.into_iter().map(|(channel, values)| Signal { channel, values }).collect()
    };
    let benches = answer.benches.into_iter().map(|runs| runs.into_iter().map(signals).collect());
    (benches.collect(), answer.legs)
}

/// A bench as MJCF with the commands of these records, each held as the model's file says of the logger. A drive without a
/// spring begins where its run does, on the run's own rig.
///
/// # Panics
///
/// If the model cannot be exported.
#[must_use]
pub fn job(model: &BenchModel, records: &[&Record]) -> BenchJob {
    let value = |name: &str| model.parameters().iter().find(|p| p.name == name).map_or(0.0, |p| p.value);
    let (lead, skew) = (value("command_lead") > 0.5, value("clock_skew"));
    let actuator = match (model.spec().is_rigid(), model.bench(), model.spec().kind) {
        (false, ..) => "motor",
        (true, Bench::Pendulum(_), _) => "lever",
        (true, _, Kind::Linear) => "carriage",
        (true, _, Kind::Rotary) => "shaft",
    };
    let input = &records[0].inputs[0].channel;
    let run = Some(records[0].name.as_str()).filter(|name| model.run(name).is_some());
    let exported = sealegs_export::on_run(Format::Mjcf, model, input, run, "bench").expect("a bench");
    let of = |record: &&Record| RunJob {
        key: run.map(|_| record.name.clone()),
        ..run_job(record, &[(actuator, input)], (lead, skew))
    };
    BenchJob { exported, runs: records.iter().map(of).collect() }
}

/// A robot with torque drives as MJCF with the torques of these records, whose starts the model must know.
///
/// # Panics
///
/// If the model cannot be exported.
#[must_use]
pub fn robot_job(model: &RobotModel, records: &[&Record]) -> BenchJob {
    let values = model.nominal();
    let joints = model.driven_joints(&values);
    let commands: Vec<(&str, &String)> = joints.iter().map(|j| (j.name, &j.command)).collect();
    let exported = sealegs_export::robot(Format::Mjcf, model, "robot").expect("a robot");
    let of = |record: &&Record| RunJob {
        key: Some(record.name.clone()),
        ..run_job(record, &commands, (false, 0.0))
    };
    BenchJob { exported, runs: records.iter().map(of).collect() }
}

fn run_job(record: &Record, commands: &[(&str, &String)], (lead, skew): (bool, f64)) -> RunJob {
    let grid = Grid::covering(&record.time_s, sealegs_actuator::bench::DEFAULT_STEP_S);
    let period = record.mean_period_s();
    let late = (skew - if lead { 1.0 } else { 0.0 }) * period;
    let times: Vec<f64> = record.time_s.iter().map(|t| t + late).collect();
    let control = |(actuator, channel): &(&str, &String)| {
        let values = record.input(channel)?;
        Some(((*actuator).to_owned(), mean_per_step(&times, values, record.hold, &[], &grid)))
    };
    RunJob {
        controls: commands.iter().filter_map(control).collect(),
        step_s: grid.step_s,
        per_row: (period / grid.step_s).round() as usize,
        key: None,
    }
}

/// What another simulator has shown for each record, as a model without parameters.
#[derive(Debug, Clone)]
pub struct Played {
    /// Signals by the record's name.
    pub shown: BTreeMap<String, Vec<Signal>>,
}

impl Model for Played {
    fn name(&self) -> String {
        "played".to_owned()
    }

    fn parameters(&self) -> &[Parameter] {
        &[]
    }

    fn inputs(&self) -> &[&'static str] {
        &sealegs_actuator::bench::INPUTS
    }

    fn predicts(&self, channel: &str) -> bool {
        self.shown.values().all(|signals| signals.iter().any(|s| s.channel == channel))
    }

    fn included(&self) -> Vec<String> {
        Vec::new()
    }

    fn effects(&self, _: &Excitation) -> Vec<EffectCard> {
        Vec::new()
    }

    fn with_effect(&self, id: &str, _: &Excitation) -> Result<Box<dyn Model>, ModelError> {
        Err(ModelError::UnknownEffect { id: id.to_owned(), suggestion: None })
    }

    fn predict(&self, _: &[f64], record: &Record, channels: &[String]) -> Result<Prediction, ModelError> {
        let unknown = |channel: &String| ModelError::UnknownChannel { channel: channel.clone() };
        let signals = self.shown.get(&record.name).map_or(&[][..], Vec::as_slice);
        let of = |channel: &String| {
            signals.iter().find(|s| s.channel == *channel).cloned().ok_or_else(|| unknown(channel))
        };
        Ok(Prediction {
            outputs: channels.iter().map(of).collect::<Result<_, _>>()?,
            ..Prediction::default()
        })
    }

    fn clone_box(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}

/// Every sensor of a bench.
#[must_use]
pub fn everything() -> Excitation {
    Excitation { measured: OUTPUTS.map(str::to_owned).to_vec(), ..Excitation::default() }
}

/// A model whose parameters have other nominal values: those that an export takes.
///
/// # Panics
///
/// For values that no file can have.
#[must_use]
pub fn at(model: &BenchModel, values: &[f64]) -> BenchModel {
    let mut spec: ActuatorSpec = model.spec().clone();
    for (p, value) in model.parameters().iter().zip(values).filter(|(p, _)| !p.name.contains('.')) {
        let said = spec.parameters.entry(p.name.clone()).or_default();
        *said = ParameterSpec {
            value: Some(*value),
            min: Some(p.min.min(*value)),
            max: Some(p.max.max(*value)),
            ..ParameterSpec::default()
        };
    }
    spec.effects = model.effect_specs(values, &[]);
    BenchModel::new(spec, model.bench()).expect("a model")
}

/// Root mean square.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0usize), |(sum, n), v| (sum + v * v, n + 1));
    (sum / n as f64).sqrt()
}
