//! Command profiles over time: step, ramp, sine, chirp, band-limited noise, multisine, table.
//!
//! A profile is a function of time alone and gives the same bits wherever and in whatever order it is asked:
//! its random numbers come from a counter, not from a state. The generator is SplitMix64 (Steele, Lea and
//! Flood 2014): the `n`-th number is a fixed hash of `seed + n * 0x9E3779B97F4A7C15`.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::ActuatorError;
use crate::kaiser::windowed_sinc;

/// A command over time, in the unit of whatever it commands (A for a current).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Profile {
    /// Zero, then a constant value from `start_s` on, up to `end_s` if that is given.
    Step {
        /// Value while it is on.
        amplitude: f64,
        /// When it begins, s.
        #[serde(default)]
        start_s: f64,
        /// When it ends, s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        end_s: Option<f64>,
    },
    /// `amplitude sin(2 pi f t + phase)`.
    Sine {
        /// Amplitude.
        amplitude: f64,
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Phase at t = 0, rad.
        #[serde(default)]
        phase_rad: f64,
    },
    /// A sine whose frequency goes from one value to another; zero afterwards.
    Chirp {
        /// Amplitude.
        amplitude: f64,
        /// Frequency at t = 0, Hz.
        from_hz: f64,
        /// Frequency at the end, Hz.
        to_hz: f64,
        /// Duration, s.
        duration_s: f64,
        /// Exponential in time (equal time per octave) instead of linear.
        #[serde(default)]
        logarithmic: bool,
    },
    /// Gaussian noise with a flat spectrum up to a bandwidth and next to nothing above.
    Noise {
        /// Root mean square.
        rms: f64,
        /// Bandwidth, Hz.
        bandwidth_hz: f64,
        /// Seed: another one gives another signal of the same kind.
        seed: u64,
    },
    /// All harmonics of `1/period_s` within a band with equal amplitude and random phases.
    Multisine {
        /// Root mean square.
        rms: f64,
        /// Lowest frequency, Hz.
        from_hz: f64,
        /// Highest frequency, Hz.
        to_hz: f64,
        /// Period after which it repeats, s.
        period_s: f64,
        /// Seed of the phases.
        seed: u64,
    },
    /// Values at times; constant before the first and after the last.
    Table {
        /// Increasing times, s.
        time_s: Vec<f64>,
        /// A value for each time.
        values: Vec<f64>,
        /// A straight line between the values instead of holding each until the next.
        #[serde(default)]
        linear: bool,
    },
}

/// Half the number of samples of the noise that take part in its value at a time.
const HALF_TAPS: i64 = 24;
/// Shape of the Kaiser window on the noise's sinc: side lobes about 90 dB down.
const KAISER_BETA: f64 = 9.0;
/// Most harmonics of a multisine: every one costs a sine at every time.
const MOST_HARMONICS: usize = 4096;

