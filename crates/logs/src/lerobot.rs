//! Datasets in LeRobot's layout: what their metadata calls the numbers of a list column.

use serde_json::Value;
use std::path::{Path, PathBuf};

/// The column that holds the measured positions of the joints.
pub const STATE: &str = "observation.state";

/// The column that holds their goals.
pub const ACTION: &str = "action";

/// Folders above a file in which its dataset's `meta/info.json` is looked for: `data/chunk-000/file-000.parquet`.
const FOLDERS_UP: usize = 4;

/// Longest metadata that is read, bytes; real ones have some ten thousand.
const MOST_BYTES: u64 = 1 << 24;

/// Columns that number rows and episodes, and tell nothing of a joint.
pub const BOOKKEEPING: [&str; 4] = ["frame_index", "episode_index", "index", "task_index"];

/// The metadata of the dataset that a file or folder belongs to, or is.
fn metadata(of: &Path) -> Option<PathBuf> {
    let of = std::fs::canonicalize(of).ok()?;
    let files = of.ancestors().take(FOLDERS_UP + 1).map(|f| f.join("meta").join("info.json"));
    files.into_iter().find(|info| info.is_file())
}

/// The files that hold the rows of a dataset, or of a part of it, by its folder or its `meta/info.json`; in their order. `None` where it
/// is none.
#[must_use]
pub fn data_files(dataset: &Path) -> Option<Vec<PathBuf>> {
    let info = metadata(dataset)?;
    let folder = match dataset.is_dir() {
        true => dataset.to_owned(),
        false if std::fs::canonicalize(dataset).ok()? == info => dataset.parent()?.parent()?.to_owned(),
        false => return None,
    };
    let mut found = Vec::new();
    let mut folders = vec![(folder, 0)];
    while let Some((folder, depth)) = folders.pop() {
        let entries = std::fs::read_dir(&folder).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
        for path in entries {
            let is_rows = path.extension().is_some_and(|e| e == "parquet");
            if path.is_dir() && depth < FOLDERS_UP && !path.ends_with("meta") {
                folders.push((path, depth + 1));
            } else if is_rows {
                found.push(path);
            }
        }
    }
    found.sort();
    (!found.is_empty()).then_some(found)
}

/// The joints of a dataset's columns, `shoulder_pan` for `action[0]`; none where there is no metadata that says so.
#[must_use]
pub fn joint_names(file: &Path) -> Vec<(String, String)> {
    let Some(info) = metadata(file) else { return Vec::new() };
    let fits = std::fs::metadata(&info).is_ok_and(|m| m.len() <= MOST_BYTES);
    let text = if fits { std::fs::read_to_string(&info).unwrap_or_default() } else { String::new() };
    let info: Value = serde_json::from_str(&text).unwrap_or_default();
    [ACTION, STATE].into_iter().flat_map(|feature| of_feature(&info, feature)).collect()
}

/// Names of one feature's numbers, which are a list or lie in a table of lists (`{"motors": [...]}`).
fn of_feature(info: &Value, feature: &str) -> Vec<(String, String)> {
    let names = &info["features"][feature]["names"];
    let lists = names.as_object().map(|groups| groups.values().collect::<Vec<_>>());
    let lists = lists.unwrap_or_else(|| vec![names]);
    let all = lists.into_iter().filter_map(Value::as_array).flatten().filter_map(Value::as_str);
    all.enumerate().map(|(i, name)| (format!("{feature}[{i}]"), joint_of(name).to_owned())).collect()
}

/// `shoulder_pan` of `shoulder_pan.pos`.
fn joint_of(name: &str) -> &str {
    name.strip_suffix(".pos").unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_both_layouts_are_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let data = folder.path().join("data").join("chunk-000");
        std::fs::create_dir_all(&data).expect("made");
        std::fs::create_dir_all(folder.path().join("meta")).expect("made");
        let file = data.join("file-000.parquet");
        std::fs::write(&file, "").expect("written");
        assert_eq!(joint_names(&file), []);
        let info = r#"{"features": {"action": {"names": ["pan.pos", "lift.pos"]},
            "observation.state": {"names": {"motors": ["pan", "lift"]}}, "timestamp": {"names": null}}}"#;
        std::fs::write(folder.path().join("meta").join("info.json"), info).expect("written");
        let pair = |column: &str, joint: &str| (column.to_owned(), joint.to_owned());
        let expected = [
            pair("action[0]", "pan"),
            pair("action[1]", "lift"),
            pair("observation.state[0]", "pan"),
            pair("observation.state[1]", "lift"),
        ];
        assert_eq!(joint_names(&file), expected);
        let meta = folder.path().join("meta");
        for dataset in [folder.path(), &folder.path().join("data"), &meta.join("info.json")] {
            let names = data_files(dataset).expect("a dataset");
            assert!(names.len() == 1 && names[0].ends_with("file-000.parquet"), "{names:?}");
        }
        assert_eq!(data_files(&file), None);
        std::fs::write(meta.join("info.json"), "{").expect("written");
        assert_eq!(joint_names(&file), []);
    }
}
