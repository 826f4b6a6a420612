//! Choosing spring stiffness and spring side for a force bandwidth (sections 4-5 to 4-7).
//!
//! Two demands put a floor under the stiffness. The actuator is a pure force source only well below its sprung
//! mass' resonance (eq 4-37), whatever the controller does. And no controller makes more force than the current
//! allows: the bound of eq 4-52 says how far an ideal inverse compensator carries, the clipped compensator in the
//! time domain says how far it really does. The softest spring that meets both is the answer, since a soft spring
//! bears impacts and controls force better.

mod beam;
mod table;

pub use beam::{AvailableSetting, BeamChoice};
pub use table::{PERFORMANCE_HEADS, performance_cells};

use serde::{Deserialize, Serialize};

use crate::compensator::ClippedCompensator;
use crate::response::{CompensatorBound, pure_force_source_hz, pure_force_source_min_stiffness};
use crate::spec::{Coefficients, Configuration, Kind};
use crate::{ActuatorError, ActuatorSpec};

/// What is wanted of a linear actuator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignRequest {
    /// Amplitude of the force to be controlled, N.
    pub amplitude_n: f64,
    /// Bandwidth that is wanted at this amplitude, Hz.
    pub bandwidth_hz: f64,
    /// Current limit, A.
    pub current_limit_a: f64,
    /// Sprung mass, kg.
    pub sprung_mass_kg: f64,
    /// Side of the spring.
    pub spring_side: Configuration,
}

/// Which demand decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// The forces on both links must agree within 3 dB (eq 4-37).
    PureForceSource,
    /// The clipped compensator must carry the force (section 4-6).
    ControlledBandwidth,
}

/// How one actuator performs at one stiffness, current limit and amplitude: a column of Table 8, corrected.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Performance {
    /// Side of the spring.
    pub spring_side: Configuration,
    /// Stiffness, N/m.
    pub stiffness_n_m: f64,
    /// Sprung mass, kg.
    pub sprung_mass_kg: f64,
    /// Undamped natural frequency `sqrt(k/m_T)/2 pi`, Hz.
    pub natural_frequency_hz: f64,
    /// Damping ratio of the plant.
    pub damping_ratio: f64,
    /// The plant's own half-power frequency, Hz; Table 8 prints it as the natural frequency.
    pub plant_bandwidth_hz: f64,
    /// Up to here the actuator is a pure force source `omega_max`, Hz (eq 4-37).
    pub pure_force_source_hz: f64,
    /// Bandwidth increase `delta_omega`, decades (eq 4-52).
    pub increase_decades: f64,
    /// Controlled bandwidth by the bound, `omega_cmax`, Hz.
    pub bound_hz: f64,
    /// Where clipping sets in, Hz; zero if it always does.
    pub clip_onset_hz: f64,
    /// Controlled bandwidth of the clipped ideal compensator in the time domain, Hz; `None` if not even a slow
    /// force of this amplitude gets through.
    pub simulated_hz: Option<f64>,
    /// Whether eq 4-52 is above the simulated bandwidth, as an upper bound should be.
    pub bound_holds: bool,
    /// The lower of the two frequencies up to which force can be relied on, Hz.
    pub usable_hz: f64,
    /// Which of the two it is.
    pub limited_by: Criterion,
}

impl Performance {
    /// Evaluates an actuator with both links held.
    #[must_use]
    pub fn new(c: &Coefficients, current_limit_a: f64, amplitude_n: f64) -> Self {
        let bound = CompensatorBound::new(c, current_limit_a, amplitude_n);
        let compensator = ClippedCompensator::new(c, current_limit_a);
        let simulated_hz = compensator.bandwidth_hz(amplitude_n);
        let sprung_mass = match c.configuration {
            Configuration::Lumped => c.total_mass(),
            Configuration::SprungMotorHousing | Configuration::SprungBallNut => c.sprung_mass,
        };
        let pure_force_source_hz = pure_force_source_hz(c.stiffness, sprung_mass);
        let controlled_hz = simulated_hz.unwrap_or(0.0);
        Self {
            spring_side: c.configuration,
            stiffness_n_m: c.stiffness,
            sprung_mass_kg: sprung_mass,
            natural_frequency_hz: (c.stiffness / c.total_mass()).sqrt() / std::f64::consts::TAU,
            damping_ratio: 0.5 * c.damping / (c.stiffness * c.total_mass()).sqrt(),
            plant_bandwidth_hz: bound.plant_bandwidth_hz,
            pure_force_source_hz,
            increase_decades: bound.increase_decades,
            bound_hz: bound.bandwidth_hz,
            clip_onset_hz: compensator.clip_onset_hz(amplitude_n),
            simulated_hz,
            bound_holds: controlled_hz <= bound.bandwidth_hz,
            usable_hz: controlled_hz.min(pure_force_source_hz),
            limited_by: if controlled_hz < pure_force_source_hz {
                Criterion::ControlledBandwidth
            } else {
                Criterion::PureForceSource
            },
        }
    }
}

