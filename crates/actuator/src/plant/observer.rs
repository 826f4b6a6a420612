//! An observer: forces that pull a simulated plant to a measured motion, and so show the force that the model lacks.
//!
//! The simulated rotor is tied to the measured one by a spring and a damper, link 2 by a damper. Where the model is
//! right they carry nothing but noise. Where a force is missing they carry that force, up to the observer's
//! bandwidth, and the simulated motion stays near the measured one. Errors that make an open-loop simulation part from
//! the measurement for seconds (a rotor that should have stuck) then last for one time constant only, so that the
//! residual is a smooth function of the parameters (nudging, Luenberger 1971; in identification: Peifer and Timmer
//! 2007, IET Systems Biology 1(2)).

use super::{Grid, sample};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// A measured position with its rate, at time stamps of its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReferenceMotion {
    /// m, or rad for a rotary quantity.
    pub position: Vec<f64>,
    /// Per second.
    pub speed: Vec<f64>,
}

impl ReferenceMotion {
    /// The same in another unit.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let times = |values: &[f64]| values.iter().map(|v| v * factor).collect();
        Self { position: times(&self.position), speed: times(&self.speed) }
    }

    /// The sum of two motions on the same time stamps.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        Self { position: sum(&self.position, &other.position), speed: sum(&self.speed, &other.speed) }
    }

    /// The motion at the points of a grid by cubics through positions and speeds (Hermite): its acceleration is free of
    /// the corners that straight lines have.
    #[must_use]
    pub fn curved(&self, grid: &Grid, time_s: &[f64]) -> Self {
        let at = |(i, u): (usize, f64)| {
            let h = time_s[i + 1] - time_s[i];
            let (a, b) = (self.position[i], self.position[i + 1]);
            let (start, end) = (h * self.speed[i], h * self.speed[i + 1]);
            let (rise, c) = (b - a, start + end - 2.0 * (b - a));
            let position = a + u * (start + u * (3.0 * rise - 2.0 * start - end + u * c));
            let speed = (start + u * (2.0 * (3.0 * rise - 2.0 * start - end) + 3.0 * u * c)) / h;
            (position, speed)
        };
        let (position, speed) = places(time_s, grid).map(at).unzip();
        Self { position, speed }
    }

    /// The motion at the points of a grid.
    #[must_use]
    pub fn on(&self, grid: &Grid, time_s: &[f64]) -> Self {
        let at = |values: &[f64]| resampled(time_s, values, grid);
        Self { position: at(&self.position), speed: at(&self.speed) }
    }
}

/// A pull towards a reference motion on a simulation's grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Pull {
    /// The motion in its sensor's unit; shared, as every simulation of a record on a grid has the same.
    pub to: Arc<ReferenceMotion>,
    /// m per unit of the reference.
    pub scale: f64,
    /// N/m.
    pub stiffness: f64,
    /// N s/m.
    pub damping: f64,
}

/// The observer's natural frequency over that of the rotor on its spring: fast enough that the motion is the measured
/// one within a fraction of an oscillation, slow enough that an encoder's counts pull less than a newton.
const FASTER: f64 = 1.5;

/// The observer's greatest natural frequency times the step of the grid: beyond it an explicit pull rings.
const FASTEST_PER_STEP: f64 = 0.15;

/// The same per sampling period: a reference knows nothing between its samples.
const FASTEST_PER_SAMPLE: f64 = 0.5;

/// Natural frequency of an observer of a mass (kg) on a spring (N/m), rad/s, for a step of integration and a sampling
/// period, s.
#[must_use]
pub fn observer_rate(stiffness: f64, mass: f64, step_s: f64, period_s: f64) -> f64 {
    let most = (FASTEST_PER_STEP / step_s).min(FASTEST_PER_SAMPLE / period_s.max(step_s));
    (FASTER * (stiffness / mass).sqrt()).min(most)
}

