//! Peaks, dips and crossings of a frequency response's gain, to 1e-6 of the frequency.

use num_complex::Complex64;
use serde::Serialize;

/// A point of a gain curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Feature {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Gain, dB.
    pub gain_db: f64,
}

/// Grid points per decade on which features are first looked for: two features of the same sort closer than
/// 0.12 % of their frequency are seen as one.
const PER_DECADE: f64 = 2000.0;

/// Gain in dB.
#[must_use]
pub fn db(value: Complex64) -> f64 {
    20.0 * value.norm().log10()
}

/// Local maxima of the gain inside `range_hz`, by ascending frequency. An undamped resonance is found at its
/// frequency, with whatever gain rounding leaves there.
#[must_use]
pub fn peaks(response: impl Fn(f64) -> Complex64, range_hz: [f64; 2]) -> Vec<Feature> {
    extrema(&|f| db(response(f)), range_hz)
}

/// Local minima of the gain inside `range_hz`, by ascending frequency.
#[must_use]
pub fn dips(response: impl Fn(f64) -> Complex64, range_hz: [f64; 2]) -> Vec<Feature> {
    extrema(&|f| -db(response(f)), range_hz)
        .into_iter()
        .map(|f| Feature { gain_db: -f.gain_db, ..f })
        .collect()
}

/// Frequencies inside `range_hz` at which the gain passes `level_db`, in either direction, ascending.
#[must_use]
pub fn crossings(response: impl Fn(f64) -> Complex64, level_db: f64, range_hz: [f64; 2]) -> Vec<f64> {
    let above = |f: f64| db(response(f)) > level_db;
    grid(range_hz)
        .windows(2)
        .filter(|pair| above(pair[0]) != above(pair[1]))
        .map(|pair| {
            let (mut low, mut high) = (pair[0], pair[1]);
            let start = above(low);
            for _ in 0..45 {
                let middle = (low * high).sqrt();
                if above(middle) == start {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            (low * high).sqrt()
        })
        .collect()
}

fn grid([low, high]: [f64; 2]) -> Vec<f64> {
    let steps = (PER_DECADE * (high / low).log10()).ceil().max(2.0) as usize;
    (0..=steps).map(|i| low * (high / low).powf(i as f64 / steps as f64)).collect()
}

/// Local maxima of `gain`: bracketed on the grid, then by golden section.
fn extrema(gain: &dyn Fn(f64) -> f64, range_hz: [f64; 2]) -> Vec<Feature> {
    let frequencies = grid(range_hz);
    let gains: Vec<f64> = frequencies.iter().map(|&f| gain(f)).collect();
    (1..frequencies.len() - 1)
        .filter(|&i| gains[i] > gains[i - 1] && gains[i] >= gains[i + 1])
        .map(|i| golden(gain, frequencies[i - 1], frequencies[i + 1]))
        .collect()
}

fn golden(gain: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> Feature {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (gain(left), gain(right));
    // The gain of a smooth peak is flat to rounding within 1e-8 of its frequency: no use in going further.
    while high - low > 1e-9 * high {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = gain(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = gain(right);
        }
    }
    let frequency_hz = 0.5 * (low + high);
    Feature { frequency_hz, gain_db: gain(frequency_hz) }
}
