//! The matrix as a dated page of Markdown.

use super::{DURATION_S, INVISIBLE, NOTHING, Outcome, Stated};
use sealegs::mystery::score::Score;
use sealegs::mystery::trial::Strength;
use sealegs_reference::campaign::{BEYOND, Rig};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A parameter that is off by more is counted as missed, as a ratio.
const CLOSE: f64 = 0.1;

/// A score's letter in a cell.
fn letter(score: &str) -> char {
    match score {
        INVISIBLE => '-',
        "false alarm" => 'F',
        "tied" => 't',
        other => other.chars().next().map_or('?', |c| c.to_ascii_uppercase()),
    }
}

/// How many of each score, and of how many.
fn tally<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> (BTreeMap<String, usize>, usize) {
    let mut counts = BTreeMap::new();
    let mut all = 0;
    for outcome in outcomes.filter(|o| o.score != INVISIBLE) {
        *counts.entry(outcome.score.clone()).or_default() += 1;
        all += 1;
    }
    (counts, all)
}

/// The page for outcomes in the order of their rows, of so many campaigns that there are to be.
#[must_use]
pub fn table(outcomes: &[Outcome], of: usize, date: &str) -> String {
    let mut searches: Vec<&str> = outcomes.iter().map(|o| o.search.as_str()).collect();
    searches.sort_unstable();
    searches.dedup();
    let search = searches.join(", ");
    let mut out = format!(
        "# Recovery matrix, {date}\n\n\
         Search {search}. Made by `cargo run --release --example recovery_matrix`: campaigns of an independent simulator\n\
         (`crates/reference`) with wrong start parameters, through the whole diagnosis. Runs of {DURATION_S:.0} s, two to \
         fit on and two to judge on. {} of {of} campaigns are made.\n\n",
        outcomes.len()
    );
    totals(&mut out, outcomes);
    cells(&mut out, outcomes);
    misses(&mut out, outcomes);
    out
}

