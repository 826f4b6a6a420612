//! What acts at the joints beside actuators: stops at the URDF's limits, viscous loss and dry friction.
//!
//! A joint whose losses are slow against the step takes them as they are at the step's beginning. Where they are
//! fast (a finger's inertia against the stiffness of a stop) that would run away, and they are solved for at the
//! step's end: see `stiff`.

use super::engine::Engine;
use super::stiff::{Loss, Stiff};
use super::tree::Tree;
use crate::robot::Robot;

/// Joint stops: a spring-damper beyond the limit that pushes back and never pulls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopLaw {
    /// Stiffness, N m/rad (N/m for a sliding joint).
    pub stiffness_nm_rad: f64,
    /// Damping, N m s/rad (N s/m for a sliding joint).
    pub damping_nm_s_rad: f64,
}

impl Default for StopLaw {
    /// An estimate: rubber that gives 2 degrees under 100 N m, well damped.
    fn default() -> Self {
        Self { stiffness_nm_rad: 3000.0, damping_nm_s_rad: 15.0 }
    }
}

/// A stop that differs at one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JointStopChange {
    /// The joint's degree of freedom.
    pub dof: usize,
    /// How much sooner than the URDF's limits it begins, rad or m.
    pub sooner_rad: f64,
    /// Its stiffness over that of the others.
    pub stiffness_ratio: f64,
    /// Its damping over that of the others.
    pub damping_ratio: f64,
}

/// Deflection at which dry joint friction reaches its bound, rad or m: elastic until it slips, so that a
/// resting joint rests. A numerical regularisation, not physical.
const PRESLIDING_RAD: f64 = 1e-4;

/// The passive torques of one joint.
#[derive(Debug, Clone)]
struct JointLosses {
    law: StopLaw,
    body: usize,
    parent: usize,
    dof: usize,
    slides: bool,
    lower: f64,
    upper: f64,
    damping: f64,
    friction: f64,
    bristle: f64,
    before: [f64; 2],
    torque: f64,
    stopped: bool,
}

impl JointLosses {
    fn bristle_stiffness(&self) -> f64 {
        self.friction / PRESLIDING_RAD
    }

    /// The greatest that its losses change with the speed at the end of a step, N m s/rad.
    fn rate(&self, step_s: f64) -> f64 {
        let stop = self.law.damping_nm_s_rad + step_s * self.law.stiffness_nm_rad;
        let stops = self.lower.is_finite() || self.upper.is_finite();
        self.damping + step_s * self.bristle_stiffness() + if stops { stop } else { 0.0 }
    }

    /// What is to be solved for the end of the step, `past` rad beyond a limit.
    fn loss(&self, past: f64) -> Loss {
        Loss {
            dof: self.dof,
            damping: self.damping,
            past,
            stop_stiffness: self.law.stiffness_nm_rad,
            stop_damping: self.law.damping_nm_s_rad,
            bristle: self.bristle,
            bristle_stiffness: self.bristle_stiffness(),
            friction: self.friction,
        }
    }

    /// Puts a torque on the bodies.
    fn put(&mut self, torque: f64, engine: &mut Engine) {
        self.torque = torque;
        if torque != 0.0 {
            engine.add_joint_effort(self.body, self.parent, self.slides, torque);
        }
    }
}

/// The passive torques of all joints.
#[derive(Debug, Clone)]
pub(crate) struct Stops {
    joints: Vec<JointLosses>,
    stiff: Stiff,
}

impl Stops {
    pub fn new(
        law: StopLaw,
        changes: &[JointStopChange],
        robot: &Robot,
        tree: &Tree,
        engine: &Engine,
        step_s: f64,
    ) -> Self {
        let joints: Vec<JointLosses> = tree
            .bodies
            .iter()
            .enumerate()
            .filter_map(|(body, b)| b.joint.as_ref().map(|j| (body, j)))
            .map(|(body, j)| {
                let joint = &robot.joints[j.joint];
                let (mut law, mut sooner) = (law, 0.0);
                for change in changes.iter().filter(|c| c.dof == j.dof) {
                    law.stiffness_nm_rad *= change.stiffness_ratio;
                    law.damping_nm_s_rad *= change.damping_ratio;
                    sooner += change.sooner_rad;
                }
                JointLosses {
                    law,
                    body,
                    parent: j.parent,
                    dof: j.dof,
                    slides: j.slides,
                    lower: joint.limits.lower + sooner,
                    upper: joint.limits.upper - sooner,
                    damping: joint.damping,
                    friction: joint.friction,
                    bristle: 0.0,
                    before: [engine.q[j.dof]; 2],
                    torque: 0.0,
                    stopped: false,
                }
            })
            .collect();
        let rates = joints.iter().map(|j| (j.dof, j.rate(step_s)));
        let stiff = Stiff::new(rates.collect(), engine, step_s);
        Self { joints, stiff }
    }

    /// Takes up the pose at the start.
    pub fn start(&mut self, engine: &Engine) {
        for joint in &mut self.joints {
            joint.before = [engine.q[joint.dof]; 2];
            joint.bristle = 0.0;
        }
    }

    /// Puts the torques on the bodies.
    pub fn apply(&mut self, engine: &mut Engine) {
        self.stiff.look(engine);
        let mut fast: Vec<(usize, Loss)> = Vec::new();
        for (index, joint) in self.joints.iter_mut().enumerate() {
            let q = engine.q[joint.dof];
            let moved = q - joint.before[1];
            joint.before = [joint.before[1], q];
            let past = if q > joint.upper {
                q - joint.upper
            } else if q < joint.lower {
                q - joint.lower
            } else {
                0.0
            };
            joint.stopped = past != 0.0;
            if joint.friction > 0.0 {
                joint.bristle = (joint.bristle - joint.bristle_stiffness() * moved)
                    .clamp(-joint.friction, joint.friction);
            }
            if self.stiff.contains(joint.dof) {
                fast.push((index, joint.loss(past)));
                continue;
            }
            let speed = engine.joint_velocity(joint.dof);
            let mut torque = -joint.damping * speed;
            if joint.stopped {
                let push = -joint.law.stiffness_nm_rad * past - joint.law.damping_nm_s_rad * speed;
                // A stop pushes back into the range only.
                torque += if past > 0.0 { push.min(0.0) } else { push.max(0.0) };
            }
            if joint.friction > 0.0 {
                torque += joint.bristle;
            }
            joint.put(torque, engine);
        }
        if !fast.is_empty() {
            let losses: Vec<Loss> = fast.iter().map(|(_, loss)| *loss).collect();
            let torques = self.stiff.torques(&losses, engine);
            for ((index, _), torque) in fast.iter().zip(torques) {
                self.joints[*index].put(torque, engine);
            }
        }
    }

    /// Power of the torques, W, once the step that they were applied in is done.
    pub fn power(&self, engine: &Engine, step_s: f64) -> f64 {
        self.joints.iter().map(|j| j.torque * (engine.q[j.dof] - j.before[0]) / (2.0 * step_s)).sum()
    }

    /// Degrees of freedom that are past a limit now.
    pub fn stopped(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().filter(|j| j.stopped).map(|j| j.dof)
    }
}
