//! What is said of a campaign of several units: each one's error, where their values differ, and for which a verdict holds.

use super::addition::Added;
use super::outcome::percent;
use super::text::figures;
use crate::comparison::Compared;
use crate::report::units::with_interval;
use schemars::JsonSchema;
use sealegs_recorder::report::{Report, Table};
use sealegs_sysid::diagnose::{Diagnosis, VerdictKind};
use sealegs_sysid::units::{self, Difference, UnitError};
use sealegs_sysid::{Campaign, Evaluation, Fit, Role};
use serde::Serialize;
use std::fmt::Write as _;

/// Error over the noise floor up to which nothing is missing on a unit: the diagnosis's own threshold of an explained error.
const EXPLAINED: f64 = 1.25;

/// Share of a unit's missing energy that effects must take for a verdict to hold for it, where something stays.
const MOST_OF_IT: f64 = 0.5;

/// The units of a campaign that has several. The physics that is added is the same in all, the model's own values are not.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Units {
    /// Each unit, in the order of the campaign.
    pub each: Vec<UnitSaid>,
    /// Parameters in which units differ by more than three combined standard errors, the clearest first.
    pub differing: Vec<Differing>,
    /// Whether the verdict holds for each unit that says something of it; none where nothing was found, or asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
    /// All of it in sentences.
    pub sentences: Vec<String>,
}

/// One unit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct UnitSaid {
    /// Its name.
    pub unit: String,
    /// Root mean square residual of its held-out runs before, in noise units: of the refitted base model, in `compare` of
    /// the model as given. None where none of its runs is held out.
    pub holdout_error_before: Option<f64>,
    /// The same after: of the model with the effects, in `compare` of the refitted one.
    pub holdout_error_after: Option<f64>,
    /// Share of its error's energy above the floor that is taken; none where there was none to take.
    pub taken_share: Option<f64>,
    /// Whether the verdict holds for this unit: most of what is missing is taken, or nothing is left. None where nothing
    /// was missing, or nothing was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holds: Option<bool>,
}

/// A parameter in which units differ.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Differing {
    /// The parameter, without a unit: `stiffness`.
    pub parameter: String,
    /// The unit of its values; empty for a ratio.
    pub unit: String,
    /// What each unit has.
    pub values: Vec<ValueOfUnit>,
    /// The greatest difference in its own standard errors.
    pub standard_errors: f64,
}

/// A unit's value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ValueOfUnit {
    /// The unit that has it.
    pub unit: String,
    /// The fitted value.
    pub value: f64,
    /// One standard error.
    pub std: f64,
}

/// What is to be said of holding.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Asked {
    /// Whether effects explain each unit.
    Effects,
    /// Whether each unit needs none.
    Nothing,
    /// Not at all: no effect explains what the units lack.
    Unexplained,
    /// Not at all: nothing was searched.
    No,
}

impl Units {
    /// Those of a diagnosis; none of a campaign with fewer than two.
    pub(super) fn of_diagnosis(campaign: &Campaign, diagnosis: &Diagnosis) -> Option<Self> {
        let verdict = &diagnosis.verdict;
        let asked = match verdict.kind {
            VerdictKind::Adequate => Asked::Nothing,
            VerdictKind::MissingEffect | VerdictKind::PartlyExplained => Asked::Effects,
            VerdictKind::Unexplained => Asked::Unexplained,
        };
        let holdout = Some((&verdict.base_holdout, &verdict.after_holdout));
        let fit = &diagnosis.found.tried[verdict.after.index].fit;
        Self::of(campaign, holdout, fit, asked)
    }

    /// Those of an addition.
    pub(super) fn of_addition(campaign: &Campaign, added: &Added) -> Option<Self> {
        let holdout = added.before_holdout.as_ref().zip(added.after_holdout.as_ref());
        Self::of(campaign, holdout, &added.after.fit, Asked::Effects)
    }

    /// Those of a comparison; their values are compared after a refit only.
    pub(crate) fn of_comparison(compared: &Compared) -> Option<Self> {
        let part = compared.part(Role::Holdout);
        let holdout = part.map(|part| (&part.before, part.shown()));
        match &compared.fit {
            Some(fit) => Self::of(compared.campaign, holdout, fit, Asked::No),
            None => Self::put_together(compared.campaign, holdout, Vec::new(), Asked::No),
        }
    }

