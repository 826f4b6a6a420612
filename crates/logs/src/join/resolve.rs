//! Which column of which file becomes which channel.

use super::{At, File, JoinError, Request, Wanted, column, names, table};
use crate::LogError;
use crate::columns::ColumnMap;
use crate::episodes::EPISODE;

/// Leaves the rows of one episode in every table that has such.
pub(super) fn keep_episode(files: &mut [File], episode: i64) -> Result<(), JoinError> {
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
pub(super) fn resolve(files: &[File], request: &Request) -> Result<(Vec<Wanted>, Vec<Wanted>), JoinError> {
    let (mut wanted, mut clocks): (Vec<Wanted>, Vec<Wanted>) = (Vec::new(), Vec::new());
    for (index, map) in request.columns.iter().enumerate() {
        // No column: the rows get it once they are known.
        if map.constant.is_some() {
            continue;
        }
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
    let maps = wanted.len();
    for (f, file) in files.iter().enumerate() {
        for (t, table) in file.log.tables.iter().enumerate() {
            for (c, column) in table.columns.iter().enumerate() {
                let at = At { file: f, table: t, column: c };
                let mapped = wanted.iter().chain(&clocks).any(|w| w.at == at);
                if mapped || column.name == "time_s" || !(request.known)(&column.name) {
                    continue;
                }
                match wanted.iter().position(|w| w.map.target == column.name) {
                    // Of columns of one name the map has chosen one.
                    Some(i) if i < maps && super::column(files, wanted[i].at).name == column.name => continue,
                    Some(i) => {
                        let other = &wanted[i];
                        let from = &files[other.at.file].label;
                        let problem = format!(
                            "'{}' stands in {} and is also made of '{}' in {from}; map one of them",
                            column.name, file.label, other.map.source
                        );
                        return Err(JoinError::Run(problem));
                    }
                    None => {}
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
