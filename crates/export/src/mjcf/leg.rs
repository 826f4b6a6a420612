//! A leg for MuJoCo: its bodies, and every actuator as a screw and a spring that a tendon's constraint ties to the leg.
//!
//! Beside the leg's bodies stand, for every actuator, a joint `NAME_screw` (the extension `y`, the rotor being its armature)
//! and a joint `NAME_deflection` (the spring). The fixed tendon `NAME_travel` has the length `y - delta`, the tendon
//! `NAME_length` the distance of the attachments (or a linkage's joint angle); an equality constraint ties the one to the
//! other, and its force is the spring's.

use super::bench::{
    cogging, drive_attributes, gap, path, screw_attributes, spring_damping, stiffness, yielding,
};
use super::{STEP_S, holding};
use crate::bench::BenchDescription;
use crate::leg::{LegActuator, LegDescription};
use crate::term::Term;
use crate::text::{escaped, num, nums, xml_head};
use crate::{ExportError, Exported, Note};
use nalgebra::{DMatrix, DVector, Isometry3};
use sealegs_leg::robot::{Drive, Geometry, HoekensMount, Inertial, JointKind, Shape};
use std::fmt::Write;

/// Mass of a body that stands for a coordinate, kg: its inertia is the joint's armature.
const COORDINATE_KG: f64 = 1e-12;

/// Postures at which a linkage's curve is fitted.
const POSTURES: usize = 201;

/// # Errors
///
/// [`ExportError::Leg`] where a linkage does not close within its joint's limits.
pub fn write(leg: &LegDescription, stem: &str) -> Result<Exported, ExportError> {
    let mut parts = Parts::default();
    for actuator in &leg.actuators {
        parts.actuator(leg, actuator)?;
    }
    let mut notes = notes(leg);
    notes.append(&mut parts.notes);
    let mut out = xml_head(&format!("{} for MuJoCo 4, written by sealegs", leg.name), &notes);
    let o = &mut out;
    let _ = writeln!(o, "<mujoco model=\"{}\">", escaped(&leg.robot.name));
    let _ = writeln!(o, "  <compiler angle=\"radian\" autolimits=\"true\"/>");
    let _ = writeln!(
        o,
        "  <option timestep=\"{}\" integrator=\"implicitfast\" gravity=\"0 0 {}\" iterations=\"100\"/>",
        num(STEP_S),
        num(-leg.gravity_m_s2)
    );
    let _ = writeln!(o, "  <worldbody>");
    if let Some(ground) = leg.ground {
        let slope = Isometry3::rotation(nalgebra::Vector3::y() * -ground.slope_rad);
        let _ = writeln!(
            o,
            "    <geom name=\"ground\" type=\"plane\" size=\"5 5 0.1\" pos=\"0 0 {}\" quat=\"{}\" friction=\"{} 0.005 0.0001\" \
             contype=\"0\" conaffinity=\"1\"/>",
            num(ground.height_m),
            quat(&slope),
            num(ground.friction)
        );
    }
    let mut start = Vec::new();
    body(o, leg, 0, 2, &mut start);
    out.push_str(&parts.bodies);
    start.append(&mut parts.start);
    let o = &mut out;
    let _ = writeln!(o, "  </worldbody>\n  <tendon>\n{}  </tendon>", parts.tendons);
    let _ = writeln!(o, "  <equality>\n{}  </equality>", parts.ties);
    let _ = writeln!(o, "  <actuator>\n{}  </actuator>", parts.motors);
    let _ = writeln!(
        o,
        "  <keyframe>\n    <key name=\"start\" qpos=\"{}\"/>\n  </keyframe>\n</mujoco>",
        nums(&start)
    );
    let _ = stem;
    Ok(Exported { text: out, beside: Vec::new(), notes })
}

fn quat(at: &Isometry3<f64>) -> String {
    let q = at.rotation.quaternion();
    nums(&[q.w, q.i, q.j, q.k])
}

fn place(at: &Isometry3<f64>) -> String {
    format!("pos=\"{}\" quat=\"{}\"", nums(at.translation.vector.as_slice()), quat(at))
}

fn inertial(i: &Inertial) -> String {
    let m = &i.inertia;
    let full = [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]];
    format!(
        "<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>",
        nums(i.com.coords.as_slice()),
        num(i.mass_kg),
        nums(&full)
    )
}

