//! The Python beside drives at joints: their sensors, and callbacks for what MuJoCo has no element for.

use super::callback::{PRELUDE, of_spring, quantisation, slips};
use super::law::{drive_limits, evaluated, friction_bound, own};
use super::stages;
use crate::Note;
use crate::driven::{Command, DrivenJoint, DrivenRobot};
use crate::term::Term;
use crate::text::{head, module, num};
use sealegs_actuator::plant::{Servo, Winding};
use std::fmt::Write;

pub fn python(robot: &DrivenRobot, stem: &str, notes: &[Note]) -> String {
    let (module, class) = (module(stem), class(robot));
    let mut out = String::from("\"\"\"");
    out.push_str(
        &head(&format!("{} for MuJoCo 4: what {stem}.xml has no element for", robot.title), notes).join("\n"),
    );
    let variable = class.to_lowercase();
    let _ = write!(
        out,
        "\n\nUse, every callback being put in after the model has been loaded:\n\n    model = \
         mujoco.MjModel.from_xml_path(\"{stem}.xml\")\n    data = mujoco.MjData(model)\n    {variable} = {module}.{class}(model)\n"
    );
    for joint in robot.joints.iter().take(2) {
        let _ = writeln!(
            out,
            "    data.actuator(\"{}\").ctrl = 0.1  # {}",
            crate::text::comment_line(&joint.name),
            joint.drive.input
        );
    }
    let _ =
        write!(out, "    mujoco.mj_step(model, data)\n    {variable}.channels(data)\n\"\"\"\n\n{PRELUDE}\n");
    let drives: Vec<_> = robot.joints.iter().map(|joint| (&joint.drive, shown(joint))).collect();
    stages::write(&mut out, &drives);
    out.push_str(include_str!("driven.py"));
    if robot.joints.iter().any(|j| j.winding().is_some()) {
        out.push_str(include_str!("winding.py"));
    }
    if robot.joints.iter().any(|j| matches!(j.command, Command::Goal(..))) {
        out.push_str(include_str!("servo.py"));
    }
    if robot.joints.iter().any(|j| j.coupling.is_some()) {
        out.push_str(include_str!("coupled.py"));
    }
    for (i, joint) in robot.joints.iter().enumerate() {
        drive(&mut out, joint, i + 1);
    }
    opening(&mut out, robot, class);
    channels(&mut out, robot);
    out
}

/// A joint's channels: as its drive's own bench and as the file calls them.
fn shown(joint: &DrivenJoint) -> Vec<(&str, &str)> {
    joint.channels.iter().map(|(at, here)| (at.as_str(), here.as_str())).collect()
}

/// The name of the Python class.
pub fn class(robot: &DrivenRobot) -> &'static str {
    if robot.is_bench { "Bench" } else { "Robot" }
}

/// A name as a Python string.
fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
}

/// Whether the Python sets the bound of the dry friction.
pub fn rubs(joint: &DrivenJoint) -> bool {
    friction_bound(&joint.drive).is_some()
}

fn drive(out: &mut String, joint: &DrivenJoint, number: usize) {
    let base = match joint.command {
        Command::Effort | Command::Impedance(_) => "Drive",
        Command::Voltage(_) => "Winding",
        Command::Goal(..) => "Servo",
    };
    let name = crate::text::comment_line(&joint.name);
    let coupled = if joint.coupling.is_some() { "Coupled, " } else { "" };
    let _ = writeln!(
        out,
        "\n\nclass Drive{number}({coupled}{base}):\n    \"\"\"The drive of the joint '{name}'.\"\"\""
    );
    let mut values = Vec::new();
    if joint.arm != 1.0 {
        values.push((if joint.coupling.is_some() { "lever" } else { "arm" }, num(joint.arm)));
    }
    if joint.drive.delay_s() > 0.0 {
        values.push(("late", "True".to_owned()));
    }
    if let Some(coupling) = joint.coupling.as_ref().filter(|c| c.in_contact) {
        values.push(("contact_damping", num(coupling.damping)));
        values.push(("half_gap", num(0.5 * coupling.gap)));
    }
    match &joint.command {
        Command::Effort | Command::Impedance(_) => {}
        Command::Voltage(winding) => {
            values.extend(winding_values(winding, joint.drive.offset_force / joint.drive.gain));
        }
        Command::Goal(winding, servo) => {
            values.extend(winding_values(winding, servo.goal_offset));
            values.extend(servo_values(servo));
        }
    }
    if !values.is_empty() {
        out.push('\n');
    }
    for (field, value) in values {
        let _ = writeln!(out, "    {field} = {value}");
    }
    spring(out, joint);
    if let Some(bound) = friction_bound(&joint.drive) {
        out.push_str("\n    def friction(self, y, speed, direction, load):\n");
        if joint.drive.terms().any(|(_, term)| matches!(term, Term::Bound { .. })) {
            out.push_str("        y_dot, F_bs = speed, load()  # noqa: F841\n");
        }
        let _ = writeln!(out, "        return {bound}");
    }
    if let Some((count, rounding)) = quantisation(&joint.drive) {
        let _ = writeln!(
            out,
            "\n    def quantised(self, u):\n        return sign(u) * {count} * int(abs(u) / {count} + {} + 1e-9)",
            num(0.5 * rounding),
            count = num(count)
        );
    }
    beside(out, joint);
}

