//! Damaged logs: whatever the bytes, reading ends soon, in little memory, with tables or with a message that names the
//! file; and what was read can be looked at and joined.

use proptest::prelude::*;
use sealegs_damage::{cases, damaged, damaged_bytes, survives};
use sealegs_logs::columns::ColumnMap;
use sealegs_logs::join::{File, Request, join};
use sealegs_logs::{parse, survey};
use std::path::Path;

fn good(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap()
}

/// Reads, surveys and joins the bytes as a file of this name.
fn survive(name: &'static str, bytes: Vec<u8>) {
    survives(move || {
        let path = Path::new(name);
        let log = match parse(path, bytes) {
            Ok(log) => log,
            Err(error) => {
                let message = error.to_string();
                assert!(message.starts_with(name) && !message.contains('\n'), "{message:?}");
                return;
            }
        };
        for table in &log.tables {
            for column in &table.columns {
                assert_eq!(column.values.len(), table.rows(), "{}", column.name);
                let first = column.values.iter().position(|v| !v.is_finite());
                assert_eq!(column.fault.as_ref().map(|f| f.row), first, "{}", column.name);
            }
        }
        let _ = survey::survey(&log);
        let names = [
            "t",
            "log_time_s",
            "timestamp",
            "q",
            "u",
            "data",
            "action[0]",
            "position[knee]",
            "fit.csv (fit)/force_1_n/measured",
        ];
        let targets = [
            "time_s",
            "time_s",
            "time_s",
            "force_1_n",
            "current_a",
            "force_2_n",
            "position_m",
            "joint_angle_rad",
            "spring_deflection_m",
        ];
        let map = |(source, target): (&str, &str)| ColumnMap {
            source: source.to_owned(),
            optional: true,
            ..ColumnMap::plain(target)
        };
        let columns: Vec<ColumnMap> = names.into_iter().zip(targets).map(map).collect();
        let request = Request {
            columns: &columns,
            sample_rate_hz: Some(1000.0),
            episode: None,
            known: &|_| false,
            held: &|name| name == "current_a",
        };
        let file = File { path: path.to_owned(), label: name.to_owned(), offset_s: 0.0, log };
        if let Ok(joined) = join(vec![file], &request) {
            assert!(joined.time_s.windows(2).all(|w| w[1] > w[0]));
            for (name, values) in &joined.channels {
                assert_eq!(values.len(), joined.time_s.len(), "{name}");
            }
        }
    });
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn damaged_texts(bytes in prop_oneof![
        damaged(&good("semicolon.csv")), damaged(&good("savetxt.txt")), damaged(&good("comments.csv")),
    ]) {
        survive("r.csv", bytes);
    }

    #[test]
    fn damaged_json(bytes in prop_oneof![
        damaged(&good("entries.json")), damaged(&good("columns.json")), damaged(&good("lines.jsonl")),
    ]) {
        survive("r.json", bytes);
    }

    #[test]
    fn damaged_matlab(bytes in prop_oneof![
        damaged_bytes(&good("plain.mat")), damaged_bytes(&good("packed.mat")), damaged_bytes(&good("dspace.mat")),
    ]) {
        survive("r.mat", bytes);
    }

    #[test]
    fn damaged_npy(bytes in prop_oneof![
        damaged_bytes(&good("record.npy")), damaged_bytes(&good("matrix.npy")),
    ]) {
        survive("r.npy", bytes);
    }

    #[test]
    fn damaged_npz(bytes in prop_oneof![
        damaged_bytes(&good("plain.npz")), damaged_bytes(&good("packed.npz")),
    ]) {
        survive("r.npz", bytes);
    }

    #[test]
    fn damaged_parquet(bytes in damaged_bytes(&good("lerobot.parquet"))) {
        survive("r.parquet", bytes);
    }

    #[test]
    fn damaged_mcap(bytes in prop_oneof![
        damaged_bytes(&good("json_none.mcap")),
        damaged_bytes(&good("json_zstd.mcap")),
        damaged_bytes(&good("json_lz4.mcap")),
        damaged_bytes(&good("bag.mcap")),
    ]) {
        survive("r.mcap", bytes);
    }

    #[test]
    fn damaged_hdf5(bytes in prop_oneof![
        damaged_bytes(&good("plain.h5")), damaged_bytes(&good("level73.mat")),
    ]) {
        survive("r.h5", bytes);
    }

    #[test]
    fn damaged_recordings(bytes in damaged_bytes(&good("small.rrd"))) {
        survive("r.rrd", bytes);
    }

    #[test]
    fn damaged_bags(bytes in damaged_bytes(&good("bag.db3"))) {
        survive("r.db3", bytes);
    }
}

#[test]
fn a_packed_chunk_whose_end_never_comes_is_refused() {
    for name in ["endless_lz4.mcap", "endless_zstd.mcap"] {
        let bytes = good(name);
        survives(move || {
            let error = parse(Path::new("r.mcap"), bytes).map(|_| ()).expect_err("broken").to_string();
            assert!(error.starts_with("r.mcap: a "), "{error}");
        });
    }
}

/// Found by a million damaged files: the chunk claims more bytes than the file has left, and its frame has lost a byte.
#[test]
fn a_packed_chunk_that_is_cut_off_is_not_unpacked_without_end() {
    let mut bytes = good("json_lz4.mcap");
    assert_eq!((bytes[43], bytes[44], bytes[67]), (0xad, 4, 0x80), "not the file that this was found in");
    (bytes[44], bytes[67]) = (9, 0);
    survive("r.mcap", bytes);
}
