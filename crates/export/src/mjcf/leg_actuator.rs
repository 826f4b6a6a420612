//! An actuator of a leg for MuJoCo: screw, spring, and the constraint that ties them to the leg.

use super::STEP_S;
use super::bench::{cogging, drive_attributes, screw_attributes, stiffness};
use super::shape::coordinate;
use super::tendon::{fixed, yielding};
use crate::bench::BenchDescription;
use crate::leg::{LegActuator, LegDescription};
use crate::term::Term;
use crate::text::{escaped, num, nums};
use crate::{ExportError, Note};
use nalgebra::{DMatrix, DVector};
use sealegs_leg::robot::{Drive, HoekensMount};
use std::fmt::Write;

/// Mass of a body that stands for a coordinate, kg: its inertia is the joint's armature.
const COORDINATE_KG: f64 = 1e-12;

/// Postures at which a linkage's curve is fitted.
const POSTURES: usize = 201;

/// What the actuators add to the leg, element by element.
#[derive(Default)]
pub struct Parts {
    pub bodies: String,
    pub tendons: String,
    pub ties: String,
    pub motors: String,
    pub start: Vec<f64>,
    pub notes: Vec<Note>,
}

impl Parts {
    pub fn actuator(&mut self, leg: &LegDescription, actuator: &LegActuator) -> Result<(), ExportError> {
        let (bench, placement) = (&actuator.drive, &actuator.placement);
        let name = escaped(&placement.name);
        // The spring's own inertia, for the solver: with it the spring turns a third of a radian in a step.
        let least = |stiffness: f64| stiffness * (3.0 * STEP_S).powi(2);
        let damping = bench.spring_damping();
        let mut spring = format!(" armature=\"{}\"", num(least(bench.stiffness)));
        let half_gap = 0.5 * bench.gap();
        if half_gap == 0.0 {
            let _ = write!(spring, " stiffness=\"{}\"", stiffness(bench));
            if actuator.weight_on_spring != 0.0 {
                let _ = write!(spring, " springref=\"{}\"", num(actuator.weight_on_spring / bench.stiffness));
            }
        }
        if damping > 0.0 {
            let _ = write!(spring, " damping=\"{}\"", num(damping));
        }
        let (travel, tie) = self.length(leg, actuator, &name)?;
        let (screw, deflection) = (format!("{name}_screw"), format!("{name}_deflection"));
        self.coordinate(&screw, &screw_attributes(bench, STEP_S));
        self.coordinate(&deflection, &spring);
        self.start.extend([travel, 0.0]);
        let mut along = vec![(screw.as_str(), 1.0), (deflection.as_str(), -1.0)];
        let end = format!("{name}_screw_end");
        if let Some((stiffness, mass)) = bench.series() {
            let armature = num(mass.max(least(stiffness)));
            self.coordinate(&end, &format!(" armature=\"{armature}\" stiffness=\"{}\"", num(stiffness)));
            self.start.push(0.0);
            along.push((end.as_str(), -1.0));
        }
        fixed(&mut self.tendons, &format!("{name}_travel"), "", &along);
        if half_gap > 0.0 {
            let play = nums(&[-half_gap, half_gap]);
            let attributes = format!(" stiffness=\"{}\" springlength=\"{play}\"", stiffness(bench));
            fixed(&mut self.tendons, &format!("{name}_spring"), &attributes, &[(&deflection, 1.0)]);
        }
        yielding(&mut self.tendons, bench, &format!("{name}_"), &screw, &[(&deflection, 1.0)]);
        let soft = format!("solref=\"{}\" solimp=\"0.9999 0.9999 0.001 0.5 2\"", nums(&[2.0 * STEP_S, 1.0]));
        let _ = writeln!(
            self.ties,
            "    <tendon name=\"{name}\" tendon1=\"{name}_travel\" tendon2=\"{name}_length\" polycoef=\"{}\" {soft}/>",
            nums(&tie)
        );
        let limit = bench.command_limit().unwrap_or(f64::INFINITY).min(actuator.current_limit_a);
        let _ = writeln!(
            self.motors,
            "    <general name=\"{name}\" joint=\"{screw}\"{}/>",
            drive_attributes(bench, Some(limit).filter(|l| l.is_finite()), STEP_S)
        );
        for (_, term) in bench.terms() {
            self.motors.push_str(&cogging(bench, term, &format!("{name}_cogging"), &screw));
        }
        self.notes
            .extend(bench.terms().map(|(id, term)| note(&format!("{}/{id}", placement.name), term, bench)));
        Ok(())
    }

    fn coordinate(&mut self, name: &str, attributes: &str) {
        coordinate(&mut self.bodies, "    ", name, COORDINATE_KG, attributes);
    }

