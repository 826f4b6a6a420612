//! Drives at joints for MuJoCo: the links as bodies, every drive as armature, losses and actuator of its joint.
//!
//! MuJoCo integrates the same equations as `sealegs_leg::bench` and `sealegs_actuator::plant`: in the joints' coordinates,
//! with the rotor's reflected inertia as the joint's armature.
//!
//! A rotor that a spring or play parts from its joint `J` has the coordinate `y` of a joint of its own, `J_rotor`, whose
//! armature it is. That joint slides, whatever the drive does, and its body hangs on the link: MuJoCo keeps the part of a
//! tendon's armature between two joints only where one carries the other, and a body of no mass that slides feels nothing of
//! the link's motion. The tendon `J_deflection` has the length `y - arm q`; spring, damping, play and the mass that the spring
//! carries are the tendon's.

use super::bench::{
    cable, cogging, drive_attributes, offset, parts_for_yield, rubbing, screw_attributes, spring_attributes,
};
use super::shape::{coordinate, geom, inertial, place};
use super::tendon::{fixed, yielding};
use super::{STEP_S, delayed, driven_callback, driven_notes};
use crate::Exported;
use crate::driven::{Command, DrivenJoint, DrivenRobot};
use crate::text::{escaped, module, num, nums, xml_head};
use nalgebra::{Matrix3, Point3};
use sealegs_actuator::plant::{Servo, Winding};
use sealegs_leg::robot::{Inertial, Joint, JointKind};
use std::fmt::Write;

/// Least mass, kg, and moment of inertia, kg m^2, of a body that moves: MuJoCo refuses less than 1e-15.
const LEAST: f64 = 1e-12;

pub fn write(robot: &DrivenRobot, stem: &str) -> Exported {
    let notes = driven_notes::notes(robot, stem);
    let step_s = step_s(robot);
    let mut out = xml_head(&format!("{} for MuJoCo 4, written by sealegs", robot.title), &notes);
    let o = &mut out;
    let _ = writeln!(o, "<mujoco model=\"{}\">", escaped(&robot.title));
    let _ = writeln!(o, "  <compiler angle=\"radian\" autolimits=\"true\"/>");
    let _ = writeln!(
        o,
        "  <option timestep=\"{}\" integrator=\"RK4\" gravity=\"0 0 {}\" iterations=\"100\" tolerance=\"1e-12\"/>",
        num(step_s),
        num(-robot.gravity_m_s2)
    );
    let _ = writeln!(o, "  <worldbody>");
    body(o, robot, 0, step_s, "    ");
    let _ = writeln!(o, "  </worldbody>");
    tendons(o, robot);
    let _ = writeln!(o, "  <actuator>");
    for joint in &robot.joints {
        actuators(o, joint, step_s);
    }
    let _ = writeln!(o, "  </actuator>\n  <sensor>");
    for joint in &robot.joints {
        let name = escaped(&joint.name);
        let _ = writeln!(
            o,
            "    <jointpos name=\"{name}_position\" joint=\"{name}\"/>\n    <jointvel name=\"{name}_speed\" joint=\"{name}\"/>"
        );
    }
    let _ = writeln!(o, "  </sensor>");
    keys(o, robot);
    let _ = writeln!(o, "</mujoco>");
    let python = driven_callback::python(robot, stem, &notes);
    Exported { text: out, beside: vec![(format!("{}.py", module(stem)), python)], notes }
}

/// The step, s: the longest in the files, or a fine part of it where an elastic friction or a clamp yields, or a rotor
/// oscillates against its joint.
pub fn step_s(robot: &DrivenRobot) -> f64 {
    let of = |j: &DrivenJoint| {
        j.coupling.as_ref().map_or(STEP_S, |c| c.step_s).min(STEP_S / parts_for_yield(&j.drive))
    };
    robot.joints.iter().map(of).fold(STEP_S, f64::min)
}

