//! A leg in motion: one step after the other, everything at an instant belonging to the same time.
//!
//! A step finds all forces at the poses of time `t_n`, lets the engine and the rotors advance to `t_n + dt`,
//! and only then completes what is known of `t_n`: load cells need the accelerations, and velocities at
//! `t_n` are the mean of those half a step before and after (see the engine's leapfrog).

mod bodies;
mod ledger;
mod sample;
mod setup;
mod watch;

pub use sample::{
    ActuatorModel, EnergyBalance, Event, EventKind, EventLevel, LegDescription, Observer, Sample,
};
pub(crate) use setup::{actuator_coefficients, actuator_spec, load_robot};
pub use watch::{ActuatorPeaks, Peak, Peaks};

use crate::LegError;
use crate::channel::Instant;
use crate::controller::{Controller, moment_arms, share_out};
use crate::dynamics::command::CommandLine;
use crate::dynamics::contact::{Contact, GroundInstant};
use crate::dynamics::coupling::{
    Actuator, ActuatorInstant, ActuatorPower, ActuatorStart, Reach, gravity_vector,
};
use crate::dynamics::drive::Servo;
use crate::dynamics::engine::Engine;
pub(crate) use crate::dynamics::engine::Mechanics;
use crate::dynamics::stop::{StopLaw, Stops};
use crate::dynamics::tree::Tree;
use crate::effect::{self, Build, LegSetting, Placed};
use crate::robot::Robot;
use crate::scenario::{Scenario, SpringStart};
use nalgebra::{DVector, Point3, Vector3};
use sealegs_actuator::plant::{Laws, SensorStage};
use sealegs_model::Excitation;
use setup::Parts;
use watch::Watch;

/// A speed that no leg has, rad/s: a state beyond it has run away even where it is still a number.
const RUNAWAY_RAD_S: f64 = 1e4;

/// A leg that can be stepped.
pub struct Simulation {
    leg: LegDescription,
    tree: Tree,
    engine: Engine,
    actuators: Vec<Actuator>,
    servos: Vec<Servo>,
    stops: Stops,
    contact: Option<Contact>,
    controller: Controller,
    commands: Vec<CommandLine>,
    /// Effects in front of or inside the sensors, by place.
    sensor_stages: Vec<(String, Vec<Box<dyn SensorStage>>)>,
    gravity: Vector3<f64>,
    step_s: f64,
    /// Steps completed.
    steps: usize,
    instants: Vec<ActuatorInstant>,
    powers: Vec<ActuatorPower>,
    ground: GroundInstant,
    energy: EnergyBalance,
    /// Power of each work at the instant before, W.
    power_before: [f64; 7],
    initial_potential_j: f64,
    sample: Sample,
    watch: Watch,
    events: Vec<Event>,
}

impl Simulation {
    /// Builds the scenario's robot and starts it.
    ///
    /// # Errors
    ///
    /// Whatever is wrong with the robot or the scenario's names and numbers.
    pub fn new(scenario: &Scenario) -> Result<Self, LegError> {
        Self::with_robot(scenario, load_robot(scenario)?)
    }

    /// Starts a robot that was loaded or made elsewhere in the scenario; its `robot` key is not looked at. Effects are
    /// those that the scenario names and those of the actuators' files.
    ///
    /// # Errors
    ///
    /// As [`Simulation::new`].
    pub fn with_robot(scenario: &Scenario, robot: Robot) -> Result<Self, LegError> {
        let seen = Excitation::default();
        let scenario = effect::with_effects_of_actuators(scenario, &robot)?;
        let effects = effect::of_scenario(&LegSetting { scenario: &scenario, robot: &robot, seen: &seen })?;
        Self::with_effects(&scenario, robot, &effects, Mechanics::Rapier)
    }

