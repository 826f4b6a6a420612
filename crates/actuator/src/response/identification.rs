//! From the second-order fit of a locked actuator's response to its inertia and damping (eq 3-14, Table 5).

use serde::Serialize;

/// A fitted response `F_1/F_m = numerator / (s^2 + damping s + constant)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SecondOrderFit {
    /// Numerator, 1/s^2.
    pub numerator_1_s2: f64,
    /// Coefficient of `s`, 1/s.
    pub damping_1_s: f64,
    /// Constant term, 1/s^2.
    pub constant_1_s2: f64,
}

/// What Table 5 calls the extracted variables.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExtractedModel {
    /// Lumped mass `m_T`, kg.
    pub total_mass_kg: f64,
    /// Reflected damping `b`, N s/m.
    pub damping_n_s_m: f64,
    /// Rotor inertia `J = (m_T - m_s) r^2`, kg m^2.
    pub rotor_inertia_kg_m2: f64,
    /// Rotor damping `b_r = b r^2`, N m s.
    pub rotor_damping_nm_s: f64,
}

impl SecondOrderFit {
    /// The fit printed in eq 3-14.
    pub const PRINTED: Self = Self { numerator_1_s2: 2166.0, damping_1_s: 39.53, constant_1_s2: 2279.0 };

    /// Gain at zero frequency; 1 by the model's form.
    #[must_use]
    pub fn dc_gain(&self) -> f64 {
        self.numerator_1_s2 / self.constant_1_s2
    }

    /// Inertia and damping for a known spring (N/m), sprung mass (kg) and ratio `r` (m/rad).
    ///
    /// The model wants numerator and constant equal to `k/m_T`. The printed fit does not have them so; Table 5's
    /// mass is the arithmetic mean of what each of the two gives, and so is this one.
    #[must_use]
    pub fn extract(&self, stiffness_n_m: f64, sprung_mass_kg: f64, ratio_m_rad: f64) -> ExtractedModel {
        let total_mass_kg = 0.5 * (stiffness_n_m / self.numerator_1_s2 + stiffness_n_m / self.constant_1_s2);
        let damping_n_s_m = self.damping_1_s * total_mass_kg;
        ExtractedModel {
            total_mass_kg,
            damping_n_s_m,
            rotor_inertia_kg_m2: (total_mass_kg - sprung_mass_kg) * ratio_m_rad.powi(2),
            rotor_damping_nm_s: damping_n_s_m * ratio_m_rad.powi(2),
        }
    }
}
