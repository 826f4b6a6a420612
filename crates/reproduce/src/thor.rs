//! The actuators of chapters 3 and 4: Table 5 with the printed stiffnesses, in the three models.

use sealegs_actuator::bench::PendulumRig;
use sealegs_actuator::plant::GRAVITY_M_S2;
use sealegs_actuator::response::Link;
use sealegs_actuator::{ActuatorError, ActuatorSpec, Coefficients, Configuration};

/// Printed stiffness of the stiff setting, N/m.
pub const STIFF_N_M: f64 = 655e3;
/// Printed stiffness of the soft setting, N/m.
pub const SOFT_N_M: f64 = 372e3;
/// Sprung mass that section 4-5-1 estimates for a sprung ball nut, kg.
pub const SBN_MASS_KG: f64 = 0.15;

/// The working point of section 4-7: the current limit, A.
pub const CURRENT_LIMIT_A: f64 = 10.0;
/// The working point of section 4-7: the amplitude of the force, N.
pub const AMPLITUDE_N: f64 = 200.0;

/// THOR by Table 5 as printed, in its three models.
#[derive(Debug, Clone)]
pub struct Thor {
    /// The preset.
    pub spec: ActuatorSpec,
}

impl Thor {
    /// Loads the preset.
    ///
    /// # Errors
    ///
    /// If it is missing.
    pub fn new() -> Result<Self, ActuatorError> {
        Ok(Self { spec: ActuatorSpec::preset("thor-linear")? })
    }

    /// The unlumped sprung-motor-housing model at a stiffness, N/m.
    #[must_use]
    pub fn smh(&self, stiffness: f64) -> Coefficients {
        let configuration = Configuration::SprungMotorHousing;
        Coefficients { configuration, stiffness, ..self.spec.coefficients() }
    }

    /// The unlumped sprung-ball-nut model at a stiffness, N/m.
    #[must_use]
    pub fn sbn(&self, stiffness: f64) -> Coefficients {
        let configuration = Configuration::SprungBallNut;
        Coefficients { configuration, sprung_mass: SBN_MASS_KG, ..self.smh(stiffness) }
    }

    /// The lumped model at a stiffness, N/m.
    #[must_use]
    pub fn lumped(&self, stiffness: f64) -> Coefficients {
        Coefficients { configuration: Configuration::Lumped, ..self.smh(stiffness) }
    }

    /// The preset with another configuration and stiffness, for simulations.
    #[must_use]
    pub fn spec_with(&self, configuration: Configuration, stiffness: f64) -> ActuatorSpec {
        let mut spec = ActuatorSpec { configuration, ..self.spec.clone() };
        spec.parameters.entry("stiffness".to_owned()).or_default().value = Some(stiffness);
        if configuration == Configuration::SprungBallNut {
            spec.sprung_mass_kg = SBN_MASS_KG;
        }
        spec
    }
}

/// The pendulum of section 3-4-5 as a link of the closed forms.
#[must_use]
pub fn pendulum_link(rig: &PendulumRig) -> Link {
    Link::pendulum(rig.arm_m, rig.length_m, rig.mass_kg, GRAVITY_M_S2)
}
