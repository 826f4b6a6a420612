//! Rational fits of a frequency response: Sanathanan-Koerner iterations, then Gauss-Newton on the true error.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::{FrequencyResponse, FrfError};

/// How much each line of a response counts in a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FitWeight {
    /// By the random error of the estimate, `|H|^2 (1 - g) / (2 n g)`: the maximum-likelihood choice where coherence is
    /// lost to output noise. Coherence is taken to be at most 0.9999, so that no few lines decide alone.
    #[default]
    Coherence,
    /// Every line by its relative error alike.
    Relative,
    /// Every line by its absolute error alike.
    Absolute,
}

/// A ratio of polynomials in `s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Rational {
    /// Numerator, ascending powers of `s`.
    pub numerator: Vec<f64>,
    /// Denominator, ascending powers of `s`; the last one is 1.
    pub denominator: Vec<f64>,
}

impl Rational {
    /// The value at a complex `s`, 1/s.
    #[must_use]
    pub fn at(&self, s: Complex64) -> Complex64 {
        polynomial(&self.numerator, s) / polynomial(&self.denominator, s)
    }

    /// The value at a frequency in Hz.
    #[must_use]
    pub fn at_hz(&self, frequency_hz: f64) -> Complex64 {
        self.at(Complex64::new(0.0, TAU * frequency_hz))
    }
}

fn polynomial(coefficients: &[f64], s: Complex64) -> Complex64 {
    coefficients.iter().rev().fold(Complex64::ZERO, |sum, c| sum * s + c)
}

/// A fitted rational function.
#[derive(Debug, Clone, PartialEq)]
pub struct RationalFit {
    /// The function.
    pub function: Rational,
    /// Standard errors of the numerator's coefficients and of all but the last of the denominator's, from the weighted
    /// residual's own size.
    pub standard_error: Rational,
    /// Root mean square of the relative error `|fit - H| / |H|` over the lines used.
    pub relative_rms: f64,
    /// Whether the last step changed no coefficient by more than 1e-9 of itself.
    pub converged: bool,
}

/// Fits a ratio of a polynomial of degree `numerator_degree` over a monic one of `denominator_degree`.
///
/// Lines at zero frequency count too. The frequency is scaled inside, so that powers of `s` stay comparable.
///
/// # Errors
///
/// [`FrfError::TooFewPoints`] or [`FrfError::Singular`].
pub fn fit_rational(
    response: &FrequencyResponse,
    numerator_degree: usize,
    denominator_degree: usize,
    weight: FitWeight,
) -> Result<RationalFit, FrfError> {
    let (top, bottom) = (numerator_degree + 1, denominator_degree);
    let unknowns = top + bottom;
    let lines = weighted_lines(response, weight);
    if 2 * lines.len() < unknowns + 1 || lines.len() < denominator_degree {
        return Err(FrfError::TooFewPoints { points: lines.len(), unknowns });
    }
    let scale = frequency_scale(&lines);
    let lines: Vec<Line> = lines.into_iter().map(|l| Line { s: l.s / scale, ..l }).collect();

    let mut x = DVector::zeros(unknowns);
    let mut before = vec![1.0];
    for _ in 0..40 {
        // |N - H (D' + s^m)|^2 / |D_before|^2, linear in the coefficients
        let (a, rhs) = stack(&lines, unknowns, |l, row| {
            let d = polynomial(&before, l.s);
            let w = l.weight / d.norm();
            for k in 0..top {
                row[k] = l.s.powu(k as u32) * w;
            }
            for k in 0..bottom {
                row[top + k] = -l.h * l.s.powu(k as u32) * w;
            }
            l.h * l.s.powu(bottom as u32) * w
        });
        let next = least_squares(a, &rhs).ok_or(FrfError::Singular { unknowns })?;
        let change = relative_change(&x, &next);
        x = next;
        before = x.rows(top, bottom).iter().copied().chain([1.0]).collect();
        if change < 1e-9 {
            break;
        }
    }
    let (x, covariance, converged) = refine(&lines, x, top, bottom).ok_or(FrfError::Singular { unknowns })?;

    let unscale = |k: usize| scale.powi(bottom as i32 - k as i32);
    let deviation = |i: usize| covariance[(i, i)].max(0.0).sqrt();
    let numerator = (0..top).map(|k| x[k] * unscale(k)).collect();
    let denominator = (0..bottom).map(|k| x[top + k] * unscale(k)).chain([1.0]).collect();
    let standard_error = Rational {
        numerator: (0..top).map(|k| deviation(k) * unscale(k)).collect(),
        denominator: (0..bottom).map(|k| deviation(top + k) * unscale(k)).collect(),
    };
    let function = Rational { numerator, denominator };
    let squares: f64 = lines
        .iter()
        .map(|l| ((function.at(l.s * scale) - l.h).norm() / l.h.norm().max(1e-300)).powi(2))
        .sum();
    let relative_rms = (squares / lines.len() as f64).sqrt();
    Ok(RationalFit { function, standard_error, relative_rms, converged })
}

/// One line of a response in a fit.
#[derive(Clone, Copy)]
struct Line {
    s: Complex64,
    h: Complex64,
    weight: f64,
}

fn weighted_lines(response: &FrequencyResponse, weight: FitWeight) -> Vec<Line> {
    (0..response.frequency_hz.len())
        .filter_map(|i| {
            let h = response.value[i];
            let g = response.coherence[i].min(0.9999);
            let weight = match weight {
                FitWeight::Coherence => (g / (1.0 - g)).sqrt() / h.norm(),
                FitWeight::Relative => 1.0 / h.norm(),
                FitWeight::Absolute => 1.0,
            };
            let s = Complex64::new(0.0, TAU * response.frequency_hz[i]);
            (weight > 0.0 && weight.is_finite() && h.is_finite()).then_some(Line { s, h, weight })
        })
        .collect()
}

