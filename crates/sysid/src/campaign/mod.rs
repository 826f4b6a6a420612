//! A campaign: a folder with one `campaign.toml` and one table per recorded run, read and checked.
//!
//! [`Campaign::read`] takes the folder (or the `campaign.toml` in it), reads all runs in parallel and
//! refuses what the data contract refuses, with one message naming file, line and column. Nothing is
//! silently dropped: columns that no bench knows stay in [`Run::unknown`], keys that mean nothing and
//! other oddities become lines of [`Campaign::notes`].
//!
//! Time stamps are kept as they are. [`Clock`] says how regular they are; whoever needs a uniform grid
//! (spectra, autocorrelation) resamples once with [`crate::resample`].

mod against;
mod clock;
mod columns;
mod file;
mod left_out;
mod memory;
mod noise;
mod rig;
mod scored;
mod table;
mod windows;

pub use clock::{Clock, Gap};
pub use left_out::{LeftOut, RARE, Spikes};
pub use memory::{CampaignBuilder, RunColumns};
pub use noise::{NoiseOrigin, NoiseStd, RepeatPair, quantum};
pub use rig::RigValues;
pub use sealegs_model::columns::{
    BESIDE as SIDE_COLUMNS, INPUTS as INPUT_COLUMNS, JOINT_COMMANDS, OUTPUTS as OUTPUT_COLUMNS,
    commanded_joint,
};

use crate::nuisance::SensorPrior;
use crate::{Error, stats};
use rayon::prelude::*;
use scored::{scored_rows, skip_start_in_motion, too_few_rows};
use sealegs_model::{Record, Signal};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Fewest rows that a run, and the part of it that counts, may have.
pub const FEWEST_ROWS: usize = 16;

/// What may say that its controller compensates gravity.
const GRAVITY_SUITS: &str = "is for the bench 'robot', whose URDF says what gravity does";

/// What the runs were recorded on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bench {
    /// Output locked: the high-impedance bench.
    Locked,
    /// The screw side turns a lever with a weight: the moving-output bench.
    Pendulum,
    /// The output moves a load freely: a carriage, a rotor with an inertia.
    Free,
    /// A robot on a fixed base or a rail with drives on its joints.
    Robot,
    /// A whole leg, by a scenario.
    Leg,
}

impl Bench {
    /// Whether its runs may begin in motion, and so be cut into pieces.
    #[must_use]
    pub fn may_begin_in_motion(self) -> bool {
        matches!(self, Self::Free | Self::Robot)
    }

    /// Whether it has joints, whose columns are called `<joint>.<what>`.
    #[must_use]
    pub fn has_joints(self) -> bool {
        matches!(self, Self::Robot | Self::Leg)
    }

    /// The name in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Locked => "locked",
            Self::Pendulum => "pendulum",
            Self::Free => "free",
            Self::Robot => "robot",
            Self::Leg => "leg",
        }
    }
}

/// What a run is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Fitted and selected on, by cross-validation inside these runs.
    Fit,
    /// Never fitted, never selected on: judges once, at the end.
    Holdout,
}

impl Role {
    /// The name in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Fit => "fit",
            Self::Holdout => "holdout",
        }
    }
}

/// One recorded run.
#[derive(Debug, Clone)]
pub struct Run {
    /// What it is for.
    pub role: Role,
    /// For a leg: its own scenario in place of the campaign's, a preset's name or a file beside the campaign's.
    pub scenario: Option<String>,
    /// Its rig's own numbers.
    pub rig: RigValues,
    /// Time stamps, the input first of the inputs, and the known output columns, all rows of the file. Its name is the file's.
    pub record: Record,
    /// The rows that count for errors (`from_s`, `to_s`); the model still simulates from the first row.
    pub scored: Range<usize>,
    /// Rows among them that do not count after all: repeated ones and spikes.
    pub left_out: LeftOut,
    /// Columns that no bench knows, kept as they are.
    pub unknown: Vec<Signal>,
    /// How regular the time stamps are.
    pub clock: Clock,
    /// Where it was read from; of several files the first, whose clock leads.
    pub path: PathBuf,
    /// The unit of the rig that it was recorded on (`left`), where the campaign says so.
    pub unit: Option<String>,
}

/// What is said of a run's columns while they are read.
#[derive(Debug, Default)]
struct RunNotes {
    own: Vec<String>,
    /// Whether the campaign maps the columns: one note names all that are left then.
    is_mapped: bool,
    /// Whether it is a further piece of a run, of whose file all is said.
    is_further: bool,
}

