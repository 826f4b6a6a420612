//! The physical effects of a leg: the actuators' catalogue at every actuator, and the leg's own at its joints,
//! links and foot.
//!
//! An id carries its place before a slash: `knee/coulomb-friction`, `ankle_pitch/output-friction`,
//! `foot/contact-compliance`; places are the names of the placement file and of the URDF. A sensor's effect may be
//! narrowed down to one channel of its place: `knee/sensor-lag@force_1_n`. A new effect of the leg's own is one
//! file here, its `mod` line, and one entry in [`CATALOGUE`]; a new one of the actuators' is in
//! [`sealegs_actuator::effect`] and is offered here unasked.

mod at_actuator;
mod contact_compliance;
mod ground_friction;
mod joint_stop;
pub(crate) mod link_mass;
mod output_friction;
mod placed;
mod signature;
mod spring_setting;

pub(crate) use placed::{
    EffectRef, Placed, at_place, candidates, of_scenario, own_effects, with_effects_of_actuators,
};
pub use signature::law_graph;

use crate::dynamics::stop::JointStopChange;
use crate::robot::Robot;
use crate::scenario::Scenario;
use sealegs_model::{EffectCard, Excitation};
use std::fmt::Debug;

/// The place of effects at the sole.
pub const FOOT: &str = "foot";

/// The leg that effects are to suit, and how hard it was driven.
#[derive(Debug, Clone, Copy)]
pub struct LegSetting<'a> {
    /// What it does.
    pub scenario: &'a Scenario,
    /// Its robot.
    pub robot: &'a Robot,
    /// The runs at hand.
    pub seen: &'a Excitation,
}

/// A leg that is about to be built: what the leg's own effects change.
#[derive(Debug)]
pub struct Build {
    /// The scenario.
    pub scenario: Scenario,
    /// The robot.
    pub robot: Robot,
    /// Stops that differ at single joints.
    pub(crate) stops: Vec<JointStopChange>,
}

/// A physical effect at a place of the leg that is no actuator's law.
pub trait LegEffect: Debug + Send + Sync {
    /// Its id without a place.
    fn id(&self) -> &'static str;

    /// The places where this leg can have it.
    fn places(&self, leg: &LegSetting) -> Vec<String>;

    /// Law and parameters with guesses that suit the place.
    fn card(&self, place: &str, leg: &LegSetting) -> EffectCard;

    /// Base parameters of the place that say the same within narrow bounds: beside the effect they stay as they are stated.
    fn replaces(&self) -> &'static [&'static str] {
        &[]
    }

    /// Puts the effect with these parameter values (in the card's order) into a leg. At the neutral values
    /// nothing changes, to the last bit.
    fn install(&self, values: &[f64], place: &str, leg: &mut Build);
}

/// The leg's own effects, in the order of the printed catalogue.
pub static CATALOGUE: &[&dyn LegEffect] = &[
    &spring_setting::SpringSetting,
    &output_friction::OutputFriction,
    &joint_stop::JointStop,
    &contact_compliance::ContactCompliance,
    &ground_friction::GroundFriction,
    &link_mass::LinkMass,
];

/// Names of the joints that move.
fn moving_joints(leg: &LegSetting) -> Vec<String> {
    leg.robot.moving_joints().map(|j| j.name.clone()).collect()
}
