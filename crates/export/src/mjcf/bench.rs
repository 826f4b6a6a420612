//! A bench for MuJoCo: the screw with its rotor, the spring as a tendon, the sprung mass and the output as bodies.
//!
//! The coordinate of the joint `screw` is the screw's extension `y`; its armature is the rotor's reflected inertia. That of
//! `screw_end` (with a series compliance) is `x_s`, that of `lever` the angle from hanging. The fixed tendon `deflection` has
//! the length `delta = y - x_s`, with `x_s = arm angle` on a lever; the spring is the tendon's. The sprung mass is a body at
//! `x_p = x_s - y`; on a lever without a series compliance it is the tendon's armature, for there `x_p = -delta`. Kinetic
//! energy and forces are then those of `sealegs_actuator::plant` exactly, without a constraint to solve.
//!
//! MuJoCo keeps the part of a tendon's armature between two joints only where one carries the other: the screw's body
//! therefore hangs on the lever, and slides along the lever's axis, where the lever does not move it.

use super::driven::constant;
use super::tendon::{fixed, yielding};
use super::{STEP_S, bench_notes, callback, delayed, holding};
use crate::Exported;
use crate::bench::{BenchDescription, Output};
use crate::term::Term;
use crate::text::{escaped, module, num, nums, xml_head};
use sealegs_actuator::Kind;
use std::fmt::Write;

/// Most of a radian that the fastest spring turns in a step: Runge-Kutta of fourth order then errs by 1e-7 rad a step, which
/// is of no account after a minute.
const MOST_ANGLE: f64 = 0.1;

/// The share of the moving inertia that a body without mass gets, for MuJoCo admits none: no signal feels it.
const LEAST_SHARE: f64 = 1e-9;

/// The least mass, kg, and moment of inertia, kg m^2, of a body: MuJoCo refuses less than 1e-15.
const LEAST: f64 = 1e-12;

pub fn write(bench: &BenchDescription, stem: &str) -> Exported {
    let notes = bench_notes::notes(bench, stem);
    let model = escaped(&bench.name);
    let mut out = xml_head(&format!("{} for MuJoCo 4, written by sealegs", bench.name), &notes);
    let o = &mut out;
    let _ = writeln!(o, "<mujoco model=\"{model}\">");
    let _ = writeln!(o, "  <compiler angle=\"radian\" autolimits=\"true\"/>");
    let _ = writeln!(
        o,
        "  <option timestep=\"{}\" integrator=\"RK4\" gravity=\"0 0 {}\" iterations=\"100\" tolerance=\"1e-12\"/>",
        num(step_s(bench)),
        num(-bench.gravity_m_s2)
    );
    bodies(o, bench);
    tendons(o, bench);
    drive(o, bench);
    let _ = writeln!(
        o,
        "  <sensor>\n    <tendonpos name=\"spring_deflection\" tendon=\"deflection\"/>\n    <jointpos \
         name=\"screw_extension\" joint=\"screw\"/>\n    <jointvel name=\"screw_speed\" joint=\"screw\"/>"
    );
    if let Output::Pendulum { .. } = bench.output {
        let _ = writeln!(o, "    <jointpos name=\"joint_angle\" joint=\"lever\"/>");
    }
    let _ = writeln!(o, "  </sensor>\n</mujoco>");
    let python = callback::python(bench, stem, &notes);
    Exported { text: out, beside: vec![(format!("{}.py", module(stem)), python)], notes }
}

/// Joint type, axis and inertial of a body that moves along the actuator's axis, or turns about it.
fn moving(bench: &BenchDescription, inertia: f64) -> (&'static str, String) {
    let least = LEAST_SHARE * (bench.inertia + bench.sprung_mass);
    let m = inertia.max(least).max(LEAST);
    match bench.kind {
        // The moments of a body that does not turn are of no account.
        Kind::Linear => ("slide", inertial("0 0 0", m, (1e-4 * m).max(LEAST))),
        Kind::Rotary => ("hinge", inertial("0 0 0", m, m)),
    }
}