/// A run, or its pieces (see [`windows`]); what is to be said of its file is said of the first.
fn in_pieces(
    run: Run,
    notes: RunNotes,
    window_s: Option<f64>,
    sample_rate_hz: Option<f64>,
) -> impl Iterator<Item = (Run, RunNotes)> {
    let cut = match window_s {
        Some(window_s) => windows::cut(run, window_s, sample_rate_hz),
        None => vec![run],
    };
    let further = || RunNotes { is_further: true, ..RunNotes::default() };
    cut.into_iter().zip(std::iter::once(notes).chain(std::iter::repeat_with(further)))
}

impl Run {
    /// Whether the run's columns were given in memory: its path is then no file's.
    #[must_use]
    pub fn is_in_memory(&self) -> bool {
        memory::is_in_memory(&self.path)
    }

    /// The rows that count for errors, those that are left out taken away; all, where hardly a row would stay.
    #[must_use]
    pub fn counted(&self) -> Vec<Range<usize>> {
        let counted = self.left_out.counted(self.scored.clone());
        let rows: usize = counted.iter().map(Range::len).sum();
        if rows < FEWEST_ROWS { vec![self.scored.clone()] } else { counted }
    }
}

/// Everything that a campaign's files say.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Its name; the folder's if the file gives none.
    pub name: String,
    /// The campaign file.
    pub file: PathBuf,
    /// What it was recorded on.
    pub bench: Bench,
    /// A preset's name, or a path beside the campaign file; may be empty for a leg and for a robot's own model file.
    pub actuator: String,
    /// For a leg: the scenario's preset or file.
    pub scenario: Option<String>,
    /// For a robot: its URDF or model file, beside the campaign's.
    pub robot: Option<String>,
    /// For a robot: its controller adds the torques that hold it against gravity to those that the runs command.
    pub gravity_compensated: bool,
    /// The line of the campaign file that names the actuator or the scenario, if it was read from one.
    pub model_line: Option<u64>,
    /// Nominal sample rate, Hz, if stated.
    pub sample_rate_hz: Option<f64>,
    /// Noise of every known output column that some run has, stated or estimated.
    pub noise: Vec<NoiseStd>,
    /// What is known of sensors beforehand, by column, where somebody said so; else
    /// [`SensorPrior::of_channel`] decides.
    pub sensors: Vec<(String, SensorPrior)>,
    /// The runs in the order of the file.
    pub runs: Vec<Run>,
    /// Pairs of runs with the same input: what they leave between them is the campaign's real floor.
    pub repeats: Vec<RepeatPair>,
    /// What a person should know of the files: unknown keys and columns, irregular time.
    pub notes: Vec<String>,
}

impl Campaign {
    /// The noise floor in noise units: what repeats of a run leave between them where there are any, and not less than
    /// 1, the stated noise.
    #[must_use]
    pub fn noise_floor(&self) -> f64 {
        let squares: Vec<f64> = self
            .repeats
            .iter()
            .filter_map(|pair| Some((pair.deviation / self.noise_std(&pair.channel)?.std).powi(2)))
            .collect();
        if squares.is_empty() { 1.0 } else { stats::mean(&squares).sqrt().max(1.0) }
    }

