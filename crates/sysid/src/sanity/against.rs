//! Every column against the nominal model's prediction of it: signs, units, exchanged, dead and clipped columns.

use super::pair::{Line, Pair};
use super::policy::{EXCITED, NEAR_FACTOR, ODD_SLOPE, SWAPPED_SLOPE};
use super::units::{are_counts, probable, short};
use super::{Finding, Problem, Severity, finding, offset, rates, stuck};
use crate::{Campaign, Data, stats};
use sealegs_model::columns::commanded_joint;
use sealegs_model::{Model, Parameter, Prediction, Unit};

/// Integration steps per sampling period, as in a search: a sign needs no more.
const STEPS_PER_SAMPLE: f64 = 4.0;

/// Correlation from which a column follows its model: the rig moves.
pub(super) const FOLLOWS: f64 = 0.5;

/// Runs that a finding names.
const MOST_NAMED: usize = 4;

/// A pair with the line through it.
pub(super) struct Seen<'a> {
    pub pair: Pair<'a>,
    pub line: Line,
    /// Explained already: its sign, unit or name is wrong, or it is dead.
    pub judged: bool,
}

impl Seen<'_> {
    /// Whether the prediction moves far enough beyond the noise to compare anything with it.
    pub fn moves(&self) -> bool {
        self.line.predicted > EXCITED * self.pair.noise
    }
}

/// One column's problem in one run.
struct Mark {
    run: usize,
    strength: f64,
    line: Line,
}

pub(super) fn look(campaign: &Campaign, model: &dyn Model) -> Vec<Finding> {
    let Ok(data) = Data::new(campaign, None, model) else { return Vec::new() };
    let coarse = model.coarser(STEPS_PER_SAMPLE);
    let nominal: Vec<f64> = coarse.parameters().iter().map(|p| p.value).collect();
    let predictions: Vec<Result<Prediction, crate::Error>> = {
        use rayon::prelude::*;
        (0..data.runs.len()).into_par_iter().map(|r| data.predict_run(r, coarse.as_ref(), &nominal)).collect()
    };
    let mut found = Vec::new();
    let failed: Vec<String> =
        predictions.iter().filter_map(|p| p.as_ref().err()).map(ToString::to_string).collect();
    if let Some(first) = failed.first() {
        found.extend(finding(
            Problem::NotSimulated,
            failed.len() as f64,
            Severity::Stops,
            "",
            format!("the nominal model cannot follow {} of {} runs: {first}", failed.len(), data.runs.len()),
            "compare the unit of the command with its column's name, and the model file with the rig"
                .to_owned(),
        ));
    }
    let mut seen = Vec::new();
    for (run, prediction) in data.runs.iter().zip(&predictions) {
        let Ok(prediction) = prediction else { continue };
        for (slot, name) in run.names.iter().enumerate() {
            let Some(predicted) = prediction.output(name) else { continue };
            let channel = &data.channels[run.channels[slot]];
            let pair = Pair {
                run: run.index,
                channel: &channel.name,
                noise: channel.noise_std,
                measured: run.measured[slot],
                predicted,
                rows: run.scored.clone(),
            };
            let line = pair.line(0, 1);
            seen.push(Seen { pair, line, judged: false });
        }
    }
    found.extend(stuck::dead(campaign, &mut seen));
    found.extend(swapped(campaign, &mut seen));
    // The inertia of a motor that nobody has stated scales every motion.
    let scaled = model.parameters().iter().any(Parameter::is_unknown);
    found.extend(signs_and_units(campaign, &mut seen, scaled));
    found.extend(stuck::clipped(campaign, &seen));
    found.extend(offset::look(campaign, &seen));
    found
}

/// The names of columns in the order of their first appearance, each with its pairs.
pub(super) fn by_channel<'s, 'a>(seen: &'s [Seen<'a>]) -> Vec<(&'a str, Vec<&'s Seen<'a>>)> {
    let mut all: Vec<(&str, Vec<&Seen>)> = Vec::new();
    for s in seen {
        match all.iter_mut().find(|(c, _)| *c == s.pair.channel) {
            Some((_, of)) => of.push(s),
            None => all.push((s.pair.channel, vec![s])),
        }
    }
    all
}

