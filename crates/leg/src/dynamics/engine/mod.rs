//! The rigid bodies in motion, and nothing but rigid bodies: every force is ours.
//!
//! The physics engine moves them ([`Mechanics::Rapier`]), and where runs are simulated by the thousand their own equations
//! of motion do ([`Mechanics::Equations`]), three times as fast. Both have the same coordinates, take the same forces, and
//! come nearer to each other with the step: a test compares them.
//!
//! # Leapfrog
//!
//! A step advances `v += a dt; x += v dt` with `a` from the pose before the step. Read as a leapfrog,
//! its velocity before step `n` belongs to the middle of the step before, `t_n - dt/2`, and the scheme is of
//! second order if velocity-dependent forces are evaluated at `v + (v - v_prev)/2`: the twists of [`BodyState`] are
//! those velocities. Rapier takes its Coriolis and gyroscopic forces at the end of the step, by first order.

mod rapier;
mod recursive;
mod weight;

use super::equations::MovingBodies;
use super::tree::Tree;
use crate::robot::Inertial;
use nalgebra::{DVector, Isometry3, Matrix3, OMatrix, Point3, U6, Vector3};
use rapier::Rapier;
use recursive::Recursive;

/// Six rows (velocity of the centre of mass, angular velocity), a column for each coordinate.
type Jacobian = OMatrix<f64, U6, nalgebra::Dyn>;

/// What moves the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mechanics {
    /// The physics engine.
    Rapier,
    /// The equations of motion in the joints' coordinates.
    Equations,
}

/// How the base is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Base {
    /// Fixed in the world.
    Fixed,
    /// On a vertical rail, with this much mass on the carriage besides the base link's own, kg.
    Rail {
        /// Mass of the carriage.
        carriage_mass_kg: f64,
    },
}

/// Linear velocity of the centre of mass and angular velocity, world frame.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Twist {
    /// Velocity of the centre of mass, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<f64>,
}

/// Pose and velocity of one body as the coupling sees them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyState {
    /// `world_from_body`.
    pub pose: Isometry3<f64>,
    /// Centre of mass, world, m.
    pub com: Point3<f64>,
    /// Velocity extrapolated to the time of the pose.
    pub twist: Twist,
}

impl BodyState {
    /// Velocity of a world point that moves with the body, m/s.
    pub fn velocity_at(&self, point: &Point3<f64>) -> Vector3<f64> {
        self.twist.linear + self.twist.angular.cross(&(point - self.com))
    }
}

/// Bodies that take forces and move by steps. Generalised vectors are in the order of their own coordinates.
trait Bodies: Send + Sync {
    /// Forgets all forces and torques.
    fn clear_forces(&mut self);
    /// Adds a force, N, at a world point, m.
    fn add_force(&mut self, body: usize, force: &Vector3<f64>, point: &Point3<f64>);
    /// Adds a torque, N m, world frame.
    fn add_torque(&mut self, body: usize, torque: &Vector3<f64>);
    /// Sets the inertia added to a coordinate.
    fn set_armature(&mut self, column: usize, inertia: f64);
    /// Moves the coordinates by a displacement and gives them a velocity.
    fn displace(&mut self, displacement: &[f64], velocity: &DVector<f64>);
    /// One step; `speed` is the velocity at the time of the poses.
    fn step(&mut self, speed: &DVector<f64>);
    /// Writes the velocity half a step before the poses.
    fn velocity(&self, out: &mut DVector<f64>);
    /// Index of the coordinate of the joint that carries a body.
    fn column(&self, body: usize) -> usize;
    /// Position of that joint, rad or m.
    fn position(&self, body: usize) -> f64;
    /// `world_from_body`.
    fn pose(&self, body: usize) -> Isometry3<f64>;
    /// How the coordinates move a body.
    fn jacobian(&self, body: usize) -> &Jacobian;
    /// Everything that would make forces of its own: damping, armature, friction, motors, springs, limits, colliders.
    #[cfg(test)]
    fn own_forces(&self) -> Vec<String>;
}

/// One tree of bodies in motion.
pub(crate) struct Engine {
    bodies: Box<dyn Bodies>,
    mass_kg: Vec<f64>,
    inertia: Vec<Matrix3<f64>>,
    com: Vec<Point3<f64>>,
    /// Gravitational acceleration along z, m/s^2.
    gravity: f64,
    /// Index in the generalised vectors of each joint of the robot by its degree of freedom.
    columns: Vec<usize>,
    /// Joint positions in the robot's order.
    pub q: Vec<f64>,
    /// Height of the carriage over where it was built, m; 0 on a fixed base.
    pub rail_m: f64,
    /// Generalised velocity before the last step, in the engine's order.
    previous: DVector<f64>,
    /// Generalised velocity now, in the engine's order.
    current: DVector<f64>,
    /// Generalised velocity extrapolated to the time of the poses, `v + (v - v_prev)/2`.
    speed: DVector<f64>,
    /// Poses and extrapolated velocities.
    pub states: Vec<BodyState>,
    rail: bool,
    /// Body and degree of freedom of each joint.
    child_joints: Vec<(usize, usize)>,
    /// Axis of the joint that carries each body, in its frame.
    axes: Vec<Vector3<f64>>,
}

