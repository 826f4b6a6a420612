//! Angles and positions beside the columns of their own rates, without a model: units, signs, and angles that begin again.

use super::against::FOLLOWS;
use super::pair::Line;
use super::units::{probable, short};
use super::{Finding, Problem, Severity, finding};
use crate::campaign::{Clock, Run};
use crate::{Campaign, Role};
use sealegs_model::Unit;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Columns that are a quantity and its rate, at the output of a bench and at a joint.
const RATES: [(&str, &str); 3] =
    [("joint_angle_rad", "speed_rad_s"), ("position_m", "speed_m_s"), ("angle_rad", "speed_rad_s")];

/// Rows over which a rate is summed: an encoder's steps average out, and a filter of a few rows does not matter.
const ROWS: usize = 20;

/// Share of a turn by which a step may miss it.
const NEAR_A_TURN: f64 = 0.05;

/// Share of a turn that the steps on either side must not reach: a shaft that really turns so fast has great steps there, too.
const AT_REST: f64 = 0.2;

pub(super) fn look(campaign: &Campaign) -> Vec<Finding> {
    let mut found = wraps(campaign);
    // What jumps by a turn has no rate.
    let jumps = |channel: &str| found.iter().any(|f| f.channel == channel);
    let pairs: Vec<(String, String)> =
        pairs(campaign).into_iter().filter(|(quantity, _)| !jumps(quantity)).collect();
    for (quantity, rate) in pairs {
        found.extend(off_scale(campaign, &quantity, &rate));
    }
    found
}

/// Every output column of a campaign's runs.
fn channels(campaign: &Campaign) -> BTreeSet<&str> {
    campaign.runs.iter().flat_map(|run| &run.record.outputs).map(|s| s.channel.as_str()).collect()
}

/// The columns of a campaign that are a quantity and its rate.
fn pairs(campaign: &Campaign) -> Vec<(String, String)> {
    let all = channels(campaign);
    let with_rate = |channel: &&str| {
        let (place, own) = channel.rsplit_once('.').map_or(("", *channel), |(place, own)| (place, own));
        let (_, rate) = RATES.iter().find(|(quantity, _)| *quantity == own)?;
        let rate = if place.is_empty() { (*rate).to_owned() } else { format!("{place}.{rate}") };
        all.contains(rate.as_str()).then(|| ((*channel).to_owned(), rate))
    };
    all.iter().filter_map(with_rate).collect()
}

/// The column that is a column's rate, or of which it is the rate, where the two agree in every run.
pub(super) fn agreeing(campaign: &Campaign, channel: &str) -> Option<String> {
    let is_of = |(quantity, rate): &(String, String)| quantity == channel || rate == channel;
    let (quantity, rate) = pairs(campaign).into_iter().find(is_of)?;
    let agree = |run: &Run| {
        let moved = increments(run, &quantity, &rate);
        moved.is_some_and(|moved| Line::through(moved.into_iter()).correlation > FOLLOWS)
    };
    campaign.runs.iter().all(agree).then(|| if channel == quantity { rate } else { quantity })
}

/// A rate in another unit than its quantity's, or against it.
fn off_scale(campaign: &Campaign, quantity: &str, rate: &str) -> Option<Finding> {
    let moved = campaign.runs.iter().filter_map(|run| increments(run, quantity, rate)).flatten();
    let line = Line::through(moved);
    if line.slope < 0.0 {
        let near = (1.0 / 3.0..3.0).contains(&-line.slope);
        return finding(
            Problem::FlippedSign,
            if near { -line.correlation } else { 0.0 },
            Severity::Stops,
            rate,
            format!(
                "`{rate}` runs against the increase of `{quantity}` with slope {}: sign?",
                short(line.slope)
            ),
            "turn the sign of one of the two in [columns] (sign = -1)".to_owned(),
        );
    }
    let (_, unit) = probable(rate, line.slope)?;
    finding(
        Problem::UnitFactor,
        line.correlation,
        Severity::Stops,
        rate,
        format!(
            "`{rate}` is {} times the rate at which `{quantity}` increases: in {unit}?",
            short(line.slope)
        ),
        format!(
            "state the unit of `{rate}`, or that of `{quantity}`, in [columns] (unit = …); a motor's speed before its gear \
             needs scale = 1/ratio"
        ),
    )
}

