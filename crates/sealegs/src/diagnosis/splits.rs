//! What is said of splits: whether the fit runs choose the same effects when one of them is left out.

use schemars::JsonSchema;
use sealegs_sysid::diagnose::{Diagnosis, VerdictKind, in_words};
use sealegs_sysid::{Campaign, Role, flips};
use serde::Serialize;

/// Runs that a sentence names.
const MOST_NAMED: usize = 4;

/// How the choice changes when each fit run is left out in turn.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Splits {
    /// Number of splits: each leaves out one fit run.
    pub splits: usize,
    /// How many of them choose the named set, or one that is listed as indistinguishable from it.
    pub choose_named: usize,
    /// What the others choose.
    pub others: Vec<OtherChoice>,
}

/// A set that some splits choose in place of the named one.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct OtherChoice {
    /// The set; empty for the base model.
    pub effects: Vec<String>,
    /// How many splits choose it.
    pub splits: usize,
    /// The runs that they leave out.
    pub left_out: Vec<String>,
}

impl Splits {
    /// Those of a diagnosis; none of fewer than three fit runs, and where nothing is said that could flip.
    pub(super) fn of(campaign: &Campaign, diagnosis: &Diagnosis) -> Option<Self> {
        let verdict = &diagnosis.verdict;
        if verdict.kind == VerdictKind::Unexplained {
            return None;
        }
        let named = verdict.after.index;
        let choices = flips::splits(&diagnosis.found, named, verdict.floor)?;
        let runs: Vec<&str> = campaign.runs_of(Role::Fit).map(|run| run.record.name.as_str()).collect();
        let mut others: Vec<OtherChoice> = Vec::new();
        for split in choices.iter().filter(|split| split.chosen != named) {
            let effects = &diagnosis.found.tried[split.chosen].effects;
            let run = runs.get(split.left_out).map_or_else(String::new, |run| (*run).to_owned());
            match others.iter_mut().find(|other| other.effects == *effects) {
                Some(other) => {
                    other.splits += 1;
                    other.left_out.push(run);
                }
                None => others.push(OtherChoice { effects: effects.clone(), splits: 1, left_out: vec![run] }),
            }
        }
        let choose_named = choices.iter().filter(|split| split.chosen == named).count();
        Some(Self { splits: choices.len(), choose_named, others })
    }

    /// That the verdict flips, in a sentence; none where it does not.
    pub(super) fn reservation(&self, named: &[String]) -> Option<String> {
        let without = |left_out: &[String]| match left_out {
            [first, .., _] if left_out.len() > MOST_NAMED => {
                format!("any of {} runs ({first} is the first)", left_out.len())
            }
            few => few.join(" or "),
        };
        let one = |other: &OtherChoice| {
            format!("{} without {}", in_words(&other.effects), without(&other.left_out))
        };
        let others: Vec<String> = self.others.iter().map(one).collect();
        (!others.is_empty()).then(|| {
            format!(
                "The verdict flips between splits of the fit runs: they choose {}, and {} in {} of {} splits.",
                others.join(", "),
                in_words(named),
                self.choose_named,
                self.splits
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flip_is_said_in_one_sentence_and_none_where_there_is_none() {
        let named = ["coulomb-friction".to_owned()];
        let steady = Splits { splits: 3, choose_named: 3, others: Vec::new() };
        assert_eq!(steady.reservation(&named), None);
        let other = OtherChoice {
            effects: vec!["backlash".to_owned()],
            splits: 1,
            left_out: vec!["fit_2.csv".to_owned()],
        };
        let pieces = (0..6).map(|n| format!("fit.csv from {n}.0 s")).collect();
        let often = OtherChoice { splits: 6, left_out: pieces, ..other.clone() };
        let said = Splits { splits: 9, choose_named: 3, others: vec![often] }.reservation(&named);
        assert!(said.is_some_and(|said| {
            said.contains("without any of 6 runs (fit.csv from 0.0 s is the first), and")
        }));
        let flips = Splits { splits: 3, choose_named: 2, others: vec![other] };
        assert_eq!(
            flips.reservation(&named).as_deref(),
            Some(
                "The verdict flips between splits of the fit runs: they choose backlash without fit_2.csv, and \
                 coulomb-friction in 2 of 3 splits."
            )
        );
    }
}