impl Profile {
    /// The value at a time, s.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        match self {
            Self::Step { amplitude, start_s, end_s } => {
                if t >= *start_s && end_s.is_none_or(|end| t < end) {
                    *amplitude
                } else {
                    0.0
                }
            }
            Self::Sine { amplitude, frequency_hz, phase_rad } => {
                amplitude * (TAU * frequency_hz * t + phase_rad).sin()
            }
            Self::Chirp { amplitude, from_hz, to_hz, duration_s, logarithmic } => {
                if !(0.0..=*duration_s).contains(&t) {
                    return 0.0;
                }
                let cycles = if *logarithmic {
                    let rate = (to_hz / from_hz).ln() / duration_s;
                    from_hz * (rate * t).exp_m1() / rate
                } else {
                    from_hz * t + 0.5 * (to_hz - from_hz) / duration_s * t * t
                };
                amplitude * (TAU * cycles).sin()
            }
            Self::Noise { rms, bandwidth_hz, seed } => rms * noise(*seed, 2.0 * bandwidth_hz * t),
            Self::Multisine { rms, from_hz, to_hz, period_s, seed } => {
                let (first, last) = harmonics(*from_hz, *to_hz, *period_s);
                let amplitude = rms * (2.0 / (last + 1 - first) as f64).sqrt();
                let phase = |k: u64| TAU * uniform(*seed, k);
                let sum: f64 = (first..=last).map(|k| (TAU * k as f64 * t / period_s + phase(k)).sin()).sum();
                amplitude * sum
            }
            Self::Table { time_s, values, linear } => {
                let after = time_s.partition_point(|&s| s <= t);
                match (after.checked_sub(1), time_s.get(after)) {
                    (None, _) => values.first().copied().unwrap_or(0.0),
                    (Some(last), None) => values[last],
                    (Some(i), Some(_)) if !linear => values[i],
                    (Some(i), Some(&next)) => {
                        let along = (t - time_s[i]) / (next - time_s[i]);
                        values[i] + along * (values[after] - values[i])
                    }
                }
            }
        }
    }

    /// The values at the given times, s.
    #[must_use]
    pub fn sample(&self, time_s: &[f64]) -> Vec<f64> {
        time_s.iter().map(|&t| self.at(t)).collect()
    }

    /// Checks every number.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] with the field's name.
    pub fn validate(&self) -> Result<(), ActuatorError> {
        let finite = |field: &str, value: f64| {
            value.is_finite().then_some(()).ok_or_else(|| ActuatorError::value(field, value, "finite"))
        };
        let positive = |field: &str, value: f64| {
            let good = value > 0.0 && value.is_finite();
            good.then_some(()).ok_or_else(|| ActuatorError::value(field, value, "positive and finite"))
        };
        match self {
            Self::Step { amplitude, start_s, end_s } => {
                finite("amplitude", *amplitude)?;
                finite("start_s", *start_s)?;
                match end_s {
                    Some(end) if end.is_nan() || *end <= *start_s => {
                        Err(ActuatorError::value("end_s", *end, "later than start_s"))
                    }
                    _ => Ok(()),
                }
            }
            Self::Sine { amplitude, frequency_hz, phase_rad } => {
                finite("amplitude", *amplitude)?;
                finite("phase_rad", *phase_rad)?;
                positive("frequency_hz", *frequency_hz)
            }
            Self::Chirp { amplitude, from_hz, to_hz, duration_s, logarithmic } => {
                finite("amplitude", *amplitude)?;
                positive("from_hz", *from_hz)?;
                positive("to_hz", *to_hz)?;
                if *logarithmic && from_hz == to_hz {
                    return Err(ActuatorError::value("to_hz", *to_hz, "different from from_hz"));
                }
                positive("duration_s", *duration_s)
            }
            Self::Noise { rms, bandwidth_hz, .. } => {
                finite("rms", *rms)?;
                positive("bandwidth_hz", *bandwidth_hz)
            }
            Self::Multisine { rms, from_hz, to_hz, period_s, .. } => {
                finite("rms", *rms)?;
                positive("from_hz", *from_hz)?;
                positive("to_hz", *to_hz)?;
                positive("period_s", *period_s)?;
                let (first, last) = harmonics(*from_hz, *to_hz, *period_s);
                if last < first || (last - first) as usize >= MOST_HARMONICS {
                    return Err(ActuatorError::value(
                        "period_s",
                        *period_s,
                        format!("such that 1 to {MOST_HARMONICS} harmonics lie in the band"),
                    ));
                }
                Ok(())
            }
            Self::Table { time_s, values, .. } => {
                if time_s.is_empty() || time_s.len() != values.len() {
                    let sizes = format!("{} times, {} values", time_s.len(), values.len());
                    return Err(ActuatorError::value("values", sizes, "as many as times, at least one"));
                }
                if let Some(pair) = time_s.windows(2).find(|w| w[0].is_nan() || w[1].is_nan() || w[1] <= w[0])
                {
                    return Err(ActuatorError::value("time_s", pair[1], "increasing"));
                }
                values.iter().chain(time_s).try_for_each(|&v| finite("values", v))
            }
        }
    }

    /// A table from CSV text with a header: the time in column `time_s`, the values in `column`.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Syntax`] with the line at fault, or [`ActuatorError::Value`].
    pub fn table_from_csv(text: &str, column: &str, linear: bool, file: &str) -> Result<Self, ActuatorError> {
        let bad = |line: usize, message: String| ActuatorError::Syntax {
            file: file.to_owned(),
            line,
            column: 1,
            message,
            suggestion: None,
        };
        let mut lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
        let header: Vec<&str> = match lines.next() {
            Some((_, line)) => line.split(',').map(str::trim).collect(),
            None => return Err(bad(1, "the file is empty".to_owned())),
        };
        let place = |name: &str| {
            let found = header.iter().position(|h| *h == name);
            found.ok_or_else(|| bad(1, format!("no column '{name}' among {}", header.join(", "))))
        };
        let (time_at, value_at) = (place("time_s")?, place(column)?);
        let (mut time_s, mut values) = (Vec::new(), Vec::new());
        for (i, line) in lines {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            let number = |at: usize| {
                let cell = cells.get(at).copied().unwrap_or_default();
                cell.parse::<f64>().map_err(|_| bad(i + 1, format!("'{cell}' is no number")))
            };
            time_s.push(number(time_at)?);
            values.push(number(value_at)?);
        }
        let table = Self::Table { time_s, values, linear };
        table.validate()?;
        Ok(table)
    }
}

