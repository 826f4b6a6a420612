//! A campaign of columns that are in memory already: what [`Campaign::read`] makes of files, without any.

use super::file::Description;
use super::scored::{scored_rows, too_few_rows};
use super::table::{Said, check_columns, check_length, sort};
use super::{Bench, Campaign, Clock, LeftOut, RigValues, Role, Run, RunNotes, clock, in_pieces, windows};
use crate::{Error, Place};
use sealegs_logs::join::time_fault;
use sealegs_model::{InputHold, Record};
use std::path::{Path, PathBuf};

/// The folder in whose place a campaign stands that was never a file; messages begin with it.
const MEMORY: &str = "(memory)";

/// Whether a path is that of a run or campaign in memory.
#[must_use]
pub(super) fn is_in_memory(path: &Path) -> bool {
    path.starts_with(MEMORY)
}

/// The columns of one run, each with its name, in SI units as the name's ending says.
///
/// `time_s` must be among them, strictly increasing. A bench's run has one of [`super::INPUT_COLUMNS`] and any of
/// [`super::OUTPUT_COLUMNS`]; a leg's columns carry their place (`knee.force_1_n`).
#[derive(Debug, Clone)]
pub struct RunColumns {
    name: String,
    role: Role,
    scenario: Option<String>,
    unit: Option<String>,
    rig: RigValues,
    columns: Vec<(String, Vec<f64>)>,
    from_s: Option<f64>,
    to_s: Option<f64>,
}

impl RunColumns {
    /// A run of this name and role; every column has as many values as the others, at least [`super::FEWEST_ROWS`].
    pub fn new<N: Into<String>>(
        name: impl Into<String>,
        role: Role,
        columns: impl IntoIterator<Item = (N, Vec<f64>)>,
    ) -> Self {
        Self {
            name: name.into(),
            role,
            scenario: None,
            unit: None,
            rig: RigValues::default(),
            columns: columns.into_iter().map(|(name, values)| (name.into(), values)).collect(),
            from_s: None,
            to_s: None,
        }
    }

    /// For a leg: this run's own scenario in place of the campaign's, a preset or a file.
    #[must_use]
    pub fn scenario(mut self, scenario: impl Into<String>) -> Self {
        self.scenario = Some(scenario.into());
        self
    }

    /// The unit that this run was recorded on (`left`): each has values of its own, and shares the effects.
    #[must_use]
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = Some(unit.into());
        self
    }

    /// The rig's own numbers in this run: masses, lengths, a servo's gain.
    #[must_use]
    pub fn rig(mut self, rig: RigValues) -> Self {
        self.rig = rig;
        self
    }

    /// Only rows from this time stamp on count for errors, s; a model still simulates from the first row.
    #[must_use]
    pub fn from_s(mut self, from_s: f64) -> Self {
        self.from_s = Some(from_s);
        self
    }

    /// Only rows up to this time stamp count for errors, s.
    #[must_use]
    pub fn to_s(mut self, to_s: f64) -> Self {
        self.to_s = Some(to_s);
        self
    }
}

/// What a `campaign.toml` would say, and the runs' columns.
#[derive(Debug, Clone)]
pub struct CampaignBuilder {
    name: String,
    bench: Bench,
    model: String,
    inputs: Vec<String>,
    sample_rate_hz: Option<f64>,
    window_s: Option<f64>,
    gravity_compensated: bool,
    hold: InputHold,
    noise_std: Vec<(String, f64)>,
    runs: Vec<RunColumns>,
}

impl CampaignBuilder {
    pub(super) fn new(name: String, bench: Bench, model: String) -> Self {
        Self {
            name,
            bench,
            model,
            inputs: Vec::new(),
            sample_rate_hz: None,
            window_s: None,
            gravity_compensated: false,
            hold: InputHold::ZeroOrder,
            noise_std: Vec::new(),
            runs: Vec::new(),
        }
    }

    /// One more run.
    #[must_use]
    pub fn run(mut self, run: RunColumns) -> Self {
        self.runs.push(run);
        self
    }

    /// The noise of an output column, one standard deviation in its unit; otherwise it is estimated.
    #[must_use]
    pub fn noise_std(mut self, channel: impl Into<String>, std: f64) -> Self {
        self.noise_std.push((channel.into(), std));
        self
    }

    /// For a leg: a column that is a command.
    #[must_use]
    pub fn input(mut self, channel: impl Into<String>) -> Self {
        self.inputs.push(channel.into());
        self
    }

    /// What the command does between its samples; without this it is held (zero order).
    #[must_use]
    pub fn hold(mut self, hold: InputHold) -> Self {
        self.hold = hold;
        self
    }

    /// The nominal sample rate, Hz; a clock that differs from it is remarked on.
    #[must_use]
    pub fn sample_rate_hz(mut self, rate: f64) -> Self {
        self.sample_rate_hz = Some(rate);
        self
    }

    /// For a free bench or a robot: runs are cut into pieces of so many seconds, each of which begins at the measured state.
    #[must_use]
    pub fn window_s(mut self, window_s: f64) -> Self {
        self.window_s = Some(window_s);
        self
    }

