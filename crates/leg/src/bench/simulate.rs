//! The motion of a robot's joints under their drives, step by step.
//!
//! A step takes mass matrix and bias at the middle of the predicted motion, viscous damping, back-EMF and the linear part of a
//! yielding transmission implicitly, and dry friction joint after joint until none changes what the others see: of second
//! order where nothing slips or sticks.
//!
//! A rotor behind a spring, or whose transmission yields or has play, has a coordinate of its own behind those of the joints;
//! all others move with their joints.

use super::observed::Pulls;
use super::rub::{Place, Rubbed};
use crate::dynamics::equations::{Equations, MovingBodies, solve_with};
use nalgebra::{DMatrix, DVector};
use sealegs_actuator::plant::{Feed, Grid, Loop, Past, Plant, SpringStep};
use sealegs_model::ModelError;

/// A robot and its drives with their values in place.
pub(super) struct Machine {
    pub tree: MovingBodies,
    /// Joint by joint.
    pub drives: Vec<Plant>,
    /// Viscous damping of each joint itself, behind its drive's spring, N m s/rad.
    pub damping: Vec<f64>,
    /// The coordinate of each joint's rotor: the joint's own, unless a spring or a transmission that yields is between.
    pub rotor: Vec<usize>,
    /// Where dry friction acts.
    pub places: Vec<Place>,
}

/// Motion and torques of one joint at the points of a grid.
#[derive(Debug, Clone, Default)]
pub(super) struct JointTrace {
    pub position: Vec<f64>,
    pub speed: Vec<f64>,
    /// Position and speed of the rotor, referred to the joint; empty where it moves with the joint.
    rotor: (Vec<f64>, Vec<f64>),
    /// Motor torque over the step that ends at the point, N m.
    pub motor: Vec<f64>,
    /// Torque that passes from the drive to the links over the step that ends at the point, N m.
    pub load: Vec<f64>,
    /// Torque of the observer's pull over the step that ends at the point, N m; 0 without an observer.
    pub pulled: Vec<f64>,
}

impl JointTrace {
    /// An empty trace with room for so many points, of a rotor beside the joint where it is `parted`.
    fn with_room(points: usize, parted: bool) -> Self {
        let room = || Vec::with_capacity(points);
        let rotor = if parted { (room(), room()) } else { Default::default() };
        Self { position: room(), speed: room(), rotor, motor: room(), load: room(), pulled: room() }
    }

    /// Adds the present point of joint `i`, whose rotor has coordinate `c`.
    fn push(&mut self, now: &State, i: usize, c: usize) {
        self.position.push(now.q[i]);
        self.speed.push(now.v[i]);
        self.motor.push(now.motor[i]);
        self.load.push(now.load[i]);
        self.pulled.push(now.pulled[i]);
        if c != i {
            self.rotor.0.push(now.q[c]);
            self.rotor.1.push(now.v[c]);
        }
    }

    /// How many numbers it holds.
    pub fn numbers(&self) -> usize {
        5 * self.position.len() + 2 * self.rotor.0.len()
    }

    /// Position of the rotor, referred to the joint, rad.
    pub fn rotor_position(&self) -> &[f64] {
        if self.rotor.0.is_empty() { &self.position } else { &self.rotor.0 }
    }

    /// By how much the rotor is ahead of the joint, rad.
    pub fn deflection(&self) -> Vec<f64> {
        self.rotor_position().iter().zip(&self.position).map(|(rotor, joint)| rotor - joint).collect()
    }

    /// Its rate, rad/s.
    pub fn rotor_speed(&self) -> &[f64] {
        if self.rotor.1.is_empty() { &self.speed } else { &self.rotor.1 }
    }
}

/// How a run goes.
pub(super) struct Course<'a> {
    /// What the joints are of the robot's, for the pulls.
    pub joints: &'a [usize],
    /// Position and speed by joint.
    pub start: &'a [(f64, f64)],
    /// What each joint's drive is told.
    pub feeds: &'a [Feed<'a>],
    /// The measured motion that the joints are pulled to.
    pub pulls: Option<&'a Pulls>,
    pub grid: Grid,
}

/// What passes a spring or a yielding transmission over a step, N m: the part that does not depend on the step's accelerations, and its
/// change with the acceleration of the rotor against the joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Passed {
    pub explicit: f64,
    pub implicit: f64,
}

/// Half of the change of speed by which the slope of a drive's torque over speed is found, over the speed itself or 1 rad/s:
/// small against what makes a limit turn, large against rounding.
const SLOPE_SPAN: f64 = 1e-4;

