//! Joint losses that are fast against the step, found at the step's end instead of at its beginning.
//!
//! With `W` the inverse of the mass matrix over the stiff joints, `v` their speeds half a step back and `v+` half a
//! step on, the losses are linear while no stop lets go and no friction slips:
//!
//! ```text
//! tau = r - C v+        v+ = v + dt W tau        =>        (I + C dt W) tau = r - C v
//! ```
//!
//! with `C = d + [at a stop] (c + dt k) + [sticking] dt kb`, and in `r` the stop's push `-k past` and the bristle's
//! force. A stop that would pull is let go, friction beyond its bound slips, and the rest is solved again. What else
//! acts on the joints within the step is not in `v+`: the torque is late by it, by first order in the step. This is
//! the linearly implicit Euler step of multibody engines, for these torques alone.

use super::engine::Engine;
use nalgebra::{DMatrix, DVector};

/// `dt W C` from which a joint is stiff. The explicit law, whose speed is extrapolated by half a step, is stable
/// below 1 for damping alone.
const STIFF: f64 = 0.5;

/// `dt W C` at the start from which a joint is watched, since `W` depends on the posture.
const WATCHED: f64 = 0.05;

/// Steps from one look at the mass matrix to the next: it only has to keep the step stable.
const LOOK_EVERY: usize = 10;

/// Rounds of letting go and slipping within a step.
const ROUNDS: usize = 4;

/// The losses of one joint at the beginning of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loss {
    pub dof: usize,
    /// Viscous loss, N m s/rad.
    pub damping: f64,
    /// How far it is beyond a limit, rad; zero within.
    pub past: f64,
    pub stop_stiffness: f64,
    pub stop_damping: f64,
    /// Force of the friction's bristle, N m.
    pub bristle: f64,
    pub bristle_stiffness: f64,
    /// Bound of the friction, N m.
    pub friction: f64,
}

/// Which joints are stiff now, and how they move each other.
#[derive(Debug, Clone)]
pub(super) struct Stiff {
    /// Degree of freedom and greatest `C` of the joints that are watched.
    watched: Vec<(usize, f64)>,
    /// Degrees of freedom that are stiff, ascending as in `watched`.
    dofs: Vec<usize>,
    /// `W` over them.
    mobility: DMatrix<f64>,
    step_s: f64,
    steps: usize,
}

impl Stiff {
    /// Watches those joints of `rates` (degree of freedom, greatest `C`) that could become stiff.
    pub fn new(rates: Vec<(usize, f64)>, engine: &Engine, step_s: f64) -> Self {
        let mut stiff = Self {
            watched: rates.into_iter().filter(|(_, rate)| *rate > 0.0).collect(),
            dofs: Vec::new(),
            mobility: DMatrix::zeros(0, 0),
            step_s,
            steps: 0,
        };
        if let Some(inverse) = stiff.inverse(engine) {
            stiff.watched.retain(|(dof, rate)| {
                let column = engine.column(*dof);
                step_s * inverse[(column, column)] * rate > WATCHED
            });
        }
        stiff
    }

    fn inverse(&self, engine: &Engine) -> Option<DMatrix<f64>> {
        if self.watched.is_empty() {
            return None;
        }
        Some(engine.mass_matrix().cholesky()?.inverse())
    }

    /// Looks at the mass matrix again, where it is time to.
    pub fn look(&mut self, engine: &Engine) {
        if self.steps.is_multiple_of(LOOK_EVERY)
            && let Some(inverse) = self.inverse(engine)
        {
            let own = |dof: usize| (engine.column(dof), engine.column(dof));
            let fast = self.watched.iter().filter(|(dof, c)| self.step_s * inverse[own(*dof)] * c > STIFF);
            self.dofs = fast.map(|(dof, _)| *dof).collect();
            let n = self.dofs.len();
            self.mobility = DMatrix::from_fn(n, n, |i, j| {
                inverse[(engine.column(self.dofs[i]), engine.column(self.dofs[j]))]
            });
        }
        self.steps += 1;
    }

    /// Whether a joint is stiff now.
    pub fn contains(&self, dof: usize) -> bool {
        self.dofs.contains(&dof)
    }

    /// The torques of the stiff joints, in the order of `losses`, N m.
    pub fn torques(&self, losses: &[Loss], engine: &Engine) -> Vec<f64> {
        let speed = DVector::from_fn(losses.len(), |i, _| engine.velocity()[engine.column(losses[i].dof)]);
        self.solve(losses, &speed)
    }

