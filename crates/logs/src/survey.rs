//! What is in a log: rates, gaps, ranges, dead columns, and what each column probably is.

use crate::columns::unwrapped;
use crate::join::counter;
use crate::moment::{DATES, TIMES};
use crate::parquet_table::STAMPS;
use crate::table::{Column, Log, Table};
use crate::{Place, guess, units};
use sealegs_model::Unit;

/// What is in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Survey {
    /// One for each table, in their order.
    pub tables: Vec<TableSurvey>,
}

/// What is in a table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableSurvey {
    /// The table's name; empty where the file has one table.
    pub name: String,
    /// Number of rows.
    pub rows: usize,
    /// The column that is time, if one is.
    pub clock: Option<ClockSurvey>,
    /// The columns in their order.
    pub columns: Vec<ColumnSurvey>,
}

/// How regular a table's time is.
#[derive(Debug, Clone, PartialEq)]
pub struct ClockSurvey {
    /// The column, by its place in [`TableSurvey::columns`].
    pub column: usize,
    /// What its numbers are: `s`, `ms`, `us` or `ns`.
    pub unit: &'static str,
    /// Why it is taken for time, and why in this unit.
    pub reason: String,
    /// After how many of its units the counter begins again, if it does.
    pub wrap: Option<f64>,
    /// First to last stamp, s.
    pub duration_s: f64,
    /// Rate by the median step, Hz.
    pub rate_hz: f64,
    /// Root mean square deviation of a step from the median one, gaps left out, as a share of it.
    pub jitter: f64,
    /// Steps of more than five periods.
    pub gaps: usize,
    /// The longest step, s.
    pub longest_s: f64,
    /// Where time does not go on for the first time.
    pub stands: Option<Place>,
}

impl ClockSurvey {
    /// Seconds that one of its unit is.
    #[must_use]
    pub fn unit_s(&self) -> f64 {
        seconds(self.unit)
    }
}

fn seconds(unit: &str) -> f64 {
    units::of(unit, Unit::Second).map_or(1.0, |(factor, _)| factor)
}

/// What is in a column.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnSurvey {
    /// As a campaign calls it.
    pub name: String,
    /// What it holds if not plain numbers.
    pub holds: Option<String>,
    /// Least and greatest finite value; `None` if no cell is a number.
    pub range: Option<(f64, f64)>,
    /// Cells that are no finite number.
    pub empty: usize,
    /// Where the first of them is, and what is wrong.
    pub fault: Option<(Place, String)>,
    /// Whether all its numbers are the same.
    pub constant: bool,
    /// Share of rows in which it stays what it was in the row before.
    pub unchanged: f64,
    /// What it probably is.
    pub role: Option<Role>,
    /// Why it is nothing, where its name says something.
    pub aside: Option<String>,
}

/// What a column probably is.
#[derive(Debug, Clone, PartialEq)]
pub struct Role {
    /// The channel of the data contract.
    pub target: String,
    /// What else the map needs, as TOML: `unit = "deg"`.
    pub settings: Option<String>,
    /// Why.
    pub reason: String,
    /// Whether it is a measurement that stands in for a joint's command, as nothing beside it is one.
    pub stands_in: bool,
}

/// A step of more periods than this is a gap.
const GAP: f64 = 5.0;

/// Looks at every column of a log.
#[must_use]
pub fn survey(log: &Log) -> Survey {
    survey_named(log, &[])
}

/// The same where a dataset's metadata says which joints columns belong to, see [`crate::lerobot::joint_names`].
#[must_use]
pub fn survey_named(log: &Log, joints: &[(String, String)]) -> Survey {
    Survey { tables: log.tables.iter().map(|table| of_table(table, joints)).collect() }
}

fn of_table(table: &Table, joints: &[(String, String)]) -> TableSurvey {
    let clock = of_clock(table);
    let mut columns: Vec<ColumnSurvey> = table.columns.iter().map(|c| of_column(table, c)).collect();
    guess::roles(table, clock.as_ref().map(|c| c.column), joints, &mut columns);
    if let Some(clock) = &clock {
        let unit = (clock.unit != "s").then(|| format!("unit = \"{}\"", clock.unit));
        let wrap = clock.wrap.map(|period| format!("wrap = {period:.1}"));
        let settings: Vec<String> = unit.into_iter().chain(wrap).collect();
        let settings = (!settings.is_empty()).then(|| settings.join(", "));
        columns[clock.column].role = Some(Role {
            target: "time_s".to_owned(),
            settings,
            reason: clock.reason.clone(),
            stands_in: false,
        });
    }
    TableSurvey { name: table.name.clone(), rows: table.rows(), clock, columns }
}

