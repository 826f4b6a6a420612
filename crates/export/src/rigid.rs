//! A robot of links and joints with losses and limits: what URDF, SDF and Isaac Lab can say.
//!
//! A series elastic actuator lies beside the joints, between two links; these formats have drives at joints only. On a
//! locked bench the joint is the spring's deflection. Everywhere else the spring is taken as rigid and the actuator's
//! inertia, damping, friction and limits are brought to the joints through the moment arms at the start.

use crate::Note;
use crate::bench::{BenchDescription, Output};
use crate::joint_note::note;
use crate::term::Term;
use crate::text::num;
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use sealegs_actuator::Kind;
use sealegs_leg::robot::{Inertial, JointKind, JointLimits, Link};

/// How far a format reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// Bodies, losses and limits: a rotor is inertia of a body.
    Body,
    /// A joint has a spring, too.
    Spring,
    /// A joint has an armature, a drive with stiffness, a delay and a torque-speed curve, too.
    Armature,
}

/// What drives a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointDrive {
    /// Stiffness of a spring about zero.
    pub spring: f64,
    /// Torque per speed that a drive's own loop takes.
    pub derivative: f64,
    /// Inertia of rotors, brought to the joint.
    pub armature: f64,
    /// Friction at rest, where it is greater than in motion.
    pub friction_at_rest: f64,
    pub delay_s: f64,
    /// Effort at rest and speed at no load under a voltage.
    pub voltage: Option<(f64, f64)>,
}

/// A joint.
#[derive(Debug, Clone)]
pub struct RigidJoint {
    pub name: String,
    pub kind: JointKind,
    pub parent: usize,
    pub child: usize,
    pub origin: Isometry3<f64>,
    pub axis: Vector3<f64>,
    pub limits: JointLimits,
    pub damping: f64,
    pub friction: f64,
    pub drive: Option<JointDrive>,
}

/// Links and joints; the only root is `links[0]`, `joints[i]` carries `links[i + 1]`.
#[derive(Debug, Clone)]
pub struct RigidRobot {
    pub name: String,
    pub title: String,
    pub links: Vec<Link>,
    pub joints: Vec<RigidJoint>,
    /// `world_from_root`; the root does not move.
    pub root: Isometry3<f64>,
    pub notes: Vec<Note>,
}

/// A link with a mass, or none, at a point, with equal moments of inertia about it.
pub fn link(name: &str, mass_kg: f64, com: Point3<f64>, moment: f64) -> Link {
    let inertial = (mass_kg > 0.0).then(|| Inertial { mass_kg, com, inertia: Matrix3::identity() * moment });
    Link { name: name.to_owned(), inertial, visuals: Vec::new(), collisions: Vec::new() }
}

impl RigidRobot {
    pub fn of_bench(bench: &BenchDescription, reach: Reach) -> Self {
        let mut notes = Vec::new();
        let rigid = bench.output != Output::Held;
        let arm = if let Output::Pendulum { arm_m, .. } = bench.output { arm_m } else { 1.0 };
        for (id, term) in bench.terms() {
            notes.push(note(id, term, reach, rigid));
        }
        if rigid {
            notes.insert(
                0,
                Note::lost(
                    "spring",
                    "a tree of joints cannot close the loop between screw, spring and lever: rigid",
                ),
            );
        } else if reach == Reach::Body {
            notes.insert(
                0,
                Note::lost("spring", format!("no joint has one; its stiffness is {}", num(bench.stiffness))),
            );
        }
        notes.insert(0, Note::lost("load cells", "no such sensor between drive and joint"));
        let armature = bench.inertia * arm * arm;
        let mut drive = JointDrive {
            spring: if rigid { 0.0 } else { bench.stiffness },
            ..driven(bench, arm, if reach == Reach::Armature { armature } else { 0.0 })
        };
        let in_body = if reach == Reach::Armature { 0.0 } else { armature };
        let (child, kind, axis) = match (bench.output, bench.kind) {
            (Output::Pendulum { mass_kg, length_m, .. }, _) => {
                let com = Point3::new(0.0, 0.0, -length_m);
                // A point mass has no moments of its own, which these formats do not admit.
                let moment = in_body.max(1e-6 * mass_kg * length_m * length_m);
                (link("lever", mass_kg, com, moment), JointKind::Continuous, -Vector3::y())
            }
            (Output::Held, Kind::Linear) => {
                let mass = bench.sprung_mass + in_body;
                (
                    link("sprung_mass", mass, Point3::origin(), 1e-4 * mass),
                    JointKind::Prismatic,
                    -Vector3::x(),
                )
            }
            (Output::Held, Kind::Rotary) => {
                let moment = bench.sprung_mass + in_body;
                (link("sprung_mass", moment, Point3::origin(), moment), JointKind::Continuous, -Vector3::x())
            }
        };
        let (spring_damping, at_output) = (bench.spring_damping(), bench.output_friction());
        drive.friction_at_rest += at_output;
        let effort = bench.command_limit().map_or(f64::INFINITY, |limit| limit * bench.gain.abs() * arm);
        // The spring's own force must not be clipped with the motor's.
        let effort = if reach == Reach::Armature && !rigid { f64::INFINITY } else { effort };
        let joint = RigidJoint {
            name: if rigid { "lever" } else { "deflection" }.to_owned(),
            kind,
            parent: 0,
            child: 1,
            origin: Isometry3::identity(),
            axis,
            limits: JointLimits { effort, velocity: speed_limit(&drive), ..JointLimits::NONE },
            damping: bench.damping * arm * arm + if rigid { 0.0 } else { spring_damping },
            friction: moving_friction(bench) * arm + at_output,
            drive: Some(drive),
        };
        Self {
            name: "bench".to_owned(),
            title: bench.name.clone(),
            links: vec![link("frame", 0.0, Point3::origin(), 0.0), child],
            joints: vec![joint],
            root: Isometry3::identity(),
            notes,
        }
    }
}

pub fn driven(bench: &BenchDescription, arm: f64, armature: f64) -> JointDrive {
    let voltage = bench.find(|t| match *t {
        Term::VoltageLimit { bus, resistance } if bus.is_finite() => {
            Some((bench.gain * bus / resistance * arm, bus / bench.gain / arm))
        }
        _ => None,
    });
    JointDrive {
        spring: 0.0,
        derivative: 0.0,
        armature,
        friction_at_rest: bench.sum(Term::dry_friction).max(moving_friction(bench)) * arm,
        delay_s: bench.delay_s(),
        voltage,
    }
}

pub fn speed_limit(drive: &JointDrive) -> f64 {
    drive.voltage.map_or(f64::INFINITY, |(_, speed)| speed)
}

/// Dry friction in motion.
pub fn moving_friction(bench: &BenchDescription) -> f64 {
    bench.sum(|t| match *t {
        Term::Coulomb { force }
        | Term::Presliding { force, .. }
        | Term::DirectedFriction { force, .. }
        | Term::Warming { force, .. } => Some(force),
        Term::Stribeck { coulomb, .. } => Some(coulomb),
        _ => None,
    })
}
