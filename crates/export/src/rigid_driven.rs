//! Drives at joints as links and joints with losses and limits, their springs rigid.

use crate::Note;
use crate::driven::{Command, DrivenJoint, DrivenRobot, Start};
use crate::joint_note::{note, of_the_robot};
use crate::rigid::{Reach, RigidJoint, RigidRobot, driven, moving_friction, speed_limit};
use crate::term::Term;
use crate::text::{num, told};
use nalgebra::{Isometry3, Matrix3, Point3};
use sealegs_leg::robot::{Inertial, Joint, JointKind, Link};

/// Share of a rotor's inertia that a link without a mass of its own gets: engines admit no massless link that moves.
const LEAST_SHARE: f64 = 1e-6;

impl RigidRobot {
    pub fn of_driven(robot: &DrivenRobot, reach: Reach) -> Self {
        let mut notes = vec![Note::lost("sensors", "they are the simulator's own")];
        if reach != Reach::Armature {
            notes.push(Note::near("rotors", "inertia of the links that they move, which turns with these"));
        }
        let mut links = robot.robot.links.clone();
        let mut joints = Vec::new();
        for joint in &robot.robot.joints {
            let mut made = RigidJoint {
                name: joint.name.clone(),
                kind: joint.kind,
                parent: joint.parent,
                child: joint.child,
                origin: joint.origin,
                axis: joint.axis.into_inner(),
                limits: joint.limits,
                damping: 0.0,
                friction: 0.0,
                drive: None,
            };
            if let Some(driven) = joint.dof.map(|dof| &robot.joints[dof]) {
                command(driven, reach, &mut notes);
                bring(driven, joint, reach, &mut made, &mut links[joint.child]);
                for (id, term) in driven.drive.terms() {
                    notes.push(at_joint(&robot.id_of(driven, id), term, driven, reach));
                }
            }
            joints.push(made);
        }
        if let Some((name, start)) = robot.starts.first() {
            let of = |(joint, at): (&DrivenJoint, &Start)| {
                format!("{} at {}, speed {}", joint.name, told(at.position), told(at.speed))
            };
            let of: Vec<String> = robot.joints.iter().zip(start).map(of).collect();
            notes.push(Note::lost(format!("start of the run {name}"), of.join("; ")));
        }
        for joint in robot.joints.iter().filter(|j| j.sprung) {
            let how = format!("rotor and link move as one; it has {} N m/rad", told(joint.drive.stiffness));
            notes.push(Note::lost(format!("spring of {}", joint.name), how));
        }
        notes.extend(of_the_robot(robot));
        Self {
            name: robot.name.clone(),
            title: robot.title.clone(),
            links,
            joints,
            root: Isometry3::identity(),
            notes,
        }
    }
}

/// What becomes of a drive's command.
fn command(joint: &DrivenJoint, reach: Reach, notes: &mut Vec<Note>) {
    let (drive, what) = (&joint.drive, format!("command {}", joint.drive.input));
    let gain = num(drive.gain * joint.arm);
    notes.push(match &joint.command {
        Command::Effort if drive.gain * joint.arm == 1.0 => Note::held(what, format!("effort of the joint {}", joint.name)),
        Command::Effort => {
            Note::near(what, format!("effort of the joint {}: {gain} times the command", joint.name))
        }
        Command::Voltage(_) => {
            Note::near(what, format!("effort of the joint {}: {gain} times the voltage; the back-EMF is its damping", joint.name))
        }
        Command::Goal(..) if reach == Reach::Armature => {
            Note::held(what, "stiffness and damping of the actuator's configuration; back-EMF as viscous_friction")
        }
        Command::Impedance(_) if reach == Reach::Armature => {
            Note::held(what, "stiffness, damping and effort_limit of the actuator's configuration")
        }
        Command::Impedance(servo) => {
            let [stiffness, damping] = [servo.proportional, servo.derivative].map(|k| num(k * drive.gain * joint.arm * joint.arm));
            Note::lost(what, format!("the loop is yours to close: {stiffness} N m per rad of error, {damping} N m s per rad"))
        }
        Command::Goal(_, servo) => {
            let per_rad = num(gain_of(joint, servo.proportional * servo.per_given()) * joint.arm);
            Note::lost(what, format!("the loop is yours to close: {per_rad} N m per rad of error; the back-EMF is the joint's damping"))
        }
    });
    if drive.offset_force != 0.0 {
        notes.push(Note::lost(
            "offset of the command",
            format!("add {} to the effort", num(drive.offset_force * joint.arm)),
        ));
    }
}

