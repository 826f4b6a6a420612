//! Position and speed at the beginning of a log: a cubic through as many of its first rows as agree on the speed.
//!
//! A long cubic averages noise, a short one follows the motion. The window grows as long as the confidence intervals of all its
//! speeds intersect (A. Goldenshluger and A. Nemirovski 1997, Mathematical Methods of Statistics 6(2)): the noise, not the motion,
//! is then what they differ by. A speed that cannot be told from rest is rest: most logs begin there, and a free swing keeps what
//! noise would make of it. A piece of a run begins anywhere: the turn of a swing is no rest.
//!
//! Few rows of a fast motion (a servo that is sent to a goal from the first row on) hide from this test how far a cubic is from
//! it. The windows' speeds then differ although their wide intervals intersect: by how much is said beside the start.

use nalgebra::{SMatrix, SVector};
use sealegs_model::{SIXTH_POWER, sixth_differences};
use std::ops::Range;

/// Fewest rows and least time (s) of a polynomial.
const FIRST_ROWS: usize = 8;
const FIRST_S: f64 = 0.02;

/// Longest time of which a start is taken, s: a link of 1 Hz has gone half of its swing.
pub const LONGEST_S: f64 = 0.5;

/// Ratio of one window to the one before.
const GROWTH: f64 = 1.25;

/// Half width of a speed's confidence interval, in standard errors: 95 %.
const STANDARD_ERRORS: f64 = 2.0;

/// Fewest rows from which the noise is estimated; with fewer the shortest parabola is taken.
const NOISE_ROWS: usize = 24;

/// The noise of a piece is known to a factor only: sixth differences of 30 rows have some 7 degrees of freedom, and the upper end
/// of their 95 % interval is at twice what they say.
const NOISE_UNCERTAIN: f64 = 2.0;

/// Where a signal begins, and how well its first rows tell that.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Start {
    /// Value at the first row.
    pub value: f64,
    /// Slope there, per second.
    pub slope: f64,
    /// Standard deviation of the value: what the noise makes of it, and what windows differ by.
    pub value_std: f64,
    /// The same of the slope; 0 where the signal begins at rest.
    pub slope_std: f64,
    /// Standard deviation of the signal's white noise.
    pub noise: f64,
    /// The first rows that it was taken from.
    pub rows: usize,
}

/// A polynomial at its first row.
struct Polynomial {
    rows: usize,
    value: f64,
    slope: f64,
    /// Standard error of the slope per standard deviation of the rows.
    slope_error: f64,
    /// Value of the polynomial that fits best of those that begin without a slope.
    value_at_rest: f64,
}

/// Where a signal begins. One that was `cut` out of a longer one begins in motion, however slow.
#[must_use]
pub fn start_of(time_s: &[f64], values: &[f64], cut: bool) -> Start {
    let first = rows_within(time_s, FIRST_S).max(FIRST_ROWS).min(time_s.len());
    let last = rows_within(time_s, LONGEST_S).max(first);
    let at_rest = Start { value: values.first().copied().unwrap_or(0.0), ..Start::default() };
    if last < NOISE_ROWS {
        let found = polynomial::<3>(&time_s[..first], &values[..first]);
        return found.map_or(at_rest, |p| Start { value: p.value, slope: p.slope, rows: first, ..at_rest });
    }
    let noise = noise_of(&values[..last]);
    let of_rows = |rows: usize| polynomial::<4>(&time_s[..rows], &values[..rows]);
    let windows = agreeing(of_rows, first..last + 1, noise);
    let (Some(shortest), Some(longest)) = (windows.first(), windows.last()) else { return at_rest };
    if cut {
        // What is known of a longer window is that it agrees with this one, not that it is right.
        let Polynomial { value, slope, slope_error, .. } = *shortest;
        let std = NOISE_UNCERTAIN * noise;
        let (value_std, slope_std) = (std, std * slope_error);
        return Start { value, slope, value_std, slope_std, noise, rows: longest.rows };
    }
    if longest.slope.abs() <= STANDARD_ERRORS * noise * longest.slope_error {
        return Start { value: longest.value_at_rest, noise, rows: longest.rows, ..at_rest };
    }
    Start {
        value: longest.value,
        slope: longest.slope,
        value_std: noise.hypot(longest.value - shortest.value),
        slope_std: (noise * longest.slope_error).hypot(longest.slope - shortest.slope),
        noise,
        rows: longest.rows,
    }
}

