//! Rows of a run that the log itself shows to be no measurement: repeated rows and isolated spikes.
//!
//! Both are found in the measured columns alone, without a model. The model still simulates through such rows; they
//! do not count for errors, in any column of the run (they are rare, and a row is one instant).

use super::noise::{by_differences, quantum};
use sealegs_model::{Record, Unit};
use std::ops::Range;

/// Isolated spikes of one output column.
#[derive(Debug, Clone, PartialEq)]
pub struct Spikes {
    /// The column.
    pub channel: String,
    /// The rows, ascending.
    pub rows: Vec<usize>,
    /// Median distance from what the neighbouring rows say, in the column's unit.
    pub size: f64,
}

/// Rows of a run that do not count.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LeftOut {
    /// Rows that repeat the row before in every output column, ascending: nothing new was read.
    pub repeated: Vec<usize>,
    /// Spikes, by column.
    pub spikes: Vec<Spikes>,
}

/// Share of a run's rows up to which spikes are rare. Beyond it a column is no measurement with outliers any more, and
/// nothing of it is left out: the 0.3 % of a glitching cable are far below, the tail of an ordinary heavy-tailed sensor
/// (a few per cent beyond 3 sigma) is above.
pub const RARE: f64 = 0.02;

/// A spike is beyond this many robust standard deviations of what its neighbours leave. In a million rows of white
/// noise the greatest is at 5.
const BEYOND: f64 = 10.0;

/// A spike is beyond this many quanta: a coarse encoder's single counts never are spikes.
const QUANTA: f64 = 5.0;

/// Greatest spread of the rows around a spike as a ratio of it. Ringing and steps, which are answers of a rig, leave
/// half of their size and more in the rows beside them.
const QUIET: f64 = 0.25;

/// Rows on either side that must be quiet.
const AROUND: usize = 3;

/// Rows on either side over which the scatter of a column is taken.
const WINDOW: usize = 32;

/// A column whose noise is this many times its quantum hardly ever shows a value twice: the chance is
/// `q / (2 sqrt(pi) sigma)`, less than one in ten.
const FINE: f64 = 3.0;

/// Repeated rows are said from this share of a run on, and from so many times what chance makes.
const REPEATED: (f64, f64) = (2e-3, 3.0);

impl LeftOut {
    /// Looks at a run's columns.
    #[must_use]
    pub fn of(record: &Record) -> Self {
        let repeated = repeated(record);
        let kept: Vec<usize> = without(0..record.len(), &repeated).flatten().collect();
        let spikes = record
            .outputs
            .iter()
            // What a controller commands jumps as it likes.
            .filter(|s| Unit::of_channel(&s.channel) != Ok(Unit::Ampere))
            .filter_map(|s| {
                let fresh: Vec<f64> = kept.iter().map(|&i| s.values[i]).collect();
                let (rows, size) = spikes(&fresh)?;
                let rows = rows.into_iter().map(|k| kept[k]).collect();
                Some(Spikes { channel: s.channel.clone(), rows, size })
            })
            .collect();
        Self { repeated, spikes }
    }

    /// Every row that is left out, ascending, each once.
    #[must_use]
    pub fn rows(&self) -> Vec<usize> {
        let spikes = self.spikes.iter().flat_map(|s| &s.rows);
        let mut rows: Vec<usize> = self.repeated.iter().chain(spikes).copied().collect();
        rows.sort_unstable();
        rows.dedup();
        rows
    }

    /// A range of rows without those that are left out, as ranges.
    #[must_use]
    pub fn counted(&self, scored: Range<usize>) -> Vec<Range<usize>> {
        without(scored, &self.rows()).collect()
    }

    /// Whether a column has a spike in these rows.
    pub(super) fn has_spike(&self, channel: &str, rows: Range<usize>) -> bool {
        let of_channel = self.spikes.iter().filter(|s| s.channel == channel);
        of_channel.flat_map(|s| &s.rows).any(|r| rows.contains(r))
    }

    /// A column's values without the rows that it is known to be wrong at.
    pub(super) fn fresh(&self, channel: &str, values: &[f64]) -> Vec<f64> {
        let mut rows = self.repeated.clone();
        rows.extend(self.spikes.iter().filter(|s| s.channel == channel).flat_map(|s| &s.rows));
        rows.sort_unstable();
        without(0..values.len(), &rows).flatten().map(|i| values[i]).collect()
    }
}

