//! `sealegs list`: what comes with the program.

use crate::failure::OrBadInput;
use clap::Args;
use sealegs::actuator::ActuatorSpec;
use sealegs::catalogue;
use sealegs::leg::robot::Robot;
use sealegs::leg::scenario::{Scenario, preset_names};
use std::fmt::Write as _;
use std::io::Write as _;

/// List the robots, actuators, scenarios, effects and campaigns that come with the program.
#[derive(Args)]
pub struct List {}

/// Runs the verb.
///
/// # Errors
///
/// If standard output cannot be written.
pub fn run(_: &List) -> anyhow::Result<u8> {
    let mut out = String::from("scenarios (sealegs run NAME, sealegs impact NAME)\n");
    for name in preset_names() {
        let scenario = Scenario::load(name, &[]).or_bad_input()?;
        let _ = writeln!(out, "  {name:<20}{}", scenario.description);
    }
    out.push_str("robots\n");
    for name in Robot::preset_names() {
        let robot = Robot::load(name, None).or_bad_input()?;
        let _ = writeln!(
            out,
            "  {name:<20}{:.1} kg, {} joints, {} actuators",
            robot.mass_kg(),
            robot.dofs,
            robot.actuators.len()
        );
    }
    out.push_str("actuators\n");
    for name in ActuatorSpec::preset_names() {
        let spec = ActuatorSpec::load(name, None).or_bad_input()?;
        let _ = writeln!(out, "  {name:<20}{} (spring: {})", spec.description, spec.spring.settings());
    }
    out.push_str("campaigns\n");
    let _ =
        writeln!(out, "  {:<20}three drops to fit and one held out; `sealegs tour` unpacks it", "leg-drop");
    let _ = writeln!(
        out,
        "  {:<20}`sealegs mystery -o FOLDER` makes one with something hidden in it",
        "any number more"
    );
    out.push_str("effects (sealegs effects ID)\n");
    for entry in catalogue::entries()? {
        let card = entry.card();
        let found = entry.found_on().join(", ");
        let _ = writeln!(out, "  {:<30}{found:<12}{}", card.id, card.summary);
    }
    std::io::stdout().write_all(out.as_bytes())?;
    Ok(0)
}
