//! A recording of Rerun as a log: what the project's own recorder writes is read back with the same numbers.

use sealegs::logs::{Column, Log, parse, read};
use sealegs::recorder::recording::{ComparedChannel, ComparedRun, Comparison, Output};
use sealegs::{Campaign, Options, compare};
use std::path::Path;

fn written(comparison: &Comparison, folder: &Path) -> std::path::PathBuf {
    let file = folder.join("r.rrd");
    comparison.write(&Output::File(file.clone())).expect("a recording");
    file
}

fn column<'a>(log: &'a Log, name: &str) -> (&'a Column, &'a [f64]) {
    let has = log.tables.iter().find_map(|t| Some((t.column(name)?, &t.columns[t.clock?].values)));
    let (column, time) = has.unwrap_or_else(|| {
        let all: Vec<_> = log.tables.iter().flat_map(|t| &t.columns).map(|c| &c.name).collect();
        panic!("no {name} among {all:?}; {:?}", log.notes)
    });
    (column, time)
}

/// Two runs with clocks of their own, of 40 rows; the value of a row and channel.
fn small() -> Comparison {
    let run = |name: &str, from_s: f64| ComparedRun {
        name: name.to_owned(),
        time_s: (0..40).map(|i| from_s + 0.001 * f64::from(i)).collect(),
        channels: vec![
            ComparedChannel {
                name: "force_1_n".to_owned(),
                unit: "N".to_owned(),
                measured: (0..40).map(|i| (0.2 * f64::from(i)).sin()).collect(),
                before: Some((0..40).map(|i| 0.9 * (0.2 * f64::from(i)).sin()).collect()),
                after: None,
                noise: 0.0,
            },
            ComparedChannel {
                name: "motor_angle_rad".to_owned(),
                unit: "rad".to_owned(),
                measured: (0..40).map(|i| 0.1 * f64::from(i)).collect(),
                before: None,
                after: None,
                noise: 0.0,
            },
        ],
    };
    Comparison {
        name: "small".to_owned(),
        runs: vec![run("fit.csv (fit)", 0.0), run("check.csv (holdout)", 0.5)],
        summary_markdown: "Two runs.".to_owned(),
    }
}

#[test]
fn a_comparison_reads_back_with_the_same_values() {
    let folder = tempfile::tempdir().expect("a folder");
    let campaign = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/campaigns").join("bench-knee");
    let campaign = Campaign::read(&campaign).expect("a campaign");
    let mut recording =
        compare(&campaign, Options::new().as_is(true)).and_then(|c| c.recording()).expect("one");
    // Where the noise is known a model is written as finely as that allows to see.
    recording.runs.iter_mut().flat_map(|run| &mut run.channels).for_each(|channel| channel.noise = 0.0);
    let log = read(&written(&recording, folder.path())).expect("a log");
    assert_eq!(log.format, "Rerun");
    let mut seen = 0;
    for run in &recording.runs {
        for channel in &run.channels {
            let curves = [("measured", Some(&channel.measured)), ("before", channel.before.as_ref())];
            for (what, values) in curves.into_iter().filter_map(|(what, values)| Some((what, values?))) {
                let name = format!("{}/{}/{what}", run.name, channel.name);
                let (column, time) = column(&log, &name);
                assert_eq!(&column.values, values, "{name}");
                assert!(column.fault.is_none());
                for (read, written) in time.iter().zip(&run.time_s) {
                    // The format counts whole nanoseconds.
                    assert!((read - written).abs() <= 5e-10, "{name}: {read}, not {written}");
                }
                seen += 1;
            }
        }
    }
    assert!(seen >= 4, "{seen} curves");
}

#[test]
fn runs_with_clocks_of_their_own_are_tables_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = read(&written(&small(), folder.path())).expect("a log");
    assert_eq!(log.tables.len(), 2, "{log:?}");
    let clocks: Vec<&str> = log.tables.iter().map(|t| t.columns[0].name.as_str()).collect();
    assert_eq!(clocks, ["time", "time of fit.csv (fit)/force_1_n/before"]);
    assert_eq!(log.tables[0].columns[0].values[0], 0.5);
    assert_eq!(column(&log, "fit.csv (fit)/motor_angle_rad/measured").0.values[30], 3.0);
    // The summary is no scalar, and nothing is said of it.
    assert!(log.notes.is_empty(), "{:?}", log.notes);
}

#[test]
fn a_recording_that_was_cut_is_read_as_far_as_it_goes() {
    let folder = tempfile::tempdir().expect("a folder");
    let bytes = std::fs::read(written(&small(), folder.path())).expect("bytes");
    let whole = parse(Path::new("r.rrd"), bytes.clone()).expect("a log");
    let columns = |log: &Log| log.tables.iter().map(|t| t.columns.len()).sum::<usize>();
    let mut parts = 0;
    for length in (0..bytes.len()).step_by(97) {
        match parse(Path::new("r.rrd"), bytes[..length].to_vec()) {
            Ok(log) => {
                parts += 1;
                assert!(columns(&log) <= columns(&whole));
            }
            Err(error) => {
                let said = error.to_string();
                assert!(said.starts_with("r.rrd: ") && !said.contains('\n'), "{said}");
            }
        }
    }
    assert!(parts > 0, "no part was read");
    let most = parse(Path::new("r.rrd"), bytes[..bytes.len() * 2 / 3].to_vec());
    let said = most.map_or_else(|e| e.to_string(), |log| log.notes.join("; "));
    assert!(said.contains("ends within a message"), "{said}");
    // As a part of a campaign: entities by their paths.
    std::fs::write(folder.path().join("r.rrd"), &bytes).expect("a file");
    let text = "name = \"r\"\nbench = \"locked\"\nactuator = \"thor-linear\"\n\n[columns]\n\
        \"fit.csv (fit)/force_1_n/measured\" = \"force_1_n\"\n\
        \"fit.csv (fit)/motor_angle_rad/measured\" = { as = \"current_a\", scale = 0.1 }\n\n\
        [[run]]\nfile = \"r.rrd\"\nrole = \"fit\"\n";
    std::fs::write(folder.path().join("campaign.toml"), text).expect("a file");
    let campaign = Campaign::read(folder.path()).expect("a campaign");
    let record = &campaign.runs[0].record;
    assert_eq!(record.len(), 40);
    assert_eq!(record.output("force_1_n").expect("a force")[10], 2.0f64.sin());
    if let Ok(file) = std::env::var("WRITE_SMALL_RRD") {
        std::fs::write(file, &bytes).expect("a file");
    }
}