/// The ranges that ascending rows leave of a range.
fn without(range: Range<usize>, rows: &[usize]) -> impl Iterator<Item = Range<usize>> {
    let mut from = range.start;
    let mut ranges = Vec::new();
    for &row in rows.iter().filter(|r| range.contains(*r)) {
        ranges.push(from..row);
        from = row + 1;
    }
    ranges.push(from..range.end);
    ranges.into_iter().filter(|r| !r.is_empty())
}

/// Rows that repeat the one before in every output column, where that is no chance.
fn repeated(record: &Record) -> Vec<usize> {
    let by_chance: Vec<f64> = record
        .outputs
        .iter()
        .filter_map(|s| {
            let (q, std) = (quantum(&s.values)?, by_differences(&[&s.values]));
            (std > FINE * q).then_some(q / (2.0 * std * std::f64::consts::PI.sqrt()))
        })
        .collect();
    // Values on no grid at all never repeat by chance; a run of coarse columns alone says nothing.
    let continuous = record.outputs.iter().any(|s| quantum(&s.values).is_none() && distinct(&s.values));
    if by_chance.is_empty() && !continuous {
        return Vec::new();
    }
    let chance = if continuous { 0.0 } else { by_chance.iter().product::<f64>() };
    let same = |i: usize| record.outputs.iter().all(|s| s.values[i] == s.values[i - 1]);
    let rows: Vec<usize> = (1..record.len()).filter(|&i| same(i)).collect();
    let share = rows.len() as f64 / record.len().max(1) as f64;
    if share > REPEATED.0.max(REPEATED.1 * chance) && rows.len() + super::FEWEST_ROWS <= record.len() {
        rows
    } else {
        Vec::new()
    }
}

/// Whether a column shows as many values as a sensor without a grid does: more than a quarter of its rows.
fn distinct(values: &[f64]) -> bool {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    4 * sorted.len() > values.len()
}

/// Rows of a column that stand out from the rows beside them, and their median size; `None` where there are none, or
/// too many to be rare.
fn spikes(values: &[f64]) -> Option<(Vec<usize>, f64)> {
    let n = values.len();
    if n < 4 * AROUND {
        return None;
    }
    // What a cubic through two rows on either side leaves of each row: white noise with the variance (1 + 34/36) s^2.
    let left: Vec<f64> = (0..n)
        .map(|i| match i.checked_sub(2).and_then(|a| values.get(a..=i + 2)) {
            Some(v) => v[2] - (4.0 * (v[1] + v[3]) - v[0] - v[4]) / 6.0,
            None => 0.0,
        })
        .collect();
    let size: Vec<f64> = left.iter().map(|l| l.abs()).collect();
    let least = QUANTA * quantum(values).unwrap_or(0.0);
    let mut rows = Vec::new();
    for i in 2..n - 2 {
        let is_greatest = (i - 2..=i + 2).all(|j| size[j] <= size[i]);
        // The cheap conditions come first: hardly a row is left for the median.
        if !is_greatest || size[i] <= least || !stands_alone(values, i, size[i]) {
            continue;
        }
        let near = scatter(&size[i.saturating_sub(WINDOW)..(i + WINDOW + 1).min(n)]);
        if size[i] > BEYOND * near.or_else(|| scatter(&size)).unwrap_or(f64::INFINITY) {
            rows.push(i);
        }
    }
    let rare = !rows.is_empty() && (rows.len() as f64) < RARE * n as f64;
    rare.then(|| {
        let sizes: Vec<f64> = rows.iter().map(|&i| size[i]).collect();
        (rows, crate::stats::median(&sizes))
    })
}

/// A robust standard deviation of what neighbours leave; rows of which they leave nothing, where a sensor rests or is at
/// its limit, say nothing. `None` where hardly a row is left.
fn scatter(size: &[f64]) -> Option<f64> {
    let felt: Vec<f64> = size.iter().copied().filter(|s| *s > 0.0).collect();
    (felt.len() >= 8).then(|| 1.4826 * crate::stats::median(&felt))
}

