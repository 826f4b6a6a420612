//! One run's table, whatever it was stored as: what is asked of its columns, and the columns sorted by what they are.

use super::file::{RunEntry, did_you_mean};
use super::{
    Bench, FEWEST_ROWS, INPUT_COLUMNS, JOINT_COMMANDS, OUTPUT_COLUMNS, SIDE_COLUMNS, commanded_joint,
};
use crate::{Error, Place};
use sealegs_logs::columns::ColumnMap;
use sealegs_logs::join::{self, JoinError, Request};
use sealegs_logs::{Format, Log, is_time};
use sealegs_model::{InputHold, Signal, Unit};
use std::path::Path;

/// A run's columns, sorted by what they are.
#[derive(Debug)]
pub(super) struct Table {
    pub time_s: Vec<f64>,
    pub inputs: Vec<Signal>,
    pub outputs: Vec<Signal>,
    pub unknown: Vec<Signal>,
    /// What a person should know of the columns, where the campaign maps them.
    pub notes: Vec<String>,
}

/// What a campaign says of the columns of its runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Said<'a> {
    pub bench: Bench,
    /// A leg's columns that are commands; every run must have them all.
    pub leg_inputs: &'a [String],
    pub sample_rate_hz: Option<f64>,
    pub hold: InputHold,
}

impl Said<'_> {
    fn is_input(&self, channel: &str) -> bool {
        let bench =
            !self.bench.has_joints() && (INPUT_COLUMNS.contains(&channel) || SIDE_COLUMNS.contains(&channel));
        let joint = self.bench == Bench::Robot && (is_joint_command(channel) || is_beside(channel));
        bench || joint || self.leg_inputs.iter().any(|i| i == channel)
    }

    fn is_output(&self, channel: &str) -> bool {
        // The stamp of a message's header is no measurement.
        let measured = Unit::of_channel(channel).is_ok_and(|unit| unit != Unit::Second);
        let of_a_leg = self.bench.has_joints() && channel.contains('.') && measured;
        !self.is_input(channel) && (of_a_leg || OUTPUT_COLUMNS.contains(&channel))
    }
}

/// Reads a run's files, which lie in this folder; `campaign` is the file that errors of its lines name.
pub(super) fn read(campaign: &Path, folder: &Path, run: &RunEntry, said: Said) -> Result<Table, Error> {
    let mut files = Vec::new();
    for entry in &run.files {
        let path = folder.join(&entry.file);
        let log = sealegs_logs::read(&path)?;
        files.push(join::File { path, label: entry.file.clone(), offset_s: entry.offset_s, log });
    }
    match (&run.columns, &mut files[..]) {
        (None, [file]) if run.episode.is_none() => plain(&file.path, std::mem::take(&mut file.log), said),
        (columns, _) => mapped(campaign, run, columns.as_deref().unwrap_or_default(), files, said),
    }
}

