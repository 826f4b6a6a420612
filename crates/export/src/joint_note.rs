//! What becomes of an effect in a format that has drives at joints only.

use crate::Note;
use crate::driven::DrivenRobot;
use crate::note::of_the_log;
use crate::rigid::Reach;
use crate::term::Term;
use crate::text::num;

/// What a robot of driven joints has or leaves out in every format, its sensors and its logger last.
pub fn of_the_robot(robot: &DrivenRobot) -> Vec<Note> {
    let mut notes = Vec::new();
    if robot.links_fitted {
        notes.push(Note::held("links", "masses, centres and moments as they were fitted"));
    }
    let rubbing: Vec<&str> =
        robot.robot.joints.iter().filter(|j| j.friction > 0.0).map(|j| j.name.as_str()).collect();
    if !rubbing.is_empty() {
        let how = format!("at {}: the model's friction is that of its effects", rubbing.join(", "));
        notes.push(Note::lost("friction in the URDF", how));
    }
    let sensors = robot.joints.iter().flat_map(|j| j.drive.sensors.clone()).collect();
    let logger = robot.joints.first().map_or((false, 0.0), |j| j.drive.logger);
    notes.extend(of_the_log(&sensors, logger));
    notes
}

/// What becomes of an effect at a joint; `rigid` where the spring is left out.
pub fn note(id: &str, term: &Term, reach: Reach, rigid: bool) -> Note {
    match term {
        Term::Coulomb { .. } | Term::OutputFriction { .. } => Note::held(id, "friction of the joint"),
        Term::Stribeck { .. } if reach == Reach::Armature => {
            Note::near(id, "friction and dynamic_friction, without the speed between them")
        }
        Term::Stribeck { .. } => Note::near(id, "friction of the joint: its level in motion"),
        Term::Presliding { .. } => Note::near(id, "friction of the joint, without the elastic part"),
        Term::DirectedFriction { .. } => Note::near(id, "friction of the joint: the mean of both directions"),
        Term::Warming { .. } => Note::near(id, "friction of the joint: what it is while cold"),
        Term::Bound { .. } => Note::lost(id, "the format's friction changes with nothing but speed"),
        Term::CommandLimit { .. } if reach == Reach::Armature && !rigid => {
            Note::lost(id, "an effort limit would clip the spring's force, too: clip the command")
        }
        Term::CommandLimit { .. } => Note::held(id, "effort limit of the joint"),
        Term::VoltageLimit { .. } if reach == Reach::Armature => {
            Note::held(id, "DCMotorCfg, unless there is a delay")
        }
        Term::VoltageLimit { .. } => Note::near(id, "velocity limit of the joint: the speed at no load"),
        Term::Delay { .. } if reach == Reach::Armature => {
            Note::held(id, "DelayedPDActuatorCfg, in whole steps")
        }
        Term::SpringDamping { .. } if !rigid => Note::near(id, "damping of the joint"),
        Term::Mode { .. } | Term::SensorLag { .. } | Term::SensorDelay { .. } => {
            Note::lost(id, "sensors are the simulator's own")
        }
        Term::Strength { ratio } => Note::lost(id, format!("multiply the command by {}", num(*ratio))),
        _ => Note::lost(id, "the format has no element for it"),
    }
}
