//! The columns of a run on one clock, whatever tables and files they stand in.
//!
//! The first file's clock leads; of several tables in it, that of the column that `[columns]` names first. Columns of
//! other tables and files are interpolated linearly at its stamps, commands that are held between their samples are held
//! here too. Rows of the leader that another table does not cover are left out, with a remark.

mod clock;
mod resolve;

use crate::columns::ColumnMap;
use crate::table::{Column, Log, Table};
use crate::{LogError, Places, lerobot};
pub(crate) use clock::counter;
pub use clock::time_fault;
use clock::{clock, gap, resampled};
use resolve::{keep_episode, resolve};
use std::path::PathBuf;

/// One file of a run.
#[derive(Debug, Clone)]
pub struct File {
    /// Where it was read from.
    pub path: PathBuf,
    /// What the campaign calls it.
    pub label: String,
    /// What is added to its clock, s.
    pub offset_s: f64,
    /// Its content.
    pub log: Log,
}

/// What a campaign asks of the files of a run.
pub struct Request<'a> {
    /// The column maps that apply.
    pub columns: &'a [ColumnMap],
    /// Makes the time where no column has it, Hz.
    pub sample_rate_hz: Option<f64>,
    /// Only rows whose `episode_index` is this.
    pub episode: Option<i64>,
    /// Whether a column of this name is taken as it is, without a map.
    pub known: &'a dyn Fn(&str) -> bool,
    /// Whether a channel is held from one sample to the next.
    pub held: &'a dyn Fn(&str) -> bool,
}

/// A run on one clock.
#[derive(Debug, Clone, Default)]
pub struct Joined {
    /// Strictly increasing time, s. It starts at zero, unless it is a column `time_s` that no map touches.
    pub time_s: Vec<f64>,
    /// The channels that were asked for or known.
    pub channels: Vec<(String, Vec<f64>)>,
    /// Columns beside them in the leading table, as they are.
    pub others: Vec<(String, Vec<f64>)>,
    /// Where the rows stood in the first file.
    pub places: Places,
    /// What a person should know, one line each.
    pub notes: Vec<String>,
}

/// Why there is no such run.
#[derive(Debug, Clone, PartialEq)]
pub enum JoinError {
    /// The column map of this index names nothing, or too much.
    Map(usize, String),
    /// The run as a whole asks for what its files do not have.
    Run(String),
    /// A file is at fault.
    File(LogError),
}

impl From<LogError> for JoinError {
    fn from(error: LogError) -> Self {
        Self::File(error)
    }
}

/// Stamps are the same if they differ by less, s.
const SAME_S: f64 = 1e-9;

/// A column in its file and table.
#[derive(Clone, Copy, PartialEq)]
struct At {
    file: usize,
    table: usize,
    column: usize,
}

/// A channel to be made.
struct Wanted {
    at: At,
    map: ColumnMap,
}

