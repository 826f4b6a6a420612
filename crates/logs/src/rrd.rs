//! Recordings of Rerun: the scalars of every entity over one timeline, each a column under the entity's path.
//!
//! Of the timelines of an entity one that holds time is taken (the logger's own, `log_time`, only where there is no
//! other), else one that counts. Entities with the same stamps are one table. Several scalars in a row become columns of
//! their own, under the names that the recording gives its lines, or numbered.
//!
//! The messages are taken apart here, and not by the library's decoder, which makes room for what a length claims.

use crate::LogError;
use crate::budget::{Budget, MOST_ARRAY, MOST_COLUMNS, MOST_INFLATED};
use crate::fence::fenced;
use crate::table::{Column, Log, Table};
use re_chunk::external::arrow::buffer::Buffer;
use re_chunk::external::arrow::ipc::reader::StreamDecoder;
use re_chunk::external::re_log_types;
use re_chunk::{Chunk, ComponentIdentifier, TimelineName};
use re_log_encoding::ToTransport;
use re_log_encoding::external::lz4_flex;
use re_log_encoding::rrd::{Compression, Decodable, MessageHeader, MessageKind, StreamFooter, StreamHeader};
use re_log_types::TimeType;
use std::collections::BTreeMap;
use std::path::Path;

/// What a recording begins with, behind which stands the number of its framing.
pub(crate) const MAGIC: &[u8] = b"RRF";

/// The message of a chunk as it stands in a file.
type Packed = <re_log_types::ArrowMsg as ToTransport>::Output;

/// The only encoding of chunks, Arrow's interprocess format, by its number.
const ARROW_IPC: i32 = 1;

/// Stores that hold how a viewer is laid out, by their number.
const BLUEPRINT: i32 = 2;

/// The type of a scalar, whatever archetype it belongs to.
const SCALAR: &str = "rerun.components.Scalar";

/// The component that names the lines of an entity's scalars.
const LINE_NAMES: &str = "SeriesLines:names";

/// The time at which the logger was called.
const LOG_TIME: &str = "log_time";

/// The number of the logger's call.
const LOG_TICK: &str = "log_tick";

/// Greatest ratio of plain to packed bytes that LZ4 can reach.
const MOST_PACKED: u64 = 255;

/// Reads the bytes of a recording.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    fenced(|| decode(bytes))
        .unwrap_or_else(|| {
            Err("is no readable recording of Rerun: its parts contradict each other".to_owned())
        })
        .map_err(|problem| LogError::whole(path, problem))
}

fn decode(bytes: &[u8]) -> Result<Log, String> {
    if bytes.is_empty() {
        return Err("is empty".to_owned());
    }
    let mut recording =
        Recording { entities: BTreeMap::new(), budget: Budget::of_file(bytes.len()), chunks: 0 };
    let mut log = Log { format: "Rerun", ..Log::default() };
    let mut rest = bytes;
    begin(&mut rest)?;
    loop {
        // A recorder that was killed leaves a part of a message.
        let Some((header, after)) = rest.split_at_checked(MessageHeader::ENCODED_SIZE_BYTES) else {
            if !rest.is_empty() || recording.chunks > 0 {
                log.notes.push(recording.cut());
            }
            break;
        };
        // Recordings that were put one behind the other.
        if header.starts_with(MAGIC) {
            begin(&mut rest)?;
            continue;
        }
        let header = MessageHeader::from_rrd_bytes(header).map_err(|e| recording.broken(&e))?;
        let payload = usize::try_from(header.len).ok().and_then(|length| after.split_at_checked(length));
        let Some((payload, after)) = payload else {
            log.notes.push(recording.cut());
            break;
        };
        rest = after;
        match header.kind {
            MessageKind::ArrowMsg => recording.message(payload)?,
            MessageKind::End => {
                rest = behind_footer(rest);
                if !rest.starts_with(MAGIC) {
                    break;
                }
            }
            MessageKind::SetStoreInfo | MessageKind::BlueprintActivationCommand => {}
        }
    }
    let whole = recording.chunks;
    recording.into_log(&mut log)?;
    if log.tables.is_empty() {
        let cut = if log.notes.iter().any(|n| n.starts_with("ends within")) {
            " and ends within a message"
        } else {
            ""
        };
        return Err(format!(
            "is a recording of Rerun without scalars over time ({whole} chunks were read){cut}"
        ));
    }
    Ok(log)
}

