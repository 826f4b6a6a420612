//! What the drive makes of a command.

use super::Known;

pub(super) const TORQUE_RIPPLE: Known = Known::new(
    "torque-ripple",
    |m, v, _| m.ripple = [v[0], v[1], v[2]],
    |d, a| {
        let cycles = d.one_of(&[4.0, 6.0, 7.0, 8.0, 11.0, 12.0, 14.0]);
        vec![("amplitude_n", 20.0 * a), ("cycles_per_rev", cycles), ("phase_rad", d.between(-3.0, 3.0))]
    },
);

pub(super) const CURRENT_SATURATION: Known =
    Known::new("current-saturation", |m, v, _| m.command_limit = v[0], |_, a| vec![("limit_a", 4.0 / a)]);

pub(super) const VOLTAGE_SATURATION: Known = Known::new(
    "voltage-saturation",
    |m, v, _| m.voltage = Some([v[0], v[1]]),
    |d, a| {
        let bus = d.between(12.0, 24.0);
        vec![("bus_v", bus), ("resistance_ohm", 0.25 * bus * a)]
    },
);

pub(super) const TRANSPORT_DELAY: Known =
    Known::new("transport-delay", |m, v, _| m.command_delay_s = v[0], |_, a| vec![("delay_s", 1e-3 * a)]);

pub(super) const COMMAND_QUANTISATION: Known = Known::new(
    "command-quantisation",
    |m, v, _| m.count = Some([v[0], v[1]]),
    |d, a| vec![("count_a", 0.1 * a), ("rounding", d.one_of(&[0.0, 1.0]))],
);