    /// As [`Simulation::with_robot`], with these effects in place of those that the scenario names.
    pub(crate) fn with_effects(
        scenario: &Scenario,
        robot: Robot,
        effects: &[Placed],
        mechanics: Mechanics,
    ) -> Result<Self, LegError> {
        let mut build = Build { scenario: scenario.clone(), robot, stops: Vec::new() };
        let before = (!effects.is_empty()).then(|| build.robot.clone());
        effects.iter().for_each(|e| e.install(&mut build));
        let Build { scenario, robot, stops } = build;
        // A controller knows the links as their file has them.
        let known = before.filter(|known| known.links != robot.links);
        let scenario = &scenario;
        let Parts { leg, tree, engine, mut actuators, servos, contact, known_bodies, start_q, start_speed } =
            Parts::new(scenario, robot, known, mechanics)?;
        let mut sensor_stages = Vec::new();
        for (actuator, model) in actuators.iter_mut().zip(&leg.actuators) {
            let mut made =
                effect::at_place(effects, &model.name, Some((&model.coefficients, model.travel_per_rad)));
            sensor_stages.push((model.name.clone(), std::mem::take(&mut made.laws.sensor_stages)));
            actuator.set_series(made.series);
            actuator.laws = made.laws;
        }
        for placed in effects {
            if !sensor_stages.iter().any(|(place, _)| *place == placed.place) {
                let made = effect::at_place(effects, &placed.place, None);
                sensor_stages.push((placed.place.clone(), made.laws.sensor_stages));
            }
        }
        let controller = Controller::new(scenario, &leg, &start_q, known_bodies)?;
        let stops =
            Stops::new(StopLaw::from(scenario.stops), &stops, &leg.robot, &tree, &engine, scenario.step_s);
        let count = actuators.len();
        let mut simulation = Self {
            watch: Watch::new(&leg),
            gravity: gravity_vector(scenario.gravity_m_s2),
            step_s: scenario.step_s,
            leg,
            tree,
            engine,
            actuators,
            servos,
            stops,
            contact,
            controller,
            commands: (0..count).map(|_| CommandLine::default()).collect(),
            sensor_stages,
            steps: 0,
            instants: vec![ActuatorInstant::default(); count],
            powers: vec![ActuatorPower::default(); count],
            ground: GroundInstant::default(),
            energy: EnergyBalance::default(),
            power_before: [0.0; 7],
            initial_potential_j: 0.0,
            sample: Sample::default(),
            events: Vec::new(),
        };
        simulation.start(&start_q, &start_speed, scenario.start.springs);
        Ok(simulation)
    }

    /// Finds the accelerations at the start by trial steps, and from them the velocities half a step
    /// before it, where the leapfrog begins.
    fn start(&mut self, q: &[f64], speed: &[f64], springs: SpringStart) {
        let mut v = DVector::zeros(self.engine.coordinates());
        for (dof, s) in speed.iter().enumerate() {
            v[self.engine.column(dof)] = *s;
        }
        self.engine.set_state(q, 0.0, &v, &v);
        for actuator in &mut self.actuators {
            actuator.start(&self.engine, 0.0, &ActuatorStart::default(), self.step_s);
        }
        let loads = match springs {
            SpringStart::Unloaded => DVector::zeros(self.actuators.len()),
            SpringStart::Balanced => {
                let arms = moment_arms(&self.engine, &self.actuators, q.len());
                let weight = self.engine.gravity_forces();
                let torques = DVector::from_fn(q.len(), |dof, _| -weight[self.engine.column(dof)]);
                share_out(&arms, &torques)
            }
        };
        let mut accelerations = DVector::zeros(v.len());
        let mut starts = vec![ActuatorStart::default(); self.actuators.len()];
        // What the sprung masses feel is one step late: every further trial leaves 1/200 of the error.
        for trial in [true, true, true, false] {
            let now = &v - &accelerations * (0.5 * self.step_s);
            let before = &v - &accelerations * (1.5 * self.step_s);
            self.engine.set_state(q, 0.0, &now, &before);
            for ((actuator, load), start) in self.actuators.iter_mut().zip(loads.iter()).zip(&starts) {
                actuator.start(&self.engine, *load, start, self.step_s);
            }
            self.stops.start(&self.engine);
            if let Some(contact) = &mut self.contact {
                contact.start(&self.engine);
            }
            for servo in &mut self.servos {
                servo.before = [self.engine.q[servo.dof]; 2];
            }
            if trial {
                self.apply_forces();
                self.engine.step();
                accelerations = (self.engine.velocity() - &now) / self.step_s;
                self.complete_actuators();
                starts = self.actuators.iter().map(Actuator::accelerations).collect();
            }
        }
    }

    /// Puts all forces of the present instant on the bodies.
    fn apply_forces(&mut self) {
        let time_s = self.time_s();
        self.engine.clear_forces();
        if self.controller.due(self.steps) {
            self.controller.update(time_s, &self.engine, &self.actuators);
            let sent = self.commands.iter_mut().zip(&self.controller.currents_a);
            for ((line, current), actuator) in sent.zip(&self.actuators) {
                line.send(time_s, *current, &actuator.laws.command_stages);
            }
        }
        for (i, actuator) in self.actuators.iter_mut().enumerate() {
            let current = match self.commands[i].given(self.steps) {
                Some(given) => {
                    self.controller.currents_a[i] = given;
                    given
                }
                // What is in force from half a step before to half a step after: between these instants the
                // leapfrog's velocities change by what is applied now.
                None => self.commands[i].mean(time_s - 0.5 * self.step_s, self.step_s),
            };
            actuator.apply(&mut self.engine, current, &self.gravity, time_s, self.step_s);
        }
        for servo in &mut self.servos {
            servo.target_rad = self.controller.target_rad(servo.dof, time_s);
            servo.apply(&mut self.engine);
        }
        self.stops.apply(&mut self.engine);
        if let Some(contact) = &mut self.contact {
            self.ground = contact.apply(&mut self.engine, self.step_s);
        }
    }