/// A link with all that hangs on it. MuJoCo numbers joints in this order.
fn body(o: &mut String, robot: &DrivenRobot, link: usize, step_s: f64, indent: &str) {
    let this = &robot.robot.links[link];
    let carrier = link.checked_sub(1).map(|j| &robot.robot.joints[j]);
    let at = carrier.map_or_else(nalgebra::Isometry3::identity, |j| j.origin);
    let _ = writeln!(o, "{indent}<body name=\"{}\" {}>", escaped(&this.name), place(&at));
    let moved = carrier.and_then(|j| Some((j, &robot.joints[j.dof?])));
    if let Some((joint, driven)) = moved {
        joint_element(o, joint, driven, step_s, indent);
    }
    let least = Inertial { mass_kg: LEAST, com: Point3::origin(), inertia: Matrix3::identity() * LEAST };
    let own = this.inertial.clone().or(moved.map(|_| least));
    if let Some(i) = own {
        let _ = writeln!(o, "{indent}  {}", inertial(&i));
    }
    let still = "contype=\"0\" conaffinity=\"0\"";
    for (shapes, group) in [(&this.visuals, 2), (&this.collisions, 3)] {
        for shape in shapes {
            geom(o, indent, shape, &format!("group=\"{group}\" {still}"));
        }
    }
    if let Some((_, driven)) = moved {
        rotor(o, driven, step_s, indent);
    }
    for joint in robot.robot.joints.iter().filter(|j| j.parent == link) {
        body(o, robot, joint.child, step_s, &format!("{indent}  "));
    }
    let _ = writeln!(o, "{indent}</body>");
}

fn joint_element(o: &mut String, joint: &Joint, driven: &DrivenJoint, step_s: f64, indent: &str) {
    let kind = if joint.kind == JointKind::Prismatic { "slide" } else { "hinge" };
    let drive = driven.at_joint();
    let mut more = match driven.coupling {
        None => screw_attributes(&drive, step_s),
        Some(_) => {
            format!(" damping=\"{}\"", num(driven.damping)) + &rubbing(drive.output_friction(), step_s)
        }
    };
    more += &cable(&drive);
    if joint.limits.lower.is_finite() && joint.limits.upper.is_finite() {
        let _ = write!(more, " range=\"{}\"", nums(&[joint.limits.lower, joint.limits.upper]));
    }
    let _ = writeln!(
        o,
        "{indent}  <joint name=\"{}\" type=\"{kind}\" axis=\"{}\"{more}/>",
        escaped(&joint.name),
        nums(joint.axis.as_slice())
    );
}

/// The joint of a rotor that moves on its own.
fn rotor(o: &mut String, driven: &DrivenJoint, step_s: f64, indent: &str) {
    if driven.coupling.is_none() {
        return;
    }
    let (name, drive, _) = driven.at_rotor();
    coordinate(o, &format!("{indent}  "), &escaped(&name), LEAST, &screw_attributes(&drive, step_s));
}

/// Springs between rotors and joints, and what yields: elastic frictions and clamps.
fn tendons(o: &mut String, robot: &DrivenRobot) {
    let mut inner = String::new();
    for joint in &robot.joints {
        let (name, (at_rotor, drive, _)) = (escaped(&joint.name), joint.at_rotor());
        let at_rotor = escaped(&at_rotor);
        let mut deflection = Vec::new();
        if let Some(coupling) = &joint.coupling {
            deflection = vec![(at_rotor.as_str(), 1.0), (name.as_str(), -joint.arm)];
            // What acts only in contact is the callback's.
            let damping = if coupling.in_contact { 0.0 } else { coupling.damping };
            let spring = spring_attributes(&drive, damping, coupling.gap, drive.sprung_mass);
            fixed(&mut inner, &format!("{name}_deflection"), &spring, &deflection);
        }
        yielding(&mut inner, &drive, &format!("{name}_"), &at_rotor, &deflection);
    }
    if !inner.is_empty() {
        let _ = write!(o, "  <tendon>\n{inner}  </tendon>\n");
    }
}