/// `in all 4 runs`, `in fit.csv and check.csv`, `in 7 of 9 runs (fit.csv is the first)`.
pub(super) fn in_runs(campaign: &Campaign, runs: &[usize], of: usize) -> String {
    let names: Vec<&str> = runs.iter().map(|&r| campaign.runs[r].record.name.as_str()).collect();
    match names.as_slice() {
        [one] if of == 1 => format!("in {one}"),
        all if all.len() == of => format!("in all {of} runs"),
        [first, ..] if names.len() > MOST_NAMED => {
            format!("in {} of {of} runs ({first} is the first)", names.len())
        }
        [first @ .., last] if !first.is_empty() => format!("in {} and {last}", first.join(", ")),
        other => format!("in {} only", other.concat()),
    }
}

/// Keeps the marks of runs whose log shows the same in most of its pieces in which the column moves: a log is wired one way from
/// its beginning to its end, and over a short piece a wrong model runs against it by chance. Returns their runs.
pub(super) fn keep_throughout<T>(
    campaign: &Campaign,
    marks: &mut Vec<T>,
    run_of: impl Fn(&T) -> usize,
    moving: &[usize],
) -> Vec<usize> {
    let marked: Vec<usize> = marks.iter().map(&run_of).collect();
    let of_log = |runs: &[usize], log: usize| {
        let path = &campaign.runs[log].path;
        runs.iter().filter(|&&run| campaign.runs[run].path == *path).count()
    };
    marks.retain(|mark| 2 * of_log(&marked, run_of(mark)) > of_log(moving, run_of(mark)));
    marks.iter().map(run_of).collect()
}

/// The runs in which a column moves.
pub(super) fn moving(seen: &[Seen], channel: &str) -> Vec<usize> {
    seen.iter().filter(|s| s.pair.channel == channel && s.moves()).map(|s| s.pair.run).collect()
}

/// Standard deviation of measured less predicted values.
fn apart(measured: &Pair, predicted: &Pair) -> f64 {
    let rows = measured.rows.iter().cloned().flatten();
    stats::std(&rows.map(|i| measured.measured[i] - predicted.predicted[i]).collect::<Vec<_>>())
}

/// How much better two columns of a run fit each other's prediction than their own; 1 or less where they do not.
pub(super) fn exchange(a: &Seen, b: &Seen) -> f64 {
    let cross = |m: &Pair, p: &Pair| {
        let rows = m.rows.iter().cloned().flatten();
        Line::through(rows.map(|i| (p.predicted[i], m.measured[i])))
    };
    let like_one = |line: Line| {
        line.correlation > FOLLOWS && (1.0 / SWAPPED_SLOPE..=SWAPPED_SLOPE).contains(&line.slope)
    };
    if !like_one(cross(&a.pair, &b.pair)) || !like_one(cross(&b.pair, &a.pair)) {
        return 0.0;
    }
    let better = |m: &Pair, other: &Pair| {
        let (own, theirs) = (apart(m, m), apart(m, other));
        // What is within the noise of its own prediction is where it belongs.
        if own < EXCITED * m.noise { 0.0 } else { own / theirs.max(f64::MIN_POSITIVE) }
    };
    better(&a.pair, &b.pair).min(better(&b.pair, &a.pair)).max(difference(&a.pair, &b.pair))
}

/// How much better the difference of two columns fits its prediction with the other sign: what a model misses of both alike,
/// a stiffness say, is not in it.
fn difference(a: &Pair, b: &Pair) -> f64 {
    let rows = || a.rows.iter().cloned().flatten();
    let spread = |sign: f64| {
        let left = rows().map(|i| (a.measured[i] - b.measured[i]) - sign * (a.predicted[i] - b.predicted[i]));
        stats::std(&left.collect::<Vec<_>>())
    };
    spread(1.0) / spread(-1.0).max(f64::MIN_POSITIVE)
}

