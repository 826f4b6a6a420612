//! Small statistics that more than one module needs.

/// The median; 0 of nothing.
#[must_use]
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The median distance between neighbouring time stamps, s; 0 of fewer than two.
#[must_use]
pub fn median_period(time_s: &[f64]) -> f64 {
    median(&time_s.windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>())
}

/// The value below which a share `q` of the values lies, by the nearest rank; 0 of nothing.
#[must_use]
pub fn quantile(values: &[f64], q: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let mut copy = values.to_vec();
    let rank = (q.clamp(0.0, 1.0) * (copy.len() - 1) as f64).round() as usize;
    *copy.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// The mean; 0 of nothing.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// Root mean square; 0 of nothing.
#[must_use]
pub fn rms(values: &[f64]) -> f64 {
    if values.is_empty() {
        0.0
    } else {
        (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
    }
}

/// Root mean square about the mean; 0 of nothing.
#[must_use]
pub fn std(values: &[f64]) -> f64 {
    let m = mean(values);
    if values.is_empty() {
        0.0
    } else {
        (values.iter().map(|v| (v - m) * (v - m)).sum::<f64>() / values.len() as f64).sqrt()
    }
}

/// Pseudo-random numbers with the same bits for the same seed (SplitMix64).
#[derive(Debug, Clone)]
pub(crate) struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Between 0 and 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Of mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Sums of neighbours that make a mean square.
const FEWEST_SUMS: usize = 8;

/// Independent samples in a residual of mean 0: their number over the greatest ratio of the mean square of sums of neighbours to that
/// of as many independent ones (the method of batch means).
#[must_use]
pub fn independent(residual: &[f64]) -> f64 {
    let n = residual.len() as f64;
    let mean_square = residual.iter().map(|r| r * r).sum::<f64>() / n.max(1.0);
    if mean_square <= 0.0 {
        return n;
    }
    let lengths =
        std::iter::successors(Some(2), |l| Some(2 * l)).take_while(|l| l * FEWEST_SUMS <= residual.len());
    let ratio = |length: usize| {
        let sums = residual.chunks_exact(length).map(|c| c.iter().sum::<f64>().powi(2));
        let count = (residual.len() / length) as f64;
        sums.sum::<f64>() / count / (length as f64 * mean_square)
    };
    n / lengths.map(ratio).fold(1.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::{Noise, independent};

    #[test]
    fn white_noise_is_as_many_samples_as_it_has_and_a_drift_is_few() {
        let mut noise = Noise::new(7);
        let white: Vec<f64> = (0..4096).map(|_| noise.normal()).collect();
        assert!(independent(&white) > 2000.0, "{}", independent(&white));
        let drift: Vec<f64> = (0..4096).map(|i| (f64::from(i) / 4096.0 * 7.0).sin()).collect();
        assert!(independent(&drift) < 20.0, "{}", independent(&drift));
        // An autoregression with a memory of a samples counts 2 a times less.
        let mut state = 0.0;
        let slow: Vec<f64> = (0..65536)
            .map(|_| {
                state += (noise.normal() - state) / 50.0;
                state
            })
            .collect();
        let samples = independent(&slow);
        assert!((300.0..1300.0).contains(&samples), "{samples}");
    }
}
