//! The noise of each output column: stated in the campaign file, or estimated from the columns.
//!
//! # Estimate
//!
//! Sixth differences `x0 - 6 x1 + 15 x2 - 20 x3 + 15 x4 - 6 x5 + x6` remove what is smooth over seven samples and leave
//! white noise with the variance `924 sigma^2`. Lower orders keep more of the motion: of an arm that is logged at 100 Hz and
//! moves at 2 Hz, third differences of samples 40 ms apart show more motion than the noise of a hobby servo's encoder.
//! Their root mean square over windows of [`WINDOW`] samples is taken where it is low (the lower quartile over the windows),
//! because motion only adds to it. Two things hide noise from differences, and each puts a floor under the estimate:
//!
//! - a quantised sensor at rest shows no difference at all: its error is `q / sqrt(12)` for a quantum `q`;
//! - a slow or over-sampled sensor has noise that is alike from sample to sample. Differences of samples
//!   several steps apart see it, so that the widest of a few spacings wins where it agrees with a flat
//!   stretch of the record; and repeats of a run see it whole, together with everything else that does
//!   not repeat. The latter is reported as [`RepeatPair`], and never taken for sensor noise.
//!
//! Rows that repeat the one before, and spikes, are left out first: the former have no difference, the latter one of
//! their own. Where fit runs have the column, they alone are asked: nothing of a holdout run is known before it judges.

use super::{Role, Run};
use crate::stats;
use rayon::prelude::*;
use sealegs_model::{SIXTH_POWER, sixth_differences};

/// Samples in a window of the estimate.
const WINDOW: usize = 64;

/// Lower quartile of the root mean square of sixth differences of white noise over windows of [`WINDOW`], as a share of the
/// noise's own: 0.887, 0.886 and 0.889 at spacings 1, 2 and 4 on 200 000 samples.
const QUARTILE: f64 = 0.887;

/// Where a noise standard deviation came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseOrigin {
    /// The campaign file states it.
    Stated,
    /// From differences of neighbouring samples.
    Differences,
    /// Half a quantum's error, `q / sqrt(12)`: nothing smaller is visible.
    Quantum,
}

/// The noise of one output column.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseStd {
    /// The column.
    pub channel: String,
    /// One standard deviation, in the column's unit: what residuals are divided by.
    pub std: f64,
    /// Where it came from.
    pub origin: NoiseOrigin,
    /// What the differences say, for comparison with what is stated.
    pub from_differences: f64,
    /// The sensor's quantum, if its values lie on a grid that is coarser than the noise.
    pub quantum: Option<f64>,
}

/// Two runs with the same input, and what differs between their outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct RepeatPair {
    /// Indices of the two runs in the campaign.
    pub runs: (usize, usize),
    /// The output column.
    pub channel: String,
    /// Root mean square of half their difference times sqrt(2), the mean of the difference removed (it
    /// is an error of tare): one run's own deviation, in the column's unit.
    pub deviation: f64,
    /// The mean that was removed, in the column's unit.
    pub offset: f64,
}

/// Noise of every known output column, in the order of first appearance.
pub(super) fn of_runs(runs: &[Run], stated: &[(String, f64)]) -> Vec<NoiseStd> {
    let mut channels: Vec<&str> = Vec::new();
    for signal in runs.iter().flat_map(|r| &r.record.outputs) {
        if !channels.contains(&signal.channel.as_str()) {
            channels.push(&signal.channel);
        }
    }
    channels
        .into_par_iter()
        .map(|channel| {
            let of = |role: Option<Role>| -> Vec<Vec<f64>> {
                let asked = runs.iter().filter(|r| role.is_none_or(|role| role == r.role));
                asked.filter_map(|r| Some(r.left_out.fresh(channel, r.record.output(channel)?))).collect()
            };
            let fitted = of(Some(Role::Fit));
            let columns = if fitted.is_empty() { of(None) } else { fitted };
            let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let from_differences = by_differences(&slices);
            let quantum = columns.iter().filter_map(|c| quantum(c)).reduce(f64::min);
            let floor = quantum.map_or(0.0, |q| q / 12f64.sqrt());
            let peak = columns.iter().flat_map(|c| c.iter()).fold(0.0f64, |p, v| p.max(v.abs()));
            let (std, origin) = match stated.iter().find(|(c, _)| c == channel) {
                Some(&(_, std)) => (std, NoiseOrigin::Stated),
                None if from_differences > floor => (from_differences, NoiseOrigin::Differences),
                // A constant column has neither noise nor quantum; any small positive number will do.
                None => (floor.max(1e-9 * peak).max(f64::MIN_POSITIVE.sqrt()), NoiseOrigin::Quantum),
            };
            let visible = quantum.filter(|q| q / 12f64.sqrt() > 0.2 * std);
            NoiseStd { channel: channel.to_owned(), std, origin, from_differences, quantum: visible }
        })
        .collect()
}

