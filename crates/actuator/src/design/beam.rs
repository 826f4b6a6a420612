//! How the two beams of the dissertation give a wanted stiffness, and what that costs them.

use serde::Serialize;

use crate::spring::{ClampSetting, EndLoadedBeam, MomentLoadedBeam, Spring};

/// One beam set to one stiffness.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BeamChoice {
    /// Which beam.
    pub beam: &'static str,
    /// Pivot distance (SAFFiR) or free length (THOR) that gives the stiffness, m; `None` if none does.
    pub length_m: Option<f64>,
    /// The lengths that the hardware allows, m.
    pub range_m: [f64; 2],
    /// Whether the length is among them.
    pub in_range: bool,
    /// Deflection at the force amplitude, m.
    pub deflection_m: f64,
    /// Deflection at the peak force, m.
    pub peak_deflection_m: f64,
    /// Bending stress at the force amplitude, Pa.
    pub stress_pa: Option<f64>,
    /// Bending stress at the peak force, Pa.
    pub peak_stress_pa: Option<f64>,
    /// Yield strength over the stress at the peak force.
    pub safety_factor: Option<f64>,
    /// The softest setting that the hardware has and that is stiff enough.
    pub available: Option<AvailableSetting>,
}

/// A setting that the hardware has.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AvailableSetting {
    /// In words, as a scenario takes it.
    pub setting: String,
    /// Its stiffness, N/m.
    pub stiffness_n_m: f64,
}

impl AvailableSetting {
    fn of(spring: &Spring) -> Self {
        Self { setting: spring.setting(), stiffness_n_m: spring.stiffness() }
    }
}

/// Both beams for a stiffness (N/m), with forces in N.
pub(super) fn choices(stiffness_n_m: f64, amplitude_n: f64, peak_n: f64) -> Vec<BeamChoice> {
    let saffir = EndLoadedBeam::saffir(0.070);
    let shortest =
        Spring::EndLoadedBeam(EndLoadedBeam { pivot_m: saffir.pivot_range_m[0], ..saffir.clone() });
    let pivot = saffir
        .pivot_for_stiffness_m(stiffness_n_m)
        .ok()
        .map(|pivot_m| EndLoadedBeam { pivot_m, ..saffir.clone() })
        .filter(|beam| beam.pivot_m <= beam.total_length_m);
    // Softer than the longest setting is asked: the longest setting is stiff enough.
    let saffir_available = (stiffness_n_m <= shortest.stiffness()).then(|| {
        let pivot_m = pivot.as_ref().map_or(f64::INFINITY, |b| b.pivot_m).min(saffir.pivot_range_m[1]);
        AvailableSetting::of(&Spring::EndLoadedBeam(EndLoadedBeam { pivot_m, ..saffir.clone() }))
    });

    let thor = |setting| Spring::MomentLoadedBeam(MomentLoadedBeam::thor(setting));
    let ideal = MomentLoadedBeam::thor(ClampSetting::Compliant);
    let length = ideal
        .length_for_stiffness_m(stiffness_n_m)
        .ok()
        .map(|metres| MomentLoadedBeam::thor(ClampSetting::Length(metres)));
    // A stiffness read off a setting's own name may lie a rounding above it.
    let enough = (1.0 - 1e-3) * stiffness_n_m;
    let thor_available = [ClampSetting::Compliant, ClampSetting::Stiff, ClampSetting::LockedOut]
        .map(thor)
        .iter()
        .find(|spring| spring.stiffness() >= enough)
        .map(AvailableSetting::of);

    let choice = |beam, length_m: Option<f64>, range_m: [f64; 2], spring: Option<Spring>, available| {
        let stress = |force| spring.as_ref().and_then(|s| s.stress_pa(force));
        BeamChoice {
            beam,
            length_m,
            range_m,
            in_range: length_m.is_some_and(|l| range_m[0] <= l && l <= range_m[1]),
            deflection_m: amplitude_n / stiffness_n_m,
            peak_deflection_m: peak_n / stiffness_n_m,
            stress_pa: stress(amplitude_n),
            peak_stress_pa: stress(peak_n),
            safety_factor: spring.as_ref().and_then(|s| s.limits(None).yield_force).map(|f| f / peak_n),
            available,
        }
    };
    vec![
        choice(
            "SAFFiR end-loaded cantilever",
            pivot.as_ref().map(|b| b.pivot_m),
            saffir.pivot_range_m,
            pivot.map(Spring::EndLoadedBeam),
            saffir_available,
        ),
        choice(
            "THOR moment-loaded beam",
            length.as_ref().and_then(MomentLoadedBeam::length_m),
            [ideal.stiff_length_m, ideal.compliant_length_m],
            length.map(Spring::MomentLoadedBeam),
            thor_available,
        ),
    ]
}
