//! A law that is a curve at each place where it may act; see [`sealegs_model::Law`].

use crate::ActuatorError;
use crate::plant::{CommandStage, DryFriction, Link, Plant, RotorForce, SensorStage, Slip, SpringForce};
use sealegs_model::{Curve, Factor, Law, Over, Parameter};

/// How far an ordinate may go beyond the greatest one.
const FARTHEST: f64 = 10.0;

/// Where a curve acts, over what, multiplied by what; and the unit of an ordinate as printed, `F` a force and `X` a length
/// of the actuator.
const KINDS: [(&str, Over, Factor); 13] = [
    ("rotor", Over::Speed, Factor::One),
    ("rotor", Over::Position, Factor::One),
    ("rotor", Over::Time, Factor::One),
    ("rotor", Over::Position, Factor::Direction),
    ("rotor", Over::Load, Factor::Direction),
    ("spring", Over::Deflection, Factor::One),
    ("spring", Over::DeflectionRate, Factor::One),
    ("spring", Over::Time, Factor::Deflection),
    ("output", Over::Speed, Factor::One),
    ("output", Over::Position, Factor::One),
    ("output", Over::Time, Factor::One),
    ("drive", Over::Command, Factor::One),
    ("drive", Over::Time, Factor::Command),
];

/// Sensors whose curve is known in their own unit.
const SENSORS: [&str; 3] = ["force_1_n", "force_2_n", "output_torque_nm"];

/// A curve with its place.
#[derive(Debug, Clone)]
pub(super) struct OnCurve {
    acts_on: String,
    curve: Curve,
}

impl OnCurve {
    /// Whether an actuator has a place for such a law.
    pub fn can(acts_on: &str, curve: &Curve) -> bool {
        match acts_on.strip_prefix("sensor/") {
            Some(channel) => {
                SENSORS.contains(&channel)
                    && curve.times == Factor::One
                    && matches!(curve.over, Over::Value | Over::Time)
            }
            None => KINDS.contains(&(acts_on, curve.over, curve.times)),
        }
    }

    /// # Errors
    ///
    /// [`ActuatorError::Value`] for a place that has no such law, and for points that are no curve.
    pub fn new(acts_on: &str, curve: Curve) -> Result<Self, ActuatorError> {
        let bad =
            |field: &str, value: String, admitted: &str| Err(ActuatorError::value(field, value, admitted));
        if !Self::can(acts_on, &curve) {
            let value = format!("{:?} times {:?} at '{acts_on}'", curve.over, curve.times).to_lowercase();
            return bad(
                "curve.over",
                value,
                "at the rotor speed, position or time, or position or load times direction; at the spring deflection or \
                 deflection-rate, or time times deflection; at the output speed, position or time; at the drive command, or \
                 time times command; at sensor/force_1_n, force_2_n or output_torque_nm value or time",
            );
        }
        if curve.x.len() != curve.y.len() || curve.x.len() < 2 {
            return bad("curve.y", format!("{} points", curve.y.len()), "as many as x has, at least two");
        }
        if !curve.x.iter().chain(&curve.y).all(|v| v.is_finite()) || !curve.x.is_sorted_by(|a, b| a < b) {
            return bad("curve.x", format!("{:?}", curve.x), "finite and ascending");
        }
        let has_dry = acts_on == "rotor" && curve.over == Over::Speed;
        if !(curve.dry == 0.0 || (has_dry && curve.dry > 0.0 && curve.dry.is_finite())) {
            return bad(
                "curve.dry",
                curve.dry.to_string(),
                "not negative, and beside a curve over the rotor's speed alone",
            );
        }
        Ok(Self { acts_on: acts_on.to_owned(), curve })
    }

    /// Where it acts, as a card says it.
    pub fn place(&self) -> &str {
        self.acts_on.split_once('/').map_or(&self.acts_on, |(place, _)| place)
    }

    /// Whether it needs an output that moves, and whether a spring.
    pub fn needs(&self) -> (bool, bool) {
        (self.acts_on == "output", self.acts_on == "spring" || self.acts_on == "sensor/force_1_n")
    }

