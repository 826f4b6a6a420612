//! The sinc under a Kaiser window: what interpolates a band-limited signal from its samples.

use std::f64::consts::PI;

/// `sin(pi x) / (pi x)` under a Kaiser window of shape `beta` that ends at `half_width`, both in samples; 1 at 0.
///
/// Source: J. F. Kaiser 1974, the `I_0`-sinh window.
pub(crate) fn windowed_sinc(x: f64, half_width: f64, beta: f64) -> f64 {
    let sinc = if x.abs() < 1e-12 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let inside = (1.0 - (x / half_width).powi(2)).max(0.0);
    sinc * bessel_i0(beta * inside.sqrt()) / bessel_i0(beta)
}

/// Modified Bessel function of the first kind of order 0, by its power series.
fn bessel_i0(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-16 * sum {
        term *= (x / (2.0 * k)).powi(2);
        sum += term;
        k += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_bessel_values_and_the_samples_themselves() {
        // Abramowitz and Stegun, table 9.8: I_0(1) and I_0(5).
        assert!((bessel_i0(1.0) - 1.266_065_877_75).abs() < 1e-10);
        assert!((bessel_i0(5.0) - 27.239_871_823_6).abs() < 1e-9);
        assert_eq!(windowed_sinc(0.0, 8.0, 9.0), 1.0);
        assert!(windowed_sinc(3.0, 8.0, 9.0).abs() < 1e-15);
    }
}