    /// For a robot: whether its controller adds the torques that hold it against gravity to those that the runs command.
    #[must_use]
    pub fn gravity_compensated(mut self, is_so: bool) -> Self {
        self.gravity_compensated = is_so;
        self
    }

    /// Checks everything as [`Campaign::read`] checks files.
    ///
    /// # Errors
    ///
    /// [`Error::BadFile`] with `(memory)/` and the run's name in place of a file, the row and the column.
    pub fn build(self) -> Result<Campaign, Error> {
        let file = Path::new(MEMORY).join(&self.name);
        let positive = |value: f64, key: &str| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => {
                let problem = format!("is {value}; must be positive and finite");
                Err(Error::bad(&file, None, Some(key), problem))
            }
        };
        for (channel, std) in &self.noise_std {
            positive(*std, &format!("noise_std.{channel}"))?;
        }
        if let Some(rate) = self.sample_rate_hz {
            positive(rate, "sample_rate_hz")?;
        }
        if let Some(window_s) = self.window_s {
            positive(window_s, "window_s")?;
            if !self.bench.may_begin_in_motion() {
                return Err(Error::bad(&file, None, Some("window_s"), windows::SUIT));
            }
        }
        if self.gravity_compensated && self.bench != Bench::Robot {
            return Err(Error::bad(&file, None, Some("gravity_compensated"), super::GRAVITY_SUITS));
        }
        if self.model.trim().is_empty() {
            let key = match self.bench {
                Bench::Leg => "scenario",
                Bench::Robot => "robot",
                _ => "actuator",
            };
            return Err(Error::bad(&file, None, Some(key), "is missing"));
        }
        if self.runs.is_empty() {
            return Err(Error::bad(&file, None, Some("run"), "a campaign needs at least one run"));
        }
        let mut runs: Vec<Run> = Vec::new();
        for run in &self.runs {
            if runs.iter().any(|r| r.record.name == run.name) {
                return Err(Error::bad(&file, None, Some("run"), format!("'{}' is there twice", run.name)));
            }
            runs.push(self.checked(run)?);
        }
        let (leg, robot) = (self.bench == Bench::Leg, self.bench == Bench::Robot);
        let description = Description {
            name: self.name,
            bench: self.bench,
            actuator: if leg || robot { String::new() } else { self.model.clone() },
            scenario: leg.then(|| self.model.clone()),
            robot: robot.then_some(self.model),
            gravity_compensated: self.gravity_compensated,
            model_line: None,
            inputs: self.inputs,
            sample_rate_hz: self.sample_rate_hz,
            hold: self.hold,
            noise_std: self.noise_std,
            runs: Vec::new(),
            notes: Vec::new(),
            misspelt: String::new(),
        };
        let (window_s, rate) = (self.window_s, description.sample_rate_hz);
        let runs =
            runs.into_iter().flat_map(|run| in_pieces(run, RunNotes::default(), window_s, rate)).collect();
        Ok(Campaign::assembled(description, file, runs))
    }

    /// One run, its columns sorted.
    fn checked(&self, run: &RunColumns) -> Result<Run, Error> {
        let path: PathBuf = Path::new(MEMORY).join(&run.name);
        let said = Said {
            bench: self.bench,
            leg_inputs: &self.inputs,
            sample_rate_hz: self.sample_rate_hz,
            hold: self.hold,
        };
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in &run.columns {
            if name.is_empty() {
                return Err(Error::bad(&path, None, None, format!("column {} has no name", names.len() + 1)));
            }
            if names.contains(&name.as_str()) {
                return Err(Error::bad(&path, None, Some(name), "is there twice"));
            }
            names.push(name);
        }
        check_columns(&path, Place::Whole, &names, said)?;
        let rows = run.columns.iter().find(|(n, _)| n == "time_s").map_or(0, |(_, v)| v.len());
        check_length(&path, rows)?;
        for (name, values) in &run.columns {
            if values.len() != rows {
                let problem = format!("has {} rows, time_s {rows}", values.len());
                return Err(Error::bad(&path, None, Some(name), problem));
            }
            if let Some(row) = values.iter().position(|v| !v.is_finite()) {
                let problem = format!("'{}' is not finite", values[row]);
                return Err(Error::bad(&path, Place::Row(row as u64 + 1), Some(name), problem));
            }
            if name == "time_s" {
                for (before, pair) in values.windows(2).enumerate() {
                    if pair[1] <= pair[0] {
                        let (problem, _) = time_fault(pair[1], pair[0]);
                        return Err(Error::bad(&path, Place::Row(before as u64 + 2), Some(name), problem));
                    }
                }
            }
        }
        let table = sort(run.columns.iter().cloned(), said);
        let record = Record {
            cut: false,
            name: run.name.clone(),
            time_s: table.time_s,
            hold: self.hold,
            inputs: table.inputs,
            outputs: table.outputs,
        };
        let scored = scored_rows(&record.time_s, run.from_s, run.to_s)
            .ok_or_else(|| Error::bad(&path, None, Some("from_s, to_s"), too_few_rows(&run.name)))?;
        if let Some(problem) = clock::too_long(&record.time_s) {
            return Err(Error::bad(&path, None, Some("time_s"), problem));
        }
        let clock = Clock::of(&record.time_s, self.sample_rate_hz);
        let scenario = run.scenario.clone();
        let left_out = LeftOut::of(&record);
        let rig = run.rig.clone();
        Ok(Run {
            role: run.role,
            scenario,
            rig,
            record,
            scored,
            left_out,
            unknown: table.unknown,
            clock,
            path,
            unit: run.unit.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Named = Vec<(&'static str, Vec<f64>)>;

    fn columns(rows: usize) -> Named {
        let time: Vec<f64> = (0..rows).map(|i| 1e-3 * i as f64).collect();
        let current: Vec<f64> = time.iter().map(|t| (60.0 * t).sin()).collect();
        let force: Vec<f64> =
            (0..rows).map(|i| 200.0 * current[i] + f64::from(i as u32 * 7919 % 11)).collect();
        vec![("time_s", time), ("current_a", current), ("force_1_n", force), ("note_m", vec![0.0; rows])]
    }

    fn built(run: RunColumns) -> Result<Campaign, Error> {
        Campaign::builder("knee", Bench::Locked, "thor-linear").run(run).build()
    }

    #[test]
    fn columns_in_memory_and_the_same_columns_in_a_file_make_the_same_campaign() {
        let folder = tempfile::tempdir().unwrap();
        let columns = columns(400);
        let mut text = columns.iter().map(|(n, _)| *n).collect::<Vec<_>>().join(",") + "\n";
        for i in 0..400 {
            let row: Vec<String> = columns.iter().map(|(_, v)| format!("{:?}", v[i])).collect();
            text += &(row.join(",") + "\n");
        }
        std::fs::write(folder.path().join("a.csv"), text).unwrap();
        let toml = "name = \"knee\"\nbench = \"locked\"\nactuator = \"thor-linear\"\n[noise_std]\nforce_1_n = 2.0\n\
                    [[run]]\nfile = \"a.csv\"\nrole = \"fit\"\nfrom_s = 0.05\n";
        std::fs::write(folder.path().join("campaign.toml"), toml).unwrap();
        let read = Campaign::read(folder.path()).unwrap();
        let built = Campaign::builder("knee", Bench::Locked, "thor-linear")
            .noise_std("force_1_n", 2.0)
            .run(RunColumns::new("a.csv", Role::Fit, columns).from_s(0.05))
            .build()
            .unwrap();
        assert_eq!(read.runs[0].record, built.runs[0].record);
        assert_eq!(read.runs[0].scored, built.runs[0].scored);
        assert_eq!(read.runs[0].unknown, built.runs[0].unknown);
        assert_eq!(read.noise, built.noise);
        assert_eq!(read.notes, built.notes);
        assert!(built.runs[0].is_in_memory() && !read.runs[0].is_in_memory());
    }

    #[test]
    fn what_a_file_may_not_hold_is_refused_by_run_row_and_column() {
        let message = |change: &dyn Fn(&mut Named)| {
            let mut columns = columns(40);
            change(&mut columns);
            built(RunColumns::new("a", Role::Fit, columns)).unwrap_err().to_string()
        };
        assert_eq!(
            message(&|c| c[2].1[7] = f64::NAN),
            "(memory)/a, row 8, column 'force_1_n': 'NaN' is not finite"
        );
        assert_eq!(
            message(&|c| c[0].1[3] = 0.0),
            "(memory)/a, row 4, column 'time_s': time goes back: 0 after 0.002"
        );
        assert_eq!(
            message(&|c| {
                c[2].1.pop();
            }),
            "(memory)/a, column 'force_1_n': has 39 rows, time_s 40"
        );
        assert!(
            message(&|c| {
                c.remove(1);
            })
            .contains("no input column")
        );
        assert!(message(&|c| c.iter_mut().for_each(|c| c.1.truncate(9))).contains("has 9 rows"));
        let run = RunColumns::new("a", Role::Fit, columns(40));
        let two = Campaign::builder("knee", Bench::Locked, "thor-linear").run(run.clone()).run(run).build();
        assert!(two.unwrap_err().to_string().contains("'a' is there twice"));
    }

    #[test]
    fn runs_of_a_free_bench_are_cut_into_pieces() {
        let free = |bench, window_s| {
            let mut columns = columns(400);
            columns[1].0 = "motor_force_n";
            columns[2].0 = "position_m";
            let run = RunColumns::new("slide", Role::Fit, columns).rig(RigValues::default());
            Campaign::builder("slide", bench, "rigid-linear").run(run).window_s(window_s).build()
        };
        let campaign = free(Bench::Free, 0.1).unwrap();
        let names: Vec<&str> = campaign.runs.iter().map(|r| r.record.name.as_str()).collect();
        assert_eq!(names, ["slide from 0.0 s", "slide from 0.1 s", "slide from 0.2 s", "slide from 0.3 s"]);
        assert!(free(Bench::Free, 0.0).unwrap_err().to_string().contains("must be positive"));
        assert!(free(Bench::Locked, 0.1).unwrap_err().to_string().contains("'free' and 'robot'"));
    }
}
