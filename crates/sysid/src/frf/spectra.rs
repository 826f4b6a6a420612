//! Averaged auto and cross spectra of an input and an output by Welch's method.

use num_complex::Complex64;
use realfft::RealFftPlanner;

use super::{FrfError, Window};

/// What is taken out of a segment before its transform.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Detrend {
    /// Nothing.
    None,
    /// The segment's mean.
    #[default]
    Mean,
    /// The segment's least-squares line.
    Line,
}

/// Settings of Welch's method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Welch {
    /// Samples of one segment.
    pub segment: usize,
    /// Samples that neighbouring segments share; half a segment is usual with [`Window::Hann`].
    pub overlap: usize,
    /// The window.
    pub window: Window,
    /// What is taken out of each segment.
    pub detrend: Detrend,
}

impl Welch {
    /// Hann window, half overlap, mean removed.
    #[must_use]
    pub fn hann(segment: usize) -> Self {
        Self { segment, overlap: segment / 2, window: Window::Hann, detrend: Detrend::Mean }
    }

    /// Averaged spectra of several runs of the same experiment, each `(input, output)` sampled every
    /// `sample_period_s`. Segments never reach across two runs.
    ///
    /// # Errors
    ///
    /// [`FrfError::LengthMismatch`], [`FrfError::TooShort`], or [`FrfError::BadSetting`].
    pub fn spectra(&self, sample_period_s: f64, runs: &[(&[f64], &[f64])]) -> Result<Spectra, FrfError> {
        self.check(sample_period_s)?;
        let n = self.segment;
        let step = n - self.overlap;
        let window = self.window.samples(n);
        let bins = n / 2 + 1;
        let mut input = vec![0.0; bins];
        let mut output = vec![0.0; bins];
        let mut cross = vec![Complex64::ZERO; bins];
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
        let mut scratch = transform.make_scratch_vec();
        let mut buffer = vec![0.0; n];
        let (mut x, mut y) = (transform.make_output_vec(), transform.make_output_vec());
        let mut averages = 0;
        let mut inner = 0.0; // sum over runs of what overlap adds to the variance, Welch (1967)
        let correlation = overlap_correlation(&window, step);
        for (run, &(u, v)) in runs.iter().enumerate() {
            if u.len() != v.len() {
                return Err(FrfError::LengthMismatch { run, input: u.len(), output: v.len() });
            }
            if u.len() < n {
                continue;
            }
            let segments = (u.len() - n) / step + 1;
            for start in (0..segments).map(|k| k * step) {
                for (signal, spectrum) in [(u, &mut x), (v, &mut y)] {
                    buffer.copy_from_slice(&signal[start..start + n]);
                    self.detrend.apply(&mut buffer);
                    buffer.iter_mut().zip(&window).for_each(|(b, w)| *b *= w);
                    // The lengths are those of the plan, so the transform cannot fail.
                    let _ = transform.process_with_scratch(&mut buffer, spectrum, &mut scratch);
                }
                for i in 0..bins {
                    input[i] += x[i].norm_sqr();
                    output[i] += y[i].norm_sqr();
                    cross[i] += x[i].conj() * y[i];
                }
            }
            averages += segments;
            inner += segments as f64
                + 2.0
                    * correlation
                        .iter()
                        .enumerate()
                        .map(|(j, rho)| (segments as f64 - (j + 1) as f64).max(0.0) * rho)
                        .sum::<f64>();
        }
        if averages == 0 {
            let longest = runs.iter().map(|r| r.0.len()).max().unwrap_or(0);
            return Err(FrfError::TooShort { longest, segment: n });
        }
        let power: f64 = window.iter().map(|w| w * w).sum();
        let scale = sample_period_s / (power * averages as f64);
        for i in 0..bins {
            // One-sided: every line but those at zero and at half the sampling frequency stands for two.
            let alone = i == 0 || (n.is_multiple_of(2) && i == bins - 1);
            let factor = if alone { scale } else { 2.0 * scale };
            input[i] *= factor;
            output[i] *= factor;
            cross[i] *= factor;
        }
        let frequency_hz = (0..bins).map(|i| i as f64 / (n as f64 * sample_period_s)).collect();
        let effective_averages = (averages as f64).powi(2) / inner;
        Ok(Spectra { sample_period_s, frequency_hz, input, output, cross, averages, effective_averages })
    }

    fn check(&self, sample_period_s: f64) -> Result<(), FrfError> {
        let bad = |what, value, admitted| Err(FrfError::BadSetting { what, value, admitted });
        if self.segment < 2 {
            return bad("segment", self.segment as f64, "at least 2 samples");
        }
        if self.overlap >= self.segment {
            return bad("overlap", self.overlap as f64, "less than a segment");
        }
        if !(sample_period_s > 0.0 && sample_period_s.is_finite()) {
            return bad("sample period", sample_period_s, "positive");
        }
        Ok(())
    }
}

impl Detrend {
    fn apply(self, values: &mut [f64]) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        match self {
            Self::None => {}
            Self::Mean => values.iter_mut().for_each(|v| *v -= mean),
            Self::Line => {
                let middle = (n - 1.0) / 2.0;
                let (mut top, mut bottom) = (0.0, 0.0);
                for (i, v) in values.iter().enumerate() {
                    let t = i as f64 - middle;
                    top += t * v;
                    bottom += t * t;
                }
                let slope = top / bottom;
                for (i, v) in values.iter_mut().enumerate() {
                    *v -= mean + slope * (i as f64 - middle);
                }
            }
        }
    }
}

/// Squared correlation of the periodograms of segments that are `1, 2, ...` steps apart.
fn overlap_correlation(window: &[f64], step: usize) -> Vec<f64> {
    let power: f64 = window.iter().map(|w| w * w).sum();
    (1..)
        .map(|j| j * step)
        .take_while(|shift| *shift < window.len())
        .map(|shift| {
            let product: f64 = window[shift..].iter().zip(window).map(|(a, b)| a * b).sum();
            (product / power).powi(2)
        })
        .collect()
}

/// One-sided averaged spectral densities of an input and an output.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectra {
    /// Sampling period of the signals, s.
    pub sample_period_s: f64,
    /// The lines' frequencies, Hz, from zero to half the sampling frequency.
    pub frequency_hz: Vec<f64>,
    /// Power spectral density of the input, unit squared per Hz.
    pub input: Vec<f64>,
    /// Power spectral density of the output, unit squared per Hz.
    pub output: Vec<f64>,
    /// Cross spectral density `conj(input) output`.
    pub cross: Vec<Complex64>,
    /// Segments averaged.
    pub averages: usize,
    /// How many independent segments would leave the same variance: overlapping ones share samples.
    pub effective_averages: f64,
}