/// The force of the spring between rotor and joint.
fn spring(out: &mut String, joint: &DrivenJoint) {
    let Some(coupling) = &joint.coupling else { return };
    if slips(&joint.drive).is_some() {
        let tendon = quoted(&format!("{}_clamp_slip", joint.name));
        let _ = write!(
            out,
            "\n    def __init__(self, model, joint):\n        super().__init__(model, joint)\n        self.clamp = \
             model.tendon_plasticadr[model.tendon({tendon}).id]\n"
        );
    }
    out.push_str("\n    def spring_force(self, delta, delta_dot, data):\n");
    of_spring(out, &joint.drive, coupling.gap, (coupling.damping, coupling.in_contact));
    out.push_str("        return force\n");
}

fn winding_values(winding: &Winding, offset: f64) -> Vec<(&'static str, String)> {
    let mut values =
        vec![("constant", num(winding.force_per_current)), ("resistance_ohm", num(winding.resistance_ohm))];
    if winding.supply_v.is_finite() {
        values.push(("supply_v", num(winding.supply_v)));
    }
    if offset != 0.0 {
        values.push(("offset", num(offset)));
    }
    values
}

fn servo_values(servo: &Servo) -> Vec<(&'static str, String)> {
    let mut values = vec![("proportional", num(servo.proportional))];
    for (name, value, neutral) in [
        ("derivative", servo.derivative, 0.0),
        ("integral", servo.integral, 0.0),
        ("dead_band", servo.dead_band, 0.0),
        ("feedback_delay_s", servo.feedback_delay_s, 0.0),
        ("duty_limit", servo.limit, 1.0),
    ] {
        if value != neutral {
            values.push((name, num(value)));
        }
    }
    values.extend(servo.period_s.map(|period| ("period_s", num(period))));
    values
}

/// Whether the Python adds a force at a joint.
fn acts(joint: &DrivenJoint) -> bool {
    joint.winding().is_some()
        || !limits(joint).is_empty()
        || places(joint).iter().any(|place| own(&joint.drive, place).next().is_some())
}

/// Where a user's own law may act on a drive's motion: the output's is the rotor's unless they move on their own.
fn places(joint: &DrivenJoint) -> &'static [&'static str] {
    if joint.coupling.is_some() { &["rotor"] } else { &["rotor", "output"] }
}

fn limits(joint: &DrivenJoint) -> String {
    let winding = match &joint.command {
        Command::Effort | Command::Impedance(_) => None,
        Command::Voltage(winding) | Command::Goal(winding, _) => Some(winding),
    };
    drive_limits(&joint.drive, winding)
}

fn beside(out: &mut String, joint: &DrivenJoint) {
    if !acts(joint) {
        return;
    }
    let (drive, limits) = (&joint.drive, limits(joint));
    let winding = joint.winding().is_some();
    if winding && !limits.is_empty() {
        let _ = write!(out, "\n    def limited(self, force, y_dot):\n{limits}        return force\n");
    }
    out.push_str(
        "\n    def beside(self, data):\n        \"\"\"Force along y that MuJoCo's own elements do not make.\"\"\"\n        y, y_dot \
         = self.motion(data)\n",
    );
    if places(joint).iter().any(|place| own(drive, place).next().is_some()) {
        let _ = writeln!(
            out,
            "        t, F_bs = data.time, self.load(data)  # noqa: F841\n        theta, theta_dot = y / {r}, y_dot / {r}  # noqa: \
             F841",
            r = num(drive.travel_per_rad)
        );
    }
    match (winding, limits.is_empty()) {
        (true, _) => out.push_str("        beside = self.beside_motor(data, y, y_dot)\n"),
        (false, true) => out.push_str("        beside = 0.0\n"),
        (false, false) => {
            let u = match (&joint.command, drive.command_limit()) {
                (Command::Impedance(servo), _) => looped(joint, servo),
                (_, Some(limit)) => {
                    format!("min(max(self.command(data), -{limit}), {limit})", limit = num(limit))
                }
                (_, None) => "self.command(data)".to_owned(),
            };
            let _ = write!(
                out,
                "        commanded = force = {} * {u} + {}\n{limits}        beside = force - commanded\n",
                num(drive.gain),
                num(drive.offset_force)
            );
        }
    }
    for law in own(drive, "rotor") {
        out.push_str(&evaluated(law, "law", 8));
        out.push_str("        beside -= law\n");
    }
    for law in own(drive, "output").filter(|_| joint.coupling.is_none()) {
        out.push_str("        theta, theta_dot = y / self.arm, y_dot / self.arm  # noqa: F841\n");
        out.push_str(&evaluated(law, "law", 8));
        out.push_str("        beside -= law / self.arm\n");
    }
    out.push_str("        return beside\n");
}