    fn of(
        campaign: &Campaign,
        holdout: Option<(&Evaluation, &Evaluation)>,
        fit: &Fit,
        asked: Asked,
    ) -> Option<Self> {
        let said = |d: Difference| Differing {
            parameter: d.parameter,
            unit: d.symbol,
            standard_errors: d.standard_errors,
            values: d
                .values
                .into_iter()
                .map(|v| ValueOfUnit { unit: v.unit, value: v.value, std: v.std })
                .collect(),
        };
        let differing = units::differences(fit).into_iter().map(said).collect();
        Self::put_together(campaign, holdout, differing, asked)
    }

    fn put_together(
        campaign: &Campaign,
        holdout: Option<(&Evaluation, &Evaluation)>,
        differing: Vec<Differing>,
        asked: Asked,
    ) -> Option<Self> {
        let names = units::of_campaign(campaign);
        if names.is_empty() {
            return None;
        }
        let floor = campaign.noise_floor();
        let errors = holdout
            .map_or_else(Vec::new, |(before, after)| units::errors(campaign, Role::Holdout, before, after));
        let of = |unit: &String| match errors.iter().find(|e| e.unit == *unit) {
            Some(error) => UnitSaid::of(error, floor, asked),
            None => UnitSaid {
                unit: unit.clone(),
                holdout_error_before: None,
                holdout_error_after: None,
                taken_share: None,
                holds: None,
            },
        };
        let each: Vec<UnitSaid> = names.iter().map(of).collect();
        let known = || each.iter().filter_map(|u| u.holds);
        let holds = known().next().is_some().then(|| known().all(|holds| holds));
        let mut units = Self { each, differing, holds, sentences: Vec::new() };
        units.sentences = units.verdict(asked).into_iter().chain(units.differences()).collect();
        Some(units)
    }

    /// Names of the units for which the verdict does (not) hold.
    fn names(&self, holds: Option<bool>) -> Vec<&str> {
        self.each.iter().filter(|u| u.holds == holds).map(|u| u.unit.as_str()).collect()
    }

    /// For which units the verdict holds, in a sentence.
    fn verdict(&self, asked: Asked) -> Option<String> {
        if asked == Asked::Unexplained {
            return Some(
                "No effect shared by all units explains them. Diagnosed alone, each unit may show an effect of its own.".to_owned(),
            );
        }
        let not = self.names(Some(false));
        let silent: Vec<&str> =
            self.each.iter().filter(|u| u.holds.is_none()).map(|u| u.unit.as_str()).collect();
        let beside = match (silent.is_empty(), asked) {
            (false, Asked::Effects) => {
                format!(" (for {}, nothing is missing or no run is held out)", silent.join(" and "))
            }
            _ => String::new(),
        };
        match self.holds? {
            true if silent.is_empty() && self.each.len() == 2 => {
                Some("The verdict holds for both units.".to_owned())
            }
            true => Some(format!(
                "The verdict holds for {}{beside}.",
                if silent.is_empty() {
                    "every unit".to_owned()
                } else {
                    self.names(Some(true)).join(" and ")
                }
            )),
            false => Some(format!("The verdict does not hold for {}{beside}.", not.join(" and "))),
        }
    }

    /// In what the units differ, a sentence a parameter; one where they differ in nothing.
    fn differences(&self) -> Vec<String> {
        let one = |d: &Differing| {
            let of = |v: &ValueOfUnit| format!("{} {}", v.unit, with_interval(v.value, Some(v.std), &d.unit));
            format!(
                "The units differ in {}: {} ({} standard errors).",
                d.parameter,
                d.values.iter().map(of).collect::<Vec<_>>().join(", "),
                figures(d.standard_errors, 2)
            )
        };
        self.differing.iter().map(one).collect()
    }

    /// Why a verdict is not as sure as it would be of one unit.
    pub(super) fn reservation(&self) -> Option<String> {
        (self.holds == Some(false)).then(|| self.sentences.first().cloned()).flatten()
    }

