//! An individual actuator with its sensors: how far it differs from the nominal one.

use super::draws::Draws;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::Bench;

use crate::Reference;

/// When a logger stamps a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stamp {
    /// When the row's command begins to act.
    Start,
    /// When the row's command has acted for a period.
    End,
}

impl Stamp {
    /// The name in an answer.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::End => "end",
        }
    }
}

/// What is true of one actuator, its load cells and its logger; ratios are to the nominal value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Individual {
    /// Spring stiffness, within 3 %.
    pub stiffness: f64,
    /// Rotor inertia, within 6 %.
    pub rotor_inertia: f64,
    /// Rotor damping, within 10 %.
    pub damping: f64,
    /// Torque constant, within 2 %.
    pub torque_constant: f64,
    /// Gains of the load cells of link 1 and link 2, within 1 %.
    pub gain: [f64; 2],
    /// Biases of the load cells, within 3 N.
    pub bias_n: [f64; 2],
    /// By how much a command acts after its time stamp, up to 10 us: two clocks, or an interrupt.
    pub command_lateness_s: f64,
    /// When rows are stamped.
    pub stamp: Stamp,
}

impl Individual {
    /// The nominal actuator with true sensors.
    pub const NOMINAL: Self = Self {
        stiffness: 1.0,
        rotor_inertia: 1.0,
        damping: 1.0,
        torque_constant: 1.0,
        gain: [1.0; 2],
        bias_n: [0.0; 2],
        command_lateness_s: 0.0,
        stamp: Stamp::Start,
    };

    /// The individual of a seed.
    #[must_use]
    pub fn drawn(seed: u64) -> Self {
        let mut d = Draws::of(seed, "individual");
        Self {
            stiffness: d.between(0.97, 1.03),
            rotor_inertia: d.between(0.94, 1.06),
            damping: d.between(0.90, 1.10),
            torque_constant: d.between(0.98, 1.02),
            gain: [d.between(0.99, 1.01), d.between(0.99, 1.01)],
            bias_n: [d.between(-3.0, 3.0), d.between(-3.0, 3.0)],
            command_lateness_s: d.between(0.0, 10e-6),
            stamp: d.one_of(&[Stamp::Start, Stamp::End]),
        }
    }

    /// This individual on a bench, driven by a current.
    #[must_use]
    pub fn on(&self, spec: &ActuatorSpec, bench: Bench) -> Reference {
        let nominal = Reference::of(spec, bench, "current_a");
        Reference {
            stiffness: nominal.stiffness * self.stiffness,
            rotor: nominal.rotor * self.rotor_inertia,
            damping: nominal.damping * self.damping,
            force_per_command: nominal.force_per_command * self.torque_constant,
            command_delay_s: self.command_lateness_s,
            ..nominal
        }
    }

    /// The base parameters by the names that a model gives them, for comparison with a fit.
    #[must_use]
    pub fn base_parameters(&self, spec: &ActuatorSpec) -> Vec<(&'static str, f64)> {
        let c = spec.coefficients();
        vec![
            ("stiffness", c.stiffness * self.stiffness),
            ("reflected_inertia", c.reflected_inertia * self.rotor_inertia),
            ("damping", c.damping * self.damping),
            ("force_constant", c.force_constant * self.torque_constant),
        ]
    }
}