/// What stands behind a stream's footer, if there is one: a place in the file and its checksum, then what names it.
fn behind_footer(rest: &[u8]) -> &[u8] {
    const NAMED_AT: usize = StreamFooter::ENCODED_SIZE_BYTES - 8;
    match rest.split_at_checked(StreamFooter::ENCODED_SIZE_BYTES) {
        Some((footer, after)) if footer[NAMED_AT..].starts_with(&StreamFooter::RRD_IDENTIFIER) => after,
        _ => rest,
    }
}

/// Takes the header of a stream.
fn begin(rest: &mut &[u8]) -> Result<(), String> {
    let no = |e: &dyn std::fmt::Display| one_line(&format!("is no readable recording of Rerun: {e}"));
    let Some((header, after)) = rest.split_at_checked(StreamHeader::ENCODED_SIZE_BYTES) else {
        return Err(no(&"it ends within its first line"));
    };
    StreamHeader::from_rrd_bytes(header)
        .and_then(StreamHeader::to_version_and_options)
        .map_err(|e| no(&e))?;
    *rest = after;
    Ok(())
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What has been read of an entity.
#[derive(Default)]
struct Entity {
    /// Names of its lines.
    names: Vec<String>,
    /// Rows on each timeline.
    timelines: BTreeMap<TimelineName, Rows>,
    /// Whether some of its scalars stand on no timeline.
    timeless: bool,
}

/// Rows of scalars on a timeline.
struct Rows {
    holds: TimeType,
    rows: Vec<(i64, Vec<f64>)>,
}

/// What has been read so far.
struct Recording {
    entities: BTreeMap<String, Entity>,
    budget: Budget,
    chunks: u64,
}

impl Recording {
    fn broken(&self, problem: &dyn std::fmt::Display) -> String {
        one_line(&format!("is no readable recording of Rerun: {problem} (after {} chunks)", self.chunks))
    }

    fn cut(&self) -> String {
        format!("ends within a message or without its last one; its {} whole chunks are read", self.chunks)
    }

    /// Takes the message of a chunk.
    fn message(&mut self, payload: &[u8]) -> Result<(), String> {
        let packed = Packed::from_rrd_bytes(payload).map_err(|e| self.broken(&e))?;
        if packed.store_id.as_ref().is_some_and(|store| store.kind == BLUEPRINT) {
            return Ok(());
        }
        let chunk = unpacked(&packed).map_err(|problem| self.broken(&problem))?;
        self.chunks += 1;
        match chunk {
            Some(chunk) => self.take(&chunk),
            None => Ok(()),
        }
    }

    fn take(&mut self, chunk: &Chunk) -> Result<(), String> {
        let parts: Vec<_> = chunk.entity_path().iter().map(|part| part.unescaped_str().to_owned()).collect();
        let name = parts.join("/");
        let lines = ComponentIdentifier::from_static_str(LINE_NAMES);
        if let Some(names) = chunk.iter_slices::<String>(lines).last() {
            let names = names.iter().map(|name| name.as_str().to_owned()).collect();
            self.entities.entry(name.clone()).or_default().names = names;
        }
        let columns = chunk.components();
        let scalars = columns
            .component_descriptors()
            .find(|descriptor| descriptor.component_type.is_some_and(|kind| kind.as_str() == SCALAR));
        let Some(scalars) = scalars.map(|descriptor| descriptor.component) else { return Ok(()) };
        if self.entities.len() >= MOST_COLUMNS && !self.entities.contains_key(&name) {
            return Err(format!("has more than {MOST_COLUMNS} entities"));
        }
        let entity = self.entities.entry(name).or_default();
        entity.timeless |= chunk.is_static();
        for (timeline, times) in chunk.timelines() {
            let holds = times.timeline().typ();
            let rows = entity.timelines.entry(*timeline).or_insert(Rows { holds, rows: Vec::new() });
            for (time, row) in times.times_raw().iter().zip(chunk.iter_slices::<f64>(scalars)) {
                if row.is_empty() || row.len() > MOST_ARRAY {
                    continue;
                }
                // Its stamp and the room of its list cost about four numbers.
                self.budget.take(row.len() + 4)?;
                rows.rows.push((*time, row.to_vec()));
            }
        }
        Ok(())
    }

    /// The tables of all entities, those with the same stamps together.
    fn into_log(self, log: &mut Log) -> Result<(), String> {
        let mut tables: Vec<(String, Vec<i64>, Table)> = Vec::new();
        let mut counted: Vec<String> = Vec::new();
        let mut timeless = 0;
        let origin = self.origin();
        let mut budget = self.budget;
        for (name, mut entity) in self.entities {
            timeless += usize::from(entity.timeless && entity.timelines.is_empty());
            let Some(timeline) = entity.best() else { continue };
            let Some(Rows { holds, mut rows }) = entity.timelines.remove(&timeline) else { continue };
            rows.sort_by_key(|(time, _)| *time);
            let before = rows.len();
            // Of what was logged twice for one instant the last holds.
            rows.reverse();
            rows.dedup_by_key(|(time, _)| *time);
            rows.reverse();
            if rows.len() < before {
                log.notes.push(format!(
                    "'{name}': {} values for one instant; the last holds",
                    before - rows.len()
                ));
            }
            if rows.is_empty() {
                continue;
            }
            let times: Vec<i64> = rows.iter().map(|(time, _)| *time).collect();
            let known =
                tables.iter().position(|(of, stamps, _)| *of == timeline.as_str() && *stamps == times);
            let index = match known {
                Some(index) => index,
                None => {
                    budget.take(rows.len())?;
                    let table = begun(&timeline, holds, &times, origin, &name, tables.is_empty());
                    if holds == TimeType::Sequence && !counted.iter().any(|c| *c == timeline.as_str()) {
                        counted.push(timeline.as_str().to_owned());
                    }
                    tables.push((timeline.as_str().to_owned(), times, table));
                    tables.len() - 1
                }
            };
            let table = &mut tables[index].2;
            let width = rows.iter().map(|(_, row)| row.len()).max().unwrap_or(0);
            for i in 0..width {
                if table.columns.len() >= MOST_COLUMNS {
                    return Err(format!("has more than {MOST_COLUMNS} columns"));
                }
                budget.take(rows.len())?;
                let own = if width == 1 { name.clone() } else { member(&name, &entity.names, i) };
                let values = rows.iter().map(|(_, row)| row.get(i).copied().unwrap_or(f64::NAN)).collect();
                if table.columns.iter().all(|c| c.name != own) {
                    table.columns.push(Column::of(own, values));
                }
            }
        }
        for timeline in counted {
            log.notes.push(format!(
                "'{timeline}' counts and holds no time: map it onto time_s, with the seconds of one count as its scale"
            ));
        }
        if timeless > 0 {
            log.notes.push(format!("{timeless} entities have scalars without a time; they are left out"));
        }
        log.tables.extend(tables.into_iter().map(|(.., table)| table));
        Ok(())
    }

    /// Whole seconds of the first stamp since 1970, from which all of them are told.
    fn origin(&self) -> i64 {
        let stamps = self.entities.values().flat_map(|e| e.timelines.values());
        let stamps = stamps.filter(|rows| rows.holds == TimeType::TimestampNs);
        stamps
            .flat_map(|rows| rows.rows.first())
            .map(|(time, _)| time.div_euclid(NANOSECONDS))
            .min()
            .unwrap_or(0)
    }
}

/// Nanoseconds in a second.
const NANOSECONDS: i64 = 1_000_000_000;

impl Entity {
    /// The timeline that tells most of when things happened.
    fn best(&self) -> Option<TimelineName> {
        let rank = |name: &TimelineName, rows: &Rows| match (rows.holds, name.as_str()) {
            (TimeType::Sequence, LOG_TICK) => 3,
            (TimeType::Sequence, _) => 2,
            (_, LOG_TIME) => 1,
            _ => 0,
        };
        let timelines = self.timelines.iter().filter(|(_, rows)| !rows.rows.is_empty());
        let best = timelines.min_by_key(|(name, rows)| {
            (rank(name, rows), std::cmp::Reverse(rows.rows.len()), name.as_str().to_owned())
        });
        best.map(|(name, _)| *name)
    }
}

/// A table with its stamps alone; of several each names its time after its first entity.
fn begun(
    timeline: &TimelineName,
    holds: TimeType,
    times: &[i64],
    origin: i64,
    entity: &str,
    first: bool,
) -> Table {
    let name =
        if first { timeline.as_str().to_owned() } else { format!("{} of {entity}", timeline.as_str()) };
    let from = if holds == TimeType::TimestampNs { origin } else { 0 };
    let seconds = |time: i64| {
        let whole = time.div_euclid(NANOSECONDS).wrapping_sub(from) as f64;
        // One division of whole numbers where they are exact, so that a written stamp reads back to the last bit.
        match time
            .checked_sub(from.wrapping_mul(NANOSECONDS))
            .filter(|t| t.unsigned_abs() <= crate::table::EXACT)
        {
            Some(exact) => exact as f64 / NANOSECONDS as f64,
            None => whole + time.rem_euclid(NANOSECONDS) as f64 / NANOSECONDS as f64,
        }
    };
    let counts = holds == TimeType::Sequence;
    let values = times.iter().map(|&time| if counts { time as f64 } else { seconds(time) }).collect();
    let column = Column { origin: from, ..Column::of(name, values) };
    Table { columns: vec![column], clock: (!counts).then_some(0), ..Table::default() }
}

/// The name of one of several scalars in a row.
fn member(entity: &str, names: &[String], index: usize) -> String {
    match names.get(index).filter(|name| !name.is_empty()) {
        Some(name) => format!("{entity}/{name}"),
        None => format!("{entity}[{index}]"),
    }
}

/// The chunk of a message, none if it is empty, with no more room than the file's own bytes can fill.
fn unpacked(packed: &Packed) -> Result<Option<Chunk>, String> {
    if packed.encoding != ARROW_IPC {
        return Err("a chunk is in another encoding than Arrow's".to_owned());
    }
    let plain: Buffer = match Compression::from(packed.compression()) {
        Compression::Off => Buffer::from(packed.payload.to_vec()),
        Compression::LZ4 => {
            let size = packed.uncompressed_size;
            let most = MOST_INFLATED.min((packed.payload.len() as u64 + 16).saturating_mul(MOST_PACKED));
            if size > most {
                return Err(format!("a chunk of {size} bytes is longer than {most}"));
            }
            let mut plain = vec![0; size as usize];
            let length = lz4_flex::block::decompress_into(&packed.payload, &mut plain)
                .map_err(|e| format!("a chunk cannot be unpacked: {e}"))?;
            plain.truncate(length);
            Buffer::from(plain)
        }
    };
    let mut decoder = StreamDecoder::new();
    let mut rest = plain;
    let batch = decoder.decode(&mut rest).map_err(|e| format!("a chunk cannot be read: {e}"))?;
    let Some(batch) = batch else { return Err("a chunk ends before its rows".to_owned()) };
    if batch.num_rows() == 0 {
        return Ok(None);
    }
    Chunk::from_chunk_record_batch(&batch).map(Some).map_err(|e| format!("a chunk cannot be read: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use re_chunk::{ChunkId, TimeColumn};
    use re_log_encoding::{Encoder, EncodingOptions};
    use re_log_types::{LogMsg, StoreId, StoreKind};
    use re_sdk_types::archetypes::Scalars;

    /// A recording with an entity of two scalars in each row, on these timelines.
    fn recording(entity: &str, timelines: Vec<TimeColumn>) -> Vec<u8> {
        let rows = timelines[0].num_rows();
        let values: Vec<f64> = (0..2 * rows).map(|i| i as f64).collect();
        let columns = Scalars::new(values).columns(std::iter::repeat_n(2, rows)).unwrap().collect();
        let timelines = timelines.into_iter().map(|t| (*t.timeline().name(), t)).collect();
        let chunk = Chunk::from_auto_row_ids(ChunkId::new(), entity.into(), timelines, columns).unwrap();
        let store = StoreId::random(StoreKind::Recording, "test");
        let mut bytes = Vec::new();
        let options = EncodingOptions::PROTOBUF_COMPRESSED;
        let version = re_build_info::CrateVersion::LOCAL;
        let mut encoder = Encoder::new_eager(version, options, &mut bytes).unwrap();
        encoder.append(&LogMsg::ArrowMsg(store, chunk.to_arrow_msg().unwrap())).unwrap();
        encoder.finish().unwrap();
        drop(encoder);
        bytes
    }

    fn names(log: &Log) -> Vec<&str> {
        log.tables.iter().flat_map(|t| &t.columns).map(|c| c.name.as_str()).collect()
    }

    #[test]
    fn stamps_of_the_rig_come_before_the_logger_s() {
        let start = 1_700_000_000 * NANOSECONDS + 250_000_000;
        let stamps: Vec<i64> = (0..3).map(|i| start + i * 1_000_000).collect();
        let bytes = recording(
            "/knee/force",
            vec![
                TimeColumn::new_timestamp_nanos_since_epoch(LOG_TIME, stamps.iter().map(|t| t + 7_000_000)),
                TimeColumn::new_sequence("frame", 0..3),
                TimeColumn::new_timestamp_nanos_since_epoch("rig", stamps),
            ],
        );
        let log = decode(&bytes).unwrap();
        assert_eq!(names(&log), ["rig", "knee/force[0]", "knee/force[1]"]);
        let time = &log.tables[0].columns[0];
        assert_eq!((time.origin, time.values.as_slice()), (1_700_000_000, &[0.25, 0.251, 0.252][..]));
        assert_eq!(log.tables[0].columns[2].values, [1.0, 3.0, 5.0]);
        assert_eq!(log.tables[0].clock, Some(0));
        assert!(log.notes.is_empty(), "{:?}", log.notes);
    }

    #[test]
    fn a_timeline_that_counts_is_no_clock_and_says_so() {
        // Out of order, and one row twice: the later one holds.
        let bytes = recording("knee", vec![TimeColumn::new_sequence("frame", [2, 0, 1, 1])]);
        let log = decode(&bytes).unwrap();
        assert_eq!(names(&log), ["frame", "knee[0]", "knee[1]"]);
        assert_eq!(log.tables[0].columns[0].values, [0.0, 1.0, 2.0]);
        assert_eq!(log.tables[0].columns[1].values, [2.0, 6.0, 0.0]);
        assert_eq!(log.tables[0].clock, None);
        let notes = log.notes.join("; ");
        assert!(notes.contains("'frame' counts") && notes.contains("the last holds"), "{notes}");
    }

    #[test]
    fn recordings_one_behind_the_other_are_one_log() {
        let times = || vec![TimeColumn::new_duration_nanos("t", [0, 1_000_000])];
        let log = decode(&[recording("a", times()), recording("b", times())].concat()).unwrap();
        assert_eq!(names(&log), ["t", "a[0]", "a[1]", "b[0]", "b[1]"]);
    }

    #[test]
    fn what_a_chunk_claims_of_its_size_is_not_believed() {
        let bytes = recording("a", vec![TimeColumn::new_duration_nanos("t", [0, 1_000_000])]);
        let header = StreamHeader::ENCODED_SIZE_BYTES;
        let message = &bytes[header + MessageHeader::ENCODED_SIZE_BYTES..];
        let length =
            MessageHeader::from_rrd_bytes(&bytes[header..][..MessageHeader::ENCODED_SIZE_BYTES]).unwrap().len;
        let packed = Packed::from_rrd_bytes(&message[..length as usize]).unwrap();
        assert!(unpacked(&packed).is_ok());
        for claimed in [1 << 30, u64::MAX] {
            let error =
                unpacked(&Packed { uncompressed_size: claimed, ..packed.clone() }).map(|_| ()).unwrap_err();
            assert!(error.contains("is longer than"), "{error}");
        }
        // The same of a message, and of Arrow's own parts.
        let mut long = bytes.clone();
        long[header + 8..header + 16].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(decode(&long).unwrap_err().contains("ends within a message"));
        let size = packed.uncompressed_size as usize;
        let plain = lz4_flex::block::decompress(&packed.payload, size).unwrap();
        for at in (0..plain.len()).step_by(4) {
            let mut damaged = plain.clone();
            damaged[at..(at + 4).min(size)].fill(0x7f);
            let packed = Packed { payload: lz4_flex::block::compress(&damaged).into(), ..packed.clone() };
            let _ = fenced(|| unpacked(&packed));
        }
    }
}
