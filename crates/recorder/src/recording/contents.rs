//! Reads a recording back: decoded series, events, and whether the file is whole.

use super::paths::{self, COMPLETE, ENDING, EVENTS, TIMELINE};
use super::rerun::{self, Chunk, LogMsg};
use crate::RecorderError;
use re_log_encoding::DecoderApp;
use re_log_encoding::rrd::{Decodable as _, StreamFooter, StreamHeader};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// How a recording ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// The run was recorded to its end.
    Complete,
    /// The run was stopped early, for this reason; everything until then is there.
    Stopped(String),
    /// The writer was killed or the file was cut: what is there is a part of unknown size.
    CutShort,
}

/// One decoded series.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DecodedSeries {
    /// Group and member, for example `forces/spring/knee_spring_force_n`.
    pub name: String,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Values.
    pub values: Vec<f64>,
}

/// One decoded line of the text log.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedEvent {
    /// Time, s.
    pub time_s: f64,
    /// The text.
    pub text: String,
}

/// What is in a recording.
///
/// The bytes of two recordings of the same run differ (they hold random ids); their contents do not.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingContents {
    /// All series, sorted by name, each in the order of time.
    pub series: Vec<DecodedSeries>,
    /// The events in the order of time.
    pub events: Vec<DecodedEvent>,
    /// Names of all entities with data that changes with time, sorted.
    pub entities: Vec<String>,
    /// How it ends.
    pub ending: Ending,
}

impl RecordingContents {
    /// Reads a recording. A file that was cut short is read as far as it goes and says so in
    /// [`RecordingContents::ending`].
    ///
    /// # Errors
    ///
    /// [`RecorderError::File`] if it cannot be opened, [`RecorderError::Unreadable`] if it is no recording.
    pub fn read(path: &Path) -> Result<Self, RecorderError> {
        let whole = has_footer(path)?;
        let file = std::fs::File::open(path).map_err(|e| file_error(path, e))?;
        let messages =
            DecoderApp::decode_eager(std::io::BufReader::new(file)).map_err(|e| unreadable(path, e))?;
        let mut collected = Collected::default();
        for message in messages {
            match message {
                Ok(LogMsg::ArrowMsg(store, arrow)) if store.is_recording() => {
                    match Chunk::from_arrow_msg(&arrow) {
                        Ok(chunk) => collected.add(&chunk),
                        Err(e) if whole => return Err(unreadable(path, e)),
                        Err(_) => break,
                    }
                }
                Ok(_) => {}
                Err(e) if whole => return Err(unreadable(path, e)),
                Err(_) => break,
            }
        }
        Ok(collected.finish(whole))
    }

    /// The series of a group's member.
    #[must_use]
    pub fn series(&self, group: &str, member: &str) -> Option<&DecodedSeries> {
        let name = format!("{group}/{member}");
        self.series.iter().find(|s| s.name == name)
    }

    /// Whether the run was recorded to its end and the file is whole.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.ending == Ending::Complete
    }
}

/// What has been decoded so far; chunks may come in any order.
#[derive(Default)]
struct Collected {
    names: BTreeMap<String, Vec<String>>,
    rows: BTreeMap<String, Vec<(i64, Vec<f64>)>>,
    events: Vec<(i64, String)>,
    entities: std::collections::BTreeSet<String>,
    ending: Option<String>,
}

