//! The law of a leg's own effect over its own argument, from what the effect changes in a leg.

use super::{Build, LegEffect, LegSetting};
use crate::dynamics::contact::Ground;
use crate::dynamics::stop::{JointStopChange, StopLaw};
use crate::simulation::actuator_spec;
use sealegs_actuator::effect::Graph;
use std::f64::consts::{FRAC_PI_2, PI};

/// How far the sole goes into the ground in the picture of a landing, m: what a drop from 0.1 m reaches.
const DEPTH_M: f64 = 2e-3;

/// How fast the foot comes down there, m/s.
const LANDING_M_S: f64 = 1.0;

/// How far a joint runs into its stop in the picture, rad.
const INTO_STOP_RAD: f64 = 0.05;

/// The law of an effect at a place, at its parameters' `values` (in the card's order); `None` if they change nothing.
#[must_use]
pub fn law_graph(effect: &dyn LegEffect, values: &[f64], place: &str, leg: &LegSetting) -> Option<Graph> {
    let built = || Build { scenario: leg.scenario.clone(), robot: leg.robot.clone(), stops: Vec::new() };
    let (without, mut with) = (built(), built());
    effect.install(values, place, &mut with);
    contact(&without, &with)
        .or_else(|| with.stops.first().and_then(|change| stop(change, place, &with)))
        .or_else(|| friction(&without, &with, place))
        .or_else(|| weight(&without, &with, place))
        .or_else(|| spring(&without, &with, place))
}

fn contact(without: &Build, with: &Build) -> Option<Graph> {
    let (own, other) = (without.scenario.ground?, with.scenario.ground?);
    if own.friction != other.friction {
        let graph =
            Graph::new("Where the sole slips", ("normal force", "N"), ("tangential force at most", "N"));
        let range = (0.0, 1000.0);
        let graph = graph.sweep("scenario", range, |n| own.friction * n);
        return Some(graph.sweep("with the effect", range, |n| other.friction * n));
    }
    if own == other {
        return None;
    }
    // In and out again along half a sine of depth.
    let landing = |ground: Ground| {
        (0..=200).map(move |i| {
            let (sin, cos) = (PI * f64::from(i) / 200.0).sin_cos();
            let depth = DEPTH_M * sin;
            (depth, ground.normal_force_n(depth, LANDING_M_S * cos))
        })
    };
    let graph = Graph::new("A landing of one sole point", ("depth", "m"), ("normal force", "N"));
    Some(graph.curve("scenario", landing(own)).curve("with the effect", landing(other)))
}

fn stop(change: &JointStopChange, place: &str, with: &Build) -> Option<Graph> {
    let upper = with.robot.joints[with.robot.joint_index(place)?].limits.upper;
    let law = StopLaw::from(with.scenario.stops);
    let sooner = upper - change.sooner_rad;
    let range = (sooner - INTO_STOP_RAD, upper + INTO_STOP_RAD);
    let torque = |ratio: f64, limit: f64| move |q: f64| -ratio * law.stiffness_nm_rad * (q - limit).max(0.0);
    let graph = Graph::new("Torque of the stop", ("joint angle", "rad"), ("torque", "N m"));
    let graph = graph.sweep("scenario", range, torque(1.0, upper));
    Some(graph.sweep("with the effect", range, torque(change.stiffness_ratio, sooner)))
}

fn friction(without: &Build, with: &Build, place: &str) -> Option<Graph> {
    let joint = with.robot.joint_index(place)?;
    let bound = with.robot.joints[joint].friction - without.robot.joints[joint].friction;
    if bound == 0.0 {
        return None;
    }
    let graph = Graph::new("Friction over the joint's speed", ("joint speed", "rad/s"), ("friction", "N m"));
    Some(graph.sweep("", (-2.0, 2.0), |v| v.signum() * bound))
}

fn weight(without: &Build, with: &Build, place: &str) -> Option<Graph> {
    let link = with.robot.link_index(place)?;
    let own = without.robot.links[link].inertial.as_ref()?;
    let other = with.robot.links[link].inertial.as_ref()?;
    if own == other {
        return None;
    }
    let g = with.scenario.gravity_m_s2;
    // Pitch turns about y: the centre's lever is its horizontal distance from the link's joint.
    let torque = |body: &crate::robot::Inertial| {
        let (mass, com) = (body.mass_kg, body.com);
        move |pitch: f64| mass * g * (com.x * pitch.cos() + com.z * pitch.sin())
    };
    let range = (-FRAC_PI_2, FRAC_PI_2);
    let graph =
        Graph::new("Torque of the link's weight about its joint", ("pitch", "rad"), ("torque", "N m"));
    Some(graph.sweep("URDF", range, torque(own)).sweep("with the effect", range, torque(other)))
}

fn spring(without: &Build, with: &Build, place: &str) -> Option<Graph> {
    let actuator = with.robot.actuators.get(with.robot.actuator_index(place)?)?.spec.as_ref()?;
    let stiffness = |build: &Build| {
        let spec = actuator_spec(&build.scenario, place, actuator).ok()?;
        let stated = build.scenario.actuator.get(place).and_then(|a| a.parameters.get("stiffness_ratio"));
        Some(spec.spring.stiffness() * stated.map_or(1.0, |ratio| ratio.value))
    };
    let (own, other) = (stiffness(without)?, stiffness(with)?);
    if own == other {
        return None;
    }
    let range = (-2e-3, 2e-3);
    let graph = Graph::new("Force over deflection", ("deflection", "m"), ("force", "N"));
    Some(graph.sweep("scenario", range, |d| own * d).sweep("with the effect", range, |d| other * d))
}
