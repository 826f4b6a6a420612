//! Words in the names of columns, and what they mean.

/// What is measured or commanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Position,
    Speed,
    Torque,
    Force,
    Current,
    Voltage,
    Temperature,
    Enable,
}

/// Words of names, and what they mean.
pub(super) const WORDS: [(Quantity, &[&str]); 8] = [
    (Quantity::Enable, &["enable", "enabled", "enabling"]),
    (Quantity::Temperature, &["temp", "temperature", "temps"]),
    (
        Quantity::Speed,
        &[
            "vel",
            "velocity",
            "velocities",
            "speed",
            "omega",
            "qd",
            "dq",
            "qdot",
            "qvel",
            "rpm",
            "geschwindigkeit",
            "drehzahl",
        ],
    ),
    (Quantity::Torque, &["tau", "torque", "torques", "effort", "efforts", "moment", "nm", "drehmoment"]),
    (Quantity::Force, &["force", "forces", "loadcell", "cell", "fx", "fy", "fz", "f", "kraft"]),
    (Quantity::Current, &["current", "currents", "curr", "cur", "iq", "amp", "amps", "ma", "i", "strom"]),
    (Quantity::Voltage, &["voltage", "volt", "volts", "vbus", "vbat", "vin", "u"]),
    (
        Quantity::Position,
        &[
            "position",
            "positions",
            "pos",
            "angle",
            "angles",
            "theta",
            "q",
            "qm",
            "qpos",
            "winkel",
            "phi",
            "enc",
            "encoder",
            "deflection",
            "elongation",
            "deg",
            "rad",
        ],
    ),
];

pub(super) const COMMANDED: [&str; 23] = [
    "cmd",
    "command",
    "commands",
    "commanded",
    "setpoints",
    "des",
    "desired",
    "ref",
    "reference",
    "goal",
    "target",
    "set",
    "setpoint",
    "sp",
    "con",
    "ctrl",
    "control",
    "action",
    "actions",
    "u",
    "req",
    "demand",
    "soll",
];

/// Of these a topic or a list above the column may be called as well.
pub(super) const COMMANDS: [&str; 14] = [
    "action",
    "actions",
    "goal",
    "cmd",
    "command",
    "commands",
    "commanded",
    "des",
    "desired",
    "ref",
    "reference",
    "target",
    "setpoint",
    "setpoints",
];

/// Accelerations, which no channel holds.
pub(super) const ACCELERATION: [&str; 8] =
    ["acc", "accel", "acceleration", "accelerations", "ddot", "qdd", "ddq", "jerk"];

/// What is added to the command of a loop.
pub(super) const FEEDFORWARD_WORDS: [&str; 3] = ["ff", "feedforward", "forward"];

pub(super) const SUPPLY: [&str; 7] = ["supply", "bus", "vbus", "battery", "vbat", "input", "vin"];

/// Derived from other columns: what a controller made of a measurement is none.
pub(super) const DERIVED: [&str; 7] = ["filt", "filtered", "est", "estimated", "fric", "error", "err"];
