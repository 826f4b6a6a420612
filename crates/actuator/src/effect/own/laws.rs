//! A user's law at each place where it may act.

use super::Expression;
use crate::plant::{DriveLimit, RotorForce, SpringForce};

#[derive(Debug)]
pub(super) struct OnRotor {
    pub law: Expression,
    pub per_travel: f64,
}

impl RotorForce for OnRotor {
    fn force(&self, y: f64, y_dot: f64, load: f64, t: f64) -> f64 {
        -self.law.value(&[y, y_dot, y * self.per_travel, y_dot * self.per_travel, load, t])
    }
}

#[derive(Debug)]
pub(super) struct InDrive {
    pub law: Expression,
    pub per_travel: f64,
    pub force_per_command: f64,
}

impl DriveLimit for InDrive {
    fn limit(&self, commanded: f64, y_dot: f64) -> f64 {
        let u = commanded / self.force_per_command;
        self.force_per_command * self.law.value(&[u, commanded, y_dot, y_dot * self.per_travel])
    }
}

#[derive(Debug)]
pub(super) struct BesideSpring {
    pub law: Expression,
    pub stiffness: f64,
}

impl SpringForce for BesideSpring {
    fn force(&self, delta: f64, delta_dot: f64, _t: f64) -> f64 {
        self.law.value(&[delta, delta_dot, self.stiffness * delta])
    }
}

#[derive(Debug)]
pub(super) struct OnOutput {
    pub law: Expression,
    pub arm: f64,
}

impl RotorForce for OnOutput {
    /// Along the axis; `y` and `y_dot` are link 2's.
    fn force(&self, y: f64, y_dot: f64, _load: f64, t: f64) -> f64 {
        -self.law.value(&[y / self.arm, y_dot / self.arm, y, y_dot, t]) / self.arm
    }
}
