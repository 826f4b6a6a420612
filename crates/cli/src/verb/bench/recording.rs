//! The recording of a run on a bench: its channels as time series.

use std::path::Path;

use sealegs::model::{Model, Signal, Unit};
use sealegs::recorder::recording::{Document, Frame, Level, Output, RecordingWriter, Scene, SeriesGroup};

use super::BenchRun;

/// Writes all channels into a recording at `path`.
///
/// # Errors
///
/// If the disk does not take it.
pub fn write(done: &BenchRun, path: &Path) -> anyhow::Result<()> {
    let signals: Vec<&Signal> = done.record.inputs.iter().chain(&done.outputs).collect();
    let series = signals
        .iter()
        .enumerate()
        .map(|(i, s)| SeriesGroup {
            name: s.channel.clone(),
            title: s.channel.replace('_', " "),
            unit: Unit::symbol_of(&s.channel).to_owned(),
            tab: if i == 0 || s.channel.starts_with("force") || s.channel.ends_with("_nm") {
                "Command and forces".to_owned()
            } else {
                "Motion".to_owned()
            },
            members: vec![s.channel.clone()],
        })
        .collect();
    let scene = Scene {
        name: done.model.name(),
        series,
        documents: vec![Document {
            name: "Actuator".to_owned(),
            text: done.model.spec().to_toml(),
            markdown: false,
        }],
        ..Scene::default()
    };
    let mut writer = RecordingWriter::create(&Output::File(path.to_owned()), &scene)?;
    for (i, &time_s) in done.record.time_s.iter().enumerate() {
        if writer.due(time_s).scalars {
            let scalars = signals.iter().map(|s| s.values[i]).collect();
            writer.frame(&Frame { time_s, scalars, poses: None })?;
        }
    }
    let last = done.record.time_s.last().copied().unwrap_or(0.0);
    for event in &done.prediction.events {
        writer.event(last, Level::Warning, event.clone())?;
    }
    writer.finish()?;
    Ok(())
}