/// First and last harmonic of `1/period` within a band.
fn harmonics(from_hz: f64, to_hz: f64, period_s: f64) -> (u64, u64) {
    // A band's edge that is a harmonic up to rounding belongs to it.
    (((from_hz * period_s - 1e-9).ceil() as u64).max(1), (to_hz * period_s + 1e-9).floor() as u64)
}

/// The `n`-th number of the generator.
fn split_mix(seed: u64, n: u64) -> u64 {
    let mut z = seed.wrapping_add(n.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The `n`-th number, uniform in (0, 1).
#[must_use]
pub fn uniform(seed: u64, n: u64) -> f64 {
    ((split_mix(seed, n) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

/// The `n`-th standard normal number, by Box and Muller from two uniform ones.
#[must_use]
pub fn gaussian(seed: u64, n: i64) -> f64 {
    let n = n as u64;
    let (u, v) = (uniform(seed, n.wrapping_mul(2)), uniform(seed, n.wrapping_mul(2).wrapping_add(1)));
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

/// White samples at whole numbers, between them interpolated by a windowed sinc: unit variance.
fn noise(seed: u64, at: f64) -> f64 {
    let base = at.floor();
    let fraction = at - base;
    let base = base as i64;
    let mut sum = 0.0;
    for k in (1 - HALF_TAPS)..=HALF_TAPS {
        let weight = windowed_sinc(fraction - k as f64, HALF_TAPS as f64, KAISER_BETA);
        sum += weight * gaussian(seed, base + k);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power of a sampled signal at one frequency, by a direct sum.
    fn power_at(values: &[f64], rate_hz: f64, frequency_hz: f64) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for (i, v) in values.iter().enumerate() {
            let window = 0.5 - 0.5 * (TAU * i as f64 / values.len() as f64).cos();
            let (s, c) = (TAU * frequency_hz * i as f64 / rate_hz).sin_cos();
            re += window * v * c;
            im += window * v * s;
        }
        (re * re + im * im) / values.len() as f64
    }

    #[test]
    fn published_split_mix_sequence() {
        // Reference output of the authors' generator for seed 1234567.
        let expected: [u64; 3] = [6457827717110365317, 3203168211198807973, 9817491932198370423];
        assert_eq!([0, 1, 2].map(|n| split_mix(1234567, n)), expected);
    }

    #[test]
    fn noise_has_its_power_within_its_band() {
        let profile = Profile::Noise { rms: 2.0, bandwidth_hz: 50.0, seed: 7 };
        let values: Vec<f64> = (0..20_000).map(|i| profile.at(f64::from(i) / 1000.0)).collect();
        let rms = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
        // 2000 independent samples: 1.6 % standard error of the rms.
        assert!((rms / 2.0 - 1.0).abs() < 0.06, "{rms}");
        let mean = |hz: [f64; 8]| hz.iter().map(|f| power_at(&values, 1000.0, *f)).sum::<f64>() / 8.0;
        let inside = mean([3.1, 7.7, 11.3, 19.9, 23.1, 31.7, 38.3, 43.9]);
        let above = mean([60.3, 71.1, 83.7, 99.9, 140.0, 200.0, 333.0, 450.0]);
        assert!(above < 1e-6 * inside, "{inside} {above}");
    }

    #[test]
    fn noise_depends_on_seed_and_time_only() {
        let a = Profile::Noise { rms: 1.0, bandwidth_hz: 10.0, seed: 1 };
        let b = Profile::Noise { rms: 1.0, bandwidth_hz: 10.0, seed: 2 };
        assert_eq!(a.at(3.21).to_bits(), a.clone().at(3.21).to_bits());
        assert_ne!(a.at(3.21), b.at(3.21));
        assert!(a.at(-0.3).is_finite());
    }

    #[test]
    fn analytic_chirp_reaches_its_frequencies() {
        for logarithmic in [false, true] {
            let chirp =
                Profile::Chirp { amplitude: 1.0, from_hz: 2.0, to_hz: 20.0, duration_s: 10.0, logarithmic };
            // Zero crossings over the last tenth of a second: 2 f per second.
            let crossings = |from: f64, to: f64| {
                let n = 20_000;
                let value = |i: i32| chirp.at(from + (to - from) * f64::from(i) / f64::from(n));
                (0..n).filter(|&i| value(i).signum() != value(i + 1).signum()).count() as f64
            };
            assert!((crossings(9.0, 10.0) / 2.0 - 18.5).abs() < 1.5, "near the end");
            assert!((crossings(0.0, 1.0) / 2.0 - 2.6).abs() < 0.7, "near the start");
            assert_eq!(chirp.at(10.1), 0.0);
        }
    }

    #[test]
    fn analytic_multisine_rms_and_period() {
        let profile = Profile::Multisine { rms: 3.0, from_hz: 1.0, to_hz: 40.0, period_s: 2.0, seed: 5 };
        profile.validate().expect("good");
        let values: Vec<f64> = (0..2000).map(|i| profile.at(f64::from(i) / 1000.0)).collect();
        let rms = (values.iter().map(|v| v * v).sum::<f64>() / 2000.0).sqrt();
        assert!((rms - 3.0).abs() < 1e-9);
        assert!((profile.at(0.37) - profile.at(2.37)).abs() < 1e-9);
    }

    #[test]
    fn tables_hold_or_interpolate() {
        let csv = "time_s,current_a\n0,1\n1,3\n2,-1\n";
        let held = Profile::table_from_csv(csv, "current_a", false, "t.csv").expect("good");
        let line = Profile::table_from_csv(csv, "current_a", true, "t.csv").expect("good");
        assert_eq!([-1.0, 0.5, 1.0, 9.0].map(|t| held.at(t)), [1.0, 1.0, 3.0, -1.0]);
        assert_eq!([-1.0, 0.5, 1.5, 9.0].map(|t| line.at(t)), [1.0, 2.0, 1.0, -1.0]);
        let message = Profile::table_from_csv("time_s,a\n0,x\n", "a", true, "t.csv").expect_err("no number");
        assert!(message.to_string().contains("t.csv:2"), "{message}");
        assert!(Profile::table_from_csv("time_s,a\n0,1\n0,2\n", "a", true, "t.csv").is_err());
        assert!(Profile::table_from_csv("time_s,a\n", "b", true, "t.csv").is_err());
    }

    #[test]
    fn bad_numbers_are_refused() {
        assert!(Profile::Step { amplitude: f64::NAN, start_s: 0.0, end_s: None }.validate().is_err());
        assert!(Profile::Step { amplitude: 1.0, start_s: 1.0, end_s: Some(1.0) }.validate().is_err());
        assert!(Profile::Noise { rms: 1.0, bandwidth_hz: 0.0, seed: 0 }.validate().is_err());
        let empty = Profile::Multisine { rms: 1.0, from_hz: 1.0, to_hz: 1.2, period_s: 0.1, seed: 0 };
        assert!(empty.validate().is_err());
    }
}
