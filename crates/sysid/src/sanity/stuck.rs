//! Columns that do not move although the model does: dead ones, and ones that stop at their extremes.

use super::against::{FOLLOWS, Seen, by_channel, in_runs, keep_throughout, moving};
use super::pair::Line;
use super::policy::EXCITED;
use super::units::short;
use super::{Finding, Problem, Severity, finding};
use crate::{Campaign, stats};
use sealegs_model::Unit;

/// A column that never changes is dead only if its prediction moves by this share of what the columns of its unit do: of
/// zero noise everything is a multiple.
const RELEVANT: f64 = 0.01;

/// A dead column shows no more than this many times its noise, nor this share of its prediction's motion.
const DEAD: (f64, f64) = (2.0, 0.02);

/// A column stands at its extreme if the model goes beyond by this share of its range on half of those rows; nominal
/// parameters bend a prediction by less.
const BEYOND_EXTREME: f64 = 0.1;

/// An extreme below this share of the greatest magnitude is where the column rests.
const AT_REST: f64 = 0.1;

pub(super) fn dead(campaign: &Campaign, seen: &mut [Seen]) -> Vec<Finding> {
    let moved_most: Vec<f64> = seen
        .iter()
        .map(|s| {
            let alike = |o: &&Seen| {
                o.pair.run == s.pair.run && Unit::symbol_of(o.pair.channel) == Unit::symbol_of(s.pair.channel)
            };
            seen.iter().filter(alike).map(|o| o.line.predicted).fold(0.0, f64::max)
        })
        .collect();
    for (s, most) in seen.iter_mut().zip(moved_most) {
        let still = s.line.measured <= (DEAD.0 * s.pair.noise).min(DEAD.1 * s.line.predicted);
        s.judged = s.moves() && still && s.line.predicted > RELEVANT * most;
    }
    let mut found = Vec::new();
    for (channel, of) in by_channel(seen) {
        let mut still: Vec<&&Seen> = of.iter().filter(|s| s.judged).collect();
        let runs = keep_throughout(campaign, &mut still, |s| s.pair.run, &moving(seen, channel));
        if still.is_empty() {
            continue;
        }
        // A rig that sticks is no broken sensor: something else must follow the model in the same run.
        let rig_moves = |run: usize| {
            seen.iter().any(|o| o.pair.run == run && o.moves() && o.line.correlation.abs() > FOLLOWS)
        };
        // A joint or a rotor may stick in one run, at small commands; a load cell has its noise even then.
        let counted = campaign.noise_std(channel).is_some_and(|n| n.quantum.is_some());
        let rests = counted || is_of_motion(channel);
        let sure = runs.iter().all(|r| rig_moves(*r)) && (still.len() == of.len() || !rests);
        let strengths: Vec<f64> = still.iter().map(|s| s.line.predicted / s.pair.noise).collect();
        let (shown, wanted) = (
            still.iter().map(|s| s.line.measured).fold(0.0, f64::max),
            still.iter().map(|s| s.line.predicted).fold(0.0, f64::max),
        );
        found.extend(finding(
            Problem::DeadColumn,
            stats::median(&strengths),
            if sure { Severity::Stops } else { Severity::Remark },
            channel,
            format!(
                "`{channel}` moves by {} {} (rms) where the model moves by {}, {}: dead?",
                short(shown),
                Unit::symbol_of(channel),
                short(wanted),
                in_runs(campaign, &runs, of.len())
            ),
            format!("look at the sensor and its cable, or take the column `{channel}` out of the file"),
        ));
    }
    found
}

/// Whether a column is a position or a speed.
pub(super) fn is_of_motion(channel: &str) -> bool {
    matches!(Unit::symbol_of(channel), "m" | "rad" | "m/s" | "rad/s")
}

pub(super) fn clipped(campaign: &Campaign, seen: &[Seen]) -> Vec<Finding> {
    let mut found = Vec::new();
    for (channel, of) in by_channel(seen) {
        let mut runs = Vec::new();
        let (mut rows, mut all, mut limit) = (0, 0, 0.0f64);
        for s in of.iter().filter(|s| s.moves() && !s.judged) {
            all += s.pair.count();
            let at = pinned(s);
            if at.is_empty() {
                continue;
            }
            runs.push(s.pair.run);
            rows += at.len();
            limit = at.iter().map(|&i| s.pair.measured[i].abs()).fold(limit, f64::max);
        }
        if runs.is_empty() {
            continue;
        }
        let share = rows as f64 / all.max(1) as f64;
        found.extend(finding(
            Problem::ClippedColumn,
            share,
            Severity::Stops,
            channel,
            format!(
                "`{channel}` stands at {} {} for {} % of the rows while the model goes on, {}: at its limit?",
                short(limit),
                Unit::symbol_of(channel),
                short(100.0 * share),
                in_runs(campaign, &runs, of.len())
            ),
            "raise the sensor's range or command less; a limit of the rig itself is left to the diagnosis"
                .to_owned(),
        ));
    }
    found
}

/// Rows of a column that stand on its least or greatest value in stretches of three and more while the model goes beyond.
fn pinned(s: &Seen) -> Vec<usize> {
    let measured = s.pair.measured;
    let rows = || s.pair.rows.iter().cloned().flatten();
    let (low, high) =
        rows().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), i| (a.min(measured[i]), b.max(measured[i])));
    let beside = |i: usize, by: isize| i.checked_add_signed(by).and_then(|k| measured.get(k)).copied();
    let stands = |i: usize, value: f64| {
        let same = |by: isize| beside(i, by) == Some(value);
        measured[i] == value && ((same(-1) && same(1)) || (same(1) && same(2)) || (same(-1) && same(-2)))
    };
    let mut pinned = Vec::new();
    for (value, way) in [(low, -1.0), (high, 1.0)] {
        let at: Vec<usize> = rows().filter(|&i| stands(i, value)).collect();
        if at.is_empty() || value.abs() < AT_REST * low.abs().max(high.abs()) {
            continue;
        }
        let others = rows().filter(|i| measured[*i] != low && measured[*i] != high);
        let line = Line::through(others.map(|i| (s.pair.predicted[i], measured[i])));
        let beyond: Vec<f64> =
            at.iter().map(|&i| way * (line.slope * s.pair.predicted[i] + line.bias - value)).collect();
        if line.correlation > FOLLOWS
            && stats::median(&beyond) > (BEYOND_EXTREME * (high - low)).max(EXCITED * s.pair.noise)
        {
            pinned.extend(at);
        }
    }
    pinned
}