/// How many rows there are up to so long (s) after the first one.
#[must_use]
pub fn rows_within(time_s: &[f64], longest_s: f64) -> usize {
    time_s.iter().take_while(|t| *t - time_s[0] <= longest_s).count()
}

/// Polynomials through ever more rows, of a range of their number, as long as their speeds agree with those of all shorter ones.
fn agreeing(of: impl Fn(usize) -> Option<Polynomial>, rows: Range<usize>, noise: f64) -> Vec<Polynomial> {
    let windows = std::iter::successors(Some(rows.start as f64), |rows| Some(GROWTH * rows));
    let windows = windows.map(|rows| rows as usize).take_while(|n| rows.contains(n));
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let agrees = |start: &Polynomial| {
        let half = STANDARD_ERRORS * noise * start.slope_error;
        (low, high) = (low.max(start.slope - half), high.min(start.slope + half));
        low <= high
    };
    windows.map_while(of).take_while(agrees).collect()
}

/// Standard deviation of white noise in a signal that is smooth beside: from sixth differences.
fn noise_of(values: &[f64]) -> f64 {
    let squares: f64 = sixth_differences(values, 1).map(|d| d * d).sum();
    (squares / (SIXTH_POWER * (values.len() - 6) as f64)).sqrt()
}

/// The polynomial of `N` coefficients that fits the rows best, least squares; `None` for fewer rows, or where time stands still.
fn polynomial<const N: usize>(time_s: &[f64], values: &[f64]) -> Option<Polynomial> {
    let rows = values.get(..time_s.len()).filter(|rows| rows.len() >= N)?;
    let (start, span) = (time_s[0], time_s[rows.len() - 1] - time_s[0]);
    // Legendre's polynomials are nearly orthogonal over even rows, so that the normal equations stay well conditioned.
    let basis = |t: f64| {
        let u = 2.0 * (t - start) / span - 1.0;
        let mut p = SVector::<f64, N>::repeat(1.0);
        for n in 1..N {
            let (k, before) = (n as f64, if n > 1 { p[n - 2] } else { 0.0 });
            p[n] = ((2.0 * k - 1.0) * u * p[n - 1] - (k - 1.0) * before) / k;
        }
        p
    };
    let (mut normal, mut right) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
    for (t, value) in time_s.iter().zip(rows) {
        let row = basis(*t);
        normal += row * row.transpose();
        right += row * (value - rows[0]);
    }
    let factors = (span > 0.0).then(|| normal.cholesky())??;
    // At u = -1 the polynomial of degree n is (-1)^n, and its slope (-1)^(n - 1) n (n + 1) / 2.
    let sign = |n: usize| if n.is_multiple_of(2) { 1.0 } else { -1.0 };
    let first = SVector::<f64, N>::from_fn(|n, _| sign(n));
    let slope = SVector::<f64, N>::from_fn(|n, _| -sign(n) * (n * (n + 1)) as f64 / span);
    let (c, by_slope) = (factors.solve(&right), factors.solve(&slope));
    let variance = slope.dot(&by_slope);
    let (first_value, first_slope) = (rows[0] + first.dot(&c), slope.dot(&c));
    Some(Polynomial {
        rows: rows.len(),
        value: first_value,
        slope: first_slope,
        slope_error: variance.sqrt(),
        value_at_rest: first_value - first.dot(&by_slope) / variance * first_slope,
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::excitation::gaussian;

    /// Uneven rows from 0.3 s on, and a motion that begins there at 0.2 with a speed of 0.7 per second.
    pub fn in_motion() -> (Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> =
            (0..400).map(|i| 0.3 + f64::from(i) * 1e-3 + 1e-4 * f64::from(i % 3)).collect();
        let values = time_s.iter().map(|t| 0.2 + 0.7 * (t - 0.3) - 2.0 * (t - 0.3).powi(2)).collect();
        (time_s, values)
    }

    /// A swing of 0.5 rad at 1 Hz in rows of 500 Hz, from a phase on, with white noise of a standard deviation.
    fn swing(phase: f64, noise: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> = (0..600).map(|n| f64::from(n) * 2e-3).collect();
        let at = |t: f64| 0.5 * (std::f64::consts::TAU * t + phase).sin();
        let values = time_s.iter().zip(0..).map(|(t, n)| at(*t) + noise * gaussian(seed, n)).collect();
        (time_s, values)
    }

    /// Root mean square error of the speed (rad/s) over phases, as found and by the shortest window.
    fn errors(noise: f64) -> (f64, f64) {
        let (mut found, mut shortest) = (0.0, 0.0);
        for n in 0..100_u32 {
            let phase = 0.1 * f64::from(n);
            let (time_s, values) = swing(phase, noise, u64::from(n) + 1);
            let truth = std::f64::consts::PI * phase.cos();
            found += (start_of(&time_s, &values, false).slope - truth).powi(2);
            shortest += (polynomial::<3>(&time_s[..11], &values[..11]).expect("rows").slope - truth).powi(2);
        }
        ((found / 100.0).sqrt(), (shortest / 100.0).sqrt())
    }

    #[test]
    fn analytic_a_parabola_is_found_with_its_standard_error() {
        let (time_s, values) = in_motion();
        let Start { value: x, slope: v, .. } = start_of(&time_s, &values, false);
        assert!((x - 0.2).abs() < 1e-12 && (v - 0.7).abs() < 1e-9, "{x} {v}");
        // Of many even rows over T the standard error of the first slope is sqrt(192 / N) / T.
        let even: Vec<f64> = (0..400).map(|i| f64::from(i) * 1e-3).collect();
        let error = polynomial::<3>(&even, &values).expect("rows").slope_error;
        assert!((error / ((192.0_f64 / 400.0).sqrt() / 0.399) - 1.0).abs() < 0.02, "{error}");
    }

    #[test]
    fn a_noisy_swing_is_averaged_and_a_clear_one_followed() {
        let (found, shortest) = errors(3e-4);
        assert!(found < 0.6 * shortest, "{found} {shortest}");
        let (found, shortest) = errors(1e-7);
        assert!(found < 0.1 * shortest && found < 2e-4, "{found} {shortest}");
    }

    #[test]
    fn a_noisy_log_that_begins_at_rest_does() {
        // Pushed by 10 rad/s^2 from the first row on, with the noise of [`swing`] at 0 rad.
        let at_rest = (0..100_u64).filter(|seed| {
            let (time_s, mut values) = swing(0.0, 3e-4, *seed);
            let clear = swing(0.0, 0.0, *seed).1;
            for ((v, c), t) in values.iter_mut().zip(clear).zip(&time_s) {
                *v += 5.0 * t * t + 0.2 - c;
            }
            let Start { value: x, slope: v, .. } = start_of(&time_s, &values, false);
            assert!((x - 0.2).abs() < 1e-3 && v.abs() < 0.1, "{x} {v}");
            v == 0.0
        });
        assert!(at_rest.count() >= 80);
    }

    #[test]
    fn analytic_a_piece_at_the_turn_of_a_swing_is_in_motion_and_says_how_well_that_is_known() {
        // So slow that it is taken for rest now and then.
        let slow = 0.006_f64;
        let phase = (slow / std::f64::consts::PI).acos();
        let (mut at_rest, mut held) = (0, 0);
        for seed in 0..100 {
            let (time_s, values) = swing(phase, 3e-4, seed);
            at_rest += i32::from(start_of(&time_s, &values, false).slope_std == 0.0);
            let cut = start_of(&time_s, &values, true);
            let off = [(cut.slope - slow) / cut.slope_std, (cut.value - 0.5 * phase.sin()) / cut.value_std];
            held += i32::from(cut.slope_std > 0.0 && off.iter().all(|off| off.abs() < 2.0));
        }
        assert!(at_rest > 10 && held > 90, "{at_rest} {held}");
    }

    #[test]
    fn rest_is_rest_and_little_is_taken_as_it_is() {
        let time_s: Vec<f64> = (0..100).map(|n| f64::from(n) * 0.01).collect();
        let begins = |rows: usize, values: &[f64]| {
            let start = start_of(&time_s[..rows], values, false);
            (start.value, start.slope, start.slope_std)
        };
        assert_eq!(begins(100, &[0.25; 100]), (0.25, 0.0, 0.0));
        assert_eq!(begins(2, &[1.0, 2.0]), (1.0, 0.0, 0.0));
        assert_eq!(begins(0, &[]), (0.0, 0.0, 0.0));
        let Start { value: x, slope: v, .. } = start_of(&time_s[..4], &[1.0, 1.1, 1.2, 1.3], false);
        assert!((x - 1.0).abs() < 1e-12 && (v - 10.0).abs() < 1e-9, "{x} {v}");
    }
}
