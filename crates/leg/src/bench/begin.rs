//! Where a record's run begins: as its first rows tell by themselves, or, where these tell it only roughly, where the model's own
//! motion meets them best, weighed against what they tell.
//!
//! As on a bench of one drive ([`sealegs_actuator::bench`]), for all joints together: they move one another. What a change of
//! the start does to the first rows is taken from the robot without effects, so that a simulation costs no more than twice these
//! rows beside the run; what is missed by that, the second step sees.

use super::RobotModel;
use super::joint::Column;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use sealegs_actuator::bench::{LONGEST_S, Start, rows_within, start_of};
use sealegs_model::{ModelError, Record};
use std::sync::Arc;

/// Steps of Gauss and Newton, and corrections beside a loop; the motion of a few rows is nearly linear in its start.
const STEPS: usize = 2;

/// Standard deviations that a start stays within of what its rows tell: where the model is wrong, noise that is far smaller
/// than its error would otherwise move it anywhere.
const LIMIT: f64 = 3.0;

/// The start of a record's run.
#[derive(Debug, Clone, Default)]
pub(super) struct Begin {
    /// Position and speed by joint, as the first rows tell them by themselves.
    pub at: Vec<(f64, f64)>,
    rough: Option<Arc<Rough>>,
}

/// First rows that tell a start only roughly.
#[derive(Debug)]
struct Rough {
    rows: Record,
    /// What was measured there, and its standard deviation.
    measured: Vec<(String, f64)>,
    unknown: Vec<Unknown>,
    /// Change of the first rows (row by row, column by column, over the noise) per standard deviation of what is unknown.
    slopes: DMatrix<f64>,
    /// Of the normal equations.
    factor: Cholesky<f64, Dyn>,
}

/// Position or speed of a joint, with the standard deviation of what the rows tell of it.
#[derive(Debug, Clone, Copy)]
struct Unknown {
    joint: usize,
    is_speed: bool,
    std: f64,
}

impl Unknown {
    fn moves(&self, at: &mut [(f64, f64)], by: f64) {
        let (position, speed) = &mut at[self.joint];
        *(if self.is_speed { speed } else { position }) += by * self.std;
    }
}

impl Begin {
    /// A start that is known.
    pub fn known(at: Vec<(f64, f64)>) -> Self {
        Self { at, rough: None }
    }

    /// The start of a record: every joint's as its first rows say, the position alone zero where it was not logged.
    pub fn of(record: &Record, robot: &RobotModel) -> Self {
        let mut at = Vec::new();
        let (mut measured, mut unknown, mut rows) = (Vec::new(), Vec::new(), 0);
        for (joint, of) in robot.joints.iter().enumerate() {
            let channel = of.channel(Column::Position);
            let start = |channel: &str| record.output(channel).map(|values| start_of(&record.time_s, values));
            let Some(start) = start(&channel) else {
                at.push((0.0, start(&of.channel(Column::Speed)).map_or(0.0, |speed| speed.value)));
                continue;
            };
            let Start { value, slope, value_std, slope_std, noise, .. } = start;
            at.push((value, slope));
            if noise > 0.0 {
                measured.push((channel, noise));
                rows = rows.max(start.rows);
            }
            // One at rest is known well.
            if noise > 0.0 && slope_std > 0.0 && value_std > 0.0 {
                let of = |(is_speed, std)| Unknown { joint, is_speed, std };
                unknown.extend([(false, value_std), (true, slope_std)].map(of));
            }
        }
        if robot.has_loop(&[record]) {
            return Self::known(corrected(record, robot, at));
        }
        let rows = record.at_rows(0..rows.min(rows_within(&record.time_s, LONGEST_S)));
        let rough = (!unknown.is_empty()).then(|| Rough::of(rows, &at, measured, unknown, robot)).flatten();
        Self { at, rough: rough.map(Arc::new) }
    }

    /// Position and speed of every joint from which a motion meets the first rows best; `shown` is what is seen of these rows,
    /// column by column, from a start.
    ///
    /// # Errors
    ///
    /// Those of `shown`.
    fn met(
        &self,
        shown: impl Fn(&Record, &[(f64, f64)], &[String]) -> Result<Vec<Vec<f64>>, ModelError>,
    ) -> Result<Vec<(f64, f64)>, ModelError> {
        let Some(rough) = &self.rough else { return Ok(self.at.clone()) };
        let channels: Vec<String> = rough.measured.iter().map(|(channel, _)| channel.clone()).collect();
        let mut off = DVector::zeros(rough.unknown.len());
        for _ in 0..STEPS {
            let left = rough.left(&shown(&rough.rows, &rough.moved(&self.at, &off), &channels)?);
            off += rough.factor.solve(&(rough.slopes.tr_mul(&left) - &off));
            off.apply(|x| *x = x.clamp(-LIMIT, LIMIT));
        }
        Ok(rough.moved(&self.at, &off))
    }
}

