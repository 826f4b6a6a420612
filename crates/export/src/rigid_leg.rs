//! A leg as links and joints with what its actuators are at each joint.

use crate::joint_note::note;
use crate::leg::LegDescription;
use crate::rigid::{JointDrive, Reach, RigidJoint, RigidRobot, driven, link, moving_friction, speed_limit};
use crate::term::Term;
use crate::text::num;
use crate::{ExportError, Note};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use sealegs_leg::robot::{JointKind, JointLimits, Link};

impl RigidRobot {
    /// # Errors
    ///
    /// [`ExportError::Leg`] where a linkage does not close at the start.
    pub fn of_leg(leg: &LegDescription, reach: Reach) -> Result<Self, ExportError> {
        let robot = &leg.robot;
        let arms = robot.moment_arms(&leg.start_q)?;
        let mut notes = vec![
            Note::lost(
                "springs",
                "a tree of joints cannot close the loops of the actuators: rigid, with the rotors at the joints",
            ),
            Note::near(
                "actuators",
                "inertia, damping, friction and effort by the moment arms at the start, each joint by itself",
            ),
        ];
        let root = if leg.rail { 1 } else { 0 };
        let mut links = robot.links.clone();
        let mut joints = Vec::new();
        if leg.rail {
            links.insert(0, link("rail", 0.0, Point3::origin(), 0.0));
            joints.push(RigidJoint {
                name: "rail".to_owned(),
                kind: JointKind::Prismatic,
                parent: 0,
                child: 1,
                origin: leg.world_from_base,
                axis: Vector3::z(),
                limits: JointLimits::NONE,
                damping: 0.0,
                friction: 0.0,
                drive: None,
            });
        }
        for joint in &robot.joints {
            let mut made = RigidJoint {
                name: joint.name.clone(),
                kind: joint.kind,
                parent: joint.parent + root,
                child: joint.child + root,
                origin: joint.origin,
                axis: joint.axis.into_inner(),
                limits: joint.limits,
                damping: joint.damping,
                friction: joint.friction,
                drive: None,
            };
            if let Some(dof) = joint.dof {
                bring(leg, dof, &arms, reach, &mut made, &mut links);
            }
            joints.push(made);
        }
        for actuator in &leg.actuators {
            for (id, term) in actuator.drive.terms() {
                notes.push(note(&format!("{}/{id}", actuator.placement.name), term, reach, true));
            }
        }
        for (id, term) in &leg.others {
            let what = id.as_str();
            notes.push(match term {
                Term::OutputFriction { .. } => Note::held(what, "friction of the joint"),
                _ if id.ends_with("/link-mass") => Note::held(what, "inertial of the link"),
                _ => Note::lost(what, "an effect of the ground, a stop or a sensor"),
            });
        }
        if leg.ground.is_some() {
            notes.push(Note::lost("ground", "the contact's law is the simulator's own"));
        }
        notes.push(Note::lost("start", format!("joints at the start, rad: {:?}", leg.start_q)));
        let height_m = leg.world_from_base.translation.z;
        // The rail's joint and the pose of SDF's root have it.
        if !leg.rail && reach != Reach::Spring && height_m != 0.0 {
            notes.push(Note::lost("base", format!("fixed at a height of {} m", num(height_m))));
        }
        Ok(Self {
            name: robot.name.clone(),
            title: leg.name.clone(),
            links,
            joints,
            root: if leg.rail { Isometry3::identity() } else { leg.world_from_base },
            notes,
        })
    }
}

/// Brings to one joint what its actuators are, through their moment arms.
fn bring(
    leg: &LegDescription,
    dof: usize,
    arms: &nalgebra::DMatrix<f64>,
    reach: Reach,
    joint: &mut RigidJoint,
    links: &mut [Link],
) {
    let mut drive = JointDrive { friction_at_rest: joint.friction, ..JointDrive::default() };
    let (mut effort, mut any) = (0.0, false);
    for actuator in &leg.actuators {
        let Some(row) = leg.robot.actuator_index(&actuator.placement.name) else { continue };
        let arm = arms[(row, dof)].abs();
        if arm == 0.0 {
            continue;
        }
        any = true;
        let bench = &actuator.drive;
        let own = driven(bench, arm, bench.inertia * arm * arm);
        drive.armature += own.armature;
        drive.friction_at_rest += own.friction_at_rest;
        drive.delay_s = drive.delay_s.max(own.delay_s);
        drive.voltage = own.voltage.or(drive.voltage);
        joint.damping += bench.damping * arm * arm;
        joint.friction += moving_friction(bench) * arm;
        let limit = bench.command_limit().unwrap_or(f64::INFINITY).min(actuator.current_limit_a);
        effort += limit * bench.gain.abs() * arm;
    }
    if !any {
        return;
    }
    joint.limits.effort = joint.limits.effort.min(effort);
    joint.limits.velocity = joint.limits.velocity.min(speed_limit(&drive));
    if reach != Reach::Armature
        && let Some(inertial) = links[joint.child].inertial.as_mut()
    {
        // About the joint's axis only; a third about the others keeps the body possible.
        let along = joint.axis * joint.axis.transpose();
        inertial.inertia += (along + (Matrix3::identity() - along) * 0.5) * drive.armature;
        drive.armature = 0.0;
    }
    joint.drive = Some(drive);
}
