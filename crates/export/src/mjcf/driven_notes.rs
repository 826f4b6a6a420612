//! What became of everything that drives at joints include, in a file for MuJoCo and in the Python beside it.

use super::SHORTEST_DELAY;
use super::driven::step_s;
use super::driven_callback::class;
use super::shape::has_mesh;
use crate::Note;
use crate::driven::{Command, DrivenJoint, DrivenRobot};
use crate::joint_note::of_the_robot;
use crate::term::Term;
use crate::text::{module, num};

pub fn notes(robot: &DrivenRobot, stem: &str) -> Vec<Note> {
    let (python, class) = (format!("{}.py", module(stem)), class(robot));
    let mut notes = vec![Note::held("rotors", "armature and damping of their joints")];
    for joint in &robot.joints {
        command(joint, &python, &mut notes);
    }
    for joint in robot.joints.iter().filter(|j| j.sprung) {
        notes.push(Note::held(format!("spring of {}", joint.name), between(joint)));
    }
    let read = format!("{python}: {class}(model).channels(data) gives them as a campaign calls them");
    notes.push(Note::callback("sensors", read));
    for joint in &robot.joints {
        for (id, term) in joint.drive.terms() {
            notes.push(effect(&robot.id_of(joint, id), term, joint, (&python, class), step_s(robot)));
        }
    }
    if !robot.starts.is_empty() {
        notes.push(Note::held(
            "starts of the runs",
            "keys, by the run's name: position and speed of every joint",
        ));
    }
    if has_mesh(&robot.robot) {
        notes.push(Note::lost("meshes", "shapes only; inertias are those of the links"));
    }
    if robot
        .robot
        .joints
        .iter()
        .any(|j| j.dof.is_some() && j.limits.lower.is_finite() && j.limits.upper.is_finite())
    {
        notes.push(Note::near(
            "joint limits",
            "range of the joints as the URDF states it: the model itself has no stops",
        ));
    }
    notes.extend(of_the_robot(robot));
    notes
}

/// What takes the command.
fn command(joint: &DrivenJoint, python: &str, notes: &mut Vec<Note>) {
    let (name, input) = (&joint.name, &joint.drive.input);
    match &joint.command {
        Command::Effort => {
            notes.push(Note::held(
                format!("command {input}"),
                format!("actuator '{name}', in the column's unit"),
            ));
        }
        Command::Voltage(_) => {
            notes.push(Note::held(
                format!("command {input}"),
                format!("dcmotor '{name}', in V: its back-EMF is held, too"),
            ));
            let how = format!("{python}: drive.enabled = False opens the bridge: no torque, no back-EMF");
            notes.push(Note::callback("enable", how));
        }
        Command::Impedance(servo) => {
            let how = format!(
                "actuator '{name}': stiffness as gain and bias, damping as bias, greatest torque as forcerange"
            );
            notes.push(Note::held(format!("command {input}"), how));
            let unheld = [
                ("dead_band_rad", servo.dead_band != 0.0),
                ("feedback_delay_s", servo.feedback_delay_s != 0.0),
                ("rate_hz", servo.period_s.is_some()),
            ];
            for (what, _) in unheld.into_iter().filter(|(_, is)| *is) {
                notes.push(Note::lost(
                    format!("{what} of the loop"),
                    "MuJoCo's own loop is continuous and sees no age",
                ));
            }
            if joint.coupling.is_some() && !servo.sees_rotor {
                notes.push(Note::near(
                    "position loop",
                    "it sees the rotor's position, where it should see the joint's",
                ));
            }
            let how = "in the control: goal + (feedforward + derivative * speed) / proportional";
            notes.push(Note::held("goal_speed_rad_s, feedforward_nm", how));
        }
        Command::Goal(_, servo) => {
            if joint.coupling.is_some() && servo.sees_rotor {
                notes.push(Note::near(
                    "position loop",
                    "it sees the joint's position, where it should see the rotor's",
                ));
            }
            let how = format!("actuator '{name}': gain, duty limit as forcerange; dcmotor '{name}_back_emf'");
            notes.push(Note::held(format!("command {input}"), how));
            let mut more = Vec::new();
            for (what, is) in [
                ("integral", servo.integral != 0.0),
                ("dead band", servo.dead_band != 0.0),
                ("age of the feedback", servo.feedback_delay_s != 0.0),
                ("sampling period", servo.period_s.is_some()),
            ] {
                if is {
                    more.push(what);
                }
            }
            if !more.is_empty() {
                let how = format!("{python}: {} of the servo's loop", more.join(", "));
                notes.push(Note::callback("position loop", how));
            }
            let how = format!(
                "{python}: drive.supply_v and drive.proportional may be set; drive.enabled = False opens the bridge. The file has \
                 {} V and {} per rad",
                num(servo.per_given()),
                num(servo.proportional)
            );
            notes.push(Note::callback("supply, gain, enable", how));
        }
    }
}