/// A start of a run whose joints follow goals by loops of their own, corrected by what its first rows show beside the motion of the
/// robot without effects: the loop brings both together, so that what is left is slow and more rows tell it.
fn corrected(record: &Record, robot: &RobotModel, mut at: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let first = record.at_rows(0..rows_within(&record.time_s, LONGEST_S));
    let places = robot.positions().into_iter().enumerate();
    let (joints, channels): (Vec<usize>, Vec<String>) =
        places.filter(|(_, place)| first.output(place).is_some()).unzip();
    for _ in 0..STEPS {
        // What cannot be simulated is said when it is to be compared.
        let Ok(shown) = robot.shown_from(&robot.nominal(), &first, &at, &channels) else { break };
        for ((joint, channel), shown) in joints.iter().zip(&channels).zip(shown) {
            let seen = first.output(channel).unwrap_or_default();
            let left: Vec<f64> = seen.iter().zip(shown).map(|(seen, shown)| seen - shown).collect();
            let start = start_of(&first.time_s, &left);
            at[*joint] = (at[*joint].0 + start.value, at[*joint].1 + start.slope);
        }
    }
    at
}

impl Rough {
    /// `None` where the robot as it is stated cannot be simulated over these rows.
    fn of(
        rows: Record,
        at: &[(f64, f64)],
        measured: Vec<(String, f64)>,
        unknown: Vec<Unknown>,
        robot: &RobotModel,
    ) -> Option<Self> {
        let (values, channels) =
            (robot.nominal(), measured.iter().map(|(channel, _)| channel.clone()).collect::<Vec<_>>());
        let count = unknown.len();
        let factor = Cholesky::new(DMatrix::identity(count, count))?;
        let mut rough = Self { rows, measured, unknown, slopes: DMatrix::zeros(0, count), factor };
        let left = |start: &[(f64, f64)]| {
            let shown = robot.shown_from(&values, &rough.rows, start, &channels).ok()?;
            Some(rough.left(&shown))
        };
        let before = left(at)?;
        let slope = |of: &Unknown| {
            let mut moved = at.to_vec();
            of.moves(&mut moved, 1.0);
            Some(&before - left(&moved)?)
        };
        let columns = rough.unknown.iter().map(slope).collect::<Option<Vec<_>>>()?;
        let slopes = DMatrix::from_columns(&columns);
        rough.factor = Cholesky::new(slopes.tr_mul(&slopes) + DMatrix::identity(count, count))?;
        rough.slopes = slopes;
        Some(rough)
    }

    /// What is left of the measured rows, over the noise.
    fn left(&self, shown: &[Vec<f64>]) -> DVector<f64> {
        let of = |((channel, noise), shown): (&(String, f64), &Vec<f64>)| {
            let seen = self.rows.output(channel).unwrap_or_default();
            seen.iter().zip(shown).map(|(seen, shown)| (seen - shown) / noise).collect::<Vec<_>>()
        };
        DVector::from_vec(self.measured.iter().zip(shown).flat_map(of).collect())
    }

    /// A start that is so many standard deviations off.
    fn moved(&self, at: &[(f64, f64)], off: &DVector<f64>) -> Vec<(f64, f64)> {
        let mut at = at.to_vec();
        self.unknown.iter().zip(off.iter()).for_each(|(of, by)| of.moves(&mut at, *by));
        at
    }
}

impl RobotModel {
    /// What the sensors show of a record's motion from a start, channel by channel.
    fn shown_from(
        &self,
        values: &[f64],
        record: &Record,
        start: &[(f64, f64)],
        channels: &[String],
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let shown = self.outputs(&self.ran_from(values, record, start)?, record, channels)?;
        Ok(shown.outputs.into_iter().map(|signal| signal.values).collect())
    }

    /// Position and speed of every joint where a record's run begins. Under an observer they are as the first rows tell
    /// them: it forgets a wrong start.
    ///
    /// # Errors
    ///
    /// As [`RobotModel::ran_from`].
    pub(super) fn start(&self, values: &[f64], record: &Record) -> Result<Vec<(f64, f64)>, ModelError> {
        match self.starts.get(&record.name) {
            None => Ok(vec![(0.0, 0.0); self.joints.len()]),
            Some(begin) if self.observed.is_some() => Ok(begin.at.clone()),
            Some(begin) => begin.met(|rows, start, channels| self.shown_from(values, rows, start, channels)),
        }
    }
}