/// A link with all that hangs on it; the positions of its joints at the start go into `start`, in MuJoCo's order.
fn body(o: &mut String, leg: &LegDescription, link: usize, depth: usize, start: &mut Vec<f64>) {
    let indent = "  ".repeat(depth);
    let this = &leg.robot.links[link];
    let carrier = link.checked_sub(1).map(|j| &leg.robot.joints[j]);
    let at = carrier.map_or(leg.world_from_base, |j| j.origin);
    let _ = writeln!(o, "{indent}<body name=\"{}\" {}>", escaped(&this.name), place(&at));
    match carrier {
        None if leg.rail => {
            let _ = writeln!(o, "{indent}  <joint name=\"rail\" type=\"slide\" axis=\"0 0 1\"/>");
            start.push(0.0);
        }
        Some(j) => {
            if let Some(dof) = j.dof {
                let kind = if j.kind == JointKind::Prismatic { "slide" } else { "hinge" };
                let mut more = String::new();
                if j.limits.lower.is_finite() && j.limits.upper.is_finite() {
                    let _ = write!(more, " range=\"{}\"", nums(&[j.limits.lower, j.limits.upper]));
                }
                if j.damping > 0.0 {
                    let _ = write!(more, " damping=\"{}\"", num(j.damping));
                }
                if j.friction > 0.0 {
                    let _ = write!(more, " frictionloss=\"{}\" {}", num(j.friction), holding(STEP_S));
                }
                let _ = writeln!(
                    o,
                    "{indent}  <joint name=\"{}\" type=\"{kind}\" axis=\"{}\"{more}/>",
                    escaped(&j.name),
                    nums(j.axis.as_slice())
                );
                start.push(leg.start_q[dof]);
            }
        }
        None => {}
    }
    if let Some(i) = &this.inertial {
        let _ = writeln!(o, "{indent}  {}", inertial(i));
    }
    let is_foot = leg.ground.is_some() && leg.robot.joints.iter().all(|j| j.parent != link);
    for shape in &this.visuals {
        geom(o, &indent, shape, "group=\"2\" contype=\"0\" conaffinity=\"0\"");
    }
    for shape in &this.collisions {
        let touch = if is_foot {
            "group=\"3\" contype=\"1\" conaffinity=\"0\""
        } else {
            "group=\"3\" contype=\"0\" conaffinity=\"0\""
        };
        geom(o, &indent, shape, touch);
    }
    for actuator in &leg.actuators {
        if let Drive::Linear { point_1, point_2 } = &actuator.placement.drive {
            let ends = [(actuator.placement.link_1, point_1, 1), (actuator.placement.link_2, point_2, 2)];
            for (_, point, end) in ends.into_iter().filter(|(l, ..)| *l == link) {
                let name = escaped(&actuator.placement.name);
                let _ = writeln!(
                    o,
                    "{indent}  <site name=\"{name}_{end}\" pos=\"{}\"/>",
                    nums(point.coords.as_slice())
                );
            }
        }
    }
    for joint in leg.robot.joints.iter().filter(|j| j.parent == link) {
        body(o, leg, joint.child, depth + 1, start);
    }
    let _ = writeln!(o, "{indent}</body>");
}

fn geom(o: &mut String, indent: &str, shape: &Shape, more: &str) {
    let (kind, size) = match &shape.geometry {
        Geometry::Box { half } => ("box", nums(half)),
        Geometry::Cylinder { radius_m, length_m } => ("cylinder", nums(&[*radius_m, 0.5 * length_m])),
        Geometry::Capsule { radius_m, length_m } => ("capsule", nums(&[*radius_m, 0.5 * length_m])),
        Geometry::Sphere { radius_m } => ("sphere", num(*radius_m)),
        Geometry::Mesh(_) => return,
    };
    let color = shape.color.map_or_else(String::new, |c| format!(" rgba=\"{}\"", nums(&c)));
    // Inertias are stated: shapes weigh nothing.
    let _ = writeln!(
        o,
        "{indent}  <geom type=\"{kind}\" size=\"{size}\" {} mass=\"0\" {more}{color}/>",
        place(&shape.origin)
    );
}

/// What the actuators add to the leg, element by element.
#[derive(Default)]
struct Parts {
    bodies: String,
    tendons: String,
    ties: String,
    motors: String,
    start: Vec<f64>,
    notes: Vec<Note>,
}

