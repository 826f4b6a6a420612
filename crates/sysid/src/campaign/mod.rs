//! A campaign: a folder with one `campaign.toml` and one table per recorded run, read and checked.
//!
//! [`Campaign::read`] takes the folder (or the `campaign.toml` in it), reads all runs in parallel and
//! refuses what the data contract refuses, with one message naming file, line and column. Nothing is
//! silently dropped: columns that no bench knows stay in [`Run::unknown`], keys that mean nothing and
//! other oddities become lines of [`Campaign::notes`].
//!
//! Time stamps are kept as they are. [`Clock`] says how regular they are; whoever needs a uniform grid
//! (spectra, autocorrelation) resamples once with [`crate::resample`].

mod clock;
mod columns;
mod file;
mod noise;
mod table;

pub use clock::{Clock, Gap};
pub use noise::{NoiseOrigin, NoiseStd, RepeatPair, quantum};

use crate::nuisance::SensorPrior;
use crate::{Error, stats};
use rayon::prelude::*;
use sealegs_model::{Model, Record, Signal};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Columns that are commands to the motor; a run of a bench has exactly one of them.
pub const INPUT_COLUMNS: [&str; 6] =
    ["current_a", "motor_force_n", "motor_torque_nm", "voltage_v", "joint_torque_nm", "position_rad"];

/// Columns that switch a drive, beside its input: zero releases it.
pub const SWITCH_COLUMNS: [&str; 1] = ["enable"];

/// Columns that a bench's sensors may have recorded.
pub const OUTPUT_COLUMNS: [&str; 12] = [
    "force_1_n",
    "force_2_n",
    "motor_angle_rad",
    "spring_deflection_m",
    "joint_angle_rad",
    "output_torque_nm",
    "spring_torque_nm",
    "spring_deflection_rad",
    "position_m",
    "speed_rad_s",
    "supply_v",
    "temperature_c",
];

/// Fewest rows that a run, and the part of it that counts, may have.
pub const FEWEST_ROWS: usize = 16;

/// What the runs were recorded on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bench {
    /// Output locked: the high-impedance bench.
    Locked,
    /// The screw side turns a lever with a weight: the moving-output bench.
    Pendulum,
    /// A whole leg, by a scenario.
    Leg,
}

