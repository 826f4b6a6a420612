//! Runs cut into pieces that each begin at the measured state: a joint that is driven by a force drifts away in open loop,
//! and after seconds of it the error says little of the model.

use super::{Clock, FEWEST_ROWS, LeftOut, Run};
use sealegs_model::Record;
use std::ops::Range;

/// What is wrong of pieces on another bench than those whose runs may begin in motion.
pub(super) const SUIT: &str = "is for the benches 'free' and 'robot', whose runs may begin in motion";

/// A run in pieces of so many seconds from the first row that counts on, each named after the time at which it begins; a
/// last piece of too few rows belongs to the one before. A run no longer than a piece stays as it is.
pub(super) fn cut(run: Run, window_s: f64, sample_rate_hz: Option<f64>) -> Vec<Run> {
    let pieces = pieces(&run.record.time_s, run.scored.clone(), window_s);
    if pieces.len() < 2 {
        return vec![run];
    }
    pieces.into_iter().map(|rows| piece(&run, rows, sample_rate_hz)).collect()
}

/// The rows of each piece.
fn pieces(time_s: &[f64], rows: Range<usize>, window_s: f64) -> Vec<Range<usize>> {
    let mut pieces: Vec<Range<usize>> = Vec::new();
    let mut from = rows.start;
    while from < rows.end {
        let end_s = time_s[from] + window_s - 1e-9;
        let to = rows.start + time_s[rows.clone()].partition_point(|&t| t < end_s);
        let to = to.max(from + 1);
        match pieces.last_mut() {
            Some(last) if to - from < FEWEST_ROWS => last.end = to,
            _ => pieces.push(from..to),
        }
        from = to;
    }
    pieces
}

fn piece(run: &Run, rows: Range<usize>, sample_rate_hz: Option<f64>) -> Run {
    let file = run.path.file_name().map_or_else(|| run.record.name.as_str().into(), |f| f.to_string_lossy());
    let name = format!("{file} from {:.1} s", run.record.time_s[rows.start]);
    let cut = run.record.cut || rows.start > 0;
    let record = Record { name, cut, ..run.record.at_rows(rows.clone()) };
    Run {
        scored: 0..record.len(),
        left_out: LeftOut::of(&record),
        unknown: run.unknown.iter().map(|s| s.at_rows(rows.clone())).collect(),
        clock: Clock::of(&record.time_s, sample_rate_hz),
        record,
        ..run.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::pieces;

    #[test]
    fn pieces_follow_one_another_and_a_short_rest_belongs_to_the_last() {
        let time_s: Vec<f64> = (0..205).map(|i| 0.01 * f64::from(i)).collect();
        assert_eq!(pieces(&time_s, 0..205, 0.5), [0..50, 50..100, 100..150, 150..205]);
        assert_eq!(pieces(&time_s, 20..120, 0.5), [20..70, 70..120]);
        assert_eq!(pieces(&time_s, 0..205, 9.0).len(), 1);
        // A gap in the log longer than a piece begins a new one.
        let gap: Vec<f64> = time_s.iter().map(|t| if *t < 1.0 { *t } else { t + 5.0 }).collect();
        assert_eq!(pieces(&gap, 0..205, 0.6), [0..60, 60..100, 100..160, 160..205]);
    }
}
