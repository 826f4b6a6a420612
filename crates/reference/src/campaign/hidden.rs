//! What can be hidden: an effect of the catalogue with drawn shape and a given strength, or one of no catalogue.

use super::Rig;
use super::draws::Draws;
use crate::effect::{IDS, Known};
use crate::{Beyond, Reference};

/// A hidden effect with its numbers by the names of its card.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// The catalogue's id, narrowed down to a sensor with `@` where it is; a name of no catalogue otherwise.
    pub id: String,
    /// Parameters in the order of the card.
    pub parameters: Vec<(&'static str, f64)>,
    /// Set where it is in no catalogue.
    pub beyond: Option<Beyond>,
}

/// The ids of the catalogue, in its order. `sensor-lag` and `sensor-delay` may be narrowed down to a sensor.
pub const CATALOGUE: [&str; IDS.len()] = IDS;

/// Names of effects that are in no catalogue.
pub const BEYOND: [&str; 11] = [
    "rough-end",
    "kinked-spring",
    "hot-motor",
    "square-root-damper",
    "directed-gain",
    "clipped-load-cell",
    "drifting-bias",
    "stale-samples",
    "friction-bump",
    "softening-spring",
    "dead-band-load-cell",
];

/// Two effects at once, as they come in practice.
pub const PAIRS: [[&str; 2]; 6] = [
    ["coulomb-friction", "hardening-spring"],
    ["stribeck-friction", "torque-ripple"],
    ["backlash", "coulomb-friction"],
    ["spring-hysteresis", "structural-mode"],
    ["load-dependent-friction", "transport-delay"],
    ["quadratic-drag", "sensor-lag@force_2_n"],
];

/// Three effects at once, as on rigs: friction, what is late, and something else.
pub const TRIPLES: [[&str; 3]; 3] = [
    ["presliding-friction", "transport-delay", "sensor-lag"],
    ["coulomb-friction", "torque-ripple", "transport-delay"],
    ["load-dependent-friction", "hardening-spring", "sensor-lag@force_2_n"],
];

impl Hidden {
    /// Whether an effect can act on this bench at all.
    #[must_use]
    pub fn applies(id: &str, rig: Rig) -> bool {
        rig == Rig::Pendulum || !Known::of(id).is_some_and(|known| known.on_output)
    }

    /// Whether an effect can be seen only beside a sensor of the spring's deflection.
    #[must_use]
    pub fn needs_deflection_sensor(id: &str) -> bool {
        Known::of(id).is_some_and(|known| known.beside_deflection)
    }

    /// An effect by its id with the shape that the seed draws. A strength of 1 is of the order of the practice
    /// campaigns; more of it shows more, without bound.
    ///
    /// # Panics
    ///
    /// For an id that it does not know: a mistake in a program, not in an input.
    #[must_use]
    pub fn drawn(id: &str, seed: u64, strength: f64) -> Self {
        let mut d = Draws::of(seed, id);
        if let Some(known) = Known::of(id) {
            return Self { id: id.to_owned(), parameters: (known.drawn)(&mut d, strength), beyond: None };
        }
        let beyond = Self::beyond(id, &mut d, strength);
        let (_, parameters) = beyond.described();
        Self { id: id.to_owned(), parameters, beyond: Some(beyond) }
    }

    fn beyond(id: &str, d: &mut Draws, a: f64) -> Beyond {
        match id {
            "rough-end" => Beyond::RoughEnd {
                force_n: 40.0 * a,
                from_m: d.between(-1e-4, 1e-4),
                width_m: d.magnitude(3e-5, 1e-4),
            },
            "kinked-spring" => Beyond::KinkedSpring { from_m: d.magnitude(5e-5, 1.5e-4), ratio: 0.2 * a },
            "hot-motor" => Beyond::HotMotor { fall: 0.1 * a, time_constant_s: d.between(3.0, 7.0) },
            "square-root-damper" => Beyond::SquareRootDamper { coefficient: 200.0 * a },
            "directed-gain" => Beyond::DirectedGain { ratio: 0.03 * a },
            "clipped-load-cell" => Beyond::ClippedLoadCell { limit_n: 500.0 / a },
            "drifting-bias" => Beyond::DriftingBias { amplitude_n: 6.0 * a, period_s: d.between(3.0, 6.0) },
            "stale-samples" => Beyond::StaleSamples { share: 0.05 * a / (1.0 + 0.05 * a) },
            "friction-bump" => Beyond::FrictionBump {
                force_n: 40.0 * a,
                at_m: d.between(-2e-4, 2e-4),
                width_m: d.magnitude(1e-4, 3e-4),
            },
            // Never all of it, however strong.
            "softening-spring" => Beyond::SofteningSpring {
                loss: 0.1 * a / (1.0 + 0.1 * a),
                time_constant_s: d.between(3.0, 7.0),
            },
            "dead-band-load-cell" => Beyond::DeadBandLoadCell { band_n: 10.0 * a },
            other => panic!("nothing of this name can be hidden: '{other}'"),
        }
    }

    /// A machine with this effect in it.
    #[must_use]
    pub fn put_into(&self, reference: Reference) -> Reference {
        if let Some(beyond) = self.beyond {
            return Reference { beyond: Some(beyond), ..reference };
        }
        let mut values: Vec<f64> = self.parameters.iter().map(|p| p.1).collect();
        if self.id == "transport-delay" {
            values[0] += reference.command_delay_s;
        }
        reference.with(&self.id, &values)
    }
}
