//! Isaac Lab: a Python module with an articulation's configuration, and the URDF that it loads.

use crate::rigid::{JointDrive, RigidJoint, RigidRobot};
use crate::text::{head, module, num};
use crate::{Exported, Note, urdf};
use std::fmt::Write;

/// The physics step for which delays are counted, s.
const STEP_S: f64 = 1e-3;

pub fn write(robot: &RigidRobot, stem: &str) -> Exported {
    let mut notes = robot.notes.clone();
    notes.push(Note::held(
        "armature, friction",
        "in the actuators' configurations; damping as viscous_friction",
    ));
    for joint in &robot.joints {
        if let Some(drive) = joint.drive.filter(|d| d.delay_s > 0.0) {
            let left = drive.delay_s - steps(&drive) as f64 * STEP_S;
            let how = format!("{} steps of {STEP_S} s; {} s are left over", steps(&drive), num(left));
            notes.push(Note::near(format!("delay at {}", joint.name), how));
            if drive.voltage.is_some() {
                notes.push(Note::lost(
                    format!("voltage limit at {}", joint.name),
                    "Isaac Lab has no drive with a delay and a torque-speed curve",
                ));
            }
        }
    }
    let urdf_name = format!("{}.urdf", module(stem));
    let mut out = String::from("\"\"\"");
    out.push_str(&head(&format!("{} for Isaac Lab 3, written by sealegs", robot.title), &notes).join("\n"));
    let _ = write!(
        out,
        "\n\nEfforts are commanded: stiffness and damping of a drive are those of a spring or of a servo's own loop, where there is one.\n\"\"\"\n\nfrom pathlib \
         import Path\n\nimport isaaclab.sim as sim_utils\nfrom isaaclab.actuators import DCMotorCfg, DelayedPDActuatorCfg, \
         ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n\n# The physics step for which delays are counted, \
         s.\nPHYSICS_DT_S = {}\n\nROBOT_CFG = ArticulationCfg(\n    spawn=sim_utils.UrdfFileCfg(\n        \
         asset_path=str(Path(__file__).with_name(\"{urdf_name}\")),\n        fix_base=True,\n        joint_drive=sim_utils.UrdfConverterCfg.JointDriveCfg(\n            \
         target_type=\"none\", gains=sim_utils.UrdfConverterCfg.JointDriveCfg.PDGainsCfg(stiffness=0.0, damping=0.0)\n        ),\n    \
         ),\n    actuators={{\n",
        num(STEP_S)
    );
    for joint in &robot.joints {
        if let Some(drive) = &joint.drive {
            actuator(&mut out, joint, drive);
        }
    }
    out.push_str("    },\n)\n");
    // Losses are the actuators'; the URDF's own would count twice.
    let mut bare = robot.clone();
    for joint in bare.joints.iter_mut().filter(|j| j.drive.is_some()) {
        (joint.damping, joint.friction) = (0.0, 0.0);
    }
    Exported { text: out, beside: vec![(urdf_name, urdf::write(&bare, stem).text)], notes }
}

fn steps(drive: &JointDrive) -> u64 {
    (drive.delay_s / STEP_S).round() as u64
}

fn actuator(out: &mut String, joint: &RigidJoint, drive: &JointDrive) {
    let mut fields = vec![
        ("stiffness", num(drive.spring)),
        ("damping", if drive.derivative == 0.0 { "0.0".to_owned() } else { num(drive.derivative) }),
        ("armature", num(drive.armature)),
        ("friction", num(drive.friction_at_rest.max(joint.friction))),
        ("dynamic_friction", num(joint.friction)),
        ("viscous_friction", num(joint.damping)),
    ];
    let class = match (steps(drive), drive.voltage) {
        (0, Some((stall, speed))) => {
            fields.push(("saturation_effort", num(stall)));
            fields.push(("actuator_velocity_limit", num(speed)));
            fields.push(("actuator_effort_limit", num(joint.limits.effort.min(stall))));
            "DCMotorCfg"
        }
        (0, None) => "ImplicitActuatorCfg",
        (n, _) => {
            fields.push(("min_delay", n.to_string()));
            fields.push(("max_delay", n.to_string()));
            "DelayedPDActuatorCfg"
        }
    };
    if class != "DCMotorCfg" && joint.limits.effort.is_finite() {
        let field =
            if class == "ImplicitActuatorCfg" { "joint_effort_limit" } else { "actuator_effort_limit" };
        fields.push((field, num(joint.limits.effort)));
    }
    let name = joint.name.replace(['"', '\\'], "_");
    let _ = writeln!(out, "        \"{name}\": {class}(\n            joint_names_expr=[\"{name}\"],");
    for (field, value) in fields {
        let _ = writeln!(out, "            {field}={value},");
    }
    out.push_str("        ),\n");
}