/// Natural frequency of the observer of a drive without a spring times the sampling period: it finds the missing force up
/// to a thirtieth of the sampling rate, and an encoder's counts pull a fraction of it.
const RIGID_RATE: f64 = 0.2;

/// Natural frequency of an observer of a body without a spring, rad/s, for a step of integration and a sampling period, s.
#[must_use]
pub fn rigid_observer_rate(step_s: f64, period_s: f64) -> f64 {
    RIGID_RATE / period_s.max(step_s)
}

impl Pull {
    /// The critically damped pull of a mass, kg, at a natural frequency, rad/s.
    #[must_use]
    pub fn on(to: Arc<ReferenceMotion>, scale: f64, mass: f64, rate: f64) -> Self {
        Self { to, scale, stiffness: mass * rate * rate, damping: 2.0 * mass * rate }
    }

    /// The force at point `n` of the grid, N, at a position (m) and speed (m/s).
    #[must_use]
    #[inline]
    pub fn force(&self, n: usize, (position, speed): (f64, f64)) -> f64 {
        self.stiffness * (self.scale * self.to.position[n] - position)
            + self.damping * (self.scale * self.to.speed[n] - speed)
    }
}

/// The pulls on an actuator's ends.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observer {
    /// On the rotor.
    pub rotor: Option<Pull>,
    /// On link 2. It should have no stiffness: a joint's encoder has a zero of its own, and its error would pull the
    /// spring.
    pub output: Option<Pull>,
}

impl Observer {
    /// Forces on the rotor and on link 2 at point `n` of the grid, N, for their positions (m) and speeds (m/s).
    #[must_use]
    #[inline]
    pub fn pull(&self, n: usize, rotor: (f64, f64), output: (f64, f64)) -> (f64, f64) {
        let of = |pull: &Option<Pull>, at| pull.as_ref().map_or(0.0, |p| p.force(n, at));
        (of(&self.rotor, rotor), of(&self.output, output))
    }
}

/// For each point of a grid the time stamp before it and how far along it lies to the next one, between 0 and 1.
fn places<'a>(time_s: &'a [f64], grid: &'a Grid) -> impl Iterator<Item = (usize, f64)> + 'a {
    let mut i = 0;
    (0..=grid.steps).map(move |n| {
        let t = grid.time(n);
        while i + 2 < time_s.len() && time_s[i + 1] <= t {
            i += 1;
        }
        (i, ((t - time_s[i]) / (time_s[i + 1] - time_s[i])).clamp(0.0, 1.0))
    })
}

/// Values at the points of a grid by straight lines between time stamps.
fn resampled(time_s: &[f64], values: &[f64], grid: &Grid) -> Vec<f64> {
    let at = |(i, along): (usize, f64)| values[i] + along * (values[i + 1] - values[i]);
    places(time_s, grid).map(at).collect()
}

/// Samples to each side that a smoothed value is taken from. At 1 kHz a quartic over them tells the speed of a motion of
/// 20 Hz to 0.6 % and of 40 Hz to 8 %, and that of an encoder of 4096 counts to 0.04 rad/s; a parabola as quiet would be
/// 6 and 24 % slow, and an observer that is pulled to it shows a missing force where there is none.
const HALF_WINDOW: usize = 10;

/// Fewest samples of a quartic: half as many again as it has coefficients.
const QUARTIC: usize = 8;

/// Fewest samples of a parabola.
const PARABOLA: usize = 5;