fn swapped(campaign: &Campaign, seen: &mut [Seen]) -> Vec<Finding> {
    let mut pairs: Vec<(String, String, Vec<Mark>, Vec<usize>)> = Vec::new();
    for i in 0..seen.len() {
        for j in i + 1..seen.len() {
            let (a, b) = (&seen[i], &seen[j]);
            if a.pair.run != b.pair.run
                || a.judged
                || b.judged
                || !(a.moves() && b.moves())
                || Unit::symbol_of(a.pair.channel) != Unit::symbol_of(b.pair.channel)
            {
                continue;
            }
            let strength = exchange(a, b);
            if super::policy::severity(Problem::SwappedColumns, strength).is_none() {
                continue;
            }
            let mark = Mark { run: a.pair.run, strength, line: a.line };
            let at = pairs.iter().position(|p| p.0 == a.pair.channel && p.1 == b.pair.channel);
            let at = at.unwrap_or_else(|| {
                pairs.push((a.pair.channel.to_owned(), b.pair.channel.to_owned(), Vec::new(), Vec::new()));
                pairs.len() - 1
            });
            pairs[at].2.push(mark);
            pairs[at].3.extend([i, j]);
        }
    }
    let mut found = Vec::new();
    for (a, b, mut marks, at) in pairs {
        let moving = moving(seen, &a);
        let runs = keep_throughout(campaign, &mut marks, |m| m.run, &moving);
        let strength = stats::median(&marks.iter().map(|m| m.strength).collect::<Vec<_>>());
        for k in at {
            seen[k].judged |= runs.contains(&seen[k].pair.run);
        }
        found.extend(finding(
            Problem::SwappedColumns,
            strength,
            Severity::Stops,
            &a,
            format!(
                "`{a}` and `{b}` fit each other's prediction {} times better than their own, {}: exchanged?",
                short(strength),
                in_runs(campaign, &runs, moving.len())
            ),
            format!("exchange the names of `{a}` and `{b}` in the header"),
        ));
    }
    found
}

/// What a line says of a column: a problem with its strength.
pub(super) fn of_line(s: &Seen) -> Option<(Problem, f64)> {
    let (r, slope) = (s.line.correlation, s.line.slope);
    let worth = |problem, strength| super::policy::severity(problem, strength).map(|_| (problem, strength));
    if !(1.0 / ODD_SLOPE..=ODD_SLOPE).contains(&slope.abs()) {
        let known = probable(s.pair.channel, slope).is_some() || are_counts(s.pair.measured);
        let unit = known.then(|| worth(Problem::UnitFactor, r.abs())).flatten();
        // A column that hardly moves, or far more than it should, says nothing of its sign: the model is another rig's there.
        return unit.or_else(|| worth(Problem::OddScale, r.abs()));
    }
    worth(Problem::FlippedSign, -r)
}

/// The column that one of a joint agrees with in every run, as its rate or of which it is the rate, and the joint's command: where
/// both run against a model it is the command that is wrong.
fn commanded_against(campaign: &Campaign, channel: &str) -> Option<(String, String)> {
    let (joint, _) = channel.rsplit_once('.')?;
    let mut inputs = campaign.runs.first()?.record.inputs.iter();
    let command = inputs.find(|input| commanded_joint(&input.channel) == Some(joint))?;
    Some((rates::agreeing(campaign, channel)?, command.channel.clone()))
}

/// Which way a column counts as positive.
fn positive(channel: &str) -> &'static str {
    let what = channel.rsplit_once('.').map_or(channel, |(_, what)| what);
    match what {
        "force_1_n" | "force_2_n" | "spring_deflection_m" => "positive is compression",
        "angle_rad" | "position_m" | "speed_rad_s" | "speed_m_s" if channel.contains('.') => {
            "positive is along the joint's axis in the URDF"
        }
        _ => "positive is where a positive command drives it",
    }
}

