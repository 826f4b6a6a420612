//! The places at which an effect can act on an actuator: each is a small trait that the integrator calls.
//!
//! Quantities are those of a linear actuator (N, m); for a rotary actuator they stand for N m and rad at
//! the output. Signs: the screw's extension `y` is positive when it lengthens the actuator, forces inside
//! the actuator are positive in compression.

use std::fmt::Debug;

/// Where and how the rotor slips, as a law of dry friction sees it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slip {
    /// Extension of the screw, m.
    pub position: f64,
    /// Screw speed, m/s; its sign is the direction of slip, 0 asks for the limit at rest.
    pub speed: f64,
    /// +1 or -1: the sign of `speed` in motion, at rest the way in which the rotor is pushed.
    pub direction: f64,
    /// Force in the screw, N, positive in compression; of a drive without a spring what passes to its load.
    pub load: f64,
    /// Heat that the rotor's dry friction has made since the beginning of the run, J.
    pub heat: f64,
    /// By how much the drive is warmer than [`REFERENCE_TEMPERATURE_C`] by its log, K; 0 where none was logged.
    pub warmer_k: f64,
}

/// The temperature at which the parameters of a law of temperature are stated, degrees Celsius.
pub const REFERENCE_TEMPERATURE_C: f64 = 25.0;

/// Dry friction between the rotor and the motor housing: a bound that holds the rotor at rest and opposes
/// its motion when it moves.
pub trait DryFriction: Debug + Send + Sync {
    /// The bound in N (not negative) where the rotor slips or is about to.
    fn bound(&self, slip: &Slip) -> f64;

    /// Whether the bound depends on speed; saying no saves time.
    fn feels_speed(&self) -> bool {
        true
    }

    /// Whether the bound depends on the load; saying no saves time.
    fn feels_load(&self) -> bool {
        true
    }

    /// Whether the bound depends on the temperature, which is looked up only where one does.
    fn feels_temperature(&self) -> bool {
        false
    }
}

/// A force on the rotor, referred to the screw, positive when it lengthens the actuator.
pub trait RotorForce: Debug + Send + Sync {
    /// The force in N at extension `y` (m), speed `y_dot` (m/s), screw force `load` (N), time `t` (s).
    fn force(&self, y: f64, y_dot: f64, load: f64, t: f64) -> f64;

    /// The energy that it has stored at extension `y`, J; none unless it is a force of position alone.
    fn stored(&self, _y: f64) -> f64 {
        0.0
    }
}

/// What the drive does to the commanded force at every instant, depending on speed.
pub trait DriveLimit: Debug + Send + Sync {
    /// The motor force (N) that is left of the commanded one (N) at screw speed `y_dot` (m/s).
    fn limit(&self, commanded: f64, y_dot: f64) -> f64;
}

/// What happens to the command on its way to the motor, independent of the state. Each sample is changed on its
/// own: a controller's commands are not known in advance.
pub trait CommandStage: Debug + Send + Sync {
    /// Changes the command's samples in place: `time_s` may be shifted, `values` (in the command's own
    /// unit, A, N or N m) changed.
    fn apply(&self, time_s: &mut [f64], values: &mut [f64]);
}

/// Something in line with the spring that uses up deflection, such as play.
pub trait SpringPath: Debug + Send + Sync {
    /// The deflection (m) that is left for the spring out of the total one (m).
    fn left(&self, deflection: f64) -> f64;
}

/// A force beside the linear spring, positive in compression.
pub trait SpringForce: Debug + Send + Sync {
    /// The force (N) at deflection `delta` (m), its rate `delta_dot` (m/s) and time `t` (s).
    fn force(&self, delta: f64, delta_dot: f64, t: f64) -> f64;
}

/// What a sensor, or the structure in front of it, does to the signal that it measures.
pub trait SensorStage: Debug + Send + Sync {
    /// Whether this channel passes through the stage.
    fn concerns(&self, channel: &str) -> bool;

    /// Changes the signal in place. It is given on a uniform grid of step `h` (s).
    fn apply(&self, values: &mut [f64], h: f64);
}

/// How an elastic element passes into slip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Onset {
    /// It is a spring up to its bound, and slips there: `f' = k v`, held within `±F`.
    Sudden,
    /// It yields from the first motion on: `f' = k v (1 - f sign(v) / F)` (P. R. Dahl 1968).
    Gradual,
}

/// An elastic element in series with a dry slider. Its force depends on the way that it was moved and not on the speed.
///
/// Beside the rotor it is presliding friction, beside the spring it is the slip of a clamp. It stores `f^2 / (2 k)`: of
/// either onset no more comes out than went in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElastoSlip {
    /// N/m.
    pub stiffness: f64,
    /// N.
    pub bound: f64,
    /// How it begins to slip.
    pub onset: Onset,
}

/// Most steps of Newton's method towards a travel: it settles within ten.
const MOST_STEPS: usize = 60;

/// Relative step of Newton's method whose square is below rounding.
const NEARLY: f64 = 1e-8;

/// Below this the exponential's mean is taken from its series, whose next term is below its rounding.
const SMALL: f64 = 0.03;

/// The series of the mean of `exp(-x)` from 0 to `x`: `(-1)^n / (n + 1)!`.
const MEAN_DECAY: [f64; 8] =
    [1.0, -1.0 / 2.0, 1.0 / 6.0, -1.0 / 24.0, 1.0 / 120.0, -1.0 / 720.0, 1.0 / 5040.0, -1.0 / 40320.0];