    fn complete_actuators(&mut self) {
        for (i, actuator) in self.actuators.iter_mut().enumerate() {
            let travel = self.leg.actuators[i].travel_per_rad;
            let current = self.controller.currents_a[i];
            (self.instants[i], self.powers[i]) =
                actuator.complete(&self.engine, current, &self.gravity, self.step_s, travel);
        }
    }

    /// One step. Afterwards [`Simulation::events`] has what happened at the instant that it began with, and
    /// with `sample` set [`Simulation::sample`] is that instant.
    ///
    /// # Errors
    ///
    /// [`LegError::NotFinite`] with the time and the body, joint or actuator.
    pub fn advance(&mut self, sample: bool) -> Result<(), LegError> {
        let time_s = self.time_s();
        self.events.clear();
        self.apply_forces();
        let before = sample.then(|| self.begin_sample(time_s));
        self.engine.step();
        self.complete_actuators();
        self.check(time_s)?;
        self.account();
        if let Some((velocity, mass, potential)) = before {
            let mean = (velocity + self.engine.velocity()) * 0.5;
            self.end_sample(&mean, 0.5 * mean.dot(&(mass * &mean)), potential);
        }
        let saturated = &self.controller.saturated;
        self.watch.look(
            time_s,
            &self.leg,
            &self.instants,
            saturated,
            &self.ground,
            self.stops.stopped(),
            &mut self.events,
        );
        self.steps += 1;
        Ok(())
    }

    /// Whether everything is still finite and within reason.
    fn check(&self, time_s: f64) -> Result<(), LegError> {
        let fault = |what: String| Err(LegError::NotFinite { time_s, what });
        // Written so that a NaN fails.
        let sane = |v: f64| v.abs() < RUNAWAY_RAD_S;
        for (instant, model) in self.instants.iter().zip(&self.leg.actuators) {
            if !(instant.spring_force_n.is_finite() && sane(instant.deflection_m)) {
                return fault(format!("actuator '{}'", model.name));
            }
        }
        if self.engine.velocity().iter().all(|v| sane(*v)) && sane(self.engine.rail_m) {
            return Ok(());
        }
        let body = self.tree.bodies.iter().skip(1).find(|b| {
            b.joint.as_ref().is_some_and(|j| !sane(self.engine.velocity()[self.engine.column(j.dof)]))
        });
        fault(format!("the motion of link '{}'", body.unwrap_or(&self.tree.bodies[0]).name))
    }

    /// What the run is about.
    #[must_use]
    pub fn leg(&self) -> &LegDescription {
        &self.leg
    }