/// The standard deviation of white noise that sixth differences show where they are quiet.
pub(super) fn by_differences(columns: &[&[f64]]) -> f64 {
    let spacing_estimate = |spacing: usize| {
        let mut windows = Vec::new();
        for column in columns {
            let d: Vec<f64> = sixth_differences(column, spacing).collect();
            windows
                .extend(d.chunks(WINDOW).filter(|w| w.len() == WINDOW || d.len() < WINDOW).map(stats::rms));
        }
        stats::quantile(&windows, 0.25) / SIXTH_POWER.sqrt() / QUARTILE
    };
    let near = spacing_estimate(1);
    // Slow noise shows at wider spacings, and so does motion: only a modest rise is believed.
    [2, 4].into_iter().map(spacing_estimate).filter(|&wide| wide < 2.0 * near).fold(near, f64::max)
}

/// The grid on which a column's values lie: the smallest step between different values, if (nearly) all
/// steps are whole multiples of it.
#[must_use]
pub fn quantum(values: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|&s| s > 0.0).collect();
    if steps.len() < 8 {
        return None;
    }
    let peak = values.iter().fold(0.0f64, |p, v| p.max(v.abs()));
    let smallest = steps.iter().copied().filter(|&s| s > 1e-12 * peak).fold(f64::INFINITY, f64::min);
    // The digits of the file blur a quantum: average the steps that are one quantum long.
    let single: Vec<f64> = steps.iter().copied().filter(|&s| s < 1.5 * smallest).collect();
    let q = stats::mean(&single);
    let off_grid = steps.iter().filter(|&&s| s < 20.0 * q && (s / q - (s / q).round()).abs() > 0.1).count();
    (smallest.is_finite() && (off_grid as f64) < 0.02 * steps.len() as f64).then_some(q)
}

/// Pairs of runs whose inputs are the same function of time.
pub(super) fn repeats(runs: &[Run]) -> Vec<RepeatPair> {
    let mut pairs = Vec::new();
    for a in 0..runs.len() {
        for b in a + 1..runs.len() {
            if alike(&runs[a], &runs[b]) {
                pairs.extend(difference(runs, a, b));
            }
        }
    }
    pairs
}

/// Whether the inputs differ by less than 3 % (rms) of their own size on the time that both scored parts
/// cover, and the rest of the runs is short.
fn alike(a: &Run, b: &Run) -> bool {
    let (ra, rb) = (&a.record, &b.record);
    let (Some(ia), Some(ib)) = (ra.inputs.first(), rb.inputs.first()) else { return false };
    // One recording that `from_s` and `to_s` cut into runs is no repeat of itself; noise makes any other one different.
    if ra.time_s == rb.time_s && ra.outputs == rb.outputs {
        return false;
    }
    let (sa, sb) = (stats::rms(&ia.values), stats::rms(&ib.values));
    // A leg from another height, or another weight, is another experiment, whatever its input; so is another unit.
    if a.scenario != b.scenario
        || a.unit != b.unit
        || a.rig != b.rig
        || ia.channel != ib.channel
        || sa == 0.0
        || (sa / sb - 1.0).abs() > 0.05
        || (a.clock.duration_s / b.clock.duration_s - 1.0).abs() > 0.05
    {
        return false;
    }
    let (mut sum, mut count) = (0.0, 0.0);
    for i in a.counted().into_iter().flatten() {
        if let Some(other) = crate::resample::at(&rb.time_s, &ib.values, ra.time_s[i]) {
            sum += (other - ia.values[i]).powi(2);
            count += 1.0;
        }
    }
    count > 0.9 * a.counted().iter().map(std::ops::Range::len).sum::<usize>() as f64
        && (sum / count).sqrt() < 0.03 * sa
}

