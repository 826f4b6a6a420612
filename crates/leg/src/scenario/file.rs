//! Reading a scenario: embedded or from a file, with overrides, and its numbers checked.

use super::{BaseSpec, Motion, Scenario};
use crate::LegError;
use crate::error::nearest;
use crate::robot::{JointKind, Robot};
use crate::simulation::load_robot;
use sealegs_actuator::ActuatorError;
use sealegs_actuator::text::parse_toml;
use std::path::Path;

/// Most steps of a run: hours of computing. More is a slip of the pen, in the duration or in the step.
pub(crate) const MOST_STEPS: f64 = 1e8;

/// Name and text of the scenarios that come with the program.
const PRESETS: [(&str, &str); 5] = [
    ("thor-drop", include_str!("../../../../assets/scenarios/thor-drop.toml")),
    ("saffir-drop", include_str!("../../../../assets/scenarios/saffir-drop.toml")),
    ("thor-swing", include_str!("../../../../assets/scenarios/thor-swing.toml")),
    ("saffir-swing", include_str!("../../../../assets/scenarios/saffir-swing.toml")),
    ("thor-impact", include_str!("../../../../assets/scenarios/thor-impact.toml")),
];

/// Names of the embedded scenarios.
#[must_use]
pub fn preset_names() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}

/// The text of an embedded scenario.
#[must_use]
pub fn preset_text(name: &str) -> Option<&'static str> {
    PRESETS.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
}

impl Scenario {
    /// A user's file if `name_or_path` is one, else the embedded scenario of that name, with `overrides` of
    /// the form `key=value`, the key dotted (`start.drop_height_m=0.1`), the value as in TOML or plain text.
    ///
    /// # Errors
    ///
    /// [`LegError::UnknownScenario`], [`LegError::Io`], [`LegError::Actuator`] for text and keys, or
    /// [`LegError::Scenario`] for a number or override that is not usable.
    pub fn load(name_or_path: &str, overrides: &[String]) -> Result<Self, LegError> {
        let path = Path::new(name_or_path);
        if path.is_file() {
            let text = std::fs::read_to_string(path)
                .map_err(|source| LegError::Io { path: name_or_path.to_owned(), source })?;
            let mut scenario = Self::from_toml(&text, name_or_path, overrides)?;
            scenario.name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
            scenario.folder = path.parent().map(Path::to_owned);
            return Ok(scenario);
        }
        let Some(text) = preset_text(name_or_path) else {
            if path.extension().is_some_and(|e| e == "toml") || path.components().count() > 1 {
                let source = std::io::Error::new(std::io::ErrorKind::NotFound, "no such file");
                return Err(LegError::Io { path: name_or_path.to_owned(), source });
            }
            let known = preset_names();
            return Err(LegError::UnknownScenario {
                name: name_or_path.to_owned(),
                suggestion: nearest(name_or_path, known.iter().copied()),
                known: known.into_iter().map(str::to_owned).collect(),
            });
        };
        let mut scenario = Self::from_toml(text, &format!("{name_or_path}.toml"), overrides)?;
        scenario.name = name_or_path.to_owned();
        Ok(scenario)
    }

    /// A scenario for a URDF alone, and its robot: the base is fixed, nobody commands, and the robot falls for a
    /// second from where all joints are zero. A joint whose limits leave zero out starts at the nearer of them, with
    /// a remark.
    ///
    /// # Errors
    ///
    /// As [`Scenario::load`] for the overrides, and what is wrong with the robot.
    pub fn for_robot(urdf: &str, overrides: &[String]) -> Result<(Self, Robot), LegError> {
        let text = format!("robot = {}\nduration_s = 1.0\n", toml::Value::from(urdf));
        let mut scenario = Self::from_toml(&text, urdf, overrides)?;
        scenario.name =
            Path::new(urdf).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let mut robot = load_robot(&scenario)?;
        let mut moved = Vec::new();
        for joint in robot.moving_joints() {
            let nearest = 0.0_f64.clamp(joint.limits.lower, joint.limits.upper);
            if nearest != 0.0 && !scenario.start.posture_rad.contains_key(&joint.name) {
                let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
                moved.push(format!("'{}' at {nearest} {unit}", joint.name));
                scenario.start.posture_rad.insert(joint.name.clone(), nearest);
            }
        }
        if !moved.is_empty() {
            let what = "joints whose limits leave zero out start at the nearer limit";
            robot.warnings.push(format!("{urdf}: {what}: {}", moved.join(", ")));
        }
        Ok((scenario, robot))
    }

