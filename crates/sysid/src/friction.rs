//! Friction against speed as logged signals show it, without a model of the drive.
//!
//! What a motor commands goes into the load, into the acceleration of what turns, and into friction. A regression
//! `u = F / k + j a + f(v)` of the command `u` on the measured load `F`, the acceleration `a` and a level for each
//! range of speed `v` therefore leaves the friction curve `k f(v)` in the load's unit, with what is viscous in its
//! slope and what is dry in its step at standstill. Speed and acceleration come from the angle by local cubics. A
//! measured angle's noise would make the acceleration look like less than it is: `1/k` and `j` are taken from a model's
//! prediction, which has none, and of the measured signals the levels alone, as means in which noise cancels.

use crate::{resample, stats};
use nalgebra::{DMatrix, DVector};

/// The signals of one run at its time stamps: command, load, angle of the drive.
#[derive(Debug, Clone, Copy)]
pub struct DriveSignals<'a> {
    /// Time stamps, s.
    pub time_s: &'a [f64],
    /// Current or force command.
    pub command: &'a [f64],
    /// Load force or torque.
    pub load: &'a [f64],
    /// Position of the drive.
    pub position: &'a [f64],
    /// The command is held from stamp to stamp.
    pub held: bool,
}

/// One range of speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionPoint {
    /// Mean speed, in the position's unit per second.
    pub speed: f64,
    /// Friction, in the load's unit; positive against positive speed.
    pub friction: f64,
}

/// A range with fewer samples has no level.
const LEAST_ROWS: usize = 20;

/// Limits of ranges, as parts of the greatest speed.
const LIMITS: [f64; 8] = [0.01, 0.03, 0.08, 0.16, 0.28, 0.42, 0.6, 0.8];

/// Samples on each side of one in a local cubic: at least, and at most.
const HALF_WIDTHS: (usize, usize) = (2, 20);

/// Part of the period of the fastest motion that a local cubic may span.
const SPAN: f64 = 0.06;

/// Share of the command's square that the regression must explain to be shown.
const EXPLAINED: f64 = 0.8;

/// Part of the greatest speed above which a curve is viscous and dry friction: below it there is Stribeck's fall, and
/// samples whose local cubic spans a reversal.
const FAST: f64 = 0.2;

/// The viscous coefficient of a curve, friction per speed: the slope of the best line with a step at standstill.
#[must_use]
pub fn viscous(points: &[FrictionPoint]) -> f64 {
    let top = points.iter().map(|p| p.speed.abs()).fold(0.0, f64::max);
    let points: Vec<FrictionPoint> = points.iter().filter(|p| p.speed.abs() > FAST * top).copied().collect();
    let sum = |of: &dyn Fn(&FrictionPoint) -> f64| points.iter().map(of).sum::<f64>();
    let (n, signs) = (points.len() as f64, sum(&|p| p.speed.abs()));
    let (squares, steps) = (sum(&|p| p.speed * p.speed), sum(&|p| p.friction * p.speed.signum()));
    let determinant = n * squares - signs * signs;
    let slope = (n * sum(&|p| p.friction * p.speed) - signs * steps) / determinant;
    if slope.is_finite() { slope } else { 0.0 }
}

/// What of the command goes into the load and into the acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Command per load.
    pub load: f64,
    /// Command per acceleration of the position.
    pub acceleration: f64,
}

/// How signals are smoothed and speeds cut, for all signals alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Treatment {
    half_width: usize,
    limits: Vec<f64>,
}

impl Treatment {
    /// What suits some runs; `None` where nothing moves.
    #[must_use]
    pub fn of(runs: &[DriveSignals]) -> Option<Self> {
        let period = stats::median(&runs.iter().map(|r| stats::median_period(r.time_s)).collect::<Vec<_>>());
        let bands = runs.iter().filter_map(|r| crate::check::band(r.time_s, r.position, false));
        let fastest = bands.map(|b| b.1).fold(0.0f64, f64::max);
        if !(period > 0.0 && fastest > 0.0) {
            return None;
        }
        let half_width = ((0.5 * SPAN / fastest / period) as usize).clamp(HALF_WIDTHS.0, HALF_WIDTHS.1);
        let speeds: Vec<f64> = runs.iter().flat_map(|r| moved(r, half_width).speed).map(f64::abs).collect();
        let top = stats::quantile(&speeds, 0.999);
        let mut limits: Vec<f64> = LIMITS.iter().rev().map(|l| -l * top).collect();
        limits.push(0.0);
        limits.extend(LIMITS.iter().map(|l| l * top));
        (top > 0.0).then_some(Self { half_width, limits })
    }

