//! The ground's forces on one body, which damp its motion faster than a step can follow explicitly.
//!
//! The damping of a landing, `c N` of every sole point, moves a light foot within a fraction of a millisecond. The velocity at
//! the time of the pose is therefore solved for together with the forces: it is the extrapolated one, in which the forces of
//! the step before act on, and half a step of what has changed in them:
//!
//! ```text
//! V = V_ext + dt/2 W (w - w_before)        w = sum over touching points of P' f,   f = g - C P V
//! =>  (I + dt/2 W sum P' C P) V = V_ext + dt/2 W (sum P' g - w_before)
//! ```
//!
//! with the twist `V` of the centre of mass, the wrench `w` about it, `W` the inverse of the mass matrix seen there, `P` from
//! twist to a point's velocity, `g` its force at rest and `C` its damping. For one mass and one damper this is the trapezoidal
//! rule, of second order and stable at any step (Crank and Nicolson 1947). A point that would pull is let go, one whose
//! friction would exceed its bound slips, and the rest is solved again.

use super::{Ground, Touch};
use crate::dynamics::engine::Engine;
use nalgebra::{Matrix3, Matrix6, Point3, SMatrix, Vector3, Vector6};

/// Steps from one look at the mass matrix to the next: what it is off by counts in second order.
const LOOK_EVERY: usize = 10;

/// Rounds of letting go and slipping within a step.
const ROUNDS: usize = 4;

/// A body with sole points.
#[derive(Debug, Clone)]
pub(super) struct Sole {
    pub body: usize,
    /// `W`, from wrench to acceleration of the centre of mass, and the steps since it was looked at.
    mobility: Matrix6<f64>,
    steps: usize,
    /// `w` of the step before.
    wrench: Vector6<f64>,
}

/// A point that touches, while its force is found.
struct Pressed {
    /// `P`.
    velocity: SMatrix<f64, 3, 6>,
    /// Elastic force along the normal, N.
    elastic: f64,
    /// Velocity along the plane, m/s.
    sliding: Vector3<f64>,
    pulls: bool,
    /// The friction that it slips with, N.
    slips: Option<Vector3<f64>>,
}

impl Sole {
    pub fn new(body: usize) -> Self {
        Self { body, mobility: Matrix6::zeros(), steps: 0, wrench: Vector6::zeros() }
    }

    /// Finds the forces on the points that touch.
    pub fn press(
        &mut self,
        touches: &mut [&mut Touch],
        (ground, normal): (&Ground, &Vector3<f64>),
        engine: &Engine,
        step_s: f64,
    ) {
        if touches.is_empty() {
            (self.steps, self.wrench) = (0, Vector6::zeros());
            return;
        }
        if self.steps.is_multiple_of(LOOK_EVERY) {
            self.mobility = engine.body_mobility(self.body);
        }
        self.steps += 1;
        let state = &engine.states[self.body];
        let extrapolated =
            Vector6::from_fn(|i, _| if i < 3 { state.twist.linear[i] } else { state.twist.angular[i - 3] });
        let pressed = |touch: &&mut Touch| Pressed::of(touch, &state.com, ground);
        let mut pressed: Vec<Pressed> = touches.iter().map(pressed).collect();
        let half = self.mobility * (0.5 * step_s);
        for _ in 0..ROUNDS {
            let (mut damping, mut rest) = (Matrix6::zeros(), -self.wrench);
            for (p, touch) in pressed.iter().zip(touches.iter()) {
                let (c, g) = p.linear(touch, (ground, normal));
                damping += p.velocity.transpose() * c * p.velocity;
                rest += p.velocity.transpose() * g;
            }
            let matrix = Matrix6::identity() + half * damping;
            let twist = matrix.lu().solve(&(extrapolated + half * rest)).unwrap_or(extrapolated);
            let mut settled = true;
            for (p, touch) in pressed.iter_mut().zip(touches.iter_mut()) {
                settled &= p.force(touch, &twist, (ground, normal));
            }
            if settled {
                break;
            }
        }
        self.wrench = Vector6::zeros();
        for (p, touch) in pressed.iter().zip(touches.iter_mut()) {
            if let Some(held) = p.slips {
                touch.bristle =
                    (held + p.sliding * ground.bristle_damping_n_s_m) / -ground.bristle_stiffness_n_m;
            }
            self.wrench += p.velocity.transpose() * touch.force;
        }
    }
}

impl Pressed {
    fn of(touch: &Touch, com: &Point3<f64>, ground: &Ground) -> Self {
        let mut velocity = SMatrix::<f64, 3, 6>::zeros();
        velocity.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
        velocity.fixed_columns_mut::<3>(3).copy_from(&-(touch.at - com).cross_matrix());
        let elastic = ground.elastic_force_n(touch.depth_m);
        Self { velocity, elastic, sliding: Vector3::zeros(), pulls: false, slips: None }
    }

    /// `C` and `g`, as far as it is known whether the point pulls or slips.
    fn linear(
        &self,
        touch: &Touch,
        (ground, normal): (&Ground, &Vector3<f64>),
    ) -> (Matrix3<f64>, Vector3<f64>) {
        let along = normal * normal.transpose();
        let (mut c, mut g) = (Matrix3::zeros(), self.slips.unwrap_or_default());
        if !self.pulls {
            c += along * (ground.damping_s_m * self.elastic);
            g += normal * self.elastic;
        }
        if self.slips.is_none() {
            c += (Matrix3::identity() - along) * ground.bristle_damping_n_s_m;
            g -= touch.bristle * ground.bristle_stiffness_n_m;
        }
        (c, g)
    }

    /// The force on a point at a twist of its body; whether it was solved for like this.
    fn force(
        &mut self,
        touch: &mut Touch,
        twist: &Vector6<f64>,
        (ground, normal): (&Ground, &Vector3<f64>),
    ) -> bool {
        let velocity = self.velocity * twist;
        let rising = velocity.dot(normal);
        let push = self.elastic * (1.0 - ground.damping_s_m * rising);
        self.sliding = velocity - normal * rising;
        let wanted =
            touch.bristle * -ground.bristle_stiffness_n_m - self.sliding * ground.bristle_damping_n_s_m;
        let (bound, size) = (ground.friction * push.max(0.0), wanted.norm());
        let pulls = push < 0.0;
        let slips = (size > bound).then(|| wanted * (bound / size));
        touch.force = normal * push.max(0.0) + slips.unwrap_or(wanted);
        let settled = pulls == self.pulls && slips.is_some() == self.slips.is_some();
        (self.pulls, self.slips) = (pulls, slips);
        settled
    }
}
