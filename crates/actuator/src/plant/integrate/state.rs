//! What a plant remembers from step to step.

use super::super::MOST_PRESLIDING;
use super::super::friction::Held;

/// Position and velocity.
#[derive(Clone, Copy)]
pub(in crate::plant) struct Motion<const N: usize> {
    pub position: [f64; N],
    pub velocity: [f64; N],
}

/// Everything that the plant remembers at a point of the grid.
#[derive(Clone, Copy)]
pub(in crate::plant) struct State<const N: usize> {
    pub motion: Motion<N>,
    /// What everything but the linear part and the command did to the motion over the last step.
    pub(super) beside: Motion<N>,
    /// Acceleration of the sprung mass, m/s^2.
    pub(super) sprung_acceleration: f64,
    /// Force of the spring on link 1, N, positive in compression.
    pub(super) force_1: f64,
    /// Motor force over the last step, N.
    pub motor: f64,
    /// What the drive's limits added to the commanded force over the last step, N.
    pub(super) limited: f64,
    /// Dry friction of the rotor over the last step, N.
    pub(super) dry: f64,
    /// Forces of the elastic presliding elements, N, positive after motion in the positive direction.
    pub presliding: [f64; MOST_PRESLIDING],
    /// Force of the slipping element beside the spring, N, positive in compression.
    pub spring_slip: f64,
    /// Forces of the observer on the rotor and on link 2 over the last step, N.
    pub(super) pull: (f64, f64),
    /// Heat that the rotor's dry friction has made, J.
    pub heat: f64,
    /// s.
    pub time_s: f64,
    /// By how much the drive is warmer than the reference over the step to come, K.
    pub(super) warmer_k: f64,
    /// Whether the drive's bridge is open over the step to come.
    pub(super) released: bool,
}

impl<const N: usize> Motion<N> {
    #[inline(always)]
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            position: std::array::from_fn(|i| self.position[i] + other.position[i]),
            velocity: std::array::from_fn(|i| self.velocity[i] + other.velocity[i]),
        }
    }

    #[inline(always)]
    pub(super) fn hold(&mut self, i: usize, held: Held, from: &Self) {
        if held == Held::Yes {
            self.velocity[i] = 0.0;
            if from.velocity[i] == 0.0 {
                self.position[i] = from.position[i];
            }
        }
    }
}
