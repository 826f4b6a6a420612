//! MCAP: topics with messages in CDR (ROS 2) or JSON.

use crate::LogError;
use crate::fence::fenced;
use crate::ros::Schema;
use crate::table::Log;
use crate::topics::{Encoding, Topics};
use mcap::McapError;
use mcap::read::ChunkReader;
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;
use std::path::Path;

/// What a file begins with.
pub(crate) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Longest record, packed or not.
const LONGEST: usize = 128 << 20;

/// Bytes that the reader is given at a time, whatever a header claims to come.
const PIECE: usize = 1 << 20;

/// Reads the bytes of an MCAP file, from beginning to end and without its index, which a recorder that was interrupted
/// does not write.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    if bytes.is_empty() {
        return Err(LogError::whole(path, "is empty"));
    }
    fenced(|| decode(path, bytes)).unwrap_or_else(|| {
        Err(LogError::whole(path, "is no readable MCAP file: its parts contradict each other"))
    })
}

/// Whether a chunk of a file is packed, by the chunks' headers alone: the last chunk may be cut off.
fn is_packed(bytes: &[u8]) -> bool {
    // Start, end, size and checksum of the chunk, before the length of its compression's name.
    const BEFORE_NAME: usize = 28;
    let mut rest = bytes.get(MAGIC.len()..).unwrap_or_default();
    while let Some((&[opcode, ref length @ ..], body)) = rest.split_first_chunk::<9>() {
        let name_length = body.get(BEFORE_NAME..BEFORE_NAME + 4);
        if opcode == op::CHUNK && name_length.is_some_and(|length| length != [0; 4]) {
            return true;
        }
        let length = usize::try_from(u64::from_le_bytes(*length)).ok();
        let Some(after) = length.and_then(|length| body.get(length..)) else { return false };
        rest = after;
    }
    false
}

/// The records of a chunk without their compression. The library's own way hangs on damaged frames whose end never
/// comes.
fn unpacked<'a>(header: &ChunkHeader, data: &'a [u8]) -> Result<Cow<'a, [u8]>, String> {
    let broken = |e: std::io::Error| format!("a chunk cannot be unpacked: {e}");
    let packed: Box<dyn Read + 'a> = match header.compression.as_str() {
        "" => return Ok(Cow::Borrowed(data)),
        "lz4" => Box::new(lz4::Decoder::new(data).map_err(broken)?),
        "zstd" => Box::new(zstd::Decoder::new(data).map_err(broken)?),
        other => return Err(format!("a chunk is packed by '{other}'; lz4 and zstd are read")),
    };
    let size = header.uncompressed_size;
    if size > LONGEST as u64 {
        return Err(format!("a chunk of {size} bytes is longer than {LONGEST}"));
    }
    let mut plain = Vec::new();
    packed.take(size + 1).read_to_end(&mut plain).map_err(broken)?;
    if plain.len() as u64 != size {
        return Err(format!("a chunk has not the {size} bytes that it should have"));
    }
    Ok(Cow::Owned(plain))
}

fn unreadable(error: McapError) -> String {
    format!("a record cannot be read: {error}")
}

fn options() -> LinearReaderOptions {
    LinearReaderOptions::default().with_validate_chunk_crcs(true).with_record_length_limit(LONGEST)
}

/// Gives a reader the next piece of what it wants; what is left.
fn fed<'a>(reader: &mut LinearReader, wanted: usize, bytes: &'a [u8]) -> &'a [u8] {
    let (now, later) = bytes.split_at(wanted.min(PIECE).min(bytes.len()));
    reader.insert(now.len()).copy_from_slice(now);
    reader.notify_read(now.len());
    later
}

fn decode(path: &Path, mut bytes: &[u8]) -> Result<Log, LogError> {
    let mut recording = Recording {
        topics: Topics::of_file(bytes.len()),
        schemas: HashMap::new(),
        channels: HashMap::new(),
        messages: 0,
    };
    // Packed chunks are unpacked here; of a plain one that was cut off the whole messages are read.
    let mut reader = LinearReader::new_with_options(options().with_emit_chunks(is_packed(bytes)));
    let mut cut = None;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => bytes = fed(&mut reader, wanted, bytes),
            Ok(LinearReadEvent::Record { opcode, data }) => {
                recording.record(opcode, data).map_err(|problem| {
                    let problem = format!("{problem} (after {} messages)", recording.messages);
                    LogError::whole(path, problem)
                })?;
            }
            // What a recorder that was interrupted leaves.
            Err(McapError::UnexpectedEof) if recording.topics.begun() => {
                cut =
                    Some(format!("ends within a record; its {} whole messages are read", recording.messages));
                break;
            }
            Err(error) => {
                let problem =
                    format!("is no readable MCAP file: {error} (after {} messages)", recording.messages);
                return Err(LogError::whole(path, problem));
            }
        }
    }
    let mut log = recording.topics.into_log("MCAP");
    log.notes.extend(cut);
    Ok(log)
}

/// What has been read so far.
struct Recording {
    topics: Topics,
    /// Name, encoding and text of message types by their number.
    schemas: HashMap<u16, (String, String, String)>,
    /// Topics by the number of their channel.
    channels: HashMap<u16, usize>,
    messages: u64,
}

impl Recording {
    fn record(&mut self, opcode: u8, data: &[u8]) -> Result<(), String> {
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | op::CHUNK) {
            return Ok(());
        }
        self.take(mcap::parse_record(opcode, data).map_err(unreadable)?)
    }

    fn take(&mut self, record: Record) -> Result<(), String> {
        match record {
            Record::Chunk { header, data } => {
                let plain = unpacked(&header, &data)?;
                let size = plain.len() as u64;
                let header = ChunkHeader {
                    compression: String::new(),
                    compressed_size: size,
                    uncompressed_size: size,
                    ..header
                };
                for record in ChunkReader::new(header, &plain).map_err(unreadable)? {
                    self.take(record.map_err(unreadable)?)?;
                }
            }
            Record::Schema { header, data } => {
                let text = String::from_utf8_lossy(&data).into_owned();
                self.schemas.insert(header.id, (header.name, header.encoding, text));
            }
            Record::Channel(channel) => {
                let encoding = self.encoding(&channel.message_encoding, channel.schema_id);
                let topic = self.topics.add(&channel.topic, encoding);
                self.channels.insert(channel.id, topic);
            }
            Record::Message { header, data } => {
                self.messages += 1;
                let topic = self.channels.get(&header.channel_id);
                let topic =
                    *topic.ok_or_else(|| format!("a message of unknown channel {}", header.channel_id))?;
                self.topics.message(topic, i128::from(header.log_time), &data)?;
            }
            _ => {}
        }
        Ok(())
    }

    fn encoding(&self, messages: &str, schema: u16) -> Encoding {
        match messages {
            "json" => Encoding::Json,
            "cdr" => match self.schemas.get(&schema) {
                Some((name, encoding, text)) if encoding == "ros2msg" || encoding.is_empty() => {
                    Schema::new(name, text).map_or_else(Encoding::Unread, |s| Encoding::Ros(Box::new(s)))
                }
                Some((name, encoding, _)) => Schema::new(name, "").map_or_else(
                    |_| Encoding::Unread(format!("{name} is defined in '{encoding}'; ros2msg is read")),
                    |s| Encoding::Ros(Box::new(s)),
                ),
                None => Encoding::Unread("its message type is not in the file".to_owned()),
            },
            other => {
                Encoding::Unread(format!("its messages are in '{other}'; CDR of ROS 2 and JSON are read"))
            }
        }
    }
}
