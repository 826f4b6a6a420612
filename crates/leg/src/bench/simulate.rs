//! The motion of a robot's joints under their drives, step by step.
//!
//! A step takes mass matrix and bias at the middle of the predicted motion, viscous damping, back-EMF and the linear part of a
//! yielding transmission implicitly, and dry friction joint after joint until none changes what the others see: of second
//! order where nothing slips or sticks.
//!
//! A rotor whose transmission yields or has play has a coordinate of its own behind those of the joints; all others move with
//! their joints.

use super::observed::Pulls;
use super::rub::{Rub, Rubbed};
use super::tree::{Equations, Tree};
use nalgebra::{DMatrix, DVector};
use sealegs_actuator::plant::{Feed, Grid, Loop, Past, Plant, SpringStep};
use sealegs_model::ModelError;

/// A robot and its drives with their values in place.
pub(super) struct Machine {
    pub tree: Tree,
    /// Joint by joint.
    pub drives: Vec<Plant>,
    /// The coordinate of each joint's rotor: the joint's own, unless its transmission yields.
    pub rotor: Vec<usize>,
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
    /// Torque that passes from the drive to the links, N m.
    pub load: Vec<f64>,
    /// Torque of the observer's pull over the step that ends at the point, N m; 0 without an observer.
    pub pulled: Vec<f64>,
}

impl JointTrace {
    /// Position of the rotor, referred to the joint, rad.
    pub fn rotor_position(&self) -> &[f64] {
        if self.rotor.0.is_empty() { &self.position } else { &self.rotor.0 }
    }

    /// Its rate, rad/s.
    pub fn rotor_speed(&self) -> &[f64] {
        if self.rotor.1.is_empty() { &self.speed } else { &self.rotor.1 }
    }
}

/// How a run goes.
pub(super) struct Course<'a> {
    /// Position and speed by joint.
    pub start: &'a [(f64, f64)],
    /// What each joint's drive is told.
    pub feeds: &'a [Feed<'a>],
    /// The measured motion that the joints are pulled to.
    pub pulls: Option<&'a Pulls>,
    pub grid: Grid,
}

/// What passes a yielding transmission over a step, N m: the part that does not depend on the step's accelerations, and its
/// change with the acceleration of the rotor against the joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Passed {
    pub explicit: f64,
    pub implicit: f64,
}

/// Half of the change of speed by which the slope of a drive's torque over speed is found, over the speed itself or 1 rad/s:
/// small against what makes a limit turn, large against rounding.
const SLOPE_SPAN: f64 = 1e-4;

impl Machine {
    /// A robot with drives on its joints.
    pub fn new(tree: Tree, drives: Vec<Plant>) -> Self {
        let n = drives.len();
        let parted = |i: usize| drives[..i].iter().filter(|d| d.is_parted()).count();
        let rotor = (0..n).map(|i| if drives[i].is_parted() { n + parted(i) } else { i }).collect();
        Self { tree, drives, rotor }
    }