    /// Reads a scenario from text; `file` is named in messages.
    ///
    /// # Errors
    ///
    /// As [`Scenario::load`].
    pub fn from_toml(text: &str, file: &str, overrides: &[String]) -> Result<Self, LegError> {
        // The text alone first: its faults have lines.
        let scenario: Self = parse_toml(text, file)?;
        if overrides.is_empty() {
            scenario.check(file)?;
            return Ok(scenario);
        }
        let mut table: toml::Table = parse_toml(text, file)?;
        let given = format!("--set {}", overrides.join(" --set "));
        for one in overrides {
            set(&mut table, one)?;
        }
        // Written out again so that unknown keys get the same suggestion as in a file.
        let changed =
            toml::to_string(&table).map_err(|e| LegError::scenario(&given, "value", e.to_string()))?;
        let scenario: Self = parse_toml(&changed, &given).map_err(|error| match error {
            // The line would be that of the rewritten text, which nobody has seen.
            ActuatorError::Syntax { message, suggestion, .. } => {
                let hint = suggestion.map_or_else(String::new, |s| format!("; did you mean '{s}'?"));
                LegError::scenario(&given, "key", format!("{message}{hint}"))
            }
            other => other.into(),
        })?;
        scenario.check(&given)?;
        Ok(scenario)
    }

    /// Makes the scenario's names of other files hold for a file in `folder`: those beside the present file get
    /// their whole path where the folder is another.
    ///
    /// # Errors
    ///
    /// [`LegError::Io`] if the present file's folder can no longer be found.
    pub fn move_to(&mut self, folder: &Path) -> Result<(), LegError> {
        let Some(from) = self.folder.clone() else { return Ok(()) };
        let from = if from.as_os_str().is_empty() { Path::new(".").to_owned() } else { from };
        let whole = |path: &Path| {
            path.canonicalize().map_err(|source| LegError::Io { path: path.display().to_string(), source })
        };
        let from = whole(&from)?;
        if folder.canonicalize().is_ok_and(|to| to == from) {
            return Ok(());
        }
        let names = [Some(&mut self.robot), self.placement.as_mut()];
        for name in names.into_iter().flatten().chain(self.current_file.values_mut().map(|f| &mut f.file)) {
            let path = from.join(&*name);
            if path.is_file() {
                *name = path.to_string_lossy().into_owned();
            }
        }
        self.folder = Some(folder.to_owned());
        Ok(())
    }

