//! `sealegs import`: what is in other people's log files, and a first campaign file for them.

mod columns;
mod load;
mod parts;
mod rig;
mod robot;

use crate::failure::{OrBadInput, bad_input};
use crate::output::{Destination, NewFolder};
use clap::Args;
use load::Loads;
use parts::{Parts, parts, runs_of_parts};
use rig::{bench, rig};
use robot::KnownRobot;
use sealegs::diagnosis::text::figures;
use sealegs::logs::survey::{ClockSurvey, ColumnSurvey, Survey, TableSurvey, survey_named};
use sealegs::logs::{EPISODE, Log, Place, lerobot};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Component, Path, PathBuf};

/// Look into log files of any kind and write a first campaign file
#[derive(Args)]
pub struct Import {
    /// Log files (CSV, Parquet, MATLAB, JSON, NumPy, MCAP, Rerun), folders of ROS 2 bags or of datasets of LeRobot; each file becomes a run; files with different channels of the same time become one run. With the URDF of the robot among them columns get the names of its joints
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write campaign.toml into this folder, which is made if it is not there
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a file that cannot be read, or a folder that has a campaign file already.
pub fn run(arguments: &Import) -> anyhow::Result<u8> {
    let is_urdf = |file: &&PathBuf| file.extension().is_some_and(|e| e.eq_ignore_ascii_case("urdf"));
    let (urdfs, files): (Vec<&PathBuf>, Vec<&PathBuf>) = arguments.files.iter().partition(is_urdf);
    let robot = match urdfs[..] {
        [] => None,
        [urdf] => Some(KnownRobot::read(urdf)?),
        [_, second, ..] => {
            return Err(bad_input(format!("{}: a second URDF; a campaign has one robot", second.display())));
        }
    };
    if files.is_empty() {
        return Err(bad_input("no log file: a URDF says what moves, and a log how it moved".to_owned()));
    }
    let mut left_out = String::new();
    let files: Vec<PathBuf> = files.into_iter().flat_map(|file| rows_of(file, &mut left_out)).collect();
    let mut logs: Vec<(&Path, Log, Survey)> = Vec::new();
    for file in &files {
        let log = sealegs::logs::read(file).or_bad_input()?;
        let joints = lerobot::joint_names(file);
        let found = match &robot {
            Some(robot) => robot.survey(&log, &joints),
            None => survey_named(&log, &joints),
        };
        logs.push((file, log, found));
    }
    let mut out = robot.as_ref().map(|robot| format!("{}\n", robot.described())).unwrap_or_default();
    out.push_str(&left_out);
    let numbers = |table: &TableSurvey| table.columns.iter().any(|c| c.range.is_some());
    if let Some((file, ..)) = logs.iter().find(|(.., found)| !found.tables.iter().any(numbers)) {
        return Err(bad_input(format!("{}: holds no column of numbers", file.display())));
    }
    for (file, log, found) in &logs {
        describe(&mut out, file, log, found);
    }
    match &arguments.output {
        None => out.push_str("\nWith -o FOLDER a first campaign.toml is written for it.\n"),
        Some(folder) => {
            let text = campaign(folder, &logs, robot.as_ref())?;
            let file = folder.join("campaign.toml");
            if file.exists() {
                return Err(bad_input(format!("{}: is there already", file.display())));
            }
            if folder.is_dir() {
                Destination::new(&file)?.write(text.as_bytes())?;
            } else {
                NewFolder::new(folder)?.write([("campaign.toml", text.as_str())])?;
            }
            let _ = writeln!(out, "\n{} is written; complete what it marks with TODO.", file.display());
        }
    }
    write!(std::io::stdout().lock(), "{out}")?;
    Ok(0)
}

/// The files with rows that an argument stands for: of a dataset of LeRobot the first ones, else itself.
fn rows_of(file: &Path, left_out: &mut String) -> Vec<PathBuf> {
    let Some(mut files) = lerobot::data_files(file) else { return vec![file.to_owned()] };
    if files.len() > MOST_EPISODES {
        let _ = writeln!(
            left_out,
            "{}: {} files; the first {MOST_EPISODES} are read",
            file.display(),
            files.len()
        );
        files.truncate(MOST_EPISODES);
    }
    files
}

/// What is in a file, for people.
fn describe(out: &mut String, file: &Path, log: &Log, found: &Survey) {
    let _ = writeln!(out, "{}: {}", file.display(), log.format);
    if !log.constants.is_empty() {
        let constants: Vec<String> = log
            .constants
            .iter()
            .take(24)
            .map(|(name, value)| format!("{name} = {}", short(*value, 6)))
            .collect();
        let more = log.constants.len().saturating_sub(24);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let _ = writeln!(out, "  single numbers: {}{more}", constants.join(", "));
    }
    for table in &found.tables {
        let name = if table.name.is_empty() { String::new() } else { format!("{}: ", table.name) };
        let _ = writeln!(out, "\n  {name}{} rows{}", table.rows, clock(table));
        let widest = table.columns.iter().map(|c| c.name.chars().count()).max().unwrap_or(0).clamp(6, 48);
        for column in &table.columns {
            let _ = writeln!(out, "    {:<widest$}  {}", column.name, content(column));
        }
    }
    if log.tables.is_empty() {
        let _ = writeln!(out, "  no rows of numbers");
    }
    for note in &log.notes {
        let _ = writeln!(out, "  {note}");
    }
}

/// `, 24.84 s at 1000 Hz by 't'`.
fn clock(table: &TableSurvey) -> String {
    let Some(clock) = &table.clock else {
        return "; no column looks like time: state sample_rate_hz".to_owned();
    };
    let ClockSurvey { duration_s, rate_hz, jitter, gaps, longest_s, .. } = clock;
    let mut said = format!(
        ", {} s at {} Hz by '{}' in {}",
        short(*duration_s, 4),
        short(*rate_hz, 5),
        table.columns[clock.column].name,
        clock.unit
    );
    // A hundredth of a period is what the digits of a file may make.
    if *jitter > 0.01 {
        let _ = write!(said, "; steps vary by {:.0} %", 100.0 * jitter);
    }
    if *gaps > 0 {
        let _ = write!(said, "; {gaps} gap(s), the longest {} s", short(*longest_s, 3));
    }
    if let Some(at) = clock.stands {
        let _ = write!(said, "; time does not go on in {}", place(at));
    }
    said
}

fn place(at: Place) -> String {
    match at {
        Place::Whole => "the file".to_owned(),
        Place::Line(line) => format!("line {line}"),
        Place::Row(row) => format!("row {row}"),
    }
}

/// From where to where the numbers of a column go.
fn range(column: &ColumnSurvey) -> String {
    match column.range {
        None => "no numbers".to_owned(),
        Some((low, _)) if column.constant => format!("always {}", short(low, 6)),
        Some((low, high)) => format!("{} to {}", short(low, 5), short(high, 5)),
    }
}

/// Range, faults and likely role of a column.
fn content(column: &ColumnSurvey) -> String {
    let mut said = range(column);
    if let Some(holds) = &column.holds {
        let _ = write!(said, "; {holds}");
    }
    if let Some((at, problem)) = &column.fault {
        let _ = write!(said, "; {} cells without number, first in {}: {problem}", column.empty, place(*at));
    }
    // A sensor that is read twice as often as it measures stays for every second row.
    if !column.constant && column.unchanged > 0.4 {
        let _ = write!(said, "; stays as it was in {:.0} % of rows", 100.0 * column.unchanged);
    }
    if let Some(role) = &column.role {
        let settings = role.settings.as_ref().map_or_else(String::new, |s| format!(", {s}"));
        let _ = write!(said, "  -> {}{settings} ({})", role.target, role.reason);
    } else if let Some(aside) = &column.aside {
        let _ = write!(said, "  ({aside})");
    }
    said
}

/// A first campaign file for these logs and the robot, which lie relative to `folder`.
fn campaign(
    folder: &Path,
    logs: &[(&Path, Log, Survey)],
    robot: Option<&KnownRobot>,
) -> anyhow::Result<String> {
    let name = folder.file_name().map_or_else(|| "campaign".into(), |n| n.to_string_lossy());
    let mut out = format!(
        "# Made by `sealegs import`: complete what is marked with TODO, then `sealegs check` it.\n\
         name = {}\n",
        quoted(&name)
    );
    let urdf = robot.map(|robot| relative(folder, &robot.file)).transpose()?;
    // The keys are a pendulum's: another bench would refuse them.
    let loads = match bench(logs, urdf.is_some()) {
        "pendulum" => Loads::of(logs.iter().map(|(_, log, _)| log)),
        _ => Loads::default(),
    };
    out.push_str(&rig(logs, urdf.as_deref(), loads.say_load()));
    let mut said: Vec<String> = Vec::new();
    for (_, log, _) in logs.iter().filter(|(_, log, _)| !log.constants.is_empty()) {
        let numbers = log.constants.iter().map(|(name, value)| format!("{name} = {}", short(*value, 6)));
        let numbers = one_line(&numbers.collect::<Vec<_>>().join(", "));
        if !said.contains(&numbers) {
            let _ = writeln!(
                out,
                "# Single numbers in the log, perhaps keys of this file or of a [[run]]: {numbers}"
            );
            said.push(numbers);
        }
    }
    if logs.iter().all(|(_, _, s)| s.tables.first().is_none_or(|t| t.clock.is_none())) {
        let rate = logs.iter().find_map(|(_, log, _)| rate_hz(log));
        let (rate, why) = rate.unwrap_or((1000.0, "no column looks like time".to_owned()));
        let _ = writeln!(out, "# sample_rate_hz = {rate:?}    # TODO: {why}");
    }
    out.push_str(
        "\n# What the columns become: \"own name\" = \"channel\", or\n\
         # { as = \"channel\", scale = 1.0, offset = 0.0, sign = 1, unit = \"deg\", wrap = true }.\n\
         # The end of a channel's name is its SI unit. TODO: check every guess.\n[columns]\n",
    );
    out.push_str(&columns::lines(logs));
    if let Some(parts) = parts(logs) {
        out.push_str(&one_run(folder, logs, &parts)?);
        return Ok(out);
    }
    let mut runs: Vec<(&Path, String)> = Vec::new();
    let parted = runs_of_parts(logs).unwrap_or_default();
    for run in &parted {
        let files = run.iter().map(|&i| Ok(quoted(&relative(folder, logs[i].0)?)));
        let files = files.collect::<anyhow::Result<Vec<_>>>()?.join(", ");
        runs.push((logs[run[0]].0, format!("files = [{files}]\n{}", loads.lines(&logs[run[0]].1))));
    }
    for (file, log, _) in logs.iter().filter(|_| parted.is_empty()) {
        let name = quoted(&relative(folder, file)?);
        let episodes = episodes(log);
        if episodes.len() > MOST_EPISODES {
            let _ = write!(out, "\n# {name} has {} episodes; the first are below.\n", episodes.len());
        }
        match episodes.is_empty() {
            true => runs.push((file, format!("file = {name}\n{}", loads.lines(log)))),
            false => runs.extend(
                episodes
                    .iter()
                    .take(MOST_EPISODES)
                    .map(|e| (*file, format!("file = {name}\nepisode = {e}\n"))),
            ),
        }
    }
    // Runs that are called so are kept back, to judge; else one of several, and of many each fourth.
    let called: Vec<bool> = runs.iter().map(|(file, _)| is_called_holdout(file)).collect();
    let by_name = called.contains(&true) && called.contains(&false);
    let kept_back = |i: usize| match by_name {
        true => called[i],
        false => i > 0 && (i + 1 == runs.len() || i % 4 == 3),
    };
    for (i, (_, run)) in runs.iter().enumerate() {
        let role = if kept_back(i) { "holdout" } else { "fit" };
        let _ = write!(out, "\n[[run]]\n{run}role = \"{role}\"\n");
    }
    if runs.len() == 1 {
        out.push_str(
            "# TODO: a run with role = \"holdout\", which the fit does not see: another one, or the same file with\n\
             # to_s = … here and from_s = … there\n",
        );
    }
    Ok(out)
}

/// The run that files are parts of.
fn one_run(folder: &Path, logs: &[(&Path, Log, Survey)], parts: &Parts) -> anyhow::Result<String> {
    let said = match parts {
        Parts::SameStamps => "the files have the same clock and different columns.",
        Parts::OneClock => "the files have different channels, at times that overlap.",
        Parts::OwnClocks(_) => {
            "the files have different channels and are as long as each other, and their clocks do not meet. TODO: each\n\
             # offset_s lets its file begin with the first one; state when it did. If they are runs, each needs a [[run]]."
        }
    };
    let files: Vec<String> = logs
        .iter()
        .enumerate()
        .map(|(i, (file, ..))| {
            let file = quoted(&relative(folder, file)?);
            Ok(match parts {
                Parts::OwnClocks(offsets) if offsets[i] != 0.0 => {
                    format!("{{ file = {file}, offset_s = {:.6} }}", offsets[i])
                }
                _ => file,
            })
        })
        .collect::<anyhow::Result<_>>()?;
    Ok(format!(
        "\n# One run: {said}\n[[run]]\nfiles = [{}]\nrole = \"fit\"\n\
         # TODO: a run with role = \"holdout\", which the fit does not see: another one, or the same files with\n\
         # to_s = … here and from_s = … there\n",
        files.join(", ")
    ))
}

/// The rate of a log without a clock, by a single number in it that is called so, and which.
fn rate_hz(log: &Log) -> Option<(f64, String)> {
    let named = |(name, value): &(String, f64)| {
        let own = name.rsplit('.').next().unwrap_or(name).to_lowercase();
        let own: String = own.chars().filter(|c| c.is_alphanumeric()).collect();
        // `Delta_X` is LabVIEW's; instruments write the others above their tables.
        let rate = match own.as_str() {
            "dt" | "ts" | "samplingperiod" | "samplingtime" | "sampletime" | "sampleinterval"
            | "timestep" | "deltax" => 1.0 / value,
            "fs" | "rate" | "ratehz" | "samplerate" | "sampleratehz" | "samplingrate"
            | "samplingfrequency" | "frequency" => *value,
            _ => return None,
        };
        (rate.is_finite() && rate > 0.0)
            .then(|| (rate, format!("no column looks like time; by '{name}' = {}", short(*value, 6))))
    };
    log.constants.iter().find_map(named)
}

/// Whether a run's file is called as one that judges, `check.csv` or `run_test_2.csv`.
fn is_called_holdout(file: &Path) -> bool {
    const CALLED: [&str; 6] = ["check", "test", "holdout", "heldout", "valid", "validation"];
    let name = file.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    name.split(|c: char| !c.is_alphabetic()).any(|word| CALLED.contains(&word))
}

/// Episodes of a file that become runs: more cost a search time and tell it little.
const MOST_EPISODES: usize = 12;

/// The episodes in a log, where its rows belong to several.
fn episodes(log: &Log) -> Vec<i64> {
    let column = log.tables.iter().find_map(|table| table.column(EPISODE));
    let values = column.map(|c| c.values.iter().filter(|v| v.is_finite()).map(|v| *v as i64));
    let all: BTreeSet<i64> = values.into_iter().flatten().collect();
    if all.len() > 1 { all.into_iter().collect() } else { Vec::new() }
}

/// A number with at most so many digits, without zeros that say nothing.
fn short(value: f64, digits: usize) -> String {
    let text = figures(value, digits);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A text as a TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A text that breaks no comment.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// How the campaign file names a log: from the folder; by its whole path where the two share no folder but the root.
fn relative(folder: &Path, file: &Path) -> anyhow::Result<String> {
    let file = std::fs::canonicalize(file).or_bad_input()?;
    Ok(seen_from(&whole(folder).or_bad_input()?, &file).to_string_lossy().into_owned())
}

/// The whole path of a folder, which may have to be made yet.
fn whole(folder: &Path) -> std::io::Result<PathBuf> {
    match (std::fs::canonicalize(folder), folder.parent(), folder.file_name()) {
        (Err(_), Some(parent), Some(name)) => {
            let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
            Ok(whole(parent)?.join(name))
        }
        (found, ..) => found,
    }
}

/// A file as it is called in a folder, both by their whole paths.
fn seen_from(folder: &Path, file: &Path) -> PathBuf {
    let shared: PathBuf =
        folder.components().zip(file.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect();
    let (Ok(up), Ok(down)) = (folder.strip_prefix(&shared), file.strip_prefix(&shared)) else {
        return file.to_owned();
    };
    if shared.parent().is_none() && !up.as_os_str().is_empty() {
        return file.to_owned();
    }
    up.components().map(|_| Component::ParentDir).chain(down.components()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_is_named_from_the_campaigns_folder() {
        let name = |folder: &str, file: &str| seen_from(Path::new(folder), Path::new(file));
        assert_eq!(name("/a/b", "/a/b/logs/x.csv"), Path::new("logs/x.csv"));
        assert_eq!(name("/a/b/c", "/a/logs/x.csv"), Path::new("../../logs/x.csv"));
        assert_eq!(name("/a/b", "/x.csv"), Path::new("/x.csv"));
        assert_eq!(name("/a/b", "/c/x.csv"), Path::new("/c/x.csv"));
    }
}
