//! Friction that repeats along the screw: `F (1 + a cos(2 pi (y - y_0) / L))`.

use super::{Known, friction};
use std::f64::consts::TAU;

pub(super) const ALONG_SCREW: Known = Known::new(
    "position-dependent-friction",
    |m, v, _| friction::rubs(m, v, |v, at| v[0] * (1.0 + v[1] * (TAU * (at.y - v[3]) / v[2]).cos())),
    |d, a| {
        let period = d.magnitude(2e-4, 6e-4);
        let place = d.between(-0.5, 0.5) * period;
        let variation = d.between(0.6, 1.0);
        vec![("force_n", 25.0 * a), ("variation", variation), ("period_m", period), ("place_m", place)]
    },
);
