//! Writes a run frame by frame into a file or to a viewer.

use super::cadence::{Cadence, Due};
use super::columns::Columns;
use super::entities::{self, refused};
use super::paths::{self, COMPLETE, DOCUMENTS, ENDING, EVENTS, TIMELINE, WORLD};
use super::stream::Stream;
use super::{Frame, Level, Scene, contents, layout, rerun, scene_view, viewer};
use crate::RecorderError;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Recordings are sent in pieces of this length, s: large enough to be small, small enough to be live.
const CHUNK_S: f64 = 1.0;

/// Where a recording goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Output {
    /// Into this file. Give a name beside the final one and rename it after
    /// [`RecordingWriter::finish`], so that a file of the final name is always whole.
    File(PathBuf),
    /// To an installed viewer: the one that runs, or a new one.
    Viewer,
}

/// Writes a run into a recording, or shows it live.
///
/// A writer that is dropped without [`RecordingWriter::finish`] or [`RecordingWriter::stop`] leaves a
/// recording that [`RecordingContents::read`](super::RecordingContents::read) reports as cut short.
#[derive(Debug)]
pub struct RecordingWriter {
    stream: Stream,
    file: Option<PathBuf>,
    scene: Scene,
    columns: Columns,
    last_time_s: Option<f64>,
    cadence: Cadence,
    laid_out: bool,
}

impl RecordingWriter {
    /// Opens the recording and writes what does not change.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Duplicate`] if two things of the scene have one name, [`RecorderError::Recorder`]
    /// if the file cannot be created, [`RecorderError::NoViewer`] if there is none to show it.
    pub fn create(output: &Output, scene: &Scene) -> Result<Self, RecorderError> {
        check_names(scene)?;
        let (mut stream, file) = open(output, "sealegs", &scene.name)?;
        entities::log_scene(&mut stream, scene)?;
        Ok(Self {
            stream,
            file,
            scene: scene.clone(),
            columns: Columns::new(scene),
            last_time_s: None,
            cadence: Cadence::default(),
            laid_out: false,
        })
    }

    /// What a frame at `time_s` should bring, so that scalars come at 1 kHz and poses at 100 Hz.
    #[must_use]
    pub fn due(&self, time_s: f64) -> Due {
        self.cadence.due(time_s)
    }

    /// Adds a frame.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Mismatch`] if it does not fit the scene, [`RecorderError::TimeOrder`] if it does
    /// not come after the one before, [`RecorderError::Recorder`] if the recorder refuses it.
    pub fn frame(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        self.check(frame)?;
        self.last_time_s = Some(frame.time_s);
        self.cadence
            .took(frame.time_s, Due { scalars: !frame.scalars.is_empty(), poses: frame.poses.is_some() });
        if !frame.scalars.is_empty() {
            self.columns.push_scalars(&self.scene, frame.time_s, &frame.scalars);
        }
        if let Some(poses) = &frame.poses {
            self.columns.push_poses(frame.time_s, poses.clone());
        }
        if self.columns.first_time_s().is_some_and(|first| frame.time_s - first >= CHUNK_S) {
            self.send()?;
        }
        Ok(())
    }

    /// Adds a line to the text log.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Recorder`] if the time is not finite.
    pub fn event(&mut self, time_s: f64, level: Level, text: impl Into<String>) -> Result<(), RecorderError> {
        if !time_s.is_finite() {
            return Err(refused(format!("an event at {time_s} s")));
        }
        self.columns.push_event(time_s, level, text.into());
        Ok(())
    }

    /// Writes what is left and ends the recording.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Recorder`] if the disk or the viewer did not take it all.
    pub fn finish(self) -> Result<(), RecorderError> {
        self.end(COMPLETE)
    }

    /// Ends a recording whose run was stopped before its end, and says why: it is readable, whole as a
    /// file, and known as stopped.
    ///
    /// # Errors
    ///
    /// As [`RecordingWriter::finish`].
    pub fn stop(mut self, reason: &str) -> Result<(), RecorderError> {
        let time_s = self.last_time_s.unwrap_or(0.0);
        self.event(time_s, Level::Error, format!("the run was stopped: {reason}"))?;
        self.end(&format!("stopped: {reason}"))
    }