    /// The law in words.
    pub fn equation(&self) -> String {
        let times = match self.curve.times {
            Factor::One => "",
            Factor::Direction => ", times -sign(y')",
            Factor::Deflection => ", times the deflection",
            Factor::Command => ", times the command",
        };
        let dry = if self.curve.dry > 0.0 { " - dry sign(y')" } else { "" };
        format!("a curve over {:?}{times}{dry}", self.curve.over).to_lowercase()
    }

    /// Each ordinate is a parameter, of many points their common size; then the dry friction.
    pub fn parameters(&self) -> Vec<Parameter> {
        let most = self.curve.y.iter().fold(0.0_f64, |a, v| a.max(v.abs())).max(f64::MIN_POSITIVE);
        let least = if self.curve.times == Factor::Direction { 0.0 } else { -FARTHEST * most };
        let ordinate = |(k, &y): (usize, &f64)| Parameter {
            neutral: Some(0.0),
            typical: 0.1 * most,
            ..Parameter::new(format!("y{}", k + 1), "", y.max(least), least, FARTHEST * most)
        };
        let mut all: Vec<Parameter> = if self.curve.y.len() <= Curve::MOST_FREE {
            self.curve.y.iter().enumerate().map(ordinate).collect()
        } else {
            let size = Parameter::new("size", "", 1.0, -FARTHEST, FARTHEST);
            vec![Parameter { neutral: Some(0.0), ..size }]
        };
        if self.curve.dry > 0.0 {
            let dry = Parameter::new("dry", "", self.curve.dry, 0.0, FARTHEST * self.curve.dry);
            all.push(Parameter { neutral: Some(0.0), ..dry });
        }
        all
    }

    pub fn install(&self, values: &[f64], plant: &mut Plant) {
        let points = self.curve.y.len();
        let y = if points <= Curve::MOST_FREE {
            values[..points].to_vec()
        } else {
            self.curve.y.iter().map(|y| y * values[0]).collect()
        };
        let law = Points { over: self.curve.over, x: self.curve.x.clone(), y };
        if self.curve.dry > 0.0 {
            let bound = values[values.len() - 1];
            plant.laws.rotor_friction.push(Box::new(Dry(Points::level(bound))));
        }
        match self.acts_on.as_str() {
            "rotor" if self.curve.times == Factor::Direction => {
                plant.laws.rotor_friction.push(Box::new(Dry(law)));
            }
            "rotor" => plant.laws.rotor_forces.push(Box::new(OnCoordinate { law, arm: 1.0 })),
            "spring" => plant.laws.spring_forces.push(Box::new(BesideSpring(law))),
            "output" => {
                let arm = match plant.rigid.unwrap_or(plant.link_2) {
                    Link::Pendulum { arm_m, .. } => arm_m,
                    _ => 1.0,
                };
                plant.output_forces.push(Box::new(OnCoordinate { law, arm }));
            }
            "drive" => {
                // A loop makes the force of a change of its goal.
                let gain = plant.servo.map_or(1.0, |servo| servo.proportional * servo.per_given());
                let per_command = 1.0 / (plant.force_per_command * gain);
                plant.laws.command_stages.push(Box::new(InDrive { law, per_command }));
            }
            sensor => {
                let channel = sensor.trim_start_matches("sensor/").to_owned();
                plant.laws.sensor_stages.push(Box::new(InSensor { channel, law }));
            }
        }
    }
}

/// What a file of the law keeps.
pub(super) fn definition(law: &Law) -> Result<toml::Table, ActuatorError> {
    let unwritten =
        |e: toml::ser::Error| ActuatorError::value("curve", law.id.clone(), format!("plain numbers: {e}"));
    toml::Table::try_from(law).map_err(unwritten)
}

#[derive(Debug, Clone)]
struct Points {
    over: Over,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Points {
    fn level(y: f64) -> Self {
        Self { over: Over::Time, x: vec![0.0], y: vec![y] }
    }

    #[inline]
    fn at(&self, x: f64) -> f64 {
        Curve::at(self.over, &self.x, &self.y, x)
    }
}

#[derive(Debug)]
struct Dry(Points);

impl DryFriction for Dry {
    fn bound(&self, slip: &Slip) -> f64 {
        let at = if self.0.over == Over::Load { slip.load.abs() } else { slip.position };
        self.0.at(at).max(0.0)
    }

