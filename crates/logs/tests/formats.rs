//! The same run as other people's tools write it, in every format: the same numbers come out of each.

use sealegs_logs::survey::survey;
use sealegs_logs::{Log, Table, read};
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn log(name: &str) -> Log {
    read(&data(name)).unwrap_or_else(|e| panic!("{e}"))
}

const ROWS: usize = 40;

fn t(row: usize) -> f64 {
    row as f64 * 0.001
}

fn q(row: usize) -> f64 {
    ((0.5 * (0.2 * row as f64).sin()) * 1e6).round() / 1e6
}

fn u(row: usize) -> f64 {
    if row % 10 < 5 { 1.5 } else { -1.5 }
}

/// The column holds what the function says, to single precision where that is what is stored.
fn holds(table: &Table, name: &str, expected: impl Fn(usize) -> f64, tolerance: f64) {
    let column = table.column(name).unwrap_or_else(|| panic!("no {name} in {:?}", names(table)));
    assert_eq!(column.fault, None, "{name}");
    assert_eq!(column.values.len(), ROWS, "{name}");
    for (row, value) in column.values.iter().enumerate() {
        let wanted = expected(row);
        assert!((value - wanted).abs() <= tolerance, "{name}, row {row}: {value} is not {wanted}");
    }
}

fn names(table: &Table) -> Vec<&str> {
    table.columns.iter().map(|c| c.name.as_str()).collect()
}

/// Decimals are kept exactly by every format but those of single precision.
const EXACT: f64 = 1e-15;
const SINGLE: f64 = 1e-7;

#[test]
fn reference_texts_hold_the_numbers() {
    for name in ["semicolon.csv", "savetxt.txt", "comments.csv"] {
        let log = log(name);
        let table = &log.tables[0];
        assert_eq!(names(table), ["t", "q", "u", "i"], "{name}");
        holds(table, "t", t, EXACT);
        holds(table, "q", q, EXACT);
        holds(table, "u", u, EXACT);
        holds(table, "i", |row| row as f64, 0.0);
    }
}

#[test]
fn reference_matlab_files_hold_the_numbers() {
    let packed = log("packed.mat");
    let table = &packed.tables[0];
    holds(table, "t", t, EXACT);
    holds(table, "q", q, EXACT);
    holds(table, "i", |row| row as f64, 0.0);
    assert_eq!(packed.constants, [("gain".to_owned(), 35.15)]);
    assert!(packed.notes.iter().any(|n| n.contains("'label' is text")), "{:?}", packed.notes);
    let plain = log("plain.mat");
    let table = &plain.tables[0];
    holds(table, "data.t", t, EXACT);
    holds(table, "data.both[0]", q, EXACT);
    holds(table, "data.both[1]", u, EXACT);
    assert_eq!(plain.constants, [("data.gain".to_owned(), 35.15)]);
    let recorded = log("dspace.mat");
    let table = &recorded.tables[0];
    holds(table, "Time", t, EXACT);
    holds(table, "angle", q, EXACT);
    holds(table, "Model Root/volts", u, EXACT);
    let logged = log("simulink.mat");
    let table = &logged.tables[0];
    holds(table, "logged.time", t, EXACT);
    holds(table, "angle", q, EXACT);
    holds(table, "volts", u, EXACT);
    let newer = log("level73.mat");
    let table = &newer.tables[0];
    assert_eq!(newer.format, "MATLAB (HDF5)");
    holds(table, "t", t, EXACT);
    holds(table, "data.q", q, EXACT);
    holds(table, "data.both[0]", q, EXACT);
    holds(table, "data.both[1]", u, EXACT);
    holds(table, "data.i", |row| row as f64, 0.0);
    holds(table, "data.on", |row| f64::from(u8::from(u(row) > 0.0)), 0.0);
    assert_eq!(table.column("data.on").unwrap().holds.as_deref(), Some("true and false"));
    assert_eq!(newer.constants, [("gain".to_owned(), 35.15)]);
    for said in ["'label' is a char", "'nothing' has no numbers"] {
        assert!(newer.notes.iter().any(|n| n.contains(said)), "{said}: {:?}", newer.notes);
    }
}

