//! The table `[columns]` of a first campaign file: what each column of the logs becomes.

use super::{one_line, place, quoted, range};
use sealegs::logs::Log;
use sealegs::logs::survey::{ColumnSurvey, Survey};
use sealegs::sysid::campaign::{INPUT_COLUMNS, JOINT_COMMANDS};
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
    let goals: Vec<&ColumnSurvey> =
        lines.values().copied().filter(|c| commanded_joint(c).is_some()).collect();
    for column in lines.values() {
        let joint = column.role.as_ref().filter(|role| role.stands_in).map(|role| place_of(&role.target));
        let other = joint.and_then(|joint| goals.iter().find(|c| commanded_joint(c) == Some(joint)));
        match other {
            Some(other) => {
                let why = format!("measured; '{}' is the command", other.name);
                let _ = writeln!(
                    out,
                    "# {} = \"\"   # {}; {}",
                    quoted(&column.name),
                    range(column),
                    one_line(&why)
                );
            }
            None => {
                let _ = writeln!(out, "{}", map(column, &mut taken));
            }
        }
    }
    out
}

/// The joint before a channel's name.
fn place_of(target: &str) -> &str {
    target.rsplit_once('.').map_or("", |(joint, _)| joint)
}

/// The joint that a column commands, and does not only measure.
fn commanded_joint(column: &ColumnSurvey) -> Option<&str> {
    let role = column.role.as_ref().filter(|role| !role.stands_in)?;
    let (joint, what) = role.target.rsplit_once('.')?;
    JOINT_COMMANDS.contains(&what).then_some(joint)
}

/// One line of `[columns]`; commented out where nothing is guessed, or where another column has the channel.
fn map<'a>(column: &'a ColumnSurvey, taken: &mut Vec<(&'a str, &'a str)>) -> String {
    let source = quoted(&column.name);
    let Some(role) = &column.role else {
        let mut why = range(column);
        if let Some(aside) = &column.aside {
            let _ = write!(why, "; {aside}");
        }
        return format!("# {source} = \"\"   # {}", one_line(&why));
    };
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