/// A measured signal and its rate by local polynomials (Savitzky and Golay 1964), on time stamps that may be uneven.
///
/// A gap much longer than the usual distance of samples ends a window. Where it reaches further to one side, at the ends of
/// a record, the polynomial is a parabola: a quartic's slope at an end is mostly noise.
#[must_use]
pub fn smoothed(time_s: &[f64], values: &[f64]) -> ReferenceMotion {
    let last = time_s.len().saturating_sub(1);
    let usual = (time_s[last] - time_s[0]) / last.max(1) as f64;
    let (mut position, mut speed) = (Vec::with_capacity(last + 1), Vec::with_capacity(last + 1));
    for i in 0..=last {
        let (mut from, mut to) = (i, i);
        while from > 0 && i - from < HALF_WINDOW && time_s[from] - time_s[from - 1] < 5.0 * usual {
            from -= 1;
        }
        while to < last && to - i < HALF_WINDOW && time_s[to + 1] - time_s[to] < 5.0 * usual {
            to += 1;
        }
        let scale = 1.0 / (HALF_WINDOW as f64 * usual);
        let samples = (from..=to).map(|j| ((time_s[j] - time_s[i]) * scale, values[j] - values[i]));
        let fitted = match (to - from + 1, i - from == to - i) {
            (QUARTIC.., true) => polynomial::<5>(samples),
            (PARABOLA.., _) => polynomial::<3>(samples),
            _ => None,
        };
        let (a, b) = fitted.unwrap_or_default();
        position.push(values[i] + a);
        speed.push(b * scale);
    }
    ReferenceMotion { position, speed }
}

/// Value and slope at 0 of the polynomial of least squares with `N` coefficients; `None` where the samples do not tell it.
fn polynomial<const N: usize>(samples: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for (x, y) in samples {
        let powers = SVector::<f64, N>::from_fn(|k, _| x.powi(k as i32));
        normal += powers * powers.transpose();
        right += powers * y;
    }
    let solved = normal.cholesky()?.solve(&right);
    Some((solved[0], solved[1]))
}

/// [`sample`] of what an observer did, shifted to the middle of the step over which it acted.
#[must_use]
pub fn pull_at(values: &[f64], grid: &Grid, time_s: &[f64]) -> Vec<f64> {
    sample(values, grid, time_s, 0.5 * grid.step_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Feed, Plant};

    #[test]
    fn analytic_a_parabola_is_smoothed_to_itself() {
        let time: Vec<f64> = (0..40).map(|i| 0.01 * f64::from(i) + 0.002 * f64::from(i % 3)).collect();
        let values: Vec<f64> = time.iter().map(|t| 1.0 - 3.0 * t + 7.0 * t * t).collect();
        let motion = smoothed(&time, &values);
        for i in 0..40 {
            assert!((motion.position[i] - values[i]).abs() < 1e-10, "{i}");
            assert!((motion.speed[i] - (14.0 * time[i] - 3.0)).abs() < 1e-8, "{i}");
        }
    }

    #[test]
    fn analytic_the_pull_is_the_force_that_the_model_lacks() {
        // A locked actuator of 1 kg on 400 N/m; the true one feels 5 N more, the model does not know of them.
        let plant = Plant::new(1.0, 0.0, 30.0, 400.0);
        let grid = Grid { start_s: 0.0, step_s: 1e-3, steps: 4000 };
        let known: Vec<f64> = (0..4000).map(|n| 20.0 * (0.004 * f64::from(n)).sin()).collect();
        let true_commands: Vec<f64> = known.iter().map(|f| f + 5.0).collect();
        let truth = plant.simulate(grid, &true_commands).expect("finite");
        let to = ReferenceMotion { position: truth.screw_position.clone(), speed: truth.screw_speed };
        let pull = Pull { to: Arc::new(to), scale: 1.0, stiffness: 1600.0, damping: 80.0 };
        let observer = Observer { rotor: Some(pull), output: None };
        let observed =
            plant.observe(grid, Feed { commands: &known, ..Feed::default() }, &observer).expect("finite");
        // In rest the observer's spring and the actuator's share the 5 N: 5 * 1600 / (1600 + 400).
        let last = observed.rotor_pull.last().copied().unwrap_or(0.0);
        assert!((last - 4.0).abs() < 0.05, "{last}");
        // Where nothing is missing nothing pulls.
        let quiet = plant
            .observe(grid, Feed { commands: &true_commands, ..Feed::default() }, &observer)
            .expect("finite");
        let most = quiet.rotor_pull.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(most < 0.05, "{most}");
    }
}
