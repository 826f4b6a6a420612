//! What a campaign says of its rig beside the actuator: masses, lengths and the servo's gain, for all runs or for one.

use super::Bench;
use crate::Error;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// A rig's own numbers; `None` where nothing is said. A run's go before the campaign's.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RigValues {
    /// Mass at the end of a pendulum, or what a linear drive moves beside itself, kg.
    pub mass_kg: Option<f64>,
    /// Distance of a pendulum's mass from its joint, m.
    pub length_m: Option<f64>,
    /// Mass of a pendulum's rod, evenly spread, kg.
    pub rod_mass_kg: Option<f64>,
    /// Lever arm of a pendulum that a linear actuator turns, m.
    pub arm_m: Option<f64>,
    /// What a rotary drive on the bench `free` turns beside itself, kg m^2.
    pub inertia_kg_m2: Option<f64>,
    /// Factor of the servo's proportional gain, on a robot of every servo's.
    pub servo_gain: Option<f64>,
    /// The same of single servos of a robot, by joint.
    pub servo_gains: BTreeMap<String, f64>,
}

/// The key of a servo's gain, or of a table of them by joint.
const SERVO_GAIN: &str = "servo_gain";

/// The keys, in a campaign and in a run.
pub(super) const RIG_KEYS: [&str; 6] =
    ["mass_kg", "length_m", "rod_mass_kg", "arm_m", "inertia_kg_m2", SERVO_GAIN];

impl RigValues {
    /// These values, and the other's where nothing is said.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        let mut servo_gains = if self.servo_gain.is_some() { BTreeMap::new() } else { other.servo_gains };
        servo_gains.extend(self.servo_gains);
        Self {
            servo_gains,
            mass_kg: self.mass_kg.or(other.mass_kg),
            length_m: self.length_m.or(other.length_m),
            rod_mass_kg: self.rod_mass_kg.or(other.rod_mass_kg),
            arm_m: self.arm_m.or(other.arm_m),
            inertia_kg_m2: self.inertia_kg_m2.or(other.inertia_kg_m2),
            servo_gain: self.servo_gain.or(other.servo_gain),
        }
    }

    /// Factor of the proportional gain of a joint's servo.
    #[must_use]
    pub fn servo_gain_of(&self, joint: &str) -> f64 {
        self.servo_gains.get(joint).copied().or(self.servo_gain).unwrap_or(1.0)
    }

    /// Sets the value that a campaign file calls `key`.
    ///
    /// # Errors
    ///
    /// What is wrong, to be read after the key: there is no such key, the bench has no such number, or the number is out
    /// of range.
    pub fn set(&mut self, key: &str, number: f64, bench: Bench) -> Result<(), String> {
        let place = match key {
            "mass_kg" => &mut self.mass_kg,
            "length_m" => &mut self.length_m,
            "rod_mass_kg" => &mut self.rod_mass_kg,
            "arm_m" => &mut self.arm_m,
            "inertia_kg_m2" => &mut self.inertia_kg_m2,
            SERVO_GAIN => &mut self.servo_gain,
            _ => return Err(format!("is no number of a rig (known: {})", RIG_KEYS.join(", "))),
        };
        let whose: &[Bench] = match key {
            "mass_kg" => &[Bench::Pendulum, Bench::Free],
            SERVO_GAIN => &[Bench::Pendulum, Bench::Free, Bench::Robot],
            "inertia_kg_m2" => &[Bench::Free],
            _ => &[Bench::Pendulum],
        };
        if !whose.contains(&bench) {
            let benches: Vec<&str> = whose.iter().map(|b| b.as_str()).collect();
            return Err(format!("is for the bench {}, not for '{}'", benches.join(" or "), bench.as_str()));
        }
        let may_vanish = matches!(key, "mass_kg" | "rod_mass_kg" | "inertia_kg_m2");
        if !(number.is_finite() && (number > 0.0 || (may_vanish && number == 0.0))) {
            let admitted = if may_vanish { "zero or positive, and finite" } else { "positive and finite" };
            return Err(format!("is {number}; must be {admitted}"));
        }
        *place = Some(number);
        Ok(())
    }
}

/// The values of a campaign's text, run by run, the campaign's own filled in.
pub(super) fn of_runs(path: &Path, text: &str, bench: Bench) -> Result<Vec<RigValues>, Error> {
    // What is no TOML has been refused before.
    let Ok(root) = DeTable::parse(text) else { return Ok(Vec::new()) };
    let common = of_table(path, text, root.get_ref(), bench)?;
    let runs = root.get_ref().iter().find(|(key, _)| key.get_ref() == "run");
    let Some(DeValue::Array(runs)) = runs.map(|(_, value)| value.get_ref()) else { return Ok(Vec::new()) };
    let tables = runs.iter().filter_map(|run| match run.get_ref() {
        DeValue::Table(table) => Some(table),
        _ => None,
    });
    tables.map(|table| Ok(of_table(path, text, table, bench)?.or(common.clone()))).collect()
}

