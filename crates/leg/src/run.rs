//! Running a scenario from beginning to end: for an observer, for a summary, for channels.

use crate::LegError;
use crate::channel::{self, Channel, Instant};
use crate::robot::{JointKind, Robot};
use crate::scenario::Scenario;
use crate::simulation::{
    EnergyBalance, Event, EventKind, LegDescription, Observer, Peaks, Sample, Simulation,
};
use sealegs_model::Signal;
use serde::Serialize;

/// What came of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunResult {
    /// The scenario's name.
    pub scenario: String,
    /// Integration step, s.
    pub step_s: f64,
    /// Time reached, s.
    pub time_s: f64,
    /// Greatest values, looked for at every step.
    pub peaks: Peaks,
    /// What happened, in the order of time.
    pub events: Vec<Event>,
    /// Where the joints are at the end, in the order of their degrees of freedom.
    pub joints: Vec<JointEnd>,
    /// What was mended, left out or is not supported in the robot's files, one sentence each.
    pub remarks: Vec<String>,
    /// Energy at the end.
    pub energy: EnergyBalance,
    /// The greatest magnitude of the energy balance's residual as a ratio of the energy in motion.
    pub worst_energy_residual: f64,
    /// Why the run stopped before its end; what was recorded until then stands.
    pub stopped: Option<String>,
}

/// What came of a run, and every channel of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Peaks, events and the energy balance.
    pub result: RunResult,
    /// The channels, one value for each of the scenario's sample periods.
    pub channels: Channels,
}

impl Scenario {
    /// Runs the scenario to its end, and keeps its channels.
    ///
    /// ```
    /// use sealegs_leg::scenario::Scenario;
    ///
    /// let drop = Scenario::load("thor-drop", &["duration_s=0.1".to_owned()])?;
    /// let recorded = drop.run()?;
    /// let height_m = recorded.channels.get("base.height_m").expect("a leg has a base");
    /// assert!(height_m.last() < height_m.first());
    /// # Ok::<(), sealegs_leg::LegError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`run`].
    pub fn run(&self) -> Result<Recorded, LegError> {
        let mut channels = Channels::default();
        let result = run(self, &mut channels)?;
        Ok(Recorded { result, channels })
    }
}

/// A joint at the end of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointEnd {
    /// Its name.
    pub name: String,
    /// Whether it slides: then metres stand for radians.
    pub slides: bool,
    /// Position, rad or m.
    pub position: f64,
    /// Speed, rad/s or m/s.
    pub speed: f64,
}

/// Runs a scenario to its end.
///
/// A state that is no longer finite ends the run early: the result then says so in `stopped`, and the
/// observer keeps what it has seen.
///
/// # Errors
///
/// What is wrong with the scenario or its robot, or what the observer reports.
pub fn run(scenario: &Scenario, observer: &mut dyn Observer) -> Result<RunResult, LegError> {
    run_simulation(scenario, Simulation::new(scenario)?, observer)
}

/// As [`run`], for a robot that was loaded or made elsewhere.
///
/// # Errors
///
/// As [`run`].
pub fn run_robot(
    scenario: &Scenario,
    robot: Robot,
    observer: &mut dyn Observer,
) -> Result<RunResult, LegError> {
    run_simulation(scenario, Simulation::with_robot(scenario, robot)?, observer)
}

/// As [`run`], for a simulation that has been prepared (effects put in).
///
/// # Errors
///
/// As [`run`].
pub fn run_simulation(
    scenario: &Scenario,
    mut simulation: Simulation,
    observer: &mut dyn Observer,
) -> Result<RunResult, LegError> {
    let steps = (scenario.duration_s / scenario.step_s - 1e-6).ceil().max(1.0) as usize;
    let every = (scenario.sample_period_s / scenario.step_s).round().max(1.0) as usize;
    observer.start(simulation.leg())?;
    let mut events: Vec<Event> = Vec::new();
    let mut worst: f64 = 0.0;
    let mut stopped = None;
    let mut time_s = 0.0;
    for step in 0..=steps {
        let sample = step % every == 0 || step == steps;
        time_s = simulation.time_s();
        if let Err(error) = simulation.advance(sample) {
            let event =
                Event { time_s, kind: EventKind::NotFinite, subject: String::new(), text: error.to_string() };
            observer.event(&event)?;
            events.push(event);
            stopped = Some(error.to_string());
            break;
        }
        for event in simulation.events() {
            observer.event(event)?;
            events.push(event.clone());
        }
        if sample {
            let sample = simulation.sample();
            worst = worst.max(sample.energy.relative().abs());
            observer.sample(sample)?;
        }
    }
    let (robot, last) = (&simulation.leg().robot, simulation.sample());
    let ends = last.joint_angles_rad.iter().zip(&last.joint_speeds_rad_s);
    let joints = (robot.moving_joints().zip(ends))
        .map(|(joint, (position, speed))| JointEnd {
            name: joint.name.clone(),
            slides: joint.kind == JointKind::Prismatic,
            position: *position,
            speed: *speed,
        })
        .collect();
    Ok(RunResult {
        scenario: scenario.name.clone(),
        joints,
        remarks: robot.warnings.clone(),
        step_s: scenario.step_s,
        time_s,
        peaks: simulation.peaks().clone(),
        events,
        energy: simulation.sample().energy,
        worst_energy_residual: worst,
        stopped,
    })
}

/// The channels of a run, sampled: `<joint>.angle_rad`, `<actuator>.force_1_n`, `.force_2_n`,
/// `.current_a`, `.rotor_angle_rad`, `base.height_m`, `foot.normal_force_n`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Channels {
    /// Time stamps, s.
    pub time_s: Vec<f64>,
    /// The channels.
    pub signals: Vec<Signal>,
    /// What each signal is.
    of: Vec<Channel>,
}

impl Channels {
    /// The values of a channel.
    #[must_use]
    pub fn get(&self, channel: &str) -> Option<&[f64]> {
        self.signals.iter().find(|s| s.channel == channel).map(|s| s.values.as_slice())
    }
}

impl Observer for Channels {
    fn start(&mut self, leg: &LegDescription) -> Result<(), LegError> {
        let actuators: Vec<String> = leg.actuators.iter().map(|a| a.name.clone()).collect();
        let all = channel::all(&leg.joints, &actuators);
        (self.signals, self.of) =
            all.into_iter().map(|(channel, of)| (Signal { channel, values: Vec::new() }, of)).unzip();
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LegError> {
        self.time_s.push(sample.time_s);
        let instant = Instant {
            joint_angles_rad: &sample.joint_angles_rad,
            actuators: &sample.actuators,
            base_height_m: sample.world_from_link[0].translation.z,
            normal_force_n: sample.ground.normal_force_n,
        };
        for (signal, of) in self.signals.iter_mut().zip(&self.of) {
            signal.values.push(of.at(&instant));
        }
        Ok(())
    }
}

/// Runs a scenario and returns its channels, for a campaign or a comparison. Parameters of actuators are
/// changed through [`Scenario::actuator`].
///
/// # Errors
///
/// As [`run`], and [`LegError::NotFinite`] if the run does not reach its end.
pub fn channels(scenario: &Scenario, robot: Robot) -> Result<(Channels, RunResult), LegError> {
    let mut channels = Channels::default();
    let result = run_robot(scenario, robot, &mut channels)?;
    match &result.stopped {
        Some(what) => Err(LegError::NotFinite { time_s: result.time_s, what: what.clone() }),
        None => Ok((channels, result)),
    }
}
