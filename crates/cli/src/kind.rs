//! What kind of file somebody gave, so that a message can say what was meant.

use crate::failure::{OrBadInput, bad_input};
use sealegs::Campaign;
use sealegs::leg::scenario::preset_names;
use std::path::Path;

/// Endings of the logs that `sealegs import` reads.
const LOGS: [&str; 15] = [
    "csv", "tsv", "txt", "parquet", "mat", "h5", "hdf5", "json", "jsonl", "npz", "npy", "mcap", "db3", "bag",
    "rrd",
];

/// A kind of file that some verb takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A campaign's folder or its `campaign.toml`.
    Campaign,
    /// A folder without a `campaign.toml`.
    Folder,
    /// A table of measurements.
    Log,
    /// A robot.
    Urdf,
    /// An actuator's file.
    Actuator,
    /// A leg's scenario.
    Scenario,
    /// A user's own effect.
    Effect,
    /// Which actuator spans which links of a robot.
    Placement,
}

impl Kind {
    /// The kind of what is at this path, if it is there and can be told.
    fn of(path: &Path) -> Option<Self> {
        if path.is_dir() {
            return Some(if path.join("campaign.toml").is_file() { Self::Campaign } else { Self::Folder });
        }
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        if !path.is_file() {
            return None;
        }
        match extension.as_str() {
            "urdf" => Some(Self::Urdf),
            "toml" => Self::of_toml(&std::fs::read_to_string(path).ok()?),
            other => LOGS.contains(&other).then_some(Self::Log),
        }
    }

    /// By keys that only one kind has.
    fn of_toml(text: &str) -> Option<Self> {
        let table: toml::Table = text.parse().ok()?;
        let has = |key: &str| table.contains_key(key);
        match () {
            () if has("bench") || has("run") => Some(Self::Campaign),
            () if has("law") || has("acts-on") => Some(Self::Effect),
            () if has("transmission") || has("motor") => Some(Self::Actuator),
            () if table.get("actuator").is_some_and(toml::Value::is_array) => Some(Self::Placement),
            () if has("start") || has("controller") || has("duration_s") => Some(Self::Scenario),
            () => None,
        }
    }

    /// What it is, and what it is good for.
    fn words(self, path: &Path) -> String {
        let shown = path.display();
        match self {
            Self::Campaign => {
                let folder = if path.is_dir() { Some(path) } else { path.parent() };
                let folder = folder.filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
                format!("is a campaign; `sealegs diagnose {}` is for it", folder.display())
            }
            Self::Folder => {
                "is a folder without a campaign.toml; `sealegs import LOG -o FOLDER` writes one".to_owned()
            }
            Self::Log => format!("is a log; `sealegs import {shown} -o FOLDER` writes a campaign for it"),
            Self::Urdf => format!("is a robot; `sealegs run {shown}` lets it fall"),
            Self::Actuator => {
                format!("is an actuator's file; `sealegs bench locked --actuator {shown}` runs it")
            }
            Self::Scenario => format!("is a leg's scenario; `sealegs run {shown}` runs it"),
            Self::Effect => {
                format!("is an effect of your own; `sealegs diagnose CAMPAIGN --effect {shown}` tries it")
            }
            Self::Placement => "is a robot's placement file; it is read with the URDF beside it".to_owned(),
        }
    }
}

/// Reads a campaign; where something else was given, one line says what that is and which command it is for.
pub(crate) fn campaign(path: &Path) -> anyhow::Result<Campaign> {
    match Kind::of(path) {
        None => Campaign::read(path).map_err(|error| {
            let shipped = path.to_str().and_then(shipped);
            shipped.map_or_else(|| bad_input(error), |said| bad_input(format!("{}: {said}", path.display())))
        }),
        Some(Kind::Campaign) => Campaign::read(path).or_bad_input(),
        Some(other) => {
            let said = other.words(path);
            Err(bad_input(format!("{}: {said}; this command takes a campaign's folder", path.display())))
        }
    }
}

/// What a name stands for that comes with the program and is no file here.
fn shipped(name: &str) -> Option<String> {
    if name == "leg-drop" {
        return Some("no such folder; `sealegs tour` unpacks this campaign as tour/leg-drop".to_owned());
    }
    preset_names().contains(&name).then(|| {
        format!("is a scenario; `sealegs run {name}` runs it; this command takes a campaign's folder")
    })
}

/// Refuses what is no scenario where one is wanted. A path of which nothing can be said passes.
pub(crate) fn expect_scenario(name: &str) -> anyhow::Result<()> {
    let path = Path::new(name);
    match Kind::of(path) {
        None | Some(Kind::Scenario) => Ok(()),
        Some(other) => Err(bad_input(format!(
            "{name}: {}; this command takes a scenario (see `sealegs list`)",
            other.words(path)
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toml_files_are_told_by_their_keys() {
        let kind = |text: &str| Kind::of_toml(text);
        assert_eq!(kind("bench = 'locked'\n[[run]]\nfile = 'a.csv'"), Some(Kind::Campaign));
        assert_eq!(kind("id = 'x'\nlaw = 'a*y'"), Some(Kind::Effect));
        assert_eq!(kind("id = 'x'\n[motor]\n[transmission]"), Some(Kind::Actuator));
        assert_eq!(kind("robot = 'thor-leg'\nduration_s = 1.0"), Some(Kind::Scenario));
        assert_eq!(kind("[[actuator]]\nname = 'knee'"), Some(Kind::Placement));
        assert_eq!(kind("x = 1"), None);
        assert_eq!(kind("not toml"), None);
    }

    #[test]
    fn names_that_come_with_the_program_are_told() {
        let said = |name: &str| campaign(Path::new(name)).unwrap_err().to_string();
        assert!(said("thor-drop").contains("`sealegs run thor-drop`"), "{}", said("thor-drop"));
        assert!(said("leg-drop").contains("tour/leg-drop"), "{}", said("leg-drop"));
        assert!(said("no-such").contains("cannot be read"), "{}", said("no-such"));
    }

    #[test]
    fn shipped_files_are_what_they_are() {
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        let kind = |file: &str| Kind::of(&assets.join(file));
        assert_eq!(kind("campaigns/leg-drop"), Some(Kind::Campaign));
        assert_eq!(kind("campaigns/leg-drop/fit-05cm.csv"), Some(Kind::Log));
        assert_eq!(kind("campaigns/leg-drop/fit-05cm.toml"), Some(Kind::Scenario));
        assert_eq!(kind("actuators/thor-linear.toml"), Some(Kind::Actuator));
        assert_eq!(kind("scenarios/thor-drop.toml"), Some(Kind::Scenario));
        assert_eq!(kind("robots/thor-leg.urdf"), Some(Kind::Urdf));
        assert_eq!(kind("robots/thor-leg.actuators.toml"), Some(Kind::Placement));
        assert_eq!(kind("campaigns"), Some(Kind::Folder));
        assert_eq!(kind("no-such.toml"), None);
    }
}