/// What a quantity increases by over some rows, and what its rate sums up to.
fn increments(run: &Run, quantity: &str, rate: &str) -> Option<Vec<(f64, f64)>> {
    let (quantity, rate) = (run.record.output(quantity)?, run.record.output(rate)?);
    let time = &run.record.time_s;
    let longest = ROWS as f64 * Clock::GAP * run.clock.period_s;
    let ends = (0..time.len()).step_by(ROWS).collect::<Vec<_>>();
    let of = |pair: &[usize]| {
        let (from, to) = (pair[0], pair[1]);
        let summed: f64 = (from..to).map(|i| 0.5 * (rate[i] + rate[i + 1]) * (time[i + 1] - time[i])).sum();
        let both = (quantity[to] - quantity[from], summed);
        (time[to] - time[from] < longest && both.0.is_finite() && both.1.is_finite()).then_some(both)
    };
    Some(ends.windows(2).filter_map(of).collect())
}

/// Angles that jump by a turn from one row to the next, and positions whose counter begins again.
fn wraps(campaign: &Campaign) -> Vec<Finding> {
    let of = |channel: &str| {
        let is_angle = channel.ends_with("angle_rad");
        let with = |jumps: fn(&[f64]) -> Vec<usize>| -> Vec<(&Run, usize)> {
            let columns = campaign.runs.iter().filter_map(|run| Some((run, run.record.output(channel)?)));
            columns.flat_map(|(run, values)| jumps(values).into_iter().map(move |row| (run, row))).collect()
        };
        let of_turns = if is_angle { with(jumps) } else { Vec::new() };
        let by_turns = !of_turns.is_empty();
        let jumps = if by_turns { of_turns } else { with(overflows) };
        let (run, row) = jumps.first()?;
        let values = run.record.output(channel)?;
        let size = (values[*row] - values[row - 1]).abs();
        let (by, cure) = match by_turns {
            true => (
                "a turn".to_owned(),
                "its encoder begins again after a turn: map the column with wrap = true",
            ),
            false => (
                format!("{} {}", short(size), Unit::symbol_of(channel)),
                "its counter begins again: map the column with wrap = its counts (65536 of 16 bits), in the file's own unit",
            ),
        };
        let role = if run.role == Role::Fit { "fit" } else { "held-out" };
        finding(
            Problem::Wraps,
            jumps.len() as f64,
            Severity::Stops,
            channel,
            format!(
                "`{channel}` jumps by {by} from one row to the next in {} places, first at {} s of {} ({role})",
                jumps.len(),
                short(run.record.time_s[*row]),
                run.record.name
            ),
            cure.to_owned(),
        )
    };
    let counted = |channel: &&str| channel.ends_with("angle_rad") || channel.ends_with("position_m");
    channels(campaign).into_iter().filter(counted).filter_map(of).collect()
}

/// Rows before which a position jumps by as much as all of its range, against its motion, which goes on as before: a counter that is
/// full.
fn overflows(values: &[f64]) -> Vec<usize> {
    let step = |i: usize| values[i] - values[i - 1];
    let size = (1..values.len()).map(|i| step(i).abs()).fold(0.0, f64::max);
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let within = size > (1.0 - NEAR_A_TURN) * (high - low);
    let is_jump = |&i: &usize| {
        let goes_on = |j: usize| step(j) * step(i) < 0.0 && step(j).abs() < AT_REST * size;
        step(i).abs() > (1.0 - NEAR_A_TURN) * size && goes_on(i - 1) && goes_on(i + 1)
    };
    match within {
        true => (2..values.len().saturating_sub(1)).filter(is_jump).collect(),
        false => Vec::new(),
    }
}