    /// The command per load and per acceleration, and the friction curve, slowest speeds in the middle; `None` where the
    /// signals do not determine them.
    #[must_use]
    pub fn regression(&self, runs: &[DriveSignals]) -> Option<(Shares, Vec<FrictionPoint>)> {
        let all: Vec<Moved> = runs.iter().map(|r| moved(r, self.half_width)).collect();
        let rows: Vec<[f64; 4]> = all
            .iter()
            .flat_map(|m| {
                (0..m.speed.len()).map(|i| [m.command[i], m.load[i], m.acceleration[i], m.speed[i]])
            })
            .collect();
        let place = |v: f64| self.limits.partition_point(|&l| l <= v);
        let mut count = vec![0usize; self.limits.len() + 1];
        for row in &rows {
            count[place(row[3])] += 1;
        }
        let kept: Vec<usize> = (0..count.len()).filter(|&c| count[c] >= LEAST_ROWS).collect();
        let n = kept.len() + 2;
        // Load and acceleration in units of their own size, for the sake of the solution.
        let size =
            |k: usize| stats::rms(&rows.iter().map(|r| r[k]).collect::<Vec<_>>()).max(f64::MIN_POSITIVE);
        let (load, acceleration) = (size(1), size(2));
        let (mut a, mut b) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
        let mut squares = 0.0;
        for row in &rows {
            let Some(cell) = kept.iter().position(|&c| c == place(row[3])) else { continue };
            let terms = [(0, row[1] / load), (1, row[2] / acceleration), (2 + cell, 1.0)];
            for (i, x) in terms {
                b[i] += x * row[0];
                for (j, y) in terms {
                    a[(i, j)] += x * y;
                }
            }
            squares += row[0] * row[0];
        }
        let solution = a.cholesky()?.solve(&b);
        // The command's own mean is no motion; what remains of its square is to come from the load and the rest.
        if !(squares > 0.0 && b.dot(&solution) > EXPLAINED * squares && solution[0] != 0.0) {
            return None;
        }
        let shares = Shares { load: solution[0] / load, acceleration: solution[1] / acceleration };
        self.levels(&all, shares).map(|points| (shares, points))
    }

    /// The friction curve of signals whose shares are known; `None` where too few ranges have samples.
    #[must_use]
    pub fn curve(&self, runs: &[DriveSignals], shares: Shares) -> Option<Vec<FrictionPoint>> {
        self.levels(&runs.iter().map(|r| moved(r, self.half_width)).collect::<Vec<_>>(), shares)
    }

    fn levels(&self, runs: &[Moved], shares: Shares) -> Option<Vec<FrictionPoint>> {
        let mut sums = vec![(0usize, 0.0, 0.0); self.limits.len() + 1];
        for m in runs {
            for (i, &v) in m.speed.iter().enumerate() {
                let cell = &mut sums[self.limits.partition_point(|&l| l <= v)];
                let left = m.command[i] - shares.load * m.load[i] - shares.acceleration * m.acceleration[i];
                *cell = (cell.0 + 1, cell.1 + v, cell.2 + left);
            }
        }
        let points: Vec<FrictionPoint> = sums
            .into_iter()
            .filter(|(count, ..)| *count >= LEAST_ROWS)
            .map(|(count, speed, left)| FrictionPoint {
                speed: speed / count as f64,
                friction: left / count as f64 / shares.load.abs(),
            })
            .collect();
        let finite = points.iter().all(|p| p.friction.is_finite() && p.speed.is_finite());
        (finite && points.len() >= 4).then_some(points)
    }
}

/// Signals of a run on an even grid, smoothed by local cubics, with the position's derivatives.
struct Moved {
    command: Vec<f64>,
    load: Vec<f64>,
    speed: Vec<f64>,
    acceleration: Vec<f64>,
}

