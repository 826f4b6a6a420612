//! `campaign.toml`: its keys, and what can be wrong with them.

use super::columns::{self, FileEntry, MappedColumn, RawColumns, RawFile};
use super::rig::{RIG_KEYS, line_at};
use super::{Bench, Role, windows};
use crate::Error;
use sealegs_model::{InputHold, plain};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;
use toml::de::DeTable;

/// A campaign file that has been checked.
pub(super) struct Description {
    pub name: String,
    pub bench: Bench,
    pub actuator: String,
    pub scenario: Option<String>,
    /// For a robot: its URDF or model file.
    pub robot: Option<String>,
    pub gravity_compensated: bool,
    /// The line that names the actuator, for a leg the scenario.
    pub model_line: Option<u64>,
    /// For a leg: columns that are commands.
    pub inputs: Vec<String>,
    pub sample_rate_hz: Option<f64>,
    pub hold: InputHold,
    pub noise_std: Vec<(String, f64)>,
    pub runs: Vec<RunEntry>,
    pub notes: Vec<String>,
    /// What [`misspelt`] says of its keys.
    pub misspelt: String,
}

/// One `[[run]]`.
pub(super) struct RunEntry {
    /// Its files; the first one's clock leads.
    pub files: Vec<FileEntry>,
    /// Only the rows of this episode.
    pub episode: Option<i64>,
    /// What a file's columns become; `None` where nothing is said, and the file has the contract's own names.
    pub columns: Option<Vec<MappedColumn>>,
    /// The unit of the rig that it was recorded on.
    pub unit: Option<String>,
    pub role: Role,
    /// For a leg: its own scenario.
    pub scenario: Option<String>,
    pub from_s: Option<f64>,
    pub to_s: Option<f64>,
    /// Length of the pieces that it is cut into, each of which begins at the measured state.
    pub window_s: Option<f64>,
    /// Its own masses and lengths, or the campaign's.
    pub rig: super::RigValues,
    /// The line of its `file` or `files` key.
    pub line: u64,
}

impl RunEntry {
    /// What the run is called: its file, or both, or the first of more, with the episode if it is one of several.
    pub fn name(&self) -> String {
        let files = match &self.files[..] {
            [first, _, rest @ ..] if !rest.is_empty() => format!("{}+{} more", first.file, 1 + rest.len()),
            all => all.iter().map(|f| f.file.as_str()).collect::<Vec<_>>().join("+"),
        };
        self.episode.map_or_else(|| files.clone(), |e| format!("{files}#{e}"))
    }

    /// Whether it may have rows of the other run.
    fn shares_rows_with(&self, other: &Self) -> bool {
        let shared = self.files.iter().any(|f| other.files.iter().any(|o| o.file == f.file));
        shared && !matches!((self.episode, other.episode), (Some(a), Some(b)) if a != b)
    }
}

#[derive(Deserialize)]
struct RawCampaign {
    name: Option<String>,
    bench: Spanned<String>,
    actuator: Option<Spanned<String>>,
    scenario: Option<Spanned<String>>,
    robot: Option<Spanned<String>>,
    gravity_compensated: Option<Spanned<bool>>,
    inputs: Option<Spanned<Vec<String>>>,
    sample_rate_hz: Option<Spanned<f64>>,
    input_hold: Option<Spanned<String>>,
    #[serde(default)]
    noise_std: BTreeMap<String, Spanned<f64>>,
    #[serde(default)]
    columns: Option<RawColumns>,
    window_s: Option<Spanned<f64>>,
    #[serde(default)]
    run: Vec<RawRun>,
}

#[derive(Deserialize)]
struct RawRun {
    file: Option<Spanned<String>>,
    files: Option<Spanned<Vec<RawFile>>>,
    episode: Option<i64>,
    unit: Option<Spanned<String>>,
    columns: Option<RawColumns>,
    role: Spanned<String>,
    scenario: Option<Spanned<String>>,
    from_s: Option<Spanned<f64>>,
    to_s: Option<Spanned<f64>>,
    window_s: Option<Spanned<f64>>,
}

