//! The effects of the catalogue in this simulator: how each is put in, and which shape of it is hidden in a campaign.
//!
//! A new effect is one file here with one [`Known`], its `mod` line, and one entry in [`KNOWN`]. A law of dry friction
//! stands in the file itself (`friction_at`); what needs a place of its own in the motion gets a field of
//! [`Reference`]. The laws are written from the equations and share nothing with the product.

mod base_motion;
mod dahl_friction;
mod drive;
mod friction;
mod output;
mod position_friction;
mod sensor;
mod spring;
mod temperature_friction;

use crate::campaign::Draws;
use crate::reference::Reference;

/// Where and how the rotor rubs.
#[derive(Debug, Clone, Copy)]
pub struct Rubbing {
    /// Extension of the screw, m.
    pub y: f64,
    /// Its speed, m/s; 0 at rest.
    pub speed: f64,
    /// The way in which it moves or is pushed, +1 or -1.
    pub direction: f64,
    /// Force in the screw, N.
    pub load: f64,
    /// By how much the drive is warmer than at the temperature for which its friction is stated, K.
    pub warmer_k: f64,
}

/// A bound of the rotor's dry friction, N, by an effect's values in the order of its card.
#[derive(Debug, Clone)]
pub struct FrictionLaw {
    /// The effect's values.
    pub values: Vec<f64>,
    /// The bound by these values.
    pub bound: fn(&[f64], &Rubbing) -> f64,
}

/// An effect's values by the names of its card.
pub(crate) type Drawn = Vec<(&'static str, f64)>;

/// How an effect is put into a machine with its values, at the sensor to which its id is narrowed down.
pub(crate) type PutIn = fn(&mut Reference, &[f64], Option<&str>);

/// An effect of the catalogue as this simulator knows it.
pub(crate) struct Known {
    /// The catalogue's id.
    pub id: &'static str,
    /// Puts it in.
    pub put: PutIn,
    /// The shape that a seed draws at a strength, about 1 in the practice campaigns; more of it shows more.
    pub drawn: fn(&mut Draws, f64) -> Drawn,
    /// Whether it needs an output that moves.
    pub on_output: bool,
    /// Whether it can be seen only beside a sensor of the spring's deflection.
    pub beside_deflection: bool,
}

impl Known {
    /// An effect that every bench can have, and that every usual sensor sees.
    const fn new(id: &'static str, put: PutIn, drawn: fn(&mut Draws, f64) -> Drawn) -> Self {
        Self { id, put, drawn, on_output: false, beside_deflection: false }
    }

    /// The effect of an id, narrowed down to a sensor or not.
    pub fn of(id: &str) -> Option<&'static Self> {
        let family = id.split('@').next().unwrap_or(id);
        KNOWN.iter().find(|known| known.id == family)
    }
}

/// Every effect that can be put in by the catalogue's id.
pub(crate) const KNOWN: &[Known] = &[
    friction::COULOMB,
    friction::PRESLIDING,
    friction::STRIBECK,
    friction::LOAD_DEPENDENT,
    friction::DIRECTION_DEPENDENT,
    friction::QUADRATIC_DRAG,
    drive::TORQUE_RIPPLE,
    drive::CURRENT_SATURATION,
    drive::VOLTAGE_SATURATION,
    drive::TRANSPORT_DELAY,
    drive::COMMAND_QUANTISATION,
    spring::HARDENING,
    spring::DAMPING,
    spring::HYSTERESIS,
    spring::BACKLASH,
    spring::SERIES_COMPLIANCE,
    sensor::STRUCTURAL_MODE,
    sensor::LAG,
    sensor::DELAY,
    output::FRICTION,
    output::WOBBLING_MASS,
    output::LOAD_MISMATCH,
    dahl_friction::DAHL,
    temperature_friction::BY_TEMPERATURE,
    base_motion::BASE_MOTION,
    position_friction::ALONG_SCREW,
];

/// The ids of [`KNOWN`], in its order.
pub(crate) const IDS: [&str; KNOWN.len()] = {
    let mut ids = [""; KNOWN.len()];
    let mut i = 0;
    while i < ids.len() {
        ids[i] = KNOWN[i].id;
        i += 1;
    }
    ids
};