    fn feels_speed(&self) -> bool {
        false
    }

    fn feels_load(&self) -> bool {
        self.0.over == Over::Load
    }
}

/// On the rotor, or on link 2 through a lever.
#[derive(Debug)]
struct OnCoordinate {
    law: Points,
    arm: f64,
}

impl RotorForce for OnCoordinate {
    fn force(&self, y: f64, y_dot: f64, _load: f64, t: f64) -> f64 {
        let at = match self.law.over {
            Over::Speed => y_dot / self.arm,
            Over::Position => y / self.arm,
            _ => t,
        };
        self.law.at(at) / self.arm
    }
}

#[derive(Debug)]
struct BesideSpring(Points);

impl SpringForce for BesideSpring {
    fn force(&self, delta: f64, delta_dot: f64, t: f64) -> f64 {
        match self.0.over {
            Over::Deflection => self.0.at(delta),
            Over::DeflectionRate => self.0.at(delta_dot),
            _ => self.0.at(t) * delta,
        }
    }
}

/// The curve is in motor force; the command is what makes it.
#[derive(Debug)]
struct InDrive {
    law: Points,
    per_command: f64,
}

impl CommandStage for InDrive {
    fn apply(&self, time_s: &mut [f64], values: &mut [f64]) {
        for (u, t) in values.iter_mut().zip(time_s.iter()) {
            *u += self.per_command
                * if self.law.over == Over::Command { self.law.at(*u) } else { self.law.at(*t) * *u };
        }
    }
}

#[derive(Debug)]
struct InSensor {
    channel: String,
    law: Points,
}

impl SensorStage for InSensor {
    fn concerns(&self, channel: &str) -> bool {
        channel == self.channel
    }

    fn apply(&self, values: &mut [f64], h: f64) {
        for (i, value) in values.iter_mut().enumerate() {
            *value += self.law.at(if self.law.over == Over::Value { *value } else { i as f64 * h });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(over: Over, times: Factor) -> Curve {
        Curve { over, times, x: vec![0.0, 1.0], y: vec![1.0, 3.0], dry: 0.0 }
    }

    #[test]
    fn each_place_applies_its_curve() {
        let installed = |acts_on: &str, over, times| {
            let mut plant = Plant::new(1.0, 0.0, 0.0, 100.0);
            let law = OnCurve::new(acts_on, curve(over, times)).expect("a place for it");
            let values: Vec<f64> = law.parameters().iter().map(|p| p.value).collect();
            law.install(&values, &mut plant);
            plant
        };
        let rotor = installed("rotor", Over::Speed, Factor::One);
        assert_eq!(rotor.laws.rotor_force(9.0, 0.5, 0.0, 0.0), 2.0);
        let dry = installed("rotor", Over::Load, Factor::Direction);
        assert_eq!(dry.laws.rotor_friction_bound(&Slip { load: -0.5, ..Slip::default() }), 2.0);
        let spring = installed("spring", Over::Time, Factor::Deflection);
        assert_eq!(spring.spring_force(0.1, 0.0, 0.5), 10.0 + 0.2);
        let sensor = installed("sensor/force_1_n", Over::Value, Factor::One);
        let mut shown = vec![0.5, 4.0];
        sensor.laws.sensor_stages[0].apply(&mut shown, 1e-3);
        assert_eq!(shown, [2.5, 13.0]);
        let drive = installed("drive", Over::Time, Factor::Command);
        let mut commands = vec![2.0, 2.0];
        drive.laws.command_stages[0].apply(&mut [0.0, 1.0], &mut commands);
        assert_eq!(commands, [4.0, 8.0]);
    }

    #[test]
    fn what_no_place_can_carry_is_refused() {
        assert!(OnCurve::new("rotor", curve(Over::Command, Factor::One)).is_err());
        assert!(OnCurve::new("sensor/motor_angle_rad", curve(Over::Value, Factor::One)).is_err());
        let back = Curve { x: vec![1.0, 0.0], ..curve(Over::Speed, Factor::One) };
        assert!(OnCurve::new("rotor", back).is_err());
    }
}
