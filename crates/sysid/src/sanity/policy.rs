//! Every threshold of the sanity checks with its origin, in one table: what is said, and what stops a diagnosis.

use super::{Problem, Severity};

/// When a problem is worth a remark, and when it stops a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// The problem.
    pub problem: Problem,
    /// What is measured of it; it grows with the problem.
    pub measure: &'static str,
    /// From here on it is said.
    pub remark: f64,
    /// From here on it stops a diagnosis; `None` where it never does.
    pub stop: Option<f64>,
    /// Why there.
    pub origin: &'static str,
}

/// One rule a problem.
///
/// What stops is what no effect of any catalogue can be: a diagnosis would name something else for it. Whatever an
/// effect, a sensor or a logger can do to a rig that is wired and scaled as the file says is a remark at most.
pub const RULES: [Rule; 15] = [
    Rule {
        problem: Problem::FlippedSign,
        measure: "correlation of measured with predicted, or of a rate with its quantity's increase, negated, where the slope is within 3 and 1/3",
        remark: 0.7,
        stop: Some(0.9),
        origin: "a wrong model that is half of the signal off still correlates by +0.7; -0.9 leaves a fifth of the \
                 variance to everything but the sign",
    },
    Rule {
        problem: Problem::UnitFactor,
        measure: "correlation of measured with predicted, or of a rate with its quantity's increase, where the slope is within 15 % \
                  of a unit's factor",
        remark: 0.95,
        stop: Some(0.95),
        origin: "nominal parameters are known to 10 %, and no factor of the table is below 4; below 0.95 (a tenth of \
                 the variance unexplained) the slope is no scale but a resonance or a friction",
    },
    Rule {
        problem: Problem::OddScale,
        measure: "correlation of measured with predicted, where the slope is beyond 3 or below 1/3 and no unit's factor",
        remark: 0.95,
        stop: None,
        origin: "the wrong actuator file or a wrong parameter does this, too: the refit will tell",
    },
    Rule {
        problem: Problem::SwappedColumns,
        measure: "each column's error with its own prediction over that with the other's, the lesser of the two; or the same of \
                  their difference",
        remark: 2.0,
        stop: Some(3.0),
        origin: "columns that are not swapped fit the other's prediction worse, never better; half the error both ways \
                 takes an error of the model that is the very difference of the two predictions",
    },
    Rule {
        problem: Problem::Offset,
        measure: "samples by which a column lies beside its prediction",
        remark: 2.0,
        stop: Some(20.5),
        origin: "one sample is the stamp's convention. Delays of several samples (2 to 3 ms at 1 kHz, a bus or a filter) are \
                 effects of the catalogue and left to it; no drive or sensor that closes a loop is 20 samples late",
    },
    Rule {
        problem: Problem::ForeignCommand,
        measure: "share of the power of the best column that is not coherent with the command, where the model fails, too",
        remark: 0.7,
        stop: Some(0.9),
        origin: "the coherence of unrelated signals is that of chance, which is taken off; play, friction and hard springs leave \
                 more than half of a rig's motion coherent with its command",
    },
    Rule {
        problem: Problem::EchoedCommand,
        measure: "standard deviation of a column over what a straight line in the command leaves of it",
        remark: 1e3,
        stop: Some(3e4),
        origin: "the best torque sensors of the measured campaigns resolve a thousandth of what they measure, and a rotor or a \
                 joint obeys no straight line in its command; a copy differs by the digits of the file",
    },
    Rule {
        problem: Problem::DeadColumn,
        measure: "noise units (rms) that a column should have moved by and did not",
        remark: 5.0,
        stop: Some(20.0),
        origin: "a rotor that sticks at small commands stays within some noise units of rest",
    },
    Rule {
        problem: Problem::ClippedColumn,
        measure: "share of the rows on the extreme value in stretches, where the model goes beyond",
        remark: 2e-3,
        stop: None,
        origin: "40 rows of a run of 20 s; a limit in a sensor or a drive is an effect that a diagnosis can describe",
    },
    Rule {
        problem: Problem::Wraps,
        measure: "steps of a turn, to a twentieth of it, between rows where the angle moves by less than a fifth of one; or of a position's \
                  whole range against its motion",
        remark: 1.0,
        stop: Some(1.0),
        origin: "no machine turns once between two rows and stands still before and after: its acceleration would be that of a \
                 turn within a sample",
    },
    Rule {
        problem: Problem::RepeatedRows,
        measure: "share of the rows that repeat the one before in every column",
        remark: 2e-3,
        stop: None,
        origin: "they are left out, and a model is integrated over them as over a gap",
    },
    Rule {
        problem: Problem::MissingRows,
        measure: "share of the rows that an even clock would have and the file has not",
        remark: 1e-4,
        stop: None,
        origin: "the time column tells the truth, and a held command bridges the gap",
    },
    Rule {
        problem: Problem::Spikes,
        measure: "share of the rows that stand alone beyond ten robust standard deviations",
        remark: 1e-9,
        stop: None,
        origin: "they are left out where they are rare",
    },
    Rule {
        problem: Problem::NotSimulated,
        measure: "runs that the nominal model cannot follow",
        remark: 1.0,
        stop: None,
        origin: "a refit may begin elsewhere; if it cannot it says so itself",
    },
    Rule {
        problem: Problem::NoHoldout,
        measure: "missing role",
        remark: 1.0,
        stop: Some(1.0),
        origin: "without a held-out run there is no verdict",
    },
];

