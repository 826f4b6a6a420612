//! Frequency responses from records: Welch spectra, H1, H2 and Hv estimates with coherence and confidence
//! bounds, peaks, and rational fits.
//!
//! The walk: [`Welch::spectra`] averages the auto and cross spectra of one or several runs,
//! [`Spectra::response`] makes a [`FrequencyResponse`] of them, [`FrequencyResponse::without_hold`] takes the
//! zero-order hold out, [`fit_rational`] and [`fit_second_order`] describe it by a few numbers, and
//! [`peak_near`] and [`peaks`] read resonances off it.
//!
//! Sources: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., chapters 6, 9 and 11 (estimates and their random
//! errors); P. D. Welch, *IEEE Trans. Audio Electroacoust.* 15 (1967) 70 (overlapped segments);
//! C. K. Sanathanan and J. Koerner, *IEEE Trans. Autom. Control* 8 (1963) 56 (rational fit).

mod fit;
mod peak;
mod response;
mod spectra;
mod window;

pub use fit::{FitWeight, Rational, RationalFit, SecondOrder, fit_rational, fit_second_order};
pub use peak::{Peak, falls_through, peak_near, peaks, trough_near};
pub use response::{Estimator, FrequencyResponse, Hold};
pub use spectra::{Detrend, Spectra, Welch};
pub use window::Window;

/// Why a frequency response could not be estimated or fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrfError {
    /// The input and the output of a run differ in length.
    #[error("run {run}: {input} input samples and {output} output samples")]
    LengthMismatch {
        /// Which run, from zero.
        run: usize,
        /// Samples of the input.
        input: usize,
        /// Samples of the output.
        output: usize,
    },
    /// No run is as long as one segment.
    #[error("the longest run has {longest} samples, fewer than one segment of {segment}")]
    TooShort {
        /// Samples of the longest run.
        longest: usize,
        /// Samples of a segment.
        segment: usize,
    },
    /// Settings that make no sense.
    #[error("{what} = {value}: must be {admitted}")]
    BadSetting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is admitted.
        admitted: &'static str,
    },
    /// Fewer usable frequencies than unknowns.
    #[error("{points} usable frequencies for {unknowns} unknowns")]
    TooFewPoints {
        /// Frequencies with a positive weight.
        points: usize,
        /// Coefficients to be found.
        unknowns: usize,
    },
    /// The least-squares problem is singular or not finite.
    #[error("the rational fit is singular: the response does not determine {unknowns} coefficients")]
    Singular {
        /// Coefficients to be found.
        unknowns: usize,
    },
}
