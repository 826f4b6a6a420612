//! Errors of the sensors.

use super::Known;

pub(super) const STRUCTURAL_MODE: Known = Known::new(
    "structural-mode",
    |m, v, _| m.sensors.mode = Some([v[0], v[1], v[2]]),
    |d, a| {
        let (frequency, ratio) = (d.between(55.0, 95.0), d.magnitude(0.02, 0.08));
        vec![("frequency_hz", frequency), ("damping_ratio", ratio), ("participation", 0.4 * a)]
    },
);

pub(super) const LAG: Known = Known::new(
    "sensor-lag",
    |m, v, channel| m.sensors.lag = Some((channel.map(str::to_owned), v[0])),
    |_, a| vec![("cutoff_hz", 200.0 / a)],
);

pub(super) const DELAY: Known = Known::new(
    "sensor-delay",
    |m, v, channel| m.sensors.delay = Some((channel.map(str::to_owned), v[0])),
    |_, a| vec![("delay_s", 1e-3 * a)],
);
