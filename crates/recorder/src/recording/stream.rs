//! Messages of a recording, written one after the other into a file or into a viewer's standard input.

use super::entities::refused;
use super::rerun::{
    AsComponents, BlueprintActivationCommand, Chunk, EntityPath, LogMsg, RecordingInfo, RowId,
    SerializedComponentBatch, SerializedComponentColumn, SetStoreInfo, StoreId, StoreInfo, StoreKind,
    StoreSource, TimeColumn, TimePoint, Timestamp,
};
use crate::RecorderError;
use re_log_encoding::{Encoder, EncodingOptions};
use std::io::Write;

/// A recording that is being written. Each message is written whole, so that what a killed program leaves can be read.
pub(super) struct Stream {
    recording: StoreId,
    encoder: Encoder<Box<dyn Write + Send>>,
}

impl std::fmt::Debug for Stream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stream").field("recording", &self.recording).finish_non_exhaustive()
    }
}

impl Stream {
    /// Begins a recording of this application, with a name that the viewer shows.
    pub(super) fn begin(
        sink: Box<dyn Write + Send>,
        application: &'static str,
        name: &str,
    ) -> Result<Self, RecorderError> {
        let version = re_build_info::CrateVersion::LOCAL;
        let encoder =
            Encoder::new_eager(version, EncodingOptions::PROTOBUF_COMPRESSED, sink).map_err(refused)?;
        let recording = StoreId::random(StoreKind::Recording, application);
        let mut stream = Self { recording: recording.clone(), encoder };
        stream.write(&store(recording))?;
        let info = RecordingInfo::new().with_start_time(Timestamp::now()).with_name(name);
        stream.log_static(EntityPath::properties(), &info)?;
        Ok(stream)
    }

    /// Writes what holds at all times.
    pub(super) fn log_static(
        &mut self,
        path: impl Into<EntityPath>,
        what: &impl AsComponents,
    ) -> Result<(), RecorderError> {
        let message = row(&self.recording, path, TimePoint::STATIC, what.as_serialized_batches())?;
        self.write(&message)
    }

    /// Writes columns with one row for each time.
    pub(super) fn send_columns(
        &mut self,
        path: impl Into<EntityPath>,
        time: TimeColumn,
        columns: impl IntoIterator<Item = SerializedComponentColumn>,
    ) -> Result<(), RecorderError> {
        let timelines = std::iter::once((*time.timeline().name(), time)).collect();
        let components = columns.into_iter().collect();
        let chunk = Chunk::from_auto_row_ids(re_chunk::ChunkId::new(), path.into(), timelines, components)
            .map_err(refused)?;
        let message = message(&self.recording, &chunk)?;
        self.write(&message)
    }

    /// Writes a layout of the viewer's window and makes it the active one.
    pub(super) fn send_layout(&mut self, layout: &Layout) -> Result<(), RecorderError> {
        self.write(&store(layout.store.clone()))?;
        for message in &layout.messages {
            self.write(message)?;
        }
        self.write(&BlueprintActivationCommand::make_active(layout.store.clone()).into())
    }

    /// A layout for this recording, still empty.
    pub(super) fn layout(&self) -> Layout {
        let application = self.recording.application_id().clone();
        Layout { store: StoreId::random(StoreKind::Blueprint, application), messages: Vec::new() }
    }

    /// Writes the footer, by which a reader knows that the file is whole.
    pub(super) fn finish(mut self) -> Result<(), RecorderError> {
        self.encoder.finish().map_err(refused)?;
        self.encoder.flush_blocking().map_err(refused)
    }

    fn write(&mut self, message: &LogMsg) -> Result<(), RecorderError> {
        self.encoder.append(message).map(|_| ()).map_err(refused)
    }
}

/// The messages of a layout.
pub(super) struct Layout {
    store: StoreId,
    messages: Vec<LogMsg>,
}

impl Layout {
    /// Adds an element of the layout.
    pub(super) fn log(
        &mut self,
        path: impl Into<EntityPath>,
        batches: Vec<SerializedComponentBatch>,
    ) -> Result<(), RecorderError> {
        let time = TimePoint::default().with(re_chunk::Timeline::new_sequence("blueprint"), 0);
        self.messages.push(row(&self.store, path, time, batches)?);
        Ok(())
    }
}

/// The message with which a recording or a layout begins.
fn store(id: StoreId) -> LogMsg {
    let info = StoreInfo::new(id, StoreSource::Other("sealegs".to_owned()));
    SetStoreInfo { row_id: *RowId::new(), info }.into()
}

/// A message with a single row.
fn row(
    store: &StoreId,
    path: impl Into<EntityPath>,
    time: TimePoint,
    batches: Vec<SerializedComponentBatch>,
) -> Result<LogMsg, RecorderError> {
    let chunk =
        Chunk::builder(path).with_serialized_batches(RowId::new(), time, batches).build().map_err(refused)?;
    message(store, &chunk)
}

fn message(store: &StoreId, chunk: &Chunk) -> Result<LogMsg, RecorderError> {
    Ok(LogMsg::ArrowMsg(store.clone(), chunk.to_arrow_msg().map_err(refused)?))
}
