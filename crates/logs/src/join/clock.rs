//! The clocks of tables, and values at the stamps of another one.

use super::{At, File, JoinError, Request, SAME_S, Wanted, column, table, table_title, title, usable};
use crate::LogError;
use crate::columns::{ColumnMap, unwrapped};
use crate::guess::is_time;

/// A step of more periods than this is a gap, over which nothing should be interpolated unsaid.
const GAP: f64 = 5.0;

/// Time stamps of a table from its own zero, and where that zero is.
pub(super) struct Clock {
    pub(super) time_s: Vec<f64>,
    /// The first stamp as the column has it, and by what that is multiplied.
    origin: i64,
    first: f64,
    scale: f64,
    offset_s: f64,
    pub(super) column: Option<usize>,
    /// Whether the column's own zero stays.
    pub(super) own_zero: bool,
}

impl Clock {
    /// The first stamp, s.
    fn start(&self) -> f64 {
        (self.origin as f64 + self.first) * self.scale + self.offset_s
    }

    /// How much later than `other` it starts, s.
    pub(super) fn after(&self, other: &Self) -> f64 {
        if self.scale == other.scale {
            let whole = self.origin.wrapping_sub(other.origin) as f64;
            (whole + (self.first - other.first)) * self.scale + (self.offset_s - other.offset_s)
        } else {
            self.start() - other.start()
        }
    }
}

/// The time stamps of a table: those of the column that is mapped onto `time_s`, or is called so, or those that the
/// format keeps; of the only table, else, by the sample rate.
pub(super) fn clock(
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
            let hint = table.columns.iter().find(|c| is_time(&c.name));
            let hint = hint.map_or_else(String::new, |c| format!(" (found '{}')", c.name));
            let Some(rate) = request.sample_rate_hz.filter(|_| alone) else {
                let problem = format!(
                    "is missing in {}{hint}; map a column onto it, or state sample_rate_hz",
                    title(files, at)
                );
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
            let (fault, cure) = time_fault(raw[i], raw[i - 1]);
            let problem = format!("{fault}; {cure}");
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

/// Counters of time that begin again, and after how many of their units.
const COUNTERS: [(&str, f64); 4] = [
    ("a counter of 16 bits", 65_536.0),
    ("a counter of 32 bits", 4_294_967_296.0),
    ("a count of the nanoseconds of a second", 1e9),
    ("a count of the seconds of a day", 86_400.0),
];

/// Share of its period within which a counter falls where it begins again: a row may come that late.
const NEAR_COUNTER: f64 = 0.02;

/// The counter of time that begins again between two stamps, and after how many of its units.
pub(crate) fn counter(stamp: f64, before: f64) -> Option<(&'static str, f64)> {
    let fallen = before - stamp;
    COUNTERS.iter().copied().find(|(_, period)| (fallen / period - 1.0).abs() < NEAR_COUNTER)
}

/// What is wrong with a time stamp that does not come after the one before, and what to do.
#[must_use]
pub fn time_fault(stamp: f64, before: f64) -> (String, String) {
    let (what, cure) = match counter(stamp, before) {
        _ if stamp == before => {
            ("repeats", "delete such rows, or leave the column out and state sample_rate_hz".to_owned())
        }
        Some((what, period)) => ("goes back", format!("{what} begins again: map it with wrap = {period}")),
        None => ("goes back", "where a log begins anew, cut the file in two".to_owned()),
    };
    (format!("time {what}: {stamp} after {before}"), cure)
}

/// A remark on the longest gap of a clock over which values are interpolated.
pub(super) fn gap(time: &[f64], name: &str) -> Option<String> {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let longest = steps.iter().copied().fold(0.0, f64::max);
    let middle = steps.len() / 2;
    let (_, median, _) = (!steps.is_empty()).then(|| steps.select_nth_unstable_by(middle, f64::total_cmp))?;
    (longest > GAP * *median)
        .then(|| format!("{name} has a gap of {longest:.3} s, over which its values are interpolated"))
}

/// Values at other stamps, inside of what `time` covers (to [`SAME_S`]).
pub(super) fn resampled(time: &[f64], values: &[f64], at: &[f64], held: bool) -> Vec<f64> {
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