impl Engine {
    /// Builds the tree with the base's frame at `world_from_base`, all joints at zero and at rest. `gravity` is the
    /// acceleration along z, m/s^2.
    pub fn new(
        mechanics: Mechanics,
        tree: &Tree,
        base: Base,
        world_from_base: &Isometry3<f64>,
        dofs: usize,
        gravity: f64,
        step_s: f64,
    ) -> Self {
        let rail = matches!(base, Base::Rail { .. });
        let mut inertials: Vec<Option<Inertial>> = tree.bodies.iter().map(|b| b.inertial.clone()).collect();
        if let Base::Rail { carriage_mass_kg } = base {
            let own = inertials[0].take();
            let own =
                own.unwrap_or(Inertial { mass_kg: 0.0, com: Point3::origin(), inertia: Matrix3::zeros() });
            // On a rail only the mass of the base counts; its inertia keeps Rapier's matrices regular.
            let inertia = own.inertia + Matrix3::identity();
            inertials[0] = Some(Inertial { mass_kg: own.mass_kg + carriage_mass_kg, com: own.com, inertia });
        }
        let (bodies, n): (Box<dyn Bodies>, usize) = match mechanics {
            Mechanics::Rapier => {
                let rapier = Rapier::new(tree, &mut inertials, rail, world_from_base, gravity, step_s);
                let n = rapier.coordinates();
                (Box::new(rapier), n)
            }
            Mechanics::Equations => {
                let on_rail = inertials[0].as_ref().filter(|_| rail);
                let moving = MovingBodies::new(tree, on_rail, world_from_base, -gravity);
                let n = moving.len();
                (Box::new(Recursive::new(moving, rail, step_s)), n)
            }
        };
        let of = |f: &dyn Fn(&Inertial) -> f64| inertials.iter().map(|i| i.as_ref().map_or(0.0, f)).collect();
        let still = BodyState { pose: Isometry3::identity(), com: Point3::origin(), twist: Twist::default() };
        let joints = tree.bodies.iter().enumerate();
        let child_joints: Vec<(usize, usize)> =
            joints.filter_map(|(i, b)| b.joint.as_ref().map(|j| (i, j.dof))).collect();
        let mut columns = vec![0; dofs];
        for &(body, dof) in &child_joints {
            columns[dof] = bodies.column(body);
        }
        let mut engine = Self {
            bodies,
            mass_kg: of(&|i| i.mass_kg),
            inertia: inertials
                .iter()
                .map(|i| i.as_ref().map_or_else(Matrix3::zeros, |i| i.inertia))
                .collect(),
            com: inertials.iter().map(|i| i.as_ref().map_or_else(Point3::origin, |i| i.com)).collect(),
            gravity,
            columns,
            q: vec![0.0; dofs],
            rail_m: 0.0,
            previous: DVector::zeros(n),
            current: DVector::zeros(n),
            speed: DVector::zeros(n),
            states: vec![still; tree.bodies.len()],
            rail,
            axes: tree.bodies.iter().map(|b| b.joint.as_ref().map_or(Vector3::x(), |j| *j.axis)).collect(),
            child_joints,
        };
        engine.read_state();
        engine
    }

    /// Number of generalised coordinates: the joints and the rail.
    pub fn coordinates(&self) -> usize {
        self.current.len()
    }

    /// Index in generalised vectors of a joint's degree of freedom.
    pub fn column(&self, dof: usize) -> usize {
        self.columns[dof]
    }

    /// Index in generalised vectors of the rail, if there is one.
    pub fn rail_column(&self) -> Option<usize> {
        self.rail.then_some(0)
    }

    /// Moves the joints to `q` and the carriage to `rail_m` over where it was built, and gives the generalised velocity
    /// `now`, with `before` as that of the step before (both in the engine's order): see the module's text on the leapfrog.
    pub fn set_state(&mut self, q: &[f64], rail_m: f64, now: &DVector<f64>, before: &DVector<f64>) {
        let mut displacement = vec![0.0; self.coordinates()];
        if let Some(column) = self.rail_column() {
            displacement[column] = rail_m - self.rail_m;
        }
        for (dof, &column) in self.columns.iter().enumerate() {
            displacement[column] = q[dof] - self.q[dof];
        }
        self.bodies.displace(&displacement, now);
        self.q.copy_from_slice(q);
        self.previous.copy_from(before);
        self.read_state();
    }

    /// Sets the inertia added to a joint, kg m^2.
    pub fn set_armature(&mut self, dof: usize, inertia: f64) {
        self.bodies.set_armature(self.columns[dof], inertia);
    }

