//! The published bound on what an ideal compensator gains under a current limit (eq 4-41 to 4-52).

use serde::Serialize;

use super::{ForceResponse, Transfer, crossings};
use crate::spec::Coefficients;

/// The plant from motor force to spring force with both links held, `k / (m_T s^2 + b s + k)` (eq 4-41).
#[must_use]
pub fn plant(c: &Coefficients) -> Transfer {
    ForceResponse::locked(c).sprung
}

/// Half power, in dB: what is meant by `-3 dB` of a bandwidth.
pub const HALF_POWER_DB: f64 = -3.010_299_956_639_812;

/// The plant's own -3 dB frequency (half power), Hz: what Table 8 calls its natural frequency.
#[must_use]
pub fn plant_bandwidth_hz(c: &Coefficients) -> f64 {
    // |P|^2 = 1 / ((1 - x)^2 + 4 zeta^2 x) with x = (f/f_n)^2, solved for |P|^2 = 1/2.
    let natural_squared = c.stiffness / c.total_mass();
    let half_width = 0.5 * c.damping * c.damping / (c.stiffness * c.total_mass());
    let middle = 1.0 - half_width;
    let x = middle + (middle * middle + 1.0).sqrt();
    (x * natural_squared).sqrt() / std::f64::consts::TAU
}

/// The bound for one plant, current limit and force amplitude.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CompensatorBound {
    /// The plant's own -3 dB frequency (eq 4-41), Hz.
    pub plant_bandwidth_hz: f64,
    /// Greatest gain of the clipped compensator `G_max` (eq 4-50), dB: the RMS of the square wave at the limit over
    /// that of the sine asked for.
    pub max_gain_db: f64,
    /// The same for the square wave's fundamental, which is what makes force: 0.91 dB less relative to that RMS.
    pub max_gain_fundamental_db: f64,
    /// Bandwidth increase `delta_omega` (eq 4-52), decades.
    pub increase_decades: f64,
    /// Controlled bandwidth `omega_cmax`, Hz. It is an upper bound only for weakly damped plants
    /// (damping ratio below about 0.64).
    pub bandwidth_hz: f64,
}

impl CompensatorBound {
    /// The bound for a current limit (A) and the amplitude of the force that is asked for (N).
    #[must_use]
    pub fn new(c: &Coefficients, current_limit_a: f64, amplitude_n: f64) -> Self {
        let limit_over_amplitude = c.force_constant * current_limit_a / amplitude_n;
        let max_gain_db = 20.0 * (limit_over_amplitude * std::f64::consts::SQRT_2).log10();
        let max_gain_fundamental_db = 20.0 * (limit_over_amplitude * 4.0 / std::f64::consts::PI).log10();
        // Eq 4-51: the plant falls by 40 dB a decade.
        let increase_decades = max_gain_db / 40.0;
        let plant_bandwidth_hz = plant_bandwidth_hz(c);
        Self {
            plant_bandwidth_hz,
            max_gain_db,
            max_gain_fundamental_db,
            increase_decades,
            bandwidth_hz: plant_bandwidth_hz * 10.0_f64.powf(increase_decades),
        }
    }
}

/// First frequency within `range_hz` at which the forces on both links differ by 3 dB, Hz: the condition of eq 4-34
/// for links that may move.
#[must_use]
pub fn forces_differ_hz(response: &ForceResponse, range_hz: [f64; 2]) -> Option<f64> {
    let ratio = |f| response.ratio.at_hz(f);
    let upper = crossings(ratio, 3.0, range_hz);
    let lower = crossings(ratio, -3.0, range_hz);
    upper.into_iter().chain(lower).min_by(f64::total_cmp)
}
