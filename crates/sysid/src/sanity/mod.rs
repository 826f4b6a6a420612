//! Whether a log is what its header says, before anything is fitted: signs, units, columns, clocks, broken sensors.
//!
//! [`look`] compares every column with the nominal model's prediction of it, and the columns with themselves. A flipped
//! sign, a column in degrees under a name in radians or two exchanged columns are no physics: a diagnosis would name an
//! effect for them. What is found is a [`Finding`] with its evidence in numbers and a cure in words. Which of them stop a
//! diagnosis is decided by one table ([`RULES`]) with the origin of every threshold.

mod against;
mod columns;
mod foreign;
mod offset;
mod pair;
mod policy;
mod rates;
mod stuck;
mod units;

pub use policy::{RULES, Rule};

use crate::Campaign;
use schemars::JsonSchema;
use sealegs_model::Model;
use serde::Serialize;

/// What may be wrong with a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Problem {
    /// A column runs against its prediction.
    FlippedSign,
    /// A column is in another unit than its name says.
    UnitFactor,
    /// A column is much larger or smaller than predicted, by no unit's factor.
    OddScale,
    /// Two columns have each other's name.
    SwappedColumns,
    /// A column lies some samples beside the others.
    Offset,
    /// The sensors do not follow the command column.
    ForeignCommand,
    /// A column is the command itself, and no measurement.
    EchoedCommand,
    /// A column hardly moves and should.
    DeadColumn,
    /// A column stops at its extremes.
    ClippedColumn,
    /// An angle jumps by a turn.
    Wraps,
    /// Rows in which nothing new was read.
    RepeatedRows,
    /// Rows that the clock says are not there.
    MissingRows,
    /// Single rows far beside their neighbours.
    Spikes,
    /// The nominal model cannot follow a run.
    NotSimulated,
    /// No run judges.
    NoHoldout,
}

impl Problem {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::FlippedSign,
        Self::UnitFactor,
        Self::OddScale,
        Self::SwappedColumns,
        Self::Offset,
        Self::ForeignCommand,
        Self::EchoedCommand,
        Self::DeadColumn,
        Self::ClippedColumn,
        Self::Wraps,
        Self::RepeatedRows,
        Self::MissingRows,
        Self::Spikes,
        Self::NotSimulated,
        Self::NoHoldout,
    ];
}

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// To be known; a diagnosis can live with it.
    Remark,
    /// A diagnosis would name an effect for it.
    Stops,
}

/// Something that is wrong with a log, or seems so.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Finding {
    /// The column; `time_s` for the clock, empty for the campaign as a whole.
    pub channel: String,
    /// What it is.
    pub problem: Problem,
    /// What speaks for it, in numbers: a sentence without its full stop.
    pub evidence: String,
    /// What to do, a sentence without its full stop.
    pub cure: String,
    /// Whether it stops a diagnosis.
    pub severity: Severity,
}

impl Finding {
    /// Whether it stops a diagnosis.
    #[must_use]
    pub fn stops(&self) -> bool {
        self.severity == Severity::Stops
    }

    /// Evidence and cure as a person reads them.
    #[must_use]
    pub fn sentence(&self) -> String {
        let stop = if self.evidence.ends_with('?') { "" } else { "." };
        format!("{}{stop} {}.", capital(&self.evidence), capital(&self.cure))
    }
}

/// A sentence with a capital letter at its beginning.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Looks at a campaign with its nominal model; what stops a diagnosis comes first.
///
/// Every run is looked at, whatever its role; nothing is fitted, and the result decides about nothing but whether a
/// diagnosis is begun. Runs that the model cannot predict at all ([`Campaign::check_against`]) are not compared.
#[must_use]
pub fn look(campaign: &Campaign, model: &dyn Model) -> Vec<Finding> {
    let mut findings = columns::look(campaign);
    findings.extend(rates::look(campaign));
    findings.extend(against::look(campaign, model));
    findings.sort_by(|a, b| b.severity.cmp(&a.severity).then(a.problem.cmp(&b.problem)));
    findings
}

/// What a log looks like with which a diagnosis is not begun, in one line; `None` where nothing stops it.
#[must_use]
pub fn stop(findings: &[Finding]) -> Option<String> {
    let stopping: Vec<&Finding> = findings.iter().filter(|f| f.stops()).collect();
    let first = stopping.first()?;
    let more = match stopping.len() - 1 {
        0 => String::new(),
        1 => " One more thing is wrong with the log.".to_owned(),
        more => format!(" {more} more things are wrong with the log."),
    };
    Some(format!("{}{more}", first.sentence()))
}

/// A finding if its strength is worth one, by the table.
fn finding(
    problem: Problem,
    strength: f64,
    most: Severity,
    channel: &str,
    evidence: String,
    cure: String,
) -> Option<Finding> {
    let severity = policy::severity(problem, strength)?.min(most);
    Some(Finding { channel: channel.to_owned(), problem, evidence, cure, severity })
}

#[cfg(test)]
mod tests;