/// A robot in motion: what a step begins with, and room for what it computes, by coordinate or by joint.
pub(super) struct State {
    /// Positions, speeds and accelerations of all coordinates.
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    a: Vec<f64>,
    /// Positions and speeds in the middle of the step.
    pub mid_q: Vec<f64>,
    mid_v: Vec<f64>,
    pub travelled: Vec<f64>,
    /// Mass matrix and bias forces of the joints.
    pub equations: Equations,
    /// The matrix of the accelerations with all that is implicit.
    matrix: DMatrix<f64>,
    force: DVector<f64>,
    /// Accelerations of all coordinates per unit of dry friction, a column for each place.
    per_friction: DMatrix<f64>,
    /// Accelerations without dry friction, and with it.
    pub free: DVector<f64>,
    pub accelerated: Vec<f64>,
    /// Torques of motors, through transmissions and of the observer's pull, joint by joint, N m.
    motor: Vec<f64>,
    pub load: Vec<f64>,
    pulled: Vec<f64>,
    /// Through springs and transmissions that yield.
    pub passed: Vec<Passed>,
    pub warmer_k: Vec<f64>,
    loops: Vec<Loop>,
    /// Dry friction, N m, and what it remembers, place by place.
    pub friction: Vec<f64>,
    pub rubbed: Vec<Rubbed>,
}

impl State {
    /// A robot where a run begins: rotors that do not move with their joints hold them.
    fn of(machine: &Machine, joints: &[(f64, f64)]) -> Self {
        let n = machine.drives.len();
        let mut q: Vec<f64> = joints.iter().map(|s| s.0).collect();
        let mut v: Vec<f64> = joints.iter().map(|s| s.1).collect();
        for (i, ahead) in ahead_at_rest(&machine.tree, &machine.drives, &q).into_iter().enumerate() {
            if machine.rotor[i] != i {
                q.push(q[i] + ahead);
                v.push(v[i]);
            }
        }
        let count = q.len();
        Self {
            a: vec![0.0; count],
            mid_q: q.clone(),
            mid_v: v.clone(),
            travelled: vec![0.0; count],
            equations: machine.tree.equations(),
            matrix: DMatrix::zeros(count, count),
            force: DVector::zeros(count),
            per_friction: DMatrix::zeros(count, machine.places.len()),
            free: DVector::zeros(count),
            accelerated: vec![0.0; count],
            motor: vec![0.0; n],
            load: vec![0.0; n],
            pulled: vec![0.0; n],
            passed: vec![Passed::default(); n],
            warmer_k: vec![0.0; n],
            loops: vec![Loop::default(); n],
            friction: vec![0.0; machine.places.len()],
            rubbed: vec![Rubbed::default(); machine.places.len()],
            q,
            v,
        }
    }

    /// Accelerations of all coordinates per unit of dry friction at a place.
    pub fn per_friction(&self, place: usize) -> &[f64] {
        let count = self.q.len();
        &self.per_friction.as_slice()[place * count..][..count]
    }
}

/// How far the rotor of each joint is ahead of it where the robot rests in a posture, rad or m: 0 of one that moves with its
/// joint.
pub(super) fn ahead_at_rest(tree: &MovingBodies, drives: &[Plant], posture: &[f64]) -> Vec<f64> {
    if drives.iter().all(|drive| drive.rigid.is_some()) {
        return vec![0.0; drives.len()];
    }
    let mut equations = tree.equations();
    tree.at(posture, &vec![0.0; drives.len()], &mut equations);
    let ahead = |(drive, torque): (&Plant, &f64)| match drive.rigid {
        Some(_) => 0.0,
        None => drive.ahead_under(*torque),
    };
    drives.iter().zip(equations.bias.iter()).map(ahead).collect()
}

impl Machine {
    /// A robot with drives on its joints, and the viscous damping of the joints themselves.
    pub fn new(tree: MovingBodies, drives: Vec<Plant>, damping: Vec<f64>) -> Self {
        let n = drives.len();
        let parted = |i: usize| drives[..i].iter().filter(|d| d.rigid.is_none()).count();
        let rotor: Vec<usize> =
            (0..n).map(|i| if drives[i].rigid.is_none() { n + parted(i) } else { i }).collect();
        let places = Place::of(&drives, &rotor);
        Self { tree, drives, damping, rotor, places }
    }