impl Bench {
    /// The name in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Locked => "locked",
            Self::Pendulum => "pendulum",
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
    /// Time stamps, the input and the known output columns, all rows of the file. Its name is the file's.
    pub record: Record,
    /// The rows that count for errors (`from_s`, `to_s`); the model still simulates from the first row.
    pub scored: Range<usize>,
    /// Columns that no bench knows, kept as they are.
    pub unknown: Vec<Signal>,
    /// How regular the time stamps are.
    pub clock: Clock,
    /// Where it was read from; of several files the first, whose clock leads.
    pub path: PathBuf,
    /// The unit of the rig that it was recorded on (`left`), where the campaign says so.
    pub unit: Option<String>,
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
    /// A preset's name, or a path beside the campaign file; empty only for a leg.
    pub actuator: String,
    /// For a leg: the scenario's preset or file.
    pub scenario: Option<String>,
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
        let runs: Vec<Result<(Run, Vec<String>), Error>> = description
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
                let mut table = table::read(&file, folder, run, said)?;
                let notes = std::mem::take(&mut table.notes);
                let record = Record {
                    name: run.name(),
                    time_s: table.time_s,
                    hold: description.hold,
                    inputs: table.inputs,
                    outputs: table.outputs,
                };
                let scored = scored_rows(&record.time_s, run.from_s, run.to_s).ok_or_else(|| {
                    Error::bad(
                        &file,
                        run.line,
                        Some("from_s, to_s"),
                        format!("leave fewer than {FEWEST_ROWS} rows of {}", run.name()),
                    )
                })?;
                let time = &record.time_s;
                if let Some(problem) = clock::too_long(time) {
                    return Err(Error::bad(&path, None, Some("time_s"), problem));
                }
                let clock = Clock::of(&record.time_s, description.sample_rate_hz);
                let (scenario, unit) = (run.scenario.clone(), run.unit.clone());
                let unknown = table.unknown;
                let run = Run { role: run.role, scenario, record, scored, unknown, clock, path, unit };
                Ok((run, notes))
            })
            .collect();
        let (runs, of_runs): (Vec<Run>, Vec<Vec<String>>) =
            runs.into_iter().collect::<Result<Vec<_>, Error>>()?.into_iter().unzip();
        let mut notes = description.notes;
        for ((run, entry), own) in runs.iter().zip(&description.runs).zip(of_runs) {
            notes.extend(own);
            // Of mapped files one note names them all.
            let unsaid = run.unknown.iter().filter(|_| entry.columns.is_none());
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
        for run in &mut runs {
            notes.extend(skip_start_in_motion(run, &noise));
        }
        Ok(Self {
            name: description.name,
            file,
            bench: description.bench,
            actuator: description.actuator,
            scenario: description.scenario,
            model_line: description.model_line,
            sample_rate_hz: description.sample_rate_hz,
            noise,
            sensors: Vec::new(),
            runs,
            repeats,
            notes,
        })
    }

    /// The error of a campaign file whose actuator or scenario is wrong.
    #[must_use]
    pub fn bad_model(&self, problem: impl Into<String>) -> Error {
        let key = if self.bench == Bench::Leg { "scenario" } else { "actuator" };
        Error::bad(&self.file, self.model_line, Some(key), problem)
    }

    /// The folder of the campaign file, beside which actuator files and scenarios are looked for.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(Path::new("."))
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

    /// Checks that a model can predict every run: one input column that it takes and at least one output
    /// column that it predicts. Returns a line for each recorded output column that it does not predict.
    ///
    /// # Errors
    ///
    /// [`Error::BadFile`] naming the run's file and its header.
    pub fn check_against(&self, model: &dyn Model) -> Result<Vec<String>, Error> {
        let mut notes = Vec::new();
        for run in &self.runs {
            let wanted = model.inputs();
            let found: Vec<&str> =
                run.record.inputs.iter().map(|s| s.channel.as_str()).filter(|c| wanted.contains(c)).collect();
            if !wanted.is_empty() && found.len() != 1 {
                let problem = match found.first() {
                    None => format!(
                        "no input column that {} takes; it needs {}",
                        model.name(),
                        wanted.join(" or ")
                    ),
                    Some(_) => format!("two input columns at once: {}", found.join(", ")),
                };
                return Err(Error::bad(&run.path, table::header_of(&run.path), None, problem));
            }
            let (known, other): (Vec<&Signal>, Vec<&Signal>) =
                run.record.outputs.iter().partition(|s| model.predicts(&s.channel));
            if known.is_empty() {
                let names: Vec<&str> = run.record.outputs.iter().map(|s| s.channel.as_str()).collect();
                let found = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                return Err(Error::bad(
                    &run.path,
                    table::header_of(&run.path),
                    None,
                    format!("no output column that {} can predict (found: {found})", model.name()),
                ));
            }
            for signal in other {
                notes.push(format!(
                    "{}: column '{}' is not predicted by {}; it is kept, and compared with nothing",
                    run.record.name,
                    signal.channel,
                    model.name()
                ));
            }
        }
        Ok(notes)
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
            Some(values[run.scored.clone()].iter().fold(0.0f64, |p, v| p.max(v.abs())))
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

/// Rows with `from_s <= time <= to_s` (to a nanosecond, as decimal digits are not exact), if they are enough.
fn scored_rows(time_s: &[f64], from_s: Option<f64>, to_s: Option<f64>) -> Option<Range<usize>> {
    let start = from_s.map_or(0, |t| time_s.partition_point(|&x| x < t - 1e-9));
    let end = to_s.map_or(time_s.len(), |t| time_s.partition_point(|&x| x <= t + 1e-9));
    (start + FEWEST_ROWS <= end).then_some(start..end)
}

/// A jump from the first row to the second beyond this many times the noise, and this share of all that the
/// channel does, is no answer to the first command: the rig was in motion.
const IN_MOTION: (f64, f64) = (20.0, 0.02);

/// Share of a run that begins in motion that does not count: models begin at rest, and forget that.
const FORGOTTEN: f64 = 0.05;

/// Leaves the beginning of a run that begins in motion out of what counts, unless the campaign says where to begin;
/// returns a remark.
fn skip_start_in_motion(run: &mut Run, noise: &[NoiseStd]) -> Option<String> {
    let moves = run.record.outputs.iter().any(|s| {
        let std = noise.iter().find(|n| n.channel == s.channel).map_or(0.0, |n| n.std);
        let (low, high) = s.values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        let jump = (s.values[1] - s.values[0]).abs();
        std > 0.0 && jump > IN_MOTION.0 * std && jump > IN_MOTION.1 * (high - low)
    });
    let rows = (FORGOTTEN * run.record.len() as f64) as usize;
    if !moves || run.scored.start > 0 || run.scored.len() < rows + FEWEST_ROWS || rows == 0 {
        return None;
    }
    run.scored.start = rows;
    let span = run.record.time_s[rows] - run.record.time_s[0];
    Some(format!(
        "{}: begins in motion; its first {span:.3} s do not count, as a model begins at rest",
        run.record.name
    ))
}

#[cfg(test)]
mod tests;
