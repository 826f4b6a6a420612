//! The residual's share in each frequency band.

use super::Region;
use crate::data::{Data, Evaluation};
use crate::resample;
use crate::stats;
use realfft::RealFftPlanner;

/// Inner limits of the bands, Hz: one, two, five, as far as the sampling reaches.
const LIMITS: [f64; 10] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];

/// Hands over the lines of the power spectrum of each block's residual on an even grid: frequency in Hz, part of the
/// sum of squares, and part of the samples (all the same in a block).
fn lines(parts: &[(&Data, &Evaluation)], mut take: impl FnMut(f64, f64, f64)) {
    let mut planner = RealFftPlanner::<f64>::new();
    for (data, at) in parts {
        for block in &at.blocks {
            let run = &data.runs[block.run];
            let time: Vec<f64> = run.rows().map(|i| run.record.time_s[i]).collect();
            let period = stats::median_period(&time);
            let mut even = resample::uniform(&time, &block.residual, period, false);
            if even.len() < 16 {
                continue;
            }
            // The block's weight is its own sum of squares, whatever the resampling did to it.
            let squares: f64 = block.residual.iter().map(|r| r * r).sum();
            let n = even.len();
            let fft = planner.plan_fft_forward(n);
            let mut spectrum = fft.make_output_vec();
            if fft.process(&mut even, &mut spectrum).is_err() {
                continue;
            }
            let lines: Vec<f64> = spectrum.iter().map(|c| c.norm_sqr()).collect();
            let total: f64 = lines.iter().sum();
            if total <= 0.0 {
                continue;
            }
            let share = block.residual.len() as f64 / lines.len() as f64;
            for (k, line) in lines.iter().enumerate() {
                take(k as f64 / (n as f64 * period), squares * line / total, share);
            }
        }
    }
}

/// Regions `a to b Hz`; a band's share of the samples is its share of the bandwidth.
pub(super) fn regions(parts: &[(&Data, &Evaluation)]) -> Vec<Region> {
    let mut power = vec![0.0; LIMITS.len() + 1];
    let mut width = vec![0.0; LIMITS.len() + 1];
    lines(parts, |hz, squares, share| {
        let band = LIMITS.partition_point(|&l| l <= hz);
        power[band] += squares;
        width[band] += share;
    });
    let (total, rows): (f64, f64) = (power.iter().sum(), width.iter().sum());
    if total <= 0.0 || rows <= 0.0 {
        return Vec::new();
    }
    (0..power.len())
        .filter(|&b| width[b] > 0.0)
        .map(|b| Region {
            axis: "frequency",
            place: String::new(),
            label: match (b.checked_sub(1).map(|i| LIMITS[i]), LIMITS.get(b)) {
                (None, Some(high)) => format!("below {high} Hz"),
                (Some(low), Some(high)) => format!("{low} to {high} Hz"),
                (Some(low), None) => format!("above {low} Hz"),
                (None, None) => "all".to_owned(),
            },
            sample_share: width[b] / rows,
            error_share: power[b] / total,
            error: (power[b] / width[b]).sqrt(),
            error_elsewhere: ((total - power[b]).max(0.0) / (rows - width[b]).max(1e-9)).sqrt(),
        })
        .collect()
}

/// Bins per octave in which a band is looked for.
const FINE: f64 = 12.0;

/// The narrowest band, as a ratio, that holds a share of the squared residual: its limits in Hz.
pub(super) fn narrowest(parts: &[(&Data, &Evaluation)], wanted: f64) -> Option<(f64, f64)> {
    let mut power = std::collections::BTreeMap::<i64, f64>::new();
    let mut total = 0.0;
    lines(parts, |hz, squares, _| {
        total += squares;
        if hz > 0.0 {
            *power.entry((FINE * hz.log2()).floor() as i64).or_default() += squares;
        }
    });
    let bins: Vec<(i64, f64)> = power.into_iter().collect();
    let mut best: Option<(i64, i64)> = None;
    let (mut from, mut sum) = (0, 0.0);
    for &(to, squares) in &bins {
        sum += squares;
        while sum - bins[from].1 >= wanted * total {
            sum -= bins[from].1;
            from += 1;
        }
        if sum >= wanted * total && best.is_none_or(|(a, b)| to - bins[from].0 < b - a) {
            best = Some((bins[from].0, to));
        }
    }
    best.map(|(a, b)| ((a as f64 / FINE).exp2(), ((b + 1) as f64 / FINE).exp2()))
}
