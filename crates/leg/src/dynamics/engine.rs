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

use super::tree::Tree;
use crate::robot::Inertial;
use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3,
};
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

/// Axis of the multibody joints' free direction in their frame.
const JOINT_AXIS: Vector3<f64> = Vector3::new(1.0, 0.0, 0.0);

impl Engine {
    /// Builds the tree with the base's frame at `world_from_base`, all joints at zero and at rest.
    pub fn new(
        tree: &Tree,
        base: Base,
        world_from_base: &Isometry3<f64>,
        dofs: usize,
        gravity: f64,
        step_s: f64,
    ) -> Self {
        let mut bodies = RigidBodySet::new();
        let mut multibody_joints = MultibodyJointSet::new();
        let mut handles = Vec::with_capacity(tree.bodies.len());
        let rail = matches!(base, Base::Rail { .. });
        let mut inertials: Vec<Option<Inertial>> = tree.bodies.iter().map(|b| b.inertial.clone()).collect();
        match base {
            Base::Fixed => {
                let fixed = RigidBodyBuilder::fixed().pose(to_pose(world_from_base)).build();
                handles.push(bodies.insert(fixed));
            }
            Base::Rail { carriage_mass_kg } => {
                let world = bodies.insert(RigidBodyBuilder::fixed().build());
                let own = inertials[0].clone();
                // On a rail only the mass of the base counts; its inertia keeps the engine's matrices regular.
                let base = own.unwrap_or(Inertial {
                    mass_kg: 0.0,
                    com: Point3::origin(),
                    inertia: Matrix3::zeros(),
                });
                let base = Inertial {
                    mass_kg: base.mass_kg + carriage_mass_kg,
                    com: base.com,
                    inertia: base.inertia + Matrix3::identity(),
                };
                handles.push(bodies.insert(dynamic(&base, world_from_base)));
                inertials[0] = Some(base);
                let upright = rotation_to(&Vector3::z());
                let mut joint = GenericJoint::new(JointAxesMask::LOCKED_PRISMATIC_AXES);
                joint.local_frame1 = to_pose(&Isometry3::from_parts(world_from_base.translation, upright));
                joint.local_frame2 = to_pose(&Isometry3::from_parts(
                    Translation3::identity(),
                    world_from_base.rotation.inverse() * upright,
                ));
                multibody_joints.insert(world, handles[0], joint, false);
            }
        }
        let mut poses = vec![*world_from_base];
        let mut child_joints = Vec::new();
        for (i, body) in tree.bodies.iter().enumerate().skip(1) {
            let (Some(joint), Some(inertial)) = (&body.joint, &body.inertial) else { continue };
            let pose = poses[joint.parent] * joint.origin;
            poses.push(pose);
            handles.push(bodies.insert(dynamic(inertial, &pose)));
            let turn = rotation_to(&joint.axis);
            let locked = if joint.slides {
                JointAxesMask::LOCKED_PRISMATIC_AXES
            } else {
                JointAxesMask::LOCKED_REVOLUTE_AXES
            };
            let mut data = GenericJoint::new(locked);
            data.local_frame1 = to_pose(&(joint.origin * turn));
            data.local_frame2 = to_pose(&Isometry3::from_parts(Translation3::identity(), turn));
            multibody_joints.insert(handles[joint.parent], handles[i], data, false);
            child_joints.push((i, joint.dof, joint.axis.into_inner()));
        }
        let gravity = Vector::new(0.0, 0.0, gravity);
        let parameters = IntegrationParameters {
            num_solver_iterations: 1,
            num_internal_stabilization_iterations: 0,
            max_ccd_substeps: 0,
            contact_recycling: false,
            dt: step_s,
            ..IntegrationParameters::default()
        };
        // Every leg has at least one joint or a rail: see `Leg::new`.
        let id = *multibody_joints.rigid_body_link(handles[handles.len() - 1]).expect("a joint was inserted");
        let link_ids: Vec<usize> =
            handles.iter().map(|h| multibody_joints.rigid_body_link(*h).map_or(0, |l| l.id)).collect();
        let body_count = handles.len();
        let still = BodyState { pose: Isometry3::identity(), com: Point3::origin(), twist: Twist::default() };
        let of = |f: &dyn Fn(&Inertial) -> f64| inertials.iter().map(|i| i.as_ref().map_or(0.0, f)).collect();
        let mut engine = Self {
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies,
            colliders: ColliderSet::new(),
            impulse_joints: ImpulseJointSet::new(),
            multibody_joints,
            soft_bodies: SoftBodySet::new(),
            ccd: CCDSolver::new(),
            parameters,
            gravity,
            handles,
            link_ids,
            multibody: id.multibody,
            mass_kg: of(&|i| i.mass_kg),
            inertia: inertials
                .iter()
                .map(|i| i.as_ref().map_or_else(Matrix3::zeros, |i| i.inertia))
                .collect(),
            com: inertials.iter().map(|i| i.as_ref().map_or_else(Point3::origin, |i| i.com)).collect(),
            columns: vec![0; dofs],
            q: vec![0.0; dofs],
            rail_m: 0.0,
            previous: DVector::zeros(0),
            current: DVector::zeros(0),
            states: vec![still; body_count],
            rail,
            axes: tree.bodies.iter().map(|b| b.joint.as_ref().map_or(JOINT_AXIS, |j| *j.axis)).collect(),
            child_joints,
        };
        // Before the first step the engine does not know where the centres of mass are: a step of no
        // duration tells it, without moving anything.
        engine.parameters.dt = 0.0;
        engine.run_pipeline();
        engine.parameters.dt = step_s;
        let multibody =
            engine.multibody_joints.get_multibody_mut(engine.multibody).expect("it was built above");
        multibody.damping_mut().fill(0.0);
        let n = multibody.ndofs();
        for &(body, dof, _) in &engine.child_joints {
            let link = multibody.link(engine.link_ids[body]).expect("it was built above");
            engine.columns[dof] = link.assembly_id();
        }
        engine.previous = DVector::zeros(n);
        engine.current = DVector::zeros(n);
        engine.read_state();
        engine
    }

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