/// `scaled`: whether the model's motions are known to a factor only.
fn signs_and_units(campaign: &Campaign, seen: &mut [Seen], scaled: bool) -> Vec<Finding> {
    let of_pair = |s: &Seen| {
        let told = if s.judged || !s.moves() { None } else { of_line(s) };
        told.filter(|(problem, _)| {
            !(scaled && *problem == Problem::OddScale && stuck::is_of_motion(s.pair.channel))
        })
    };
    let told: Vec<Option<(Problem, f64)>> = seen.iter().map(of_pair).collect();
    let mut found = Vec::new();
    let all_of_command = command(campaign, seen, &told, &mut found);
    for (channel, of) in by_channel(seen) {
        let moving = moving(seen, channel);
        for problem in [Problem::FlippedSign, Problem::UnitFactor, Problem::OddScale] {
            let mut marks: Vec<Mark> = seen
                .iter()
                .zip(&told)
                .filter(|(s, _)| s.pair.channel == channel && !all_of_command.contains(&s.pair.run))
                .filter_map(|(s, told)| {
                    let (p, strength) = (*told)?;
                    (p == problem).then_some(Mark { run: s.pair.run, strength, line: s.line })
                })
                .collect();
            keep_throughout(campaign, &mut marks, |m| m.run, &moving);
            let counts = of.iter().all(|s| are_counts(s.pair.measured));
            found.extend(of_marks(campaign, problem, channel, &marks, moving.len(), counts));
        }
    }
    for (s, told) in seen.iter_mut().zip(told) {
        s.judged |= told.is_some();
    }
    found
}

/// The finding of one column's marks.
fn of_marks(
    campaign: &Campaign,
    problem: Problem,
    channel: &str,
    marks: &[Mark],
    moving: usize,
    counts: bool,
) -> Option<Finding> {
    let middle = |of: fn(&Mark) -> f64| stats::median(&marks.iter().map(of).collect::<Vec<_>>());
    let (slope, r) = (middle(|m| m.line.slope), middle(|m| m.line.correlation));
    let runs: Vec<usize> = marks.iter().map(|m| m.run).collect();
    let place = if marks.is_empty() { return None } else { in_runs(campaign, &runs, moving) };
    let sign = if slope < 0.0 { "-" } else { "" };
    let (evidence, cure) = match problem {
        Problem::FlippedSign => (
            format!(
                "`{channel}` runs against the model with slope {slope:.2} (correlation {r:.3}) {place}: sign?"
            ),
            match commanded_against(campaign, channel) {
                Some((other, command)) => {
                    format!(
                        "`{channel}` agrees with `{other}`: negate the command, `{command}`, rather than both"
                    )
                }
                None => format!("negate `{channel}`; {}", positive(channel)),
            },
        ),
        Problem::UnitFactor if counts => (
            format!(
                "`{channel}` holds whole numbers only, {} times what the model says (correlation {r:.3}) {place}: counts?",
                short(slope)
            ),
            format!(
                "divide `{channel}` by {sign}{} counts per {}",
                short(slope.abs()),
                Unit::symbol_of(channel)
            ),
        ),
        Problem::UnitFactor => {
            let (factor, name) = probable(channel, slope)?;
            let times = if slope < 0.0 { ", and against it" } else { "" };
            (
                format!(
                    "`{channel}` is {} times what the model says{times} (correlation {r:.3}) {place}: {name}?",
                    short(slope.abs())
                ),
                format!(
                    "divide `{channel}` by {sign}{}; its name says {}",
                    short(factor),
                    Unit::symbol_of(channel)
                ),
            )
        }
        _ => (
            format!("`{channel}` is {} times what the model says (correlation {r:.3}) {place}", short(slope)),
            "compare the sensor's scale and the actuator's file with the rig".to_owned(),
        ),
    };
    // A unit is one number in every run; what changes with the amplitude is a limit or a friction.
    let sizes: Vec<f64> = marks.iter().map(|m| m.line.slope.abs()).collect();
    let one = sizes.iter().all(|s| s.max(slope.abs()) < NEAR_FACTOR * s.min(slope.abs()));
    let sure = problem != Problem::UnitFactor || (marks.len() == moving && one);
    let most = if sure { Severity::Stops } else { Severity::Remark };
    finding(problem, middle(|m| m.strength), most, channel, evidence, cure)
}

