//! The rigid bodies in the physics engine, and nothing but rigid bodies: every force is ours.
//!
//! Reduced coordinates (multibody joints) in f64, one solver iteration a step because the default four are
//! substeps over which our forces would be held, no sleeping, no colliders, no continuous collision
//! detection. The engine's joint damping is 0.1 by default and is set to zero, as are its motors, springs,
//! limits and friction; its armature is zero except where the coupling of a linkage drive sets it.
//!
//! # Leapfrog
//!
//! The engine advances `v += a dt; x += v dt` with `a` from the pose before the step. Read as a leapfrog,
//! its velocity before step `n` belongs to the middle of the step before, `t_n - dt/2`, and the scheme is of
//! second order if velocity-dependent forces are evaluated at `v + (v - v_prev)/2`: the twists of [`BodyState`] are
//! those velocities, read from the engine's own body Jacobians because the bodies' velocities lag.

mod build;
mod weight;

use nalgebra::{DVector, Isometry3, Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d_f64::math::{Pose, Rotation, Vector};
use rapier3d_f64::prelude::*;

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

/// The engine with one tree of bodies in it.
pub(crate) struct Engine {
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd: CCDSolver,
    parameters: IntegrationParameters,
    gravity: Vector,
    handles: Vec<RigidBodyHandle>,
    /// Index of each body in the multibody.
    link_ids: Vec<usize>,
    multibody: MultibodyIndex,
    mass_kg: Vec<f64>,
    inertia: Vec<Matrix3<f64>>,
    com: Vec<Point3<f64>>,
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
    /// Poses and extrapolated velocities.
    pub states: Vec<BodyState>,
    rail: bool,
    /// Body, degree of freedom and axis of each joint.
    child_joints: Vec<(usize, usize, Vector3<f64>)>,
    /// Axis of the joint that carries each body, in its frame.
    axes: Vec<Vector3<f64>>,
}

impl Engine {
    fn run_pipeline(&mut self) {
        self.pipeline.step(
            self.gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd,
            &(),
            &(),
        );
    }

    fn multibody(&self) -> &Multibody {
        self.multibody_joints.get_multibody(self.multibody).expect("it is never removed")
    }

    fn multibody_mut(&mut self) -> &mut Multibody {
        self.multibody_joints.get_multibody_mut_internal(self.multibody).expect("it is never removed")
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
        let Self { multibody_joints, bodies, multibody, .. } = self;
        let multibody = multibody_joints.get_multibody_mut_internal(*multibody).expect("it is never removed");
        multibody.apply_displacements(&displacement);
        multibody.generalized_velocity_mut().copy_from(now);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
        self.q.copy_from_slice(q);
        self.read_state();
        self.previous.copy_from(before);
        self.read_twists();
    }

    /// Sets the inertia added to a joint, kg m^2.
    pub fn set_armature(&mut self, dof: usize, inertia: f64) {
        let column = self.columns[dof];
        self.multibody_mut().armature_mut()[column] = inertia;
    }

    /// Forgets all forces and torques: they persist in the engine, and a force at a point leaves a torque.
    pub fn clear_forces(&mut self) {
        for handle in &self.handles {
            let body = &mut self.bodies[*handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
    }

    /// Adds a force, N, at a world point, m.
    pub fn add_force(&mut self, body: usize, force: &Vector3<f64>, point: &Point3<f64>) {
        self.bodies[self.handles[body]].add_force_at_point(to_vector(force), to_vector(&point.coords), false);
    }

    /// Adds a torque, N m, world frame.
    pub fn add_torque(&mut self, body: usize, torque: &Vector3<f64>) {
        self.bodies[self.handles[body]].add_torque(to_vector(torque), false);
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
        self.run_pipeline();
        std::mem::swap(&mut self.previous, &mut self.current);
        self.read_state();
    }

    /// A step of the engine and nothing else, for a benchmark.
    pub fn step_bare(&mut self) {
        self.run_pipeline();
    }

    /// Takes poses and velocities from the engine.
    fn read_state(&mut self) {
        let Self { multibody_joints, multibody, .. } = self;
        let multibody = multibody_joints.get_multibody(*multibody).expect("it is never removed");
        self.current.copy_from(&multibody.generalized_velocity());
        for &(body, dof, _) in &self.child_joints {
            let link = multibody.link(self.link_ids[body]).expect("it was built");
            let coords = link.joint().coords();
            let locked = link.joint().data.locked_axes;
            self.q[dof] = if locked.contains(JointAxesMask::LIN_X) { coords[3] } else { coords[0] };
        }
        if self.rail {
            self.rail_m = multibody.link(self.link_ids[0]).expect("it was built").joint().coords()[0];
        }
        for i in 0..self.states.len() {
            let link = multibody.link(self.link_ids[i]).expect("it was built");
            let pose = from_pose(link.local_to_world());
            self.states[i].com = pose * self.com[i];
            self.states[i].pose = pose;
        }
        self.read_twists();
    }

    /// Velocities at `v + (v - v_prev)/2`.
    fn read_twists(&mut self) {
        let extrapolated = |i: usize| 1.5 * self.current[i] - 0.5 * self.previous[i];
        let multibody = self.multibody_joints.get_multibody(self.multibody).expect("it is never removed");
        for (state, &id) in self.states.iter_mut().zip(&self.link_ids) {
            let j = multibody.body_jacobian(id);
            let mut twist = [0.0; 6];
            for column in 0..j.ncols() {
                let v = extrapolated(column);
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
        let column = self.columns[dof];
        1.5 * self.current[column] - 0.5 * self.previous[column]
    }

    /// Generalised velocity half a step before the poses, in the engine's order.
    pub fn velocity(&self) -> &DVector<f64> {
        &self.current
    }

    /// The engine's Jacobian of a body: six rows (velocity of the centre of mass, angular velocity).
    pub fn jacobian(&self, body: usize) -> &rapier3d_f64::math::Jacobian<f64> {
        self.multibody().body_jacobian(self.link_ids[body])
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

    /// Everything in the engine that would make forces of its own, for a test: damping, armature, friction,
    /// motors, springs, limits, colliders.
    #[cfg(test)]
    pub fn own_forces(&self) -> Vec<String> {
        let multibody = self.multibody();
        let mut found = Vec::new();
        for (name, values) in [
            ("damping", multibody.damping()),
            ("armature", multibody.armature()),
            ("friction", multibody.frictions()),
        ] {
            if values.amax() != 0.0 {
                found.push(name.to_owned());
            }
        }
        for link in multibody.links() {
            let data = &link.joint().data;
            if !data.motor_axes.is_empty() || !data.limit_axes.is_empty() {
                found.push("motor or limit".to_owned());
            }
            if (0..6).any(|axis| link.joint().spring(axis).0 != 0.0) {
                found.push("spring".to_owned());
            }
        }
        for (_, body) in self.bodies.iter() {
            if body.linear_damping() != 0.0 || body.angular_damping() != 0.0 {
                found.push("body damping".to_owned());
            }
        }
        if !self.colliders.is_empty() {
            found.push("collider".to_owned());
        }
        found
    }
}

fn to_vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn to_pose(pose: &Isometry3<f64>) -> Pose {
    let q = pose.rotation.coords;
    Pose::from_parts(to_vector(&pose.translation.vector), Rotation::from_xyzw(q.x, q.y, q.z, q.w))
}

fn from_pose(pose: &Pose) -> Isometry3<f64> {
    let (t, q) = (pose.translation, pose.rotation);
    Isometry3::from_parts(
        Translation3::new(t.x, t.y, t.z),
        UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}
