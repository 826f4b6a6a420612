//! Periods of effects that repeat along the screw or with the rotor, read off the missing force, and frequencies of
//! resonances, read off what is left: between two periods that
//! differ by more than half a wave along the travel no fit finds its way, and simulating every one of them costs more than all
//! other effects.

use crate::data::Data;
use crate::diagnose::Candidate;
use crate::diagnose::missing::{Missing, ports};
use crate::diagnose::policy::{
    CYCLES, LOWEST_HZ, PERIOD_ROWS, PERIODS, RESONANCES, RESONANCES_APART, WAVES_APART,
};
use rayon::prelude::*;
use sealegs_model::{EffectCard, Parameter, internal};
use std::f64::consts::TAU;

/// The parameter that says where an effect resonates.
pub(crate) const RESONANCE: &str = "frequency_hz";

/// The card with starting periods where the missing force at the rotor has the most power along the screw; where a simulation
/// is dear it keeps those of its starting cycles per turn of the rotor that have most power. As it is where the effect has
/// neither, or no observer shows what is missing. A resonance starts where what is left has the most power, too: beside its
/// own width nothing leads to it.
pub(crate) fn with_periods(data: &Data, observed: &Candidate, card: &EffectCard) -> EffectCard {
    let dear = observed.model.is_dear();
    let mut card = card.clone();
    let place = card.id.rsplit_once('/').map_or("", |(place, _)| place).to_owned();
    let rotor = || {
        let at = &observed.fit.evaluation;
        ports(data, &at.predictions).into_iter().find(|m| m.place == place && m.port == "rotor")
    };
    for p in &mut card.parameters {
        if p.name == RESONANCE && !dear {
            p.starts.extend(loudest(data, observed, (p.min, p.max)));
        } else if p.name.starts_with(EffectCard::PERIOD)
            && let Some(missing) = rotor()
        {
            let found = strongest(&along(data, observed, &missing, internal::SCREW_POSITION), p);
            if let Some(first) = found.first() {
                (p.value, p.starts) = (*first, found);
            }
        } else if p.name == EffectCard::CYCLES
            && dear
            && let Some(missing) = rotor()
        {
            let rows = along(data, observed, &missing, internal::ROTOR_ANGLE);
            let power = powers(&rows, &p.starts.iter().map(|cycles| cycles / TAU).collect::<Vec<_>>());
            let mut order: Vec<usize> = (0..power.len()).collect();
            order.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
            order.truncate(CYCLES as usize);
            let kept: Vec<f64> = order.into_iter().map(|i| p.starts[i]).collect();
            if let Some(first) = kept.first() {
                (p.value, p.starts) = (*first, kept);
            }
        }
    }
    card
}

/// The frequencies between two bounds at which what a candidate leaves has the most power, in noise units, the loudest first.
fn loudest(data: &Data, candidate: &Candidate, (lowest, highest): (f64, f64)) -> Vec<f64> {
    let blocks: Vec<(Vec<f64>, &[f64])> = candidate
        .fit
        .evaluation
        .blocks
        .iter()
        .map(|b| {
            let run = &data.runs[b.run];
            (run.rows().map(|i| run.record.time_s[i]).collect(), &b.residual[..])
        })
        .collect();
    let periods = data.runs.iter().map(|run| run.record.mean_period_s());
    let nyquist = 0.5 / periods.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let (first, last) = (lowest.max(LOWEST_HZ), highest.min(nyquist));
    if first >= last {
        return Vec::new();
    }
    let steps = ((last / first).ln() / RESONANCES_APART.ln()).ceil() as i32;
    let all: Vec<f64> = (0..=steps).map(|i| first * RESONANCES_APART.powi(i)).collect();
    let power = |hz: &f64| -> f64 {
        let of_block = |(time, residual): &(Vec<f64>, &[f64])| {
            let (mut sin_sum, mut cos_sum) = (0.0, 0.0);
            for (t, r) in time.iter().zip(*residual) {
                let (sin, cos) = (TAU * hz * t).sin_cos();
                sin_sum += r * sin;
                cos_sum += r * cos;
            }
            sin_sum * sin_sum + cos_sum * cos_sum
        };
        blocks.iter().map(of_block).sum()
    };
    let power: Vec<f64> = all.par_iter().map(power).collect();
    peaks(&power).into_iter().take(RESONANCES as usize).map(|i| all[i]).collect()
}

/// The places of local maxima, the greatest first.
pub(crate) fn peaks(power: &[f64]) -> Vec<usize> {
    let at = |i: usize| power.get(i).copied().unwrap_or(0.0);
    let mut peaks: Vec<usize> =
        (0..power.len()).filter(|&i| at(i) > at(i + 1) && (i == 0 || at(i) >= at(i - 1))).collect();
    peaks.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
    peaks
}

/// A row of the missing force along the screw, or over the rotor's angle.
struct Row {
    position: f64,
    /// The missing force, and that times the direction of motion: a friction turns round with it.
    force: [f64; 2],
}