    /// Reads the campaign in a folder, or by its `campaign.toml`.
    ///
    /// # Errors
    ///
    /// [`Error::BadFile`] for everything that the data contract calls bad input, in the order of the
    /// runs, whatever the number of threads.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let file = if path.is_dir() { path.join("campaign.toml") } else { path.to_owned() };
        let description = file::read(&file)?;
        let folder = file.parent().unwrap_or(Path::new("."));
        let runs: Vec<Result<(Run, RunNotes), Error>> = description
            .runs
            .par_iter()
            .map(|run| {
                if let Some(missing) = run.files.iter().find(|f| !folder.join(&f.file).exists()) {
                    let problem = format!("no such file: {}", missing.file);
                    return Err(Error::bad(&file, run.line, Some("file"), problem));
                }
                let path = folder.join(&run.files[0].file);
                let said = table::Said {
                    bench: description.bench,
                    leg_inputs: &description.inputs,
                    sample_rate_hz: description.sample_rate_hz,
                    hold: description.hold,
                };
                let hinted = |error: Error| error.hinted(&file, &description.misspelt);
                let mut table = table::read(&file, folder, run, said).map_err(hinted)?;
                let notes = std::mem::take(&mut table.notes);
                let record = Record {
                    cut: false,
                    name: run.name(),
                    time_s: table.time_s,
                    hold: description.hold,
                    inputs: table.inputs,
                    outputs: table.outputs,
                };
                let scored = scored_rows(&record.time_s, run.from_s, run.to_s).ok_or_else(|| {
                    Error::bad(&file, run.line, Some("from_s, to_s"), too_few_rows(&run.name()))
                })?;
                let time = &record.time_s;
                if let Some(problem) = clock::too_long(time) {
                    return Err(Error::bad(&path, None, Some("time_s"), problem));
                }
                let clock = Clock::of(&record.time_s, description.sample_rate_hz);
                let (scenario, unit) = (run.scenario.clone(), run.unit.clone());
                let left_out = LeftOut::of(&record);
                let notes = RunNotes { own: notes, is_mapped: run.columns.is_some(), is_further: false };
                let run = Run {
                    role: run.role,
                    scenario,
                    rig: run.rig.clone(),
                    record,
                    scored,
                    left_out,
                    unknown: table.unknown,
                    clock,
                    path,
                    unit,
                };
                Ok((run, notes))
            })
            .collect();
        let mut pieces: Vec<(Run, RunNotes)> = Vec::new();
        for (run, entry) in runs.into_iter().zip(&description.runs) {
            let (run, notes) = run?;
            pieces.extend(in_pieces(run, notes, entry.window_s, description.sample_rate_hz));
        }
        Ok(Self::assembled(description, file, pieces))
    }

    /// A campaign of columns in memory: its name, its bench, and its actuator (for a leg its scenario), a preset's name
    /// or a file.
    ///
    /// ```
    /// use sealegs_sysid::campaign::{Bench, Campaign, Role, RunColumns};
    ///
    /// let time_s: Vec<f64> = (0..100).map(|i| 1e-3 * f64::from(i)).collect();
    /// let current_a: Vec<f64> = time_s.iter().map(|t| (50.0 * t).sin()).collect();
    /// let force_1_n: Vec<f64> = current_a.iter().map(|i| 238.0 * i).collect();
    /// let columns = [("time_s", time_s), ("current_a", current_a), ("force_1_n", force_1_n)];
    /// let campaign = Campaign::builder("knee-bench", Bench::Locked, "thor-linear")
    ///     .noise_std("force_1_n", 2.0)
    ///     .run(RunColumns::new("sine", Role::Fit, columns))
    ///     .build()?;
    /// assert_eq!(campaign.runs[0].record.len(), 100);
    /// # Ok::<(), sealegs_sysid::Error>(())
    /// ```
    pub fn builder(name: impl Into<String>, bench: Bench, model: impl Into<String>) -> CampaignBuilder {
        CampaignBuilder::new(name.into(), bench, model.into())
    }

    /// The same campaign with its runs in pieces of so many seconds that each begin at the measured state, as `window_s` in its
    /// file cuts them; as it is on a bench whose runs do not begin in motion.
    #[must_use]
    pub fn cut_into(&self, window_s: f64) -> Self {
        let mut cut = self.clone();
        if self.bench.may_begin_in_motion() {
            let pieces = |run| windows::cut(run, window_s, self.sample_rate_hz);
            cut.runs = cut.runs.into_iter().flat_map(pieces).collect();
            cut.repeats = noise::repeats(&cut.runs);
        }
        cut
    }

    /// What follows from all runs together: noise, repeats, remarks.
    fn assembled(description: file::Description, file: PathBuf, runs: Vec<(Run, RunNotes)>) -> Self {
        let (runs, of_runs): (Vec<Run>, Vec<RunNotes>) = runs.into_iter().unzip();
        let mut notes = description.notes;
        for (run, said) in runs.iter().zip(of_runs) {
            if said.is_further {
                continue;
            }
            notes.extend(said.own);
            // Of mapped files one note names them all.
            let unsaid = run.unknown.iter().filter(|_| !said.is_mapped);
            notes.extend(unsaid.map(|column| {
                let channel = &column.channel;
                format!("{}: unknown column '{channel}' is kept, and compared with nothing", run.record.name)
            }));
            notes.extend(run.clock.remarks().into_iter().map(|r| format!("{}: {r}", run.record.name)));
        }
        for (channel, _) in &description.noise_std {
            if !runs.iter().any(|r| r.record.output(channel).is_some()) {
                notes.push(format!("{}: [noise_std] names '{channel}', which no run has", file.display()));
            }
        }
        let repeats = noise::repeats(&runs);
        let noise = noise::of_runs(&runs, &description.noise_std);
        let mut runs = runs;
        // The model of a drive without a spring begins in motion, as its run does.
        for run in runs.iter_mut().filter(|_| !description.bench.may_begin_in_motion()) {
            notes.extend(skip_start_in_motion(run, &noise));
        }
        Self {
            name: description.name,
            file,
            bench: description.bench,
            actuator: description.actuator,
            scenario: description.scenario,
            robot: description.robot,
            gravity_compensated: description.gravity_compensated,
            model_line: description.model_line,
            sample_rate_hz: description.sample_rate_hz,
            noise,
            sensors: Vec::new(),
            runs,
            repeats,
            notes,
        }
    }

    /// The error of a campaign file with a wrong key.
    #[must_use]
    pub fn bad_key(&self, key: &str, problem: impl Into<String>) -> Error {
        Error::bad(&self.file, None, Some(key), problem)
    }

    /// The error of a campaign file whose actuator or scenario is wrong.
    #[must_use]
    pub fn bad_model(&self, problem: impl Into<String>) -> Error {
        let key = match self.bench {
            Bench::Leg => "scenario",
            Bench::Robot => "robot",
            _ => "actuator",
        };
        Error::bad(&self.file, self.model_line, Some(key), problem)
    }

    /// The folder of the campaign file, beside which actuator files and scenarios are looked for; that of the process
    /// for a campaign in memory.
    #[must_use]
    pub fn folder(&self) -> &Path {
        if self.is_in_memory() {
            return Path::new("");
        }
        self.file.parent().unwrap_or(Path::new("."))
    }

    /// Whether the campaign was built from columns in memory: its path is then no file's.
    #[must_use]
    pub fn is_in_memory(&self) -> bool {
        memory::is_in_memory(&self.file)
    }

    /// The runs of one role.
    pub fn runs_of(&self, role: Role) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |r| r.role == role)
    }

    /// Checks that there is a run of this role.
    ///
    /// # Errors
    ///
    /// [`Error::NoRun`].
    pub fn require(&self, role: Role) -> Result<(), Error> {
        match self.runs_of(role).next() {
            Some(_) => Ok(()),
            None => Err(Error::NoRun { file: self.file.clone(), role: role.as_str() }),
        }
    }

    /// States what is known of a column's sensor: one standard deviation of its gain about 1 (0: exact),
    /// and of a run's bias.
    pub fn state_sensor(&mut self, channel: &str, gain_std: Option<f64>, bias_std: Option<f64>) {
        let Some(noise) = self.noise_std(channel).map(|n| n.std) else { return };
        let peak = self.peak(channel);
        let prior = SensorPrior::of_channel(channel, noise, peak).stated(gain_std, bias_std);
        self.sensors.retain(|(c, _)| c != channel);
        self.sensors.push((channel.to_owned(), prior));
    }

    /// What is known of a column's sensor beforehand.
    #[must_use]
    pub fn sensor_prior(&self, channel: &str) -> SensorPrior {
        let stated = self.sensors.iter().find(|(c, _)| c == channel);
        let noise = self.noise_std(channel).map_or(1.0, |n| n.std);
        stated.map_or_else(|| SensorPrior::of_channel(channel, noise, self.peak(channel)), |(_, p)| *p)
    }

    /// The greatest magnitude of an output column in the rows that count: of the fit runs, if any has it.
    #[must_use]
    pub fn peak(&self, channel: &str) -> f64 {
        let of = |run: &Run| {
            let values = run.record.output(channel)?;
            Some(run.counted().into_iter().flatten().fold(0.0f64, |p, i| p.max(values[i].abs())))
        };
        let fitted = self.runs_of(Role::Fit).filter_map(of).fold(0.0, f64::max);
        if fitted > 0.0 { fitted } else { self.runs.iter().filter_map(of).fold(0.0, f64::max) }
    }

    /// The noise standard deviation of an output column.
    #[must_use]
    pub fn noise_std(&self, channel: &str) -> Option<&NoiseStd> {
        self.noise.iter().find(|n| n.channel == channel)
    }
}

#[cfg(test)]
mod tests;
