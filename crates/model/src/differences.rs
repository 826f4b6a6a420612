//! Sixth differences, which leave of a signal its noise: what is smooth over seven samples vanishes.

/// The variance of sixth differences of white noise over the noise's own: the sum of the squared weights.
pub const SIXTH_POWER: f64 = 924.0;

/// Sixth differences of samples that are so many rows apart, `x0 - 6 x1 + 15 x2 - 20 x3 + 15 x4 - 6 x5 + x6`.
pub fn sixth_differences(values: &[f64], spacing: usize) -> impl Iterator<Item = f64> + '_ {
    const WEIGHTS: [f64; 7] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];
    let last = values.len().saturating_sub((WEIGHTS.len() - 1) * spacing);
    (0..last).map(move |i| WEIGHTS.iter().enumerate().map(|(k, w)| w * values[i + k * spacing]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_fifth_degree_vanishes_and_an_impulse_shows_the_weights() {
        let smooth: Vec<f64> = (0..30).map(|i| f64::from(i).powi(5) - 3.0 * f64::from(i * i)).collect();
        assert!(sixth_differences(&smooth, 1).chain(sixth_differences(&smooth, 4)).all(|d| d.abs() < 1e-6));
        assert_eq!(sixth_differences(&smooth, 1).count(), 24);
        assert_eq!(sixth_differences(&smooth[..6], 1).count(), 0);
        let impulse: Vec<f64> = (0..13).map(|i| f64::from(u8::from(i == 6))).collect();
        assert_eq!(sixth_differences(&impulse, 1).map(|d| d * d).sum::<f64>(), SIXTH_POWER);
    }
}