/// The torque that a loop commands, as Python.
fn looped(joint: &DrivenJoint, servo: &Servo) -> String {
    let free = format!(
        "{} * (self.command(data) + {} - y) - {} * y_dot",
        num(servo.proportional),
        num(servo.goal_offset),
        num(servo.derivative)
    );
    let most = joint.most_of(servo, &joint.drive) / joint.drive.gain.abs();
    if most.is_finite() {
        format!("min(max({free}, -{most}), {most})", most = num(most))
    } else {
        format!("({free})")
    }
}

fn opening(out: &mut String, robot: &DrivenRobot, class: &str) {
    let _ = write!(
        out,
        "\n\nclass {class}:\n    \"\"\"The drives with their sensors, and the callbacks.\"\"\"\n\n    def __init__(self, model):\n        \
         self.model = model\n        self.signature = model.signature\n        self.drives = [\n"
    );
    for (i, joint) in robot.joints.iter().enumerate() {
        let _ = writeln!(out, "            Drive{}(model, {}),", i + 1, quoted(&joint.name));
    }
    out.push_str("        ]\n        self.stages = stages()\n");
    let control = robot.joints.iter().any(|j| rubs(j) || quantisation(&j.drive).is_some());
    let touches = robot.joints.iter().any(|j| j.coupling.as_ref().is_some_and(|c| c.in_contact));
    let passive = touches || robot.joints.iter().any(acts);
    if control {
        out.push_str("        mujoco.set_mjcb_control(self._control)\n");
    }
    if passive {
        out.push_str("        mujoco.set_mjcb_passive(self._passive)\n");
    }
    let guard = "        if model.signature != self.signature:\n            return\n        for drive in self.drives:\n";
    if control {
        let _ = write!(
            out,
            "\n    def _control(self, model, data):\n{guard}            if drive.quantised:\n                \
             data.ctrl[drive.motor] = drive.quantised(data.ctrl[drive.motor])\n            if drive.friction:\n                \
             drive.rub(data)\n"
        );
    }
    if passive {
        let _ = write!(
            out,
            "\n    def _passive(self, model, data):\n{guard}            if drive.beside:\n                \
             data.qfrc_passive[drive.rate] += drive.arm * drive.beside(data)\n"
        );
        if touches {
            out.push_str("            if drive.coupled:\n                drive.touch(data)\n");
        }
    }
}

fn channels(out: &mut String, robot: &DrivenRobot) {
    out.push_str(
        "\n    def channels(self, data):\n        \"\"\"The channels at this instant, before the sensors, as a campaign calls \
         them.\"\"\"\n        mujoco.mj_forward(self.model, data)\n        channels = {}\n",
    );
    for (i, joint) in robot.joints.iter().enumerate() {
        let _ = writeln!(out, "        drive = self.drives[{i}]");
        for (at_drive, shown) in &joint.channels {
            let value = match at_drive.as_str() {
                "motor_angle_rad" => format!("drive.motion(data)[0] / {}", num(joint.drive.travel_per_rad)),
                "force_1_n" | "force_2_n" | "output_torque_nm" => "drive.load(data)".to_owned(),
                "spring_deflection_m" | "spring_deflection_rad" => {
                    "data.ten_length[drive.deflection]".to_owned()
                }
                "spring_torque_nm" => {
                    format!("{} * data.ten_length[drive.deflection]", num(joint.drive.nominal_stiffness))
                }
                "speed_m_s" | "speed_rad_s" => "data.qvel[drive.joint_rate]".to_owned(),
                _ => "data.qpos[drive.joint_position]".to_owned(),
            };
            let _ = writeln!(out, "        channels[{}] = {value}", quoted(shown));
        }
    }
    out.push_str(
        "        return channels\n\n    def sense(self, data):\n        \"\"\"The channels behind the sensors: to be called \
         after every step, and once before the first.\"\"\"\n        channels = self.channels(data)\n        for name, stage in \
         self.stages:\n            channels[name] = stage.step(channels[name], self.model.opt.timestep)\n        return \
         channels\n",
    );
}
