//! Columns that lie whole samples beside the command or beside each other.

use super::against::{Seen, by_channel, in_runs};
use super::policy::{
    BEYOND_OWN_CORRELATION, CLEAR_OFFSET, LEFT_BY_OFFSET, LONG_OFFSET_S, MOST_OFFSET, NEAR_OFFSET,
    SAME_OFFSET,
};
use super::units::short;
use super::{Finding, Problem, Severity, finding, foreign};
use crate::{Campaign, stats};
use rayon::prelude::*;

/// Share of a column's variance that may stay before far offsets are looked for, too.
const UNEXPLAINED: f64 = 0.1;

/// Rows that are stepped over in a search far away.
const STRIDE: usize = 4;

/// The offset of a column in a run at which it fits its prediction best.
#[derive(Debug, Clone, Copy)]
struct Best {
    /// Rows by which the measured column is late; negative where it is early.
    lag: isize,
    /// Share of its variance that is left there.
    unexplained: f64,
    /// The same at the best offset that an effect could be: of many far ones some fit by chance.
    unexplained_near: f64,
    /// It is clearly better than none.
    clear: bool,
    /// No phase of a narrow band can be taken for it.
    beyond_phase: bool,
}

pub(super) fn look(campaign: &Campaign, seen: &[Seen]) -> Vec<Finding> {
    let told = |s: &Seen| s.moves() && !s.judged && is_driven(campaign, s);
    let best: Vec<Option<Best>> = seen.par_iter().map(|s| told(s).then(|| best(s))).collect();
    let mut found = Vec::new();
    let mut explained = vec![false; seen.len()];
    // All columns of every run together: the command is beside them.
    let of_command = |i: usize| {
        campaign.runs[seen[i].pair.run].record.inputs.len() == 1
            && seen.iter().filter(|s| s.pair.run == seen[i].pair.run && s.moves()).count() > 1
    };
    let examined =
        |of: &dyn Fn(usize) -> bool| (0..seen.len()).filter(|&i| best[i].is_some() && of(i)).count();
    let clear: Vec<usize> = (0..seen.len()).filter(|&i| best[i].is_some_and(|b| b.clear)).collect();
    // Slow runs hardly tell; what tells must agree, and be half of all at least.
    let enough = |own: &[usize], of: usize| !own.is_empty() && 2 * own.len() >= of && agree(own, &best);
    let channels = by_channel(seen);
    let every = channels.iter().all(|(channel, of)| {
        of.iter().all(|s| !told(s)) || clear.iter().any(|&i| seen[i].pair.channel == *channel)
    });
    if every && clear.iter().all(|&i| of_command(i)) && enough(&clear, examined(&|_| true)) {
        let channel = campaign.runs[seen[clear[0]].pair.run].record.inputs[0].channel.clone();
        clear.iter().for_each(|&i| explained[i] = true);
        found.extend(said(campaign, seen, &best, &clear, &channel, true));
    }
    for (channel, _) in channels {
        let own: Vec<usize> =
            clear.iter().copied().filter(|&i| !explained[i] && seen[i].pair.channel == channel).collect();
        if enough(&own, examined(&|i| seen[i].pair.channel == channel)) {
            found.extend(said(campaign, seen, &best, &own, channel, false));
        }
    }
    if found.iter().all(|f| !f.stops()) {
        let near: Vec<f64> = best.iter().flatten().map(|b| b.unexplained_near).collect();
        found.extend(foreign::look(campaign, seen, &near));
    }
    found
}

/// Whether a column's joint has a command in its run, where joints have commands of their own. Without one a joint of a
/// robot moves as a hand or a brake that nobody logged wants it to.
fn is_driven(campaign: &Campaign, s: &Seen) -> bool {
    let Some((joint, _)) = s.pair.channel.rsplit_once('.') else { return true };
    let inputs = campaign.runs[s.pair.run].record.inputs.iter();
    let efforts = inputs.filter_map(|i| i.channel.rsplit_once('.'));
    let mut driven = efforts.filter(|(_, what)| matches!(*what, "torque_nm" | "force_n")).peekable();
    driven.peek().is_none() || driven.any(|(of, _)| of == joint)
}