impl Parts {
    fn actuator(&mut self, leg: &LegDescription, actuator: &LegActuator) -> Result<(), ExportError> {
        let (bench, placement) = (&actuator.drive, &actuator.placement);
        let name = escaped(&placement.name);
        // The spring's own inertia: so little that it moves ten times faster than a step can show its tie to be soft.
        let least = |stiffness: f64| stiffness * (3.0 * STEP_S).powi(2);
        let damping = spring_damping(bench);
        let mut spring = format!(" armature=\"{}\"", num(least(bench.stiffness)));
        let half_gap = 0.5 * gap(bench);
        if half_gap == 0.0 {
            let _ = write!(spring, " stiffness=\"{}\"", stiffness(bench));
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
        self.fixed(&format!("{name}_travel"), "", &along);
        if half_gap > 0.0 {
            let play = nums(&[-half_gap, half_gap]);
            let attributes = format!(" stiffness=\"{}\" springlength=\"{play}\"", stiffness(bench));
            self.fixed(&format!("{name}_spring"), &attributes, &[(&deflection, 1.0)]);
        }
        for (_, term) in bench.terms() {
            match *term {
                Term::Presliding { force, stiffness } if force > 0.0 => {
                    self.fixed(&format!("{name}_presliding"), &yielding(stiffness, force), &[(&screw, 1.0)]);
                }
                Term::SpringSlip { stiffness, force } if force > 0.0 => {
                    self.fixed(
                        &format!("{name}_clamp_slip"),
                        &yielding(stiffness, force),
                        &[(&deflection, 1.0)],
                    );
                }
                _ => {}
            }
        }
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
        let mass = num(COORDINATE_KG);
        let _ = writeln!(
            self.bodies,
            "    <body name=\"{name}\">\n      <inertial pos=\"0 0 0\" mass=\"{mass}\" diaginertia=\"{mass} {mass} {mass}\"/>\n      \
             <joint name=\"{name}\" type=\"slide\" axis=\"1 0 0\"{attributes}/>\n    </body>"
        );
    }

    fn fixed(&mut self, name: &str, attributes: &str, joints: &[(&str, f64)]) {
        let _ =
            write!(self.tendons, "    <fixed name=\"{name}\"{attributes}>\n{}    </fixed>\n", path(joints));
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
                self.fixed(&format!("{name}_length"), "", &[(&escaped(&joint.name), 1.0)]);
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
        Term::Stribeck { .. } | Term::DirectedFriction { .. } => {
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
        Term::SpringDamping { .. } if gap(bench) > 0.0 => {
            Note::near(id, "damping beside the spring, within the play too")
        }
        Term::SpringDamping { .. } => Note::held(id, "damping of the spring's joint"),
        Term::Backlash { .. } => {
            Note::held(id, "springlength of a tendon as a range, within which it has no force")
        }
        Term::Series { .. } => {
            Note::near(id, "a further spring; its mass is felt between screw and leg only")
        }
        _ => Note::lost(id, "no element of MuJoCo; the callbacks beside a bench show how it could be added"),
    }
}

fn notes(leg: &LegDescription) -> Vec<Note> {
    let mut notes = vec![
        Note::held(
            "actuators",
            "motor in A on the screw's joint; spring force: stiffness times NAME_deflection",
        ),
        Note::near(
            "springs",
            "tied to the leg by a constraint with a small inertia of their own, for the solver",
        ),
        Note::near(
            "sprung masses",
            "point masses on the links; their reaction to the screw's acceleration is left out",
        ),
        Note::near("joint stops", "MuJoCo's own limits, without the scenario's stiffness and damping"),
        Note::lost("controller", "currents are yours to command; key 'start' has the scenario's posture"),
    ];
    if leg.ground.is_some() {
        notes.push(Note::near(
            "ground",
            "friction and slope; the contact's law is MuJoCo's, not Hunt and Crossley's",
        ));
    }
    if leg.loaded_start {
        notes.push(Note::lost("start", "the springs' load: key 'start' has them unloaded"));
    }
    let meshes = leg.robot.links.iter().flat_map(|l| l.visuals.iter().chain(&l.collisions));
    if meshes.into_iter().any(|s| matches!(s.geometry, Geometry::Mesh(_))) {
        notes.push(Note::lost("meshes", "shapes only; inertias are those of the links"));
    }
    for placement in leg.robot.actuators.iter().filter(|p| p.spec.is_none()) {
        notes.push(Note::lost(placement.name.as_str(), "a rigid position drive: its joint is free"));
    }
    for (id, term) in &leg.others {
        let (what, why) = (id.as_str(), "an effect of the ground, a stop or a sensor");
        notes.push(match term {
            Term::OutputFriction { .. } => Note::held(what, "frictionloss of the joint"),
            _ if id.ends_with("/link-mass") => Note::held(what, "inertial of the link"),
            _ if id.ends_with("/spring-setting") => Note::held(what, "stiffness of the spring"),
            _ if id.ends_with("/ground-friction") => Note::held(what, "friction of the ground"),
            _ => Note::lost(what, why),
        });
    }
    notes
}