fn inertial(at: &str, mass: f64, moment: f64) -> String {
    let moment = num(moment);
    format!("<inertial pos=\"{at}\" mass=\"{}\" diaginertia=\"{moment} {moment} {moment}\"/>", num(mass))
}

/// Parts of the longest step that a spring which yields needs: MuJoCo lets it yield once a step, so that it is too strong by
/// half a step's travel. On the pendulum bench an elastic friction of THOR's then does within 3 % what it does here.
const PARTS_FOR_YIELD: f64 = 5.0;

/// The step of a bench, s: the longest in the files, or a whole part of it that is fine enough for what rings on a series
/// compliance, and for what yields.
pub fn step_s(bench: &BenchDescription) -> f64 {
    let fastest = bench.series().map_or(0.0, |(stiffness, mass)| {
        let mass = (mass + bench.sprung_mass).max(LEAST_SHARE * bench.inertia);
        ((stiffness + bench.stiffness) / mass).sqrt()
    });
    STEP_S / (STEP_S * fastest / MOST_ANGLE).ceil().max(parts_for_yield(bench))
}

/// Parts of the longest step for what yields; 1 where nothing does.
pub fn parts_for_yield(bench: &BenchDescription) -> f64 {
    let yields = bench.terms().any(|(_, t)| matches!(t, Term::Presliding { .. } | Term::SpringSlip { .. }));
    if yields { PARTS_FOR_YIELD } else { 1.0 }
}

fn bodies(o: &mut String, bench: &BenchDescription) {
    let _ = writeln!(o, "  <worldbody>");
    let rotor = screw_attributes(bench, step_s(bench));
    let (kind, sprung) = moving(bench, bench.sprung_mass);
    let screw = |indent: &str, kind: &str, axis: &str, inertial: &str| {
        format!(
            "{indent}<body name=\"sprung_mass\">\n{indent}  {inertial}\n{indent}  <joint name=\"screw\" type=\"{kind}\" \
             axis=\"{axis}\"{rotor}/>\n{indent}</body>\n"
        )
    };
    match (bench.series(), bench.output) {
        (Some((stiffness, mass)), output) => {
            let (_, inertial_of) = moving(bench, mass);
            // Towards a lever the compliance is a tendon.
            let held = match output {
                Output::Held => format!(" stiffness=\"{}\"", num(stiffness)),
                Output::Pendulum { .. } => String::new(),
            };
            let _ = write!(
                o,
                "    <body name=\"screw_end\">\n      {inertial_of}\n      <joint name=\"screw_end\" type=\"{kind}\" \
                 axis=\"1 0 0\"{held}/>\n{}    </body>\n",
                screw("      ", kind, "-1 0 0", &sprung)
            );
        }
        (None, Output::Held) => o.push_str(&screw("    ", kind, "-1 0 0", &sprung)),
        // On the lever, see below.
        (None, Output::Pendulum { .. }) => {}
    }
    if let Output::Pendulum { mass_kg, length_m, .. } = bench.output {
        let friction = rubbing(bench.output_friction(), step_s(bench));
        let at = nums(&[0.0, 0.0, -length_m]);
        let friction = friction + &cable(bench);
        // A point mass: its own moments are as good as none.
        let point = inertial(&at, mass_kg, LEAST_SHARE * mass_kg * length_m * length_m);
        let _ = writeln!(
            o,
            "    <body name=\"lever\" pos=\"0.4 0 0\">\n      {point}\n      <joint name=\"lever\" type=\"hinge\" \
             axis=\"0 -1 0\"{friction}/>\n      <geom type=\"capsule\" fromto=\"0 0 0 {at}\" size=\"0.01\" mass=\"0\" \
             contype=\"0\" conaffinity=\"0\"/>"
        );
        if bench.series().is_none() {
            let least = LEAST_SHARE * mass_kg;
            let inertial = inertial("0 0 0", least, least * length_m * length_m);
            o.push_str(&screw("      ", "slide", "0 1 0", &inertial).replace("sprung_mass", "rotor"));
        }
        wobbling(o, bench);
        let _ = writeln!(o, "    </body>");
    }
    let _ = writeln!(o, "  </worldbody>");
}

