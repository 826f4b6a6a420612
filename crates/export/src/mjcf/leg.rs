//! A leg for MuJoCo: its bodies, and every actuator as a screw and a spring that a tendon's constraint ties to the leg.
//!
//! Beside the leg's bodies stand, for every actuator, a joint `NAME_screw` (the extension `y`, the rotor being its armature)
//! and a joint `NAME_deflection` (the spring). The fixed tendon `NAME_travel` has the length `y - delta`, the tendon
//! `NAME_length` the distance of the attachments (or a linkage's joint angle); an equality constraint ties the one to the
//! other, and its force is the spring's.

use super::leg_actuator::Parts;
use super::shape::{geom, has_mesh, inertial, place, quat};
use super::{STEP_S, holding};
use crate::leg::LegDescription;
use crate::term::Term;
use crate::text::{escaped, num, nums, xml_head};
use crate::{ExportError, Exported, Note};
use nalgebra::Isometry3;
use sealegs_leg::robot::{Drive, JointKind};
use std::fmt::Write;

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
            "point masses on the links, their weight on the screw that at the start; no reaction to its acceleration",
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
    if has_mesh(&leg.robot) {
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
