//! Fewer points without losing a peak.

/// At most about `limit` of the points, in their order: of each stretch the first, least, greatest and
/// last by value, so that every peak stays.
///
/// A point with a value that is not a number ends a line; such gaps stay.
#[must_use]
pub fn decimate(points: &[(f64, f64)], limit: usize) -> Vec<(f64, f64)> {
    if points.len() <= limit.max(4) {
        return points.to_vec();
    }
    let stretches = (limit / 4).max(1);
    let mut kept = Vec::with_capacity(4 * stretches);
    for s in 0..stretches {
        let begin = s * points.len() / stretches;
        let end = (s + 1) * points.len() / stretches;
        let mut chosen = vec![begin, end - 1];
        let values = || (begin..end).filter(|&i| points[i].1.is_finite());
        chosen.extend(values().min_by(|&a, &b| points[a].1.total_cmp(&points[b].1)));
        chosen.extend(values().max_by(|&a, &b| points[a].1.total_cmp(&points[b].1)));
        // A gap must stay a gap.
        chosen.extend((begin..end).find(|&i| !points[i].1.is_finite()));
        chosen.sort_unstable();
        chosen.dedup();
        kept.extend(chosen.into_iter().map(|i| points[i]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_ends_and_order_stay() {
        let mut points: Vec<(f64, f64)> =
            (0..100_000).map(|i| (f64::from(i) * 1e-3, (f64::from(i) * 0.01).sin())).collect();
        points[54_321].1 = 17.0;
        points[77_777].1 = -23.0;
        let kept = decimate(&points, 2000);
        assert!(kept.len() <= 2000);
        assert!(kept.contains(&points[54_321]) && kept.contains(&points[77_777]));
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        assert!(kept.windows(2).all(|w| w[0].0 < w[1].0));
    }

    #[test]
    fn gaps_stay_and_short_series_are_untouched() {
        let mut points: Vec<(f64, f64)> = (0..10_000).map(|i| (f64::from(i), 1.0)).collect();
        points[5_000].1 = f64::NAN;
        assert!(decimate(&points, 400).iter().any(|p| p.1.is_nan()));
        assert_eq!(decimate(&points[..50], 400), &points[..50]);
    }
}