    /// The motion over a run; `names` are the joints'.
    ///
    /// # Errors
    ///
    /// [`ModelError::NotFinite`] when a joint runs away, [`ModelError::BadParameter`] for a mass matrix that is not positive
    /// definite.
    pub fn run(&self, course: &Course, names: &[&str]) -> Result<Vec<JointTrace>, ModelError> {
        let mut now = State::of(self, course.start);
        let mut traces: Vec<JointTrace> = self
            .rotor
            .iter()
            .enumerate()
            .map(|(i, c)| JointTrace::with_room(course.grid.steps + 1, *c != i))
            .collect();
        for step in 0..=course.grid.steps {
            for (i, trace) in traces.iter_mut().enumerate() {
                trace.push(&now, i, self.rotor[i]);
            }
            if step == course.grid.steps {
                break;
            }
            if let Some(i) = (0..names.len()).find(|&i| !(now.q[i].is_finite() && now.v[i].is_finite())) {
                let what = format!("the position of joint {}", names[i]);
                return Err(ModelError::NotFinite { time_s: course.grid.time(step), what });
            }
            self.to_middle(&mut now, course.grid.step_s);
            self.drive(course, step, &traces, &mut now);
            if let Some(pulls) = course.pulls {
                self.pull(pulls, (course.joints, step), &mut now);
            }
            if !self.accelerate(&mut now) {
                let (name, admitted) = ("mass matrix".to_owned(), "such that every joint moves some mass");
                return Err(ModelError::BadParameter { name, value: 0.0, admitted });
            }
            self.rub(&mut now, course.grid.step_s);
            self.advance(&mut now, course.grid.step_s);
        }
        // No step ends at the first point: what acts over the one that begins there.
        for trace in traces.iter_mut().filter(|trace| trace.load.len() > 1) {
            (trace.motor[0], trace.load[0]) = (trace.motor[1], trace.load[1]);
        }
        Ok(traces)
    }

    /// Positions and speeds in the middle of the step, as they are without a change of the accelerations, and the equations
    /// of motion there.
    fn to_middle(&self, now: &mut State, h: f64) {
        for i in 0..now.q.len() {
            now.mid_q[i] = now.q[i] + 0.5 * h * now.v[i] + 0.125 * h * h * now.a[i];
            now.mid_v[i] = now.v[i] + 0.5 * h * now.a[i];
        }
        let n = self.drives.len();
        self.tree.at(&now.mid_q[..n], &now.mid_v[..n], &mut now.equations);
    }

    /// The matrix of the accelerations and the forces without dry friction and without an observer's pull.
    fn drive(&self, course: &Course, step: usize, traces: &[JointTrace], now: &mut State) {
        let (n, h) = (self.drives.len(), course.grid.step_s);
        let t = course.grid.time(step) + 0.5 * h;
        now.matrix.fill(0.0);
        now.matrix.view_mut((0, 0), (n, n)).copy_from(&now.equations.mass);
        now.force.fill(0.0);
        for (i, plant) in self.drives.iter().enumerate() {
            let (c, feed, trace) = (self.rotor[i], &course.feeds[i], &traces[i]);
            now.warmer_k[i] = feed.warmer_k(step);
            now.matrix[(c, c)] += plant.reflected_inertia + 0.5 * h * plant.damping;
            let mut command = feed.command(step);
            if let Some(servo) = &plant.servo {
                let (position, speed) = match servo.sees_rotor {
                    true => (trace.rotor_position(), trace.rotor_speed()),
                    false => (&trace.position[..], &trace.speed[..]),
                };
                let past = Past { position, speed, step_s: h };
                command = servo.command(&feed.told(step), past, &mut now.loops[i]);
            }
            let (q, v, load) = (&now.mid_q, &now.mid_v, now.load[i]);
            let (torque, slope) =
                if feed.released(step) { (0.0, 0.0) } else { motor_torque(plant, command, v[c]) };
            now.matrix[(c, c)] += 0.5 * h * slope;
            now.motor[i] = torque;
            let outside: f64 = plant.output_forces.iter().map(|f| f.force(q[i], v[i], load, t)).sum();
            now.force[c] += torque + 0.5 * h * slope * now.a[c] + plant.laws.rotor_force(q[c], v[c], load, t)
                - plant.damping * now.v[c];
            now.force[i] += outside - now.equations.bias[i] - self.damping[i] * now.v[i];
            now.matrix[(i, i)] += 0.5 * h * self.damping[i];
            if c != i {
                let over = (now.q[c] - now.q[i], now.v[c] - now.v[i], now.a[c] - now.a[i]);
                let passed = pass(plant, over, h, course.grid.time(step));
                now.force[c] -= passed.explicit;
                now.force[i] += passed.explicit;
                // A mass that the spring carries moves by what it yields.
                for (row, column, sign) in [(i, i, 1.0), (c, c, 1.0), (i, c, -1.0), (c, i, -1.0)] {
                    now.matrix[(row, column)] += sign * (passed.implicit + plant.sprung_mass);
                }
                now.passed[i] = passed;
            }
        }
    }

