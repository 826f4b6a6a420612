//! The Python beside a bench for MuJoCo: read-outs of its sensors, and callbacks for what MuJoCo has no element for.

use super::bench::beside_screw;
use super::law::{drive_limits, evaluated, friction_bound, own};
use super::stages;
use crate::Note;
use crate::bench::{BenchDescription, Output};
use crate::term::Term;
use crate::text::{head, module, num};
use std::fmt::Write;

/// Functions of a user's own law that Python's `math` calls otherwise or has not.
pub const PRELUDE: &str = "from math import atan, cos, exp, pi, sin, sqrt, tan, tanh  # noqa: F401
from math import log as ln  # noqa: F401

import mujoco
import numpy


def sign(x):
    return int(x > 0) - int(x < 0)


def square(x):
    return x * x
";

pub fn python(bench: &BenchDescription, stem: &str, notes: &[Note]) -> String {
    let module = module(stem);
    let mut out = String::from("\"\"\"");
    out.push_str(
        &head(&format!("{} for MuJoCo 4: what {stem}.xml has no element for", bench.name), notes).join("\n"),
    );
    let _ = write!(
        out,
        "\n\nUse, every callback being put in after the model has been loaded:\n\n    model = \
         mujoco.MjModel.from_xml_path(\"{stem}.xml\")\n    data = mujoco.MjData(model)\n    bench = {module}.Bench(model)\n    \
         data.ctrl[0] = 1.0  # {}\n    mujoco.mj_step(model, data)\n    bench.channels(data)\n\"\"\"\n\n{PRELUDE}\n",
        bench.input
    );
    stages::write(&mut out, &[(bench, bench.channels.iter().map(|c| (*c, *c)).collect())]);
    out.push_str("\nclass Bench:\n    \"\"\"The bench's sensors, and its callbacks.\"\"\"\n\n");
    opening(&mut out, bench);
    forces(&mut out, bench);
    channels(&mut out, bench);
    callbacks(&mut out, bench);
    out
}

fn opening(out: &mut String, bench: &BenchDescription) {
    let _ = write!(
        out,
        "    def __init__(self, model):\n        self.model = model\n        self.signature = model.signature\n        \
         self.deflection = model.tendon(\"deflection\").id\n"
    );
    for joint in joints(bench) {
        let _ = writeln!(
            out,
            "        self.{joint} = model.joint(\"{joint}\").qposadr[0]\n        self.{joint}_rate = \
             model.joint(\"{joint}\").dofadr[0]"
        );
    }
    if slips(bench).is_some() {
        out.push_str("        self.clamp = model.tendon_plasticadr[model.tendon(\"clamp_slip\").id]\n");
    }
    out.push_str("        self.stages = stages()\n");
    if warms(bench) {
        out.push_str("        self.heat = self.heated_s = 0.0\n");
    }
    if friction_bound(bench).is_some() || quantisation(bench).is_some() {
        out.push_str("        mujoco.set_mjcb_control(self._control)\n");
    }
    if has_passive(bench) {
        out.push_str(
            "        self.buffer = numpy.zeros(1)\n        mujoco.set_mjcb_passive(self._passive)\n",
        );
    }
}

fn joints(bench: &BenchDescription) -> Vec<&'static str> {
    let mut joints = vec!["screw"];
    if bench.series().is_some() {
        joints.push("screw_end");
    }
    if bench.output != Output::Held {
        joints.push("lever");
    }
    joints
}

pub fn slips(bench: &BenchDescription) -> Option<f64> {
    bench.find(|t| match *t {
        Term::SpringSlip { stiffness, force } if force > 0.0 => Some(stiffness),
        _ => None,
    })
}

pub fn quantisation(bench: &BenchDescription) -> Option<(f64, f64)> {
    bench.find(|t| match *t {
        Term::Quantisation { count, rounding } if count > 0.0 => Some((count, rounding)),
        _ => None,
    })
}

fn warms(bench: &BenchDescription) -> bool {
    bench.terms().any(|(_, t)| matches!(t, Term::Warming { .. }))
}

fn has_passive(bench: &BenchDescription) -> bool {
    !drive_limits(bench, None).is_empty()
        || ["rotor", "spring", "output"].iter().any(|p| own(bench, p).next().is_some())
}