/// Looks for the offset of one column of a run.
fn best(s: &Seen) -> Best {
    let rows = s.pair.count();
    let most = MOST_OFFSET.min(rows / 4) as isize;
    let near = (NEAR_OFFSET as isize).min(most);
    let at = |lag: isize, stride: usize| s.pair.line(lag, stride).unexplained();
    let least = |lags: &mut dyn Iterator<Item = isize>, stride: usize| -> (isize, f64) {
        lags.map(|lag| (lag, at(lag, stride))).fold((0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a })
    };
    let mut found = least(&mut (-near..=near), 1);
    let unexplained_near = found.1;
    if (found.1 > UNEXPLAINED || found.0.abs() == near) && most > near {
        let (far, _) = least(&mut (-most..=most).filter(|l| l.abs() > near), STRIDE);
        let refined = least(&mut (far - 2..=far + 2), 1);
        if refined.1 < found.1 {
            found = refined;
        }
    }
    let (lag, unexplained) = found;
    let (none, noise) = (s.line.unexplained(), s.pair.noise / s.line.measured.max(f64::MIN_POSITIVE));
    let follows = s.pair.line(lag, 1).correlation > 0.0;
    let clear = follows
        && lag.abs() > 1
        && unexplained.sqrt() < CLEAR_OFFSET.0 * none.sqrt()
        && none.sqrt() > CLEAR_OFFSET.1 * noise;
    let beyond_phase = clear && s.pair.own_correlation(lag) < BEYOND_OWN_CORRELATION;
    Best { lag, unexplained, unexplained_near, clear, beyond_phase }
}

/// Whether pairs have the same offset.
fn agree(of: &[usize], best: &[Option<Best>]) -> bool {
    let lags: Vec<f64> = of.iter().filter_map(|&i| best[i]).map(|b| b.lag as f64).collect();
    let middle = stats::median(&lags);
    lags.iter().all(|l| (l - middle).abs() <= SAME_OFFSET.0.max(SAME_OFFSET.1 * middle.abs()))
}

/// What is said of pairs with the same offset.
fn said(
    campaign: &Campaign,
    seen: &[Seen],
    best: &[Option<Best>],
    of: &[usize],
    channel: &str,
    command: bool,
) -> Option<Finding> {
    let bests: Vec<Best> = of.iter().filter_map(|&i| best[i]).collect();
    let lag = stats::median(&bests.iter().map(|b| b.lag as f64).collect::<Vec<_>>());
    let periods: Vec<f64> = of.iter().map(|&i| campaign.runs[seen[i].pair.run].clock.period_s).collect();
    let time_s = lag.abs() * stats::median(&periods);
    let from = stats::median(&of.iter().map(|&i| seen[i].line.unexplained().sqrt()).collect::<Vec<_>>());
    let to = stats::median(&bests.iter().map(|b| b.unexplained.sqrt()).collect::<Vec<_>>());
    let mut runs: Vec<usize> = of.iter().map(|&i| seen[i].pair.run).collect();
    runs.dedup();
    let explains = to * to <= LEFT_BY_OFFSET;
    let sure = explains && time_s > LONG_OFFSET_S && bests.iter().any(|b| b.beyond_phase);
    // Without a recorded command the model moves by its own controller and contacts: a friction or a soft sole that it lacks
    // moves a column by some milliseconds, either way.
    if !sure && runs.iter().all(|&r| campaign.runs[r].record.inputs.is_empty()) {
        return None;
    }
    let late = if lag > 0.0 { "after" } else { "before" };
    let evidence = format!(
        "{} {} samples ({} ms) {late} {}: realigned, {:.1} % of its motion is left unexplained instead of {:.1} %, {}",
        if command { "every sensor answers".to_owned() } else { format!("`{channel}` lies") },
        lag.abs(),
        short(1e3 * time_s),
        if command { format!("the model's answer to `{channel}`") } else { "the model".to_owned() },
        100.0 * to,
        100.0 * from,
        in_runs(campaign, &runs, runs.len().max(campaign.runs.len()))
    );
    let cure = if sure {
        format!("move `{channel}` by {} rows in the file, or find where the rows went", lag.abs())
    } else if !explains {
        "the model is too far from the rig to tell a shift of rows from a wrong model".to_owned()
    } else {
        "a delay of the drive or of a sensor is an effect, which the diagnosis names if it is one".to_owned()
    };
    let most = if sure { Severity::Stops } else { Severity::Remark };
    finding(Problem::Offset, lag.abs(), most, channel, evidence, cure)
}
