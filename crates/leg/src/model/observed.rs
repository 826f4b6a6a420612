//! A leg under an observer: the links move as they were measured, the rotors are pulled to what their encoders showed.
//!
//! Along a known motion of the links the actuators do not feel one another, so that each is integrated by itself, and a
//! simulation costs a small part of the leg's. What acts beyond the actuators (joints, contact, masses) changes nothing
//! here. Channels that are followed, or cannot be told, are predicted as they were measured.
//!
//! A joint's encoder is mounted with an error, which a spring of 400 kN/m at an arm of 0.1 m turns into 40 N for each
//! milliradian: the encoders' zeros are parameters of a leg under an observer.

use super::Case;
use super::predict::{self, Asked};
use crate::dynamics::coupling::{KnownLinks, KnownPath};
use crate::effect::Placed;
use crate::scenario::Scenario;
use crate::simulation::Simulation;
use sealegs_actuator::plant::{
    Grid, Pull, ReferenceMotion, mean_per_step, observer_rate, pull_at, sample, smoothed,
};
use sealegs_model::{ModelError, Parameter, Prediction, Record, Signal, internal};
use std::sync::{Arc, Mutex, PoisonError};

/// Half the window over which an acceleration is taken, s: that of an encoder with 0.4 mrad counts at 1 kHz is then known
/// to some 5 rad/s^2, which moves a sprung mass' force by the noise of a load cell.
const ACCELERATION_WINDOW_S: f64 = 6e-3;

/// One standard deviation of what is known of the zero of a joint's encoder, and the most that it is taken to be off, rad:
/// it is mounted by hand.
const ZERO_STD_RAD: f64 = 0.02;
/// See [`ZERO_STD_RAD`].
const GREATEST_ZERO_RAD: f64 = 0.1;

/// By how much a joint is turned to see what its zero does to the paths, rad.
const TURNED_RAD: f64 = 1e-3;

/// The parameters that a leg has under an observer alone: the zero of each joint's encoder, rad, measured less true.
pub(super) fn zeros(case: &Case) -> Vec<Parameter> {
    let zero = |joint: &str| Parameter {
        prior_std: Some(ZERO_STD_RAD),
        ..Parameter::new(format!("{joint}/encoder_zero"), "rad", 0.0, -GREATEST_ZERO_RAD, GREATEST_ZERO_RAD)
    };
    case.robot.moving_joints().map(|joint| zero(&joint.name)).collect()
}

/// What records measured, for the observers of their simulations.
#[derive(Debug)]
pub(super) struct Observed {
    /// The records that are followed.
    records: Vec<Record>,
    /// Known motions by record and grid: every simulation asks for them again.
    known: Mutex<Vec<OnGrid>>,
}

/// A record's name, the bits of the step and the steps of its grid, and the motion on it.
type OnGrid = ((String, u64, usize), Arc<Known>);

/// The motion of a record on a grid.
#[derive(Debug)]
struct Known {
    actuators: Vec<Followed>,
}

/// An actuator of which current and rotor were measured.
#[derive(Debug)]
struct Followed {
    /// Its index.
    index: usize,
    path: Arc<KnownPath>,
    /// Change of the path's length with each joint at each point of the grid and one beyond, m/rad.
    arms: Vec<Vec<f64>>,
    /// Rotor angle on the grid, rad.
    rotor: Arc<ReferenceMotion>,
    /// The same at the record's time stamps.
    rotor_at_samples: ReferenceMotion,
    /// Smoothed load cell on link 1 at the record's time stamps, N.
    force_1: Option<Vec<f64>>,
}

impl Observed {
    /// What can be followed of some records; `None` unless each of them measured all joints, the base where it moves, and
    /// the current and the rotor of an actuator.
    pub fn of(cases: &[Case], records: &[&Record]) -> Option<Self> {
        let follows = |record: &&Record| {
            let case = cases.iter().find(|c| c.record.as_deref() == Some(&record.name)).unwrap_or(&cases[0]);
            let mut joints = case.robot.moving_joints();
            let rail = matches!(case.scenario.base, crate::scenario::BaseSpec::Rail { .. });
            joints.all(|j| record.output(&format!("{}.angle_rad", j.name)).is_some())
                && (!rail || record.output("base.height_m").is_some())
                && case.robot.actuators.iter().any(|a| measured(record, &a.name).is_some())
        };
        records.iter().all(follows).then(|| Self {
            records: records.iter().map(|r| (*r).clone()).collect(),
            known: Mutex::default(),
        })
    }

