//! What a run tells its observer: the description of the leg, samples, events.

use crate::LegError;
use crate::dynamics::contact::{Ground, GroundInstant};
use crate::dynamics::coupling::ActuatorInstant;
use crate::robot::{LengthRange, Robot};
use nalgebra::Isometry3;
use sealegs_actuator::Coefficients;
use sealegs_actuator::spring::SpringLimits;
use serde::Serialize;

/// An actuator as the run has it.
#[derive(Debug, Clone, PartialEq)]
pub struct ActuatorModel {
    /// Its name in the placement file.
    pub name: String,
    /// The actuator file's id.
    pub id: String,
    /// The spring's setting in words.
    pub spring_setting: String,
    /// The numbers of its equations of motion.
    pub coefficients: Coefficients,
    /// The same as its file and its spring's setting state them: what a controller knows of it.
    pub nominal: Coefficients,
    /// What its spring can bear.
    pub limits: SpringLimits,
    /// Screw travel per rotor angle `r`, m/rad.
    pub travel_per_rad: f64,
    /// Greatest current, A; infinite where nothing limits it.
    pub current_limit_a: f64,
    /// Lengths that the stroke allows, m.
    pub length: LengthRange,
}

/// What a run is about, before it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct LegDescription {
    /// The scenario's name.
    pub scenario: String,
    /// The robot, as the run has it.
    pub robot: Robot,
    /// Names of the moving joints in the order of their degree of freedom.
    pub joints: Vec<String>,
    /// The actuators with springs, in the order of the samples.
    pub actuators: Vec<ActuatorModel>,
    /// Names of the rigid position drives.
    pub drives: Vec<String>,
    /// The ground, if there is one.
    pub ground: Option<Ground>,
    /// Time between samples, s.
    pub sample_period_s: f64,
    /// Duration of the run, s.
    pub duration_s: f64,
}

/// One instant of a run. Everything belongs to the same time, velocities included.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sample {
    /// Time, s.
    pub time_s: f64,
    /// Joint positions, rad.
    pub joint_angles_rad: Vec<f64>,
    /// Joint speeds, rad/s.
    pub joint_speeds_rad_s: Vec<f64>,
    /// `world_from_link` by link index.
    pub world_from_link: Vec<Isometry3<f64>>,
    /// The actuators.
    pub actuators: Vec<ActuatorInstant>,
    /// Bending stress of each actuator's beam, Pa.
    pub stresses_pa: Vec<f64>,
    /// Torques of the rigid position drives, N m.
    pub drive_torques_nm: Vec<f64>,
    /// What the ground does.
    pub ground: GroundInstant,
    /// Energy and work since the start.
    pub energy: EnergyBalance,
}

/// Where energy is and what has brought or taken it, J. Works are integrals by the mean of both ends of each
/// step; positive brings energy into the leg.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct EnergyBalance {
    /// Kinetic energy of links, rotors and sprung masses.
    pub kinetic_j: f64,
    /// Potential energy against gravity.
    pub potential_j: f64,
    /// In the linear springs.
    pub spring_j: f64,
    /// Work of the motors.
    pub motor_work_j: f64,
    /// Work of rotor damping and friction.
    pub rotor_loss_j: f64,
    /// Work of what acts beside the linear springs.
    pub spring_loss_j: f64,
    /// Work of the ground; while it is compressed a part of it will come back.
    pub ground_work_j: f64,
    /// Work of joint stops, joint damping and joint friction.
    pub joint_work_j: f64,
    /// Work of the rigid position drives.
    pub drive_work_j: f64,
    /// Work of gravity on the sprung masses' motion relative to their attachment, and of the turning axis,
    /// which the placement of the sprung mass neglects (of the lumped model: of its missing reaction).
    pub sprung_mass_work_j: f64,
    /// Energy at the start.
    pub initial_j: f64,
    /// What does not add up: energy now minus energy at the start minus all works.
    pub residual_j: f64,
    /// The greatest energy in motion so far (kinetic, springs, and height lost), to which the residual
    /// compares; at least the work of all weight over a micrometre.
    pub turnover_j: f64,
}

impl EnergyBalance {
    /// The residual as a ratio of the energy in motion.
    #[must_use]
    pub fn relative(&self) -> f64 {
        if self.turnover_j > 0.0 { self.residual_j / self.turnover_j } else { 0.0 }
    }

    /// All works, J.
    #[must_use]
    pub fn work_j(&self) -> f64 {
        self.motor_work_j
            + self.rotor_loss_j
            + self.spring_loss_j
            + self.ground_work_j
            + self.joint_work_j
            + self.drive_work_j
            + self.sprung_mass_work_j
    }
}

/// How much an event matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EventLevel {
    /// Good to know.
    Info,
    /// A limit that machines have to live with.
    Warning,
    /// Beyond what is allowed or known.
    Error,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EventKind {
    /// The foot touches the ground.
    TouchDown,
    /// The foot leaves the ground.
    LiftOff,
    /// A current is at its limit.
    Saturation,
    /// A joint is past its limit.
    JointStop,
    /// An actuator is shorter or longer than its stroke allows.
    Stroke,
    /// A force is past the rated one.
    RatedForce,
    /// A beam is past yield.
    Yield,
    /// A beam is set outside the range that its law was measured in.
    BeamRange,
    /// The run could not go on.
    NotFinite,
}

/// Something that happened, with its time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Event {
    /// When, s.
    pub time_s: f64,
    /// What.
    pub kind: EventKind,
    /// Of which joint or actuator; empty for the foot.
    pub subject: String,
    /// In words, with numbers.
    pub text: String,
}

impl Event {
    /// How much it matters.
    #[must_use]
    pub fn level(&self) -> EventLevel {
        match self.kind {
            EventKind::TouchDown | EventKind::LiftOff => EventLevel::Info,
            EventKind::Saturation | EventKind::JointStop => EventLevel::Warning,
            _ => EventLevel::Error,
        }
    }
}

/// Whoever watches a run: a recorder, a table, a test.
pub trait Observer {
    /// Before the first sample.
    ///
    /// # Errors
    ///
    /// Whatever keeps it from going on; the run then ends with that error.
    fn start(&mut self, leg: &LegDescription) -> Result<(), LegError> {
        let _ = leg;
        Ok(())
    }

    /// At every sample period.
    ///
    /// # Errors
    ///
    /// As [`Observer::start`].
    fn sample(&mut self, sample: &Sample) -> Result<(), LegError>;

    /// When something happens, in the order of time; before the next sample.
    ///
    /// # Errors
    ///
    /// As [`Observer::start`].
    fn event(&mut self, event: &Event) -> Result<(), LegError> {
        let _ = event;
        Ok(())
    }
}

/// Watches nothing.
impl Observer for () {
    fn sample(&mut self, _: &Sample) -> Result<(), LegError> {
        Ok(())
    }
}
