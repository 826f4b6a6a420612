//! Base motion: the frame that holds link 1 is a mass on a spring and a damper.

use super::Known;
use crate::End;

pub(super) const BASE_MOTION: Known = Known::new(
    "base-motion",
    |m, v, _| {
        let [hz, mass, ratio] = [v[0], v[1], v[2]];
        let w = std::f64::consts::TAU * hz;
        m.link_1 = End::Mounted([mass, mass * w * w, 2.0 * ratio * w * mass]);
    },
    // The lighter the frame, the more it yields.
    |d, a| {
        let (hz, ratio) = (d.magnitude(12.0, 25.0), d.magnitude(0.02, 0.1));
        vec![("frequency_hz", hz), ("base_mass_kg", 400.0 / a), ("damping_ratio", ratio)]
    },
);
