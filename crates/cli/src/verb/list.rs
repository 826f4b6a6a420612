//! `sealegs list`: what comes with the program.

use crate::failure::{OrBadInput, bad_input};
use clap::Args;
use sealegs::actuator::ActuatorSpec;
use sealegs::actuator::text::meant;
use sealegs::catalogue;
use sealegs::leg::robot::Robot;
use sealegs::leg::scenario::{Scenario, preset_names, preset_text};
use std::fmt::Write as _;
use std::io::Write as _;

/// List the robots, actuators, scenarios, effects and campaigns that come with the program, or print the file of one.
#[derive(Args)]
pub struct List {
    /// Print the file of this actuator, scenario or robot: `sealegs list quasi-direct-drive > knee.toml` makes a copy to change
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// The file of an actuator, a scenario or a robot.
fn file(name: &str) -> anyhow::Result<&'static str> {
    let robot = || Robot::preset_texts(name).map(|(urdf, _)| urdf);
    if let Some(text) = ActuatorSpec::preset_text(name).or_else(|| preset_text(name)).or_else(robot) {
        return Ok(text);
    }
    let robots = Robot::preset_names();
    let known: Vec<&str> =
        ActuatorSpec::preset_names().into_iter().chain(preset_names()).chain(robots).collect();
    let hint = meant(name, known.iter().copied());
    Err(bad_input(format!("'{name}' has no file here{hint} (known: {})", known.join(", "))))
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a name that nothing has; if standard output cannot be written.
pub fn run(arguments: &List) -> anyhow::Result<u8> {
    if let Some(name) = &arguments.name {
        std::io::stdout().write_all(file(name)?.as_bytes())?;
        return Ok(0);
    }
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