#[test]
fn reference_hdf5_holds_the_numbers() {
    let log = log("plain.h5");
    let table = &log.tables[0];
    assert_eq!(log.format, "HDF5");
    holds(table, "rig.t", t, EXACT);
    holds(table, "rig.q", q, 1e-7);
    holds(table, "rig.motor.both[0]", q, EXACT);
    holds(table, "rig.motor.both[1]", u, EXACT);
    holds(table, "rig.on", |row| f64::from(u8::from(u(row) > 0.0)), 0.0);
    // Of a date since 1970 in ns a double keeps a quarter of a microsecond.
    let stamps = &table.column("rig.stamp_ns").unwrap().values;
    assert!((0..ROWS).all(|row| (stamps[row] - stamps[0] - 1e6 * row as f64).abs() <= 512.0));
    assert_eq!(log.constants, [("gain".to_owned(), 35.15)]);
    assert!(log.notes.iter().any(|n| n.contains("'rig.label' holds text")), "{:?}", log.notes);
}

#[test]
fn reference_numpy_files_hold_the_numbers() {
    let plain = log("plain.npz");
    holds(&plain.tables[0], "t", t, EXACT);
    holds(&plain.tables[0], "q", q, SINGLE);
    holds(&plain.tables[0], "both[1]", u, EXACT);
    assert_eq!(plain.constants, [("gain".to_owned(), 35.15)]);
    let packed = log("packed.npz");
    holds(&packed.tables[0], "q", q, EXACT);
    holds(&packed.tables[0], "i", |row| row as f64, 0.0);
    let record = log("record.npy");
    let table = &record.tables[0];
    holds(table, "array.t", t, EXACT);
    holds(table, "array.q", q, SINGLE);
    holds(table, "array.pair[1]", |row| -(row as f64), 0.0);
    holds(table, "array.on", |row| f64::from(u8::from(u(row) > 0.0)), 0.0);
    assert!(record.notes[0].contains("'array.name' holds <U4"), "{:?}", record.notes);
    let matrix = log("matrix.npy");
    holds(&matrix.tables[0], "array[1]", q, EXACT);
}

#[test]
fn reference_json_holds_the_numbers() {
    for name in ["entries.json", "lines.jsonl"] {
        let log = log(name);
        let table = &log.tables[0];
        holds(table, "t", t, EXACT);
        holds(table, "motor.q", q, EXACT);
        holds(table, "motor.pair[0]", u, EXACT);
        holds(table, "motor.pair[1]", |row| row as f64, 0.0);
    }
    holds(&log("columns.json").tables[0], "q", q, EXACT);
    assert_eq!(log("entries.json").constants, [("kp".to_owned(), 100.0)]);
}

#[test]
fn reference_parquet_of_lerobot_holds_lists_episodes_and_stamps() {
    let log = log("lerobot.parquet");
    let table = &log.tables[0];
    assert_eq!(table.rows(), 3 * ROWS);
    let state = table.column("observation.state[0]").unwrap();
    assert!((state.values[ROWS + 7] - (q(7) + 1.0)).abs() < SINGLE);
    assert_eq!(table.column("action[0]").unwrap().values[5], -1.5);
    assert_eq!(table.column("next.done").unwrap().values[ROWS - 1], 1.0);
    assert!(table.column("task").unwrap().fault.as_ref().unwrap().problem.contains("String"));
    let stamp = table.column("stamp").unwrap();
    assert!(stamp.holds.as_ref().unwrap().contains("nanoseconds"));
    assert_eq!(stamp.values[1] - stamp.values[0], 1e6);
}

#[test]
fn reference_mcap_holds_the_numbers_in_every_compression() {
    for name in ["json_none.mcap", "json_zstd.mcap", "json_lz4.mcap"] {
        let log = log(name);
        let table = &log.tables[0];
        assert_eq!(table.name, "/rig");
        holds(table, "q", q, EXACT);
        holds(table, "i", |row| row as f64, 0.0);
        // Seconds since a whole one near the first message: nanoseconds are kept.
        holds(table, "log_time_s", |row| 0.123_456_789 + t(row), 1e-12);
        assert_eq!(table.column("log_time_s").unwrap().origin, 1_700_000_000);
    }
}