/// Whether the rows around a row, the straight line through them taken off, are quiet beside it.
fn stands_alone(values: &[f64], i: usize, size: f64) -> bool {
    let from = i.saturating_sub(AROUND);
    let rows = from..(i + AROUND + 1).min(values.len());
    let beside: Vec<(f64, f64)> =
        rows.filter(|k| *k != i).map(|k| (k as f64 - i as f64, values[k])).collect();
    let n = beside.len() as f64;
    let (mx, my) = beside.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / n, b + y / n));
    let (xx, xy) =
        beside.iter().fold((0.0, 0.0), |(a, b), (x, y)| (a + (x - mx).powi(2), b + (x - mx) * (y - my)));
    let left = beside.iter().map(|(x, y)| y - my - xy / xx * (x - mx));
    let (low, high) = left.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    high - low < QUIET * size
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::Noise;
    use sealegs_model::{InputHold, Signal};

    fn record(columns: Vec<(&str, Vec<f64>)>) -> Record {
        let n = columns[0].1.len();
        let outputs = columns
            .into_iter()
            .map(|(channel, values)| Signal { channel: channel.to_owned(), values })
            .collect();
        Record {
            cut: false,
            name: "r".into(),
            time_s: (0..n).map(|i| 1e-3 * i as f64).collect(),
            hold: InputHold::ZeroOrder,
            inputs: Vec::new(),
            outputs,
        }
    }

    /// A force with noise of 2 N in digits of 0.01 N, and an encoder of 4096 counts.
    fn plain(n: usize) -> Vec<(&'static str, Vec<f64>)> {
        let mut noise = Noise::new(7);
        let count = std::f64::consts::TAU / 4096.0;
        let motion = |i: usize| (0.004 * i as f64).sin() + 0.3 * (0.2 * i as f64).sin();
        let force =
            (0..n).map(|i| ((300.0 * motion(i) + 2.0 * noise.normal()) * 100.0).round() / 100.0).collect();
        let angle = (0..n).map(|i| (0.4 * motion(i) / count).round() * count).collect();
        vec![("force_1_n", force), ("motor_angle_rad", angle)]
    }

    #[test]
    fn spikes_are_found_one_by_one_and_nothing_else_is() {
        let mut columns = plain(20_000);
        assert_eq!(LeftOut::of(&record(columns.clone())), LeftOut::default());
        let mut noise = Noise::new(3);
        let mut at: Vec<usize> = (0..60).map(|_| 10 + (19_980.0 * noise.uniform()) as usize).collect();
        at.sort_unstable();
        at.dedup_by(|a, b| *a - *b < 8);
        for (k, &i) in at.iter().enumerate() {
            columns[0].1[i] += if k % 2 == 0 { 400.0 } else { -400.0 };
        }
        let left_out = LeftOut::of(&record(columns));
        let [spikes] = &left_out.spikes[..] else { panic!("{left_out:?}") };
        assert_eq!((spikes.channel.as_str(), &spikes.rows), ("force_1_n", &at));
        assert!((spikes.size - 400.0).abs() < 5.0, "{}", spikes.size);
        let counted = left_out.counted(5..19_990);
        assert_eq!(counted.iter().map(Range::len).sum::<usize>(), 19_985 - at.len());
    }

    #[test]
    fn steps_and_ringing_are_answers_of_a_rig_and_no_spikes() {
        let mut columns = plain(4000);
        for i in 1000..4000 {
            columns[0].1[i] += 400.0;
        }
        for (k, i) in (2000..2060).enumerate() {
            columns[0].1[i] += 400.0 * (-0.1 * k as f64).exp() * (2.2 * k as f64).cos();
        }
        assert_eq!(LeftOut::of(&record(columns)).spikes, []);
    }

    #[test]
    fn a_rough_column_is_left_as_it_is() {
        let mut columns = plain(4000);
        for i in (20..4000).step_by(40) {
            columns[0].1[i] += 400.0;
        }
        assert_eq!(LeftOut::of(&record(columns)).spikes, [], "2.5 % are not rare");
    }

    #[test]
    fn repeated_rows_are_those_in_which_nothing_was_read() {
        let mut columns = plain(8000);
        let rows: Vec<usize> = (100..8000).step_by(50).flat_map(|i| [i, i + 1]).collect();
        for (_, values) in &mut columns {
            for &i in &rows {
                values[i] = values[i - 1];
            }
        }
        let left_out = LeftOut::of(&record(columns.clone()));
        assert_eq!(left_out.repeated, rows);
        assert_eq!(left_out.spikes, []);
        // An encoder alone repeats itself whenever it hardly moves.
        columns.remove(0);
        assert_eq!(LeftOut::of(&record(columns)).repeated, Vec::<usize>::new());
    }
}