/// The geometric mean of the frequencies above zero, rad/s.
fn frequency_scale(lines: &[Line]) -> f64 {
    let logs: Vec<f64> = lines.iter().filter(|l| l.s.im > 0.0).map(|l| l.s.im.ln()).collect();
    if logs.is_empty() { 1.0 } else { (logs.iter().sum::<f64>() / logs.len() as f64).exp() }
}

/// Real and imaginary rows of a complex linear system.
fn stack(
    lines: &[Line],
    unknowns: usize,
    mut fill: impl FnMut(&Line, &mut [Complex64]) -> Complex64,
) -> (DMatrix<f64>, DVector<f64>) {
    let mut a = DMatrix::zeros(2 * lines.len(), unknowns);
    let mut rhs = DVector::zeros(2 * lines.len());
    let mut row = vec![Complex64::ZERO; unknowns];
    for (i, line) in lines.iter().enumerate() {
        let b = fill(line, &mut row);
        for (k, value) in row.iter().enumerate() {
            a[(2 * i, k)] = value.re;
            a[(2 * i + 1, k)] = value.im;
        }
        rhs[2 * i] = b.re;
        rhs[2 * i + 1] = b.im;
    }
    (a, rhs)
}

fn least_squares(a: DMatrix<f64>, rhs: &DVector<f64>) -> Option<DVector<f64>> {
    let qr = a.qr();
    let projected = qr.q().transpose() * rhs;
    qr.r().solve_upper_triangular(&projected).filter(|x| x.iter().all(|v| v.is_finite()))
}

fn relative_change(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / b.abs().max(1e-12)).fold(0.0, f64::max)
}

/// Gauss-Newton on `weight |N/D - H|` with halved steps; returns the coefficients and their covariance.
fn refine(
    lines: &[Line],
    start: DVector<f64>,
    top: usize,
    bottom: usize,
) -> Option<(DVector<f64>, DMatrix<f64>, bool)> {
    let unknowns = top + bottom;
    let system = |x: &DVector<f64>| {
        let denominator: Vec<f64> = x.rows(top, bottom).iter().copied().chain([1.0]).collect();
        let numerator: Vec<f64> = x.rows(0, top).iter().copied().collect();
        stack(lines, unknowns, |l, row| {
            let (n, d) = (polynomial(&numerator, l.s), polynomial(&denominator, l.s));
            for k in 0..top {
                row[k] = l.s.powu(k as u32) / d * l.weight;
            }
            for k in 0..bottom {
                row[top + k] = -n * l.s.powu(k as u32) / (d * d) * l.weight;
            }
            (l.h - n / d) * l.weight
        })
    };
    let mut x = start;
    let (mut jacobian, mut residual) = system(&x);
    let mut converged = false;
    for _ in 0..30 {
        let step = least_squares(jacobian.clone(), &residual)?;
        let mut factor = 1.0;
        let mut accepted = None;
        while factor > 1e-4 {
            let trial = &x + &step * factor;
            let (j, r) = system(&trial);
            if r.norm_squared() <= residual.norm_squared() {
                accepted = Some((trial, j, r));
                break;
            }
            factor /= 2.0;
        }
        // No step leads further down: this is the minimum to rounding.
        let Some((trial, j, r)) = accepted else {
            converged = true;
            break;
        };
        let change = relative_change(&x, &trial);
        (x, jacobian, residual) = (trial, j, r);
        if change < 1e-9 {
            converged = true;
            break;
        }
    }
    let freedom = (residual.len() as f64 - unknowns as f64).max(1.0);
    let covariance = (jacobian.transpose() * &jacobian).try_inverse()? * (residual.norm_squared() / freedom);
    Some((x, covariance, converged))
}

/// A second-order low pass `c / (s^2 + a s + b)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondOrder {
    /// `c`, output per input times 1/s^2.
    pub numerator: f64,
    /// `a`, 1/s.
    pub first: f64,
    /// `b`, 1/s^2.
    pub zeroth: f64,
    /// Standard errors of `c`, `a` and `b`.
    pub standard_error: [f64; 3],
}

impl SecondOrder {
    /// `sqrt(b) / 2 pi`, Hz.
    #[must_use]
    pub fn natural_frequency_hz(&self) -> f64 {
        self.zeroth.max(0.0).sqrt() / TAU
    }

    /// `a / (2 sqrt(b))`.
    #[must_use]
    pub fn damping_ratio(&self) -> f64 {
        self.first / (2.0 * self.zeroth.max(0.0).sqrt())
    }

    /// `c / b`.
    #[must_use]
    pub fn static_gain(&self) -> f64 {
        self.numerator / self.zeroth
    }
}

/// Fits `c / (s^2 + a s + b)` with all three free, as eq. 3-14 of the dissertation does.
///
/// # Errors
///
/// As [`fit_rational`].
pub fn fit_second_order(response: &FrequencyResponse, weight: FitWeight) -> Result<SecondOrder, FrfError> {
    let fit = fit_rational(response, 0, 2, weight)?;
    Ok(SecondOrder {
        numerator: fit.function.numerator[0],
        first: fit.function.denominator[1],
        zeroth: fit.function.denominator[0],
        standard_error: [
            fit.standard_error.numerator[0],
            fit.standard_error.denominator[1],
            fit.standard_error.denominator[0],
        ],
    })
}