    /// The lines of a terminal; `before` and `after` head the columns, the first alone where nothing was added.
    pub(crate) fn text(&self, before: &str, after: Option<&str>) -> String {
        let widest = self.each.iter().map(|u| u.unit.len()).max().unwrap_or(0).max(5);
        let mut out = format!("\nUnits, held-out error in noise units\n  {:<widest$}  {before:>10}", "");
        out.extend(after.map(|after| format!(" {after:>10}  {:>10}", "taken")));
        out.push('\n');
        for unit in &self.each {
            let _ = write!(out, "  {:<widest$}  {:>10}", unit.unit, said(unit.holdout_error_before));
            out.extend(
                after.map(|_| format!(" {:>10}  {:>10}", said(unit.holdout_error_after), unit.taken())),
            );
            out.push('\n');
        }
        for sentence in &self.sentences {
            let _ = writeln!(out, "  {sentence}");
        }
        out
    }

    /// The section of a report; `before` and `after` as for [`Units::text`].
    pub(crate) fn section(&self, page: &mut Report, before: &str, after: Option<&str>) {
        page.section("Units");
        for sentence in &self.sentences {
            page.paragraph(sentence);
        }
        let mut table = Table::new().words("unit").numbers(before, "noise units");
        if let Some(after) = after {
            table = table.numbers(after, "noise units").numbers("taken", "");
        }
        for unit in &self.each {
            let mut cells = vec![unit.unit.clone(), said(unit.holdout_error_before)];
            if after.is_some() {
                cells.extend([said(unit.holdout_error_after), unit.taken()]);
            }
            table.row(cells);
        }
        page.table(
            &table,
            "Root mean square residual of each unit's own held-out runs, and the share of its energy above the noise floor that is \
             taken. Every unit has its own values of the model's parameters; the effects are shared.",
        );
    }
}

/// An error as printed.
fn said(error: Option<f64>) -> String {
    error.map_or("-".to_owned(), |e| figures(e, 4))
}

impl UnitSaid {
    fn of(error: &UnitError, floor: f64, asked: Asked) -> Self {
        let excess = |e: f64| (e * e - floor * floor).max(0.0);
        let missing = error.before > EXPLAINED * floor;
        let taken_share =
            (excess(error.before) > 0.0 && missing).then(|| 1.0 - excess(error.after) / excess(error.before));
        let explained = error.after <= EXPLAINED * floor;
        let holds = match asked {
            Asked::No | Asked::Unexplained => None,
            Asked::Nothing => Some(explained),
            // Where nothing was missing, an effect may only do harm.
            Asked::Effects if !missing => (!explained).then_some(false),
            Asked::Effects => Some(explained || taken_share.is_some_and(|share| share >= MOST_OF_IT)),
        };
        Self {
            unit: error.unit.clone(),
            holdout_error_before: Some(error.before),
            holdout_error_after: Some(error.after),
            taken_share,
            holds,
        }
    }

    /// The share that is taken, as printed.
    fn taken(&self) -> String {
        match self.taken_share {
            None => "-".to_owned(),
            Some(share) if share <= 0.0 => "nothing".to_owned(),
            Some(share) if share > 0.99 => format!("{:.2} %", 100.0 * share),
            Some(share) => percent(share),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(before: f64, after: f64, asked: Asked) -> UnitSaid {
        UnitSaid::of(&UnitError { unit: "left".to_owned(), before, after }, 1.0, asked)
    }

    #[test]
    fn a_verdict_holds_for_a_unit_whose_error_it_takes() {
        assert_eq!(unit(40.0, 1.02, Asked::Effects).holds, Some(true));
        assert_eq!(unit(40.0, 12.0, Asked::Effects).holds, Some(true));
        assert_eq!(unit(40.0, 35.0, Asked::Effects).holds, Some(false));
        // Nothing was missing: what is no better says nothing, what is worse speaks against it.
        assert_eq!(unit(1.03, 1.02, Asked::Effects).holds, None);
        assert_eq!(unit(1.03, 4.0, Asked::Effects).holds, Some(false));
        assert_eq!(unit(1.03, 1.03, Asked::Nothing).holds, Some(true));
        assert_eq!(unit(40.0, 40.0, Asked::No).holds, None);
        assert_eq!(unit(40.0, 50.0, Asked::Effects).taken(), "nothing");
    }
}
