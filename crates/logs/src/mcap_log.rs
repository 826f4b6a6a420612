//! MCAP: topics with messages in CDR (ROS 2) or JSON.

use crate::LogError;
use crate::fence::fenced;
use crate::ros::Schema;
use crate::table::Log;
use crate::topics::{Encoding, Topics};
use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::HashMap;
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

fn decode(path: &Path, mut bytes: &[u8]) -> Result<Log, LogError> {
    let mut recording = Recording {
        topics: Topics::of_file(bytes.len()),
        schemas: HashMap::new(),
        channels: HashMap::new(),
        messages: 0,
    };
    let options =
        LinearReaderOptions::default().with_validate_chunk_crcs(true).with_record_length_limit(LONGEST);
    let mut reader = LinearReader::new_with_options(options);
    let mut cut = None;
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let piece = wanted.min(PIECE).min(bytes.len());
                let (now, later) = bytes.split_at(piece);
                reader.insert(piece).copy_from_slice(now);
                reader.notify_read(piece);
                bytes = later;
            }
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
        if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(());
        }
        match mcap::parse_record(opcode, data).map_err(|e| format!("a record cannot be read: {e}"))? {
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
