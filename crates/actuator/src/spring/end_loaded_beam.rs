//! The SAFFiR spring: a cantilever with a movable pivot, bent by the actuator at its end.

use serde::Serialize;

use super::Material;
use crate::ActuatorError;

/// How deflection follows from force for a pivot at distance `a` from the actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BeamLaw {
    /// Clamped at the pivot, `k = 3 E I / a^3` (eq 2-3).
    Fixed,
    /// Pinned at clamp and pivot, `k = 3 E I / (l a^2)` (eq 2-4).
    PinnedPinned,
    /// Clamped at the base, pinned at the pivot, `k = 12 E I / (a^3 + 3 l a^2)` (eq 2-5).
    FixedPinned,
    /// What was measured, `k = 4.12e10 a^-2.70` with `a` in mm and `k` in N/m (eq 2-6).
    #[default]
    Measured,
}

/// Coefficient of eq 2-6 in N/m with the length in mm (section 2-4-2).
const MEASURED_COEFFICIENT: f64 = 4.12e10;
/// Exponent of eq 2-6.
const MEASURED_EXPONENT: f64 = -2.70;

/// A rectangular cantilever, end-loaded, whose free length a movable pivot sets (section 2-4).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EndLoadedBeam {
    /// What it is made of.
    pub material: Material,
    /// Length from the base clamp to the actuator's axis `l`, m.
    pub total_length_m: f64,
    /// Width `b`, m.
    pub width_m: f64,
    /// Thickness in the bending direction `h`, m.
    pub thickness_m: f64,
    /// Distance from the pivot to the actuator's axis `a`, m.
    pub pivot_m: f64,
    /// Least and greatest `a` that the mounting allows and the measurements cover, m.
    pub pivot_range_m: [f64; 2],
    /// Which law gives the stiffness.
    pub law: BeamLaw,
}

impl EndLoadedBeam {
    /// Pivot distances of the measurements behind eq 2-6, m (section 2-4-2).
    pub const TEST_PIVOTS_M: [f64; 5] = [0.071, 0.080, 0.088, 0.098, 0.108];
    /// Magnitudes of the loads of those measurements, N, each both ways (section 2-4-2).
    pub const TEST_LOADS_N: [f64; 5] = [93.0, 187.0, 280.0, 458.0, 687.0];

    /// The beam of SAFFiR with its pivot at `pivot_m`: 125 x 30 x 6 mm of Ti-6Al-4V, pivot 65 to 110 mm
    /// (section 2-4-2).
    #[must_use]
    pub fn saffir(pivot_m: f64) -> Self {
        Self {
            material: Material {
                name: "titanium-6al-4v".to_owned(),
                youngs_modulus_pa: 115e9,
                yield_strength_pa: 828e6,
            },
            total_length_m: 0.125,
            width_m: 0.030,
            thickness_m: 0.006,
            pivot_m,
            pivot_range_m: [0.065, 0.110],
            law: BeamLaw::Measured,
        }
    }

    /// Second moment of area `I = b h^3 / 12`, m^4.
    #[must_use]
    pub fn second_moment_m4(&self) -> f64 {
        self.width_m * self.thickness_m.powi(3) / 12.0
    }

    /// Stiffness at the actuator by one of the laws, for any pivot distance, N/m.
    #[must_use]
    pub fn stiffness_by(&self, law: BeamLaw, pivot_m: f64) -> f64 {
        let ei = self.material.youngs_modulus_pa * self.second_moment_m4();
        let (a, l) = (pivot_m, self.total_length_m);
        match law {
            BeamLaw::Fixed => 3.0 * ei / a.powi(3),
            BeamLaw::PinnedPinned => 3.0 * ei / (l * a * a),
            BeamLaw::FixedPinned => 12.0 * ei / (a.powi(3) + 3.0 * l * a * a),
            BeamLaw::Measured => MEASURED_COEFFICIENT * (1e3 * a).powf(MEASURED_EXPONENT),
        }
    }

    /// Stiffness at the actuator at the present pivot, N/m.
    #[must_use]
    pub fn stiffness_n_m(&self) -> f64 {
        self.stiffness_by(self.law, self.pivot_m)
    }