    fn solve(&self, losses: &[Loss], speed: &DVector<f64>) -> Vec<f64> {
        let (n, dt) = (losses.len(), self.step_s);
        let row = |loss: &Loss| self.dofs.iter().position(|d| *d == loss.dof).unwrap_or(0);
        let rows: Vec<usize> = losses.iter().map(row).collect();
        let w = DMatrix::from_fn(n, n, |i, j| dt * self.mobility[(rows[i], rows[j])]);
        let mut pushes: Vec<bool> = losses.iter().map(|l| l.past != 0.0).collect();
        // The bound that a joint's friction slips at.
        let mut slips: Vec<Option<f64>> = vec![None; n];
        let mut end = speed.clone();
        for _ in 0..ROUNDS {
            let c = |i: usize| {
                let l = &losses[i];
                let stop = if pushes[i] { l.stop_damping + dt * l.stop_stiffness } else { 0.0 };
                l.damping + stop + if slips[i].is_none() { dt * l.bristle_stiffness } else { 0.0 }
            };
            let r = |i: usize| {
                let l = &losses[i];
                slips[i].unwrap_or(l.bristle) - if pushes[i] { l.stop_stiffness * l.past } else { 0.0 }
            };
            // (I + dt W C) v+ = v + dt W r: the same equation, written for the speeds.
            let matrix = DMatrix::from_fn(n, n, |i, j| w[(i, j)] * c(j) + f64::from(u8::from(i == j)));
            let force = DVector::from_fn(n, |i, _| r(i));
            let Some(solved) = matrix.lu().solve(&(speed + &w * force)) else { break };
            end = solved;
            let mut settled = true;
            for (i, loss) in losses.iter().enumerate() {
                if pushes[i] && loss.push(end[i], dt) * loss.past > 0.0 {
                    (pushes[i], settled) = (false, false);
                }
                let stick = loss.bristle - dt * loss.bristle_stiffness * end[i];
                if slips[i].is_none() && stick.abs() > loss.friction {
                    (slips[i], settled) = (Some(loss.friction.copysign(stick)), false);
                }
            }
            if settled {
                break;
            }
        }
        (0..n)
            .map(|i| {
                let (l, v) = (&losses[i], end[i]);
                let stop = if pushes[i] { l.push(v, dt) } else { 0.0 };
                let friction = slips[i].unwrap_or(l.bristle - dt * l.bristle_stiffness * v);
                stop + friction.clamp(-l.friction, l.friction) - l.damping * v
            })
            .collect()
    }
}

impl Loss {
    /// What a stop does at the end of a step with this speed, N m.
    fn push(&self, speed: f64, step_s: f64) -> f64 {
        -self.stop_stiffness * (self.past + step_s * speed) - self.stop_damping * speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(mobility: f64) -> Stiff {
        Stiff {
            watched: Vec::new(),
            dofs: vec![0],
            mobility: DMatrix::from_element(1, 1, mobility),
            step_s: 1e-4,
            steps: 0,
        }
    }

    const FREE: Loss = Loss {
        dof: 0,
        damping: 0.0,
        past: 0.0,
        stop_stiffness: 3000.0,
        stop_damping: 15.0,
        bristle: 0.0,
        bristle_stiffness: 0.0,
        friction: 0.0,
    };

    /// Speed after a step from 2 rad/s.
    fn after(loss: Loss, mobility: f64) -> (f64, f64) {
        let stiff = one(mobility);
        let torque = stiff.solve(&[loss], &DVector::from_element(1, 2.0))[0];
        (2.0 + stiff.step_s * mobility * torque, torque)
    }

    #[test]
    fn analytic_heavy_damping_stops_and_never_reverses() {
        // d dt W = 1e-1 * 1e-4 * 1e8 = 1000: backward Euler leaves 1/1001 of the speed.
        let (speed, _) = after(Loss { damping: 0.1, ..FREE }, 1e8);
        assert!((speed - 2.0 / 1001.0).abs() < 1e-12, "{speed}");
    }

    #[test]
    fn analytic_friction_holds_up_to_its_bound() {
        let rough = Loss { friction: 0.1, bristle_stiffness: 1e3, ..FREE };
        // Light: it sticks, and dt W dt kb = 10 leaves 1/11 of the speed.
        let (speed, torque) = after(rough, 1e6);
        assert!((speed - 2.0 / 11.0).abs() < 1e-12 && torque.abs() < 0.1, "{speed} {torque}");
        // Heavy: it slips, with the bound against the motion.
        let (_, torque) = after(Loss { bristle: -0.0999, ..rough }, 1.0);
        assert_eq!(torque, -0.1);
    }

    #[test]
    fn analytic_a_stop_pushes_and_does_not_pull() {
        let (_, torque) = after(Loss { past: 0.01, ..FREE }, 1e6);
        assert!(torque < 0.0, "{torque}");
        // Below the lower limit and fast on its way out: nothing to push.
        let (speed, torque) = after(Loss { past: -0.001, stop_damping: 15.0, ..FREE }, 1.0);
        assert_eq!((speed, torque), (2.0, 0.0));
    }
}
