//! Values between irregular time stamps, and the one resampling onto an even grid.

/// The straight line's value at `t` between the two samples around it; `None` outside the record.
#[must_use]
pub fn at(time_s: &[f64], values: &[f64], t: f64) -> Option<f64> {
    let after = time_s.partition_point(|&x| x < t);
    if after == time_s.len() {
        return None;
    }
    if time_s[after] == t {
        return Some(values[after]);
    }
    let before = after.checked_sub(1)?;
    let share = (t - time_s[before]) / (time_s[after] - time_s[before]);
    Some(values[before] + share * (values[after] - values[before]))
}

/// Values on an even grid from the first to the last time stamp, by straight lines. `hold` keeps the
/// value before instead, as a zero-order held command does.
#[must_use]
pub fn uniform(time_s: &[f64], values: &[f64], period_s: f64, hold: bool) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else { return Vec::new() };
    let count = ((last - first) / period_s + 1e-6).floor() as usize + 1;
    let mut next = 0;
    (0..count)
        .map(|i| {
            // A hair of tolerance keeps grid points on the samples of an even record.
            let t = first + i as f64 * period_s;
            while next < time_s.len() && time_s[next] <= t + 1e-6 * period_s {
                next += 1;
            }
            let before = next.saturating_sub(1);
            if hold || next >= time_s.len() {
                return values[before];
            }
            let share = ((t - time_s[before]) / (time_s[next] - time_s[before])).clamp(0.0, 1.0);
            values[before] + share * (values[next] - values[before])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_straight_line_survives_irregular_sampling() {
        let time = [0.0, 0.1, 0.35, 0.4, 1.0];
        let line: Vec<f64> = time.iter().map(|t| 3.0 * t - 1.0).collect();
        let even = uniform(&time, &line, 0.05, false);
        assert_eq!(even.len(), 21);
        for (i, v) in even.iter().enumerate() {
            assert!((v - (3.0 * 0.05 * i as f64 - 1.0)).abs() < 1e-12);
        }
        assert_eq!(uniform(&time, &line, 0.05, true)[6], line[1]);
        assert_eq!(at(&time, &line, 1.1), None);
        assert!((at(&time, &line, 0.2).unwrap() + 0.4).abs() < 1e-12);
    }
}
