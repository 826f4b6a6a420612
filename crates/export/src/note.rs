//! What became of a part of the model in another format, in words.

use crate::text::told;
use sealegs_actuator::spec::SensorSpec;
use std::collections::BTreeMap;
use std::fmt;

/// What became of a part of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// The file holds it.
    Held,
    /// The file holds something near it.
    Approximate,
    /// Python beside the file adds it.
    Callback,
    /// Neither holds it.
    Lost,
}

impl Fate {
    /// The word in a listing.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Approximate => "approximate",
            Self::Callback => "callback",
            Self::Lost => "lost",
        }
    }
}

/// What became of one part of the model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// The effect's id, with its place on a leg, or the part in words.
    pub what: String,
    /// Its fate.
    pub fate: Fate,
    /// How, or why not.
    pub how: String,
}

impl Note {
    pub(crate) fn new(what: impl Into<String>, fate: Fate, how: impl Into<String>) -> Self {
        Self { what: what.into(), fate, how: how.into() }
    }

    pub(crate) fn held(what: impl Into<String>, how: impl Into<String>) -> Self {
        Self::new(what, Fate::Held, how)
    }

    pub(crate) fn near(what: impl Into<String>, how: impl Into<String>) -> Self {
        Self::new(what, Fate::Approximate, how)
    }

    pub(crate) fn callback(what: impl Into<String>, how: impl Into<String>) -> Self {
        Self::new(what, Fate::Callback, how)
    }

    pub(crate) fn lost(what: impl Into<String>, how: impl Into<String>) -> Self {
        Self::new(what, Fate::Lost, how)
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:<11}  {}: {}", self.fate.as_str(), self.what, self.how)
    }
}

/// What belongs to the log and its sensors, and stays in the model's file.
pub(crate) fn of_the_log(sensors: &BTreeMap<String, SensorSpec>, (lead, skew): (bool, f64)) -> Vec<Note> {
    let mut notes = Vec::new();
    if sensors.values().any(|s| s.gain.is_some() || s.bias.is_some()) {
        notes.push(Note::lost(
            "gain and bias of the sensors",
            "they stay in the model file: measured = gain true + bias",
        ));
    }
    if lead || skew != 0.0 {
        let lead = if lead { "a row's command acted in the period before its time stamp; " } else { "" };
        let how = format!("{lead}commands are late by {} of a period: they belong to the log", told(skew));
        notes.push(Note::lost("time stamps of the logger", how));
    }
    notes
}
