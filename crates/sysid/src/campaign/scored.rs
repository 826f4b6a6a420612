//! Which rows of a run count for errors.

use super::{FEWEST_ROWS, NoiseStd, Run};
use sealegs_model::Unit;
use std::ops::Range;

/// The message for bounds that leave too little.
pub(super) fn too_few_rows(run: &str) -> String {
    format!("leave fewer than {FEWEST_ROWS} rows of {run}")
}

/// Rows with `from_s <= time <= to_s` (to a nanosecond, as decimal digits are not exact), if they are enough.
pub(super) fn scored_rows(time_s: &[f64], from_s: Option<f64>, to_s: Option<f64>) -> Option<Range<usize>> {
    let start = from_s.map_or(0, |t| time_s.partition_point(|&x| x < t - 1e-9));
    let end = to_s.map_or(time_s.len(), |t| time_s.partition_point(|&x| x <= t + 1e-9));
    (start + FEWEST_ROWS <= end).then_some(start..end)
}

/// A jump of a sensor from the first row to the second beyond this many times the noise, and this share of all that the
/// channel does, is no answer to the first command: the rig was in motion. A drive's current is none of the rig's motion:
/// it jumps to whatever the controller begins with.
const IN_MOTION: (f64, f64) = (20.0, 0.02);

/// Share of a run that begins in motion that does not count: models begin at rest, and forget that.
const FORGOTTEN: f64 = 0.05;

/// Leaves the beginning of a run that begins in motion out of what counts, unless the campaign says where to begin;
/// returns a remark.
pub(super) fn skip_start_in_motion(run: &mut Run, noise: &[NoiseStd]) -> Option<String> {
    let sensors = run.record.outputs.iter().filter(|s| Unit::of_channel(&s.channel) != Ok(Unit::Ampere));
    let moves = sensors.filter(|s| !run.left_out.has_spike(&s.channel, 0..2)).any(|s| {
        let std = noise.iter().find(|n| n.channel == s.channel).map_or(0.0, |n| n.std);
        let (low, high) = s.values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        let jump = (s.values[1] - s.values[0]).abs();
        std > 0.0 && jump > IN_MOTION.0 * std && jump > IN_MOTION.1 * (high - low)
    });
    let rows = (FORGOTTEN * run.record.len() as f64) as usize;
    if !moves || run.scored.start > 0 || run.scored.len() < rows + FEWEST_ROWS || rows == 0 {
        return None;
    }
    run.scored.start = rows;
    let span = run.record.time_s[rows] - run.record.time_s[0];
    Some(format!(
        "{}: begins in motion; its first {span:.3} s do not count, as a model begins at rest",
        run.record.name
    ))
}