/// What a problem of a strength means; `None` where it is not worth a word.
#[must_use]
pub fn severity(problem: Problem, strength: f64) -> Option<Severity> {
    let rule = RULES.iter().find(|r| r.problem == problem)?;
    match rule.stop {
        Some(stop) if strength >= stop => Some(Severity::Stops),
        _ if strength >= rule.remark => Some(Severity::Remark),
        _ => None,
    }
}

/// A column is compared with its prediction where that moves by so many noise units (rms about its mean): then noise takes
/// less than 3 % of the correlation.
pub const EXCITED: f64 = 5.0;

/// A slope within this ratio of a unit's factor is one: nominal parameters are known to 10 %, a load cell to 1 %.
pub const NEAR_FACTOR: f64 = 1.15;

/// A slope beyond this ratio of 1 is no inaccuracy of a nominal parameter any more.
pub const ODD_SLOPE: f64 = 3.0;

/// Two swapped columns show the other's prediction with a slope within this ratio of 1.
pub const SWAPPED_SLOPE: f64 = 2.0;

/// Most samples by which a column is moved beside its prediction in search of an offset, and the least share of a run
/// that must stay.
pub const MOST_OFFSET: usize = 250;

/// Offsets up to which every run is examined; farther ones are looked for only where these leave a column unexplained.
pub const NEAR_OFFSET: usize = 20;

/// An offset is clear where it at least halves the error that is left without it, and where the error was above this many
/// noise units.
pub const CLEAR_OFFSET: (f64, f64) = (0.5, 3.0);

/// An offset that stops also lasts this long, s: at 10 kHz twenty samples are a slow bus.
pub const LONG_OFFSET_S: f64 = 0.02;

/// An offset that stops leaves no more than this share of the column's variance (a third of its motion): as for a unit's factor,
/// what is left beyond that is a model that is wrong, and a wrong model fits better somewhere by chance.
pub const LEFT_BY_OFFSET: f64 = 0.1;

/// An offset that stops is no phase of a narrow band: the prediction's own correlation with itself has fallen below this at
/// that offset, in some run.
pub const BEYOND_OWN_CORRELATION: f64 = 0.5;

/// A model that leaves less of the sensors' variance follows its command, whatever the coherence of short runs.
pub const MODEL_FAILS: f64 = 0.7;

/// Least number of segments over which coherence is averaged, and the longest segment, samples.
pub const COHERENCE_SEGMENTS: usize = 16;
/// See [`COHERENCE_SEGMENTS`].
pub const LONGEST_SEGMENT: usize = 1024;

/// Runs agree on an offset within so many samples, or this share of it.
pub const SAME_OFFSET: (f64, f64) = (1.0, 0.05);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_has_one_rule_with_its_origin_and_stops_no_earlier_than_it_is_said() {
        for problem in Problem::ALL {
            let rules: Vec<&Rule> = RULES.iter().filter(|r| r.problem == problem).collect();
            let [rule] = rules[..] else { panic!("{problem:?}: {rules:?}") };
            assert!(!rule.origin.is_empty() && !rule.measure.is_empty());
            assert!(rule.stop.is_none_or(|s| s >= rule.remark), "{rule:?}");
            assert_eq!(severity(problem, 0.99 * rule.remark), None);
            let expected = if rule.stop == Some(rule.remark) { Severity::Stops } else { Severity::Remark };
            assert_eq!(severity(problem, rule.remark), Some(expected));
        }
        assert_eq!(RULES.len(), Problem::ALL.len());
    }
}