/// Rows before which an angle jumps by a turn while it hardly moves on either side.
fn jumps(angle: &[f64]) -> Vec<usize> {
    let step = |i: usize| (angle[i] - angle[i - 1]).abs();
    let rests = |i: usize| i == 0 || i >= angle.len() || step(i) < AT_REST * TAU;
    let is_jump = |&i: &usize| (step(i) - TAU).abs() < NEAR_A_TURN * TAU && rests(i - 1) && rests(i + 1);
    (1..angle.len()).filter(is_jump).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{campaign, run};
    use sealegs_model::Signal;

    /// A run with an angle and a rate beside the toy's columns, by time.
    fn with(angle: impl Fn(f64) -> f64, rate: impl Fn(f64) -> f64) -> Campaign {
        let noise = (0.2, 0.001);
        let mut campaign =
            campaign(vec![(Role::Fit, run(&[1.0, 4.0, 400.0], 2000, 3, noise, (1.0, 0.0), 1.0))], noise);
        let record = &mut campaign.runs[0].record;
        let column = |channel: &str, of: &dyn Fn(f64) -> f64| Signal {
            channel: channel.to_owned(),
            values: record.time_s.iter().map(|t| of(*t)).collect(),
        };
        let columns = [column("knee.angle_rad", &angle), column("knee.speed_rad_s", &rate)];
        record.outputs.extend(columns);
        campaign
    }

    fn found(angle: impl Fn(f64) -> f64, rate: impl Fn(f64) -> f64) -> Vec<(Problem, bool, String)> {
        let found = look(&with(angle, rate)).into_iter();
        found.map(|f| (f.problem, f.stops(), f.evidence)).collect()
    }

    #[test]
    fn a_rate_in_another_unit_or_against_its_angle_is_said() {
        let (angle, rate) = (|t: f64| 2.0 * (3.0 * t).sin(), |t: f64| 6.0 * (3.0 * t).cos());
        assert_eq!(found(angle, rate), []);
        // A load that is a tenth off is no unit.
        assert_eq!(found(angle, |t| 1.1 * rate(t)), []);
        let rpm = found(angle, |t| rate(t) * 30.0 / std::f64::consts::PI);
        let [(Problem::UnitFactor, true, said)] = &rpm[..] else { panic!("{rpm:?}") };
        assert!(
            said.contains("`knee.speed_rad_s` is 9.5") && said.contains("revolutions a minute"),
            "{said}"
        );
        let flipped = found(angle, |t| -rate(t));
        assert!(matches!(&flipped[..], [(Problem::FlippedSign, true, _)]), "{flipped:?}");
        // What is no rate at all is no fault of a unit.
        assert_eq!(found(angle, |t| 300.0 * (17.0 * t).sin()), []);
    }

    #[test]
    fn an_angle_that_begins_again_is_said_and_one_that_turns_fast_is_not() {
        let wrapped = |t: f64| (2.0 * t + 1.0).rem_euclid(TAU);
        let said = found(wrapped, |_| 2.0);
        let [(Problem::Wraps, true, evidence)] = &said[..] else { panic!("{said:?}") };
        assert!(evidence.contains("in 3 places, first at 2.6"), "{evidence}");
        // A counter of 16 bits of a motor, and steps of a servo from one end to the other, which rests there.
        let full = found(|t| (30.0 * (t - 1.0)).rem_euclid(201.0), |_| 30.0);
        let [(Problem::Wraps, true, evidence)] = &full[..] else { panic!("{full:?}") };
        assert!(evidence.contains("jumps by 201 rad"), "{evidence}");
        assert_eq!(found(|t| if t.rem_euclid(2.0) < 1.0 { 0.0 } else { 1.5 }, |_| 0.0), []);
        // A turn a row, which a logger of 200 Hz sees of a motor at 12 000 rpm.
        assert_eq!(found(|t| 200.0 * TAU * t, |_| 200.0 * TAU), []);
    }
}
