//! What single numbers of a log say of its run: the load that it moved, and the gain of its servo.

use sealegs::logs::Log;

/// What logs call a key of a `[[run]]`: BAM's recordings and their like.
const KEYS: [(&str, &[&str]); 4] = [
    ("mass_kg", &["mass", "mass_kg", "load_kg"]),
    ("length_m", &["length", "length_m"]),
    ("rod_mass_kg", &["arm_mass", "rod_mass", "rod_mass_kg"]),
    ("servo_gain", &["kp"]),
];

/// The keys of a pendulum's `[[run]]` that a log's numbers fill in, where every log has them; of a servo's gain only where it differs: with
/// one gain an actuator file states it as it is.
#[derive(Default)]
pub(super) struct Loads {
    keys: Vec<(&'static str, &'static str)>,
}

impl Loads {
    /// Of the logs of a pendulum.
    pub(super) fn of<'a>(logs: impl Iterator<Item = &'a Log> + Clone) -> Self {
        let every = |name: &str| logs.clone().all(|log| value(log, name).is_some_and(|v| v > 0.0));
        let differs = |name: &str| {
            let mut values = logs.clone().filter_map(|log| value(log, name));
            let first = values.next();
            values.any(|v| Some(v) != first)
        };
        let named = |names: &[&'static str]| names.iter().copied().find(|name| every(name));
        let keys = KEYS.iter().filter_map(|(key, names)| Some((*key, named(names)?)));
        Self { keys: keys.filter(|(key, name)| *key != "servo_gain" || differs(name)).collect() }
    }

    /// Whether the load that a pendulum carries is among them.
    pub(super) fn say_load(&self) -> bool {
        ["mass_kg", "length_m"].iter().all(|key| self.keys.iter().any(|(own, _)| own == key))
    }

    /// The lines of a log's run.
    pub(super) fn lines(&self, log: &Log) -> String {
        let line = |(key, name): &(&str, &str)| {
            let gain = "; TODO: the actuator file states the loop's gain per 1 of it";
            let todo = if *key == "servo_gain" { gain } else { "" };
            Some(format!("{key} = {:?}   # '{name}' in the log{todo}\n", value(log, name)?))
        };
        self.keys.iter().filter_map(line).collect()
    }
}

fn value(log: &Log, name: &str) -> Option<f64> {
    log.constants.iter().find(|(own, _)| own == name).map(|(_, value)| *value)
}