    /// The tendon whose length is the actuator's, or the angle that it follows from; the screw's travel at the start with
    /// the spring unloaded, m, and the tie's polynomial.
    fn length(
        &mut self,
        leg: &LegDescription,
        actuator: &LegActuator,
        name: &str,
    ) -> Result<(f64, [f64; 5]), ExportError> {
        let robot = &leg.robot;
        let index = robot.actuator_index(&actuator.placement.name).unwrap_or_default();
        match &actuator.placement.drive {
            Drive::Hoekens(mount) => {
                let joint = &robot.joints[mount.joint];
                let q = joint.dof.map_or(0.0, |dof| leg.start_q[dof]);
                let (tie, worst) = fitted(leg, mount)?;
                fixed(&mut self.tendons, &format!("{name}_length"), "", &[(&escaped(&joint.name), 1.0)]);
                self.notes.push(Note::near(
                    format!("{} linkage", actuator.placement.name),
                    format!(
                        "a polynomial of fourth degree of its joint's angle, within {} mm of its travel",
                        num((worst * 1e6).round() / 1e3)
                    ),
                ));
                Ok((tie.iter().rev().fold(0.0, |sum, c| sum * q + c), tie))
            }
            _ => {
                let _ = write!(
                    self.tendons,
                    "    <spatial name=\"{name}_length\">\n      <site site=\"{name}_1\"/>\n      <site site=\"{name}_2\"/>\n    \
                     </spatial>\n"
                );
                let at = |q: &[f64]| robot.lever(index, q).map(|l| l.length_m);
                Ok((at(&leg.start_q)? - at(&vec![0.0; robot.dofs])?, [0.0, 1.0, 0.0, 0.0, 0.0]))
            }
        }
    }
}

/// A linkage's travel from joint position zero as a polynomial of fourth degree of the position, by least squares over the
/// joint's range, and its greatest error, m.
fn fitted(leg: &LegDescription, mount: &HoekensMount) -> Result<([f64; 5], f64), ExportError> {
    let limits = leg.robot.joints[mount.joint].limits;
    let (low, high) = (limits.lower.max(-std::f64::consts::PI), limits.upper.min(std::f64::consts::PI));
    let travel = |q: f64| {
        mount
            .linkage
            .travel_m(mount.crank_angle_at_zero_rad + mount.sign * q)
            .map_err(sealegs_leg::LegError::from)
    };
    let zero = travel(0.0)?;
    let at: Vec<f64> = (0..POSTURES).map(|i| low + (high - low) * i as f64 / (POSTURES - 1) as f64).collect();
    let wanted = at.iter().map(|q| Ok(travel(*q)? - zero)).collect::<Result<Vec<f64>, ExportError>>()?;
    let powers = DMatrix::from_fn(POSTURES, 5, |i, k| at[i].powi(k as i32));
    let wanted = DVector::from_vec(wanted);
    // Five columns of a few radians: far from singular.
    let solved = powers.clone().svd(true, true).solve(&wanted, 1e-12).unwrap_or_else(|_| DVector::zeros(5));
    let worst = (&powers * &solved - wanted).amax();
    Ok((std::array::from_fn(|k| solved[k]), worst))
}

/// What becomes of an actuator's effect.
fn note(id: &str, term: &Term, bench: &BenchDescription) -> Note {
    match term {
        Term::Coulomb { .. } => Note::held(id, "frictionloss of the screw's joint"),
        Term::Stribeck { .. } | Term::DirectedFriction { .. } | Term::Warming { .. } => {
            Note::near(id, "frictionloss of the screw's joint: its greatest bound at rest")
        }
        Term::Presliding { .. } | Term::SpringSlip { .. } => {
            Note::held(id, "a tendon's spring with springyield")
        }
        Term::Drag { .. } => Note::held(id, "quadratic damping of the screw's joint"),
        Term::Ripple { .. } => Note::held(id, "cogging of a dcmotor without current"),
        Term::CommandLimit { .. } => Note::held(id, "ctrlrange of the actuator"),
        Term::Delay { .. } => Note::held(id, "delay of the actuator, and half a step for its interpolation"),
        Term::Hardening { .. } => Note::held(id, "cubic stiffness of the spring's joint"),
        Term::SpringDamping { .. } if bench.gap() > 0.0 => {
            Note::near(id, "damping beside the spring, within the play too")
        }
        Term::SpringDamping { .. } => Note::held(id, "damping of the spring's joint"),
        Term::Backlash { .. } => {
            Note::held(id, "springlength of a tendon as a range, within which it has no force")
        }
        Term::Series { .. } => {
            Note::near(id, "a further spring; its mass is felt between screw and leg only")
        }
        Term::OutputFriction { .. } => Note::held(id, "frictionloss of the joint"),
        _ if id.ends_with("/spring-setting") => Note::held(id, "stiffness of the spring"),
        _ => Note::lost(id, "no element of MuJoCo; the callbacks beside a bench show how it could be added"),
    }
}
