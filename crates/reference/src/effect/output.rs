//! The output that the screw moves.

use super::Known;
use crate::End;

pub(super) const FRICTION: Known = Known {
    on_output: true,
    ..Known::new(
        "output-friction",
        |m, v, _| {
            let arm = if let End::Pendulum { arm_m, .. } = m.link_2 { arm_m } else { 1.0 };
            m.output_friction = v[0] / arm;
        },
        |_, a| vec![("torque_nm", 0.4 * a)],
    )
};

pub(super) const WOBBLING_MASS: Known = Known {
    on_output: true,
    ..Known::new(
        "wobbling-mass",
        |m, v, _| m.wobbling = Some([v[0], v[1], v[2], v[3]]),
        |d, a| {
            // The card's radius is fixed: mass and radius act together.
            let (frequency, ratio) = (d.magnitude(3.0, 12.0), d.magnitude(0.03, 0.12));
            vec![
                ("mass_kg", 0.15 * a),
                ("radius_m", 0.3),
                ("frequency_hz", frequency),
                ("damping_ratio", ratio),
            ]
        },
    )
};

pub(super) const LOAD_MISMATCH: Known = Known {
    on_output: true,
    ..Known::new(
        "load-mismatch",
        |m, v, _| {
            if let End::Pendulum { mass_kg, length_m, .. } = &mut m.link_2 {
                // A point mass with this weight's moment and this inertia.
                *mass_kg *= v[0] * v[0] / v[1];
                *length_m *= v[1] / v[0];
            }
        },
        |d, a| {
            let (mass, length) = (1.0 + 0.06 * a, 1.0 + d.magnitude(0.02, 0.06) * a);
            vec![("gravity_ratio", mass * length), ("inertia_ratio", mass * length * length)]
        },
    )
};
