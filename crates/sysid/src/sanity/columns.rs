//! What the files show without a model: missing and repeated rows, spikes, runs without a role.

use super::pair::Line;
use super::units::short;
use super::{Finding, Problem, Severity, finding};
use crate::campaign::{Clock, Run};
use crate::{Campaign, Role};
use sealegs_model::Unit;

pub(super) fn look(campaign: &Campaign) -> Vec<Finding> {
    let mut found = Vec::new();
    found.extend(no_holdout(campaign));
    found.extend(missing_rows(campaign));
    found.extend(repeated_rows(campaign));
    found.extend(spikes(campaign));
    found.extend(echoes(campaign));
    found
}

/// Columns that are a straight line in the command in every run in which they move: a controller's estimate, or a copy.
fn echoes(campaign: &Campaign) -> Vec<Finding> {
    let echo = |noise: &crate::campaign::NoiseStd| {
        let channel = noise.channel.as_str();
        let of_run = |run: &Run| {
            let [input] = &run.record.inputs[..] else { return None };
            let output = run.record.output(channel)?;
            let line = Line::through(input.values.iter().copied().zip(output.iter().copied()));
            let left = (1.0 - line.correlation.powi(2)).max(0.0).sqrt();
            (line.measured > 0.0)
                .then(|| (1.0 / left.max(f64::MIN_POSITIVE), line.slope, input.channel.clone()))
        };
        let runs = campaign.runs.iter().filter_map(of_run);
        let least = runs.reduce(|a, b| if b.0 < a.0 { b } else { a })?;
        finding(
            Problem::EchoedCommand,
            least.0,
            Severity::Stops,
            channel,
            format!("`{channel}` is `{}` times {}, and no measurement", least.2, short(least.1)),
            "leave it out: it is a command, or was computed from one".to_owned(),
        )
    };
    campaign.noise.iter().filter_map(echo).collect()
}

fn no_holdout(campaign: &Campaign) -> Option<Finding> {
    let missing = campaign.require(Role::Holdout).is_err();
    finding(
        Problem::NoHoldout,
        f64::from(u8::from(missing)),
        Severity::Stops,
        "",
        format!("none of the {} runs has the role \"holdout\"", campaign.runs.len()),
        "hold one run out, best of another kind and amplitude".to_owned(),
    )
}

/// Rows that an even clock would have and the time column has not, and the longest gap: its length and where, s.
fn missing(run: &Run) -> (usize, usize, (f64, f64)) {
    let clock = &run.clock;
    // A clock that wanders has no row to miss before a step is a gap.
    let even = clock.jitter_s < 0.1 * clock.period_s;
    let least = if even { 1.5 } else { Clock::GAP };
    let (mut rows, mut places, mut longest) = (0, 0, (0.0, 0.0));
    for pair in run.record.time_s.windows(2) {
        let step = pair[1] - pair[0];
        if step > least * clock.period_s {
            rows += (step / clock.period_s).round() as usize - 1;
            places += 1;
            if step > longest.0 {
                longest = (step, pair[0]);
            }
        }
    }
    (rows, places, longest)
}

fn missing_rows(campaign: &Campaign) -> Option<Finding> {
    let of_runs: Vec<_> = campaign.runs.iter().map(|r| (missing(r), r)).filter(|(m, _)| m.0 > 0).collect();
    let rows: usize = of_runs.iter().map(|(m, _)| m.0).sum();
    let places: usize = of_runs.iter().map(|(m, _)| m.1).sum();
    let all: usize = campaign.runs.iter().map(|r| r.record.len()).sum();
    let ((_, _, (length, at)), run) = of_runs.iter().max_by(|a, b| a.0.2.0.total_cmp(&b.0.2.0))?;
    finding(
        Problem::MissingRows,
        rows as f64 / (all + rows) as f64,
        Severity::Stops,
        "time_s",
        format!(
            "{rows} rows are missing in {places} places, the longest gap {} s after {} s of {}",
            short(*length),
            short(*at),
            run.record.name
        ),
        "the command is held over a gap; where it went on the logger must not lose rows".to_owned(),
    )
}

fn repeated_rows(campaign: &Campaign) -> Option<Finding> {
    let rows: usize = campaign.runs.iter().map(|r| r.left_out.repeated.len()).sum();
    let all: usize = campaign.runs.iter().map(|r| r.record.len()).sum();
    let worst = campaign.runs.iter().map(|r| longest(&r.left_out.repeated)).max().unwrap_or(0);
    let share = rows as f64 / all.max(1) as f64;
    finding(
        Problem::RepeatedRows,
        share,
        Severity::Stops,
        "",
        format!(
            "{} % of the rows repeat the row before in every output column, up to {worst} in a row: they are left out",
            short(100.0 * share)
        ),
        "log at the rate at which the sensors are read".to_owned(),
    )
}

/// Most consecutive numbers among ascending ones.
fn longest(rows: &[usize]) -> usize {
    let mut most = 0;
    let mut length = 0;
    for (i, row) in rows.iter().enumerate() {
        length = if i > 0 && rows[i - 1] + 1 == *row { length + 1 } else { 1 };
        most = most.max(length);
    }
    most
}

fn spikes(campaign: &Campaign) -> Vec<Finding> {
    campaign
        .noise
        .iter()
        .filter_map(|noise| {
            let channel = noise.channel.as_str();
            let with = |r: &&Run| r.record.output(channel).is_some();
            let all: usize = campaign.runs.iter().filter(with).map(|r| r.record.len()).sum();
            let of_runs = campaign.runs.iter().flat_map(|r| &r.left_out.spikes);
            let of_runs: Vec<_> = of_runs.filter(|s| s.channel == channel).collect();
            let rows: usize = of_runs.iter().map(|s| s.rows.len()).sum();
            let size = crate::stats::median(&of_runs.iter().map(|s| s.size).collect::<Vec<_>>());
            let unit = Unit::symbol_of(channel);
            let share = rows as f64 / all.max(1) as f64;
            let (are, they) =
                if rows == 1 { ("row is a spike", "it is") } else { ("rows are spikes", "they are") };
            finding(
                Problem::Spikes,
                share,
                Severity::Stops,
                channel,
                format!(
                    "{rows} {are} of about {} {unit} ({} % of `{channel}`): {they} left out",
                    short(size),
                    short(100.0 * share)
                ),
                "look for a loose connector or a shared bus; nothing need be done for a diagnosis".to_owned(),
            )
        })
        .collect()
}
