//! Where a record's run begins: as its first rows tell by themselves, or, where these tell it only roughly, where the model's own
//! motion meets them best, weighed against what they tell.
//!
//! As on a bench of one drive ([`sealegs_actuator::bench`]), for all joints together: they move one another. What a change of
//! the start does to the first rows is taken from the robot without effects, so that a simulation costs no more than twice these
//! rows beside the run; what is missed by that, the second step sees.

use super::RobotModel;
use super::joint::Column;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use sealegs_actuator::bench::{LONGEST_S, START_LIMIT, START_STEPS, Start, rows_within, start_of};
use sealegs_model::{ModelError, Record};
use std::sync::Arc;

/// The start of a record's run.
#[derive(Debug, Clone, Default)]
pub(super) struct Begin {
    /// Position and speed by joint, as the first rows tell them by themselves.
    pub at: Vec<(f64, f64)>,
    rough: Option<Arc<Rough>>,
}

/// The first rows of a record.
#[derive(Debug)]
struct FirstRows {
    rows: Record,
    /// The joints' positions and speeds that were measured there, with the standard deviation of their noise.
    channels: Vec<String>,
    noise: Vec<f64>,
}

/// First rows that tell a start only roughly.
#[derive(Debug)]
struct Rough {
    first: FirstRows,
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
        let (mut channels, mut noises, mut unknown, mut rows) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for (joint, of) in robot.joints.iter().enumerate() {
            let channel = of.channel(Column::Position);
            let start = |channel: &str| record.output(channel).map(|values| start_of(&record.time_s, values));
            let Some(start) = start(&channel) else {
                at.push((0.0, start(&of.channel(Column::Speed)).map_or(0.0, |speed| speed.value)));
                continue;
            };
            let Start { value, mut slope, value_std, mut slope_std, noise, .. } = start;
            let rough = noise > 0.0 && slope_std > 0.0 && value_std > 0.0;
            let channel_of_speed = of.channel(Column::Speed);
            let measured = record.output(&channel_of_speed).filter(|_| rough);
            if let Some(speed) = measured.map(|values| start_of(&record.time_s, values))
                && speed.noise > 0.0
            {
                let std = speed.value_std.max(speed.noise);
                // A speed that is filtered, or late, is none.
                if (speed.value - slope).abs() <= START_LIMIT * slope_std.hypot(std) {
                    let weight = slope_std.powi(2) / (slope_std.powi(2) + std.powi(2));
                    slope += weight * (speed.value - slope);
                    slope_std *= (1.0 - weight).sqrt();
                    channels.push(channel_of_speed);
                    noises.push(speed.noise);
                    rows = rows.max(speed.rows);
                }
            }
            at.push((value, slope));
            if noise > 0.0 {
                channels.push(channel);
                noises.push(noise);
                rows = rows.max(start.rows);
            }
            // One at rest is known well.
            if rough {
                let of = |(is_speed, std)| Unknown { joint, is_speed, std };
                unknown.extend([(false, value_std), (true, slope_std)].map(of));
            }
        }
        if robot.has_loop(&[record]) {
            return Self::known(corrected(record, robot, at));
        }
        let rows = record.at_rows(0..rows.min(rows_within(&record.time_s, LONGEST_S)));
        let first = FirstRows { rows, channels, noise: noises };
        let rough = (!unknown.is_empty()).then(|| Rough::of(first, &at, unknown, robot)).flatten();
        Self { at, rough: rough.map(Arc::new) }
    }
}

/// A start of a run whose joints follow goals by loops of their own, corrected by what its first rows show beside the motion of the
/// robot without effects: the loop brings both together, so that what is left is slow and more rows tell it.
fn corrected(record: &Record, robot: &RobotModel, mut at: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let first = record.at_rows(0..rows_within(&record.time_s, LONGEST_S));
    let places = robot.positions().into_iter().enumerate();
    let (joints, channels): (Vec<usize>, Vec<String>) =
        places.filter(|(_, place)| first.output(place).is_some()).unzip();
    for _ in 0..START_STEPS {
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

impl FirstRows {
    /// What a motion from a start leaves of the measured rows, over the noise.
    fn left(
        &self,
        robot: &RobotModel,
        values: &[f64],
        start: &[(f64, f64)],
    ) -> Result<DVector<f64>, ModelError> {
        let shown = robot.shown_from(values, &self.rows, start, &self.channels)?;
        let of = |((channel, noise), shown): ((&String, &f64), &Vec<f64>)| {
            let seen = self.rows.output(channel).unwrap_or_default();
            seen.iter().zip(shown).map(|(seen, shown)| (seen - shown) / noise).collect::<Vec<_>>()
        };
        Ok(DVector::from_vec(self.channels.iter().zip(&self.noise).zip(&shown).flat_map(of).collect()))
    }
}

impl Rough {
    /// `None` where the robot as it is stated cannot be simulated over these rows.
    fn of(first: FirstRows, at: &[(f64, f64)], unknown: Vec<Unknown>, robot: &RobotModel) -> Option<Self> {
        let values = robot.nominal();
        let before = first.left(robot, &values, at).ok()?;
        let slope = |of: &Unknown| {
            let mut moved = at.to_vec();
            of.moves(&mut moved, 1.0);
            Some(&before - first.left(robot, &values, &moved).ok()?)
        };
        let slopes = DMatrix::from_columns(&unknown.iter().map(slope).collect::<Option<Vec<_>>>()?);
        let factor = Cholesky::new(slopes.tr_mul(&slopes) + DMatrix::identity(unknown.len(), unknown.len()))?;
        Some(Self { first, unknown, slopes, factor })
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
        let Some(begin) = self.starts.get(&record.name) else {
            return Ok(vec![(0.0, 0.0); self.joints.len()]);
        };
        let Some(rough) = begin.rough.as_ref().filter(|_| self.observed.is_none()) else {
            return Ok(begin.at.clone());
        };
        let mut off = DVector::zeros(rough.unknown.len());
        for _ in 0..START_STEPS {
            let left = rough.first.left(self, values, &rough.moved(&begin.at, &off))?;
            off += rough.factor.solve(&(rough.slopes.tr_mul(&left) - &off));
            off.apply(|x| *x = x.clamp(-START_LIMIT, START_LIMIT));
        }
        Ok(rough.moved(&begin.at, &off))
    }
}