const KEYS: [&str; 13] = [
    "name",
    "bench",
    "actuator",
    "scenario",
    "robot",
    "gravity_compensated",
    "inputs",
    "sample_rate_hz",
    "input_hold",
    "noise_std",
    "columns",
    "window_s",
    "run",
];
const RUN_KEYS: [&str; 10] =
    ["file", "files", "episode", "unit", "columns", "role", "scenario", "from_s", "to_s", "window_s"];

/// Reads and checks a campaign file; the tables it names are not touched.
pub(super) fn read(path: &Path) -> Result<Description, Error> {
    let text = std::fs::read_to_string(path)
        .map_err(|e| Error::bad(path, None, None, format!("cannot be read: {e}")))?;
    parse(path, &text)
}

/// As [`read`], of text.
pub(super) fn parse(path: &Path, text: &str) -> Result<Description, Error> {
    if text.trim().is_empty() {
        return Err(Error::bad(path, None, None, "is empty"));
    }
    let raw: RawCampaign = toml::from_str(text).map_err(|e| {
        let missing = e.message().starts_with("missing field");
        let meant: String = if missing { misspelt(text) } else { String::new() };
        let problem = plain(&e.message().replace('\n', " ")) + &meant;
        Error::bad(path, e.span().map(|s| line_at(text, s.start)), None, problem)
    })?;
    let line = |span: std::ops::Range<usize>| line_at(text, span.start);

    let bench = match raw.bench.get_ref().as_str() {
        "locked" => Bench::Locked,
        "pendulum" => Bench::Pendulum,
        "free" => Bench::Free,
        "robot" => Bench::Robot,
        "leg" => Bench::Leg,
        other => {
            let problem = unknown("bench", other, &["locked", "pendulum", "free", "robot", "leg"]);
            return Err(Error::bad(path, line(raw.bench.span()), Some("bench"), problem));
        }
    };
    if bench == Bench::Leg && raw.scenario.is_none() {
        let problem = format!("is missing; a leg needs one{}", misspelt(text));
        return Err(Error::bad(path, line(raw.bench.span()), Some("scenario"), problem));
    }
    if bench == Bench::Robot && raw.robot.is_none() {
        let problem = format!("is missing; it names the URDF or the robot's model file{}", misspelt(text));
        return Err(Error::bad(path, line(raw.bench.span()), Some("robot"), problem));
    }
    if let Some(robot) = raw.robot.as_ref().filter(|_| bench != Bench::Robot) {
        return Err(Error::bad(path, line(robot.span()), Some("robot"), "is for the bench 'robot'"));
    }
    if let Some(said) = raw.gravity_compensated.as_ref().filter(|_| bench != Bench::Robot) {
        let at = line(said.span());
        return Err(Error::bad(path, at, Some("gravity_compensated"), super::GRAVITY_SUITS));
    }
    if !bench.has_joints() && raw.actuator.as_ref().is_none_or(|a| a.get_ref().trim().is_empty()) {
        let problem = format!("is missing{}", misspelt(text));
        return Err(Error::bad(path, raw.actuator.map(|a| line(a.span())), Some("actuator"), problem));
    }
    if let Some(inputs) = raw.inputs.as_ref().filter(|_| bench != Bench::Leg) {
        let problem = "is for a leg; the input of a bench is known by its column's name";
        return Err(Error::bad(path, line(inputs.span()), Some("inputs"), problem));
    }
    let hold = match raw.input_hold.as_ref().map(|h| (h.get_ref().as_str(), h.span())) {
        None | Some(("zero-order", _)) => InputHold::ZeroOrder,
        Some(("linear", _)) => InputHold::Linear,
        Some(("band-limited", _)) => InputHold::BandLimited,
        Some((other, span)) => {
            let problem = unknown("input hold", other, &["zero-order", "linear", "band-limited"]);
            return Err(Error::bad(path, line(span), Some("input_hold"), problem));
        }
    };
    let positive = |value: &Spanned<f64>, key: &str| {
        let v = *value.get_ref();
        if v.is_finite() && v > 0.0 {
            Ok(v)
        } else {
            Err(Error::bad(
                path,
                line(value.span()),
                Some(key),
                format!("is {v}; must be positive and finite"),
            ))
        }
    };
    let sample_rate_hz = raw.sample_rate_hz.as_ref().map(|v| positive(v, "sample_rate_hz")).transpose()?;
    let mut noise_std = Vec::new();
    for (channel, value) in &raw.noise_std {
        noise_std.push((channel.clone(), positive(value, &format!("noise_std.{channel}"))?));
    }

    let rigs = super::rig::of_runs(path, text, bench)?;
    let shared = raw.columns.as_ref().map(|c| columns::mapped(path, c, &line)).transpose()?;
    if raw.run.is_empty() {
        return Err(Error::bad(path, None, Some("run"), "no [[run]]; a campaign needs at least one"));
    }
    let mut runs: Vec<RunEntry> = Vec::new();
    for (run, rig) in raw.run.iter().zip(rigs) {
        let role = match run.role.get_ref().as_str() {
            "fit" => Role::Fit,
            "holdout" => Role::Holdout,
            other => {
                let problem = unknown("role", other, &["fit", "holdout"]);
                return Err(Error::bad(path, line(run.role.span()), Some("role"), problem));
            }
        };
        let bound = |value: &Option<Spanned<f64>>, key: &str| match value {
            Some(v) if !v.get_ref().is_finite() => {
                Err(Error::bad(path, line(v.span()), Some(key), "must be finite"))
            }
            other => Ok(other.as_ref().map(|v| *v.get_ref())),
        };
        if let Some(scenario) = run.scenario.as_ref().filter(|_| bench != Bench::Leg) {
            return Err(Error::bad(path, line(scenario.span()), Some("scenario"), "is for a leg"));
        }
        let (files, at) = files_of(path, run, &line)?;
        let own = run.columns.as_ref().map(|c| columns::mapped(path, c, &line)).transpose()?;
        let columns = (own.is_some() || shared.is_some()).then(|| {
            columns::with_own(shared.as_deref().unwrap_or_default(), own.as_deref().unwrap_or_default())
        });
        if let Some(unit) = run.unit.as_ref().filter(|u| u.get_ref().trim().is_empty()) {
            return Err(Error::bad(path, line(unit.span()), Some("unit"), "is empty"));
        }
        let entry = RunEntry {
            files,
            episode: run.episode,
            columns,
            unit: run.unit.as_ref().map(|u| u.get_ref().trim().to_owned()),
            role,
            scenario: run.scenario.as_ref().map(|s| s.get_ref().clone()),
            from_s: bound(&run.from_s, "from_s")?,
            to_s: bound(&run.to_s, "to_s")?,
            window_s: match run.window_s.as_ref().or(raw.window_s.as_ref()) {
                Some(window) if !bench.may_begin_in_motion() => {
                    return Err(Error::bad(path, line(window.span()), Some("window_s"), windows::SUIT));
                }
                window => window.map(|v| positive(v, "window_s")).transpose()?,
            },
            rig,
            line: at,
        };
        if runs.iter().any(|r| r.shares_rows_with(&entry) && r.scenario != entry.scenario) {
            let problem = format!("'{}' stands here with two scenarios", entry.name());
            return Err(Error::bad(path, entry.line, Some("scenario"), problem));
        }
        if runs.iter().any(|r| r.shares_rows_with(&entry) && r.rig != entry.rig) {
            let problem = format!("'{}' stands here on two rigs", entry.name());
            return Err(Error::bad(path, entry.line, Some("file"), problem));
        }
        if let Some(before) = runs.iter().find(|r| r.shares_rows_with(&entry) && r.role != entry.role) {
            let apart = entry.from_s.zip(before.to_s).is_some_and(|(a, b)| a >= b)
                || before.from_s.zip(entry.to_s).is_some_and(|(a, b)| a >= b);
            if !apart {
                let problem = format!(
                    "'{}' has two roles on the same rows: a held-out run is never fitted",
                    entry.name()
                );
                return Err(Error::bad(path, entry.line, Some("file"), problem));
            }
        }
        runs.push(entry);
    }
    let folder_name = || {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        folder.file_name().map_or_else(|| "campaign".to_owned(), |n| n.to_string_lossy().into_owned())
    };
    let model = match bench {
        Bench::Leg => &raw.scenario,
        Bench::Robot => &raw.robot,
        _ => &raw.actuator,
    };
    Ok(Description {
        model_line: model.as_ref().map(|m| line(m.span())),
        name: raw.name.unwrap_or_else(folder_name),
        bench,
        actuator: raw.actuator.map(Spanned::into_inner).unwrap_or_default(),
        scenario: raw.scenario.map(Spanned::into_inner),
        robot: raw.robot.map(Spanned::into_inner),
        gravity_compensated: raw.gravity_compensated.is_some_and(Spanned::into_inner),
        inputs: raw.inputs.map(Spanned::into_inner).unwrap_or_default(),
        sample_rate_hz,
        hold,
        noise_std,
        runs,
        notes: unknown_keys(path, text),
        misspelt: misspelt(text),
    })
}