/// A cable across the lever's joint, as attributes of the joint: with its rest as the joint's `springref`.
pub fn cable(bench: &BenchDescription) -> String {
    let cables = || {
        bench.terms().filter_map(|(_, t)| match *t {
            Term::Cable { stiffness, rest } if stiffness > 0.0 => Some((stiffness, rest)),
            _ => None,
        })
    };
    let total: f64 = cables().map(|(k, _)| k).sum();
    if total == 0.0 {
        return String::new();
    }
    let rest = cables().map(|(k, rest)| k * rest).sum::<f64>() / total;
    format!(" stiffness=\"{}\" springref=\"{}\"", num(total), num(rest))
}

/// A constant effort on the output, as an actuator that follows no control.
pub fn offset(bench: &BenchDescription, name: &str, joint: &str) -> String {
    let effort = bench.sum(|t| if let Term::OutputOffset { force } = t { Some(*force) } else { None });
    let mut text = String::new();
    constant(&mut text, name, joint, effort);
    text
}

fn wobbling(o: &mut String, bench: &BenchDescription) {
    for (_, term) in bench.terms() {
        if let Term::Wobbling { mass, radius, frequency_hz, ratio } = *term
            && mass > 0.0
        {
            let w = std::f64::consts::TAU * frequency_hz;
            let point = inertial("0 0 0", mass, LEAST_SHARE * mass * radius * radius);
            let _ = writeln!(
                o,
                "      <body name=\"wobbling_mass\" pos=\"{}\">\n        {point}\n        <joint name=\"wobbling_mass\" \
                 type=\"slide\" axis=\"1 0 0\" stiffness=\"{}\" damping=\"{}\"/>\n      </body>",
                nums(&[0.0, 0.0, -radius]),
                num(mass * w * w),
                num(2.0 * ratio * w * mass)
            );
        }
    }
}

/// `k`, or `k 0 k_3` for a hardening spring.
pub fn stiffness(bench: &BenchDescription) -> String {
    let cubic = bench.cubic();
    if cubic == 0.0 { num(bench.stiffness) } else { nums(&[bench.stiffness, 0.0, cubic]) }
}

/// The joint whose coordinate the deflection has beside the screw's, and how much of it.
pub fn beside_screw(bench: &BenchDescription) -> Option<(&'static str, f64)> {
    match (bench.series(), bench.output) {
        (Some(_), _) => Some(("screw_end", -1.0)),
        (None, Output::Pendulum { arm_m, .. }) => Some(("lever", -arm_m)),
        (None, Output::Held) => None,
    }
}

/// What the rotor is, as attributes of the screw's joint, at a step in s.
pub fn screw_attributes(bench: &BenchDescription, step_s: f64) -> String {
    let drag = bench.sum(|t| if let Term::Drag { coefficient } = t { Some(*coefficient) } else { None });
    let damping = if drag == 0.0 { num(bench.damping) } else { nums(&[bench.damping, drag, 0.0]) };
    let mut attributes = format!(" armature=\"{}\" damping=\"{damping}\"", num(bench.inertia));
    if bench.terms().any(|(_, t)| t.dry_friction().is_some()) {
        attributes += &held_by(bench.sum(Term::dry_friction), step_s);
    }
    attributes
}

/// Dry friction of a joint at a step in s; nothing for none.
pub fn rubbing(friction: f64, step_s: f64) -> String {
    if friction > 0.0 { held_by(friction, step_s) } else { String::new() }
}

