//! What can be hidden: an effect of the catalogue with drawn shape and a given strength, or one of no catalogue.

use super::Rig;
use super::draws::Draws;
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
pub const CATALOGUE: [&str; 21] = [
    "coulomb-friction",
    "presliding-friction",
    "stribeck-friction",
    "load-dependent-friction",
    "direction-dependent-friction",
    "quadratic-drag",
    "torque-ripple",
    "current-saturation",
    "voltage-saturation",
    "transport-delay",
    "command-quantisation",
    "hardening-spring",
    "spring-damping",
    "spring-hysteresis",
    "backlash",
    "series-compliance",
    "structural-mode",
    "sensor-lag",
    "sensor-delay",
    "output-friction",
    "wobbling-mass",
];

/// Names of effects that are in no catalogue.
pub const BEYOND: [&str; 11] = [
    "position-dependent-friction",
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

impl Hidden {
    /// Whether an effect can act on this bench at all.
    #[must_use]
    pub fn applies(id: &str, rig: Rig) -> bool {
        rig == Rig::Pendulum || !matches!(id, "output-friction" | "wobbling-mass")
    }

    /// Whether an effect can be seen only beside a sensor of the spring's deflection: where forces and angles
    /// alone are measured, a compliance in series is a softer spring.
    #[must_use]
    pub fn needs_deflection_sensor(id: &str) -> bool {
        id == "series-compliance"
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
        let a = strength;
        let parameters = match id.split('@').next().unwrap_or(id) {
            "coulomb-friction" => vec![("force_n", 30.0 * a)],
            "presliding-friction" => {
                // It slips after a travel that is small beside the run's.
                let force = 30.0 * a;
                vec![("force_n", force), ("stiffness_n_m", force / d.magnitude(1e-5, 5e-5))]
            }
            "stribeck-friction" => {
                let low = 20.0 * a;
                let velocity = d.magnitude(0.002, 0.006);
                vec![
                    ("coulomb_n", low),
                    ("static_n", low * d.between(1.8, 2.6)),
                    ("stribeck_velocity_m_s", velocity),
                ]
            }
            "load-dependent-friction" => vec![("coefficient", 0.06 * a)],
            "direction-dependent-friction" => {
                let asymmetry = d.between(0.3, 0.7) * d.one_of(&[-1.0, 1.0]);
                vec![("force_n", 30.0 * a), ("asymmetry", asymmetry)]
            }
            "quadratic-drag" => vec![("coefficient_n_s2_m2", 1e5 * a)],
            "torque-ripple" => {
                let cycles = d.one_of(&[4.0, 6.0, 7.0, 8.0, 11.0, 12.0, 14.0]);
                vec![
                    ("amplitude_n", 20.0 * a),
                    ("cycles_per_rev", cycles),
                    ("phase_rad", d.between(-3.0, 3.0)),
                ]
            }
            "current-saturation" => vec![("limit_a", 4.0 / a)],
            "voltage-saturation" => {
                let bus = d.between(12.0, 24.0);
                vec![("bus_v", bus), ("resistance_ohm", 0.25 * bus * a)]
            }
            "transport-delay" => vec![("delay_s", 1e-3 * a)],
            "command-quantisation" => vec![("count_a", 0.1 * a), ("rounding", d.one_of(&[0.0, 1.0]))],
            "hardening-spring" => vec![("cubic_n_m3", 3e10 * a)],
            "spring-damping" => vec![("damping_n_s_m", 300.0 * a)],
            "spring-hysteresis" => {
                let force = 15.0 * a;
                vec![("stiffness_n_m", force / d.magnitude(1e-5, 1e-4)), ("slip_force_n", force)]
            }
            "backlash" => vec![("gap_m", 3e-5 * a)],
            "series-compliance" => {
                vec![("stiffness_n_m", 2e7 / a), ("unsprung_mass_kg", d.between(0.05, 0.15))]
            }
            "structural-mode" => {
                let (frequency, ratio) = (d.between(55.0, 95.0), d.magnitude(0.02, 0.08));
                vec![("frequency_hz", frequency), ("damping_ratio", ratio), ("participation", 0.4 * a)]
            }
            "sensor-lag" => vec![("cutoff_hz", 200.0 / a)],
            "sensor-delay" => vec![("delay_s", 1e-3 * a)],
            "output-friction" => vec![("torque_nm", 0.4 * a)],
            "wobbling-mass" => {
                // The card's radius is fixed: mass and radius act together.
                let (frequency, ratio) = (d.magnitude(3.0, 12.0), d.magnitude(0.03, 0.12));
                vec![
                    ("mass_kg", 0.15 * a),
                    ("radius_m", 0.3),
                    ("frequency_hz", frequency),
                    ("damping_ratio", ratio),
                ]
            }
            _ => {
                let beyond = Self::beyond(id, &mut d, a);
                let (_, parameters) = beyond.described();
                return Self { id: id.to_owned(), parameters, beyond: Some(beyond) };
            }
        };
        Self { id: id.to_owned(), parameters, beyond: None }
    }

    fn beyond(id: &str, d: &mut Draws, a: f64) -> Beyond {
        match id {
            "position-dependent-friction" => {
                Beyond::PositionFriction { force_n: 25.0 * a, period_m: d.magnitude(2e-4, 6e-4) }
            }
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
