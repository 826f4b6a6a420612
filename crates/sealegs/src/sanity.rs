//! What is wrong with a log, as every verb shows it, and the refusal to diagnose it.

use crate::diagnosis::drift::Astray;
use crate::{Error, Result};
use sealegs_model::Model;
use sealegs_recorder::report::{Report, Table};
use sealegs_sysid::Campaign;
use sealegs_sysid::sanity::{self, Finding};
use std::fmt::Write as _;
use std::path::Path;

/// A heading and two lines a finding, with an empty line before; nothing where nothing was found.
#[must_use]
pub fn text(findings: &[Finding]) -> String {
    let mut out = String::new();
    if findings.is_empty() {
        return out;
    }
    out.push_str("\nChecks of the log\n");
    for finding in findings {
        let mark = if finding.stops() { "!" } else { " " };
        let _ = writeln!(out, "{mark} {}\n    {}", finding.evidence, finding.cure);
    }
    if findings.iter().any(Finding::stops) {
        out.push_str("  Findings marked with ! stop a diagnosis.\n");
    }
    out
}

/// What to do about runs from which the model as it stands diverges in open loop, in a sentence: a refit of it would take long and
/// say little.
#[must_use]
pub fn drift_advice(campaign: &Campaign, model: &dyn Model) -> Option<String> {
    Some(format!("before any refit: {}", Astray::before_a_fit(campaign, model)?.advice()))
}

/// The same as a section of a page.
pub fn section(page: &mut Report, findings: &[Finding]) {
    if findings.is_empty() {
        return;
    }
    page.section("Checks of the log");
    let mut table = Table::new().words("what was found").words("cure");
    for finding in findings {
        let cells = [finding.evidence.clone(), finding.cure.clone()];
        if finding.stops() {
            table.strong_row(cells)
        } else {
            table.row(cells)
        };
    }
    page.table(&table, "Found before anything was fitted. Findings in bold stop a diagnosis.");
}

/// Refuses to go on with a log that is not what its header says, unless `force`.
///
/// # Errors
///
/// [`Error::WrongLog`]: the first of the findings that stop, with its cure.
pub fn gate(campaign: &Path, findings: &[Finding], force: bool) -> Result<()> {
    match sanity::stop(findings) {
        Some(why) if !force => Err(Error::WrongLog { campaign: campaign.to_owned(), why }),
        _ => Ok(()),
    }
}