    fn end(mut self, ending: &str) -> Result<(), RecorderError> {
        self.send()?;
        close(self.stream, self.file.as_deref(), ending)
    }

    fn send(&mut self) -> Result<(), RecorderError> {
        if !self.laid_out {
            // Only now the first poses are known, and with them where to look.
            let root = scene_view::layout(&self.scene, self.columns.poses());
            layout::send(&mut self.stream, TIMELINE, &root)?;
            self.laid_out = true;
        }
        self.columns.send(&mut self.stream, &self.scene)
    }

    fn check(&self, frame: &Frame) -> Result<(), RecorderError> {
        let time_s = frame.time_s;
        if !time_s.is_finite() || self.last_time_s.is_some_and(|last| time_s <= last) {
            let previous_s = self.last_time_s.unwrap_or(f64::NEG_INFINITY);
            return Err(RecorderError::TimeOrder { time_s, previous_s });
        }
        let fits = |what: &str, expected: usize, found: usize| {
            if expected == found {
                Ok(())
            } else {
                Err(RecorderError::Mismatch { what: format!("{what} at {time_s} s"), expected, found })
            }
        };
        if !frame.scalars.is_empty() {
            fits("scalars", self.scene.scalar_count(), frame.scalars.len())?;
        }
        if let Some(poses) = &frame.poses {
            fits("bodies", self.scene.bodies.len(), poses.bodies.len())?;
            fits("rods", self.scene.rods.len(), poses.rods.len())?;
            fits("arrows", self.scene.arrows.len(), poses.arrows.len())?;
        }
        Ok(())
    }
}

/// Opens a stream into a file or to a viewer.
pub(super) fn open(
    output: &Output,
    application: &'static str,
    name: &str,
) -> Result<(Stream, Option<PathBuf>), RecorderError> {
    let (sink, file): (Box<dyn std::io::Write + Send>, _) = match output {
        Output::File(path) => {
            let file = std::fs::File::create(path)
                .map_err(|source| RecorderError::File { path: path.clone(), source })?;
            (Box::new(file), Some(path.clone()))
        }
        Output::Viewer => (Box::new(viewer::pipe()?), None),
    };
    Ok((Stream::begin(sink, application, name)?, file))
}

/// Marks the end, closes the stream, and looks whether the file is whole.
pub(super) fn close(mut stream: Stream, file: Option<&Path>, ending: &str) -> Result<(), RecorderError> {
    stream.log_static(paths::path([ENDING]), &rerun::TextDocument::new(ending))?;
    stream.finish()?;
    match file {
        Some(path) if !contents::has_footer(path)? => {
            Err(refused(format!("{} could not be completed; is the disk full?", path.display())))
        }
        _ => Ok(()),
    }
}

fn check_names(scene: &Scene) -> Result<(), RecorderError> {
    let mut seen = BTreeSet::new();
    let bodies = scene.bodies.iter().map(|b| paths::path([WORLD, "bodies", &b.name]));
    let rods = scene.rods.iter().map(|r| paths::path([WORLD, "actuators", &r.name]));
    let arrows = scene.arrows.iter().map(|a| paths::path([WORLD, "forces", &a.name]));
    let documents = scene.documents.iter().map(|d| paths::path([DOCUMENTS, &d.name]));
    let series = scene.series.iter().map(|g| paths::group(&g.name));
    let ours = [paths::path([EVENTS]), paths::path([ENDING]), paths::path([WORLD])];
    for path in ours.into_iter().chain(bodies).chain(rods).chain(arrows).chain(documents).chain(series) {
        let text = path.to_string();
        if !seen.insert(path) {
            return Err(RecorderError::Duplicate { path: text });
        }
    }
    for group in &scene.series {
        let mut members = BTreeSet::new();
        for member in &group.members {
            if !members.insert(member) {
                return Err(RecorderError::Duplicate { path: format!("{}: {member}", group.name) });
            }
        }
    }
    Ok(())
}
