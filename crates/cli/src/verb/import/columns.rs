//! The table `[columns]` of a first campaign file: what each column of the logs becomes.

use super::{one_line, place, quoted, range};
use sealegs::logs::Log;
use sealegs::logs::survey::{ColumnSurvey, Survey};
use sealegs::sysid::campaign::{INPUT_COLUMNS, commanded_joint};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// The lines of the table.
pub(super) fn lines(logs: &[(&Path, Log, Survey)]) -> String {
    let mut out = String::new();
    // Files of one kind have the same columns: each is stated once.
    let mut lines: BTreeMap<(usize, &str), &ColumnSurvey> = BTreeMap::new();
    let mut order: Vec<&str> = Vec::new();
    for column in logs.iter().flat_map(|(_, _, s)| &s.tables).flat_map(|t| &t.columns) {
        let at = order.iter().position(|n| *n == column.name).unwrap_or_else(|| {
            order.push(&column.name);
            order.len() - 1
        });
        // A column that stands still in the first file may move in the next one.
        let kept = lines.entry((at, column.name.as_str())).or_insert(column);
        if kept.role.is_none() && column.role.is_some() {
            *kept = column;
        }
    }
    let mut taken: Vec<(&str, &str)> = Vec::new();
    // What one topic measures another one may command.
    let joint_of = |column: &ColumnSurvey, measured: bool| {
        let role = column.role.as_ref().filter(|role| role.stands_in == measured)?;
        commanded_joint(&role.target).map(str::to_owned)
    };
    for column in lines.values() {
        let joint = joint_of(column, true);
        let command = lines.values().find(|c| joint.is_some() && joint_of(c, false) == joint);
        let line = match command {
            Some(command) => left_out(column, Some(&format!("measured; '{}' is the command", command.name))),
            None => map(column, &mut taken),
        };
        let _ = writeln!(out, "{line}");
    }
    out
}

/// The line of a column that becomes nothing, with what it holds and why.
fn left_out(column: &ColumnSurvey, why: Option<&str>) -> String {
    let why = why.map_or_else(String::new, |why| format!("; {why}"));
    format!("# {} = \"\"   # {}", quoted(&column.name), one_line(&(range(column) + &why)))
}

/// One line of `[columns]`; commented out where nothing is guessed, or where another column has the channel.
fn map<'a>(column: &'a ColumnSurvey, taken: &mut Vec<(&'a str, &'a str)>) -> String {
    let source = quoted(&column.name);
    let Some(role) = &column.role else { return left_out(column, column.aside.as_deref()) };
    // Every table has its own time; a bench has one input.
    let input = |target: &str| INPUT_COLUMNS.contains(&target);
    let other = taken.iter().find(|(t, _)| *t == role.target || (input(t) && input(&role.target)));
    let other = other.filter(|_| role.target != "time_s").map(|(_, name)| *name);
    let mut reason = role.reason.clone();
    if let Some(other) = other {
        let _ = write!(reason, "; '{other}' is taken in its place");
    } else if let Some((at, problem)) = &column.fault {
        let _ = write!(
            reason,
            "; TODO: {} cells hold no number, first in {} ({problem}): delete such rows of the file, gaps are allowed",
            column.empty,
            place(*at)
        );
    }
    if other.is_none() {
        taken.push((&role.target, &column.name));
    }
    let said = match &role.settings {
        Some(settings) => format!("{{ as = {}, {settings} }}", quoted(&role.target)),
        None => quoted(&role.target),
    };
    let mark = if other.is_none() && column.fault.is_none() { "" } else { "# " };
    format!("{mark}{source} = {said}   # {}", one_line(&reason))
}