fn forces(out: &mut String, bench: &BenchDescription) {
    out.push_str(
        "\n    def extension(self, data):\n        \"\"\"Extension y and speed of the screw.\"\"\"\n        return \
         data.qpos[self.screw], data.qvel[self.screw_rate]\n\n    def spring_force(self, data):\n        \"\"\"Force of the \
         spring on link 1, positive in compression.\"\"\"\n        delta, delta_dot = data.ten_length[self.deflection], \
         data.ten_velocity[self.deflection]\n",
    );
    of_spring(out, bench, bench.gap(), (bench.spring_damping(), false));
    if own(bench, "spring").next().is_some() {
        out.push_str("        force += self._beside_spring(left, delta_dot)\n");
    }
    out.push_str("        return force\n");
    let acceleration = match beside_screw(bench) {
        Some((joint, coef)) => {
            format!("data.qacc[self.screw_rate] + {} * data.qacc[self.{joint}_rate]", num(coef))
        }
        None => "data.qacc[self.screw_rate]".to_owned(),
    };
    let _ = write!(
        out,
        "\n    def screw_force(self, data):\n        \"\"\"Force in the screw, positive in compression, with the latest \
         acceleration.\"\"\"\n        return self.spring_force(data) + {} * ({acceleration})\n",
        num(bench.sprung_mass)
    );
}

/// Lines that turn a deflection `delta` and its rate `delta_dot` into the `force` of the spring, whose damping may act in contact
/// only.
pub fn of_spring(out: &mut String, bench: &BenchDescription, gap: f64, (damping, in_contact): (f64, bool)) {
    if gap > 0.0 {
        let half = num(0.5 * gap);
        let _ = writeln!(out, "        left = delta - min(max(delta, -{half}), {half})");
    } else {
        out.push_str("        left = delta\n");
    }
    let _ = writeln!(out, "        force = {} * left", num(bench.stiffness));
    let cubic = bench.cubic();
    if cubic != 0.0 {
        let _ = writeln!(out, "        force += {} * left**3", num(cubic));
    }
    if damping > 0.0 {
        let contact = if in_contact { " * (left != 0.0)" } else { "" };
        let _ = writeln!(out, "        force += {} * delta_dot{contact}", num(damping));
    }
    if let Some(stiffness) = slips(bench) {
        let _ = writeln!(out, "        force += {} * (delta - data.plastic[self.clamp])", num(stiffness));
    }
}

fn channels(out: &mut String, bench: &BenchDescription) {
    out.push_str(
        "\n    def channels(self, data):\n        \"\"\"The bench's channels at this instant, before its sensors, as a \
         campaign calls them.\"\"\"\n        mujoco.mj_forward(self.model, data)\n        y, _ = \
         self.extension(data)\n        return {\n",
    );
    for channel in &bench.channels {
        let force_2 = match (bench.series(), bench.output) {
            (Some((k, _)), Output::Held) => format!("{} * data.qpos[self.screw_end]", num(k)),
            (Some((k, _)), Output::Pendulum { arm_m, .. }) => {
                format!("{} * (data.qpos[self.screw_end] - {} * data.qpos[self.lever])", num(k), num(arm_m))
            }
            (None, _) => "self.screw_force(data)".to_owned(),
        };
        let value = match *channel {
            "force_1_n" | "output_torque_nm" => "self.spring_force(data)".to_owned(),
            "force_2_n" => force_2,
            "motor_angle_rad" => format!("y / {}", num(bench.travel_per_rad)),
            "joint_angle_rad" => "data.qpos[self.lever]".to_owned(),
            "spring_torque_nm" => {
                format!("{} * data.ten_length[self.deflection]", num(bench.nominal_stiffness))
            }
            _ => "data.ten_length[self.deflection]".to_owned(),
        };
        let _ = writeln!(out, "            \"{channel}\": {value},");
    }
    out.push_str(
        "        }\n\n    def sense(self, data):\n        \"\"\"The channels behind the sensors: to be called after every \
         step, and once before the first.\"\"\"\n        channels = self.channels(data)\n        for name, stage in \
         self.stages:\n            channels[name] = stage.step(channels[name], self.model.opt.timestep)\n        return \
         channels\n",
    );
}

