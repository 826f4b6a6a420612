//! Whether log files are runs, or parts of one run on one clock or on several.

use sealegs::logs::Log;
use sealegs::logs::survey::{Survey, TableSurvey};
use sealegs::sysid::campaign::INPUT_COLUMNS;
use std::collections::BTreeSet;
use std::path::Path;

/// Share of the shorter file's time that must lie within the other one's for both to be on one clock.
const OVERLAP: f64 = 0.5;

/// Ratio of the durations of two files up to which they may be parts of one run though their clocks do not meet.
const AS_LONG: f64 = 1.1;

/// How log files belong together.
#[derive(Debug, PartialEq)]
pub(super) enum Parts {
    /// Each is a run, or several.
    Runs,
    /// All have the same time stamps.
    SameStamps,
    /// All are on one clock, with stamps of their own.
    OneClock,
    /// Their clocks do not meet: what to add to the time of each for all to begin together, s.
    OwnClocks(Vec<f64>),
}

/// How log files belong together: parts of one run have one table each, and no channel twice.
pub(super) fn parts(logs: &[(&Path, Log, Survey)]) -> Parts {
    let all: Option<Vec<(&Log, &TableSurvey)>> = logs
        .iter()
        .map(|(_, log, found)| match (&log.tables[..], &found.tables[..]) {
            ([_], [seen]) if seen.clock.is_some() => Some((log, seen)),
            _ => None,
        })
        .collect();
    match all {
        Some(all) if all.len() > 1 && have_same_stamps(&all) => Parts::SameStamps,
        Some(all) if all.len() > 1 && are_complements(&all) => by_clocks(&all),
        _ => Parts::Runs,
    }
}

/// Whether files have equal time stamps, and no other column twice.
fn have_same_stamps(all: &[(&Log, &TableSurvey)]) -> bool {
    let stamps = |(log, seen): &(&Log, &TableSurvey)| {
        let clock = seen.clock.as_ref().map_or(0, |clock| clock.column);
        log.tables[0].columns[clock].values.clone()
    };
    let first = stamps(&all[0]);
    let mut names: BTreeSet<&str> = BTreeSet::new();
    all.iter().all(|part| {
        let clock = part.1.clock.as_ref().map(|clock| clock.column);
        let mut others = part.1.columns.iter().enumerate().filter(|(i, _)| Some(*i) != clock);
        stamps(part) == first && others.all(|(_, column)| names.insert(&column.name))
    })
}

/// Whether each file has channels that no other one has, and one alone has the command.
fn are_complements(all: &[(&Log, &TableSurvey)]) -> bool {
    let mut channels: BTreeSet<&str> = BTreeSet::new();
    let mut commands = 0;
    for (_, seen) in all {
        let targets = seen.columns.iter().filter_map(|c| Some(c.role.as_ref()?.target.as_str()));
        let own: Vec<&str> = targets.filter(|target| *target != "time_s").collect();
        commands += usize::from(own.iter().any(|target| INPUT_COLUMNS.contains(target)));
        if own.is_empty() || !own.into_iter().all(|target| channels.insert(target)) {
            return false;
        }
    }
    commands == 1
}

/// How complementary files belong together by when they begin and end.
fn by_clocks(all: &[(&Log, &TableSurvey)]) -> Parts {
    let spans: Vec<(f64, f64)> = all.iter().filter_map(span_s).collect();
    let shortest = spans.iter().map(|(start, end)| end - start).fold(f64::INFINITY, f64::min);
    let longest = spans.iter().map(|(start, end)| end - start).fold(0.0, f64::max);
    let latest = spans.iter().map(|(start, _)| *start).fold(f64::NEG_INFINITY, f64::max);
    let earliest_end = spans.iter().map(|(_, end)| *end).fold(f64::INFINITY, f64::min);
    if spans.len() == all.len() && earliest_end - latest >= OVERLAP * shortest {
        Parts::OneClock
    } else if spans.len() == all.len() && longest <= AS_LONG * shortest {
        Parts::OwnClocks(spans.iter().map(|(start, _)| spans[0].0 - start).collect())
    } else {
        Parts::Runs
    }
}

/// When a file's first and last row were, s.
fn span_s((log, seen): &(&Log, &TableSurvey)) -> Option<(f64, f64)> {
    let clock = seen.clock.as_ref()?;
    let per_second = match clock.unit {
        "ms" => 1e3,
        "us" => 1e6,
        "ns" => 1e9,
        _ => 1.0,
    };
    let (first, _) = seen.columns[clock.column].range?;
    let start = first / per_second;
    (log.tables[0].rows() > 1).then_some((start, start + clock.duration_s))
}