/// The mean of `exp(-x)` from 0 to `x`, and its slope.
#[inline]
fn mean_decay(x: f64) -> (f64, f64) {
    if x < SMALL {
        // Horner's scheme for both.
        return MEAN_DECAY.iter().rev().fold((0.0, 0.0), |(sum, slope), c| (sum * x + c, slope * x + sum));
    }
    let lost = -(-x).exp_m1();
    (lost / x, ((1.0 - lost) * x - lost) / (x * x))
}

impl ElastoSlip {
    /// The element's force after its ends have moved by `step` (m), from the force `f` (N) before.
    #[must_use]
    pub fn advance(&self, f: f64, step: f64) -> f64 {
        match self.onset {
            Onset::Sudden => (f + self.stiffness * step).clamp(-self.bound, self.bound),
            Onset::Gradual => {
                let (end, x) = (self.bound * step.signum(), self.stiffness * step.abs() / self.bound);
                f - (f - end) * x * mean_decay(x).0
            }
        }
    }

    /// The element's mean force over a step, N, from the force `f` (N) before, where its ends would move by
    /// `free` (m) without it, and by `softness` (m/N) less for every newton of it.
    #[must_use]
    #[inline]
    pub fn mean_force(&self, f: f64, free: f64, softness: f64) -> f64 {
        match self.onset {
            Onset::Sudden => {
                let half = 0.5 * self.stiffness;
                ((f + half * free) / (1.0 + half * softness)).clamp(-self.bound, self.bound)
            }
            Onset::Gradual => self.gradual_mean(f, free, softness),
        }
    }

    /// Of the travel `a >= 0` in the direction of the push, `a - push + softness (mean force) = 0` is increasing and
    /// concave: Newton's method comes from below and never passes it. Each step squares the error, so that the one after a step of
    /// [`NEARLY`] of the travel is below rounding, and the mean force follows it along its slope.
    fn gradual_mean(&self, f: f64, free: f64, softness: f64) -> f64 {
        let direction = (free - softness * f).signum();
        let (f, free, per_travel) = (f * direction, free * direction, self.stiffness / self.bound);
        let mut travel = 0.0_f64;
        let mut mean = f;
        for _ in 0..MOST_STEPS {
            let (share, slope) = mean_decay(per_travel * travel);
            mean = self.bound + (f - self.bound) * share;
            let mean_slope = (f - self.bound) * slope * per_travel;
            let step = (free - travel - softness * mean) / (1.0 + softness * mean_slope);
            let after = (travel + step).max(0.0);
            if (after - travel).abs() <= NEARLY * after {
                mean += mean_slope * (after - travel);
                break;
            }
            travel = after;
        }
        direction * mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRADUAL: ElastoSlip = ElastoSlip { stiffness: 2e6, bound: 30.0, onset: Onset::Gradual };

    #[test]
    fn analytic_gradual_onset_approaches_its_bound_exponentially() {
        // f = F (1 - exp(-k y / F)) from rest; any way in parts is the same way.
        let law = |y: f64| 30.0 * (1.0 - (-2e6 * y / 30.0).exp());
        let whole = GRADUAL.advance(0.0, 2e-5);
        assert!((whole - law(2e-5)).abs() < 1e-12);
        let parts = (0..50).fold(0.0, |f, _| GRADUAL.advance(f, 4e-7));
        assert!((parts - whole).abs() < 1e-12);
        assert_eq!(GRADUAL.advance(7.0, 0.0), 7.0);
        assert!(GRADUAL.advance(29.9, 1.0) <= 30.0 && GRADUAL.advance(0.0, -1.0) >= -30.0);
    }

    #[test]
    fn analytic_series_of_the_mean_meets_the_exponential() {
        for x in [0.01, 0.02999, 0.03] {
            let (mean, slope) = mean_decay(x);
            let (lost, h) = (-(-x).exp_m1(), 1e-4);
            let at = |x: f64| -(-x).exp_m1() / x;
            assert!((mean - lost / x).abs() < 1e-15, "{x} {mean}");
            assert!((slope - (at(x + h) - at(x - h)) / (2.0 * h)).abs() < 1e-9, "{x} {slope}");
        }
        assert_eq!(mean_decay(0.0), (1.0, -0.5));
    }

    #[test]
    fn analytic_the_mean_force_belongs_to_the_travel_that_it_leaves() {
        for element in [GRADUAL, ElastoSlip { onset: Onset::Sudden, ..GRADUAL }] {
            for (f, free, softness) in [
                (0.0, 1e-6, 1e-9),
                (12.0, -3e-5, 4e-7),
                (-29.0, 2e-4, 1e-6),
                (20.0, 1e-6, 1e-4),
                (5.0, 0.0, 1e-8),
            ] {
                let mean = element.mean_force(f, free, softness);
                let travel = free - softness * mean;
                // By the middles of a thousand parts; the sudden one's mean is that of a step that does not reach its bound.
                let parts = 1000;
                let middle = |i: usize| element.advance(f, travel * (i as f64 + 0.5) / parts as f64);
                let by_parts = (0..parts).map(middle).sum::<f64>() / parts as f64;
                let elastic = (f + element.stiffness * travel).abs() < element.bound;
                if element.onset == Onset::Gradual || elastic {
                    assert!((mean - by_parts).abs() < 1e-5 * element.bound, "{element:?} {mean} {by_parts}");
                }
            }
        }
    }
}
