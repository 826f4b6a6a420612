//! What became of everything that a bench includes, in a file for MuJoCo and in the Python beside it.

use super::SHORTEST_DELAY;
use super::bench::step_s;
use crate::Note;
use crate::bench::BenchDescription;
use crate::note::of_the_log;
use crate::term::Term;
use crate::text::{module, num};

/// What became of everything that the model includes.
pub fn notes(bench: &BenchDescription, stem: &str) -> Vec<Note> {
    let python = format!("{}.py", module(stem));
    let mut notes = vec![
        Note::held(
            "rotor",
            "armature and damping of the joint 'screw', whose position is the screw's extension",
        ),
        Note::held("command", format!("actuator 'motor', in the unit of {}", bench.input)),
        Note::callback(
            "load cells",
            format!("{python}: Bench(model).channels(data) gives the bench's channels"),
        ),
    ];
    for (id, term) in bench.terms() {
        let callback = |how: &str| Note::callback(id, format!("{python}: {how}"));
        notes.push(match term {
            Term::Coulomb { .. } => Note::held(id, "frictionloss of the joint 'screw'"),
            Term::Stribeck { .. }
            | Term::LoadFriction { .. }
            | Term::ByPower { .. }
            | Term::Warming { .. }
            | Term::Bound { .. }
            | Term::DirectedFriction { .. } => {
                callback("sets the frictionloss of the joint 'screw' at every step")
            }
            Term::Presliding { .. } => {
                Note::held(id, "tendon 'presliding': a spring with springyield, at a finer step")
            }
            Term::Drag { .. } => Note::held(id, "quadratic damping of the joint 'screw'"),
            Term::Ripple { .. } => Note::held(id, "cogging of a dcmotor without current"),
            Term::CommandLimit { .. } => Note::held(id, "ctrlrange of the actuator 'motor'"),
            Term::VoltageLimit { .. } => {
                callback("takes from the motor's force what the voltage does not give")
            }
            Term::Delay { delay_s } if *delay_s < SHORTEST_DELAY * step_s(bench) => {
                let least = num(SHORTEST_DELAY * step_s(bench));
                Note::near(id, format!("delay of the actuator 'motor', which is no shorter than {least} s"))
            }
            Term::Delay { .. } => {
                Note::held(id, "delay of the actuator 'motor', and half a step for its interpolation")
            }
            Term::Quantisation { .. } => callback("rounds the control"),
            Term::Hardening { .. } => Note::held(id, "cubic stiffness"),
            Term::SpringDamping { .. } if bench.gap() > 0.0 => {
                Note::near(id, "damping beside the spring, within the play too")
            }
            Term::SpringDamping { .. } => Note::held(id, "damping of the tendon 'deflection'"),
            Term::SpringSlip { .. } => {
                Note::held(id, "tendon 'clamp_slip': a spring with springyield, at a finer step")
            }
            Term::Backlash { .. } => Note::held(
                id,
                "springlength of the tendon 'deflection' as a range, within which it has no force",
            ),
            Term::Series { .. } => {
                Note::held(id, "body 'screw_end' between screw and output, on its own spring")
            }
            Term::Mode { .. } | Term::SensorLag { .. } | Term::SensorDelay { .. } => {
                callback("Bench(model).sense(data) passes the channels through it, step by step")
            }
            Term::OutputFriction { .. } => Note::held(id, "frictionloss of the joint 'lever'"),
            Term::OutputOffset { .. } => {
                Note::held(id, "actuator 'output_offset', whose control does nothing")
            }
            Term::Cable { .. } => Note::held(id, "stiffness and springref of the joint 'lever'"),
            Term::Load => Note::held(id, "mass and place of the body 'lever'"),
            Term::DeadZone { .. } | Term::Sag { .. } | Term::FeedbackDelay => {
                Note::lost(id, "the motor of this file takes a current, not a voltage")
            }
            Term::Strength { .. } => Note::held(id, "gain of the actuator 'motor'"),
            Term::Wobbling { .. } => Note::held(id, "body 'wobbling_mass' on the lever"),
            Term::Own(own) if matches!(own.acts_on.as_str(), "rotor" | "drive" | "spring" | "output") => {
                callback("your law as a force")
            }
            Term::Own(_) | Term::Transmission | Term::Unknown => {
                Note::lost(id, "this writer does not know the effect")
            }
        });
    }
    notes.extend(of_the_log(&bench.sensors, bench.logger));
    notes
}
