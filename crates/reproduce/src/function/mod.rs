//! The functions that a formula of the table can call: `name(word, word, ...)`.

mod compensator;
mod response;
mod simulated;
mod stated;

use crate::ReproduceError;
use crate::setup::Setup;

/// What a function of the table is: its name, its arguments with what it gives, and the function.
struct Function {
    name: &'static str,
    usage: &'static str,
    law: fn(&Setup, &Call<'_>) -> Result<f64, ReproduceError>,
}

/// All of them, by topic.
const TOPICS: [&[Function]; 4] =
    [&stated::FUNCTIONS, &response::FUNCTIONS, &compensator::FUNCTIONS, &simulated::FUNCTIONS];

/// The functions that a formula of the table can call: name, and arguments with what it gives and in which unit.
#[must_use]
pub fn functions() -> Vec<(&'static str, &'static str)> {
    TOPICS.iter().flat_map(|t| t.iter()).map(|f| (f.name, f.usage)).collect()
}

/// A call with its words.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Call<'t> {
    name: &'t str,
    words: Vec<&'t str>,
}

impl<'t> Call<'t> {
    /// Reads a call. Text that does not begin with the name of a function and end with its bracket is none.
    pub(crate) fn parse(text: &'t str) -> Option<Self> {
        let (name, rest) = text.split_once('(')?;
        if !functions().iter().any(|(known, _)| *known == name) {
            return None;
        }
        let words = rest.strip_suffix(')')?;
        Some(Self { name, words: words.split(',').map(str::trim).filter(|w| !w.is_empty()).collect() })
    }

    /// Calls the function.
    pub(crate) fn value(&self, setup: &Setup) -> Result<f64, ReproduceError> {
        let function = TOPICS.iter().flat_map(|t| t.iter()).find(|f| f.name == self.name);
        (function.ok_or_else(|| self.unknown("function", self.name))?.law)(setup, self)
    }

    fn word(&self, at: usize) -> Result<&'t str, ReproduceError> {
        let missing = || ReproduceError::missing(format!("{} lacks argument {}", self.name, at + 1));
        self.words.get(at).copied().ok_or_else(missing)
    }

    fn number(&self, at: usize) -> Result<f64, ReproduceError> {
        let word = self.word(at)?;
        word.parse().map_err(|_| self.unknown("number", word))
    }

    fn unknown(&self, what: &str, word: &str) -> ReproduceError {
        ReproduceError::missing(format!("{}: no {what} '{word}'", self.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_are_told_from_arithmetic() {
        let call = Call::parse("peak_hz(force_1, smh, stiff, 3, 100)").unwrap();
        assert_eq!((call.word(0).unwrap(), call.number(4).unwrap()), ("force_1", 100.0));
        assert!(call.word(5).is_err() && call.number(0).is_err());
        assert_eq!(Call::parse("sqrt(2)"), None);
        assert_eq!(Call::parse("2 * k"), None);
        assert_eq!(Call::parse("printed(T2-09) / 2"), None);
    }

    #[test]
    fn names_are_unique_and_documented() {
        let mut names: Vec<&str> = functions().iter().map(|(name, _)| *name).collect();
        assert!(functions().iter().all(|(_, usage)| usage.len() > 10));
        let all = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all);
    }
}
