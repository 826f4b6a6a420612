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
    (Quantity::Speed, &["vel", "velocity", "velocities", "speed", "omega", "qd", "dq", "qdot", "rpm"]),
    (Quantity::Torque, &["tau", "torque", "torques", "effort", "efforts", "moment", "nm"]),
    (Quantity::Force, &["force", "forces", "loadcell", "cell", "fx", "fy", "fz", "f"]),
    (Quantity::Current, &["current", "currents", "curr", "cur", "iq", "amp", "amps", "ma", "i"]),
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
            "enc",
            "encoder",
            "deflection",
            "elongation",
            "deg",
            "rad",
        ],
    ),
];

pub(super) const COMMANDED: [&str; 21] = [
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
    "u",
    "req",
    "demand",
];

/// Of these a topic or a list above the column may be called as well.
pub(super) const COMMANDS: [&str; 8] =
    ["cmd", "command", "commands", "commanded", "desired", "reference", "target", "setpoints"];

/// Accelerations, which no channel holds.
pub(super) const ACCELERATION: [&str; 8] =
    ["acc", "accel", "acceleration", "accelerations", "ddot", "qdd", "ddq", "jerk"];

pub(super) const SUPPLY: [&str; 7] = ["supply", "bus", "vbus", "battery", "vbat", "input", "vin"];

/// Derived from other columns: what a controller made of a measurement is none.
pub(super) const DERIVED: [&str; 7] = ["filt", "filtered", "est", "estimated", "fric", "error", "err"];
