//! Windows of a Welch segment.

use std::f64::consts::TAU;

/// A window, in its periodic form (the one for spectra: `w[n]` of a cosine sum with period `len`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Window {
    /// `1`: for signals that are periodic in the segment.
    Rectangular,
    /// `0.5 - 0.5 cos`: the usual choice for noise.
    #[default]
    Hann,
    /// `0.54 - 0.46 cos`.
    Hamming,
    /// Five-term flat top of D'Antona and Ferrero, as in scipy: amplitudes of single tones.
    FlatTop,
}

impl Window {
    /// Coefficients of the cosine sum `sum_k (-1)^k a_k cos(2 pi k n / len)`.
    fn terms(self) -> &'static [f64] {
        match self {
            Self::Rectangular => &[1.0],
            Self::Hann => &[0.5, 0.5],
            Self::Hamming => &[0.54, 0.46],
            Self::FlatTop => &[0.215_578_95, 0.416_631_58, 0.277_263_158, 0.083_578_947, 0.006_947_368],
        }
    }

    /// The window's samples.
    #[must_use]
    pub fn samples(self, len: usize) -> Vec<f64> {
        (0..len)
            .map(|n| {
                let phase = TAU * n as f64 / len as f64;
                self.terms()
                    .iter()
                    .enumerate()
                    .map(|(k, a)| if k % 2 == 0 { *a } else { -a } * (k as f64 * phase).cos())
                    .sum()
            })
            .collect()
    }

    /// Equivalent noise bandwidth in bins: how far leakage smooths a spectrum.
    #[must_use]
    pub fn noise_bandwidth_bins(self) -> f64 {
        let a = self.terms();
        1.0 + a[1..].iter().map(|v| v * v).sum::<f64>() / (2.0 * a[0] * a[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_noise_bandwidths_are_the_textbook_ones() {
        for (window, bins) in [
            (Window::Rectangular, 1.0),
            (Window::Hann, 1.5),
            (Window::Hamming, 1.362_826),
            (Window::FlatTop, 3.770_2),
        ] {
            assert!((window.noise_bandwidth_bins() - bins).abs() < 1e-4, "{window:?}");
            let w = window.samples(64);
            let direct = 64.0 * w.iter().map(|v| v * v).sum::<f64>() / w.iter().sum::<f64>().powi(2);
            assert!((direct - bins).abs() < 1e-4, "{window:?}: {direct}");
        }
    }
}