/// Puts the channels of a run on one clock.
///
/// # Errors
///
/// [`JoinError`] for a map that names no column or several, a cell that is no finite number in a channel, time that
/// repeats or goes back, and clocks that do not overlap.
pub fn join(mut files: Vec<File>, request: &Request) -> Result<Joined, JoinError> {
    let mut notes = Vec::new();
    if let Some(episode) = request.episode {
        keep_episode(&mut files, episode)?;
    }
    let (wanted, clocks) = resolve(&files, request)?;
    let mut tables: Vec<(usize, usize)> = Vec::new();
    for w in &wanted {
        if !tables.contains(&(w.at.file, w.at.table)) {
            tables.push((w.at.file, w.at.table));
        }
    }
    tables.sort_by_key(|&(file, _)| file);
    let Some(&lead) = tables.first() else {
        return Err(JoinError::Run(format!(
            "no column is mapped, and none is known; there are {}",
            names(&files)
        )));
    };
    for w in &wanted {
        usable(&files, w)?;
    }
    for (f, file) in files.iter().enumerate().filter(|(f, _)| tables.iter().all(|t| t.0 != *f)) {
        notes.push(format!("{}: no channel is made of file {}", file.label, f + 1));
    }
    let leader = clock(&files, lead, &clocks, request, tables.len() == 1, &mut notes)?;
    let lead_time = leader.time_s.as_slice();

    let mut span = 0..lead_time.len();
    let mut followers = Vec::new();
    for &at in &tables[1..] {
        let clock = clock(&files, at, &clocks, request, false, &mut notes)?;
        let shift = clock.after(&leader);
        let time: Vec<f64> = clock.time_s.iter().map(|t| t + shift).collect();
        let (first, last) = (time[0], time[time.len() - 1]);
        let from = lead_time.partition_point(|&t| t < first - SAME_S);
        let to = lead_time.partition_point(|&t| t <= last + SAME_S);
        let name = title(&files, at);
        if from >= to {
            let problem = format!(
                "{} covers {first:.6e} s to {last:.6e} s of the first clock, which has 0 s to {:.6e} s; \
                 `offset_s = {:.6}` lets both begin together",
                table_title(&files, at),
                lead_time[lead_time.len() - 1],
                files[at.0].offset_s - shift
            );
            return Err(LogError::whole(&files[at.0].path, problem).into());
        }
        if from > span.start || to < span.end {
            notes.push(format!(
                "{} of {} rows are left out: {name} does not cover them",
                from.saturating_sub(span.start) + span.end.saturating_sub(to),
                lead_time.len()
            ));
        }
        span = span.start.max(from)..span.end.min(to);
        let same =
            time.len() == lead_time.len() && time.iter().zip(lead_time).all(|(a, b)| (a - b).abs() < SAME_S);
        if !same {
            notes.push(format!("{name} is brought to the clock of {}", title(&files, lead)));
            notes.extend(gap(&time, &name));
        }
        followers.push((at, time, same));
    }
    if span.len() < 2 {
        return Err(JoinError::Run("its files have no two rows in common".to_owned()));
    }

    let mut channels = Vec::new();
    for w in &wanted {
        let source = column(&files, w.at);
        let values = match source.origin {
            0 => w.map.apply(&source.values),
            _ => w.map.apply(&source.clone().into_absolute()),
        };
        // Finite numbers of the file may be beyond all doubles once they are scaled.
        if let Some(row) = values.iter().position(|v| !v.is_finite()) {
            let table = table(&files, (w.at.file, w.at.table));
            let (at, name) = (table.places.of(row), table.full_name(source));
            let problem = format!("'{}' is not finite as {}", source.values[row], w.map.target);
            return Err(LogError::new(&files[w.at.file].path, at, Some(&name), problem).into());
        }
        let values = match followers.iter().find(|(at, ..)| *at == (w.at.file, w.at.table)) {
            None | Some((_, _, true)) => values[span.clone()].to_vec(),
            Some((_, time, false)) => {
                resampled(time, &values, &lead_time[span.clone()], (request.held)(&w.map.target))
            }
        };
        channels.push((w.map.target.clone(), values));
    }
    for (index, map) in request.columns.iter().enumerate() {
        let Some(value) = map.constant else { continue };
        if channels.iter().any(|(name, _)| *name == map.target) {
            return Err(JoinError::Map(index, format!("'{}' is in the file, or constant twice", map.target)));
        }
        channels.push((map.target.clone(), vec![value; span.len()]));
    }
    let zero = lead_time[span.start];
    let time_s: Vec<f64> = match leader.column.filter(|_| leader.own_zero) {
        // Unchanged to the last bit.
        Some(c) => table(&files, lead).columns[c].values[span.clone()].to_vec(),
        None => lead_time[span.clone()].iter().map(|t| t - zero).collect(),
    };
    let label = files[lead.0].label.clone();
    let table = &mut files[lead.0].log.tables[lead.1];
    if span.len() < table.rows() {
        table.keep(&span.clone().collect::<Vec<_>>());
    }
    let taken = |c: usize| {
        leader.column == Some(c)
            || wanted.iter().any(|w| w.at == At { file: lead.0, table: lead.1, column: c })
    };
    let mut others = Vec::new();
    for (c, column) in table.columns.iter_mut().enumerate().filter(|(c, _)| !taken(*c)) {
        if channels.iter().any(|(name, _)| *name == column.name) {
            continue;
        }
        match &column.fault {
            Some(fault) => notes.push(format!(
                "{}: column {} '{}' is left out: {} in {}",
                label,
                c + 1,
                column.name,
                fault.problem,
                match table.places.of(fault.row) {
                    crate::Place::Line(n) => format!("line {n}"),
                    crate::Place::Row(n) => format!("row {n}"),
                    crate::Place::Whole => "the file".to_owned(),
                }
            )),
            None => others.push((column.name.clone(), std::mem::take(column).into_absolute())),
        }
    }
    let told = others.iter().map(|(n, _)| n.as_str()).filter(|n| !lerobot::BOOKKEEPING.contains(n));
    let names: Vec<&str> = told.collect();
    if !names.is_empty() {
        notes.push(format!(
            "{}: no channel is made of {}; kept, and compared with nothing",
            label,
            some(&names)
        ));
    }
    Ok(Joined { time_s, channels, others, places: std::mem::take(&mut table.places), notes })
}

fn column(files: &[File], at: At) -> &Column {
    &files[at.file].log.tables[at.table].columns[at.column]
}

fn table(files: &[File], (file, table): (usize, usize)) -> &Table {
    &files[file].log.tables[table]
}

/// What a table is called in remarks.
fn title(files: &[File], at: (usize, usize)) -> String {
    let (file, name) = (&files[at.0].label, &table(files, at).name);
    match files[at.0].log.tables.iter().filter(|t| t.name == *name).count() {
        1 if name.is_empty() => file.clone(),
        1 => format!("{file}: {name}"),
        // One that was cut by the rows that its columns have numbers in.
        _ => table(files, at).columns.last().map_or(String::new(), |c| format!("{file}: '{}'", c.name)),
    }
}

/// What a table is called where the file has been named.
fn table_title(files: &[File], at: (usize, usize)) -> String {
    let table = &table(files, at).name;
    if table.is_empty() { "its clock".to_owned() } else { format!("'{table}'") }
}

/// A few of the names, and how many more there are.
pub(crate) fn some(names: &[&str]) -> String {
    const SHOWN: usize = 12;
    let shown = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN { format!("{shown} and {} more", names.len() - SHOWN) } else { shown }
}

/// What there is.
fn names(files: &[File]) -> String {
    let names: Vec<String> = files
        .iter()
        .flat_map(|f| f.log.tables.iter().flat_map(|t| t.columns.iter().map(|c| t.full_name(c))))
        .collect();
    some(&names.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Every cell of a channel must be a finite number.
fn usable(files: &[File], wanted: &Wanted) -> Result<(), LogError> {
    let (file, table) = (&files[wanted.at.file], table(files, (wanted.at.file, wanted.at.table)));
    let column = column(files, wanted.at);
    match &column.fault {
        Some(fault) => {
            let name = table.full_name(column);
            Err(LogError::new(&file.path, table.places.of(fault.row), Some(&name), fault.problem.clone()))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