/// Where the rotor meets the joint.
fn between(joint: &DrivenJoint) -> String {
    format!("tendon '{0}_deflection' between the joints '{0}_rotor' and '{0}'", joint.name)
}

/// What becomes of an effect.
fn effect(id: &str, term: &Term, joint: &DrivenJoint, (python, class): (&str, &str), step_s: f64) -> Note {
    let callback = |how: &str| Note::callback(id, format!("{python}: {how}"));
    let bridge = joint.winding().is_some();
    let (rotor, parted) = (joint.at_rotor().0, joint.coupling.is_some());
    let name = &joint.name;
    match term {
        Term::Coulomb { .. } => Note::held(id, format!("frictionloss of the joint '{rotor}'")),
        Term::Stribeck { .. }
        | Term::LoadFriction { .. }
        | Term::ByPower { .. }
        | Term::Warming { .. }
        | Term::Bound { .. }
        | Term::DirectedFriction { .. } => {
            callback(&format!("sets the frictionloss of the joint '{rotor}' at every step"))
        }
        Term::Presliding { .. } => {
            Note::held(id, format!("tendon '{name}_presliding': a spring with springyield, at a finer step"))
        }
        Term::Drag { .. } => Note::held(id, format!("quadratic damping of the joint '{rotor}'")),
        Term::Ripple { .. } => Note::held(id, "cogging of a dcmotor without current"),
        Term::CommandLimit { .. } if bridge => callback("clips the motor's current"),
        Term::CommandLimit { .. } if matches!(joint.command, Command::Impedance(_)) => {
            Note::held(id, format!("forcerange of the actuator '{name}'"))
        }
        Term::CommandLimit { .. } => Note::held(id, format!("ctrlrange of the actuator '{name}'")),
        Term::VoltageLimit { .. } => callback("takes from the motor's force what the voltage does not give"),
        Term::DeadZone { .. } if bridge => callback("takes the bridge's dead zone from the voltage"),
        Term::Sag { .. } if bridge => callback("lowers the voltage by the supply's own resistance"),
        Term::FeedbackDelay if matches!(joint.command, Command::Impedance(_)) => {
            Note::lost(id, "MuJoCo's own loop sees no age")
        }
        Term::FeedbackDelay if matches!(joint.command, Command::Goal(..)) => {
            callback("the loop sees a position of that age")
        }
        Term::Delay { delay_s } if *delay_s < SHORTEST_DELAY * step_s => {
            let least = num(SHORTEST_DELAY * step_s);
            Note::near(id, format!("delay of the actuator '{name}', which is no shorter than {least} s"))
        }
        Term::Delay { .. } => {
            Note::held(id, format!("delay of the actuator '{name}', and half a step for its interpolation"))
        }
        Term::Quantisation { .. } => callback("rounds the control"),
        Term::Mode { .. } | Term::SensorLag { .. } | Term::SensorDelay { .. } => {
            callback(&format!("{class}(model).sense(data) passes the channels through it, step by step"))
        }
        Term::OutputOffset { .. } => {
            Note::held(id, format!("actuator '{name}_output_offset', whose control does nothing"))
        }
        Term::Cable { .. } => Note::held(id, format!("stiffness and springref of the joint '{name}'")),
        Term::Hardening { .. } if parted => Note::held(id, "cubic stiffness of the spring's tendon"),
        Term::SpringDamping { .. } if parted => Note::held(id, "damping of the spring's tendon"),
        Term::SpringSlip { .. } if parted => {
            Note::held(id, format!("tendon '{name}_clamp_slip': a spring with springyield, at a finer step"))
        }
        Term::Transmission if joint.coupling.as_ref().is_some_and(|c| c.in_contact) => {
            callback(&format!("damping while the play is closed; the rest is the {}", between(joint)))
        }
        Term::Backlash { .. } | Term::Transmission if parted => Note::held(id, between(joint)),
        Term::OutputFriction { .. } if parted => {
            Note::held(id, format!("frictionloss of the joint '{name}'"))
        }
        Term::Strength { .. } if !bridge => Note::held(id, format!("gain of the actuator '{name}'")),
        Term::Load => Note::held(id, "mass and place of the body 'load'"),
        Term::Own(own)
            if matches!(own.acts_on.as_str(), "rotor" | "drive") || (own.acts_on == "output" && !parted) =>
        {
            callback("your law as a force")
        }
        Term::Transmission => {
            Note::lost(id, "rotor and load are one body here, which neither yields nor has play")
        }
        _ => Note::lost(id, "this writer has no element for it at a drive without a spring"),
    }
}
