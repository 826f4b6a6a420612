//! Recordings are read back as they were written, and a cut one is known as cut.

use sealegs_recorder::RecorderError;
use sealegs_recorder::recording::{
    Arrow, ArrowState, Body, Color, ComparedChannel, ComparedRun, Comparison, Document, Ending, Frame,
    Geometry, Level, Output, Pose, Poses, RecordingContents, RecordingWriter, Rod, RodState, Scene,
    SeriesGroup, Shape,
};
use std::path::Path;

fn group(name: &str, members: &[&str]) -> SeriesGroup {
    SeriesGroup {
        name: name.into(),
        title: name.into(),
        unit: "N".into(),
        tab: "Forces".into(),
        members: members.iter().map(|m| (*m).to_owned()).collect(),
    }
}

fn scene() -> Scene {
    Scene {
        name: "test".into(),
        bodies: vec![Body {
            name: "shank / left".into(),
            shapes: vec![Shape::new(Geometry::Sphere { radius_m: 0.1 }, Color::GREY)],
        }],
        rods: vec![Rod { name: "knee".into(), radius_m: 0.01, full_scale_n: 2225.0 }],
        arrows: vec![Arrow { name: "ground".into(), color: Color::GREEN, length_m_per_n: 1e-3 }],
        series: vec![
            group("forces/spring", &["knee_spring_force_n", "hip_spring_force_n"]),
            group("deflection", &["knee_deflection_m"]),
        ],
        documents: vec![Document { name: "Scenario".into(), text: "a = 1".into(), markdown: false }],
        ..Scene::default()
    }
}

fn frame(step: usize) -> Frame {
    let time_s = step as f64 * 1e-3;
    let poses = step.is_multiple_of(10).then(|| Poses {
        bodies: vec![Pose { position_m: [time_s, 0.0, 1.0], ..Pose::default() }],
        rods: vec![RodState { from_m: [0.0; 3], to_m: [0.0, 0.0, 1.0], force_n: 100.0 }],
        arrows: vec![ArrowState { origin_m: [0.0; 3], force_n: [0.0, 0.0, 350.0] }],
    });
    Frame { time_s, scalars: vec![time_s.sin() * 1e3, f64::from(step as u32), 1e-7 * time_s], poses }
}

fn write(path: &Path, steps: usize) -> RecordingWriter {
    let mut writer = RecordingWriter::create(&Output::File(path.to_owned()), &scene()).unwrap();
    for step in 0..steps {
        if step == 1500 {
            writer.event(1.5, Level::Warning, "knee: <saturated> & \"hot\"").unwrap();
        }
        writer.frame(&frame(step)).unwrap();
    }
    writer
}

#[test]
fn what_was_written_is_read_back_exactly() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rrd.part");
    write(&path, 2345).finish().unwrap();

    let contents = RecordingContents::read(&path).unwrap();
    assert!(contents.is_complete());
    assert_eq!(contents.series.len(), 3);
    for (group, member, value) in [
        ("forces/spring", "knee_spring_force_n", 0),
        ("forces/spring", "hip_spring_force_n", 1),
        ("deflection", "knee_deflection_m", 2),
    ] {
        let series = contents.series(group, member).unwrap();
        assert_eq!(series.values.len(), 2345);
        for (step, (&time_s, &read)) in series.time_s.iter().zip(&series.values).enumerate() {
            let expected = frame(step);
            // The recording counts whole nanoseconds.
            assert!((time_s - expected.time_s).abs() < 1e-9);
            assert_eq!(read.to_bits(), expected.scalars[value].to_bits());
        }
    }
    assert_eq!(contents.events.len(), 1);
    assert_eq!(contents.events[0].text, "knee: <saturated> & \"hot\"");
    assert_eq!(contents.events[0].time_s, 1.5);
    for entity in ["world/bodies/shank / left", "world/actuators/knee", "world/forces/ground", "events"] {
        assert!(contents.entities.iter().any(|e| e == entity), "{entity} not in {:?}", contents.entities);
    }
}

#[test]
fn two_recordings_of_one_run_have_the_same_contents() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.rrd"), folder.path().join("b.rrd"));
    write(&a, 1200).finish().unwrap();
    write(&b, 1200).finish().unwrap();
    assert_eq!(RecordingContents::read(&a).unwrap(), RecordingContents::read(&b).unwrap());
}

#[test]
fn a_recording_cut_anywhere_is_never_taken_for_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.rrd");
    write(&path, 2345).finish().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let cut = folder.path().join("cut.rrd");
    let cuts = [1, 2, 11, 12, 13, 36, 37, bytes.len() / 4, bytes.len() / 2, bytes.len() * 3 / 4];
    for missing in cuts {
        std::fs::write(&cut, &bytes[..bytes.len() - missing]).unwrap();
        let contents = RecordingContents::read(&cut).unwrap();
        assert_eq!(contents.ending, Ending::CutShort, "{missing} bytes missing");
    }
    // What there is of it can still be looked at.
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let part = RecordingContents::read(&cut).unwrap();
    assert!(part.series.iter().any(|s| s.values.len() < 2345));
    assert!(part.series.iter().any(|s| s.values.len() >= 900));
    // Shorter than its own header: no recording at all.
    for no_recording in [&bytes[..5], b"time_s,current_a\n0,1\n0.001,1\n0.002,1\n".as_slice(), &[]] {
        std::fs::write(&cut, no_recording).unwrap();
        assert!(matches!(RecordingContents::read(&cut), Err(RecorderError::Unreadable { .. })));
    }
}