fn callbacks(out: &mut String, bench: &BenchDescription) {
    let bound = friction_bound(bench);
    let quantisation = quantisation(bench);
    if bound.is_some() || quantisation.is_some() {
        out.push_str(
            "\n    def _control(self, model, data):\n        if model.signature != self.signature:\n            return\n",
        );
        if let Some((count, rounding)) = quantisation {
            let _ = writeln!(
                out,
                "        u = data.ctrl[0]\n        data.ctrl[0] = sign(u) * {count} * int(abs(u) / {count} + {} + 1e-9)",
                num(0.5 * rounding),
                count = num(count)
            );
        }
        if let Some(bound) = bound {
            // Below this speed it is at rest: a constraint that holds creeps a hundred times slower.
            let _ = writeln!(
                out,
                "        speed = data.qvel[self.screw_rate]\n        pushed = data.actuator_force[0] - \
                 self.spring_force(data)\n        direction = sign(speed if abs(speed) > 1e-8 else pushed)  # noqa: \
                 F841\n        load = lambda: self.screw_force(data)  # noqa: E731, F841"
            );
            if bench.terms().any(|(_, term)| matches!(term, Term::Bound { .. })) {
                out.push_str("        y, y_dot = self.extension(data)  # noqa: F841\n        F_bs = load()  # noqa: F841\n");
            }
            if warms(bench) {
                // Every run begins cold, and Runge-Kutta asks several times within a step.
                out.push_str(
                    "        if data.time < self.heated_s:\n            self.heat = self.heated_s = 0.0\n        self.heat += \
                     model.dof_frictionloss[self.screw_rate] * abs(speed) * (data.time - self.heated_s)\n        \
                     self.heated_s = data.time\n",
                );
            }
            let _ = writeln!(out, "        model.dof_frictionloss[self.screw_rate] = {bound}");
        }
    }
    if own(bench, "spring").next().is_some() {
        let _ = write!(
            out,
            "\n    def _beside_spring(self, delta, delta_dot):\n        F_k, force = {} * delta, 0.0  # noqa: F841\n",
            num(bench.stiffness)
        );
        for law in own(bench, "spring") {
            out.push_str(&evaluated(law, "law", 8));
            out.push_str("        force += law\n");
        }
        out.push_str("        return force\n");
    }
    if has_passive(bench) {
        passive(out, bench);
    }
}

fn passive(out: &mut String, bench: &BenchDescription) {
    out.push_str(
        "\n    def _passive(self, model, data):\n        if model.signature != self.signature:\n            return\n        y, \
         y_dot = self.extension(data)\n        t, F_bs = data.time, self.screw_force(data)  # noqa: F841\n",
    );
    let _ = writeln!(
        out,
        "        theta, theta_dot = y / {r}, y_dot / {r}  # noqa: F841\n        on_screw = 0.0",
        r = num(bench.travel_per_rad)
    );
    for law in own(bench, "rotor") {
        out.push_str(&evaluated(law, "law", 8));
        out.push_str("        on_screw -= law\n");
    }
    let limits = drive_limits(bench, None);
    if !limits.is_empty() {
        let u = if bench.delay_s() > 0.0 {
            "mujoco.mj_readCtrl(model, data, 0, data.time, self.buffer, 1)[0]"
        } else {
            "data.ctrl[0]"
        };
        let u = match bench.command_limit() {
            Some(limit) => format!("min(max({u}, -{limit}), {limit})", limit = num(limit)),
            None => u.to_owned(),
        };
        let _ = write!(
            out,
            "        commanded = force = {} * {u} + {}\n{limits}        on_screw += force - commanded\n",
            num(bench.gain),
            num(bench.offset_force)
        );
    }
    out.push_str("        data.qfrc_passive[self.screw_rate] += on_screw\n");
    if own(bench, "spring").next().is_some() {
        let half = num(0.5 * bench.gap());
        let _ = writeln!(
            out,
            "        delta, delta_dot = data.ten_length[self.deflection], data.ten_velocity[self.deflection]\n        left = \
             delta - min(max(delta, -{half}), {half})\n        beside = self._beside_spring(left, delta_dot)\n        \
             data.qfrc_passive[self.screw_rate] -= beside"
        );
        if let Some((joint, coef)) = beside_screw(bench) {
            let _ = writeln!(out, "        data.qfrc_passive[self.{joint}_rate] -= {} * beside", num(coef));
        }
    }
    let Output::Pendulum { arm_m, .. } = bench.output else { return };
    for law in own(bench, "output") {
        let _ = writeln!(
            out,
            "        theta, theta_dot = data.qpos[self.lever], data.qvel[self.lever_rate]\n        y, y_dot = {arm} * theta, \
             {arm} * theta_dot",
            arm = num(arm_m)
        );
        out.push_str(&evaluated(law, "law", 8));
        out.push_str("        data.qfrc_passive[self.lever_rate] -= law\n");
    }
}