/// Where every column of a run is off in the same way the command is: returns the runs that this explains.
fn command(
    campaign: &Campaign,
    seen: &[Seen],
    told: &[Option<(Problem, f64)>],
    found: &mut Vec<Finding>,
) -> Vec<usize> {
    let mut runs: Vec<(usize, f64, f64)> = Vec::new();
    for (index, run) in campaign.runs.iter().enumerate() {
        let own: Vec<(&Seen, Option<(Problem, f64)>)> = seen
            .iter()
            .zip(told.iter().copied())
            .filter(|(s, _)| s.pair.run == index && s.moves() && !s.judged)
            .collect();
        // A column that follows the model as it should speaks for the command.
        let follows = |s: &Seen| (1.0 / ODD_SLOPE..=ODD_SLOPE).contains(&s.line.slope);
        let told = own.iter().filter(|(_, t)| t.is_some()).count();
        if run.record.inputs.len() != 1 || told < 2 || own.iter().any(|(s, t)| t.is_none() && follows(s)) {
            continue;
        }
        let slopes: Vec<f64> = own.iter().filter(|(_, t)| t.is_some()).map(|(s, _)| s.line.slope).collect();
        let (low, high) =
            slopes.iter().fold((f64::INFINITY, 0.0f64), |(a, b), s| (a.min(s.abs()), b.max(s.abs())));
        let own: Vec<_> = own.into_iter().filter(|(_, t)| t.is_some()).collect();
        let one_way = slopes.iter().all(|s| s.signum() == slopes[0].signum());
        if one_way && high < ODD_SLOPE * low {
            let r = stats::median(&own.iter().map(|(s, _)| s.line.correlation.abs()).collect::<Vec<_>>());
            runs.push((index, stats::median(&slopes), r));
        }
    }
    let all: Vec<usize> = (0..campaign.runs.len()).collect();
    let explained = keep_throughout(campaign, &mut runs, |r| r.0, &all);
    let Some(&(first, ..)) = runs.first() else { return Vec::new() };
    let slope = stats::median(&runs.iter().map(|r| r.1).collect::<Vec<_>>());
    let r = stats::median(&runs.iter().map(|r| r.2).collect::<Vec<_>>());
    let channel = campaign.runs[first].record.inputs[0].channel.clone();
    let place = in_runs(campaign, &explained, campaign.runs.len());
    let sign = if slope < 0.0 { "-" } else { "" };
    let odd = !(1.0 / ODD_SLOPE..=ODD_SLOPE).contains(&slope.abs());
    let (problem, evidence, cure) = match probable(&channel, 1.0 / slope).filter(|_| odd) {
        Some((factor, name)) => (
            Problem::UnitFactor,
            format!(
                "every sensor shows {} times what the model makes of `{channel}` (correlation {r:.3}) {place}: {name}?",
                short(slope)
            ),
            format!(
                "divide `{channel}` by {sign}{}; its name says {}",
                short(factor),
                Unit::symbol_of(&channel)
            ),
        ),
        None if odd => (
            Problem::OddScale,
            format!(
                "every sensor shows {} times what the model makes of `{channel}` (correlation {r:.3}) {place}",
                short(slope)
            ),
            "compare the command's scale and the actuator's file with the rig".to_owned(),
        ),
        None => (
            Problem::FlippedSign,
            format!(
                "every sensor runs against the model with slope {slope:.2} (correlation -{r:.3}) {place}: the sign of `{channel}`?"
            ),
            format!("negate `{channel}`; a positive command drives every sensor to its positive side"),
        ),
    };
    found.extend(finding(problem, r, Severity::Stops, &channel, evidence, cure));
    explained
}