/// The line of a place in a text, from 1.
pub(super) fn line_at(text: &str, offset: usize) -> u64 {
    1 + text.bytes().take(offset).filter(|b| *b == b'\n').count() as u64
}

fn of_table(path: &Path, text: &str, table: &DeTable, bench: Bench) -> Result<RigValues, Error> {
    let mut values = RigValues::default();
    for (key, value) in table {
        let name = key.get_ref().as_ref();
        if !RIG_KEYS.contains(&name) {
            continue;
        }
        let line = line_at(text, key.span().start);
        let bad = |problem: String| Error::bad(path, line, Some(name), problem);
        if let (SERVO_GAIN, DeValue::Table(joints)) = (name, value.get_ref()) {
            values.servo_gains = gains(joints, bench).map_err(bad)?;
            continue;
        }
        let Some(number) = number(value.get_ref()) else { return Err(bad("is no number".to_owned())) };
        values.set(name, number, bench).map_err(bad)?;
    }
    Ok(values)
}

/// A servo gain for each of some joints.
fn gains(joints: &DeTable, bench: Bench) -> Result<BTreeMap<String, f64>, String> {
    if bench != Bench::Robot {
        return Err(format!("names joints, which the bench {} has not", bench.as_str()));
    }
    let gain = |(joint, value): (&toml::Spanned<Cow<'_, str>>, &toml::Spanned<DeValue<'_>>)| {
        let joint = joint.get_ref().to_string();
        let Some(gain) = number(value.get_ref()) else { return Err(format!("of '{joint}' is no number")) };
        RigValues::default().set(SERVO_GAIN, gain, bench).map_err(|e| format!("of '{joint}' {e}"))?;
        Ok((joint, gain))
    };
    joints.iter().map(gain).collect()
}

fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Float(number) => number.as_str().parse().ok(),
        DeValue::Integer(number) => number.as_str().parse().ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "bench = \"pendulum\"\nlength_m = 0.1\n[[run]]\nfile = \"a.csv\"\nmass_kg = 0.5\n\
                        [[run]]\nfile = \"b.csv\"\nmass_kg = 1\nlength_m = 0.2\nservo_gain = 400\n";

    #[test]
    fn a_runs_own_values_go_before_the_campaigns() {
        let runs = of_runs(Path::new("c.toml"), TEXT, Bench::Pendulum).unwrap();
        assert_eq!(runs[0], RigValues { mass_kg: Some(0.5), length_m: Some(0.1), ..RigValues::default() });
        assert_eq!(
            (runs[1].mass_kg, runs[1].length_m, runs[1].servo_gain),
            (Some(1.0), Some(0.2), Some(400.0))
        );
    }

    #[test]
    fn a_robots_servos_may_have_gains_of_their_own() {
        let text = "servo_gain = { knee = 2, hip = 3.0 }\n[[run]]\n[[run]]\nservo_gain = { hip = 5 }\n\
                    [[run]]\nservo_gain = 7\n";
        let of = |text: &str, bench| of_runs(Path::new("c.toml"), text, bench);
        let runs = of(text, Bench::Robot).unwrap();
        let gains = |joint: &str| runs.iter().map(|r| r.servo_gain_of(joint)).collect::<Vec<_>>();
        assert_eq!((gains("knee"), gains("hip")), (vec![2.0, 2.0, 7.0], vec![3.0, 5.0, 7.0]));
        assert_eq!(runs[1].servo_gain_of("ankle"), 1.0);
        let error = |text: &str, bench| of(text, bench).unwrap_err().to_string();
        assert!(error(text, Bench::Pendulum).contains("names joints"));
        let negative = error(&text.replace("= 5", "= -5"), Bench::Robot);
        assert!(negative.contains("line 4") && negative.contains("of 'hip' is -5"), "{negative}");
    }

    #[test]
    fn a_key_that_no_rig_has_is_refused_with_those_that_it_has() {
        let mut rig = RigValues::default();
        let error = rig.set("mass", 1.0, Bench::Pendulum).unwrap_err();
        assert!(error.contains("mass_kg, length_m"), "{error}");
        assert_eq!(rig, RigValues::default());
    }

    #[test]
    fn what_a_bench_cannot_have_is_named_with_its_line() {
        let error = of_runs(Path::new("c.toml"), TEXT, Bench::Free).unwrap_err().to_string();
        assert!(error.contains("line 2") && error.contains("length_m"), "{error}");
        let negative = TEXT.replace("= 0.5", "= -0.5");
        let error = of_runs(Path::new("c.toml"), &negative, Bench::Pendulum).unwrap_err().to_string();
        assert!(error.contains("line 5") && error.contains("mass_kg"), "{error}");
        let word = TEXT.replace("= 400", "= \"high\"");
        let error = of_runs(Path::new("c.toml"), &word, Bench::Pendulum).unwrap_err().to_string();
        assert!(error.contains("line 10") && error.contains("no number"), "{error}");
    }
}