#[test]
fn reference_ros_bags_hold_joints_by_their_names() {
    for name in ["bag.mcap", "bag.db3"] {
        let log = log(name);
        let states = log.tables.iter().find(|t| t.name == "/joint_states").unwrap();
        // The order of the joints changes from message to message.
        holds(states, "position[knee]", q, EXACT);
        holds(states, "position[ankle]", |row| -q(row), EXACT);
        holds(states, "velocity[ankle]", |row| -2.0 * q(row), EXACT);
        holds(states, "header.stamp_s", |row| 0.123_456_789 + t(row), 1e-12);
        holds(states, "log_time_s", |row| 0.123_756_789 + t(row), 1e-12);
        let commands = log.tables.iter().find(|t| t.name == "/commands").unwrap();
        assert_eq!(commands.column("data[1]").unwrap().values, [0.0, 10.0, 20.0, 30.0]);
        let command = log.tables.iter().find(|t| t.name == "/command").unwrap();
        assert_eq!(command.column("data").unwrap().values, [1.5; 4]);
    }
}

#[test]
fn a_recording_that_was_cut_off_is_read_as_far_as_it_goes() {
    let bytes = std::fs::read(data("json_none.mcap")).unwrap();
    let half = sealegs_logs::parse(Path::new("half.mcap"), bytes[..bytes.len() / 2].to_vec()).unwrap();
    let rows = half.tables[0].rows();
    assert!(rows > 5 && rows < ROWS, "{rows}");
    assert!(half.notes.iter().any(|n| n.contains("ends within a record")), "{:?}", half.notes);
}

#[test]
fn reference_recordings_of_rerun_hold_the_numbers() {
    let log = log("small.rrd");
    assert_eq!(log.format, "Rerun");
    let starts = [
        ("check.csv (holdout)", 0.5, "time"),
        ("fit.csv (fit)", 0.0, "time of fit.csv (fit)/force_1_n/measured"),
    ];
    for (table, (run, from_s, clock)) in log.tables.iter().zip(starts) {
        holds(table, clock, |row| from_s + t(row), EXACT);
        assert_eq!(table.clock, Some(0));
        let sine = |row: usize| (0.2 * row as f64).sin();
        holds(table, &format!("{run}/force_1_n/measured"), sine, 0.0);
        holds(table, &format!("{run}/force_1_n/model_before"), |row| 0.9 * sine(row), 0.0);
        holds(table, &format!("{run}/motor_angle_rad/measured"), |row| 0.1 * row as f64, 0.0);
    }
    assert!(log.notes.iter().all(|n| n.contains("ends within")), "{:?}", log.notes);
}

#[test]
fn what_is_not_read_says_what_to_do() {
    for (name, bytes, said) in [
        ("r.rrd", &b"RRF2"[..], "no readable recording of Rerun: it ends within its first line"),
        ("r.rrd", b"nothing at all of it", "no readable recording of Rerun"),
        ("r.h5", b"\x89HDF\r\n\x1a\n", "HDF5"),
        ("r.mcap", b"nothing", "no readable MCAP"),
        ("r.npz", b"nothing", "no readable NPZ"),
        ("r.npy", b"nothing", "no readable NumPy"),
        (
            "r.npy",
            b"\x93NUMPY\x01\x00\x37\x00{'descr': '<\n8', 'fortran_order': False, 'shape': (1,)}",
            "'<\\n8'",
        ),
        ("r.mat", b"nothing", "no MAT-file"),
        ("r.json", b"nothing", "no readable JSON"),
        ("r.db3", b"nothing", "no readable ROS 2 bag"),
        ("r.csv", b"", "is empty"),
    ] {
        let message = sealegs_logs::parse(Path::new(name), bytes.to_vec()).unwrap_err().to_string();
        assert!(message.starts_with(name) && message.contains(said), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
}

#[test]
fn every_format_is_surveyed() {
    for entry in std::fs::read_dir(data("")).unwrap() {
        let path = entry.unwrap().path();
        let Ok(log) = read(&path) else { continue };
        let survey = survey(&log);
        let clock = survey.tables[0].clock.as_ref();
        let timed = !path.ends_with("matrix.npy");
        assert_eq!(clock.is_some(), timed, "{}", path.display());
        if let Some(clock) = clock {
            // LeRobot's stamps begin anew with every episode.
            assert!((clock.rate_hz - 1000.0).abs() < 1.0, "{}: {clock:?}", path.display());
        }
    }
}
