//! Where a record's run begins: as its first rows tell by themselves, or, where these tell it only roughly, where the model's own
//! motion meets them best, weighed against what they tell.
//!
//! As on a bench of one drive ([`sealegs_actuator::bench`]), for all joints together: they move one another. What a change of
//! the start does to the first rows is simulated with the very values that a run is, and each start is found to the end: derivatives
//! by the values see what is left of the way to it as if it were noise.

use super::RobotModel;
use super::joint::Column;
use nalgebra::{Cholesky, DMatrix, DVector};
use sealegs_actuator::bench::{LONGEST_S, START_LIMIT, START_STEPS, Start, rows_within, start_of};
use sealegs_model::{ModelError, Record};
use std::sync::Arc;

/// Most steps to a start, and the step (standard deviations of what is known of it) below which it is found: a thousandth of
/// what a derivative changes it by.
const MOST_STEPS: usize = 8;
const STEP_TOLERANCE: f64 = 1e-7;

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
            let start = |channel: &str| {
                record.output(channel).map(|values| start_of(&record.time_s, values, record.cut))
            };
            let Some(start) = start(&channel) else {
                at.push((0.0, start(&of.channel(Column::Speed)).map_or(0.0, |speed| speed.value)));
                continue;
            };
            let noise = start.noise;
            let rough = noise > 0.0 && start.slope_std > 0.0 && start.value_std > 0.0;
            let channel_of_speed = of.channel(Column::Speed);
            let speed = record.output(&channel_of_speed).filter(|_| rough);
            let told = speed.and_then(|speed| told_by_speed(record, record.output(&channel)?, speed, &start));
            if let Some((_, of_speed)) = told {
                channels.push(channel_of_speed);
                noises.push(of_speed.noise);
                rows = rows.max(of_speed.rows);
            }
            let Start { value, slope, value_std, slope_std, .. } = told.map_or(start, |(start, _)| start);
            at.push((value, slope));
            if noise > 0.0 {
                channels.push(channel);
                noises.push(noise);
                rows = rows.max(start.rows);
            }
            let of = |(is_speed, std)| Unknown { joint, is_speed, std };
            // The speed of one at rest is known; where it stands is what its rows say on average.
            let stands = (false, noise / (start.rows.max(1) as f64).sqrt());
            let unknowns = if rough { vec![(false, value_std), (true, slope_std)] } else { vec![stands] };
            unknown.extend(unknowns.into_iter().filter(|_| noise > 0.0).map(of));
        }
        if robot.has_loop(&[record]) {
            return Self::known(corrected(record, robot, at));
        }
        let within = rows_within(&record.time_s, LONGEST_S);
        let rows = record.at_rows(0..rows.min(within));
        let first = FirstRows { rows, channels, noise: noises };
        // Where the robot as it is stated cannot be simulated over these rows, nothing else tells.
        let tells = !unknown.is_empty() && first.left(robot, &robot.nominal(), &at).is_ok();
        Self { at, rough: tells.then(|| Arc::new(Rough { first, unknown })) }
    }
}

/// A joint's start with the help of its measured speed, and that of the speed's own column: what it is at the first row, and where
/// it leads the first positions back to. `None` where it does not lead from each of them to the next: a speed that is filtered, or
/// late, is none.
fn told_by_speed(record: &Record, position: &[f64], speed: &[f64], start: &Start) -> Option<(Start, Start)> {
    let of_speed = start_of(&record.time_s, speed, true);
    let rows = start.rows.max(2);
    let steps = record.time_s[..rows].windows(2).zip(speed.windows(2));
    let mut gone = vec![0.0];
    for (t, v) in steps {
        gone.push(gone[gone.len() - 1] + 0.5 * (v[0] + v[1]) * (t[1] - t[0]));
    }
    let back: Vec<f64> = position.iter().zip(&gone).map(|(q, gone)| q - gone).collect();
    let value = back.iter().sum::<f64>() / rows as f64;
    let span = record.time_s[rows - 1] - record.time_s[0];
    // The noise of a speed adds up to a random walk.
    let walk = of_speed.noise * span / (rows as f64).sqrt();
    let std = start.noise.hypot(walk);
    let off = (back.iter().map(|q| (q - value).powi(2)).sum::<f64>() / rows as f64).sqrt();
    let leads = of_speed.noise > 0.0 && off <= START_LIMIT * std;
    let slope_std = of_speed.value_std;
    let value_std = std / (rows as f64).sqrt().max(1.0) + walk;
    leads.then_some((Start { value, slope: of_speed.value, value_std, slope_std, ..*start }, of_speed))
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
            let start = start_of(&first.time_s, &left, false);
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

/// A step of Gauss and Newton from a start so far off, which leaves so much of the first rows, weighed against what these tell by
/// themselves.
fn step(slopes: &DMatrix<f64>, left: &DVector<f64>, off: &DVector<f64>) -> Option<DVector<f64>> {
    let normal = slopes.tr_mul(slopes) + DMatrix::identity(slopes.ncols(), slopes.ncols());
    Some(Cholesky::new(normal)?.solve(&(slopes.tr_mul(left) - off)))
}

impl Rough {
    /// Change of the first rows, which a motion from `at` leaves `before` of (row by row, column by column, over the noise),
    /// per standard deviation of what is unknown.
    fn slopes(
        &self,
        robot: &RobotModel,
        values: &[f64],
        at: &[(f64, f64)],
        before: &DVector<f64>,
    ) -> Result<DMatrix<f64>, ModelError> {
        let slope = |of: &Unknown| {
            let mut moved = at.to_vec();
            of.moves(&mut moved, 1.0);
            Ok(before - self.first.left(robot, values, &moved)?)
        };
        let slopes: Result<Vec<DVector<f64>>, ModelError> = self.unknown.iter().map(slope).collect();
        Ok(DMatrix::from_columns(&slopes?))
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
        let left_at = |off: &DVector<f64>| rough.first.left(self, values, &rough.moved(&begin.at, off));
        let mut off = DVector::zeros(rough.unknown.len());
        let mut left = left_at(&off)?;
        let slopes = rough.slopes(self, values, &begin.at, &left)?;
        for _ in 0..MOST_STEPS {
            let Some(step) = step(&slopes, &left, &off) else { break };
            let next = (&off + step).map(|x| x.clamp(-START_LIMIT, START_LIMIT));
            let moved = (&next - &off).amax();
            off = next;
            if moved < STEP_TOLERANCE {
                break;
            }
            left = left_at(&off)?;
        }
        Ok(rough.moved(&begin.at, &off))
    }
}
