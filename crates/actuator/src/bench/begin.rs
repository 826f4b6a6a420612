//! Where a simulation begins whose run's first rows tell it only roughly: the position and the speed from which the model's own
//! motion meets these rows best, weighed against what they tell by themselves.

use super::{BenchModel, FirstRows};
use nalgebra::{Matrix2, Vector2};
use sealegs_model::{Model, ModelError, Record};

/// Gain in squared residuals over a start at rest up to which that is taken, and from which on the motion is: 95 % of what noise
/// gains by itself, and four standard deviations. Between them a share of the motion is, so that a prediction stays continuous in the
/// model's values.
const AT_REST: (f64, f64) = (4.0, 16.0);

/// Standard deviations of the rows' own speed beyond which it is a motion's, whatever the model says: a cubic through rows that are
/// driven from the first one on is some three off.
const IN_MOTION: f64 = 10.0;

/// Steps of Gauss and Newton to a start; the motion of a few rows is nearly linear in it.
pub const START_STEPS: usize = 2;

/// Standard deviations that a start stays within of what its rows tell, as a sensor's gain does: where the model is wrong,
/// noise that is far smaller than its error would otherwise move it anywhere.
pub const START_LIMIT: f64 = 3.0;

impl BenchModel {
    /// The same model, the start of a record's run where a simulation with the nominal values begins it: first rows that tell
    /// a start roughly are met by the model's own motion.
    ///
    /// # Errors
    ///
    /// Those of [`Model::predict`].
    pub fn starting_as(mut self, record: &Record) -> Result<Self, ModelError> {
        if self.run(&record.name).is_some_and(|run| run.first_rows.is_some()) {
            let values: Vec<f64> = self.parameters().iter().map(|p| p.value).collect();
            let start = self.simulate(&values, record)?.0.start;
            for run in self.runs.iter_mut().filter(|run| run.record == record.name) {
                (run.start, run.first_rows) = (start, None);
            }
        }
        Ok(self)
    }
}

/// Position (m, or rad of a rotary drive) and speed of a run's start. `shown` is what the position's column shows of a simulation from
/// a start at the first rows, if it can be simulated.
pub(super) fn start(
    first: &FirstRows,
    record: &Record,
    mut shown: impl FnMut((f64, f64)) -> Option<Vec<f64>>,
) -> (f64, f64) {
    let begins = &first.start;
    let stds = Vector2::new(begins.value_std, begins.slope_std);
    let of = |at: &Vector2<f64>| {
        let in_units = Vector2::new(begins.value, begins.slope) + at.component_mul(&stds);
        (first.scale * in_units[0], first.scale * in_units[1])
    };
    let mut at = Vector2::<f64>::zeros();
    let measured = record.output(&first.channel).filter(|_| begins.noise > 0.0 && stds.min() > 0.0);
    let Some(measured) = measured.map(|m| &m[..begins.rows]) else { return of(&at) };
    // Residuals in standard deviations of the noise; the start in those of what the rows tell of it.
    let mut residual = |at: &Vector2<f64>| -> Option<Vec<f64>> {
        let shown = shown(of(at))?;
        Some(measured.iter().zip(shown).map(|(m, s)| (m - s) / begins.noise).collect())
    };
    let cost = |r: &[f64], at: &Vector2<f64>| r.iter().map(|r| r * r).sum::<f64>() + at.norm_squared();
    let Some(mut left) = residual(&at) else { return of(&at) };
    for _ in 0..START_STEPS {
        let moved = [Vector2::x(), Vector2::y()].map(|by: Vector2<f64>| residual(&(at + by)));
        let [Some(x), Some(v)] = moved else { break };
        let (mut normal, mut right) = (Matrix2::identity(), -at);
        for ((left, x), v) in left.iter().zip(&x).zip(&v) {
            let slope = Vector2::new(left - x, left - v);
            normal += slope * slope.transpose();
            right += slope * *left;
        }
        let Some(step) = normal.cholesky().map(|c| c.solve(&right)) else { break };
        let next = (at + step).map(|x| x.clamp(-START_LIMIT, START_LIMIT));
        match residual(&next) {
            Some(after) if cost(&after, &next) < cost(&left, &at) => (at, left) = (next, after),
            _ => break,
        }
    }
    if record.cut || begins.slope.abs() > IN_MOTION * begins.slope_std {
        return of(&at);
    }
    // Most logs begin at rest; a polynomial through the first rows of one that is driven at once does not tell.
    let squares = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
    let still = Vector2::new(at[0], -begins.slope / begins.slope_std);
    let off = residual(&still).map_or(0.0, |r| r.iter().sum::<f64>() / r.len() as f64);
    let still = Vector2::new(still[0] + off * begins.noise / begins.value_std, still[1]);
    let Some(gain) = residual(&still).map(|r| squares(&r) - squares(&left)) else { return of(&at) };
    let moves = ((gain - AT_REST.0) / (AT_REST.1 - AT_REST.0)).clamp(0.0, 1.0);
    of(&(still + (at - still) * moves))
}

