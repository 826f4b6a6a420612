//! Dahl friction: `f' = k y' (1 - f sign(y') / F)`, a state of its own in the motion (P. R. Dahl 1968).

use super::Known;

pub(super) const DAHL: Known = Known::new(
    "dahl-friction",
    |m, v, _| m.dahl = Some([v[0], v[1]]),
    |d, a| {
        // As presliding friction: the travel to slip is small beside the run's.
        let force = 30.0 * a;
        vec![("force_n", force), ("stiffness_n_m", force / d.magnitude(1e-5, 5e-5))]
    },
);