fn moved(run: &DriveSignals, half_width: usize) -> Moved {
    let period = stats::median_period(run.time_s);
    let even = |values: &[f64], hold: bool| resample::uniform(run.time_s, values, period, hold);
    let weights = local_cubic(half_width);
    let smooth = |values: &[f64], order: usize| -> Vec<f64> {
        let scale = period.powi(order as i32);
        values
            .windows(2 * half_width + 1)
            .map(|w| w.iter().zip(&weights[order]).map(|(v, c)| v * c).sum::<f64>() / scale)
            .collect()
    };
    let position = even(run.position, false);
    Moved {
        command: smooth(&even(run.command, run.held), 0),
        load: smooth(&even(run.load, false), 0),
        speed: smooth(&position, 1),
        acceleration: smooth(&position, 2),
    }
}

/// Weights of the samples around one for the value, the first and the second derivative there of the cubic that
/// fits them best, at unit distance (A. Savitzky, M. Golay, 1964).
fn local_cubic(half_width: usize) -> [Vec<f64>; 3] {
    let m = half_width as i64;
    let sum = |power: u32| (-m..=m).map(|i| (i as f64).powi(power as i32)).sum::<f64>();
    let (s0, s2, s4, s6) = (sum(0), sum(2), sum(4), sum(6));
    let even = s0 * s4 - s2 * s2;
    let odd = s2 * s6 - s4 * s4;
    let weights = |of: &dyn Fn(f64) -> f64| (-m..=m).map(|i| of(i as f64)).collect();
    [
        weights(&|x| (s4 - s2 * x * x) / even),
        weights(&|x| (s6 * x - s4 * x.powi(3)) / odd),
        weights(&|x| 2.0 * (s0 * x * x - s2) / even),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_cubic_has_its_own_derivatives() {
        let cubic = |x: f64| 2.0 - 3.0 * x + 0.5 * x * x + 0.25 * x.powi(3);
        for half_width in [2, 7] {
            let w = local_cubic(half_width);
            let at = |order: usize| -> f64 {
                w[order].iter().enumerate().map(|(i, c)| c * cubic(i as f64 - half_width as f64)).sum()
            };
            assert!((at(0) - 2.0).abs() < 1e-9 && (at(1) + 3.0).abs() < 1e-9 && (at(2) - 1.0).abs() < 1e-9);
        }
    }

    /// A sweep whose command is made from a friction law: the law comes back.
    #[test]
    fn analytic_the_law_comes_back() {
        let (k, inertia) = (40.0, 0.02);
        let law = |v: f64| 6.0 * v.signum() + 0.5 * v;
        let time: Vec<f64> = (0..20_000).map(|i| i as f64 * 1e-3).collect();
        let angle = |t: f64| (6.0 * t + 0.8 * t * t).sin();
        let (position, mut command, mut load) =
            (time.iter().map(|t| angle(*t)).collect::<Vec<_>>(), vec![], vec![]);
        for &t in &time {
            let h = 1e-4;
            let v = (angle(t + h) - angle(t - h)) / (2.0 * h);
            let a = (angle(t + h) - 2.0 * angle(t) + angle(t - h)) / (h * h);
            let f = 30.0 * angle(t + 0.3) + 12.0;
            load.push(f);
            command.push((f + inertia * a + law(v)) / k);
        }
        let run =
            DriveSignals { time_s: &time, command: &command, load: &load, position: &position, held: false };
        let curve = Treatment::of(&[run]).unwrap().regression(&[run]).unwrap().1;
        // Slower ranges hold samples whose local cubic spans a reversal.
        let steady = curve.iter().filter(|p| p.speed.abs() > 10.0);
        assert!(steady.clone().count() >= 6);
        for p in steady {
            assert!((p.friction - law(p.speed)).abs() < 0.3, "{p:?} {}", law(p.speed));
        }
        assert!((viscous(&curve) - 0.5).abs() < 0.03, "{}", viscous(&curve));
    }

    #[test]
    fn what_does_not_move_has_no_curve() {
        let (time, flat) = ([0.0, 1e-3, 2e-3, 3e-3], [0.0; 4]);
        let run = DriveSignals { time_s: &time, command: &flat, load: &flat, position: &flat, held: true };
        assert_eq!(Treatment::of(&[run]), None);
    }
}