    /// Checks every number that needs no robot.
    fn check(&self, file: &str) -> Result<(), LegError> {
        let bad = |field: String, value: f64, admitted: &str| {
            Err(LegError::scenario(file, &field, format!("{value}: must be {admitted}")))
        };
        let positive = |field: &str, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                bad(field.to_owned(), value, "positive and finite")
            }
        };
        let not_negative = |field: &str, value: f64| {
            if value >= 0.0 && value.is_finite() {
                Ok(())
            } else {
                bad(field.to_owned(), value, "zero or positive, and finite")
            }
        };
        let finite =
            |field: String, value: f64| if value.is_finite() { Ok(()) } else { bad(field, value, "finite") };
        positive("duration_s", self.duration_s)?;
        positive("step_s", self.step_s)?;
        positive("sample_period_s", self.sample_period_s)?;
        not_negative("gravity_m_s2", self.gravity_m_s2)?;
        if self.step_s > 2e-3 {
            return bad("step_s".to_owned(), self.step_s, "at most 0.002 s: the springs are unstable beyond");
        }
        if self.duration_s / self.step_s > MOST_STEPS {
            let problem =
                format!("{:e}: must be at most {MOST_STEPS:e} steps of {:e} s", self.duration_s, self.step_s);
            return Err(LegError::scenario(file, "duration_s", problem));
        }
        self.multiple(file, "sample_period_s", self.sample_period_s)?;
        positive("controller.rate_hz", self.controller.rate_hz)?;
        self.multiple(file, "1/controller.rate_hz", 1.0 / self.controller.rate_hz)?;
        match self.base {
            BaseSpec::Fixed { height_m } => finite("base.height_m".to_owned(), height_m)?,
            BaseSpec::Rail { carriage_mass_kg } => not_negative("base.carriage_mass_kg", carriage_mass_kg)?,
        }
        not_negative("start.drop_height_m", self.start.drop_height_m)?;
        for (joint, value) in &self.start.posture_rad {
            finite(format!("start.posture_rad.{joint}"), *value)?;
        }
        for (joint, value) in &self.start.speed_rad_s {
            finite(format!("start.speed_rad_s.{joint}"), *value)?;
        }
        if let Some(g) = &self.ground {
            finite("ground.height_m".to_owned(), g.height_m)?;
            if g.slope_rad.is_nan() || g.slope_rad.abs() >= 1.2 {
                return bad("ground.slope_rad".to_owned(), g.slope_rad, "between -1.2 and 1.2");
            }
            not_negative("ground.friction", g.friction)?;
            positive("ground.stiffness_n_m_n", g.stiffness_n_m_n)?;
            if !(1.0..=3.0).contains(&g.exponent) {
                return bad("ground.exponent".to_owned(), g.exponent, "between 1 and 3");
            }
            not_negative("ground.damping_s_m", g.damping_s_m)?;
            positive("ground.bristle_stiffness_n_m", g.bristle_stiffness_n_m)?;
            not_negative("ground.bristle_damping_n_s_m", g.bristle_damping_n_s_m)?;
        }
        positive("stops.stiffness_nm_rad", self.stops.stiffness_nm_rad)?;
        not_negative("stops.damping_nm_s_rad", self.stops.damping_nm_s_rad)?;
        not_negative("controller.stiffness_nm_rad", self.controller.stiffness_nm_rad)?;
        not_negative("controller.damping_nm_s_rad", self.controller.damping_nm_s_rad)?;
        if let Some(limit) = self.controller.current_limit_a {
            positive("controller.current_limit_a", limit)?;
        }
        for (joint, gains) in &self.controller.joints {
            for (key, value) in
                [("stiffness_nm_rad", gains.stiffness_nm_rad), ("damping_nm_s_rad", gains.damping_nm_s_rad)]
            {
                not_negative(&format!("controller.joints.{joint}.{key}"), value.unwrap_or(0.0))?;
            }
        }
        for (actuator, changes) in &self.actuator {
            positive(
                &format!("actuator.{actuator}.current_limit_a"),
                changes.current_limit_a.unwrap_or(1.0),
            )?;
            for (name, value) in &changes.parameters {
                let field = format!("actuator.{actuator}.parameters.{name}");
                match name.as_str() {
                    "damping" | "sprung_mass" => not_negative(&field, value.value)?,
                    _ => positive(&field, value.value)?,
                }
            }
        }
        for (joint, motion) in &self.motion {
            let field = |key: &str| format!("motion.{joint}.{key}");
            match *motion {
                Motion::HalfCosine { to_rad, start_s, duration_s } => {
                    finite(field("to_rad"), to_rad)?;
                    finite(field("start_s"), start_s)?;
                    positive(&field("duration_s"), duration_s)?;
                }
                Motion::Sine { amplitude_rad, frequency_hz, phase_rad } => {
                    finite(field("amplitude_rad"), amplitude_rad)?;
                    finite(field("phase_rad"), phase_rad)?;
                    positive(&field("frequency_hz"), frequency_hz)?;
                }
            }
        }
        for (actuator, profile) in &self.current {
            profile
                .validate()
                .map_err(|e| LegError::scenario(file, &format!("current.{actuator}"), e.to_string()))?;
        }
        for (index, effect) in self.effects.iter().enumerate() {
            effect.validate(index)?;
        }
        for (channel, sensor) in &self.sensors {
            sensor.validate(channel)?;
        }
        for height in self.sweep.iter().flat_map(|s| &s.heights_m) {
            not_negative("sweep.heights_m", *height)?;
        }
        Ok(())
    }

    /// Whether a period is a whole number of steps.
    fn multiple(&self, file: &str, field: &str, period_s: f64) -> Result<(), LegError> {
        let steps = period_s / self.step_s;
        if steps >= 0.999 && (steps - steps.round()).abs() < 1e-6 * steps {
            return Ok(());
        }
        let problem = format!("{period_s} s: must be a multiple of step_s = {} s", self.step_s);
        Err(LegError::scenario(file, field, problem))
    }
}

