//! Campaigns in Parquet as pyarrow, pandas and polars write them: the same numbers as in CSV, the same refusals.

use sealegs_sysid::{Campaign, Error};
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/parquet").join(name)
}

/// A campaign of this one file.
fn campaign(name: &str) -> Result<Campaign, Error> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(data(name), folder.path().join(name)).unwrap();
    let text = format!(
        "name = \"t\"\nbench = \"locked\"\nactuator = \"a\"\n[[run]]\nfile = \"{name}\"\nrole = \"fit\"\n"
    );
    std::fs::write(folder.path().join("campaign.toml"), text).unwrap();
    Campaign::read(folder.path())
}

#[test]
fn reference_parquet_of_every_writer_holds_the_numbers_of_the_csv() {
    let csv = campaign("table.csv").unwrap();
    let csv = &csv.runs[0];
    assert_eq!(csv.record.len(), 40);
    assert_eq!(csv.unknown.len(), 3);
    assert_eq!(csv.unknown[2].values[1], 9_223_372_036_855_824_384.0);
    for name in [
        "pyarrow.parquet",
        "polars.parquet",
        "pandas.parquet",
        "pyarrow_zstd_v2_groups.parquet",
        "pyarrow_delta_split.parquet",
        "pandas_index.parquet",
    ] {
        let read = campaign(name).unwrap_or_else(|e| panic!("{e}"));
        let run = &read.runs[0];
        assert_eq!(run.record.time_s, csv.record.time_s, "{name}");
        assert_eq!(run.record.inputs, csv.record.inputs, "{name}");
        assert_eq!(run.record.outputs, csv.record.outputs, "{name}");
        assert_eq!(run.unknown[..3], csv.unknown[..], "{name}");
        assert_eq!(run.scored, csv.scored);
        assert_eq!(run.unknown.len(), if name == "pandas_index.parquet" { 4 } else { 3 });
    }
}

#[test]
fn what_is_wrong_with_a_parquet_file_is_named_by_row_and_column() {
    for (name, said) in [
        ("null", &["row 12", "'force_1_n'", "the cell is empty"][..]),
        ("nan", &["row 12", "'force_1_n'", "not finite"]),
        ("infinite", &["row 12", "'force_1_n'", "not finite"]),
        ("text", &["row 1,", "'force_1_n'", "String"]),
        ("boolean", &["row 1,", "'force_1_n'", "true and false"]),
        ("timestamp", &["row 1,", "'time_s'", "Timestamp"]),
        ("list", &["'force_1_n'", "lists"]),
        ("repeated_time", &["row 12", "'time_s'", "repeats"]),
        ("unit", &["'force_1_lbf'", "known unit"]),
        ("two_inputs", &["two input columns", "current_a, motor_force_n"]),
        ("short", &["15 rows"]),
        ("no_input", &["no input column"]),
        ("no_time", &["'time_s'", "is missing"]),
        ("gzip", &["'time_s'", "GZIP", "snappy"]),
    ] {
        let file = format!("bad_{name}.parquet");
        let message = campaign(&file).unwrap_err().to_string();
        for word in said.iter().chain([&file.as_str()]) {
            assert!(message.contains(word), "{message} does not say {word}");
        }
        assert!(!message.contains('\n') && !message.contains("line "), "{message}");
    }
}

#[test]
fn a_file_that_is_no_parquet_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let description = "bench = \"locked\"\nactuator = \"a\"\n[[run]]\nfile = \"r.parquet\"\nrole = \"fit\"\n";
    std::fs::write(folder.path().join("campaign.toml"), description).unwrap();
    let good = std::fs::read(data("polars.parquet")).unwrap();
    for (bytes, said) in [
        (&b""[..], "is empty"),
        (&b"time_s,current_a\n0,1\n"[..], "no readable Parquet"),
        (&good[..good.len() / 2], "no readable Parquet"),
        (&good[good.len() / 2..], "no readable Parquet"),
    ] {
        std::fs::write(folder.path().join("r.parquet"), bytes).unwrap();
        let message = Campaign::read(folder.path()).unwrap_err().to_string();
        assert!(message.contains("r.parquet") && message.contains(said), "{message}");
    }
}

/// The library that decodes Parquet panics on both; neither panic nor a second message may come of it.
#[test]
fn regress_a_file_whose_parts_contradict_each_other_is_refused() {
    let good = std::fs::read(data("pyarrow_delta_split.parquet")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let description = "bench = \"locked\"\nactuator = \"a\"\n[[run]]\nfile = \"r.parquet\"\nrole = \"fit\"\n";
    std::fs::write(folder.path().join("campaign.toml"), description).unwrap();
    let mut contradicted = 0;
    for at in 0..good.len() {
        let mut bytes = good.clone();
        // Signs and lengths are in the low bits of the format's numbers.
        bytes[at] ^= 1;
        std::fs::write(folder.path().join("r.parquet"), bytes).unwrap();
        if let Err(error) = Campaign::read(folder.path()) {
            let message = error.to_string();
            assert!(message.contains("r.parquet") && !message.contains('\n'), "{message}");
            contradicted += usize::from(message.contains("contradict"));
        }
    }
    assert!(contradicted > 0, "the fence is no longer needed");
}
