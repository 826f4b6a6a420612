//! The benches: what the actuator's ends are attached to.

use super::PendulumRig;
use crate::plant::Link;
use crate::{ActuatorError, ActuatorSpec};

/// What the actuator's ends are attached to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bench {
    /// Both links held (high impedance).
    Locked,
    /// Spring side held, screw side on the lever of a pendulum (moving output).
    Pendulum(PendulumRig),
    /// Spring side held, the output moves a load of this mass (kg) or inertia (kg m^2); with a drive without a spring it
    /// may be zero, as the rotor moves, too.
    Free {
        /// kg, or kg m^2 of a rotary drive.
        load: f64,
    },
    /// Links of given masses in kg that move freely along the axis; infinite is held.
    Masses {
        /// Spring side.
        link_1_kg: f64,
        /// Screw side.
        link_2_kg: f64,
    },
}

impl Bench {
    pub(super) fn links(&self) -> (Link, Link) {
        let mass = |m: f64| if m.is_finite() { Link::Mass(m) } else { Link::Fixed };
        match self {
            Self::Locked => (Link::Fixed, Link::Fixed),
            Self::Pendulum(rig) => (Link::Fixed, rig.link()),
            Self::Free { load } => (Link::Fixed, Link::Mass(*load)),
            Self::Masses { link_1_kg, link_2_kg } => (mass(*link_1_kg), mass(*link_2_kg)),
        }
    }

    pub(super) fn label(&self) -> &'static str {
        match self {
            Self::Locked => "locked",
            Self::Pendulum(_) => "pendulum",
            Self::Free { .. } => "free",
            Self::Masses { .. } => "free masses",
        }
    }

    /// Arm of the output's lever, m; 1 where there is none.
    pub(super) fn arm_m(&self) -> f64 {
        if let Self::Pendulum(rig) = self { rig.arm_m } else { 1.0 }
    }

    /// Whether an actuator can be on it.
    pub(super) fn check(&self, spec: &ActuatorSpec) -> Result<(), ActuatorError> {
        let (rigid, load) = (spec.is_rigid(), self.links().1);
        if rigid && matches!(self, Self::Locked | Self::Masses { .. }) {
            let admitted = "a bench whose output moves, free or pendulum, for a drive without a spring";
            return Err(ActuatorError::value("bench", self.label(), admitted));
        }
        let mass = load.mass_kg();
        if load == Link::Fixed || mass > 0.0 || (rigid && mass == 0.0) {
            return Ok(());
        }
        Err(ActuatorError::value(
            "load of the bench",
            mass,
            "positive; zero only for a drive without a spring",
        ))
    }
}