    /// Adds the pull of an observer.
    fn pull(&self, pulls: &Pulls, at: (&[usize], usize), now: &mut State) {
        let n = self.drives.len();
        let equations = &now.equations;
        let inertia = |i, j| self.inertia(equations, i, j);
        pulls.torques(at, (&now.mid_q[..n], &now.mid_v[..n]), inertia, &mut now.pulled);
        now.force.iter_mut().zip(&now.pulled).for_each(|(force, pull)| *force += pull);
    }

    /// The accelerations without dry friction, and what it adds to them at each place; as [`solve_with`].
    fn accelerate(&self, now: &mut State) -> bool {
        let State { matrix, force, free, per_friction, .. } = now;
        free.copy_from(force);
        per_friction.fill(0.0);
        for (mut column, place) in per_friction.column_iter_mut().zip(&self.places) {
            place.push(1.0, column.as_mut_slice());
        }
        solve_with(matrix, |factor| {
            factor.solve_mut(free);
            factor.solve_mut(per_friction);
        })
    }

    /// Goes on to the end of the step with the accelerations that friction leaves.
    fn advance(&self, now: &mut State, h: f64) {
        for i in 0..now.q.len() {
            let (free, accelerated) = (now.free[i], now.accelerated[i]);
            let size = now.v[i].abs() + h * (free.abs() + (accelerated - free).abs());
            let mut after = now.v[i] + h * accelerated;
            // What rounding leaves of a speed that friction has just stopped is not a motion.
            let rubbed =
                self.places.iter().zip(&now.friction).any(|(place, by)| place.holds(i) && *by != 0.0);
            if rubbed && after.abs() <= 1e-11 * size {
                after = 0.0;
            }
            now.travelled[i] =
                if now.v[i] == 0.0 && after == 0.0 { 0.0 } else { 0.5 * h * (now.v[i] + after) };
            now.a[i] = (after - now.v[i]) / h;
            now.q[i] += now.travelled[i];
            now.v[i] = after;
        }
        self.remember(now);
    }

    /// An entry of the mass matrix of the joints with the reflected inertia of the drives that move with them, kg m^2.
    fn inertia(&self, equations: &Equations, i: usize, j: usize) -> f64 {
        let with_joint = i == j && self.rotor[i] == i;
        equations.mass[(i, j)] + if with_joint { self.drives[i].reflected_inertia } else { 0.0 }
    }
}

/// The torque of a motor at a speed, N m, and by how much a faster one has less, N m s/rad: of a back-EMF that is taken
/// implicitly. A torque that is commanded does not depend on speed.
fn motor_torque(plant: &Plant, command: f64, speed: f64) -> (f64, f64) {
    let torque = plant.motor_force(command, speed);
    if plant.winding.is_none() {
        return (torque, 0.0);
    }
    let span = SLOPE_SPAN * speed.abs().max(1.0);
    let at = |speed| plant.motor_force(command, speed);
    (torque, ((at(speed - span) - at(speed + span)) / (2.0 * span)).max(0.0))
}

/// What passes a transmission over a step, from deflection, its rate and acceleration (rad, rad/s, rad/s^2).
fn pass(plant: &Plant, (start, rate, acceleration): (f64, f64, f64), h: f64, t: f64) -> Passed {
    let (stiffness, damping) = (plant.stiffness, plant.laws.spring_damping);
    let mut explicit = stiffness * (start + 0.5 * h * rate) + damping * rate;
    if !plant.laws.spring_is_linear() {
        let mean = start + 0.5 * h * rate + 0.25 * h * h * acceleration;
        let over =
            SpringStep { start, mean, rate: rate + 0.5 * h * acceleration, step_s: h, per_step: 1.0 / h };
        explicit += plant.laws.spring_departure(stiffness, &over, t);
    }
    Passed { explicit, implicit: 0.5 * h * damping + 0.25 * h * h * stiffness }
}