/// The missing force over an internal signal, less its means over each of both directions of motion.
fn along(data: &Data, observed: &Candidate, missing: &Missing, over: &str) -> Vec<Row> {
    let predictions = &observed.fit.evaluation.predictions;
    let total: usize = missing.runs.iter().map(Vec::len).sum();
    let every = (total as f64 / PERIOD_ROWS).ceil().max(1.0) as usize;
    let mut rows: Vec<(f64, f64, f64)> = Vec::new();
    for ((run, prediction), force) in data.runs.iter().zip(predictions).zip(&missing.runs) {
        let of = |name| prediction.internal_at(&missing.place, name).unwrap_or(&[]);
        let (position, speed) = (of(over), of(internal::SCREW_SPEED));
        let scored: Vec<usize> = run.rows().collect();
        for (at, force) in scored.chunks(every).zip(force.chunks(every)) {
            let middle = at[at.len() / 2];
            if let (Some(y), Some(v)) = (position.get(middle), speed.get(middle)) {
                rows.push((*y, v.signum(), force.iter().sum::<f64>() / force.len() as f64));
            }
        }
    }
    let mean = |direction: f64| {
        let of = || rows.iter().filter(move |r| r.1 == direction).map(|r| r.2);
        of().sum::<f64>() / of().count().max(1) as f64
    };
    let (forth, back) = (mean(1.0), mean(-1.0));
    rows.iter()
        .map(|&(position, direction, force)| {
            let left = force - if direction > 0.0 { forth } else { back };
            Row { position, force: [left, left * direction] }
        })
        .collect()
}

/// The length of a travel, and waves along it in even steps between a period's least and greatest start: a part of a wave
/// turns a crest into a trough at the far end. `None` where nothing moves.
pub(crate) fn waves_along(
    positions: impl Iterator<Item = f64>,
    period: &Parameter,
) -> Option<(f64, Vec<f64>)> {
    let (low, high) = extent(positions);
    let (shortest, longest) = extent(period.starts.iter().copied().chain([period.value]));
    let travel = high - low;
    if travel.is_nan() || travel <= 0.0 || shortest <= 0.0 {
        return None;
    }
    let (first, last) = (travel / longest, travel / shortest);
    let steps = ((last - first) / WAVES_APART).ceil() as usize;
    Some((travel, (0..=steps).map(|i| first + WAVES_APART * i as f64).collect()))
}

/// Least and greatest of some values.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The periods at which the force has most power, the strongest first.
fn strongest(rows: &[Row], period: &Parameter) -> Vec<f64> {
    let Some((travel, waves)) = waves_along(rows.iter().map(|r| r.position), period) else {
        return Vec::new();
    };
    let power = powers(rows, &waves.iter().map(|waves| waves / travel).collect::<Vec<_>>());
    peaks(&power).into_iter().take(PERIODS as usize).map(|i| travel / waves[i]).collect()
}

/// The power of the force, or of it times the direction of motion, in waves of so many per unit of the position.
fn powers(rows: &[Row], waves: &[f64]) -> Vec<f64> {
    let power = |waves: &f64| {
        let mut sums = [[0.0; 2]; 2];
        for row in rows {
            let (sin, cos) = (TAU * waves * row.position).sin_cos();
            for (sum, force) in sums.iter_mut().zip(row.force) {
                sum[0] += force * sin;
                sum[1] += force * cos;
            }
        }
        sums.iter().map(|s| s[0] * s[0] + s[1] * s[1]).fold(0.0, f64::max)
    };
    waves.par_iter().map(power).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_period_of_a_friction_along_many_waves_is_found() {
        // Sixty waves along a travel of 0.12 that a slow motion goes up and down: a friction, and a much greater slow force.
        let rows: Vec<Row> = (0..8000)
            .map(|i| {
                let phase = f64::from(i) * TAU / 3000.0;
                let (position, direction) = (0.06 * phase.sin(), phase.cos().signum());
                let friction = direction * (TAU * position / 0.002).cos();
                let force = friction + 3.0 * (0.3 * phase).sin();
                Row { position, force: [force, force * direction] }
            })
            .collect();
        let mut period = Parameter::new("period_m", "m", 0.01, 0.0005, 0.48);
        period.starts = vec![0.0005, 0.48];
        let found = strongest(&rows, &period);
        assert!(found.iter().any(|p| (p / 0.002 - 1.0).abs() < 2e-3), "{found:?}");
    }

    #[test]
    fn waves_are_a_quarter_apart_between_the_extreme_starts() {
        let mut period = Parameter::new("period_m", "m", 0.02, 0.001, 1.0);
        period.starts = vec![0.01, 0.08];
        let (travel, waves) = waves_along([0.1, 0.02, 0.14].into_iter(), &period).expect("it moves");
        assert!((travel - 0.12).abs() < 1e-15);
        assert_eq!(waves.first().copied(), Some(travel / 0.08));
        assert!((0.12 / 0.01..0.12 / 0.01 + 0.25).contains(waves.last().expect("some")));
        assert!(waves.windows(2).all(|w| (w[1] - w[0] - 0.25).abs() < 1e-12));
        assert!(waves_along([0.1, 0.1].into_iter(), &period).is_none());
    }

    #[test]
    fn analytic_peaks_are_local_maxima_with_the_greatest_first() {
        assert_eq!(peaks(&[3.0, 1.0, 2.0, 5.0, 4.0, 4.5]), [3, 5, 0]);
    }
}