fn totals(out: &mut String, outcomes: &[Outcome]) {
    let beyond = |o: &&Outcome| BEYOND.contains(&o.row.as_str());
    let nothing = |o: &&Outcome| o.row == NOTHING;
    type Of<'a> = Box<dyn Fn(&&Outcome) -> bool + 'a>;
    let groups: [(&str, Of<'_>); 3] = [
        ("effects of the catalogue", Box::new(|o| !beyond(o) && !nothing(o))),
        ("nothing hidden", Box::new(nothing)),
        ("in no catalogue", Box::new(beyond)),
    ];
    out.push_str("| campaigns | number |");
    for score in Score::ALL {
        let _ = write!(out, " {score} |");
    }
    out.push_str(" right or tied |\n|---|---|");
    out.push_str(&"---|".repeat(Score::ALL.len() + 1));
    out.push('\n');
    for (name, of) in groups {
        let (counts, all) = tally(outcomes.iter().filter(|o| of(o)));
        let count = |s: Score| counts.get(s.as_str()).copied().unwrap_or(0);
        let _ = write!(out, "| {name} | {all} |");
        for score in Score::ALL {
            let _ = write!(out, " {} |", count(score));
        }
        let good = count(Score::Right) + count(Score::Tied);
        let share = 100.0 * good as f64 / all.max(1) as f64;
        let _ = writeln!(out, " {share:.1} % |");
    }
    let told: Vec<f64> = outcomes.iter().filter_map(|o| o.worst_parameter).collect();
    let close = told.iter().filter(|w| **w <= CLOSE).count();
    let nearest = outcomes.iter().filter_map(|o| o.worst(Stated::nearest_error));
    let close_to_either = nearest.filter(|w| *w <= CLOSE).count();
    let diagnosed: Vec<f64> = outcomes.iter().filter_map(|o| o.seconds).collect();
    let _ = writeln!(
        out,
        "\nWhere exactly the hidden effects were named and the fitted values are kept, every parameter of theirs is \
         within 10 % in {close} of {}, and in {close_to_either} where the value counts, too, that is said for the other convention \
         of a log that leaves it open. A diagnosis took {:.0} s on average.\n",
        told.len(),
        diagnosed.iter().sum::<f64>() / diagnosed.len().max(1) as f64
    );
    let located: Vec<_> = outcomes.iter().filter_map(|o| o.located).collect();
    if !located.is_empty() {
        let _ = writeln!(
            out,
            "Of what is in no catalogue, port and dependence were said right in {} of the {} campaigns since this is \
             counted, the port alone in {}.\n",
            located.iter().filter(|l| l.right()).count(),
            located.len(),
            located.iter().filter(|l| l.port && !l.dependence).count()
        );
    }
    let stated: Vec<&Stated> = outcomes.iter().flat_map(|o| &o.stated).collect();
    let held = |of_effect: bool| {
        let asked: Vec<&&Stated> = stated.iter().filter(|s| s.of_effect() == of_effect).collect();
        format!("{} of {}", asked.iter().filter(|s| s.holds()).count(), asked.len())
    };
    if !stated.is_empty() {
        let _ = writeln!(
            out,
            "Stated intervals of 95 % that hold the truth, on the {} campaigns since this is counted: {} of the \
             effects' parameters, {} of the base model's.\n",
            outcomes.iter().filter(|o| !o.stated.is_empty()).count(),
            held(true),
            held(false)
        );
    }
}

fn cells(out: &mut String, outcomes: &[Outcome]) {
    out.push_str(
        "One letter per individual: R right, t tied, P part, W wrong, M missed, F false alarm, - no strength lets it show \
         on this bench.\nIn no catalogue: R is `unexplained`, P `partly-explained`. Weak, middle and dominant are the base \
         model's error, in noise units: 1.3 to\n1.5, 8 to 25 and 100 to 400, or 2.5 to 5 and 8 to 20 where the load cells \
         alone see it.\n\n| hidden |",
    );
    let columns: Vec<(Rig, Strength)> =
        [Rig::Locked, Rig::Pendulum].iter().flat_map(|r| Strength::ALL.map(|s| (*r, s))).collect();
    for (rig, strength) in &columns {
        let _ = write!(out, " {}, {} |", rig.as_str(), strength.as_str());
    }
    out.push_str("\n|---|");
    out.push_str(&"---|".repeat(columns.len()));
    out.push('\n');
    let mut rows: Vec<&str> = Vec::new();
    for outcome in outcomes {
        if !rows.contains(&outcome.row.as_str()) {
            rows.push(&outcome.row);
        }
    }
    for row in rows {
        let _ = write!(out, "| {row} |");
        for (rig, strength) in &columns {
            let letters: String = outcomes
                .iter()
                .filter(|o| o.row == row && o.bench == rig.as_str() && o.strength == strength.as_str())
                .map(|o| letter(&o.score))
                .collect();
            let _ = write!(out, " {letters} |");
        }
        out.push('\n');
    }
}

/// An error in noise units, as the page and the progress say it.
#[must_use]
pub fn error(of: Option<f64>) -> String {
    of.map_or_else(|| "-".to_owned(), |error| format!("{error:.2}"))
}

fn misses(out: &mut String, outcomes: &[Outcome]) {
    let bad = |o: &&Outcome| !matches!(o.score.as_str(), "right" | "tied" | INVISIBLE);
    if !outcomes.iter().any(|o| bad(&o)) {
        return;
    }
    out.push_str("\n## What was not right\n\n| campaign | score | said | error before | after |\n|---|---|---|---|---|\n");
    for o in outcomes.iter().filter(bad) {
        let said = if o.said.is_empty() { String::new() } else { format!(": {}", o.said.join(" + ")) };
        let _ = writeln!(
            out,
            "| {} | {} | {}{said} | {} | {} |",
            o.name,
            o.score,
            o.verdict,
            error(o.base_error),
            error(o.after_error)
        );
    }
}