/// The answer to a [`DesignRequest`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Design {
    /// What was asked.
    pub request: DesignRequest,
    /// Least stiffness for the pure-force-source assumption up to the wanted bandwidth, N/m (eq 4-38, with the
    /// constant that follows from eq 4-37: 135.2, not the printed 134.84).
    pub pure_force_source_min_stiffness_n_m: f64,
    /// Least stiffness for the wanted bandwidth by the bound of eq 4-52, N/m: optimistic where the bound is above
    /// the simulation; `None` if no stiffness gives it.
    pub bound_min_stiffness_n_m: Option<f64>,
    /// Least stiffness for the wanted bandwidth by the clipped compensator in the time domain, N/m; `None` if no
    /// stiffness gives it.
    pub simulated_min_stiffness_n_m: Option<f64>,
    /// The softest spring that meets both demands, N/m; `None` if none does.
    pub min_stiffness_n_m: Option<f64>,
    /// Which demand puts the higher floor under the stiffness.
    pub limited_by: Criterion,
    /// Below this stiffness eq 4-52 is no upper bound for this actuator, current limit and amplitude, N/m; `None`
    /// if it always is.
    pub bound_fails_below_n_m: Option<f64>,
    /// Performance at the softest spring that meets both demands.
    pub at_min_stiffness: Option<Performance>,
    /// Performance with the spring that the actuator has now.
    pub at_present: Performance,
    /// How the beams of SAFFiR and THOR give that stiffness.
    pub beams: Vec<BeamChoice>,
}

/// Stiffnesses between which a design is sought, N/m: far beyond any beam on both sides.
const SEARCH_N_M: [f64; 2] = [1e2, 1e9];

/// The softest spring that gives a linear actuator the wanted bandwidth, and what it looks like as a beam.
///
/// Motor, transmission and ratings are those of `spec`; sprung mass, spring side and current limit are the request's.
///
/// # Errors
///
/// [`ActuatorError::Value`] for a rotary actuator, the lumped model, or a number that is not positive and finite.
pub fn design(spec: &ActuatorSpec, request: &DesignRequest) -> Result<Design, ActuatorError> {
    if spec.kind != Kind::Linear {
        return Err(ActuatorError::value("kind", "rotary", "linear: the design rules are for screws"));
    }
    for (field, value) in [
        ("amplitude_n", request.amplitude_n),
        ("bandwidth_hz", request.bandwidth_hz),
        ("current_limit_a", request.current_limit_a),
        ("sprung_mass_kg", request.sprung_mass_kg),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(ActuatorError::value(field, value, "positive and finite"));
        }
    }
    if request.spring_side == Configuration::Lumped {
        return Err(ActuatorError::value(
            "spring_side",
            "lumped",
            "sprung-motor-housing or sprung-ball-nut: the lumped model tells no side",
        ));
    }
    let nominal = Coefficients {
        sprung_mass: request.sprung_mass_kg,
        configuration: request.spring_side,
        ..spec.coefficients()
    };
    let (current, amplitude) = (request.current_limit_a, request.amplitude_n);
    let at = |stiffness: f64| Coefficients { stiffness, ..nominal };
    let bound = |k: f64| CompensatorBound::new(&at(k), current, amplitude).bandwidth_hz;
    let simulated = |k: f64| ClippedCompensator::new(&at(k), current).bandwidth_hz(amplitude).unwrap_or(0.0);

    let force_source = pure_force_source_min_stiffness(request.sprung_mass_kg, request.bandwidth_hz);
    let by_simulation = least(|k| simulated(k) >= request.bandwidth_hz);
    let min_stiffness_n_m = by_simulation.map(|k| k.max(force_source));
    let peak_n = spec.ratings.peak_force_n.unwrap_or(nominal.force_constant * current);
    Ok(Design {
        request: *request,
        pure_force_source_min_stiffness_n_m: force_source,
        bound_min_stiffness_n_m: least(|k| bound(k) >= request.bandwidth_hz),
        simulated_min_stiffness_n_m: by_simulation,
        min_stiffness_n_m,
        limited_by: if by_simulation.is_some_and(|k| k <= force_source) {
            Criterion::PureForceSource
        } else {
            Criterion::ControlledBandwidth
        },
        bound_fails_below_n_m: least(|k| bound(k) >= simulated(k)).filter(|k| *k > SEARCH_N_M[0]),
        at_min_stiffness: min_stiffness_n_m.map(|k| Performance::new(&at(k), current, amplitude)),
        at_present: Performance::new(&nominal, current, amplitude),
        beams: min_stiffness_n_m.map_or_else(Vec::new, |k| beam::choices(k, amplitude, peak_n)),
    })
}

/// The least stiffness in the search range that is enough, for a demand that, once met, stays met.
fn least(enough: impl Fn(f64) -> bool) -> Option<f64> {
    let [mut low, mut high] = SEARCH_N_M;
    if !enough(high) {
        return None;
    }
    if enough(low) {
        return Some(low);
    }
    while high / low > 1.0 + 1e-9 {
        let middle = (low * high).sqrt();
        if enough(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

/// Table 8 as it should be: soft and stiff spring, each as sprung ball nut (0.15 kg, an estimate of section 4-7) and
/// as sprung motor housing, in the table's order.
#[must_use]
pub fn table_8(spec: &ActuatorSpec, current_limit_a: f64, amplitude_n: f64) -> [Performance; 4] {
    let nominal = spec.coefficients();
    [
        (372e3, Configuration::SprungBallNut),
        (372e3, Configuration::SprungMotorHousing),
        (655e3, Configuration::SprungBallNut),
        (655e3, Configuration::SprungMotorHousing),
    ]
    .map(|(stiffness, configuration)| {
        let sprung_mass = match configuration {
            Configuration::SprungBallNut => 0.15,
            _ => nominal.sprung_mass,
        };
        let c = Coefficients { stiffness, configuration, sprung_mass, ..nominal };
        Performance::new(&c, current_limit_a, amplitude_n)
    })
}

#[cfg(test)]
mod tests;
