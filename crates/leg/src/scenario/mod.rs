//! A scenario: which robot, how held, from which posture, on what ground, under which control, for how long.
//!
//! A TOML file with the keys of [`Scenario`] and the structs in it; the shipped ones in `assets/scenarios/`
//! comment every key. Unknown keys are refused with a suggestion; `key=value` overrides with dotted keys
//! change a file before it is read (`--set start.drop_height_m=0.1`).

mod controller;
mod file;

pub use controller::{ControllerKind, ControllerSpec, CurrentFile, JointGains, Motion};
pub(crate) use file::MOST_STEPS;
pub use file::{preset_names, preset_text};

pub use crate::dynamics::contact::Ground;
use crate::dynamics::stop::StopLaw;
use sealegs_actuator::Configuration;
use sealegs_actuator::excitation::Profile;
use sealegs_actuator::spec::{EffectSpec, EffectValue, SensorSpec};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Everything that a run is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// One line for lists.
    #[serde(default)]
    pub description: String,
    /// An embedded robot's name or a URDF file.
    pub robot: String,
    /// A placement file in place of the one beside the URDF.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub placement: Option<String>,
    /// Left becomes right: the mirror image of the robot about its x-z plane.
    #[serde(default)]
    pub mirrored: bool,
    /// Refuses a URDF that would have to be mended (see [`LoadOptions::strict`](crate::robot::LoadOptions)).
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub strict: bool,
    /// Duration, s.
    pub duration_s: f64,
    /// Integration step, s.
    #[serde(default = "default_step")]
    pub step_s: f64,
    /// Time between recorded samples, s; a multiple of the step.
    #[serde(default = "default_sample_period")]
    pub sample_period_s: f64,
    /// Gravity, m/s^2, downwards.
    #[serde(default = "default_gravity")]
    pub gravity_m_s2: f64,
    /// How the base is held.
    #[serde(default)]
    pub base: BaseSpec,
    /// The state at the start.
    #[serde(default)]
    pub start: StartSpec,
    /// The ground; without the table there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<Ground>,
    /// Joint stops.
    #[serde(default)]
    pub stops: StopSpec,
    /// What holds for all actuators.
    #[serde(default)]
    pub actuators: ActuatorsSpec,
    /// What differs for single actuators, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub actuator: BTreeMap<String, ActuatorOverride>,
    /// Who commands the currents.
    #[serde(default)]
    pub controller: ControllerSpec,
    /// How joints are to move, by name; a joint without an entry is to keep its posture.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub motion: BTreeMap<String, Motion>,
    /// Currents (A) that are added to the controller's, by actuator.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub current: BTreeMap<String, Profile>,
    /// Currents (A) from CSV files that are added to the controller's, by actuator.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub current_file: BTreeMap<String, CurrentFile>,
    /// What `sealegs impact` sweeps over unless told otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepSpec>,
    /// Physical effects beyond the base model, each with its place: `knee/coulomb-friction`.
    #[serde(default, rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
    /// Gain and bias of the sensors by channel, as a fit has left them; only comparisons read them.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sensors: BTreeMap<String, SensorSpec>,
    /// Where the numbers came from; kept as it is.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub provenance: BTreeMap<String, String>,
    /// The file's name without its ending, or the preset's; not a key of the file.
    #[serde(skip)]
    pub name: String,
    /// The folder of the file, from which other files are named; not a key of the file.
    #[serde(skip)]
    pub folder: Option<std::path::PathBuf>,
}

impl Scenario {
    /// The same scenario without what a fit knew of its values (`std`): the actuators' tolerances hold again.
    #[must_use]
    pub fn without_fitted_std(&self) -> Self {
        let mut plain = self.clone();
        let effects = plain.effects.iter_mut().flat_map(|e| e.parameters.values_mut());
        let parameters = plain.actuator.values_mut().flat_map(|o| o.parameters.values_mut());
        effects.chain(parameters).for_each(|given| given.std = None);
        plain
    }
}

/// 100 us: peak forces are then converged to better than 1 %.
fn default_step() -> f64 {
    1e-4
}

fn default_sample_period() -> f64 {
    1e-3
}

fn default_gravity() -> f64 {
    9.81
}

/// How the base is held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum BaseSpec {
    /// Fixed in the world at a height.
    Fixed {
        /// Height of the base's frame, m.
        #[serde(default)]
        height_m: f64,
    },
    /// On a vertical rail without friction.
    Rail {
        /// Mass of the carriage beside the base link's own, kg.
        #[serde(default)]
        carriage_mass_kg: f64,
    },
}

impl Default for BaseSpec {
    fn default() -> Self {
        Self::Fixed { height_m: 0.0 }
    }
}

/// How loaded the springs are at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpringStart {
    /// No force: right for free fall, where nothing needs to be carried.
    #[default]
    Unloaded,
    /// Each spring carries its share of the leg's weight as it hangs from its base.
    Balanced,
}

/// The state at the start.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartSpec {
    /// Joint positions, rad, by joint name; zero for the others.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub posture_rad: BTreeMap<String, f64>,
    /// Joint speeds, rad/s, by joint name; zero for the others.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub speed_rad_s: BTreeMap<String, f64>,
    /// Distance of the lowest sole point from the ground, m, on a rail.
    #[serde(default)]
    pub drop_height_m: f64,
    /// Load of the springs.
    #[serde(default)]
    pub springs: SpringStart,
}

/// Joint stops beyond the URDF's limits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StopSpec {
    /// Stiffness, N m/rad.
    pub stiffness_nm_rad: f64,
    /// Damping, N m s/rad.
    pub damping_nm_s_rad: f64,
}

impl Default for StopSpec {
    fn default() -> Self {
        let StopLaw { stiffness_nm_rad, damping_nm_s_rad } = StopLaw::default();
        Self { stiffness_nm_rad, damping_nm_s_rad }
    }
}

impl From<StopSpec> for StopLaw {
    fn from(s: StopSpec) -> Self {
        Self { stiffness_nm_rad: s.stiffness_nm_rad, damping_nm_s_rad: s.damping_nm_s_rad }
    }
}

/// What holds for all actuators.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorsSpec {
    /// Spring setting in place of the placement file's (`compliant`, `stiff`, `locked-out`, `70mm`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spring: Option<String>,
    /// Configuration in place of the actuator file's: `sprung-motor-housing`, `sprung-ball-nut`, `lumped`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<Configuration>,
}

/// What differs for one actuator.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorOverride {
    /// Spring setting.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spring: Option<String>,
    /// Greatest current, A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// Values of base parameters: `stiffness`, `reflected_inertia`, `damping`, `force_constant`,
    /// `motor_gain`, `sprung_mass`; a plain number, or `{ value, std }` where a fit has found it.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, EffectValue>,
}

/// A sweep over drop heights and spring settings.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepSpec {
    /// Drop heights, m.
    pub heights_m: Vec<f64>,
    /// Spring settings.
    pub springs: Vec<String>,
}