/// What differs between the outputs of two such runs.
fn difference(runs: &[Run], a: usize, b: usize) -> Vec<RepeatPair> {
    let (ra, rb) = (&runs[a].record, &runs[b].record);
    let mut pairs = Vec::new();
    for signal in &ra.outputs {
        let Some(other) = rb.output(&signal.channel) else { continue };
        let spikes = runs[b].left_out.rows();
        let d: Vec<f64> = runs[a]
            .counted()
            .into_iter()
            .flatten()
            .filter(|&i| !beside(&spikes, &rb.time_s, ra.time_s[i]))
            .filter_map(|i| Some(signal.values[i] - crate::resample::at(&rb.time_s, other, ra.time_s[i])?))
            .collect();
        pairs.push(RepeatPair {
            runs: (a, b),
            channel: signal.channel.clone(),
            deviation: stats::std(&d) / 2f64.sqrt(),
            offset: stats::mean(&d),
        });
    }
    pairs
}

/// Whether one of two neighbouring rows around a time is among these.
fn beside(rows: &[usize], time_s: &[f64], t: f64) -> bool {
    let after = time_s.partition_point(|&x| x < t);
    rows.binary_search(&after).is_ok() || after.checked_sub(1).is_some_and(|k| rows.binary_search(&k).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::Noise;

    #[test]
    fn white_noise_on_a_slow_signal_is_estimated_within_a_tenth() {
        let mut noise = Noise::new(1);
        let values: Vec<f64> =
            (0..4000).map(|i| 50.0 * (f64::from(i) * 0.02).sin() + 2.0 * noise.normal()).collect();
        let std = by_differences(&[&values]);
        assert!((std / 2.0 - 1.0).abs() < 0.1, "{std}");
    }

    #[test]
    fn the_motion_of_a_slowly_logged_joint_is_not_taken_for_noise() {
        let mut noise = Noise::new(3);
        // 0.4 rad at 0.5 Hz and 0.15 rad at 1.5 Hz, logged at 100 Hz, with the noise of an encoder of 4096 counts.
        let values: Vec<f64> = (0..6000)
            .map(|i| {
                let turn = std::f64::consts::TAU * 0.01 * f64::from(i);
                0.4 * (0.5 * turn).sin() + 0.15 * (1.5 * turn).cos() + 4.4e-4 * noise.normal()
            })
            .collect();
        let std = by_differences(&[&values]);
        assert!((std / 4.4e-4 - 1.0).abs() < 0.05, "{std}");
    }

    #[test]
    fn noise_that_is_alike_from_sample_to_sample_is_seen_at_wider_spacings() {
        let mut noise = Noise::new(6);
        let mut state = 0.0;
        // A first-order lag of two samples; the stationary standard deviation is 1.
        let keep = (-0.5f64).exp();
        let values: Vec<f64> = (0..8000)
            .map(|_| {
                state = keep * state + (1.0 - keep * keep).sqrt() * noise.normal();
                state
            })
            .collect();
        let std = by_differences(&[&values]);
        assert!((0.85..1.1).contains(&std), "{std}");
    }

    #[test]
    fn a_quantised_sensor_shows_its_quantum() {
        let q = std::f64::consts::TAU / 4096.0;
        let values: Vec<f64> = (0..4000)
            .map(|i| {
                let x = 0.3 * (f64::from(i) * 0.001).sin();
                // Six digits, as a file would have them.
                ((x / q).round() * q * 1e6).round() / 1e6
            })
            .collect();
        let found = quantum(&values).unwrap();
        assert!((found / q - 1.0).abs() < 2e-3, "{found} {q}");
        let mut noise = Noise::new(2);
        let continuous: Vec<f64> = (0..400).map(|_| noise.normal()).collect();
        assert_eq!(quantum(&continuous), None);
    }

    #[test]
    fn a_coarse_encoder_has_the_error_of_its_count_at_rest_and_in_motion() {
        let q = std::f64::consts::TAU / 128.0;
        for speed in [0.0003, 0.002, 0.05] {
            let values: Vec<f64> =
                (0..6000).map(|i| ((2.0 * (f64::from(i) * speed).sin()) / q).round() * q).collect();
            let run = run_of(vec![("motor_angle_rad", values)]);
            let noise = &of_runs(&[run], &[])[0];
            let ratio = noise.std / (q / 12f64.sqrt());
            // In motion neighbouring errors are independent, and the differences see them a little wide.
            assert!((0.99..1.4).contains(&ratio), "{speed}: {ratio}");
            assert!((noise.quantum.unwrap() / q - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn repeated_rows_and_spikes_do_not_hide_the_noise() {
        let mut noise = Noise::new(9);
        let mut values: Vec<f64> =
            (0..8000).map(|i| 50.0 * (f64::from(i) * 0.002).sin() + 2.0 * noise.normal()).collect();
        // A sensor that is read every fifth row, and off now and then.
        for i in 0..values.len() {
            let glitch = if i % 300 == 30 { 400.0 } else { 0.0 };
            values[i] = if i % 5 == 0 { values[i] + glitch } else { values[i - i % 5] };
        }
        let naive = by_differences(&[&values]);
        assert!(naive < 1.5, "most of the rows are no news: {naive}");
        let run = run_of(vec![("force_1_n", values)]);
        assert_eq!((run.left_out.repeated.len(), run.left_out.spikes[0].rows.len()), (6400, 27));
        let found = &of_runs(&[run], &[])[0];
        assert!((found.std / 2.0 - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn a_holdout_run_says_nothing_of_the_noise_where_a_fit_run_does() {
        let mut noise = Noise::new(4);
        let mut column = |std: f64| (0..2000).map(|_| std * noise.normal()).collect::<Vec<f64>>();
        let fit = run_of(vec![("force_1_n", column(2.0))]);
        let holdout = Run { role: Role::Holdout, ..run_of(vec![("force_1_n", column(0.1))]) };
        let alone = of_runs(std::slice::from_ref(&fit), &[]);
        assert_eq!(of_runs(&[fit, holdout], &[]), alone);
    }

    #[test]
    fn a_recording_that_is_cut_into_two_runs_is_no_repeat_of_itself() {
        let mut noise = Noise::new(5);
        let input: Vec<f64> = (0..2000).map(|i| (0.02 * f64::from(i)).sin()).collect();
        let mut recorded = || {
            let mut run =
                run_of(vec![("force_1_n", input.iter().map(|u| 9.0 * u + noise.normal()).collect())]);
            run.record
                .inputs
                .push(sealegs_model::Signal { channel: "current_a".into(), values: input.clone() });
            run
        };
        let (once, again) = (recorded(), recorded());
        let found = repeats(&[once.clone(), again]);
        // Two recordings of unit noise: each deviates by 1 N.
        assert!(found.len() == 1 && (found[0].deviation - 1.0).abs() < 0.05, "{found:?}");
        let (first, last) = (Run { scored: 0..1000, ..once.clone() }, Run { scored: 1000..2000, ..once });
        assert_eq!(repeats(&[first, last]), []);
    }

    fn run_of(columns: Vec<(&str, Vec<f64>)>) -> Run {
        let n = columns[0].1.len();
        let outputs = columns
            .into_iter()
            .map(|(channel, values)| sealegs_model::Signal { channel: channel.to_owned(), values })
            .collect();
        let record = sealegs_model::Record {
            cut: false,
            name: "r".into(),
            time_s: (0..n).map(|i| 1e-3 * i as f64).collect(),
            hold: sealegs_model::InputHold::ZeroOrder,
            inputs: Vec::new(),
            outputs,
        };
        Run {
            role: Role::Fit,
            scenario: None,
            rig: crate::campaign::RigValues::default(),
            scored: 0..n,
            left_out: crate::campaign::LeftOut::of(&record),
            unknown: Vec::new(),
            clock: crate::campaign::Clock::of(&record.time_s, None),
            path: "r".into(),
            unit: None,
            record,
        }
    }
}
