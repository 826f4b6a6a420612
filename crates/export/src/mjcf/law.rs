//! Laws as lines of Python: what a callback adds to MuJoCo's own forces.

use crate::bench::BenchDescription;
use crate::term::{OwnLaw, Term, python};
use crate::text::num;
use sealegs_actuator::plant::Winding;
use std::fmt::Write;

/// The bound of the rotor's dry friction as a Python expression of `speed`, `direction`, `load()` and `self.heat`, what dry
/// friction has made so far in J; `None` where it is a number, which MuJoCo holds itself.
pub fn friction_bound(bench: &BenchDescription) -> Option<String> {
    let constant = bench.sum(|t| if let Term::Coulomb { force } = t { Some(*force) } else { None });
    let mut parts = Vec::new();
    for (_, term) in bench.terms() {
        if let Term::Bound { expression } = term {
            parts.push(format!("({})", python(expression)));
            continue;
        }
        match *term {
            Term::Stribeck { coulomb, at_rest, velocity } => parts.push(format!(
                "{} + {} * exp(-(speed / {}) ** 2)",
                num(coulomb),
                num(at_rest - coulomb),
                num(velocity)
            )),
            Term::LoadFriction { coefficient } => parts.push(format!("{} * abs(load())", num(coefficient))),
            Term::ByPower { driving, driven } => parts.push(format!(
                "({} if load() * direction > 0 else {}) * abs(load())",
                num(driving),
                num(driven)
            )),
            Term::Warming { force, fall, energy_j } => parts.push(format!(
                "{} * (1.0 - {} * (1.0 - exp(-self.heat / {})))",
                num(force),
                num(fall),
                num(energy_j)
            )),
            Term::DirectedFriction { force, asymmetry } => {
                parts.push(format!("{} * (1.0 + {} * direction)", num(force), num(asymmetry)));
            }
            _ => {}
        }
    }
    if parts.is_empty() {
        return None;
    }
    if constant > 0.0 {
        parts.insert(0, num(constant));
    }
    Some(parts.join(" + "))
}

/// The user's own laws at a place.
pub fn own<'a>(bench: &'a BenchDescription, place: &'a str) -> impl Iterator<Item = &'a OwnLaw> {
    bench.effects.iter().filter_map(move |e| match &e.term {
        Term::Own(own) if own.acts_on == place => Some(own),
        _ => None,
    })
}

/// Lines that set a law's parameters and evaluate it into a variable, indented by `indent` blanks.
pub fn evaluated(law: &OwnLaw, into: &str, indent: usize) -> String {
    let blanks = " ".repeat(indent);
    let mut text = String::new();
    for (name, value) in &law.parameters {
        let _ = writeln!(text, "{blanks}{name} = {}", num(*value));
    }
    let _ = writeln!(text, "{blanks}{into} = {}", law.python());
    text
}

/// Lines of the limits of the drive that depend on speed: they change `force`, the commanded one, at `y_dot`. With a
/// `winding` the bridge's limits are among them.
pub fn drive_limits(bench: &BenchDescription, winding: Option<&Winding>) -> String {
    let mut text = String::new();
    for (_, term) in bench.terms() {
        match term {
            Term::VoltageLimit { bus, resistance } if bus.is_finite() => {
                let gain = num(bench.gain);
                let _ = writeln!(
                    text,
                    "        low, high = ({gain} * (volts - {gain} * y_dot) / {} for volts in (-{bus}, {bus}))\n        force = \
                     min(max(force, low), high)",
                    num(*resistance),
                    bus = num(*bus)
                );
            }
            Term::CommandLimit { limit } if winding.is_some() && limit.is_finite() => {
                let most = winding.map_or(*limit, |w| w.force_per_current * limit);
                let _ = writeln!(text, "        force = min(max(force, -{most}), {most})", most = num(most));
            }
            Term::DeadZone { duty } => {
                let Some(volts) = winding.map(|w| num(duty * w.supply_v)) else { continue };
                let _ = writeln!(
                    text,
                    "        asked = self.volts(force, y_dot)\n        force = self.force(asked - min(max(asked, -{volts}), \
                     {volts}), y_dot)"
                );
            }
            Term::Sag { resistance } => {
                let Some(w) = winding else { continue };
                let _ = writeln!(
                    text,
                    "        asked = self.volts(force, y_dot)\n        share = {} * (asked / {}) ** 2\n        force = \
                     self.force((asked + share * self.constant * y_dot) / (1.0 + share), y_dot)",
                    num(resistance / w.resistance_ohm),
                    num(w.supply_v)
                );
            }
            Term::Own(own) if own.acts_on == "drive" => {
                let gain = num(bench.gain);
                let _ = writeln!(text, "        F_m, u = force, force / {gain}");
                text.push_str(&evaluated(own, "u", 8));
                let _ = writeln!(text, "        force = {gain} * u");
            }
            _ => {}
        }
    }
    text
}
