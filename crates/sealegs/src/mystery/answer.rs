//! The answer to a mystery, and the sealed file that keeps it from a glance.
//!
//! The seal is no secret: the text is turned into letters and digits (base64, RFC 4648) so that nobody reads it by
//! accident, and a SHA-256 checksum tells a file that was changed or cut short.

use crate::{Error, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The sealed file's name in a campaign's folder.
pub const FILE: &str = "answer.sealed";

/// First line of a sealed file.
const HEAD: &str = "sealegs answer 1: not to be read, `sealegs reveal` opens it";

/// Letters in a line of a sealed file.
const LINE: usize = 76;

/// A number with its name; the unit is in the name or, for a base parameter, that of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Named {
    /// The parameter's name.
    pub name: String,
    /// SI.
    pub value: f64,
}

/// A hidden effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HiddenEffect {
    /// Its id, with its place or sensor where it has one.
    pub id: String,
    /// Whether the catalogue has it.
    pub known: bool,
    /// Its numbers, named as in its card.
    pub parameters: Vec<Named>,
    /// Where it acts, if the catalogue does not have it: `rotor`, `spring`, `sensor/force_1_n`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<String>,
    /// What it depends on, the most telling first, if the catalogue does not have it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub depends_on: Vec<String>,
}

/// A sensor's true errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueSensor {
    /// The column.
    pub channel: String,
    /// Measured per true.
    pub gain: f64,
    /// In the column's unit.
    pub bias: f64,
}

/// Everything that is true of a mystery and stands in none of its other files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// The campaign's name.
    pub campaign: String,
    /// Its bench.
    pub bench: String,
    /// The seed that made it.
    pub seed: u64,
    /// Error of the refitted model without the effects on the holdout runs, noise units.
    pub base_error: f64,
    /// Whether that was estimated to first order instead of refitted.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub base_error_is_estimate: bool,
    /// `start` or `end`: whether a row's command begins at its time stamp or ends there.
    pub stamp: String,
    /// What is rough about the log; no effect.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rough: Vec<String>,
    /// What is hidden; empty where nothing is.
    #[serde(default)]
    pub effects: Vec<HiddenEffect>,
    /// The base model's parameters.
    pub parameters: Vec<Named>,
    /// The sensors that have a gain and a bias.
    pub sensors: Vec<TrueSensor>,
}

impl Answer {
    /// The text of the sealed file.
    ///
    /// # Errors
    ///
    /// If a number cannot be written as TOML.
    pub fn sealed(&self) -> Result<String> {
        let text = toml::to_string(self)
            .map_err(|e| Error::Unwritable { what: "the answer", problem: e.to_string() })?;
        let letters = STANDARD.encode(&text);
        let lines: Vec<&str> =
            (0..letters.len()).step_by(LINE).map(|i| &letters[i..(i + LINE).min(letters.len())]).collect();
        Ok(format!("{HEAD}\n{}\n{}\n", checksum(&text), lines.join("\n")))
    }

    /// Opens a sealed file's text.
    ///
    /// # Errors
    ///
    /// If it is no sealed answer, or was changed.
    pub fn opened(sealed: &str) -> Result<Self> {
        let mut lines = sealed.lines();
        if lines.next() != Some(HEAD) {
            return Err(refused("line 1: no sealed answer of this version"));
        }
        let stated = lines.next().unwrap_or_default();
        let letters: String = lines.collect();
        let bytes = STANDARD.decode(letters).map_err(|_| refused("the sealed text is damaged"))?;
        let text = String::from_utf8(bytes).map_err(|_| refused("the sealed text is damaged"))?;
        if checksum(&text) != stated {
            return Err(refused("line 2: the checksum does not fit; the file was changed or cut short"));
        }
        toml::from_str(&text).map_err(|_| refused("the sealed text is of another version"))
    }
}

fn refused(problem: &str) -> Error {
    Error::SealedAnswer { problem: problem.to_owned() }
}

fn checksum(text: &str) -> String {
    Sha256::digest(text).iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer() -> Answer {
        Answer {
            campaign: "m".to_owned(),
            bench: "locked".to_owned(),
            seed: u64::from(u32::MAX),
            base_error: 3.25,
            base_error_is_estimate: false,
            stamp: "end".to_owned(),
            rough: vec!["spikes".to_owned()],
            effects: vec![
                HiddenEffect {
                    id: "backlash".to_owned(),
                    known: true,
                    parameters: vec![Named { name: "gap_m".to_owned(), value: 1.0 / 3.0 }],
                    port: None,
                    depends_on: Vec::new(),
                },
                HiddenEffect {
                    id: "friction-bump".to_owned(),
                    known: false,
                    parameters: Vec::new(),
                    port: Some("rotor".to_owned()),
                    depends_on: vec!["position".to_owned()],
                },
            ],
            parameters: vec![Named { name: "stiffness".to_owned(), value: 6.5e5 }],
            sensors: Vec::new(),
        }
    }

    #[test]
    fn what_is_sealed_opens_to_the_last_bit_and_tells_nothing_at_a_glance() {
        let sealed = answer().sealed().unwrap();
        assert!(!sealed.contains("backlash") && !sealed.contains("gap"), "{sealed}");
        assert!(sealed.lines().all(|l| l.len() <= LINE), "{sealed}");
        assert_eq!(Answer::opened(&sealed).unwrap(), answer());
    }

    #[test]
    fn a_damaged_seal_is_refused() {
        let sealed = answer().sealed().unwrap();
        let last = sealed.lines().last().unwrap();
        let other = if last.starts_with('A') { "B" } else { "A" };
        let changed = sealed.replace(last, &format!("{other}{}", &last[1..]));
        for damaged in ["", "hello", &changed, &sealed.replace(last, ""), &sealed.replace(last, "***")] {
            assert!(Answer::opened(damaged).is_err(), "{damaged}");
        }
    }
}