    /// Time of the instant that the next step begins with, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.steps as f64 * self.step_s
    }

    /// The last sample that was asked for.
    #[must_use]
    pub fn sample(&self) -> &Sample {
        &self.sample
    }

    /// What happened at the last instant.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Greatest values so far, looked for at every step.
    #[must_use]
    pub fn peaks(&self) -> &Peaks {
        self.watch.peaks()
    }

    /// One step that is told to whoever wants channels and nothing else.
    pub(crate) fn advance_watched(&mut self, mut see: impl FnMut(&Instant)) -> Result<(), LegError> {
        let mut angles = std::mem::take(&mut self.sample.joint_angles_rad);
        angles.clone_from(&self.engine.q);
        let base_height_m = self.base_height_m();
        self.advance(false)?;
        see(&Instant {
            joint_angles_rad: &angles,
            actuators: &self.instants,
            base_height_m,
            normal_force_n: self.ground.normal_force_n,
        });
        self.sample.joint_angles_rad = angles;
        Ok(())
    }

    /// Commands an actuator by these currents, A, each the mean over one step and already past the drive's stages,
    /// in place of the controller.
    pub(crate) fn give_currents(&mut self, actuator: usize, per_step: Vec<f64>) {
        self.commands[actuator].give(per_step);
    }

    /// Wants a joint at these positions, rad, with straight lines between, in place of its motion.
    pub(crate) fn give_target(&mut self, dof: usize, time_s: Vec<f64>, position_rad: Vec<f64>) {
        self.controller.give_target(dof, time_s, position_rad);
    }

    /// Effects in front of or inside the sensors of a place.
    pub(crate) fn sensor_stages(&self, place: &str) -> &[Box<dyn SensorStage>] {
        self.sensor_stages.iter().find(|(p, _)| p == place).map_or(&[], |(_, stages)| stages)
    }

    /// What acts in an actuator beside its linear parts.
    pub(crate) fn laws(&self, actuator: usize) -> Option<&Laws> {
        self.actuators.get(actuator).map(|a| &a.laws)
    }

    /// What acts in an actuator beside its linear parts: the place where effects are put in.
    pub fn laws_mut(&mut self, actuator: usize) -> Option<&mut Laws> {
        self.actuators.get_mut(actuator).map(|a| &mut a.laws)
    }

    /// Path of every actuator at a pose and its velocities (of the joints and of the rail, rad and m), with the velocity of
    /// the joint that a linkage turns and the point where the sprung mass is attached.
    pub(crate) fn reaches_at(
        &mut self,
        (q, rail_m): (&[f64], f64),
        (speed, rail_m_s): (&[f64], f64),
    ) -> Vec<(Reach, f64, Point3<f64>)> {
        let mut v = DVector::zeros(self.engine.coordinates());
        for (dof, s) in speed.iter().enumerate() {
            v[self.engine.column(dof)] = *s;
        }
        if let Some(column) = self.engine.rail_column() {
            v[column] = rail_m_s;
        }
        self.engine.set_state(q, rail_m, &v, &v);
        self.actuators.iter().map(|a| a.reach_of(&self.engine)).collect()
    }

    /// Height of the base's frame, m.
    pub(crate) fn base_height_m(&self) -> f64 {
        self.engine.states[0].pose.translation.z
    }

    /// Whether the base slides on a rail.
    pub(crate) fn is_on_rail(&self) -> bool {
        self.engine.rail_column().is_some()
    }

    /// The actuators as they are, with gravity (m/s^2): for a simulation of them alone.
    pub(crate) fn actuators_mut(&mut self) -> (&mut [Actuator], Vector3<f64>) {
        (&mut self.actuators, self.gravity)
    }

    /// For a benchmark: as [`Simulation::new`], with the bodies moved as in fits.
    #[doc(hidden)]
    pub fn as_in_fits(scenario: &Scenario) -> Result<Self, LegError> {
        Self::with_effects(scenario, load_robot(scenario)?, &[], Mechanics::Equations)
    }

    /// For a benchmark: a step of the engine alone, without any of our forces.
    #[doc(hidden)]
    pub fn bare_engine_step(&mut self) {
        self.engine.clear_forces();
        self.engine.step_bare();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_engine_makes_no_forces_of_its_own() {
        for name in ["thor-drop", "saffir-drop", "thor-swing"] {
            let scenario = Scenario::load(name, &[]).expect("good");
            let mut simulation = Simulation::new(&scenario).expect("good");
            for _ in 0..10 {
                simulation.advance(false).expect("runs");
            }
            let mut found = simulation.engine.own_forces();
            // The coupling of a linkage drive sets its joint's armature, and nothing else does.
            let linkages = simulation.leg.robot.actuators.iter();
            if linkages.clone().any(|p| matches!(p.drive, crate::robot::Drive::Hoekens(_))) {
                found.retain(|f| f != "armature");
            }
            assert!(found.is_empty(), "{name}: {found:?}");
        }
    }
    /// Joint angles after a time, with a step.
    fn angles(mechanics: Mechanics, scenario: &Scenario, step_s: f64, time_s: f64) -> Vec<f64> {
        let scenario = Scenario { step_s, ..scenario.clone() };
        let robot = load_robot(&scenario).expect("good");
        let mut simulation =
            Simulation::with_effects(&scenario, robot, &[], mechanics).expect("a simulation");
        for _ in 0..(time_s / step_s).round() as usize {
            simulation.advance(false).expect("runs");
        }
        simulation.engine.q.clone()
    }

    fn distance(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn converges_both_mechanics_move_a_leg_alike_and_nearer_with_the_step() {
        for (name, time_s) in [("thor-swing", 0.4), ("saffir-swing", 0.4), ("thor-drop", 0.2)] {
            let scenario = Scenario::load(name, &[]).expect("good");
            let at = |mechanics, step_s| angles(mechanics, &scenario, step_s, time_s);
            let apart = |step_s| distance(&at(Mechanics::Rapier, step_s), &at(Mechanics::Equations, step_s));
            let (coarse, fine) = (apart(1e-4), apart(5e-5));
            assert!(coarse < 1e-6, "{name}: {coarse:e} rad");
            assert!(fine < 0.6 * coarse, "{name}: {coarse:e} and {fine:e} rad");
        }
    }
}