fn held_by(friction: f64, step_s: f64) -> String {
    format!(" frictionloss=\"{}\" {}", num(friction), holding(step_s))
}

fn tendons(o: &mut String, bench: &BenchDescription) {
    let mut inner = String::new();
    let mut deflection = vec![("screw", 1.0)];
    deflection.extend(beside_screw(bench));
    let carried =
        if bench.series().is_none() && bench.output != Output::Held { bench.sprung_mass } else { 0.0 };
    let spring = spring_attributes(bench, bench.spring_damping(), bench.gap(), carried);
    fixed(&mut inner, "deflection", &spring, &deflection);
    yielding(&mut inner, bench, "", "screw", &deflection);
    if let (Some((stiffness, _)), Output::Pendulum { arm_m, .. }) = (bench.series(), bench.output) {
        let spring = format!(" stiffness=\"{}\"{}", num(stiffness), slack(bench));
        fixed(&mut inner, "series", &spring, &[("screw_end", 1.0), ("lever", -arm_m)]);
    }
    let _ = writeln!(o, "  <tendon>\n{inner}  </tendon>");
}

/// The spring between rotor and output as attributes of the tendon that has its deflection; `carried` is the mass, kg, that
/// moves by it.
pub fn spring_attributes(bench: &BenchDescription, damping: f64, gap: f64, carried: f64) -> String {
    let mut spring = format!(" stiffness=\"{}\"", stiffness(bench));
    if damping > 0.0 {
        let _ = write!(spring, " damping=\"{}\"", num(damping));
    }
    if gap > 0.0 {
        let _ = write!(spring, " springlength=\"{}\"", nums(&[-0.5 * gap, 0.5 * gap]));
    } else {
        spring.push_str(slack(bench));
    }
    if carried > 0.0 {
        let _ = write!(spring, " armature=\"{}\"", num(carried));
    }
    spring
}

/// Without it a tendon is slack where its joints' own springs are.
fn slack(bench: &BenchDescription) -> &'static str {
    if cable(bench).is_empty() { "" } else { " springlength=\"0\"" }
}

fn drive(o: &mut String, bench: &BenchDescription) {
    let attributes = drive_attributes(bench, bench.command_limit(), step_s(bench));
    let _ = writeln!(o, "  <actuator>\n    <general name=\"motor\" joint=\"screw\"{attributes}/>");
    for (_, term) in bench.terms() {
        o.push_str(&cogging(bench, term, "cogging", "screw"));
    }
    o.push_str(&offset(bench, "output_offset", "lever"));
    let _ = writeln!(o, "  </actuator>");
}

/// Gain, limit and delay of the motor at a step in s.
pub fn drive_attributes(bench: &BenchDescription, limit: Option<f64>, step_s: f64) -> String {
    let mut attributes = format!(" gainprm=\"{}\"", num(bench.gain));
    if bench.offset_force != 0.0 {
        let _ =
            write!(attributes, " biastype=\"affine\" biasprm=\"{}\"", nums(&[bench.offset_force, 0.0, 0.0]));
    }
    if let Some(limit) = limit {
        let _ = write!(attributes, " ctrlrange=\"{}\"", nums(&[-limit, limit]));
    }
    attributes + &delayed(bench.delay_s(), step_s)
}

/// A torque ripple as a motor without current, of which the cogging is left, at the rotor; nothing for another term.
pub fn cogging(bench: &BenchDescription, term: &Term, name: &str, joint: &str) -> String {
    let Term::Ripple { amplitude, cycles, phase } = *term else { return String::new() };
    format!(
        "    <dcmotor name=\"{name}\" joint=\"{joint}\" gear=\"{}\" input=\"none\" motorconst=\"0\" resistance=\"1\" cogging=\"{}\"/>\n",
        num(1.0 / bench.travel_per_rad),
        nums(&[amplitude * bench.travel_per_rad, cycles, phase])
    )
}
