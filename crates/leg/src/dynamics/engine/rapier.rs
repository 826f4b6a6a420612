//! The bodies in Rapier.
//!
//! Reduced coordinates (multibody joints) in f64, one solver iteration a step because the default four are
//! substeps over which our forces would be held, no sleeping, no colliders, no continuous collision
//! detection. The engine's joint damping is 0.1 by default and is set to zero, as are its motors, springs,
//! limits and friction; its armature is zero except where the coupling of a linkage drive sets it. Velocities are read
//! from the engine's own body Jacobians because the bodies' velocities lag.

use super::{Bodies, Jacobian};
use crate::dynamics::tree::Tree;
use crate::robot::Inertial;
use nalgebra::{
    DVector, Isometry3, Matrix3, Point3, Quaternion, Rotation3, SymmetricEigen, Translation3, UnitQuaternion,
    Vector3,
};
use rapier3d_f64::math::{Pose, Rotation, Vector};
use rapier3d_f64::prelude::*;

/// Axis of the multibody joints' free direction in their frame.
const JOINT_AXIS: Vector3<f64> = Vector3::new(1.0, 0.0, 0.0);

/// The engine with one tree of bodies in it.
pub(super) struct Rapier {
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
}

impl Rapier {
    /// Builds the tree; `inertials` become those that the engine will really use.
    pub fn new(
        tree: &Tree,
        inertials: &mut [Option<Inertial>],
        rail: bool,
        world_from_base: &Isometry3<f64>,
        gravity: f64,
        step_s: f64,
    ) -> Self {
        let mut bodies = RigidBodySet::new();
        let mut multibody_joints = MultibodyJointSet::new();
        let mut handles = Vec::with_capacity(tree.bodies.len());
        match inertials[0].as_ref().filter(|_| rail) {
            None => {
                let fixed = RigidBodyBuilder::fixed().pose(to_pose(world_from_base)).build();
                handles.push(bodies.insert(fixed));
            }
            Some(base) => {
                let world = bodies.insert(RigidBodyBuilder::fixed().build());
                handles.push(bodies.insert(dynamic(base, world_from_base)));
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
        }
        let parameters = IntegrationParameters {
            num_solver_iterations: 1,
            num_internal_stabilization_iterations: 0,
            max_ccd_substeps: 0,
            contact_recycling: false,
            // Before the first step the engine does not know where the centres of mass are: a step of no
            // duration tells it, without moving anything.
            dt: 0.0,
            ..IntegrationParameters::default()
        };
        // Every leg has at least one joint or a rail: see `Parts::new`.
        let id = *multibody_joints.rigid_body_link(handles[handles.len() - 1]).expect("a joint was inserted");
        let link_ids: Vec<usize> =
            handles.iter().map(|h| multibody_joints.rigid_body_link(*h).map_or(0, |l| l.id)).collect();
        let mut rapier = Self {
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
            gravity: Vector::new(0.0, 0.0, gravity),
            handles,
            link_ids,
            multibody: id.multibody,
        };
        rapier.run_pipeline();
        rapier.parameters.dt = step_s;
        for (handle, inertial) in rapier.handles.iter().zip(inertials) {
            let body = &rapier.bodies[*handle];
            if let Some(inertial) = inertial.as_mut().filter(|_| body.is_dynamic()) {
                let own = body.mass_properties().local_mprops.reconstruct_inertia_matrix();
                inertial.inertia = Matrix3::from_column_slice(&own.to_cols_array());
            }
        }
        rapier.multibody_mut().damping_mut().fill(0.0);
        rapier
    }

    /// Number of generalised coordinates.
    pub fn coordinates(&self) -> usize {
        self.multibody().ndofs()
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

    fn link(&self, body: usize) -> &MultibodyLink {
        self.multibody().link(self.link_ids[body]).expect("it was built")
    }
}

impl Bodies for Rapier {
    /// They persist in the engine, and a force at a point leaves a torque.
    fn clear_forces(&mut self) {
        for handle in &self.handles {
            let body = &mut self.bodies[*handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
    }

    fn add_force(&mut self, body: usize, force: &Vector3<f64>, point: &Point3<f64>) {
        self.bodies[self.handles[body]].add_force_at_point(to_vector(force), to_vector(&point.coords), false);
    }

    fn add_torque(&mut self, body: usize, torque: &Vector3<f64>) {
        self.bodies[self.handles[body]].add_torque(to_vector(torque), false);
    }

    fn set_armature(&mut self, column: usize, inertia: f64) {
        self.multibody_mut().armature_mut()[column] = inertia;
    }

    fn displace(&mut self, displacement: &[f64], velocity: &DVector<f64>) {
        let Self { multibody_joints, bodies, multibody, .. } = self;
        let multibody = multibody_joints.get_multibody_mut_internal(*multibody).expect("it is never removed");
        multibody.apply_displacements(displacement);
        multibody.generalized_velocity_mut().copy_from(velocity);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
    }

    fn step(&mut self, _speed: &DVector<f64>) {
        self.run_pipeline();
    }

    fn velocity(&self, out: &mut DVector<f64>) {
        out.copy_from(&self.multibody().generalized_velocity());
    }

    fn column(&self, body: usize) -> usize {
        self.link(body).assembly_id()
    }

    fn position(&self, body: usize) -> f64 {
        let joint = self.link(body).joint();
        joint.coords()[if joint.data.locked_axes.contains(JointAxesMask::LIN_X) { 3 } else { 0 }]
    }

    fn pose(&self, body: usize) -> Isometry3<f64> {
        from_pose(self.link(body).local_to_world())
    }

    fn jacobian(&self, body: usize) -> &Jacobian {
        self.multibody().body_jacobian(self.link_ids[body])
    }

    #[cfg(test)]
    fn own_forces(&self) -> Vec<String> {
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

/// A body with these mass properties. Its principal axes are found here: the engine's own way to them takes moments
/// that differ by less than about 1e-5 kg m^2 for equal (an absolute tolerance on their fourth power), and a finger
/// or a light shank would get those of another body.
fn dynamic(inertial: &Inertial, pose: &Isometry3<f64>) -> RigidBody {
    let SymmetricEigen { eigenvalues: moments, eigenvectors: mut axes } =
        SymmetricEigen::new(inertial.inertia);
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)).coords;
    let properties = MassProperties::with_principal_inertia_frame(
        to_vector(&inertial.com.coords),
        inertial.mass_kg,
        to_vector(&moments),
        Rotation::from_xyzw(turn.x, turn.y, turn.z, turn.w),
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
