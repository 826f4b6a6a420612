//! The estimate of a frequency response, its coherence and its random error.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::Spectra;

/// Where the noise is taken to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimator {
    /// `S_xy / S_xx`: noise on the output only. Unbiased where the input is known, as a command is.
    #[default]
    H1,
    /// `S_yy / S_yx`: noise on the input only.
    H2,
    /// `sqrt(H1 H2)`: noise on both in proportion to the signals.
    Hv,
}

/// What a sampled command does before it reaches the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// The samples are the signal.
    #[default]
    None,
    /// Held from sample to sample, only its delay of half a period taken into account.
    HalfSample,
    /// Held from sample to sample: `exp(-i w T / 2) sinc(w T / 2)`. Exact but for aliases of the response
    /// from beyond half the sampling frequency.
    ZeroOrder,
}

impl Hold {
    /// The hold's own frequency response at a sampling period `sample_period_s`.
    #[must_use]
    pub fn response(self, frequency_hz: f64, sample_period_s: f64) -> Complex64 {
        let half = PI * frequency_hz * sample_period_s;
        let gain = if half.abs() < 1e-9 { 1.0 } else { half.sin() / half };
        match self {
            Self::None => Complex64::ONE,
            Self::HalfSample => Complex64::from_polar(1.0, -half),
            Self::ZeroOrder => Complex64::from_polar(gain, -half),
        }
    }
}

impl Spectra {
    /// The frequency response from input to output.
    ///
    /// Lines on which nothing was excited have coherence zero and value zero.
    #[must_use]
    pub fn response(&self, estimator: Estimator) -> FrequencyResponse {
        let lines = 0..self.frequency_hz.len();
        let coherence: Vec<f64> = lines
            .clone()
            .map(|i| {
                let power = self.input[i] * self.output[i];
                if power > 0.0 { (self.cross[i].norm_sqr() / power).min(1.0) } else { 0.0 }
            })
            .collect();
        let value = lines
            .map(|i| {
                if coherence[i] == 0.0 {
                    return Complex64::ZERO;
                }
                let h1 = self.cross[i] / self.input[i];
                match estimator {
                    Estimator::H1 => h1,
                    Estimator::H2 => h1 / coherence[i],
                    Estimator::Hv => h1 / coherence[i].sqrt(),
                }
            })
            .collect();
        FrequencyResponse {
            sample_period_s: self.sample_period_s,
            frequency_hz: self.frequency_hz.clone(),
            value,
            coherence,
            averages: self.effective_averages,
        }
    }
}

/// An estimated frequency response.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// Sampling period of the signals it came from, s.
    pub sample_period_s: f64,
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Output per input.
    pub value: Vec<Complex64>,
    /// Ordinary coherence, 0 to 1.
    pub coherence: Vec<f64>,
    /// Number of independent averages behind each line.
    pub averages: f64,
}

impl FrequencyResponse {
    /// A response that is known exactly, for example a closed form: coherence one.
    #[must_use]
    pub fn exact(frequency_hz: Vec<f64>, value: Vec<Complex64>) -> Self {
        let coherence = vec![1.0; value.len()];
        Self { sample_period_s: 0.0, frequency_hz, value, coherence, averages: 1.0 }
    }

    /// Magnitude in dB.
    #[must_use]
    pub fn magnitude_db(&self) -> Vec<f64> {
        self.value.iter().map(|h| 20.0 * h.norm().log10()).collect()
    }

    /// Phase in rad, unwrapped from the first line on.
    #[must_use]
    pub fn phase_rad(&self) -> Vec<f64> {
        let mut turns = 0.0;
        let mut last: Option<f64> = None;
        self.value
            .iter()
            .map(|h| {
                let raw = h.arg();
                if let Some(before) = last {
                    turns -= ((raw - before) / TAU).round();
                }
                last = Some(raw);
                raw + turns * TAU
            })
            .collect()
    }

    /// Normalised random error of the magnitude, which is also the phase's standard deviation in rad:
    /// `sqrt(1 - g) / sqrt(2 n g)` with coherence `g` and `n` averages (Bendat and Piersol, table 9.6).
    /// A first-order formula: too small where coherence is below about 0.1.
    #[must_use]
    pub fn relative_error(&self) -> Vec<f64> {
        self.coherence
            .iter()
            .map(|g| if *g > 0.0 { ((1.0 - g) / (2.0 * self.averages * g)).sqrt() } else { f64::INFINITY })
            .collect()
    }

    /// Bounds of the magnitude in dB, `deviations` standard deviations (1.96 for 95 %) below and above.
    /// Below `-inf` means that the line's magnitude cannot be told from zero.
    #[must_use]
    pub fn bounds_db(&self, deviations: f64) -> Vec<(f64, f64)> {
        self.magnitude_db()
            .iter()
            .zip(self.relative_error())
            .map(|(db, e)| {
                let below = (1.0 - deviations * e).max(0.0);
                (db + 20.0 * below.log10(), db + 20.0 * (1.0 + deviations * e).log10())
            })
            .collect()
    }

    /// The response with the effect of the command's hold divided out.
    #[must_use]
    pub fn without_hold(mut self, hold: Hold) -> Self {
        for (f, h) in self.frequency_hz.iter().zip(&mut self.value) {
            *h /= hold.response(*f, self.sample_period_s);
        }
        self
    }

    /// Only the lines within `from_hz..=to_hz` whose coherence is at least `least_coherence`.
    #[must_use]
    pub fn band(&self, from_hz: f64, to_hz: f64, least_coherence: f64) -> Self {
        let keep = |i: &usize| {
            (from_hz..=to_hz).contains(&self.frequency_hz[*i]) && self.coherence[*i] >= least_coherence
        };
        let lines: Vec<usize> = (0..self.frequency_hz.len()).filter(keep).collect();
        Self {
            sample_period_s: self.sample_period_s,
            frequency_hz: lines.iter().map(|&i| self.frequency_hz[i]).collect(),
            value: lines.iter().map(|&i| self.value[i]).collect(),
            coherence: lines.iter().map(|&i| self.coherence[i]).collect(),
            averages: self.averages,
        }
    }
}