/// The table of a file that has the contract's own names.
pub(super) fn plain(path: &Path, mut log: Log, said: Said) -> Result<Table, Error> {
    if log.tables.len() > 1 {
        let names: Vec<&str> = log.tables.iter().map(|t| t.name.as_str()).collect();
        let problem =
            format!("has {} tables ({}); map their columns in [columns]", names.len(), names.join(", "));
        return Err(Error::bad(path, None, None, problem));
    }
    let Some(table) = log.tables.pop() else {
        return Err(Error::bad(path, None, None, format!("has no rows of numbers{}", of_notes(&log))));
    };
    let header = header_of(path);
    if table.headerless {
        return Err(Error::bad(path, header, None, "no header: the first row must hold the columns' names"));
    }
    let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
    for column in &table.columns {
        if let Some(number) = column.name.strip_prefix('#') {
            return Err(Error::bad(path, header, None, format!("column {number} has no name")));
        }
        let list = column.name.split_once('[').filter(|_| Unit::of_channel(&column.name).is_err());
        if let Some((list, _)) = list {
            let problem = "holds lists; a column must hold one number per row, or be mapped in [columns]";
            return Err(Error::bad(path, Place::Row(1), Some(list), problem));
        }
    }
    check_columns(path, header, &names, said)?;
    for column in &table.columns {
        // A fault in the first row is named below, with what the cell holds.
        if let Some(holds) = column.holds.as_ref().filter(|_| column.fault.is_none()) {
            let problem = format!(
                "holds {holds}; a column must hold floating-point or integer numbers, or be mapped in [columns]"
            );
            return Err(Error::bad(path, table.places.of(0), Some(&column.name), problem));
        }
    }
    // The fault of the first row, and in it of the first column; time that does not go on is one.
    let cells = table.columns.iter().filter_map(|c| Some((c.fault.as_ref()?.row, c)));
    let fault = cells.min_by_key(|(row, _)| *row);
    let time = table.column("time_s").map(|c| c.values.as_slice()).unwrap_or_default();
    let stands = time.windows(2).position(|w| w[1] <= w[0]).map(|i| i + 1);
    match (fault, stands) {
        (Some((row, column)), stands) if stands.is_none_or(|s| row <= s) => {
            let problem = column.fault.as_ref().map(|f| f.problem.clone()).unwrap_or_default();
            return Err(Error::bad(path, table.places.of(row), Some(&column.name), problem));
        }
        (_, Some(row)) => {
            let (fault, cure) = join::time_fault(time[row], time[row - 1]);
            let problem = format!("{fault}; {cure}");
            return Err(Error::bad(path, table.places.of(row), Some("time_s"), problem));
        }
        _ => {}
    }
    check_length(path, table.rows())?;
    let mut sorted = sort(table.columns.into_iter().map(|c| (c.name.clone(), c.into_absolute())), said);
    if Format::has_lines(path) {
        sorted.notes = log.notes;
    }
    Ok(sorted)
}

/// The table of files whose columns are mapped, or of several files.
fn mapped(
    campaign: &Path,
    run: &RunEntry,
    columns: &[super::columns::MappedColumn],
    files: Vec<join::File>,
    said: Said,
) -> Result<Table, Error> {
    let maps: Vec<ColumnMap> = columns.iter().map(|c| c.map.clone()).collect();
    let first = files[0].path.clone();
    let request = Request {
        columns: &maps,
        sample_rate_hz: said.sample_rate_hz,
        episode: run.episode,
        known: &|name| said.is_input(name) || said.is_output(name),
        held: &|name| said.hold == InputHold::ZeroOrder && said.is_input(name),
    };
    let name = run.name();
    let joined = join::join(files, &request).map_err(|error| match error {
        JoinError::File(error) => error.into(),
        JoinError::Map(index, problem) => {
            let key = format!("columns.{}", maps[index].source);
            Error::bad(campaign, columns[index].line, Some(&key), problem)
        }
        JoinError::Run(problem) => Error::bad(campaign, run.line, Some("file"), format!("{name}: {problem}")),
    })?;
    let channels: Vec<&str> =
        joined.channels.iter().map(|(n, _)| n.as_str()).chain(std::iter::once("time_s")).collect();
    check_columns(&first, header_of(&first), &channels, said)?;
    check_length(&first, joined.time_s.len())?;
    // What is not known keeps the file's own name, whatever it means.
    let mut table = sort(joined.channels.into_iter(), said);
    table.time_s = joined.time_s;
    table.unknown.extend(joined.others.into_iter().map(|(channel, values)| Signal { channel, values }));
    table.notes = joined.notes;
    Ok(table)
}

/// What a log's notes say, behind a message.
fn of_notes(log: &Log) -> String {
    log.notes.first().map_or_else(String::new, |note| format!(": {note}"))
}

/// Where a run's file says what its columns are called.
pub(super) fn header_of(path: &Path) -> Place {
    if Format::has_lines(path) && !super::memory::is_in_memory(path) { Place::Line(1) } else { Place::Whole }
}