    /// Moves the joints to `q` (and the carriage back to where it was built) and gives the generalised velocity `now`, with `before` as that of the step
    /// before (both in the engine's order): see the module's text on the leapfrog.
    pub fn set_state(&mut self, q: &[f64], now: &DVector<f64>, before: &DVector<f64>) {
        let mut displacement = vec![0.0; self.coordinates()];
        if let Some(column) = self.rail_column() {
            displacement[column] = -self.rail_m;
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

    /// The mass matrix of the bodies at the present poses, in the engine's order (without armature): for
    /// energies at the recorded samples only.
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let n = self.coordinates();
        let mut mass = DMatrix::zeros(n, n);
        for (i, state) in self.states.iter().enumerate() {
            let j = self.jacobian(i);
            let r = state.pose.rotation.to_rotation_matrix();
            let turned = r * self.inertia[i] * r.transpose();
            let (linear, angular) = (j.fixed_rows::<3>(0), j.fixed_rows::<3>(3));
            mass += linear.transpose() * linear * self.mass_kg[i] + angular.transpose() * turned * angular;
        }
        mass
    }

    /// Potential energy of the bodies, zero at world height 0, J.
    pub fn potential_energy(&self) -> f64 {
        self.states.iter().zip(&self.mass_kg).map(|(s, m)| -m * self.gravity.z * s.com.z).sum()
    }

    /// Generalised force of gravity at the present poses, in the engine's order.
    pub fn gravity_forces(&self) -> DVector<f64> {
        let mut forces = DVector::zeros(self.coordinates());
        for i in 0..self.states.len() {
            let j = self.jacobian(i);
            for column in 0..j.ncols() {
                forces[column] += j[(2, column)] * self.mass_kg[i] * self.gravity.z;
            }
        }
        forces
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
        out.fill(0.0);
        for (sign, body, point) in [(-1.0, body_1, point_1), (1.0, body_2, point_2)] {
            let j = self.jacobian(body);
            let arm = (point - self.states[body].com).cross(direction);
            for (column, value) in out.iter_mut().enumerate() {
                *value += sign
                    * (direction.x * j[(0, column)]
                        + direction.y * j[(1, column)]
                        + direction.z * j[(2, column)]
                        + arm.x * j[(3, column)]
                        + arm.y * j[(4, column)]
                        + arm.z * j[(5, column)]);
            }
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

fn dynamic(inertial: &Inertial, pose: &Isometry3<f64>) -> RigidBody {
    let m = &inertial.inertia;
    let columns = |c: usize| Vector::new(m[(0, c)], m[(1, c)], m[(2, c)]);
    let properties = MassProperties::with_inertia_matrix(
        to_vector(&inertial.com.coords),
        inertial.mass_kg,
        rapier3d_f64::math::Matrix::from_cols(columns(0), columns(1), columns(2)),
    );
    RigidBodyBuilder::dynamic()
        .pose(to_pose(pose))
        .additional_mass_properties(properties)
        .can_sleep(false)
        .build()
}

/// A rotation that takes x to `axis`.
fn rotation_to(axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&JOINT_AXIS, axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI))
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