fn of_column(table: &Table, column: &Column) -> ColumnSurvey {
    let finite = || column.values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let unchanged = column.values.windows(2).filter(|w| w[0] == w[1]).count();
    let origin = column.origin as f64;
    ColumnSurvey {
        name: table.full_name(column),
        holds: column.holds.clone(),
        range: (low <= high).then_some((low + origin, high + origin)),
        empty: column.values.iter().filter(|v| !v.is_finite()).count(),
        fault: column.fault.as_ref().map(|f| (table.places.of(f.row), f.problem.clone())),
        constant: low == high,
        unchanged: unchanged as f64 / column.values.len().saturating_sub(1).max(1) as f64,
        role: None,
        aside: None,
    }
}

/// The column that is time, and why: the format's own, or one that is called so and goes on.
pub(crate) fn clock_of(table: &Table) -> Option<(usize, &'static str)> {
    if let Some(own) = table.clock {
        return Some((own, "the time at which each message was logged"));
    }
    let fit = |c: &Column| c.fault.is_none() && goes_on(&c.values);
    // pandas' index of time stamps may have no name.
    let dated = |c: &Column| {
        let stamps = |h: &str| [DATES, TIMES].contains(&h) || h.starts_with(STAMPS);
        c.holds.as_deref().is_some_and(stamps)
    };
    let at = |like: &dyn Fn(&Column) -> bool| table.columns.iter().position(|c| like(c) && fit(c));
    match at(&dated) {
        Some(index) => Some((index, "its cells are dates or times, and they go on")),
        None => Some((at(&|c| guess::is_time(&c.name))?, "by its name, and it goes on")),
    }
}

/// How regular a table's time is, where a column is time.
fn of_clock(table: &Table) -> Option<ClockSurvey> {
    let (index, reason) = clock_of(table)?;
    let column = &table.columns[index];
    let wrap = column.values.windows(2).find_map(|w| counter(w[1], w[0])).map(|(_, period)| period);
    let values = match wrap {
        Some(period) => &unwrapped(&column.values, period),
        None => &column.values,
    };
    let steps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).filter(|s| s.is_finite()).collect();
    let mut sorted: Vec<f64> = steps.iter().copied().filter(|&s| s > 0.0).collect();
    if sorted.is_empty() {
        return None;
    }
    sorted.sort_unstable_by(f64::total_cmp);
    let period = sorted[sorted.len() / 2];
    let first = column.values[0] + column.origin as f64;
    let (unit, why) = guess::time_unit(&column.name, column.holds.as_deref(), first, period);
    let factor = seconds(unit);
    let (mut sum, mut count, mut gaps) = (0.0, 0.0f64, 0);
    for step in &steps {
        if *step > GAP * period {
            gaps += 1;
        } else {
            sum += (step - period).powi(2);
            count += 1.0;
        }
    }
    let last = values[values.len() - 1];
    Some(ClockSurvey {
        column: index,
        unit,
        reason: format!("{reason}; {why}"),
        wrap,
        duration_s: (last - values[0]) * factor,
        rate_hz: 1.0 / (period * factor),
        jitter: (sum / count.max(1.0)).sqrt() / period,
        gaps,
        longest_s: sorted[sorted.len() - 1] * factor,
        stands: values.windows(2).position(|w| w[1] <= w[0]).map(|row| table.places.of(row + 1)),
    })
}

/// Whether numbers nearly always increase: a few that do not are a fault of a clock, and no other signal.
pub(crate) fn goes_on(values: &[f64]) -> bool {
    let steps = values.len().saturating_sub(1);
    let on = values.windows(2).filter(|w| w[1] > w[0]).count();
    steps > 0 && on as f64 > 0.95 * steps as f64
}
