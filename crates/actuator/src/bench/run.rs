//! What one run of a campaign has of its own: its rig, where it begins, its servo's gain.

use super::Bench;
use crate::ActuatorSpec;
use sealegs_model::Record;

/// A run's own rig, start and gain.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSetup {
    /// The name of its record.
    pub record: String,
    /// The bench with the run's own mass and length.
    pub bench: Bench,
    /// Position (m, or rad of a rotary drive) and speed of the output at its first row; used of drives without a spring.
    pub start: (f64, f64),
    /// Factor of the servo's proportional gain.
    pub servo_gain: f64,
}

/// Fewest rows and least time (s) through which the parabola at a run's beginning goes.
const FIRST_ROWS: usize = 8;
const FIRST_S: f64 = 0.02;

impl RunSetup {
    /// A run on a bench whose start is taken from its record.
    ///
    /// The position is the first output column that shows one, see [`start_of`]; where there is none the speed is the
    /// speed column's and the position zero.
    #[must_use]
    pub fn of_record(record: &Record, spec: &ActuatorSpec, bench: Bench, servo_gain: f64) -> Self {
        let arm = bench.arm_m();
        let position = [("position_m", 1.0), ("joint_angle_rad", arm), ("motor_angle_rad", spec.ratio())];
        let speed = [("speed_m_s", 1.0), ("speed_rad_s", arm)];
        let find = |of: &[(&str, f64)]| of.iter().find_map(|(name, k)| Some((record.output(name)?, *k)));
        let start = match (find(&position), find(&speed)) {
            (Some((values, k)), _) => {
                let (x, v) = start_of(&record.time_s, values);
                (k * x, k * v)
            }
            (None, Some((values, k))) => (0.0, k * start_of(&record.time_s, values).0),
            (None, None) => (0.0, 0.0),
        };
        Self { record: record.name.clone(), bench, start, servo_gain }
    }
}

/// Value and slope at the first row of a signal, by a parabola through its first rows.
#[must_use]
pub fn start_of(time_s: &[f64], values: &[f64]) -> (f64, f64) {
    let rows = first_rows(time_s);
    parabola_at_start(&time_s[..rows], &values[..rows])
}

/// How many rows count for the start.
fn first_rows(time_s: &[f64]) -> usize {
    let within = time_s.iter().take_while(|t| *t - time_s[0] <= FIRST_S).count();
    within.max(FIRST_ROWS).min(time_s.len())
}

/// Value and slope at the first time stamp of the parabola that fits the rows best, least squares.
fn parabola_at_start(time_s: &[f64], values: &[f64]) -> (f64, f64) {
    let Some((&start, &span)) = time_s.first().zip(time_s.last()) else { return (0.0, 0.0) };
    let span = span - start;
    if time_s.len() < 3 || span <= 0.0 {
        return (values.first().copied().unwrap_or(0.0), 0.0);
    }
    // Legendre's polynomials are nearly orthogonal over even rows, so that the normal equations stay well conditioned.
    let basis = |t: f64| {
        let u = 2.0 * (t - start) / span - 1.0;
        [1.0, u, 1.5 * u * u - 0.5]
    };
    let (mut a, mut b) = ([[0.0; 3]; 3], [0.0; 3]);
    for (t, value) in time_s.iter().zip(values) {
        let row = basis(*t);
        for i in 0..3 {
            b[i] += row[i] * (value - values[0]);
            for j in 0..3 {
                a[i][j] += row[i] * row[j];
            }
        }
    }
    for column in 0..3 {
        for below in column + 1..3 {
            let factor = a[below][column] / a[column][column];
            for j in column..3 {
                a[below][j] -= factor * a[column][j];
            }
            b[below] -= factor * b[column];
        }
    }
    let mut c = [0.0; 3];
    for i in (0..3).rev() {
        let known: f64 = (i + 1..3).map(|j| a[i][j] * c[j]).sum();
        c[i] = (b[i] - known) / a[i][i];
    }
    // At u = -1 the polynomials are 1, -1, 1 and their slopes 0, 1, -3.
    (values[0] + c[0] - c[1] + c[2], (c[1] - 3.0 * c[2]) * 2.0 / span)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sealegs_model::{InputHold, Signal};

    #[test]
    fn analytic_a_start_in_motion_is_found() {
        let time_s: Vec<f64> =
            (0..400).map(|i| 0.3 + f64::from(i) * 1e-3 + 1e-4 * f64::from(i % 3)).collect();
        let values: Vec<f64> =
            time_s.iter().map(|t| 0.2 + 0.7 * (t - 0.3) - 2.0 * (t - 0.3).powi(2)).collect();
        let mut record = Record {
            name: "run".to_owned(),
            time_s,
            hold: InputHold::ZeroOrder,
            inputs: Vec::new(),
            outputs: vec![Signal { channel: "position_m".to_owned(), values }],
        };
        let spec = ActuatorSpec::preset("rigid-linear").expect("preset");
        let start =
            |record: &Record| RunSetup::of_record(record, &spec, Bench::Free { load: 0.0 }, 1.0).start;
        let (x, v) = start(&record);
        assert!((x - 0.2).abs() < 1e-12 && (v - 0.7).abs() < 1e-9, "{x} {v}");
        record.outputs[0].channel = "motor_angle_rad".to_owned();
        assert!((start(&record).0 - 0.2 * spec.ratio()).abs() < 1e-12);
        record.outputs[0].channel = "force_2_n".to_owned();
        assert_eq!(start(&record), (0.0, 0.0));
    }
}
