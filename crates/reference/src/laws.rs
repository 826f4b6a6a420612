//! What acts inside an actuator beside its linear parts: one set of laws for benches and legs.

use crate::beyond::Beyond;
use crate::effect::Rubbing;
use crate::reference::Reference;

impl Reference {
    /// The spring's force without its slipping element, N, positive in compression, at a deflection (m) and its rate.
    pub(crate) fn spring_force(&self, deflection: f64, rate: f64) -> f64 {
        let left = if deflection > 0.5 * self.gap {
            deflection - 0.5 * self.gap
        } else if deflection < -0.5 * self.gap {
            deflection + 0.5 * self.gap
        } else {
            return 0.0;
        };
        let beyond = match self.beyond {
            Some(Beyond::KinkedSpring { from_m, ratio }) => ratio * self.stiffness * (left - from_m).max(0.0),
            _ => 0.0,
        };
        self.stiffness * left + self.cubic * left.powi(3) + self.spring_damping * rate + beyond
    }

    /// The spring's force at a time as a ratio of what it was at the beginning.
    pub(crate) fn spring_left(&self, time_s: f64) -> f64 {
        match self.beyond {
            Some(Beyond::SofteningSpring { loss, time_constant_s }) => {
                1.0 + loss * (-time_s / time_constant_s).exp_m1()
            }
            _ => 1.0,
        }
    }

    /// What is left for the screw of the motor's force `motor`, N, at an extension (m) and its speed: damping, drag
    /// and ripple taken into account, dry friction not.
    pub(crate) fn on_screw(&self, motor: f64, y: f64, y_dot: f64) -> f64 {
        motor - self.damping * y_dot - self.drag * y_dot.abs() * y_dot
            + self.ripple[0] * (self.ripple[1] * y / self.travel_per_rad + self.ripple[2]).sin()
    }

    /// Whether the rotor has dry friction.
    pub(crate) fn has_rotor_friction(&self) -> bool {
        self.coulomb > 0.0
            || !self.rotor_friction.is_empty()
            || matches!(self.beyond, Some(Beyond::RoughEnd { .. } | Beyond::FrictionBump { .. }))
    }

    /// Bound of the rotor's dry friction, N.
    pub(crate) fn rotor_bound(&self, at: &Rubbing) -> f64 {
        let y = at.y;
        let laws: f64 = self.rotor_friction.iter().map(|law| (law.bound)(&law.values, at)).sum();
        let placed = match self.beyond {
            Some(Beyond::RoughEnd { force_n, from_m, width_m }) => {
                0.5 * force_n * (1.0 + ((y - from_m) / width_m).tanh())
            }
            Some(Beyond::FrictionBump { force_n, at_m, width_m }) => {
                force_n * (-((y - at_m) / width_m).powi(2)).exp()
            }
            _ => 0.0,
        };
        self.coulomb + laws + placed
    }
}
