//! Bags of ROS 2 in SQLite: topics with messages in CDR.

use crate::LogError;
use crate::ros::Schema;
use crate::sqlite::{Database, Value};
use crate::table::Log;
use crate::topics::{Encoding, Topics};
use std::collections::HashMap;
use std::path::Path;

/// Reads the bytes of a `.db3` file.
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<Log, LogError> {
    let mut beside = path.as_os_str().to_owned();
    beside.push("-wal");
    if std::fs::metadata(&beside).is_ok_and(|m| m.len() > 0) {
        let problem = "has changes in the file '-wal' beside it; let sqlite3 open and close it once";
        return Err(LogError::whole(path, problem));
    }
    topics(bytes)
        .map(|topics| topics.into_log("ROS 2 bag"))
        .map_err(|problem| LogError::whole(path, format!("is no readable ROS 2 bag: {problem}")))
}

fn topics(bytes: &[u8]) -> Result<Topics, String> {
    let database = Database::open(bytes)?;
    let missing = |name: &str| format!("it has no table '{name}'");
    let definitions = definitions(&database)?;
    let table = database.table("topics")?.ok_or_else(|| missing("topics"))?;
    let [name, kind, format] = ["name", "type", "serialization_format"].map(|c| table.column(c));
    let (name, kind, format) = (name?, kind?, format?);
    let mut topics = Topics::of_file(bytes.len());
    let mut by_id: HashMap<i64, usize> = HashMap::new();
    database.rows(&table, &mut |id, row| {
        let text = |at: usize| row.get(at).and_then(Value::text).unwrap_or_default();
        let kind = text(kind);
        let encoding = match text(format) {
            "cdr" => Schema::new(kind, definitions.get(kind).map_or("", String::as_str))
                .map_or_else(Encoding::Unread, |s| Encoding::Ros(Box::new(s))),
            other => Encoding::Unread(format!("its messages are in '{other}'; CDR is read")),
        };
        by_id.insert(id, topics.add(text(name), encoding));
        Ok(())
    })?;
    let table = database.table("messages")?.ok_or_else(|| missing("messages"))?;
    let [topic, stamp, data] = ["topic_id", "timestamp", "data"].map(|c| table.column(c));
    let (topic, stamp, data) = (topic?, stamp?, data?);
    database.rows(&table, &mut |number, row| {
        let integer = |at: usize| row.get(at).and_then(Value::integer);
        let (Some(topic), Some(stamp), Some(Value::Blob(data))) =
            (integer(topic), integer(stamp), row.get(data))
        else {
            return Err(format!("message {number} is broken"));
        };
        let topic = by_id.get(&topic).ok_or_else(|| format!("message {number} has an unknown topic"))?;
        topics.message(*topic, i128::from(stamp), data)
    })?;
    Ok(topics)
}

/// Definitions of message types, which recorders since 2023 store.
fn definitions(database: &Database) -> Result<HashMap<String, String>, String> {
    let mut definitions = HashMap::new();
    let Some(table) = database.table("message_definitions")? else { return Ok(definitions) };
    let (kind, text) = (table.column("topic_type")?, table.column("encoded_message_definition")?);
    let encoding = table.column("encoding")?;
    database.rows(&table, &mut |_, row| {
        let said = |at: usize| row.get(at).and_then(Value::text);
        if let (Some(kind), Some("ros2msg"), Some(text)) = (said(kind), said(encoding), said(text)) {
            definitions.insert(kind.to_owned(), text.to_owned());
        }
        Ok(())
    })?;
    Ok(definitions)
}