    /// Whether a record is followed.
    pub fn follows(&self, record: &Record) -> bool {
        self.records.iter().any(|r| r.name == record.name)
    }

    /// What the actuators do along the measured motion, the joints' encoders having these zeros.
    pub fn predict(
        &self,
        case: &Case,
        scenario: &Scenario,
        (effects, zeros_rad): (&[Placed], &[f64]),
        record: &Record,
        asked: Asked,
    ) -> Result<Prediction, ModelError> {
        // What is followed is the record that was given then, not one that is compared now.
        let record = self.records.iter().find(|r| r.name == record.name).unwrap_or(record);
        let mut simulation = case.simulation(scenario, effects).map_err(predict::model_error)?;
        let grid = predict::grid(record, scenario.step_s)?;
        let known = self.known(case, scenario, record, &grid)?;
        let steps = (grid.steps * known.actuators.len()) as u64;
        let mut prediction = Prediction { steps, ..Prediction::default() };
        let mut told: Vec<(String, Vec<f64>)> = Vec::new();
        for followed in &known.actuators {
            let inside = asked.inside.then_some(&mut prediction.internals);
            told.extend(follow(&mut simulation, followed, zeros_rad, record, &grid, inside)?);
        }
        for channel in asked.channels {
            let values = match told.iter().find(|(name, _)| name == channel) {
                Some((_, values)) => values.clone(),
                None => record
                    .output(channel)
                    .ok_or_else(|| ModelError::UnknownChannel { channel: channel.clone() })?
                    .to_vec(),
            };
            prediction.outputs.push(Signal { channel: channel.clone(), values });
        }
        Ok(prediction)
    }

    /// The motion of a record on a grid, from the cache where it is there.
    fn known(
        &self,
        case: &Case,
        scenario: &Scenario,
        record: &Record,
        grid: &Grid,
    ) -> Result<Arc<Known>, ModelError> {
        let key = (record.name.clone(), grid.step_s.to_bits(), grid.steps);
        // A thread that panicked while it held the lock leaves whole entries behind.
        let lock = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = lock().iter().find(|(k, _)| *k == key) {
            return Ok(known.clone());
        }
        let known = Arc::new(Known::of(case, scenario, record, grid)?);
        lock().push((key, known.clone()));
        Ok(known)
    }
}

/// Current and rotor angle of an actuator, where both were measured.
fn measured<'a>(record: &'a Record, actuator: &str) -> Option<(&'a [f64], &'a [f64])> {
    let name = format!("{actuator}.current_a");
    let current = record.input(&name).or_else(|| record.output(&name))?;
    Some((current, record.output(&format!("{actuator}.rotor_angle_rad"))?))
}

