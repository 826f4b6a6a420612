//! The stages of a bench's sensors as Python classes that are stepped.

use crate::bench::BenchDescription;
use crate::term::Term;
use crate::text::num;
use std::fmt::Write;

/// The stages that channels pass through, in their order: of each drive its terms, and its channels as its own bench and
/// the file call them.
pub fn write(out: &mut String, drives: &[(&BenchDescription, Vec<(&str, &str)>)]) {
    let mut list = String::new();
    for (bench, channels) in drives {
        for (_, term) in bench.terms() {
            for (channel, shown) in channels {
                if let Some(stage) = stage(term, channel) {
                    let _ = writeln!(list, "        (\"{shown}\", {stage}),");
                }
            }
        }
    }
    if list.is_empty() {
        out.push_str("\ndef stages():\n    return []\n\n");
        return;
    }
    out.push_str(include_str!("stages.py"));
    let _ = write!(out, "\n\ndef stages():\n    return [\n{list}    ]\n\n");
}

/// What a term does to a channel, if anything.
fn stage(term: &Term, channel: &str) -> Option<String> {
    let is_force = channel.ends_with("_n") || channel.ends_with("_nm");
    let (stage, concerns) = match term {
        Term::Mode { frequency_hz, ratio, participation } => {
            (format!("Mode({}, {}, {})", num(*frequency_hz), num(*ratio), num(*participation)), is_force)
        }
        Term::SensorLag { channel: at, cutoff_hz } => {
            (format!("Lag({})", num(*cutoff_hz)), at.as_ref().map_or(is_force, |c| c == channel))
        }
        Term::SensorDelay { channel: at, delay_s } => {
            (format!("Late({})", num(*delay_s)), at.as_ref().is_none_or(|c| c == channel))
        }
        _ => return None,
    };
    concerns.then_some(stage)
}