/// Torque at the joint for a voltage at standstill.
fn gain_of(joint: &DrivenJoint, volts: f64) -> f64 {
    joint.winding().map_or(0.0, |(constant, resistance)| volts * constant / resistance)
}

/// Brings a drive to its joint.
fn bring(driven_joint: &DrivenJoint, joint: &Joint, reach: Reach, made: &mut RigidJoint, link: &mut Link) {
    let bench = driven_joint.at_joint();
    let mut drive = driven(&bench, 1.0, bench.inertia);
    made.damping = bench.damping;
    made.friction = moving_friction(&bench);
    let mut effort = bench.command_limit().map_or(f64::INFINITY, |limit| limit * bench.gain.abs());
    if let Some((constant, resistance)) = driven_joint.winding() {
        made.damping += constant * constant / resistance;
        effort = bench.command_limit().map_or(f64::INFINITY, |limit| limit * constant.abs());
    }
    // Torque at the joint per unit of what a loop gives.
    let looped = match &driven_joint.command {
        Command::Goal(_, servo) => Some((servo, gain_of(driven_joint, servo.per_given()))),
        Command::Impedance(servo) => Some((servo, bench.gain)),
        Command::Effort | Command::Voltage(_) => None,
    };
    if let Some((servo, per_given)) = looped {
        effort = effort.min((servo.limit * per_given).abs());
        drive.delay_s += servo.feedback_delay_s;
        if reach == Reach::Armature {
            // The loop is one of the drive's own travel.
            let at_joint = |per_travel: f64| per_travel * per_given * driven_joint.arm;
            (drive.spring, drive.derivative) = (at_joint(servo.proportional), at_joint(servo.derivative));
        }
    }
    made.limits.effort = joint.limits.effort.min(effort);
    made.limits.velocity = joint.limits.velocity.min(speed_limit(&drive));
    let along = made.axis * made.axis.transpose();
    let share = if reach == Reach::Armature { LEAST_SHARE } else { 1.0 };
    let rotor = (along + (Matrix3::identity() - along) * 0.5) * drive.armature;
    let slides = joint.kind == JointKind::Prismatic;
    match link.inertial.as_mut() {
        _ if slides => slide(link, share * drive.armature, reach),
        Some(inertial) if reach != Reach::Armature => inertial.inertia += rotor,
        Some(_) => {}
        None => {
            // A mass on the axis: no moment of the rotor's, no weight to speak of.
            let mass_kg = LEAST_SHARE.max(LEAST_SHARE * drive.armature);
            link.inertial = Some(Inertial { mass_kg, com: Point3::origin(), inertia: rotor * share });
        }
    }
    if reach != Reach::Armature {
        drive.armature = 0.0;
    }
    made.drive = Some(drive);
}

/// The rotor of a sliding joint as mass of its link: what has no mass of its own gets it at least in part.
fn slide(link: &mut Link, mass_kg: f64, reach: Reach) {
    let at = |com| Inertial { mass_kg, com, inertia: Matrix3::identity() * 1e-4 * mass_kg };
    link.inertial = Some(match link.inertial.take() {
        Some(own) if reach == Reach::Armature => own,
        Some(own) => {
            let at = at(own.com);
            own.joined_with(&at)
        }
        None => at(Point3::origin()),
    });
}

/// What becomes of an effect at a drive without a spring.
fn at_joint(id: &str, term: &Term, joint: &DrivenJoint, reach: Reach) -> Note {
    match term {
        Term::OutputOffset { force } => Note::lost(id, format!("add {} to the effort", num(*force))),
        Term::Load => Note::held(id, "inertial of the link"),
        Term::CommandLimit { .. } if joint.winding().is_some() => Note::held(id, "effort limit of the joint"),
        _ => note(id, term, reach, true),
    }
}
