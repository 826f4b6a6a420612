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

/// The points between which straight lines stay within a tolerance of all the others, first and last among them.
///
/// A point with a value that is not a number ends a line; such gaps stay.
#[must_use]
pub fn straightened(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    let mut next = 0;
    while let Some(&first) = points.get(next) {
        kept.push(first);
        next += 1;
        if !first.1.is_finite() {
            continue;
        }
        // The point where the present line begins, and the slopes of the lines from there that pass all points since.
        let (mut from, mut last) = (first, first);
        let (mut least, mut greatest) = (f64::NEG_INFINITY, f64::INFINITY);
        while let Some(&point) = points.get(next).filter(|p| p.1.is_finite()) {
            let (run, rise) = (point.0 - from.0, point.1 - from.1);
            if !(least..=greatest).contains(&(rise / run)) {
                kept.push(last);
                from = last;
                (least, greatest) = (f64::NEG_INFINITY, f64::INFINITY);
                continue;
            }
            least = least.max((rise - tolerance) / run);
            greatest = greatest.min((rise + tolerance) / run);
            last = point;
            next += 1;
        }
        if last.0 > from.0 {
            kept.push(last);
        }
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

    #[test]
    fn straight_lines_between_what_is_kept_pass_every_other_point() {
        let points: Vec<(f64, f64)> = (0..10_000)
            .map(|i| {
                let t = f64::from(i) * 1e-3;
                (t, if (2000..2100).contains(&i) { f64::NAN } else { (3.0 * t * t).sin() })
            })
            .collect();
        let kept = straightened(&points, 1e-3);
        assert!(kept.len() < points.len() / 2, "{}", kept.len());
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        let mut lines = kept.windows(2).peekable();
        for p in points.iter().filter(|p| p.1.is_finite()) {
            while lines.peek().is_some_and(|l| l[1].0 < p.0) {
                lines.next();
            }
            let [a, b] = lines.peek().unwrap()[..] else { unreachable!() };
            let on_line = if p.0 == a.0 {
                a.1
            } else if p.0 == b.0 {
                b.1
            } else {
                a.1 + (b.1 - a.1) * (p.0 - a.0) / (b.0 - a.0)
            };
            assert!((on_line - p.1).abs() <= 1.001e-3, "{p:?} beside {on_line}");
        }
        assert_eq!(kept.iter().filter(|p| p.1.is_nan()).count(), 100);
        assert_eq!(straightened(&points[..1], 1.0), &points[..1]);
        assert!(straightened(&[], 1.0).is_empty());
    }
}
