//! Friction that falls with the temperature: `F exp(-a (T - T_0))`, `T_0` where a run begins.

use super::{Known, friction};

/// How fast the drive of a campaign warms, K/s: by 40 K in a run of 20 s.
const WARMS_K_S: f64 = 2.0;

pub(super) const BY_TEMPERATURE: Known = Known::new(
    "temperature-friction",
    |m, v, _| {
        m.warms_k_s = WARMS_K_S;
        friction::rubs(m, v, |v, at| v[0] * (-v[1] * at.warmer_k).exp());
    },
    |d, a| vec![("force_n", 40.0 * a), ("fall_per_k", d.between(0.01, 0.03))],
);
