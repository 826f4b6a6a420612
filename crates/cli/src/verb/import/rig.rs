//! What a log may have been recorded on: bench and actuator of a first campaign file.

use super::quoted;
use sealegs::logs::Log;
use sealegs::logs::survey::{ColumnSurvey, Survey};
use std::path::Path;

/// What is measured of a spring that is turned.
const SPRING: [&str; 2] = ["spring_torque_nm", "spring_deflection_rad"];

/// What a column is called that commands torques without those that hold the robot against gravity: libfranka's.
const WITHOUT_GRAVITY: &str = "tau_J_d";

fn columns<'a>(logs: &'a [(&Path, Log, Survey)]) -> impl Iterator<Item = &'a ColumnSurvey> {
    logs.iter().flat_map(|(_, _, s)| &s.tables).flat_map(|t| &t.columns)
}

/// What columns are guessed to be.
fn targets<'a>(logs: &'a [(&Path, Log, Survey)]) -> impl Iterator<Item = &'a str> {
    columns(logs).filter_map(|c| Some(c.role.as_ref()?.target.as_str()))
}

/// What the logs were recorded on, as a campaign file calls it.
pub(super) fn bench(logs: &[(&Path, Log, Survey)], has_urdf: bool) -> &'static str {
    let has = |ending: &str| targets(logs).any(|target| target.ends_with(ending));
    if has_urdf || targets(logs).any(|target| target.contains('.')) {
        "robot"
    } else if has("joint_angle_rad") {
        "pendulum"
    } else if is_sprung(logs) {
        "locked"
    } else if has("motor_angle_rad") {
        "pendulum"
    } else {
        "free"
    }
}

/// Whether a spring is measured, of a drive that is turned or by the load cells of a beam. A drive without one that follows a goal, or
/// whose joint is measured alone, has no load cell of a beam.
fn is_sprung(logs: &[(&Path, Log, Survey)]) -> bool {
    let has = |ending: &str| targets(logs).any(|target| target.ends_with(ending));
    let linear = ["force_1_n", "force_2_n", "spring_deflection_m"].into_iter().any(has);
    SPRING.into_iter().any(has) || (linear && !has("position_rad") && !has("position_m"))
}

/// Bench and actuator that have such columns; the robot's, where its `urdf` is known. The load of a pendulum is left to be stated,
/// unless the runs state it (`loads_are_said`).
pub(super) fn rig(logs: &[(&Path, Log, Survey)], urdf: Option<&str>, loads_are_said: bool) -> String {
    let has = |ending: &str| targets(logs).any(|target| target.ends_with(ending));
    // A goal of the servo's own loop, or the voltage of its motor.
    let impedance = has("goal_speed_rad_s") || has("feedforward_nm");
    let rotary = match has("position_rad") {
        true if impedance => "quasi-direct-drive",
        false if !has("voltage_v") => "rigid-rotary",
        _ => "hobby-servo",
    };
    let slides_only = has(".position_m") && !has("angle_rad");
    let drive = if slides_only { "rigid-linear" } else { rotary };
    let constant = |channel: &str| match has("current_a") && rotary == "rigid-rotary" {
        true => format!(
            "# TODO: its drive takes 1 N m for 1 A. Give the current the scale of yours, as a torque:\n\
             # \"…\" = {{ as = \"{channel}\", scale = N m per A }}, or state torque_constant_nm_a in an actuator file.\n"
        ),
        false => String::new(),
    };
    let bench = bench(logs, urdf.is_some());
    if bench == "robot" {
        let constant = constant("JOINT.torque_nm");
        let pieces = match has("torque_nm") {
            true => {
                "# window_s = 2.0          # where joints under torques drift away in open loop, `check` says how long pieces to cut\n"
            }
            false => "",
        };
        let robot = match urdf {
            Some(urdf) => format!("robot = {}\n", quoted(urdf)),
            None => "robot = \"ROBOT.urdf\"       # TODO: its URDF beside this file, whose joints are called as below\n".to_owned(),
        };
        let gravity = match columns(logs).any(|c| c.role.is_some() && c.name.contains(WITHOUT_GRAVITY)) {
            true => {
                "gravity_compensated = true # the controller adds gravity to what libfranka calls tau_J_d\n"
            }
            false => "",
        };
        let loops = match (has("position_rad"), impedance) {
            (true, true) => {
                "# TODO: a copy of it beside this file with your gains under [servo]: `sealegs list quasi-direct-drive` prints it\n"
            }
            (true, false) => {
                "# TODO: \"quasi-direct-drive\" with your gains in its place, where the controller sends k_p and k_d and a torque (legged robots)\n"
            }
            (false, _) => "",
        };
        return format!(
            "bench = \"robot\"            # columns that are called by a joint\n\
             {robot}{gravity}\
             actuator = \"{drive}\"  # TODO: the drive of its joints; where they differ, see [drive] of a robot's file\n{loops}{constant}{pieces}\
             # An encoder on the motor's side of a gear is JOINT.motor_angle_rad, times the ratio where it is logged at the output.\n"
        );
    }
    if is_sprung(logs) {
        let sprung = if SPRING.into_iter().any(has) { "rmd-x8-rotary-sea" } else { "thor-linear" };
        let load = match bench {
            "pendulum" if !loads_are_said => {
                "mass_kg = 1.0              # TODO: the load of the pendulum, and its distance\nlength_m = 0.1\n"
            }
            _ => "",
        };
        format!(
            "bench = \"{bench}\"         # TODO: what it was recorded on: locked, pendulum, free, robot, leg\n\
             actuator = \"{sprung}\"   # TODO: a preset (`sealegs list`) or an actuator file beside this one\n{load}"
        )
    } else if bench == "pendulum" {
        let constant = constant("joint_torque_nm");
        let load = match loads_are_said {
            true => "",
            false => {
                "# TODO: the load of the pendulum, and its distance; a [[run]] may have its own. On the bench free: inertia_kg_m2.\n\
                 mass_kg = 1.0\nlength_m = 0.1\n"
            }
        };
        format!(
            "bench = \"pendulum\"         # TODO: what it was recorded on: pendulum, free (nothing hangs on it), robot\n\
             actuator = \"{rotary}\"  # no spring is measured; TODO: a preset (`sealegs list`) or a file beside this one\n\
             {load}{constant}"
        )
    } else {
        "bench = \"free\"             # TODO: what it was recorded on: free (a carriage), locked, robot, leg\n\
         actuator = \"rigid-linear\"  # no spring is measured; TODO: a preset (`sealegs list`) or a file beside this one\n\
         mass_kg = 1.0              # TODO: what it moves\n"
            .to_owned()
    }
}
