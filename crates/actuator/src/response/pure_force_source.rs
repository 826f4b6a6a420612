//! Up to which frequency an actuator may be taken for a pure force source (eq 4-33 to 4-40).

use std::f64::consts::PI;

/// The constant printed in eq 4-38 to 4-40. It comes from 3 dB rounded to 1.414; with eq 4-37's own 0.292 it is
/// 135.20 (see [`pure_force_source_min_stiffness`]).
pub const PRINTED_STIFFNESS_CONSTANT: f64 = 134.84;

/// `1 - 10^(-3/20)`: how far below the sprung mass' resonance, squared, both forces agree within 3 dB.
fn share() -> f64 {
    1.0 - 10.0_f64.powf(-3.0 / 20.0)
}

/// Frequency up to which the forces on both links agree within 3 dB, Hz (eq 4-37):
/// `f_max = sqrt(0.292 k / m_s) / 2 pi`, with the links held.
#[must_use]
pub fn pure_force_source_hz(stiffness_n_m: f64, sprung_mass_kg: f64) -> f64 {
    (share() * stiffness_n_m / sprung_mass_kg).sqrt() / (2.0 * PI)
}

/// Least stiffness for which the actuator is a pure force source up to a frequency, N/m: eq 4-37 solved for `k`,
/// `k = (4 pi^2 / 0.29205) m_s f^2`.
#[must_use]
pub fn pure_force_source_min_stiffness(sprung_mass_kg: f64, frequency_hz: f64) -> f64 {
    4.0 * PI * PI / share() * sprung_mass_kg * frequency_hz.powi(2)
}