#[test]
fn a_writer_that_is_dropped_leaves_a_recording_known_as_cut_short() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dropped.rrd");
    drop(write(&path, 2345));
    assert_eq!(RecordingContents::read(&path).unwrap().ending, Ending::CutShort);
}

#[test]
fn a_stopped_run_is_kept_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stopped.rrd");
    write(&path, 1700).stop("shank is no longer finite at 1.7 s").unwrap();
    let contents = RecordingContents::read(&path).unwrap();
    assert_eq!(contents.ending, Ending::Stopped("shank is no longer finite at 1.7 s".into()));
    assert_eq!(contents.series("deflection", "knee_deflection_m").unwrap().values.len(), 1700);
    assert!(contents.events.last().unwrap().text.contains("no longer finite"));
}

#[test]
fn frames_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.rrd");
    let mut writer = RecordingWriter::create(&Output::File(path), &scene()).unwrap();
    let few = Frame { scalars: vec![1.0], ..frame(0) };
    assert!(matches!(writer.frame(&few), Err(RecorderError::Mismatch { expected: 3, found: 1, .. })));
    let bodiless = Frame { poses: Some(Poses::default()), ..frame(0) };
    assert!(matches!(writer.frame(&bodiless), Err(RecorderError::Mismatch { expected: 1, found: 0, .. })));
    writer.frame(&frame(5)).unwrap();
    assert!(matches!(writer.frame(&frame(5)), Err(RecorderError::TimeOrder { .. })));
    assert!(matches!(writer.frame(&frame(4)), Err(RecorderError::TimeOrder { .. })));
    let never = Frame { time_s: f64::NAN, ..frame(9) };
    assert!(matches!(writer.frame(&never), Err(RecorderError::TimeOrder { .. })));
}

#[test]
fn names_given_twice_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = Output::File(folder.path().join("twice.rrd"));
    let mut twice = scene();
    twice.bodies.push(twice.bodies[0].clone());
    assert!(matches!(RecordingWriter::create(&output, &twice), Err(RecorderError::Duplicate { .. })));
    let mut twice = scene();
    twice.series[0].members[1] = twice.series[0].members[0].clone();
    assert!(matches!(RecordingWriter::create(&output, &twice), Err(RecorderError::Duplicate { .. })));
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let output = Output::File(folder.path().join("no-such-folder").join("run.rrd"));
    let message = RecordingWriter::create(&output, &scene()).unwrap_err().to_string();
    assert!(message.contains("no-such-folder"), "{message}");
}

#[test]
fn a_comparison_holds_all_curves_and_their_residuals() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("comparison.rrd");
    let time_s: Vec<f64> = (0..5000).map(|i| f64::from(i) * 1e-3).collect();
    let measured: Vec<f64> = time_s.iter().map(|t| 100.0 * t.sin()).collect();
    let before: Vec<f64> = measured.iter().map(|m| 0.9 * m).collect();
    let after: Vec<f64> = measured.iter().map(|m| m - 0.5).collect();
    let channel = ComparedChannel {
        name: "force_1_n".into(),
        unit: "N".into(),
        measured: measured.clone(),
        before: Some(before),
        after: Some(after),
        noise: 0.0,
    };
    let run = ComparedRun { name: "run-01 (fit)".into(), time_s, channels: vec![channel] };
    let comparison =
        Comparison { name: "campaign".into(), runs: vec![run], summary_markdown: "# Backlash".into() };
    comparison.write(&Output::File(path.clone())).unwrap();

    let contents = RecordingContents::read(&path).unwrap();
    assert!(contents.is_complete());
    let series = |what: &str| {
        let group = format!("run-01 (fit)/force_1_n/{what}");
        contents.series(&group, &format!("{what} [N]")).unwrap()
    };
    assert_eq!(series("measured").values, measured);
    for (i, m) in measured.iter().enumerate() {
        assert!((series("residual_before").values[i] - 0.1 * m).abs() < 1e-12);
        assert!((series("residual_after").values[i] - 0.5).abs() < 1e-12);
    }

    // With the noise known the file is as fine as that allows to see: measured to the last bit, the others by their extremes.
    let whole = std::fs::metadata(&path).unwrap().len();
    let mut noisy = comparison.clone();
    noisy.runs[0].channels[0].noise = 0.5;
    noisy.write(&Output::File(path.clone())).unwrap();
    let contents = RecordingContents::read(&path).unwrap();
    let series = |what: &str| {
        contents.series(&format!("run-01 (fit)/force_1_n/{what}"), &format!("{what} [N]")).unwrap()
    };
    assert_eq!(series("measured").values, measured);
    let after = series("after");
    assert!(after.values.len() < 1000, "{}", after.values.len());
    let greatest = after.values.iter().copied().fold(0.0, f64::max);
    assert!((greatest - 99.5).abs() < 0.26, "{greatest}");
    let size = std::fs::metadata(&path).unwrap().len();
    assert!(2 * size < whole, "{size} of {whole} bytes");

    let mut short = comparison.clone();
    short.runs[0].channels[0].measured.pop();
    let output = Output::File(folder.path().join("short.rrd"));
    assert!(matches!(short.write(&output), Err(RecorderError::Mismatch { expected: 5000, found: 4999, .. })));
}
