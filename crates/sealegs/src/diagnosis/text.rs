//! A diagnosis as text for a terminal.

use super::outcome::{Outcome, ParameterValue};
use super::sentence::TOLD;
use crate::report::units::with_interval;
use sealegs_sysid::diagnose::DEPARTURE;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Duration;

/// Rows of the ranking that are printed.
const ROWS: usize = 8;

/// Everything that is printed of a diagnosis that took this long.
#[must_use]
pub fn of(outcome: &Outcome, took: Duration) -> String {
    let mut out = String::new();
    let o = &mut out;
    let _ = writeln!(o, "{}: {}", outcome.campaign, outcome.sentence);
    for reason in &outcome.confidence.reasons {
        let _ = writeln!(o, "  {reason}");
    }
    o.push_str(&super::bounds::lines(outcome.bounded()));
    o.push_str(&crate::sanity::text(&outcome.sanity));
    let _ = writeln!(o);
    let said = |s: &&String| !outcome.confidence.reasons.contains(s);
    for sentence in outcome.remainder.iter().filter(said) {
        let _ = writeln!(o, "  {sentence}");
    }
    if !outcome.remainder.is_empty() {
        let _ = writeln!(o);
    }
    let mut rows =
        vec![("base model, refitted".to_owned(), outcome.base.fit_error, outcome.base.holdout_error)];
    if let Some(after) = &outcome.after {
        rows.push((format!("with {}", outcome.effects.join(" + ")), after.fit_error, after.holdout_error));
    }
    if let Some(law) = &outcome.law {
        let with = law.beside.iter().chain([&law.effect]).cloned().collect::<Vec<_>>().join(" + ");
        rows.push((format!("with {with}"), law.fit_error, law.holdout_error));
    }
    let wide = rows.iter().map(|(name, ..)| name.chars().count()).max().unwrap_or(0).max(24);
    let _ = writeln!(o, "  {:<wide$}  fit runs   held-out runs", "error in noise units");
    for (name, fitted, held_out) in rows {
        let _ = writeln!(o, "  {name:<wide$} {fitted:>9.3} {held_out:>15.3}");
    }
    if let Some(worst) = outcome.worst_channels(TOLD) {
        let _ = writeln!(o, "  held-out, root mean square: {worst}");
    }
    if !outcome.indistinguishable.is_empty() {
        let _ = writeln!(o, "\nThese runs fit as well:");
        for set in &outcome.indistinguishable {
            let _ = writeln!(o, "  {}", set.join(" + "));
        }
    }
    if let Some(sentence) = another_name(outcome) {
        let _ = writeln!(o, "\n{sentence}");
    }
    if !outcome.ranking.is_empty() {
        let widest =
            outcome.ranking.iter().take(ROWS).map(|r| r.effects.join(" + ").len()).max().unwrap_or(0);
        let _ = writeln!(o, "\n  {:<widest$}  {:>9}  {:>12}", "ranking", "held-out", "evidence");
        for ranked in outcome.ranking.iter().take(ROWS) {
            let name = ranked.effects.join(" + ");
            let _ = writeln!(
                o,
                "  {name:<widest$}  {:>9.3}  {:>12}",
                ranked.holdout_error,
                evidence(ranked.evidence)
            );
        }
        let _ = writeln!(
            o,
            "  (evidence: log-likelihood gained over the base model on left-out stretches of the fit runs, by \
             cross-validation)"
        );
    }
    if let Some(units) = &outcome.units {
        o.push_str(&units.text("base model", outcome.after.as_ref().map(|_| "with it")));
    }
    let side = outcome.after.as_ref().unwrap_or(&outcome.base);
    let _ = writeln!(
        o,
        "\n  parameters of the {}",
        if outcome.after.is_some() { "model with it" } else { "base model" }
    );
    out.push_str(&parameter_lines(&side.parameters));
    let o = &mut out;
    for sentence in other_conventions(outcome) {
        let _ = writeln!(o, "\n{sentence}");
    }
    let _ = writeln!(o, "\nNext experiment: {}", outcome.next_experiment);
    for note in crate::notes::together(&outcome.notes) {
        let _ = writeln!(o, "note: {note}");
    }
    let seconds = took.as_secs_f64();
    let _ = writeln!(
        o,
        "{} simulations, {:.0} s of experiment in {seconds:.1} s: {:.0} simulated seconds per second",
        outcome.work.simulations,
        outcome.work.simulated_s,
        outcome.work.simulated_s / seconds.max(1e-3)
    );
    again_below(&mut out, &outcome.campaign, &outcome.sentence);
    out
}

