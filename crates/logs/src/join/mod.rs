//! The columns of a run on one clock, whatever tables and files they stand in.
//!
//! The first file's clock leads; of several tables in it, that of the column that `[columns]` names first. Columns of
//! other tables and files are interpolated linearly at its stamps, commands that are held between their samples are held
//! here too. Rows of the leader that another table does not cover are left out, with a remark.

use crate::columns::{ColumnMap, unwrapped};
use crate::table::{Column, Log, Table};
use crate::{LogError, Places};
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

/// The column of LeRobot's tables that says to which recording a row belongs.
const EPISODE: &str = "episode_index";

/// Stamps are the same if they differ by less, s.
const SAME_S: f64 = 1e-9;

/// A step of more periods than this is a gap, over which nothing should be interpolated unsaid.
const GAP: f64 = 5.0;

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

/// Time stamps of a table from its own zero, and where that zero is.
struct Clock {
    time_s: Vec<f64>,
    /// The first stamp as the column has it, and by what that is multiplied.
    origin: i64,
    first: f64,
    scale: f64,
    offset_s: f64,
    column: Option<usize>,
    /// Whether the column's own zero stays.
    own_zero: bool,
}

impl Clock {
    /// The first stamp, s.
    fn start(&self) -> f64 {
        (self.origin as f64 + self.first) * self.scale + self.offset_s
    }

