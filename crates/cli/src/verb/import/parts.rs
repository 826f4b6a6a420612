//! Whether log files are runs, or parts of one run on one clock or on several.

use sealegs::logs::survey::{ClockSurvey, Survey, TableSurvey};
use sealegs::logs::{Log, Table};
use sealegs::sysid::campaign::INPUT_COLUMNS;
use std::collections::BTreeSet;
use std::path::Path;

/// Share of the shorter file's time that must lie within the other one's for both to be on one clock.
const OVERLAP: f64 = 0.5;

/// Ratio of the durations of two files up to which they may be parts of one run though their clocks do not meet.
const AS_LONG: f64 = 1.1;

/// How log files are parts of one run.
#[derive(Debug, PartialEq)]
pub(super) enum Parts {
    /// All have the same time stamps.
    SameStamps,
    /// All are on one clock, with stamps of their own.
    OneClock,
    /// Their clocks do not meet: what to add to the time of each for all to begin together, s.
    OwnClocks(Vec<f64>),
}

/// A file with one table, and that with a clock.
struct Part<'a> {
    table: &'a Table,
    seen: &'a TableSurvey,
    clock: &'a ClockSurvey,
}

impl<'a> Part<'a> {
    fn of(log: &'a Log, found: &'a Survey) -> Option<Self> {
        let ([table], [seen]) = (&log.tables[..], &found.tables[..]) else { return None };
        Some(Self { table, seen, clock: seen.clock.as_ref()? })
    }

    fn stamps(&self) -> &'a [f64] {
        &self.table.columns[self.clock.column].values
    }

    /// The channels that its columns become, without its time.
    fn channels(&self) -> BTreeSet<&'a str> {
        let targets = self.seen.columns.iter().filter_map(|c| Some(c.role.as_ref()?.target.as_str()));
        targets.filter(|target| *target != "time_s").collect()
    }

    fn has_command(&self) -> bool {
        self.channels().iter().any(|target| INPUT_COLUMNS.contains(target))
    }

    /// When its first and last row were, s.
    fn span_s(&self) -> Option<(f64, f64)> {
        let (first, _) = self.seen.columns[self.clock.column].range?;
        let start = first * self.clock.unit_s();
        (self.table.rows() > 1).then_some((start, start + self.clock.duration_s))
    }
}

/// How log files are parts of one run, which have one table each, and no channel twice; `None` where each is a run, or several.
pub(super) fn parts(logs: &[(&Path, Log, Survey)]) -> Option<Parts> {
    let all: Vec<Part> = logs.iter().map(|(_, log, found)| Part::of(log, found)).collect::<Option<_>>()?;
    match all.len() > 1 {
        true if have_same_stamps(&all) => Some(Parts::SameStamps),
        true if are_complements(&all) => by_clocks(&all),
        _ => None,
    }
}

/// Which files are parts of one run each, where there are several runs: one of each has the command, and the others belong to that
/// one which they share their time with; of several that one which is called alike, `chirp_link` as `chirp_motor`. `None` where a file
/// belongs to none of them, or to several.
pub(super) fn runs_of_parts(logs: &[(&Path, Log, Survey)]) -> Option<Vec<Vec<usize>>> {
    let all: Vec<Part> = logs.iter().map(|(_, log, found)| Part::of(log, found)).collect::<Option<_>>()?;
    let spans: Vec<(f64, f64)> = all.iter().map(Part::span_s).collect::<Option<_>>()?;
    let (commands, others): (Vec<usize>, Vec<usize>) = (0..all.len()).partition(|&i| all[i].has_command());
    if commands.len() < 2 || others.is_empty() {
        return None;
    }
    let mut runs: Vec<Vec<usize>> = commands.into_iter().map(|i| vec![i]).collect();
    for i in others {
        let shares = |run: &Vec<usize>| {
            share_time(&[spans[run[0]], spans[i]])
                && run.iter().all(|&j| all[j].channels().is_disjoint(&all[i].channels()))
        };
        let sharing: Vec<usize> = (0..runs.len()).filter(|&run| shares(&runs[run])).collect();
        let alike = |&run: &usize| stem(logs[runs[run][0]].0) == stem(logs[i].0);
        let called: Vec<usize> = sharing.iter().copied().filter(alike).collect();
        match (&sharing[..], &called[..]) {
            ([run], _) | (_, [run]) => runs[*run].push(i),
            _ => return None,
        }
    }
    Some(runs)
}

/// What a file is called without the last word, where it has several.
fn stem(file: &Path) -> String {
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    name.rsplit_once(['_', '-', '.']).map_or_else(|| name.clone(), |(stem, _)| stem.to_owned())
}

/// Whether files have equal time stamps, and no other column twice.
fn have_same_stamps(all: &[Part]) -> bool {
    let mut names: BTreeSet<&str> = BTreeSet::new();
    all.iter().all(|part| {
        let columns = part.seen.columns.iter().enumerate();
        let mut others = columns.filter(|(i, _)| *i != part.clock.column);
        part.stamps() == all[0].stamps() && others.all(|(_, column)| names.insert(&column.name))
    })
}

/// Whether each file has channels that no other one has, and one alone has the command.
fn are_complements(all: &[Part]) -> bool {
    let mut channels: BTreeSet<&str> = BTreeSet::new();
    let mut commands = 0;
    for part in all {
        let own = part.channels();
        commands += usize::from(part.has_command());
        if own.is_empty() || !own.into_iter().all(|target| channels.insert(target)) {
            return false;
        }
    }
    commands == 1
}

/// How complementary files belong together by when they begin and end.
fn by_clocks(all: &[Part]) -> Option<Parts> {
    let spans: Vec<(f64, f64)> = all.iter().map(Part::span_s).collect::<Option<_>>()?;
    if share_time(&spans) {
        return Some(Parts::OneClock);
    }
    let lengths = || spans.iter().map(|(start, end)| end - start);
    let (shortest, longest) = (lengths().fold(f64::INFINITY, f64::min), lengths().fold(0.0, f64::max));
    let offsets = || spans.iter().map(|(start, _)| spans[0].0 - start).collect();
    (longest <= AS_LONG * shortest).then(|| Parts::OwnClocks(offsets()))
}

/// Whether most of the shortest of some spans of time lies within all of them.
fn share_time(spans: &[(f64, f64)]) -> bool {
    let shortest = spans.iter().map(|(start, end)| end - start).fold(f64::INFINITY, f64::min);
    let latest = spans.iter().map(|(start, _)| *start).fold(f64::NEG_INFINITY, f64::max);
    let earliest_end = spans.iter().map(|(_, end)| *end).fold(f64::INFINITY, f64::min);
    earliest_end - latest >= OVERLAP * shortest
}
