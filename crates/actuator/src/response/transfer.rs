//! A rational transfer function of `s`, with its modes.

use std::f64::consts::TAU;

use num_complex::Complex64;
use serde::Serialize;

use super::Polynomial;

/// A ratio of two polynomials in `s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer {
    numerator: Polynomial,
    denominator: Polynomial,
}

/// A pole or zero as an oscillation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mode {
    /// `|s|/2 pi`, Hz: the undamped natural frequency, or the corner of a real root.
    pub frequency_hz: f64,
    /// `-Re s/|s|`: 1 for a real root.
    pub damping_ratio: f64,
}

impl Transfer {
    /// From numerator and denominator.
    #[must_use]
    pub fn new(numerator: Polynomial, denominator: Polynomial) -> Self {
        Self { numerator, denominator }
    }

    /// The value at a complex `s`, rad/s. At `s = 0` between free links it is not defined (NaN).
    #[must_use]
    pub fn at(&self, s: Complex64) -> Complex64 {
        self.numerator.at(s) / self.denominator.at(s)
    }

    /// The value at a frequency, Hz.
    #[must_use]
    pub fn at_hz(&self, frequency_hz: f64) -> Complex64 {
        self.at(Complex64::new(0.0, TAU * frequency_hz))
    }

    /// Roots of the denominator, rad/s.
    #[must_use]
    pub fn poles(&self) -> Vec<Complex64> {
        self.denominator.roots()
    }

    /// Roots of the numerator, rad/s.
    #[must_use]
    pub fn zeros(&self) -> Vec<Complex64> {
        self.numerator.roots()
    }

    /// Natural frequencies: the oscillating poles, by ascending frequency.
    #[must_use]
    pub fn resonances(&self) -> Vec<Mode> {
        oscillations(&self.poles())
    }

    /// Anti-resonances: the oscillating zeros, by ascending frequency.
    #[must_use]
    pub fn anti_resonances(&self) -> Vec<Mode> {
        oscillations(&self.zeros())
    }
}

/// One mode for each complex pair of roots.
fn oscillations(roots: &[Complex64]) -> Vec<Mode> {
    roots
        .iter()
        .filter(|s| s.im > 1e-9 * s.norm())
        .map(|s| Mode { frequency_hz: s.norm() / TAU, damping_ratio: -s.re / s.norm() })
        .collect()
}