/// Lines of a terminal, less some for what stands above: a longer text says its answer again at its end.
const SCREEN: usize = 24;

/// Says the answer again where it has gone off the top of a terminal.
pub(crate) fn again_below(out: &mut String, campaign: &str, answer: &str) {
    if out.lines().count() > SCREEN {
        let _ = writeln!(out, "\n{campaign}: {answer}");
    }
}

/// Evidence with no more digits than mean something.
#[must_use]
pub fn evidence(value: f64) -> String {
    if value.abs() < 1e4 { format!("{value:.1}") } else { format!("{value:.3e}") }
}

/// One line a parameter with half its 95 % interval, fixed ones left out.
#[must_use]
pub fn parameter_lines(parameters: &[ParameterValue]) -> String {
    let mut out = String::new();
    let widest = parameters.iter().filter(|p| !p.fixed).map(|p| p.name.len()).max().unwrap_or(0);
    for p in parameters.iter().filter(|p| !p.fixed) {
        let remark = match p.remark() {
            nothing if nothing.is_empty() => nothing,
            remark => format!("  {remark}"),
        };
        let _ = writeln!(out, "  {:<widest$}  {}{remark}", p.name, with_interval(p.value, p.std, &p.unit));
    }
    out
}

/// So many digits of a value that its uncertainty shows in the last two.
pub(crate) fn digits_for(value: f64, std: f64) -> usize {
    if value == 0.0 || std <= 0.0 {
        return 4;
    }
    let ratio = (value.abs() / std).log10().floor();
    (ratio + 2.0).clamp(2.0, 9.0) as usize
}

/// A number with so many significant digits, in powers of ten only where it is very large or small.
#[must_use]
pub fn figures(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let power = value.abs().log10().floor() as i32;
    if (-4..7).contains(&power) {
        let decimals = (digits as i32 - 1 - power).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", digits.saturating_sub(1))
    }
}

/// What is said of laws that contain the named ones, if some were fitted.
#[must_use]
pub(super) fn another_name(outcome: &Outcome) -> Option<String> {
    let sets: Vec<String> = outcome.same_by_another_name.iter().map(|s| s.join(" + ")).collect();
    let (verb, pronoun) = if sets.len() == 1 { ("fits", "it is") } else { ("fit", "they are") };
    (!sets.is_empty()).then(|| {
        format!(
            "{} {verb} as well, because {pronoun} the same law on these runs: a law that differs by {:.0} % would have \
             fitted worse.",
            sets.join(" and "),
            100.0 * DEPARTURE
        )
    })
}

/// What is said of conventions of the log under which the data are explained as well, with other values.
#[must_use]
pub(super) fn other_conventions(outcome: &Outcome) -> Vec<String> {
    let parameters = outcome.after.as_ref().map_or(&[][..], |after| &after.parameters);
    let said = |(name, value): (&String, &f64)| {
        let p = parameters.iter().find(|p| p.name == *name);
        let (std, unit) = p.map_or((0.0, ""), |p| (p.std.unwrap_or(0.0), p.unit.as_str()));
        format!("{name} {} {unit}", figures(*value, digits_for(*value, std))).trim_end().to_owned()
    };
    let list = |values: &BTreeMap<String, f64>| values.iter().map(said).collect::<Vec<_>>().join(", ");
    outcome
        .equally_good_choices
        .iter()
        .map(|other| {
            format!(
                "With {} (a convention of the log that these runs leave open) the model fits as well, with {}.",
                list(&other.choices),
                list(&other.parameters)
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_show_their_uncertainty_and_no_more() {
        assert_eq!(figures(11650.3, digits_for(11650.3, 41.0)), "11650");
        assert_eq!(figures(0.012_345, digits_for(0.012_345, 0.000_21)), "0.0123");
        assert_eq!(figures(1.5e9, 3), "1.50e9");
        assert_eq!(figures(0.0, 3), "0");
    }
}
