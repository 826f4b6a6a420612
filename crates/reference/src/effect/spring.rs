//! The spring and what lies in line with it.

use super::Known;

pub(super) const HARDENING: Known =
    Known::new("hardening-spring", |m, v, _| m.cubic = v[0], |_, a| vec![("cubic_n_m3", 3e10 * a)]);

pub(super) const DAMPING: Known = Known::new(
    "spring-damping",
    |m, v, _| m.spring_damping = v[0],
    |_, a| vec![("damping_n_s_m", 300.0 * a)],
);

pub(super) const HYSTERESIS: Known = Known::new(
    "spring-hysteresis",
    |m, v, _| m.spring_slip = Some([v[0], v[1]]),
    |d, a| {
        let force = 15.0 * a;
        vec![("stiffness_n_m", force / d.magnitude(1e-5, 1e-4)), ("slip_force_n", force)]
    },
);

pub(super) const BACKLASH: Known =
    Known::new("backlash", |m, v, _| m.gap = v[0], |_, a| vec![("gap_m", 3e-5 * a)]);

pub(super) const SERIES_COMPLIANCE: Known = Known {
    // Where forces and angles alone are measured it is a softer spring.
    beside_deflection: true,
    ..Known::new(
        "series-compliance",
        |m, v, _| m.series = Some([v[0], v[1]]),
        |d, a| vec![("stiffness_n_m", 2e7 / a), ("unsprung_mass_kg", d.between(0.05, 0.15))],
    )
};