/// The files of a run, and the line that names them.
fn files_of(
    path: &Path,
    run: &RawRun,
    line: &dyn Fn(std::ops::Range<usize>) -> u64,
) -> Result<(Vec<FileEntry>, u64), Error> {
    match (&run.file, &run.files) {
        (Some(file), None) => Ok((vec![FileEntry::plain(file.get_ref())], line(file.span()))),
        (None, Some(files)) => {
            let at = line(files.span());
            let files =
                columns::files(files).map_err(|problem| Error::bad(path, at, Some("files"), problem))?;
            Ok((files, at))
        }
        (Some(file), Some(_)) => {
            let problem = "stands beside 'files'; a run has one of the two";
            Err(Error::bad(path, line(file.span()), Some("file"), problem))
        }
        (None, None) => Err(Error::bad(
            path,
            line(run.role.span()),
            Some("file"),
            "is missing; a run has 'file' or 'files'",
        )),
    }
}

/// One note for each key that means nothing, with the one that was probably meant.
fn unknown_keys(path: &Path, text: &str) -> Vec<String> {
    let note = |(key, offset, meant)| {
        let line = line_at(text, offset);
        format!("{}: line {line}: key '{key}' is not known and has no effect{meant}", path.display())
    };
    unknown_with_hints(text).into_iter().map(note).collect()
}