    /// How much later than `other` it starts, s.
    fn after(&self, other: &Self) -> f64 {
        if self.scale == other.scale {
            let whole = self.origin.wrapping_sub(other.origin) as f64;
            (whole + (self.first - other.first)) * self.scale + (self.offset_s - other.offset_s)
        } else {
            self.start() - other.start()
        }
    }
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
                 state its offset_s",
                table_title(&files, at),
                lead_time[lead_time.len() - 1]
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
        let values = match followers.iter().find(|(at, ..)| *at == (w.at.file, w.at.table)) {
            None | Some((_, _, true)) => values[span.clone()].to_vec(),
            Some((_, time, false)) => {
                resampled(time, &values, &lead_time[span.clone()], (request.held)(&w.map.target))
            }
        };
        channels.push((w.map.target.clone(), values));
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
    if !others.is_empty() {
        let names: Vec<&str> = others.iter().map(|(n, _)| n.as_str()).collect();
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
    let (file, table) = (&files[at.0].label, &table(files, at).name);
    if table.is_empty() { file.clone() } else { format!("{file}: {table}") }
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

/// Leaves the rows of one episode in every table that has such.
fn keep_episode(files: &mut [File], episode: i64) -> Result<(), JoinError> {
    let mut found = false;
    for file in files {
        for table in &mut file.log.tables {
            let Some(index) = table.column(EPISODE) else { continue };
            found = true;
            let rows: Vec<usize> =
                (0..index.values.len()).filter(|&r| index.values[r] == episode as f64).collect();
            if rows.is_empty() {
                let (low, high) = index
                    .values
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
                let problem = format!("has no episode {episode}; it has {low} to {high}");
                return Err(LogError::new(&file.path, None, Some(EPISODE), problem).into());
            }
            table.keep(&rows);
        }
    }
    if found { Ok(()) } else { Err(JoinError::Run(format!("no file has a column '{EPISODE}'"))) }
}

/// The columns that a source names.
fn hits(files: &[File], source: &str) -> Vec<At> {
    let mut hits = Vec::new();
    for (f, file) in files.iter().enumerate() {
        let inside = source.strip_prefix(file.label.as_str()).and_then(|rest| rest.strip_prefix(':'));
        for (t, table) in file.log.tables.iter().enumerate() {
            for (c, column) in table.columns.iter().enumerate() {
                let named = |name: &str| {
                    column.name == name
                        || name.strip_prefix(table.name.as_str()).and_then(|r| r.strip_prefix('.'))
                            == Some(column.name.as_str())
                };
                if named(source) || inside.is_some_and(named) {
                    hits.push(At { file: f, table: t, column: c });
                }
            }
        }
    }
    hits
}

/// Which column becomes which channel, and which columns are clocks.
fn resolve(files: &[File], request: &Request) -> Result<(Vec<Wanted>, Vec<Wanted>), JoinError> {
    let (mut wanted, mut clocks): (Vec<Wanted>, Vec<Wanted>) = (Vec::new(), Vec::new());
    for (index, map) in request.columns.iter().enumerate() {
        let hits = hits(files, &map.source);
        if hits.is_empty() && map.optional {
            continue;
        }
        if hits.is_empty() {
            return Err(JoinError::Map(index, nothing_like(files, &map.source)));
        }
        if map.target == "time_s" {
            clocks.extend(hits.into_iter().map(|at| Wanted { at, map: map.clone() }));
            continue;
        }
        if let [_, _, ..] = hits[..] {
            let places: Vec<String> = hits
                .iter()
                .map(|at| {
                    let full = table(files, (at.file, at.table)).full_name(column(files, *at));
                    if files.len() > 1 { format!("{}:{full}", files[at.file].label) } else { full }
                })
                .collect();
            let problem = format!("'{}' is ambiguous: {}", map.source, places.join(", "));
            return Err(JoinError::Map(index, problem));
        }
        if let Some(before) = wanted.iter().find(|w| w.map.target == map.target) {
            let problem = format!("'{}' is already made of '{}'", map.target, before.map.source);
            return Err(JoinError::Map(index, problem));
        }
        wanted.push(Wanted { at: hits[0], map: map.clone() });
    }
    for (f, file) in files.iter().enumerate() {
        for (t, table) in file.log.tables.iter().enumerate() {
            for (c, column) in table.columns.iter().enumerate() {
                let at = At { file: f, table: t, column: c };
                let mapped = wanted.iter().chain(&clocks).any(|w| w.at == at);
                if mapped || column.name == "time_s" || !(request.known)(&column.name) {
                    continue;
                }
                if let Some(other) = wanted.iter().find(|w| w.map.target == column.name) {
                    let problem = format!(
                        "'{}' stands in {} and is also made of '{}'",
                        column.name, file.label, other.map.source
                    );
                    return Err(JoinError::Run(problem));
                }
                wanted.push(Wanted { at, map: ColumnMap::plain(&column.name) });
            }
        }
    }
    Ok((wanted, clocks))
}

/// What is said of a source that no file has.
fn nothing_like(files: &[File], source: &str) -> String {
    let all: Vec<String> = files
        .iter()
        .flat_map(|f| f.log.tables.iter().flat_map(|t| t.columns.iter().map(|c| t.full_name(c))))
        .collect();
    let near = all
        .iter()
        .map(|name| (strsim::jaro_winkler(name, source), name))
        .filter(|(score, _)| *score > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let near = near.map_or_else(String::new, |(_, name)| format!("; did you mean '{name}'?"));
    // A topic that could not be read is why its columns are not there.
    let why = files
        .iter()
        .flat_map(|f| &f.log.notes)
        .find(|note| note.split('\'').nth(1).is_some_and(|topic| source.contains(topic)))
        .map_or_else(String::new, |note| format!("; {note}"));
    let labels: Vec<&str> = files.iter().map(|f| f.label.as_str()).collect();
    format!("no column '{source}' in {}{near} (there are {}){why}", labels.join(", "), names(files))
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

/// The time stamps of a table: those of the column that is mapped onto `time_s`, or is called so, or those that the
/// format keeps; of the only table, else, by the sample rate.
fn clock(
    files: &[File],
    at: (usize, usize),
    clocks: &[Wanted],
    request: &Request,
    alone: bool,
    notes: &mut Vec<String>,
) -> Result<Clock, JoinError> {
    let (file, table) = (&files[at.0], table(files, at));
    if table.rows() < 2 {
        let problem = format!("{} has {} rows", table_title(files, at), table.rows());
        return Err(LogError::whole(&file.path, problem).into());
    }
    let mapped: Vec<&Wanted> = clocks.iter().filter(|c| (c.at.file, c.at.table) == at).collect();
    if let [_, second, ..] = mapped[..] {
        let problem = format!("'{}' would be a second time_s of {}", second.map.source, title(files, at));
        return Err(JoinError::Run(problem));
    }
    let own = table.columns.iter().position(|c| c.name == "time_s");
    let (wanted, own_zero) = match (mapped.first(), own.or(table.clock)) {
        (Some(w), _) => (Wanted { at: w.at, map: w.map.clone() }, false),
        (None, Some(c)) => {
            let at = At { file: at.0, table: at.1, column: c };
            (Wanted { at, map: ColumnMap::plain("time_s") }, own == Some(c))
        }
        (None, None) => {
            let hint = table.columns.iter().find(|c| c.name.contains("time") || c.name.contains("stamp"));
            let hint = hint.map_or_else(String::new, |c| format!(" (found '{}')", c.name));
            let Some(rate) = request.sample_rate_hz.filter(|_| alone) else {
                let problem = format!("is missing in {}{hint}; map a column onto it", title(files, at));
                return Err(LogError::new(&file.path, None, Some("time_s"), problem).into());
            };
            notes.push(format!("{}: time is made of the stated {rate} Hz{hint}", title(files, at)));
            let time_s = (0..table.rows()).map(|i| i as f64 / rate).collect();
            let offset_s = file.offset_s;
            let (origin, first, scale, column, own_zero) = (0, 0.0, 1.0, None, false);
            return Ok(Clock { time_s, origin, first, scale, offset_s, column, own_zero });
        }
    };
    usable(files, &wanted)?;
    let source = column(files, wanted.at);
    let name = table.full_name(source);
    let raw = match wanted.map.wrap {
        Some(period) => &unwrapped(&source.values, period),
        None => &source.values,
    };
    let first = raw.first().copied().unwrap_or(0.0);
    let scale = wanted.map.scale;
    let time_s: Vec<f64> = raw.iter().map(|t| (t - first) * scale).collect();
    for i in 1..time_s.len() {
        if !(time_s[i] > time_s[i - 1] && time_s[i].is_finite()) {
            let what = if time_s[i] == time_s[i - 1] { "repeats" } else { "goes back" };
            let problem = format!("time {what}: {} after {}", raw[i], raw[i - 1]);
            return Err(LogError::new(&file.path, table.places.of(i), Some(&name), problem).into());
        }
    }
    Ok(Clock {
        time_s,
        origin: source.origin,
        first,
        scale,
        offset_s: wanted.map.offset + file.offset_s,
        column: Some(wanted.at.column),
        own_zero: own_zero && file.offset_s == 0.0,
    })
}

/// A remark on the longest gap of a clock over which values are interpolated.
fn gap(time: &[f64], name: &str) -> Option<String> {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let longest = steps.iter().copied().fold(0.0, f64::max);
    let middle = steps.len() / 2;
    let (_, median, _) = (!steps.is_empty()).then(|| steps.select_nth_unstable_by(middle, f64::total_cmp))?;
    (longest > GAP * *median)
        .then(|| format!("{name} has a gap of {longest:.3} s, over which its values are interpolated"))
}

/// Values at other stamps, inside of what `time` covers (to [`SAME_S`]).
fn resampled(time: &[f64], values: &[f64], at: &[f64], held: bool) -> Vec<f64> {
    let mut next = 0;
    at.iter()
        .map(|&t| {
            while next < time.len() && time[next] <= t + SAME_S {
                next += 1;
            }
            let Some(before) = next.checked_sub(1) else { return values[0] };
            if held || next == time.len() {
                return values[before];
            }
            let share = ((t - time[before]) / (time[next] - time[before])).clamp(0.0, 1.0);
            values[before] + share * (values[next] - values[before])
        })
        .collect()
}

#[cfg(test)]
mod tests;