/// The motor under the joint's own name, and what else pushes the joint.
fn actuators(o: &mut String, joint: &DrivenJoint, step_s: f64) {
    let ((at_rotor, drive, arm), name) = (joint.at_rotor(), escaped(&joint.name));
    let at_rotor = escaped(&at_rotor);
    let late = delayed(drive.delay_s(), step_s);
    let winding = |w: &Winding| {
        format!(
            " gear=\"{}\" motorconst=\"{}\" resistance=\"{}\"",
            num(arm),
            num(w.force_per_current),
            num(w.resistance_ohm)
        )
    };
    match &joint.command {
        Command::Effort => {
            let limit = drive.command_limit();
            let _ = writeln!(
                o,
                "    <general name=\"{name}\" joint=\"{at_rotor}\"{}/>",
                drive_attributes(&drive, limit, step_s)
            );
        }
        Command::Voltage(w) => {
            let _ = writeln!(
                o,
                "    <dcmotor name=\"{name}\" joint=\"{at_rotor}\" input=\"voltage\"{}{late}/>",
                winding(w)
            );
            constant(o, &format!("{name}_offset"), &at_rotor, drive.offset_force);
        }
        Command::Impedance(servo) => {
            let most = joint.most_of(servo, &drive);
            position_loop(o, (&name, &at_rotor), servo, (drive.gain, arm, most), &late);
        }
        Command::Goal(w, servo) => {
            // Duty times supply over the resistance is a current, times the constant a force along y.
            // One that sees the joint and pushes the rotor is the callback's.
            let held = if joint.coupling.is_some() { 0.0 } else { 1.0 };
            let per_duty = arm * servo.per_given() * w.force_per_current / w.resistance_ohm;
            let most = (per_duty * servo.limit).abs();
            position_loop(o, (&name, &at_rotor), servo, (held * per_duty, arm, most), &late);
            let _ = writeln!(
                o,
                "    <dcmotor name=\"{name}_back_emf\" joint=\"{at_rotor}\" input=\"none\"{}/>",
                winding(w)
            );
        }
    }
    for (_, term) in drive.terms() {
        o.push_str(&cogging(&drive, term, &format!("{name}_cogging"), &at_rotor));
    }
    o.push_str(&offset(&joint.at_joint(), &format!("{name}_output_offset"), &name));
}

/// A position loop as an actuator of a joint, with the effort there per unit of what the loop gives, the travel per motion of the joint
/// and the greatest effort. The loop is one of y.
fn position_loop(
    o: &mut String,
    (name, joint): (&str, &str),
    servo: &Servo,
    (per_given, arm, most): (f64, f64, f64),
    late: &str,
) {
    let gain = per_given * servo.proportional;
    let bias = [gain * servo.goal_offset, -gain * arm, -per_given * servo.derivative * arm];
    let range = match most.is_finite() {
        true => format!(" forcerange=\"{}\"", nums(&[-most, most])),
        false => String::new(),
    };
    let _ = writeln!(
        o,
        "    <general name=\"{name}\" joint=\"{joint}\" gainprm=\"{}\" biastype=\"affine\" biasprm=\"{}\"{range}{late}/>",
        num(gain),
        nums(&bias)
    );
}

/// A constant effort on a joint, as an actuator that follows no control; nothing for none.
pub fn constant(o: &mut String, name: &str, joint: &str, effort: f64) {
    if effort != 0.0 {
        let bias = nums(&[effort, 0.0, 0.0]);
        let _ = writeln!(
            o,
            "    <general name=\"{name}\" joint=\"{joint}\" gainprm=\"0\" biastype=\"affine\" biasprm=\"{bias}\"/>"
        );
    }
}

/// Where the campaign's runs begin. MuJoCo's order of joints is that of the bodies.
fn keys(o: &mut String, robot: &DrivenRobot) {
    if robot.starts.is_empty() {
        return;
    }
    let order = order(robot);
    let _ = writeln!(o, "  <keyframe>");
    for (name, start) in &robot.starts {
        let (mut position, mut speed) = (Vec::new(), Vec::new());
        for &i in &order {
            let (joint, at) = (&robot.joints[i], &start[i]);
            position.push(at.position);
            speed.push(at.speed);
            if joint.coupling.is_some() {
                position.push(joint.arm * at.position + at.ahead);
                speed.push(joint.arm * at.speed);
            }
        }
        let _ = writeln!(
            o,
            "    <key name=\"{}\" qpos=\"{}\" qvel=\"{}\"/>",
            escaped(name),
            nums(&position),
            nums(&speed)
        );
    }
    let _ = writeln!(o, "  </keyframe>");
}

/// Degrees of freedom in the order of MuJoCo's bodies, depth first.
fn order(robot: &DrivenRobot) -> Vec<usize> {
    let (mut order, mut open) = (Vec::new(), vec![0_usize]);
    while let Some(link) = open.pop() {
        order.extend(link.checked_sub(1).and_then(|j| robot.robot.joints[j].dof));
        open.extend(robot.robot.joints.iter().filter(|j| j.parent == link).map(|j| j.child).rev());
    }
    order
}
