//! The command between its samples: over every step of the integrator's grid its mean, or what is in force where the step begins.

use super::ports::CommandStage;
use crate::kaiser::windowed_sinc;
use sealegs_model::InputHold;

/// A uniform grid of integration steps that covers a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Time of the first point, s.
    pub start_s: f64,
    /// Step, s.
    pub step_s: f64,
    /// Number of steps; there is one point more.
    pub steps: usize,
}

impl Grid {
    /// The grid from the first to beyond the last time stamp with a step of at most `max_step_s`.
    ///
    /// Where the time stamps are uniform the step divides their distance, so that every sample falls on
    /// a point of the grid.
    #[must_use]
    pub fn covering(time_s: &[f64], max_step_s: f64) -> Self {
        let start_s = time_s[0];
        let span = time_s[time_s.len() - 1] - start_s;
        let mean_period = span / (time_s.len() - 1) as f64;
        let uniform = time_s
            .iter()
            .enumerate()
            .all(|(i, t)| (t - start_s - i as f64 * mean_period).abs() < 0.01 * mean_period);
        let step_s = if uniform {
            mean_period / (mean_period / max_step_s - 1e-9).ceil().max(1.0)
        } else {
            max_step_s
        };
        let steps = (span / step_s - 1e-6).ceil().max(1.0) as usize;
        Self { start_s, step_s, steps }
    }

    /// How close to a point a time stamp is on it: what is left is rounding of decimal time stamps.
    fn rounding(&self) -> f64 {
        1e-7 * self.step_s.max(1e-6)
    }

    /// Time of a point, s.
    #[must_use]
    pub fn time(&self, point: usize) -> f64 {
        self.start_s + point as f64 * self.step_s
    }
}

/// The command as a constant over every step of `grid`, after the drive's `stages`, in the command's unit.
///
/// Under a zero-order hold it is the mean over the step, exactly. A smooth command is taken at the middle of
/// the step and lifted by what holding it over a step takes away (see `lifted`). Before its first sample the
/// command has the value of that sample.
#[must_use]
pub fn mean_per_step(
    time_s: &[f64],
    values: &[f64],
    hold: InputHold,
    stages: &[Box<dyn CommandStage>],
    grid: &Grid,
) -> Vec<f64> {
    let (time_s, values) = after(stages, time_s, values);
    match hold {
        InputHold::ZeroOrder => hold_zero_order(&time_s, &values, grid),
        InputHold::Linear => hold_linear(&time_s, &values, grid),
        InputHold::BandLimited => lifted(hold_band_limited(&time_s, &values, grid)),
    }
}

/// A command that is held between its samples, after the drive's `stages`, as it is where each step of `grid` begins: what a loop that
/// samples then sees, and nothing of what comes within the step. Before its first sample it has the value of that sample.
#[must_use]
pub fn at_step_starts(
    time_s: &[f64],
    values: &[f64],
    stages: &[Box<dyn CommandStage>],
    grid: &Grid,
) -> Vec<f64> {
    let (time_s, values) = after(stages, time_s, values);
    let mut current = 0;
    (0..grid.steps)
        .map(|n| {
            current = in_force(&time_s, current, grid.time(n) + grid.rounding());
            values[current]
        })
        .collect()
}

/// The sample that is in force at a time, from an earlier one on.
fn in_force(time_s: &[f64], mut current: usize, at: f64) -> usize {
    while current + 1 < time_s.len() && time_s[current + 1] <= at {
        current += 1;
    }
    current
}

/// A command after the drive's stages.
pub(crate) fn after(
    stages: &[Box<dyn CommandStage>],
    time_s: &[f64],
    values: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let (mut time_s, mut values) = (time_s.to_vec(), values.to_vec());
    stages.iter().for_each(|stage| stage.apply(&mut time_s, &mut values));
    (time_s, values)
}

/// Holding a sine over a step `h` multiplies it by `sin(x)/x` with `x = w h / 2`. Subtracting a 24th of the
/// second difference multiplies it by `1 + x^2/6` in the leading order, so that the product errs by `x^4` only.
fn lifted(values: Vec<f64>) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|n| {
            let (before, after) = (values[n.saturating_sub(1)], values[(n + 1).min(last)]);
            values[n] - (before - 2.0 * values[n] + after) / 24.0
        })
        .collect()
}

fn hold_zero_order(time_s: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    let h = grid.step_s;
    let snap = grid.rounding();
    let mut current = 0;
    (0..grid.steps)
        .map(|n| {
            let (from, to) = (grid.time(n), grid.time(n + 1));
            current = in_force(time_s, current, from + snap);
            if current + 1 == time_s.len() || time_s[current + 1] >= to - snap {
                return values[current];
            }
            let mut sum = 0.0;
            let mut at = from;
            let mut i = current;
            while i + 1 < time_s.len() && time_s[i + 1] < to {
                sum += values[i] * (time_s[i + 1] - at);
                at = time_s[i + 1];
                i += 1;
            }
            (sum + values[i] * (to - at)) / h
        })
        .collect()
}