    /// Forgets all forces and torques.
    pub fn clear_forces(&mut self) {
        self.bodies.clear_forces();
    }

    /// Adds a force, N, at a world point, m.
    pub fn add_force(&mut self, body: usize, force: &Vector3<f64>, point: &Point3<f64>) {
        self.bodies.add_force(body, force, point);
    }

    /// Adds a torque, N m, world frame.
    pub fn add_torque(&mut self, body: usize, torque: &Vector3<f64>) {
        self.bodies.add_torque(body, torque);
    }

    /// Adds the effort of a joint, N m about or N along its axis: on the body, and back on its parent.
    pub fn add_joint_effort(&mut self, body: usize, parent: usize, slides: bool, effort: f64) {
        let along = self.joint_axis(body) * effort;
        if slides {
            let at = Point3::from(self.states[body].pose.translation.vector);
            self.add_force(body, &along, &at);
            self.add_force(parent, &-along, &at);
        } else {
            self.add_torque(body, &along);
            self.add_torque(parent, &-along);
        }
    }

    /// One step with the forces that were added.
    pub fn step(&mut self) {
        self.bodies.step(&self.speed);
        std::mem::swap(&mut self.previous, &mut self.current);
        self.read_state();
    }

    /// A step of the bodies and nothing else, for a benchmark.
    pub fn step_bare(&mut self) {
        self.bodies.step(&self.speed);
    }

    /// Takes positions, poses and velocities from the bodies.
    fn read_state(&mut self) {
        self.bodies.velocity(&mut self.current);
        for &(body, dof) in &self.child_joints {
            self.q[dof] = self.bodies.position(body);
        }
        if self.rail {
            self.rail_m = self.bodies.position(0);
        }
        for (i, state) in self.states.iter_mut().enumerate() {
            state.pose = self.bodies.pose(i);
            state.com = state.pose * self.com[i];
        }
        self.read_twists();
    }

    /// Velocities at the time of the poses.
    fn read_twists(&mut self) {
        let velocities = self.current.iter().zip(&self.previous);
        self.speed
            .iter_mut()
            .zip(velocities)
            .for_each(|(speed, (v, before))| *speed = 1.5 * v - 0.5 * before);
        for (i, state) in self.states.iter_mut().enumerate() {
            let j = self.bodies.jacobian(i);
            let mut twist = [0.0; 6];
            for column in 0..j.ncols() {
                let v = self.speed[column];
                for (row, t) in twist.iter_mut().enumerate() {
                    *t += j[(row, column)] * v;
                }
            }
            state.twist = Twist {
                linear: Vector3::new(twist[0], twist[1], twist[2]),
                angular: Vector3::new(twist[3], twist[4], twist[5]),
            };
        }
    }

    /// Velocity of a joint extrapolated to the time of the poses, rad/s or m/s.
    pub fn joint_velocity(&self, dof: usize) -> f64 {
        self.speed[self.columns[dof]]
    }

    /// Generalised velocity half a step before the poses, in the engine's order.
    pub fn velocity(&self) -> &DVector<f64> {
        &self.current
    }

    /// The Jacobian of a body: six rows (velocity of the centre of mass, angular velocity).
    pub fn jacobian(&self, body: usize) -> &Jacobian {
        self.bodies.jacobian(body)
    }

    /// The gradient with respect to the generalised coordinates of a length that a unit force along
    /// `direction` between two points would work on: `d . (v_2 - v_1)` for each unit velocity.
    pub fn length_gradient(
        &self,
        (body_1, point_1): (usize, &Point3<f64>),
        (body_2, point_2): (usize, &Point3<f64>),
        direction: &Vector3<f64>,
        out: &mut [f64],
    ) {
        let from = self.along(body_1, point_1, direction);
        let to = self.along(body_2, point_2, direction);
        for (column, value) in out.iter_mut().enumerate() {
            *value = to(column) - from(column);
        }
    }

    /// How a body's point moves along a direction per unit of a coordinate, by its column.
    pub fn along(
        &self,
        body: usize,
        point: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> impl Fn(usize) -> f64 + '_ {
        let (j, u) = (self.jacobian(body), *direction);
        let arm = (point - self.states[body].com).cross(&u);
        move |column| {
            u.x * j[(0, column)]
                + u.y * j[(1, column)]
                + u.z * j[(2, column)]
                + arm.x * j[(3, column)]
                + arm.y * j[(4, column)]
                + arm.z * j[(5, column)]
        }
    }

    /// World axis of the joint that carries a body.
    pub fn joint_axis(&self, body: usize) -> Vector3<f64> {
        self.states[body].pose * self.axes[body]
    }

    /// Everything in the engine that would make forces of its own.
    #[cfg(test)]
    pub fn own_forces(&self) -> Vec<String> {
        self.bodies.own_forces()
    }
}
