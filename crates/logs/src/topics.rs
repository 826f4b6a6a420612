//! Recordings of topics: every topic becomes a table with the time at which each message was logged.

use crate::budget::Budget;
use crate::json;
use crate::ros::{Schema, Stamps};
use crate::table::{Cell, Log, Rows};

/// The column of the time at which a message was logged.
const LOGGED: &str = "log_time_s";

/// How the messages of a topic are read.
pub(crate) enum Encoding {
    /// CDR of this type.
    Ros(Box<Schema>),
    Json,
    /// Not at all, for this reason.
    Unread(String),
}

/// A topic that is being read.
pub(crate) struct Topic {
    name: String,
    encoding: Encoding,
    rows: Rows,
    stamps: Stamps,
}

/// All topics of a recording.
pub(crate) struct Topics {
    topics: Vec<Topic>,
    budget: Budget,
    /// Whole seconds of the first message's time, of which all others are told from.
    origin: Option<i64>,
}

impl Topics {
    pub fn of_file(bytes: usize) -> Self {
        Self { topics: Vec::new(), budget: Budget::of_file(bytes), origin: None }
    }

    /// Whether a message has come.
    pub fn begun(&self) -> bool {
        self.origin.is_some()
    }

    /// Adds a topic; several publishers of one topic are one.
    pub fn add(&mut self, name: &str, encoding: Encoding) -> usize {
        if let Some(known) = self.topics.iter().position(|t| t.name == name) {
            return known;
        }
        let topic =
            Topic { name: name.to_owned(), encoding, rows: Rows::default(), stamps: Stamps::default() };
        self.topics.push(topic);
        self.topics.len() - 1
    }

    /// Takes a message, logged so many nanoseconds after the recorder's zero.
    ///
    /// A topic with a message that cannot be read is left out from there on.
    pub fn message(&mut self, topic: usize, logged_ns: i128, data: &[u8]) -> Result<(), String> {
        let seconds = logged_ns.div_euclid(1_000_000_000) as i64;
        let origin = *self.origin.get_or_insert(seconds);
        let Some(topic) = self.topics.get_mut(topic) else { return Ok(()) };
        topic.stamps.origin = origin;
        if matches!(topic.encoding, Encoding::Unread(_)) {
            return Ok(());
        }
        let since = seconds.wrapping_sub(origin) as f64 + 1e-9 * logged_ns.rem_euclid(1_000_000_000) as f64;
        topic.rows.put(LOGGED, &Cell::Number(since), &mut self.budget)?;
        let read = match &topic.encoding {
            Encoding::Ros(schema) => schema
                .decode(data, &mut topic.rows, &mut self.budget, &mut topic.stamps)
                .and_then(|()| topic.rows.end_row(&mut self.budget)),
            Encoding::Json => json::entry(data, &mut topic.rows, &mut self.budget),
            Encoding::Unread(_) => Ok(()),
        };
        if let Err(problem) = read {
            let number = topic.rows.rows() + 1;
            topic.encoding = Encoding::Unread(format!("message {number}: {problem}"));
            topic.rows = Rows::default();
        }
        Ok(())
    }

    pub fn into_log(self, format: &'static str) -> Log {
        let mut log = Log { format, ..Log::default() };
        let origin = self.origin.unwrap_or(0);
        for topic in self.topics {
            if let Encoding::Unread(why) = topic.encoding {
                log.notes.push(format!("topic '{}' is left out: {why}", topic.name));
                continue;
            }
            if topic.rows.too_many {
                log.notes.push(format!("topic '{}': its long arrays are left out", topic.name));
            }
            let Some(mut table) = topic.rows.into_table(topic.name.clone()) else {
                log.notes.push(format!("topic '{}' has no messages", topic.name));
                continue;
            };
            for column in &mut table.columns {
                if column.name == LOGGED || topic.stamps.columns.contains(&column.name) {
                    column.origin = origin;
                }
            }
            table.clock = table.columns.iter().position(|c| c.name == LOGGED);
            log.tables.push(table);
        }
        log
    }
}
