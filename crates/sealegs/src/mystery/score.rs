//! How a verdict stands against the truth: the rules of a lab course, the same for the recovery matrix.

use std::collections::BTreeSet;
use std::fmt;

/// A verdict against the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Score {
    /// It names exactly what is hidden: nothing where nothing is, nothing known where it is in no catalogue.
    Right,
    /// What is hidden is among the sets that the verdict calls indistinguishable.
    Tied,
    /// Some of the effects, not all; or, for one of no catalogue, known effects that help, with the remainder
    /// said to be unexplained.
    Part,
    /// Other effects.
    Wrong,
    /// Nothing is said to be missing, and something is.
    Missed,
    /// Something is said to be missing, and nothing is.
    FalseAlarm,
}

impl Score {
    /// Every score, best first.
    pub const ALL: [Self; 6] =
        [Self::Right, Self::Tied, Self::Part, Self::Wrong, Self::Missed, Self::FalseAlarm];

    /// In a word or two.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Tied => "tied",
            Self::Part => "part",
            Self::Wrong => "wrong",
            Self::Missed => "missed",
            Self::FalseAlarm => "false alarm",
        }
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// Scores a verdict: its kind in the data contract's words, the effects that it names and the sets that it calls
/// indistinguishable, against what is `hidden`; `known` says whether the catalogue has all of that.
#[must_use]
pub fn score(
    hidden: &[String],
    known: bool,
    verdict: &str,
    named: &[String],
    indistinguishable: &[Vec<String>],
) -> Score {
    let set = |ids: &[String]| -> BTreeSet<String> { ids.iter().cloned().collect() };
    let (hidden, said) = (set(hidden), set(named));
    if hidden.is_empty() {
        return if verdict == "adequate" { Score::Right } else { Score::FalseAlarm };
    }
    if verdict == "adequate" {
        return Score::Missed;
    }
    if !known {
        return match verdict {
            "unexplained" => Score::Right,
            "partly-explained" => Score::Part,
            _ => Score::Wrong,
        };
    }
    if said == hidden {
        Score::Right
    } else if indistinguishable.iter().any(|tied| set(tied) == hidden) {
        Score::Tied
    } else if said.intersection(&hidden).next().is_some() {
        Score::Part
    } else {
        Score::Wrong
    }
}

/// Whether all that is hidden is a fault of the log that was said as such (by the ids of its sanity findings), with nothing
/// left to explain: rows that were not read are left out, and `adequate` is then the right verdict.
#[must_use]
pub fn is_said_of_the_log<'a>(
    hidden: &[String],
    verdict: &str,
    mut sanity: impl Iterator<Item = &'a str>,
) -> bool {
    hidden == ["stale-samples"] && verdict == "adequate" && sanity.any(|p| p == "repeated-rows")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_were_not_read_are_right_where_they_are_said() {
        let stale = ["stale-samples".to_owned()];
        assert!(is_said_of_the_log(&stale, "adequate", ["spikes", "repeated-rows"].into_iter()));
        assert!(!is_said_of_the_log(&stale, "adequate", ["spikes"].into_iter()));
        assert!(!is_said_of_the_log(&stale, "missing-effect", ["repeated-rows"].into_iter()));
        assert!(!is_said_of_the_log(&["backlash".to_owned()], "adequate", ["repeated-rows"].into_iter()));
    }

    #[test]
    fn every_case_has_its_score() {
        let ids = |text: &str| -> Vec<String> { text.split_whitespace().map(str::to_owned).collect() };
        let of = |hidden: &str, known: bool, verdict: &str, said: &str, tied: &str| {
            let tied: Vec<Vec<String>> = tied.split('|').map(ids).filter(|t| !t.is_empty()).collect();
            score(&ids(hidden), known, verdict, &ids(said), &tied)
        };
        assert_eq!(of("", true, "adequate", "", ""), Score::Right);
        assert_eq!(of("", true, "missing-effect", "a", ""), Score::FalseAlarm);
        assert_eq!(of("", true, "unexplained", "", ""), Score::FalseAlarm);
        assert_eq!(of("a b", true, "missing-effect", "b a", ""), Score::Right);
        assert_eq!(of("a", true, "missing-effect", "b", "c|a"), Score::Tied);
        assert_eq!(of("a b", true, "missing-effect", "b", "c|a"), Score::Part);
        assert_eq!(of("a", true, "partly-explained", "b", "c"), Score::Wrong);
        assert_eq!(of("a", true, "unexplained", "", ""), Score::Wrong);
        assert_eq!(of("a", true, "adequate", "", ""), Score::Missed);
        assert_eq!(of("odd", false, "unexplained", "", ""), Score::Right);
        assert_eq!(of("odd", false, "partly-explained", "a", ""), Score::Part);
        assert_eq!(of("odd", false, "missing-effect", "a", ""), Score::Wrong);
        assert_eq!(of("odd", false, "adequate", "", ""), Score::Missed);
    }
}
