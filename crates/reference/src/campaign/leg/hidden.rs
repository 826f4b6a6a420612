//! What can be hidden in a leg, where, and how strong it must be to be seen.

use super::{LegOrder, ROBOT, Scene, names, signals};
use crate::campaign::{Draws, Hidden, reach};
use crate::leg::LegIndividual;
use sealegs_leg::LegError;
use sealegs_leg::robot::Robot;

/// Effects that can be hidden in a leg, without their place. Backlash is none of them: a light foot rattles in its play,
/// and no affordable step follows the rattling to a fraction of the noise.
pub const LEG_CATALOGUE: [&str; 11] = [
    "coulomb-friction",
    "stribeck-friction",
    "load-dependent-friction",
    "direction-dependent-friction",
    "quadratic-drag",
    "torque-ripple",
    "transport-delay",
    "hardening-spring",
    "spring-setting",
    "link-mass",
    "contact-compliance",
];

/// Two effects at once, as they come in practice.
pub const LEG_PAIRS: [[&str; 2]; 5] = [
    ["direction-dependent-friction", "torque-ripple"],
    ["load-dependent-friction", "transport-delay"],
    ["stribeck-friction", "link-mass"],
    ["spring-setting", "coulomb-friction"],
    ["quadratic-drag", "hardening-spring"],
];

/// Actuators that move in every scene.
const LANDING: [&str; 4] = ["hip_pitch", "knee", "ankle_outer", "ankle_inner"];
/// Those that move only where the leg swings.
const SWINGING: [&str; 2] = ["hip_front", "hip_back"];
/// Links whose mass may be off.
const LINKS: [&str; 3] = ["thigh", "shank", "foot"];

/// Greatest amount, in the units of [`Hidden::drawn`]: beyond it nobody would call it a hidden effect.
const MOST: f64 = 8.0;

/// Step of the integration while an amount is looked for, s.
const COARSE_STEP_S: f64 = 1e-4;

/// Change of a parameter for a sensitivity, as a ratio.
const NUDGE: f64 = 0.01;

/// Spring settings that are taken for the compliant one, as ratios of stiffness: THOR's stiff setting (655 over
/// 372 kN/m), and one between that is clamped a little too short.
const SETTINGS: [f64; 2] = [1.76, 1.25];

/// How plain an effect is to be: root mean square of what it changes, in noise units, after what the parameters of its
/// own place can take up to first order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plain {
    /// A little above the noise.
    Weak,
    /// Plain to see.
    Middle,
    /// It dominates the error.
    Dominant,
}

impl Plain {
    fn window(self) -> (f64, f64) {
        match self {
            Self::Weak => (1.3, 1.6),
            Self::Middle => (2.0, 3.5),
            Self::Dominant => (4.0, 9.0),
        }
    }
}

/// A place for an effect in a scene; `None` where the scene has none.
#[must_use]
pub fn leg_place(effect: &str, scene: Scene, d: &mut Draws) -> Option<&'static str> {
    match (effect, scene) {
        ("contact-compliance", Scene::Swing) => None,
        ("contact-compliance", Scene::Drop) => Some("foot"),
        ("link-mass", _) => Some(d.one_of(&LINKS)),
        (_, Scene::Swing) => {
            let all: Vec<&str> = LANDING.into_iter().chain(SWINGING).collect();
            Some(d.one_of(&all))
        }
        (_, Scene::Drop) => Some(d.one_of(&LANDING)),
    }
}

/// An effect at a place with the shape that the seed draws and an amount; 1 is of the order of the practice campaigns.
fn drawn(place: &str, effect: &str, seed: u64, amount: f64) -> Hidden {
    let mut d = Draws::of(seed, &format!("{place}/{effect}"));
    let parameters = match effect {
        // A rotor turns so fast here that more cycles would pass between two samples.
        "torque-ripple" => {
            let cycles = d.one_of(&[1.0, 2.0, 3.0]);
            let phase = d.between(-3.0, 3.0);
            vec![("amplitude_n", 20.0 * amount), ("cycles_per_rev", cycles), ("phase_rad", phase)]
        }
        // Whole steps of every integration.
        "transport-delay" => {
            vec![("delay_s", (1e-3 * amount / COARSE_STEP_S).round().max(1.0) * COARSE_STEP_S)]
        }
        "link-mass" => {
            let shift = d.between(0.01, 0.03) * d.one_of(&[-1.0, 1.0]);
            vec![("mass_kg", 0.15 * amount), ("shift_x_m", 0.0), ("shift_z_m", shift)]
        }
        "contact-compliance" => {
            let softer = d.one_of(&[true, false]);
            let ratio = 1.0 + 0.4 * amount;
            let ratio = if softer { 1.0 / ratio } else { ratio };
            vec![("stiffness_ratio", ratio), ("damping_change_s_m", 0.1 * amount)]
        }
        _ => Hidden::drawn(effect, d.seed(), amount).parameters,
    };
    Hidden { id: format!("{place}/{effect}"), parameters, beyond: None }
}

