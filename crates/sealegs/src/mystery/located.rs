//! Whether a diagnosis says where something acts that is in no catalogue, and what it depends on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is missing at a port, as `diagnose --json` lists it under `missing_signals`; other keys are left alone.
#[derive(Debug, Clone, Deserialize)]
pub struct MissingSignal {
    /// `command`, `rotor`, `drive`, `spring`, `output`, `joint`, `contact`, `sensor/<channel>`; on a leg behind its place.
    pub port: String,
    /// What it depends on, the most telling first.
    #[serde(default)]
    pub depends_on: Vec<String>,
}

/// How what is said stands against the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Located {
    /// It is at the right port.
    pub port: bool,
    /// What it depends on most is among what is said.
    pub dependence: bool,
}

impl Located {
    /// Both.
    #[must_use]
    pub fn right(self) -> bool {
        self.port && self.dependence
    }
}

/// Judges the first of the missing signals, in the order in which a diagnosis lists them, against the port and the
/// dependence of what is hidden. Nothing said is wrong.
#[must_use]
pub fn located(port: &str, depends_on: &[String], said: &[MissingSignal]) -> Located {
    let Some(first) = said.first() else { return Located { port: false, dependence: false } };
    let (wanted, named) = (place(port), place(&first.port));
    // Something of all sensors shows at any of them.
    let same = wanted == named || (wanted == "sensor" && named.starts_with("sensor/"));
    let most = depends_on.first().map(|d| quantity(d));
    let dependence = most.is_some_and(|most| first.depends_on.iter().any(|d| quantity(d) == most));
    Located { port: same, dependence: same && dependence }
}

/// A port without its place on a leg. A gain of the drive is a gain of the command: the data cannot tell.
fn place(port: &str) -> &str {
    let port = match port.split_once('/') {
        Some((first, rest)) if first != "sensor" => rest,
        _ => port,
    };
    if port == "drive" { "command" } else { port }
}

/// What a dependence is about, whatever it is called: a spring's deflection and its load, a screw's extension and the
/// rotor's angle are one.
fn quantity(name: &str) -> &'static str {
    const WORDS: [(&str, &[&str]); 6] = [
        ("time", &["time"]),
        ("past", &["past", "history", "delay"]),
        ("position", &["position", "extension", "angle", "place"]),
        ("load", &["load", "deflection", "force", "torque", "value", "signal"]),
        ("command", &["command", "current", "input"]),
        // Last, as the direction is a factor of a bound that depends on something else.
        ("speed", &["speed", "velocity", "direction", "sign"]),
    ];
    let name = name.to_lowercase();
    WORDS.iter().find(|(_, words)| words.iter().any(|w| name.contains(w))).map_or("", |(what, _)| what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_signal_is_judged_by_its_port_and_what_it_depends_on_most() {
        let said = |port: &str, depends: &[&str]| {
            let depends_on = depends.iter().map(|d| (*d).to_owned()).collect();
            vec![MissingSignal { port: port.to_owned(), depends_on }]
        };
        let judged = |port: &str, most: &str, said: &[MissingSignal]| {
            let of = located(port, &[most.to_owned(), "direction".to_owned()], said);
            (of.port, of.dependence)
        };
        assert_eq!(
            judged("rotor", "position", &said("rotor", &["direction", "screw extension"])),
            (true, true)
        );
        assert_eq!(judged("rotor", "position", &said("rotor", &["direction"])), (true, false));
        let bound = said("rotor", &["direction and position"]);
        assert_eq!(judged("rotor", "position", &bound), (true, true));
        assert_eq!(judged("rotor", "direction", &bound), (true, false));
        assert_eq!(judged("rotor", "position", &said("spring", &["extension"])), (false, false));
        assert_eq!(judged("spring", "deflection", &said("knee/spring", &["load"])), (true, true));
        assert_eq!(judged("command", "command", &said("drive", &["current_a"])), (true, true));
        assert_eq!(judged("sensor", "past", &said("sensor/force_1_n", &["its own past"])), (true, true));
        assert_eq!(judged("sensor/force_1_n", "time", &said("sensor/force_2_n", &["time"])), (false, false));
        assert_eq!(judged("spring", "time", &[]), (false, false));
    }
}