fn hold_linear(time_s: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    let mut i = 0;
    // The value at the middle is the mean wherever no sample falls within the step.
    (0..grid.steps)
        .map(|n| {
            let t = grid.time(n) + 0.5 * grid.step_s;
            while i + 2 < time_s.len() && time_s[i + 1] <= t {
                i += 1;
            }
            let along = ((t - time_s[i]) / (time_s[i + 1] - time_s[i])).clamp(0.0, 1.0);
            values[i] + along * (values[i + 1] - values[i])
        })
        .collect()
}

/// Half the number of samples that take part in the interpolation of a band-limited command.
const HALF_TAPS: usize = 24;

/// Shape of its window, for a stop band far below a sensor's noise.
const KAISER_BETA: f64 = 9.0;

/// Interpolation by a sinc under a Kaiser window at the middle of each step.
fn hold_band_limited(time_s: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    let period = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    // The phases repeat where the step divides the period: the weights are then computed once.
    let per_period = (period / grid.step_s).round().max(1.0);
    let repeats = (per_period * grid.step_s - period).abs() < 1e-9 * period;
    let position = |n: usize| (grid.time(n) + 0.5 * grid.step_s - time_s[0]) / period;
    let per_period = per_period as usize;
    let phases: Vec<(f64, [f64; 2 * HALF_TAPS])> = if repeats {
        (0..per_period)
            .map(|p| (position(p).floor(), sinc_weights(position(p) - position(p).floor())))
            .collect()
    } else {
        Vec::new()
    };
    (0..grid.steps)
        .map(|n| {
            let (base, weights) = if repeats {
                let (first, weights) = &phases[n % per_period];
                (first + (n / per_period) as f64, *weights)
            } else {
                let base = position(n).floor();
                (base, sinc_weights(position(n) - base))
            };
            let base = base.max(0.0) as usize;
            // Samples base - HALF_TAPS + 1 ..= base + HALF_TAPS; the ends repeat the first and last value.
            if base + 1 >= HALF_TAPS && base + HALF_TAPS < values.len() {
                let from = base + 1 - HALF_TAPS;
                return weights.iter().zip(&values[from..]).map(|(w, v)| w * v).sum();
            }
            let last = values.len() as isize - 1;
            let from = base as isize + 1 - HALF_TAPS as isize;
            weights
                .iter()
                .enumerate()
                .map(|(k, w)| w * values[(from + k as isize).clamp(0, last) as usize])
                .sum()
        })
        .collect()
}

/// Weights of the samples around a point `fraction` of a period after the middle-left sample; their sum is 1.
fn sinc_weights(fraction: f64) -> [f64; 2 * HALF_TAPS] {
    let mut weights = [0.0; 2 * HALF_TAPS];
    let mut sum = 0.0;
    for (k, weight) in weights.iter_mut().enumerate() {
        let x = fraction + HALF_TAPS as f64 - 1.0 - k as f64;
        *weight = windowed_sinc(x, HALF_TAPS as f64, KAISER_BETA);
        sum += *weight;
    }
    weights.iter_mut().for_each(|w| *w /= sum);
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_zero_order_means_are_exact_at_odd_times() {
        let grid = Grid { start_s: 0.0, step_s: 0.1, steps: 4 };
        let means = mean_per_step(&[0.0, 0.05, 0.22], &[1.0, 3.0, -1.0], InputHold::ZeroOrder, &[], &grid);
        for (mean, truth) in means.iter().zip([2.0, 3.0, 0.2 * 3.0 - 0.8, -1.0]) {
            assert!((mean - truth).abs() < 1e-12, "{means:?}");
        }
    }

    #[test]
    fn a_loop_that_samples_sees_nothing_of_what_comes_after() {
        let grid = Grid { start_s: 0.0, step_s: 0.1, steps: 4 };
        let seen = at_step_starts(&[0.05, 0.1, 0.201], &[1.0, 3.0, -1.0], &[], &grid);
        assert_eq!(seen, [1.0, 3.0, 3.0, -1.0]);
    }

    #[test]
    fn analytic_band_limited_sine_between_samples() {
        let f = 0.31;
        let time: Vec<f64> = (0..400).map(f64::from).collect();
        let values: Vec<f64> = time.iter().map(|t| (std::f64::consts::TAU * f * t).sin()).collect();
        for step_s in [0.125, 0.13] {
            let grid = Grid { start_s: 0.0, step_s, steps: (399.0 / step_s) as usize };
            let got = mean_per_step(&time, &values, InputHold::BandLimited, &[], &grid);
            for n in (60.0 / step_s) as usize..(340.0 / step_s) as usize {
                let truth = (std::f64::consts::TAU * f * (grid.time(n) + 0.5 * step_s)).sin();
                let lift = 1.0 + (std::f64::consts::TAU * f * step_s).powi(2) / 24.0;
                assert!((got[n] - truth * lift).abs() < 1e-4, "{n}: {} {truth}", got[n]);
            }
        }
    }

    #[test]
    fn grid_divides_a_uniform_period() {
        let time: Vec<f64> = (0..100).map(|i| f64::from(i) * 1e-3).collect();
        let grid = Grid::covering(&time, 1e-4);
        assert!((grid.step_s - 1e-4).abs() < 1e-15);
        assert_eq!(grid.steps, 990);
    }
}
