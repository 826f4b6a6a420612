//! Peaks, troughs and crossings of a magnitude curve, between its lines.

/// A local extremum of a magnitude curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Where, Hz, interpolated.
    pub frequency_hz: f64,
    /// How high, dB, interpolated.
    pub magnitude_db: f64,
    /// How far it stands out from the higher of the two valleys beside it, dB; `f64::NAN` where it was not asked for.
    pub prominence_db: f64,
}

/// The highest point within `from_hz..=to_hz`, refined by a least-squares parabola through the points within
/// `half_width_hz` of it (at least one on either side). A wide parabola averages the noise of an estimate; it must
/// stay narrower than the resonance.
///
/// `None` if the band holds no point, or if the highest one is at its edge, which is no peak.
#[must_use]
pub fn peak_near(
    frequency_hz: &[f64],
    magnitude_db: &[f64],
    from_hz: f64,
    to_hz: f64,
    half_width_hz: f64,
) -> Option<Peak> {
    let inside: Vec<usize> = (0..frequency_hz.len().min(magnitude_db.len()))
        .filter(|&i| (from_hz..=to_hz).contains(&frequency_hz[i]) && magnitude_db[i].is_finite())
        .collect();
    let top = inside.iter().copied().max_by(|&a, &b| magnitude_db[a].total_cmp(&magnitude_db[b]))?;
    if Some(&top) == inside.first() || Some(&top) == inside.last() {
        return None;
    }
    let mut refined = parabola_top(frequency_hz, magnitude_db, frequency_hz[top], half_width_hz, top)?;
    // Centre the parabola on what it found: the highest of many noisy points is not the middle.
    for _ in 0..4 {
        refined = parabola_top(frequency_hz, magnitude_db, refined.0, half_width_hz, top)?;
    }
    Some(Peak { frequency_hz: refined.0, magnitude_db: refined.1, prominence_db: f64::NAN })
}

/// The lowest point within a band, refined as in [`peak_near`].
#[must_use]
pub fn trough_near(
    frequency_hz: &[f64],
    magnitude_db: &[f64],
    from_hz: f64,
    to_hz: f64,
    half_width_hz: f64,
) -> Option<Peak> {
    let upside_down: Vec<f64> = magnitude_db.iter().map(|m| -m).collect();
    peak_near(frequency_hz, &upside_down, from_hz, to_hz, half_width_hz)
        .map(|p| Peak { magnitude_db: -p.magnitude_db, ..p })
}

/// Top of the least-squares parabola through the points within `half_width_hz` of `centre_hz`, and the
/// neighbours of `top` whatever the width. Falls back to `top` itself where the points do not bend downwards.
fn parabola_top(
    frequency_hz: &[f64],
    magnitude_db: &[f64],
    centre_hz: f64,
    half_width_hz: f64,
    top: usize,
) -> Option<(f64, f64)> {
    let mut low = frequency_hz.partition_point(|f| *f < centre_hz - half_width_hz);
    let mut high = frequency_hz.partition_point(|f| *f <= centre_hz + half_width_hz);
    low = low.min(top.saturating_sub(1));
    high = high.max(top + 2).min(frequency_hz.len());
    let scale = (frequency_hz[high - 1] - frequency_hz[low]) / 2.0;
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for i in low..high {
        let t = (frequency_hz[i] - centre_hz) / scale;
        let row = nalgebra::Vector3::new(1.0, t, t * t);
        normal += row * row.transpose();
        right += row * magnitude_db[i];
    }
    let c = normal.lu().solve(&right)?;
    if c[2] >= 0.0 {
        return Some((frequency_hz[top], magnitude_db[top]));
    }
    let t = (-c[1] / (2.0 * c[2])).clamp(-2.0, 2.0);
    Some((centre_hz + t * scale, c[0] + c[1] * t + c[2] * t * t))
}

/// All local maxima that stand out by at least `least_prominence_db`, interpolated by a parabola through three
/// points, in the order of frequency.
#[must_use]
pub fn peaks(frequency_hz: &[f64], magnitude_db: &[f64], least_prominence_db: f64) -> Vec<Peak> {
    let n = frequency_hz.len().min(magnitude_db.len());
    let mut found = Vec::new();
    for i in 1..n.saturating_sub(1) {
        let here = magnitude_db[i];
        if !(here > magnitude_db[i - 1] && here >= magnitude_db[i + 1]) {
            continue;
        }
        let valley = |side: &mut dyn Iterator<Item = usize>| {
            let mut lowest = here;
            for j in side {
                if magnitude_db[j] > here {
                    break;
                }
                lowest = lowest.min(magnitude_db[j]);
            }
            lowest
        };
        let prominence_db = here - valley(&mut (0..i).rev()).max(valley(&mut (i + 1..n)));
        if prominence_db < least_prominence_db {
            continue;
        }
        if let Some((f, db)) = parabola_top(frequency_hz, magnitude_db, frequency_hz[i], 0.0, i) {
            found.push(Peak { frequency_hz: f, magnitude_db: db, prominence_db });
        }
    }
    found
}

/// Where the curve first falls through `level_db` after `from_hz`, Hz, on a straight line between the two points.
#[must_use]
pub fn falls_through(frequency_hz: &[f64], magnitude_db: &[f64], level_db: f64, from_hz: f64) -> Option<f64> {
    let n = frequency_hz.len().min(magnitude_db.len());
    (1..n).filter(|&i| frequency_hz[i - 1] >= from_hz).find_map(|i| {
        let (a, b) = (magnitude_db[i - 1], magnitude_db[i]);
        (a >= level_db && b < level_db).then(|| {
            let part = (a - level_db) / (a - b);
            frequency_hz[i - 1] + part * (frequency_hz[i] - frequency_hz[i - 1])
        })
    })
}