/// Time, exactly one input, known units.
pub(super) fn check_columns(path: &Path, at: Place, words: &[&str], said: Said) -> Result<(), Error> {
    if let Some(missing) = said.leg_inputs.iter().find(|i| !words.contains(&i.as_str())) {
        return Err(Error::bad(path, at, Some(missing), "is missing; the campaign's 'inputs' names it"));
    }
    for name in words {
        // A name without an underscore carries no unit at all (`index`): kept, as unknown. So is the index
        // that pandas writes beside the columns of a table of which rows were left out.
        if name.contains('_')
            && !name.starts_with("__index_level_")
            && let Err(error) = Unit::of_channel(name)
        {
            return Err(Error::bad(path, at, Some(name), format!("{error}; or map it in [columns]")));
        }
    }
    if !words.contains(&"time_s") {
        let hint =
            words.iter().find(|word| is_time(word)).map_or_else(String::new, |w| format!(" (found '{w}')"));
        let problem = format!(
            "is missing{hint}; map a column onto it in the campaign's [columns], or state sample_rate_hz beside them"
        );
        return Err(Error::bad(path, at, Some("time_s"), problem));
    }
    if said.bench == Bench::Robot && !words.iter().any(|w| is_joint_command(w)) {
        let problem = format!(
            "no input column; a robot's joints are commanded by '<joint>.{}'",
            JOINT_COMMANDS.join("', '.")
        );
        return Err(Error::bad(path, at, None, problem));
    }
    if said.bench.has_joints() {
        return Ok(());
    }
    let inputs: Vec<&str> = words.iter().copied().filter(|w| INPUT_COLUMNS.contains(w)).collect();
    match inputs.len() {
        1 => Ok(()),
        0 => {
            // What is a sensor's name is no misspelt command, however near it comes.
            let strange = words.iter().filter(|w| **w != "time_s" && !said.is_output(w) && !is_beside(w));
            let near = strange.map(|w| did_you_mean(w, &INPUT_COLUMNS)).find(|s| !s.is_empty());
            let problem = format!(
                "no input column; one of {} is needed{} A command that did not change and was not logged is stated in \
                 [columns]: \"not logged\" = {{ as = \"voltage_v\", constant = 12.0 }}",
                INPUT_COLUMNS.join(", "),
                near.unwrap_or_else(|| ".".to_owned())
            );
            Err(Error::bad(path, at, None, problem))
        }
        _ => Err(Error::bad(
            path,
            at,
            Some(inputs[1]),
            format!("two input columns at once: {}", inputs.join(", ")),
        )),
    }
}

/// Whether a robot's column commands a joint.
fn is_joint_command(name: &str) -> bool {
    commanded_joint(name).is_some()
}

/// Whether a drive, at a joint or alone, reads the column beside its command.
fn is_beside(name: &str) -> bool {
    SIDE_COLUMNS.contains(&name.rsplit_once('.').map_or(name, |(_, what)| what))
}

/// There must be enough rows.
pub(super) fn check_length(path: &Path, rows: usize) -> Result<(), Error> {
    if rows >= FEWEST_ROWS {
        return Ok(());
    }
    Err(Error::bad(path, None, None, format!("has {rows} rows; at least {FEWEST_ROWS} are needed")))
}

/// The columns by what they are; what a drive reads beside its command comes behind it.
pub(super) fn sort(columns: impl Iterator<Item = (String, Vec<f64>)>, said: Said) -> Table {
    let mut table = Table {
        time_s: Vec::new(),
        inputs: Vec::new(),
        outputs: Vec::new(),
        unknown: Vec::new(),
        notes: Vec::new(),
    };
    for (channel, values) in columns {
        let of_leg = said.bench.has_joints() && channel.contains('.');
        if channel == "time_s" {
            table.time_s = values;
        } else if said.is_input(&channel) {
            table.inputs.push(Signal { channel, values });
        } else if of_leg || said.is_output(&channel) {
            table.outputs.push(Signal { channel, values });
        } else {
            table.unknown.push(Signal { channel, values });
        }
    }
    table.inputs.sort_by_key(|s| is_beside(&s.channel));
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_may_have_dots_in_its_name() {
        assert!(is_joint_command("left.elbow.torque_nm") && is_beside("left.elbow.enable"));
        assert!(
            is_beside("supply_v") && !is_joint_command("torque_nm") && !is_joint_command("elbow.angle_rad")
        );
    }
}
