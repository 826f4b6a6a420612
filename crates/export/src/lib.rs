//! A bench, a leg or a robot as a file of other people's simulators, and what that format cannot hold.
//!
//! [`bench()`] writes an actuator on a test bench, [`leg()`] a whole leg, [`robot()`] a robot with its drives, each in one
//! of four [`Format`]s. The text comes
//! with its [`Note`]s: for every effect whether the file holds it, a Python callback beside the file adds it, or it is
//! lost. The same notes stand as comments at the head of the file.
//!
//! Units are SI. Signs are those of `sealegs-model`: the axis points from link 1 (the spring side) to link 2 (the screw
//! side), forces inside the actuator are positive in compression, the screw's extension `y` lengthens the actuator.

mod bench;
mod driven;
mod error;
mod isaaclab;
mod joint_note;
mod leg;
mod mjcf;
mod note;
mod rigid;
mod rigid_driven;
mod rigid_leg;
mod sdf;
mod term;
mod text;
mod urdf;

pub use error::ExportError;
pub use note::{Fate, Note};

use sealegs_actuator::bench::BenchModel;
use sealegs_leg::bench::RobotModel;
use sealegs_leg::scenario::Scenario;
use std::fmt;
use std::str::FromStr;

/// A format of other people's simulators.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MuJoCo's own, as version 4.0 reads it.
    Mjcf,
    /// The Unified Robot Description Format of ROS.
    Urdf,
    /// A Python module with an articulation's configuration for Isaac Lab 3, and a URDF beside it.
    IsaacLab,
    /// The Simulation Description Format 1.9 of Gazebo.
    Sdf,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Mjcf, Self::Urdf, Self::IsaacLab, Self::Sdf];

    /// Its name on the command line.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Mjcf => "mjcf",
            Self::Urdf => "urdf",
            Self::IsaacLab => "isaaclab",
            Self::Sdf => "sdf",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for Format {
    type Err = ExportError;

    fn from_str(name: &str) -> Result<Self, ExportError> {
        let known = Self::ALL.into_iter().find(|f| f.as_str() == name);
        known.ok_or_else(|| ExportError::UnknownFormat { name: name.to_owned() })
    }
}

/// A model in another format.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The file's text.
    pub text: String,
    /// Files that belong beside it: name and text.
    pub beside: Vec<(String, String)>,
    /// What became of every effect, and of what else the format treats otherwise.
    pub notes: Vec<Note>,
}

/// Writes an actuator on a bench with its file's values and effects. `input` is the channel of its command
/// (`current_a`, `motor_force_n` or `motor_torque_nm`), `stem` the name of the file to be without its ending, from which
/// the files beside it take theirs.
///
/// # Errors
///
/// [`ExportError::Bench`] for a bench that no writer knows, [`ExportError::Stem`], or [`ExportError::Model`] for values
/// that no actuator can have.
pub fn bench(format: Format, model: &BenchModel, input: &str, stem: &str) -> Result<Exported, ExportError> {
    on_run(format, model, input, None, stem)
}

/// As [`bench()`], with the rig, the start and the servo's gain of one of the model's runs, by its record's name.
///
/// # Errors
///
/// As [`bench()`].
pub fn on_run(
    format: Format,
    model: &BenchModel,
    input: &str,
    run: Option<&str>,
    stem: &str,
) -> Result<Exported, ExportError> {
    text::check_stem(stem)?;
    if model.spec().is_rigid() {
        return Ok(driven(format, &driven::DrivenRobot::of_bench(model, input, run)?, stem));
    }
    let bench = bench::BenchDescription::of(model, input)?;
    Ok(match format {
        Format::Mjcf => mjcf::bench::write(&bench, stem),
        Format::Urdf => urdf::write(&rigid::RigidRobot::of_bench(&bench, rigid::Reach::Body), stem),
        Format::Sdf => sdf::write(&rigid::RigidRobot::of_bench(&bench, rigid::Reach::Spring), stem),
        Format::IsaacLab => {
            isaaclab::write(&rigid::RigidRobot::of_bench(&bench, rigid::Reach::Armature), stem)
        }
    })
}

/// Writes a robot with its drives, with its nominal values and the effects of its file; `stem` as for [`bench()`].
///
/// # Errors
///
/// [`ExportError::Stem`], or [`ExportError::Model`] for values that no drive can have.
pub fn robot(format: Format, model: &RobotModel, stem: &str) -> Result<Exported, ExportError> {
    text::check_stem(stem)?;
    Ok(driven(format, &driven::DrivenRobot::of_robot(model)?, stem))
}

fn driven(format: Format, robot: &driven::DrivenRobot, stem: &str) -> Exported {
    use rigid::{Reach, RigidRobot};
    match format {
        Format::Mjcf => mjcf::driven::write(robot, stem),
        Format::Urdf => urdf::write(&RigidRobot::of_driven(robot, Reach::Body), stem),
        Format::Sdf => sdf::write(&RigidRobot::of_driven(robot, Reach::Spring), stem),
        Format::IsaacLab => isaaclab::write(&RigidRobot::of_driven(robot, Reach::Armature), stem),
    }
}

/// Writes the leg of a scenario with the effects that the scenario and its actuators' files name; `stem` as for
/// [`bench()`].
///
/// # Errors
///
/// [`ExportError::Leg`] for whatever is wrong with the scenario or its robot, [`ExportError::Stem`].
pub fn leg(format: Format, scenario: &Scenario, stem: &str) -> Result<Exported, ExportError> {
    text::check_stem(stem)?;
    let leg = leg::LegDescription::of(scenario)?;
    Ok(match format {
        Format::Mjcf => mjcf::leg::write(&leg, stem)?,
        Format::Urdf => urdf::write(&rigid::RigidRobot::of_leg(&leg, rigid::Reach::Body)?, stem),
        Format::Sdf => sdf::write(&rigid::RigidRobot::of_leg(&leg, rigid::Reach::Spring)?, stem),
        Format::IsaacLab => isaaclab::write(&rigid::RigidRobot::of_leg(&leg, rigid::Reach::Armature)?, stem),
    })
}