#[cfg(test)]
mod tests {
    use super::super::Start;
    use super::*;
    use crate::excitation::gaussian;
    use sealegs_model::{InputHold, Signal};

    const NOISE: f64 = 1e-3;

    /// What a column shows of a motion from a start that is braked within 20 ms.
    fn braked((x, v): (f64, f64), time_s: &[f64]) -> Vec<f64> {
        time_s.iter().map(|t| x + 0.02 * v * (1.0 - (-t / 0.02).exp())).collect()
    }

    /// What is found of a start whose rows tell a slope so well, in the column's unit.
    fn found(slope: f64, slope_std: f64, truth: (f64, f64)) -> (f64, f64) {
        let time_s: Vec<f64> = (0..20).map(|i| f64::from(i) * 5e-3).collect();
        let values = braked(truth, &time_s);
        let outputs = vec![Signal { channel: "joint_angle_rad".to_owned(), values }];
        let (name, hold) = ("run".to_owned(), InputHold::ZeroOrder);
        let record = Record { cut: false, name, time_s: time_s.clone(), hold, inputs: Vec::new(), outputs };
        let start = Start { value: 0.1, slope, value_std: 5.0 * NOISE, slope_std, noise: NOISE, rows: 20 };
        let first = FirstRows { channel: "joint_angle_rad".to_owned(), scale: 2.0, start };
        let in_column = |(x, v): (f64, f64)| (x / first.scale, v / first.scale);
        in_column(super::start(&first, &record, |at| Some(braked(in_column(at), &time_s))))
    }

    #[test]
    fn analytic_rows_that_tell_little_are_followed_by_the_model() {
        let (x, v) = found(0.4, 2.0, (0.102, -0.5));
        assert!((x - 0.102).abs() < 2e-4 && (v + 0.5).abs() < 0.03, "{x} {v}");
    }

    #[test]
    fn a_log_that_is_driven_at_once_from_rest_begins_at_rest() {
        // Its acceleration swings within the rows, which a cubic takes for a speed.
        let time_s: Vec<f64> = (0..40).map(|i| f64::from(i) * 1e-3).collect();
        let noise = 2e-6;
        let driven = |(x, v): (f64, f64)| -> Vec<f64> {
            time_s.iter().map(|t| x + v * t + 2e-4 * (1.0 - (150.0 * t).cos())).collect()
        };
        let found = |truth: (f64, f64), seed: u64| {
            let values: Vec<f64> =
                (0..).zip(driven(truth)).map(|(n, x)| x + noise * gaussian(seed, n)).collect();
            let start = Start {
                value: truth.0,
                slope: truth.1 + 8e-5,
                value_std: 3.0 * noise,
                slope_std: 6e-5,
                noise,
                rows: 40,
            };
            let outputs = vec![Signal { channel: "position_m".to_owned(), values }];
            let (name, hold) = ("run".to_owned(), InputHold::ZeroOrder);
            let record =
                Record { cut: false, name, time_s: time_s.clone(), hold, inputs: Vec::new(), outputs };
            let first = FirstRows { channel: "position_m".to_owned(), scale: 1.0, start };
            super::start(&first, &record, |at| Some(driven(at)))
        };
        let at_rest = (0..100).filter(|&seed| found((0.1, 0.0), seed).1 == 0.0).count();
        assert!(at_rest >= 90, "{at_rest}");
        for seed in 0..20 {
            let (x, v) = found((0.1, 5e-3), seed);
            assert!((v - 5e-3).abs() < 1e-4 && (x - 0.1).abs() < 5e-6, "{x} {v}");
        }
    }

    #[test]
    fn what_the_rows_tell_well_stays() {
        let (_, v) = found(0.4, 1e-4, (0.1, -0.5));
        assert!((v - 0.4).abs() <= 3.001e-4, "{v}");
    }
}
