//! Damaged campaigns: whatever the bytes, reading ends soon, in little memory, with data or with a message
//! that names the file.

use proptest::prelude::*;
use sealegs_damage::{cases, damaged, damaged_bytes, survives};
use sealegs_sysid::{Campaign, Error};
use std::path::Path;

const CAMPAIGN: &str = "name = \"t\"\nbench = \"locked\"\nactuator = \"a\"\nsample_rate_hz = 1000.0\n\
    input_hold = \"linear\"\n[noise_std]\nforce_1_n = 2.0\n[[run]]\nfile = \"r.csv\"\nrole = \"fit\"\n\
    from_s = 0.001\nto_s = 0.030\n[[run]]\nfile = \"h.csv\"\nrole = \"holdout\"\n";

/// A campaign that maps columns and joins two files.
const MAPPED: &str = "bench = \"locked\"\nactuator = \"a\"\n[columns]\n\"time_s\" = { as = \"time_s\", unit = \"ms\" }\n\
    \"current_a\" = { as = \"current_a\", scale = 2.0, offset = 1.0, sign = -1 }\n\
    \"r.csv:force_1_n\" = \"force_1_n\"\n\"h.csv:force_1_n\" = { as = \"motor_angle_rad\", unit = \"deg\", wrap = true }\n\
    [[run]]\nfiles = [\"r.csv\", { file = \"h.csv\", offset_s = 0.001 }]\nrole = \"fit\"\nunit = \"left\"\n\
    [run.columns]\n\"r.csv:current_a\" = \"current_a\"\n\"time_s\" = { as = \"time_s\", scale = 1.0 }\n";

fn csv() -> String {
    let row = |i: u32| format!("{:.3},{},{:.2}\n", f64::from(i) * 1e-3, i % 5, f64::from(i % 7) * 0.25);
    "time_s,current_a,force_1_n\n".to_owned() + &(0..40).map(row).collect::<String>()
}

fn parquet(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/parquet");
    std::fs::read(folder.join(name)).unwrap()
}

/// Reads a campaign of these files, which must end well or with a message that names a file of it.
fn read(files: Vec<(&'static str, Vec<u8>)>) -> Result<Campaign, Error> {
    let read = survives(move || {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let read = Campaign::read(folder.path());
        if let Err(error) = &read {
            let message = error.to_string();
            let named = message.strip_prefix(&*folder.path().to_string_lossy()).is_some();
            assert!(named, "{message:?}");
        }
        read
    });
    if let Ok(campaign) = &read {
        for run in &campaign.runs {
            assert!(run.scored.len() >= 16 && run.record.time_s.iter().all(|t| t.is_finite()));
        }
    }
    read
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn a_damaged_campaign_file_is_read_or_refused(toml in damaged(CAMPAIGN.as_bytes())) {
        let _ = read(vec![("campaign.toml", toml), ("r.csv", csv().into()), ("h.csv", csv().into())]);
    }

    #[test]
    fn a_damaged_campaign_file_of_maps_is_read_or_refused(toml in damaged(MAPPED.as_bytes())) {
        let _ = read(vec![("campaign.toml", toml), ("r.csv", csv().into()), ("h.csv", csv().into())]);
    }

    #[test]
    fn a_damaged_csv_file_is_read_or_refused(table in damaged(csv().as_bytes())) {
        let _ = read(vec![("campaign.toml", CAMPAIGN.into()), ("r.csv", table), ("h.csv", csv().into())]);
    }

    #[test]
    fn a_damaged_parquet_file_is_read_or_refused(
        table in prop_oneof![
            damaged_bytes(&parquet("polars.parquet")),
            damaged_bytes(&parquet("pyarrow.parquet")),
            damaged_bytes(&parquet("pyarrow_zstd_v2_groups.parquet")),
            damaged_bytes(&parquet("pyarrow_delta_split.parquet")),
        ]
    ) {
        let toml = CAMPAIGN.replace("r.csv", "r.parquet");
        let _ = read(vec![("campaign.toml", toml.into()), ("r.parquet", table), ("h.csv", csv().into())]);
    }
}

#[test]
fn the_maps_that_are_damaged_are_good() {
    let files = vec![("campaign.toml", MAPPED.into()), ("r.csv", csv().into()), ("h.csv", csv().into())];
    let run = read(files).unwrap_or_else(|e| panic!("{e}")).runs.remove(0);
    // The second file begins a row later.
    assert_eq!(run.record.len(), 39);
    assert_eq!(run.unit.as_deref(), Some("left"));
}
