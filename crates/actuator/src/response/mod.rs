//! Closed-form frequency responses of an actuator between any two links, and the bounds that follow.
//!
//! One formula holds for all cases. `D_s` and `D_u` are the dynamic stiffnesses of the link at the spring and of
//! the other one, `M` is what translates on the spring and `Z` what the motor drags along:
//!
//! ```text
//! R = 1 + M s^2 (1/k + 1/D_s)                     F_u/F_s = R
//! F_s/F_m = 1 / { R + Z [ R/D_u + 1/k + 1/D_s ] }
//!
//! unlumped (SMH and SBN):  M = m_s,  Z = m_J s^2 + b s
//! lumped:                  M = m_T,  Z = b s
//! ```
//!
//! With both links held it gives eq 3-6 to 3-8, 3-11 to 3-13, 4-20 to 4-22 and 4-29 to 4-31.

mod compensator_bound;
mod find;
mod identification;
mod polynomial;
mod pure_force_source;
mod transfer;

pub use compensator_bound::{CompensatorBound, HALF_POWER_DB, forces_differ_hz, plant, plant_bandwidth_hz};
pub use find::{Feature, crossings, db, dips, peaks};
pub use identification::{ExtractedModel, SecondOrderFit};
pub use polynomial::Polynomial;
pub use pure_force_source::{
    PRINTED_STIFFNESS_CONSTANT, pure_force_source_hz, pure_force_source_min_stiffness,
};
pub use transfer::{Mode, Transfer};

use crate::spec::{Coefficients, Configuration};

/// What an end of the actuator is attached to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Link {
    /// Held: infinite dynamic stiffness.
    Fixed,
    /// A mass on a spring to ground, `D = m s^2 + k_g`; without the spring a free mass. The mass includes what
    /// of the actuator moves with the link.
    Mass {
        /// Mass seen along the actuator, kg.
        mass_kg: f64,
        /// Stiffness to ground, N/m.
        stiffness_n_m: f64,
    },
}

impl Link {
    /// A free mass, kg.
    #[must_use]
    pub fn free(mass_kg: f64) -> Self {
        Self::Mass { mass_kg, stiffness_n_m: 0.0 }
    }

    /// A lever of length `arm_m` that carries `mass_kg` hanging at `radius_m` under `gravity_m_s2`, linearised
    /// about hanging: `m2 = m (L/a)^2`, `k_g = m g L / a^2` (section 3-4-5).
    #[must_use]
    pub fn pendulum(arm_m: f64, radius_m: f64, mass_kg: f64, gravity_m_s2: f64) -> Self {
        Self::Mass {
            mass_kg: mass_kg * (radius_m / arm_m).powi(2),
            stiffness_n_m: mass_kg * gravity_m_s2 * radius_m / arm_m.powi(2),
        }
    }

    /// `D = p/q` with `q = 0` for a fixed link, so that no formula divides by infinity.
    fn over(self) -> (Polynomial, Polynomial) {
        match self {
            Self::Fixed => (Polynomial::constant(1.0), Polynomial::constant(0.0)),
            Self::Mass { mass_kg, stiffness_n_m } => {
                (Polynomial::new([stiffness_n_m, 0.0, mass_kg]), Polynomial::constant(1.0))
            }
        }
    }
}

/// The force responses of one actuator between two links, as rational functions of `s`.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceResponse {
    /// Force on the link at the spring per motor force, `F_sprung/F_m`.
    pub sprung: Transfer,
    /// Force on the other link per motor force, `F_unsprung/F_m`.
    pub unsprung: Transfer,
    /// `F_sprung/F_unsprung`.
    pub ratio: Transfer,
    spring_at_link_1: bool,
}

impl ForceResponse {
    /// The responses for the link at the spring and the other one.
    #[must_use]
    pub fn new(c: &Coefficients, sprung_link: Link, unsprung_link: Link) -> Self {
        let (mass, inertia) = match c.configuration {
            Configuration::Lumped => (c.total_mass(), 0.0),
            Configuration::SprungMotorHousing | Configuration::SprungBallNut => {
                (c.sprung_mass, c.reflected_inertia)
            }
        };
        let k = Polynomial::constant(c.stiffness);
        let moved = Polynomial::new([0.0, 0.0, mass]);
        let dragged = Polynomial::new([0.0, c.damping, inertia]);
        let (p_s, q_s) = sprung_link.over();
        let (p_u, q_u) = unsprung_link.over();
        // The formula of the module, times k p_s p_u.
        let r = &(&k * &p_s) + &(&moved * &(&p_s + &(&k * &q_s)));
        let bracket = &(&(&r * &q_u) + &(&p_s * &p_u)) + &(&(&k * &q_s) * &p_u);
        let denominator = &(&r * &p_u) + &(&dragged * &bracket);
        Self {
            sprung: Transfer::new(&(&k * &p_s) * &p_u, denominator.clone()),
            unsprung: Transfer::new(&r * &p_u, denominator),
            ratio: Transfer::new(&k * &p_s, r),
            spring_at_link_1: c.configuration != Configuration::SprungBallNut,
        }
    }

    /// Both links held: the high-impedance bench.
    #[must_use]
    pub fn locked(c: &Coefficients) -> Self {
        Self::new(c, Link::Fixed, Link::Fixed)
    }

    /// The responses for link 1 and link 2 as the dissertation numbers them: the spring is at link 1 (SMH, lumped) or
    /// at link 2 (SBN). Benches and campaigns call the spring's side link 1 in every configuration:
    /// [`ForceResponse::new`] takes the sides by name.
    #[must_use]
    pub fn between(c: &Coefficients, link_1: Link, link_2: Link) -> Self {
        if c.configuration == Configuration::SprungBallNut {
            Self::new(c, link_2, link_1)
        } else {
            Self::new(c, link_1, link_2)
        }
    }

    /// Force on link 1 per motor force, `F_1/F_m`, in the dissertation's numbering.
    #[must_use]
    pub fn force_1(&self) -> &Transfer {
        if self.spring_at_link_1 { &self.sprung } else { &self.unsprung }
    }

    /// Force on link 2 per motor force, `F_2/F_m`, in the dissertation's numbering.
    #[must_use]
    pub fn force_2(&self) -> &Transfer {
        if self.spring_at_link_1 { &self.unsprung } else { &self.sprung }
    }
}

#[cfg(test)]
mod tests;