/// `; key 'benhc' (line 3) is not known; did you mean 'bench'?` for each unknown key that comes near a known one.
fn misspelt(text: &str) -> String {
    let hinted = unknown_with_hints(text).into_iter().filter(|(.., meant)| !meant.is_empty());
    hinted
        .map(|(key, at, meant)| format!("; key '{key}' (line {}) is not known{meant}", line_at(text, at)))
        .collect()
}

/// Every key that means nothing, where it begins in the text, and a hint at the one that was probably meant.
fn unknown_with_hints(text: &str) -> Vec<(String, usize, String)> {
    let Ok(table) = DeTable::parse(text) else { return Vec::new() };
    let of = |table: &DeTable, known: &[&str]| -> Vec<(String, usize, String)> {
        let means_nothing = |key: &str| !known.contains(&key) && !RIG_KEYS.contains(&key);
        let unknown = table.keys().filter(|key| means_nothing(key.get_ref()));
        let found =
            unknown.map(|k| (k.get_ref().to_string(), k.span().start, did_you_mean(k.get_ref(), known)));
        let mut found: Vec<_> = found.collect();
        found.sort_by_key(|(_, offset, _)| *offset);
        found
    };
    let runs = table.get_ref().get("run").and_then(|runs| runs.get_ref().as_array()).into_iter().flatten();
    let of_runs = runs.filter_map(|run| run.get_ref().as_table()).flat_map(|run| of(run, &RUN_KEYS));
    of(table.get_ref(), &KEYS).into_iter().chain(of_runs).collect()
}

/// `unknown role 'hold-out'; did you mean 'holdout'? (known: fit, holdout)`
fn unknown(what: &str, found: &str, known: &[&str]) -> String {
    format!("unknown {what} '{found}'{} (known: {})", did_you_mean(found, known), known.join(", "))
}

/// `; did you mean '…'?` where a known word comes near, else nothing.
pub(super) fn did_you_mean(found: &str, known: &[&str]) -> String {
    known
        .iter()
        .map(|k| (strsim::jaro_winkler(found, k), k))
        .filter(|(score, _)| *score > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or_else(String::new, |(_, k)| format!("; did you mean '{k}'?"))
}
