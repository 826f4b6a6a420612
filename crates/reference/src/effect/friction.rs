//! Friction of the rotor.

use super::{FrictionLaw, Known, Rubbing};
use crate::Reference;

/// Adds a bound to the rotor's dry friction. A law of nothing but zeros is none: a bound of zero would be looked for at every
/// reversal, and change the last bits.
pub(super) fn rubs(machine: &mut Reference, values: &[f64], bound: fn(&[f64], &Rubbing) -> f64) {
    if values.iter().any(|v| *v != 0.0) {
        machine.rotor_friction.push(FrictionLaw { values: values.to_vec(), bound });
    }
}

pub(super) const COULOMB: Known =
    Known::new("coulomb-friction", |m, v, _| m.coulomb = v[0], |_, a| vec![("force_n", 30.0 * a)]);

pub(super) const PRESLIDING: Known = Known::new(
    "presliding-friction",
    |m, v, _| m.presliding = Some([v[0], v[1]]),
    |d, a| {
        // It slips after a travel that is small beside the run's.
        let force = 30.0 * a;
        vec![("force_n", force), ("stiffness_n_m", force / d.magnitude(1e-5, 5e-5))]
    },
);

pub(super) const STRIBECK: Known = Known::new(
    "stribeck-friction",
    |m, v, _| {
        rubs(m, v, |v, at| v[0] + (v[1] - v[0]) * (-(at.speed / v[2]).powi(2)).exp());
    },
    |d, a| {
        let low = 20.0 * a;
        let velocity = d.magnitude(0.002, 0.006);
        vec![("coulomb_n", low), ("static_n", low * d.between(1.8, 2.6)), ("stribeck_velocity_m_s", velocity)]
    },
);

pub(super) const LOAD_DEPENDENT: Known = Known::new(
    "load-dependent-friction",
    |m, v, _| rubs(m, v, |v, at| v[0] * at.load.abs()),
    |_, a| vec![("coefficient", 0.06 * a)],
);

pub(super) const DIRECTION_DEPENDENT: Known = Known::new(
    "direction-dependent-friction",
    |m, v, _| rubs(m, v, |v, at| v[0] * (1.0 + v[1] * at.direction)),
    |d, a| {
        let asymmetry = d.between(0.3, 0.7) * d.one_of(&[-1.0, 1.0]);
        vec![("force_n", 30.0 * a), ("asymmetry", asymmetry)]
    },
);

pub(super) const QUADRATIC_DRAG: Known =
    Known::new("quadratic-drag", |m, v, _| m.drag = v[0], |_, a| vec![("coefficient_n_s2_m2", 1e5 * a)]);