impl Known {
    fn of(case: &Case, scenario: &Scenario, record: &Record, grid: &Grid) -> Result<Self, ModelError> {
        let mut simulation = case.simulation(scenario, &[]).map_err(predict::model_error)?;
        let beyond = Grid { steps: grid.steps + 1, ..*grid };
        let on_grid = |channel: &str| -> ReferenceMotion {
            let values = record.output(channel).unwrap_or(&[]);
            smoothed(&record.time_s, values).curved(&beyond, &record.time_s)
        };
        let joints: Vec<ReferenceMotion> =
            case.robot.moving_joints().map(|j| on_grid(&format!("{}.angle_rad", j.name))).collect();
        let base = simulation.is_on_rail().then(|| on_grid("base.height_m"));
        let height = simulation.base_height_m();
        let followed: Vec<usize> = simulation
            .leg()
            .actuators
            .iter()
            .enumerate()
            .filter_map(|(i, a)| measured(record, &a.name).map(|_| i))
            .collect();
        let count = simulation.leg().actuators.len();
        let mut paths = vec![KnownPath::default(); count];
        let mut arms = vec![vec![Vec::with_capacity(beyond.steps + 1); joints.len()]; count];
        for n in 0..=beyond.steps {
            let q: Vec<f64> = joints.iter().map(|j| j.position[n]).collect();
            let speed: Vec<f64> = joints.iter().map(|j| j.speed[n]).collect();
            let rail = base.as_ref().map_or((0.0, 0.0), |b| (b.position[n] - height, b.speed[n]));
            let reaches = simulation.reaches_at((&q, rail.0), (&speed, rail.1));
            let mut turned = q.clone();
            for j in 0..q.len() {
                turned[j] = q[j] + TURNED_RAD;
                let there = simulation.reaches_at((&turned, rail.0), (&speed, rail.1));
                turned[j] = q[j];
                for (arms, (here, there)) in arms.iter_mut().zip(reaches.iter().zip(there)) {
                    arms[j].push((there.0.length_m - here.0.length_m) / TURNED_RAD);
                }
            }
            for (path, (reach, joint_speed, attachment)) in paths.iter_mut().zip(reaches) {
                path.reaches.push(reach);
                path.joint_speeds.push(joint_speed);
                path.attachments.push(attachment);
            }
        }
        let half = (ACCELERATION_WINDOW_S / grid.step_s).round() as usize;
        paths.iter_mut().for_each(|path| path.find_accelerations(half, grid.step_s));
        let actuators = followed
            .into_iter()
            .filter_map(|index| {
                let name = &simulation.leg().actuators[index].name;
                let (_, angle) = measured(record, name)?;
                let at_samples = smoothed(&record.time_s, angle);
                let force_1 = record.output(&format!("{name}.force_1_n"));
                Some(Followed {
                    index,
                    path: Arc::new(std::mem::take(&mut paths[index])),
                    arms: std::mem::take(&mut arms[index]),
                    rotor: Arc::new(at_samples.on(grid, &record.time_s)),
                    rotor_at_samples: at_samples,
                    force_1: force_1.map(|f| smoothed(&record.time_s, f).position),
                })
            })
            .collect();
        Ok(Self { actuators })
    }
}

impl Followed {
    /// How much longer the path is at each point than it was measured with encoders of these zeros (rad), m.
    fn longer(&self, zeros_rad: &[f64]) -> Vec<f64> {
        let mut longer = vec![0.0; self.path.reaches.len()];
        for (arm, zero) in self.arms.iter().zip(zeros_rad).filter(|(_, zero)| **zero != 0.0) {
            longer.iter_mut().zip(arm).for_each(|(longer, arm)| *longer -= arm * zero);
        }
        longer
    }
}

