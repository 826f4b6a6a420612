//! Building the rigid bodies of a leg in the physics engine.

use super::{Base, BodyState, Engine, Twist, to_pose, to_vector};
use crate::dynamics::tree::Tree;
use crate::robot::Inertial;
use nalgebra::{
    DVector, Isometry3, Matrix3, Point3, Rotation3, SymmetricEigen, Translation3, UnitQuaternion, Vector3,
};
use rapier3d_f64::math::{Rotation, Vector};
use rapier3d_f64::prelude::*;

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
        // The inertias that it will really use, for the mass matrix.
        for (handle, inertia) in engine.handles.iter().zip(&mut engine.inertia) {
            let body = &engine.bodies[*handle];
            if body.is_dynamic() {
                let own = body.mass_properties().local_mprops.reconstruct_inertia_matrix();
                *inertia = Matrix3::from_column_slice(&own.to_cols_array());
            }
        }
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