    /// The motion over a run; `names` are the joints'.
    ///
    /// # Errors
    ///
    /// [`ModelError::NotFinite`] when a joint runs away, [`ModelError::BadParameter`] for a mass matrix that has no
    /// inverse.
    pub fn run(&self, course: &Course, names: &[String]) -> Result<Vec<JointTrace>, ModelError> {
        let (n, h) = (self.drives.len(), course.grid.step_s);
        let count = n + self.drives.iter().filter(|d| d.is_parted()).count();
        let mut equations = self.tree.equations();
        let (mut q, mut v) = self.start(course.start, count, &mut equations);
        let mut a = vec![0.0; count];
        let mut rubbed = vec![Rubbed::default(); n];
        let mut loops = vec![Loop::default(); n];
        let mut traces = vec![JointTrace::default(); n];
        let (mut load, mut motor, mut pulled) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let mut passed = vec![Passed::default(); n];
        let (mut mid_q, mut mid_v) = (vec![0.0; count], vec![0.0; count]);
        let (mut held, mut travelled, mut warmer_k) = (vec![false; count], vec![0.0; count], vec![0.0; n]);
        for step in 0..=course.grid.steps {
            for (i, trace) in traces.iter_mut().enumerate() {
                trace.position.push(q[i]);
                trace.speed.push(v[i]);
                trace.motor.push(motor[i]);
                trace.load.push(load[i]);
                trace.pulled.push(pulled[i]);
                if self.rotor[i] != i {
                    trace.rotor.0.push(q[self.rotor[i]]);
                    trace.rotor.1.push(v[self.rotor[i]]);
                }
            }
            if step == course.grid.steps {
                break;
            }
            if let Some(i) = (0..n).find(|&i| !(q[i].is_finite() && v[i].is_finite())) {
                let what = format!("the position of joint {}", names[i]);
                return Err(ModelError::NotFinite { time_s: course.grid.time(step), what });
            }
            for i in 0..count {
                mid_q[i] = q[i] + 0.5 * h * v[i] + 0.125 * h * h * a[i];
                mid_v[i] = v[i] + 0.5 * h * a[i];
            }
            self.tree.at(&mid_q[..n], &mid_v[..n], &mut equations);
            let t = course.grid.time(step) + 0.5 * h;
            let mut matrix: DMatrix<f64> = equations.mass.clone();
            matrix.resize_mut(count, count, 0.0);
            let mut force = DVector::zeros(count);
            for (i, plant) in self.drives.iter().enumerate() {
                let (c, feed, trace) = (self.rotor[i], &course.feeds[i], &traces[i]);
                warmer_k[i] = feed.warmer_k(step);
                matrix[(c, c)] += plant.reflected_inertia + 0.5 * h * plant.damping;
                let mut command = feed.command(step);
                if let Some(servo) = &plant.servo {
                    let past = Past { position: &trace.position, speed: &trace.speed, step_s: h };
                    command = servo.volts(command, feed.supply(step), past, &mut loops[i]);
                }
                let (torque, slope) =
                    if feed.released(step) { (0.0, 0.0) } else { motor_torque(plant, command, mid_v[c]) };
                matrix[(c, c)] += 0.5 * h * slope;
                motor[i] = torque;
                let outside: f64 =
                    plant.output_forces.iter().map(|f| f.force(mid_q[i], mid_v[i], load[i], t)).sum();
                force[c] +=
                    torque + 0.5 * h * slope * a[c] + plant.laws.rotor_force(mid_q[c], mid_v[c], load[i], t)
                        - plant.damping * v[c];
                force[i] += outside - equations.bias[i];
                if c != i {
                    let over = (q[c] - q[i], v[c] - v[i], a[c] - a[i]);
                    passed[i] = pass(plant, over, h, course.grid.time(step));
                    let Passed { explicit, implicit } = passed[i];
                    force[c] -= explicit;
                    force[i] += explicit;
                    for (row, column, sign) in [(i, i, 1.0), (c, c, 1.0), (i, c, -1.0), (c, i, -1.0)] {
                        matrix[(row, column)] += sign * implicit;
                    }
                }
            }
            if let Some(pulls) = course.pulls {
                let inertia = |i, j| self.inertia(&equations, i, j);
                pulls.torques(step, (&mid_q[..n], &mid_v[..n]), inertia, &mut pulled);
                force.iter_mut().zip(&pulled).for_each(|(force, pull)| *force += pull);
            }
            let Some(inverse) = matrix.try_inverse() else {
                let admitted = "such that every joint moves some mass";
                return Err(ModelError::BadParameter {
                    name: "mass matrix".to_owned(),
                    value: 0.0,
                    admitted,
                });
            };
            let free = &inverse * force;
            let at = Rub {
                q: &mid_q,
                v: &v,
                free: &free,
                inverse: &inverse,
                passed: &passed,
                warmer_k: &warmer_k,
                h,
            };
            let friction = self.rub(&at, &equations, &mut load, &mut rubbed);
            for (i, rub) in friction.iter().enumerate() {
                held[self.rotor[i]] = *rub != 0.0;
            }
            for i in 0..count {
                let gained: f64 = (0..n).map(|j| inverse[(i, self.rotor[j])] * friction[j]).sum();
                let size = v[i].abs() + h * (free[i].abs() + gained.abs());
                let mut after = v[i] + h * (free[i] + gained);
                // What rounding leaves of a speed that friction has just stopped is not a motion.
                if held[i] && after.abs() <= 1e-11 * size {
                    after = 0.0;
                }
                travelled[i] = if v[i] == 0.0 && after == 0.0 { 0.0 } else { 0.5 * h * (v[i] + after) };
                a[i] = (after - v[i]) / h;
                q[i] += travelled[i];
                v[i] = after;
            }
            for (i, plant) in self.drives.iter().enumerate() {
                rubbed[i].advance(&plant.laws, travelled[self.rotor[i]]);
            }
        }
        Ok(traces)
    }

    /// Positions and speeds of all coordinates where a run begins: rotors that do not move with their joints hold them.
    fn start(&self, joints: &[(f64, f64)], count: usize, equations: &mut Equations) -> (Vec<f64>, Vec<f64>) {
        let n = self.drives.len();
        let mut q: Vec<f64> = joints.iter().map(|s| s.0).collect();
        let mut v: Vec<f64> = joints.iter().map(|s| s.1).collect();
        if count > n {
            self.tree.at(&q, &vec![0.0; n], equations);
            for i in (0..n).filter(|&i| self.rotor[i] != i) {
                q.push(q[i] + self.drives[i].ahead_under(equations.bias[i]));
                v.push(v[i]);
            }
        }
        (q, v)
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