    /// The pivot distance that gives a stiffness, m: the inverse of [`EndLoadedBeam::stiffness_by`]. The
    /// answer may lie outside [`EndLoadedBeam::pivot_range_m`].
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] unless the stiffness is positive and finite.
    pub fn pivot_for_stiffness_m(&self, stiffness_n_m: f64) -> Result<f64, ActuatorError> {
        if !(stiffness_n_m > 0.0 && stiffness_n_m.is_finite()) {
            return Err(ActuatorError::value("stiffness_n_m", stiffness_n_m, "positive and finite"));
        }
        // Every law falls strictly with a: halve the interval on a logarithmic scale.
        let (mut shortest, mut longest) = (1e-4 * self.total_length_m, 1e4 * self.total_length_m);
        for _ in 0..100 {
            let middle = (shortest * longest).sqrt();
            if self.stiffness_by(self.law, middle) > stiffness_n_m {
                shortest = middle;
            } else {
                longest = middle;
            }
        }
        Ok((shortest * longest).sqrt())
    }

    /// Whether the pivot stands where the mounting and the measured law allow it.
    #[must_use]
    pub fn in_range(&self) -> bool {
        self.pivot_range_m[0] <= self.pivot_m && self.pivot_m <= self.pivot_range_m[1]
    }

    /// Greatest bending stress, at the pivot, `sigma = 6 F a / (b h^2)` (eq 2-2), Pa. The moment at the
    /// pivot is `F a` whatever the law.
    #[must_use]
    pub fn stress_pa(&self, force_n: f64) -> f64 {
        6.0 * force_n.abs() * self.pivot_m / (self.width_m * self.thickness_m.powi(2))
    }

    /// Force at which the beam yields, N.
    #[must_use]
    pub fn yield_force_n(&self) -> f64 {
        self.material.yield_strength_pa / self.stress_pa(1.0)
    }

    /// Deflection at which a beam clamped at the pivot yields, `delta = (2/3)(S_y/E) a^2 / h` (eq 2-1), m.
    #[must_use]
    pub fn max_deflection_m(&self) -> f64 {
        2.0 / 3.0 * self.material.yield_strength_pa / self.material.youngs_modulus_pa * self.pivot_m.powi(2)
            / self.thickness_m
    }

    /// Yield strength over the stress at this force.
    #[must_use]
    pub fn load_safety_factor(&self, force_n: f64) -> f64 {
        self.yield_force_n() / force_n.abs()
    }

    /// Deflection at yield (eq 2-1) over the deflection of the clamped beam (eq 2-3) at this force.
    #[must_use]
    pub fn deflection_safety_factor(&self, force_n: f64) -> f64 {
        self.max_deflection_m() * self.stiffness_by(BeamLaw::Fixed, self.pivot_m) / force_n.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_stiffness_of_the_four_laws() {
        // Columns: a in mm, then fixed, pinned-pinned, fixed-pinned, measured in kN/m, recomputed by hand
        // from eq 2-3 to 2-6 with EI = 62.1 N m^2.
        let table = [
            (65.0, 678.4, 352.8, 400.9, 524.8),
            (70.0, 543.2, 304.2, 341.8, 429.7),
            (88.0, 273.4, 192.5, 207.8, 231.6),
            (110.0, 140.0, 123.2, 127.0, 126.8),
        ];
        for (a, fixed, pinned, fixed_pinned, measured) in table {
            let beam = EndLoadedBeam::saffir(1e-3 * a);
            for (law, kn_m) in [
                (BeamLaw::Fixed, fixed),
                (BeamLaw::PinnedPinned, pinned),
                (BeamLaw::FixedPinned, fixed_pinned),
                (BeamLaw::Measured, measured),
            ] {
                let k = 1e-3 * beam.stiffness_by(law, beam.pivot_m);
                assert!((k / kn_m - 1.0).abs() < 1e-3, "{law:?} at {a} mm: {k}");
            }
        }
    }

    #[test]
    fn published_430_kn_m_at_70_mm() {
        assert!((EndLoadedBeam::saffir(0.070).stiffness_n_m() / 429.67e3 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn published_safety_factors_at_110_mm_and_1000_n() {
        let beam = EndLoadedBeam::saffir(0.110);
        // Printed: 1.35 and 1.46; a linear clamped beam makes both the same (1.355).
        assert!((beam.load_safety_factor(1000.0) - 1.3549).abs() < 1e-4);
        assert!((beam.deflection_safety_factor(1000.0) - 1.3549).abs() < 1e-4);
        assert!((beam.stress_pa(-1000.0) - 611.1e6).abs() < 0.1e6);
        assert!((beam.max_deflection_m() - 9.68e-3).abs() < 1e-5);
    }

    #[test]
    fn analytic_pivot_inverts_stiffness() {
        for law in [BeamLaw::Fixed, BeamLaw::PinnedPinned, BeamLaw::FixedPinned, BeamLaw::Measured] {
            let beam = EndLoadedBeam { law, ..EndLoadedBeam::saffir(0.08) };
            let pivot = beam.pivot_for_stiffness_m(beam.stiffness_n_m()).expect("positive stiffness");
            assert!((pivot - 0.08).abs() < 1e-12, "{law:?}: {pivot}");
        }
        assert!(EndLoadedBeam::saffir(0.08).pivot_for_stiffness_m(-1.0).is_err());
    }
}
