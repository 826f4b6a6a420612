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