impl Collected {
    fn add(&mut self, chunk: &Chunk) {
        let entity = chunk.entity_path();
        let name = paths::name_of(entity);
        let texts = |descriptor: rerun::ComponentDescriptor| {
            chunk
                .iter_slices::<String>(descriptor.component)
                .map(|row| row.iter().map(|t| t.as_str().to_owned()).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        };
        if chunk.is_static() {
            if *entity == paths::path([ENDING]) {
                self.ending = texts(rerun::TextDocument::descriptor_text()).into_iter().flatten().next();
            }
            if let Some(row) = texts(rerun::SeriesLines::descriptor_names()).into_iter().next() {
                self.names.insert(name, row);
            }
            return;
        }
        let Some(times) = chunk.timelines().iter().find(|(n, _)| n.as_str() == TIMELINE).map(|(_, t)| t)
        else {
            return;
        };
        self.entities.insert(name.clone());
        if *entity == paths::path([EVENTS]) {
            let lines = texts(rerun::TextLog::descriptor_text()).into_iter().flatten();
            self.events.extend(times.times_raw().iter().copied().zip(lines));
        }
        let scalars = rerun::Scalars::descriptor_scalars();
        if chunk.components().contains_component(scalars.component) {
            let rows = self.rows.entry(name).or_default();
            for (time, row) in times.times_raw().iter().zip(chunk.iter_slices::<f64>(scalars.component)) {
                rows.push((*time, row.to_vec()));
            }
        }
    }

    fn finish(self, whole: bool) -> RecordingContents {
        let mut series = Vec::new();
        for (group, mut rows) in self.rows {
            rows.sort_by_key(|(time, _)| *time);
            let width = rows.iter().map(|(_, row)| row.len()).max().unwrap_or(0);
            let names = self.names.get(&group).cloned().unwrap_or_default();
            for i in 0..width {
                let member = names.get(i).cloned().unwrap_or_else(|| i.to_string());
                let present = || rows.iter().filter(|(_, row)| row.len() > i);
                series.push(DecodedSeries {
                    name: format!("{group}/{member}"),
                    time_s: present().map(|(time, _)| *time as f64 * 1e-9).collect(),
                    values: present().map(|(_, row)| row[i]).collect(),
                });
            }
        }
        series.sort_by(|a, b| a.name.cmp(&b.name));
        let mut events = self.events;
        events.sort_by_key(|(time, _)| *time);
        let ending = match self.ending {
            Some(text) if whole && text == COMPLETE => Ending::Complete,
            Some(text) if whole => {
                Ending::Stopped(text.strip_prefix("stopped: ").unwrap_or(&text).to_owned())
            }
            _ => Ending::CutShort,
        };
        RecordingContents {
            series,
            events: events
                .into_iter()
                .map(|(time, text)| DecodedEvent { time_s: time as f64 * 1e-9, text })
                .collect(),
            entities: self.entities.into_iter().collect(),
            ending,
        }
    }
}

fn file_error(path: &Path, source: std::io::Error) -> RecorderError {
    RecorderError::File { path: path.to_owned(), source }
}

fn unreadable(path: &Path, what: impl std::fmt::Display) -> RecorderError {
    RecorderError::Unreadable { path: path.to_owned(), what: what.to_string() }
}

/// Whether the file ends with a footer that belongs to it: only a writer that was closed leaves one.
pub(super) fn has_footer(path: &Path) -> Result<bool, RecorderError> {
    let mut file = std::fs::File::open(path).map_err(|e| file_error(path, e))?;
    let length = file.metadata().map_err(|e| file_error(path, e))?.len();
    let head = StreamHeader::ENCODED_SIZE_BYTES;
    let mut header = vec![0; head];
    if length < head as u64 {
        return Err(unreadable(path, "it is too short for a recording"));
    }
    file.read_exact(&mut header).map_err(|e| file_error(path, e))?;
    StreamHeader::from_rrd_bytes(&header).map_err(|e| unreadable(path, e))?;
    let tail = StreamFooter::ENCODED_SIZE_BYTES as u64;
    if length < tail {
        return Ok(false);
    }
    let mut read = |from: u64, count: u64| -> Result<Vec<u8>, RecorderError> {
        let mut bytes = vec![0; count as usize];
        file.seek(SeekFrom::Start(from))
            .and_then(|_| file.read_exact(&mut bytes))
            .map_err(|e| file_error(path, e))?;
        Ok(bytes)
    };
    let Ok(footer) = StreamFooter::from_rrd_bytes(&read(length - tail, tail)?) else {
        return Ok(false);
    };
    let Some(entry) = footer.entries.first() else {
        return Ok(false);
    };
    let span = &entry.rrd_footer_byte_span_from_start_excluding_header;
    if span.start.checked_add(span.len).is_none_or(|end| end > length) {
        return Ok(false);
    }
    let payload = read(span.start, span.len)?;
    Ok(StreamFooter::compute_crc(&payload) == entry.crc_excluding_header)
}