/// Applies one override `key=value` to a table.
fn set(table: &mut toml::Table, one: &str) -> Result<(), LegError> {
    let fault = |problem: &str| LegError::scenario("--set", one, problem.to_owned());
    let (path, value) = one.split_once('=').ok_or_else(|| fault("must have the form key=value"))?;
    let value = value.trim();
    // What is no TOML value is plain text: `spring=stiff` needs no quotes.
    let value = toml::from_str::<toml::Table>(&format!("v = {value}"))
        .ok()
        .and_then(|mut t| t.remove("v"))
        .unwrap_or_else(|| toml::Value::String(value.to_owned()));
    let mut keys: Vec<&str> = path.split('.').map(str::trim).collect();
    if keys.iter().any(|k| k.is_empty()) {
        return Err(fault("an empty key"));
    }
    let last = keys.pop().unwrap_or_default();
    let mut at = table;
    for key in keys {
        let next = at.entry(key).or_insert_with(|| toml::Value::Table(toml::Table::new()));
        at = next.as_table_mut().ok_or_else(|| fault("a key inside something that is no table"))?;
    }
    // A whole number stands for a number with a fraction where the file has one.
    let value = match (at.get(last), value) {
        (Some(toml::Value::Float(_)), toml::Value::Integer(i)) => toml::Value::Float(i as f64),
        (_, value) => value,
    };
    at.insert(last.to_owned(), value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str =
        "robot = \"thor-leg\"\nduration_s = 1.0\n[base]\nkind = \"rail\"\ncarriage_mass_kg = 5.0\n";

    fn with(overrides: &[&str]) -> Result<Scenario, LegError> {
        let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
        Scenario::from_toml(SMALL, "small.toml", &overrides)
    }

    #[test]
    fn every_preset_is_readable() {
        for name in preset_names() {
            let scenario = Scenario::load(name, &[]).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(scenario.name, name);
            assert!(!scenario.description.is_empty());
        }
    }

    #[test]
    fn overrides_reach_dotted_keys() {
        let scenario = with(&[
            "start.drop_height_m=1",
            "actuators.spring=stiff",
            "actuator.knee.parameters.stiffness=5e5",
            "base.carriage_mass_kg=7",
        ])
        .expect("good");
        assert_eq!(scenario.start.drop_height_m, 1.0);
        assert_eq!(scenario.actuators.spring.as_deref(), Some("stiff"));
        assert_eq!(scenario.actuator["knee"].parameters["stiffness"].value, 5e5);
        assert_eq!(scenario.base, BaseSpec::Rail { carriage_mass_kg: 7.0 });
    }

    #[test]
    fn faults_name_the_field_and_suggest() {
        let message = |overrides: &[&str]| with(overrides).expect_err("bad").to_string();
        assert!(message(&["start.drop_heigth_m=1"]).contains("did you mean 'drop_height_m'"));
        assert!(message(&["step_s=0"]).contains("step_s: 0: must be positive"));
        assert!(message(&["step_s=nan"]).contains("step_s"));
        assert!(message(&["duration_s=1e300"]).contains("duration_s: 1e300: must be at most 1e8 steps"));
        assert!(message(&["step_s=1e-300"]).contains("at most 1e8 steps"));
        assert!(message(&["sample_period_s=1.5e-4"]).contains("multiple of step_s"));
        assert!(message(&["ground.friction=-1"]).contains("ground.friction"));
        assert!(message(&["nonsense"]).contains("key=value"));
        assert!(message(&["robot.x=1"]).contains("no table"));
        assert!(
            message(&["actuator.knee.parameters.stiffness=-1"])
                .contains("actuator.knee.parameters.stiffness")
        );
        let misspelt = SMALL.replace("duration_s", "duraton_s");
        let message = Scenario::from_toml(&misspelt, "x.toml", &[]).expect_err("misspelt").to_string();
        assert!(message.contains("x.toml:2") && message.contains("did you mean 'duration_s'"), "{message}");
        assert!(
            Scenario::load("thor-drp", &[])
                .expect_err("none")
                .to_string()
                .contains("did you mean 'thor-drop'")
        );
    }
}