/// Integrates one actuator along its known path: its channels by name, and its internal signals where they are asked for.
fn follow(
    simulation: &mut Simulation,
    followed: &Followed,
    zeros_rad: &[f64],
    record: &Record,
    grid: &Grid,
    internals: Option<&mut Vec<Signal>>,
) -> Result<Vec<(String, Vec<f64>)>, ModelError> {
    let i = followed.index;
    let (name, nominal, travel) = {
        let of = &simulation.leg().actuators[i];
        (of.name.clone(), of.nominal, of.travel_per_rad)
    };
    let (current, _) = measured(record, &name).unwrap_or_default();
    let stages = simulation.laws(i).map_or(&[][..], |laws| &laws.command_stages);
    let around = Grid { start_s: grid.start_s - 0.5 * grid.step_s, ..*grid };
    let currents = mean_per_step(&record.time_s, current, record.hold, stages, &around);
    // Gains follow from nominal values: they must not change while a fit moves the parameters.
    let mass = nominal.total_mass();
    let rate = observer_rate(nominal.stiffness, mass, grid.step_s, record.mean_period_s());
    let pull = Pull::on(followed.rotor.clone(), travel, mass, rate);
    let mut links =
        KnownLinks { path: followed.path.clone(), point: 0, longer_m: followed.longer(zeros_rad) };
    let points = grid.steps + 1;
    let room = || Vec::with_capacity(points);
    let mut forces = [room(), room(), room()];
    let mut inside = internals.map(|internals| (internals, predict::INTERNALS.map(|_| room()), room()));
    let coefficients = {
        let (actuators, gravity) = simulation.actuators_mut();
        let actuator = &mut actuators[i];
        actuator.follow(&links, Some(pull));
        for n in 0..points {
            // Beyond the last step the command of that step goes on.
            let current = currents[n.min(currents.len() - 1)];
            links.point = n;
            actuator.apply(&mut links, current, &gravity, grid.time(n), grid.step_s);
            links.point = n + 1;
            let (instant, _) = actuator.complete(&links, current, &gravity, grid.step_s, travel);
            if !instant.force_1_n.is_finite() {
                return Err(ModelError::NotFinite {
                    time_s: grid.time(n),
                    what: format!("actuator '{name}'"),
                });
            }
            let now = [instant.force_1_n, instant.force_2_n, instant.rotor_angle_rad];
            for (values, value) in forces.iter_mut().zip(now) {
                values.push(value);
            }
            if let Some((_, inside, pulled)) = &mut inside {
                for (values, value) in inside.iter_mut().zip(predict::internals(&instant, travel)) {
                    values.push(value);
                }
                pulled.push(actuator.pulled_n());
            }
        }
        actuator.coefficients
    };
    let at = |values: &[f64]| sample(values, grid, &record.time_s, 0.0);
    if let Some((internals, inside, pulled)) = inside {
        let missing = missing(
            followed,
            (&forces, &inside[1], &pulled),
            (coefficients.stiffness, coefficients.damping, travel),
            grid,
            record,
        );
        for (port, values) in missing {
            internals.push(Signal { channel: format!("{name}.{}{port}", internal::MISSING), values });
        }
        for (what, values) in predict::INTERNALS.iter().zip(&inside) {
            internals.push(Signal { channel: format!("{name}.{what}"), values: at(values) });
        }
    }
    let endings = ["force_1_n", "force_2_n", "rotor_angle_rad"];
    // Between the cells is the sprung mass: its acceleration out of an encoder's counts is worth less than what link 1 felt.
    let told = |ending: &str| ending != "force_2_n" || followed.force_1.is_none();
    Ok(endings
        .into_iter()
        .zip(forces)
        .filter(|(ending, _)| told(ending))
        .map(|(ending, mut values)| {
            for stage in simulation.sensor_stages(&name).iter().filter(|s| s.concerns(ending)) {
                stage.apply(&mut values, grid.step_s);
            }
            (format!("{name}.{ending}"), at(&values))
        })
        .collect())
}

/// What is missing at the rotor and at the spring, at the record's time stamps, N (see the bench's observer): the pull and
/// what spring and damper do not feel of it as the rotor lags behind its reference; and the measured force beyond the
/// modelled spring's at the measured deflection.
fn missing(
    followed: &Followed,
    (channels, speed, pulled): (&[Vec<f64>; 3], &[f64], &[f64]),
    (stiffness, damping, travel): (f64, f64, f64),
    grid: &Grid,
    record: &Record,
) -> Vec<(&'static str, Vec<f64>)> {
    let at = |values: &[f64]| sample(values, grid, &record.time_s, 0.0);
    let (force_1, angle, speed) = (at(&channels[0]), at(&channels[2]), at(speed));
    let pull = pull_at(pulled, grid, &record.time_s);
    let reference = &followed.rotor_at_samples;
    let lag = |i: usize| stiffness * travel * (reference.position[i] - angle[i]);
    let beyond = |i: usize| followed.force_1.as_ref().map_or_else(|| lag(i), |f| f[i] - force_1[i]);
    let damped = |i: usize| damping * (travel * reference.speed[i] - speed[i]);
    let rows = 0..record.time_s.len();
    let mut ports = vec![("rotor", rows.clone().map(|i| pull[i] + damped(i) + beyond(i)).collect())];
    if followed.force_1.is_some() {
        ports.push(("spring", rows.map(|i| beyond(i) - lag(i)).collect()));
    }
    ports
}