/// The effect at its place, so strong that it is as plain as wanted, and how plain that is; `None` where no amount
/// does it.
///
/// # Errors
///
/// Those of a run of the leg.
pub fn leg_visible(
    order: &LegOrder,
    place: &str,
    effect: &str,
    plain: Plain,
) -> Result<Option<Hidden>, LegError> {
    let probe = Probe::new(order, place)?;
    if effect == "spring-setting" {
        let ratio = SETTINGS[usize::from(plain == Plain::Weak)];
        let id = format!("{place}/{effect}");
        let hidden = Hidden { id, parameters: vec![("stiffness_ratio", ratio)], beyond: None };
        let shows = probe.left_by(std::slice::from_ref(&hidden))? >= plain.window().0.min(2.0);
        return Ok(shows.then_some(hidden));
    }
    let error = |amount: f64| probe.left_by(&[drawn(place, effect, order.seed, amount)]);
    let found = reach(plain.window(), error)?;
    Ok(found.filter(|a| *a <= MOST).map(|amount| drawn(place, effect, order.seed, amount)))
}

/// How plain hidden effects are together: about the error of a model that is refitted without them, in noise units.
///
/// # Errors
///
/// Those of a run of the leg.
pub fn leg_plain(order: &LegOrder) -> Result<f64, LegError> {
    let places: Vec<&str> = order.hidden.iter().filter_map(|h| h.id.split('/').next()).collect();
    let plain = LegOrder { hidden: Vec::new(), ..order.clone() };
    Probe::at(&plain, &places)?.left_by(&order.hidden)
}

/// What the runs show without the effect, and what the parameters of its place can take up.
struct Probe {
    order: LegOrder,
    own: LegIndividual,
    truth: Vec<f64>,
    /// Orthonormal changes of all signals by the parameters.
    taken: Vec<Vec<f64>>,
}

impl Probe {
    fn new(order: &LegOrder, place: &str) -> Result<Self, LegError> {
        Self::at(order, &[place])
    }

    fn at(order: &LegOrder, places: &[&str]) -> Result<Self, LegError> {
        let order = LegOrder { step_s: COARSE_STEP_S, ..order.clone() };
        let own = order.individual()?;
        let truth = seen(&order, &own, &[])?;
        let mut probe = Self { truth, taken: Vec::new(), own, order };
        for place in places {
            for nudged in probe.nudged(place)? {
                let mut change = probe.change(&nudged, &[])?;
                probe.clean(&mut change);
                let size = change.iter().map(|c| c * c).sum::<f64>().sqrt();
                // What these runs do not feel takes up nothing.
                if size > 1e-3 {
                    change.iter_mut().for_each(|c| *c /= size);
                    probe.taken.push(change);
                }
            }
        }
        Ok(probe)
    }

    /// Other individuals: each with one parameter of a place a little off.
    fn nudged(&self, place: &str) -> Result<Vec<LegIndividual>, LegError> {
        let (_, actuators) = names(&Robot::load(ROBOT, None)?);
        let mut all = Vec::new();
        if let Some(i) = actuators.iter().position(|a| a == place) {
            for k in 0..self.own.actuators[i].len() {
                let mut other = self.own.clone();
                other.actuators[i][k] *= 1.0 + NUDGE;
                all.push(other);
            }
        } else if place == "foot" && self.order.scene == Scene::Drop {
            for k in 0..self.own.contact.len() {
                let mut other = self.own.clone();
                other.contact[k] *= 1.0 + NUDGE;
                all.push(other);
            }
        }
        Ok(all)
    }

    fn change(&self, individual: &LegIndividual, hidden: &[Hidden]) -> Result<Vec<f64>, LegError> {
        let with = seen(&self.order, individual, hidden)?;
        Ok(with.iter().zip(&self.truth).map(|(a, b)| a - b).collect())
    }

    /// Takes out what the parameters account for.
    fn clean(&self, change: &mut [f64]) {
        for unit in &self.taken {
            let share: f64 = change.iter().zip(unit).map(|(c, u)| c * u).sum();
            change.iter_mut().zip(unit).for_each(|(c, u)| *c -= share * u);
        }
    }

    /// About the refitted model's error with these effects hidden, noise units; 1 for none.
    fn left_by(&self, hidden: &[Hidden]) -> Result<f64, LegError> {
        let mut change = match self.change(&self.own, hidden) {
            // A leg that runs away shows too much of it.
            Err(LegError::NotFinite { .. }) => return Ok(1e3),
            change => change?,
        };
        self.clean(&mut change);
        let square = change.iter().map(|c| c * c).sum::<f64>() / change.len().max(1) as f64;
        Ok((1.0 + square).sqrt())
    }
}

/// All signals of the first and the last run in noise units, each without its mean where its sensor has a bias.
fn seen(order: &LegOrder, individual: &LegIndividual, hidden: &[Hidden]) -> Result<Vec<f64>, LegError> {
    let mut all = Vec::new();
    let lands = order.scene == Scene::Drop;
    for run in order.truth(&[0, 3], individual, hidden)? {
        for (sensor, signal) in order.sensors()?.iter().zip(signals(&run, lands)) {
            let mean = signal.iter().sum::<f64>() / signal.len().max(1) as f64;
            let zero = if sensor.may_be_off() { mean } else { 0.0 };
            all.extend(signal.iter().map(|s| (s - zero) / sensor.noise_std()));
        }
    }
    Ok(all)
}
