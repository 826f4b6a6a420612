//! What the dissertation's own numbers point to, in sentences with numbers that were just computed.

use serde::Serialize;

use crate::Reproduction;

/// One conclusion with its evidence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The conclusion.
    pub title: String,
    /// Its evidence and its limits.
    pub sentences: Vec<String>,
}

/// The conclusions: static stiffnesses, moving-output peaks, Table 8, the bandwidth bound.
#[must_use]
pub fn findings(r: &Reproduction) -> Vec<Finding> {
    vec![static_points(r), moving_peaks(r), table_8(r), bound(r)]
}

fn static_points(r: &Reproduction) -> Finding {
    let both = r.softer.series_and_scale;
    let mut sentences = vec![
        format!(
            "Measured 372 and 655 kN/m against the design's 380 and 760: one stiffness of {:.0} kN/m in series and a beam {:.1} % stiffer than designed reproduce both (two unknowns, two numbers).",
            1e-3 * both.series_stiffness_n_m,
            100.0 * (both.beam_scale - 1.0)
        ),
        format!(
            "Test that was not fitted: with the beam locked out only the series stiffness is left, {:.2} times the stiff setting (5 to 95 % {:.1} to {:.1}); section 5-2 says four.",
            both.lock_out_factor, both.lock_out_quantiles[0], both.lock_out_quantiles[1]
        ),
        "The same fit by a longer beam instead would leave the locked actuator infinitely stiff, which section 5-2 excludes.".to_owned(),
    ];
    for cause in &r.softer.single {
        sentences.push(format!(
            "{} alone would have to be {} at the compliant and {} at the stiff setting: contradictory.",
            capitalised(cause.unknown),
            crate::text::number(cause.from_compliant),
            crate::text::number(cause.from_stiff)
        ));
    }
    Finding {
        title: "372, 655 kN/m and the lock-out factor point to a series compliance in joints and clamp"
            .to_owned(),
        sentences,
    }
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |c| c.to_uppercase().chain(characters).collect())
}

fn moving_peaks(r: &Reproduction) -> Finding {
    let mut sentences = vec![format!(
        "The stated parameters give {:.2} and {:.2} Hz by formula ({:.2} and {:.2} Hz by nonlinear simulation and H1), the text prints 15.76 and 6.35 Hz: both about 7 to 8 % lower.",
        r.ours("R3-11").unwrap_or(f64::NAN),
        r.ours("R3-12").unwrap_or(f64::NAN),
        r.ours("S3-20").unwrap_or(f64::NAN),
        r.ours("S3-21").unwrap_or(f64::NAN)
    )];
    for e in &r.explanations {
        sentences.push(format!(
            "{}{}: {:.2} and {:.2} Hz, {:.1} % off.",
            capitalised(&e.change),
            if e.value == "-" { String::new() } else { format!(", {}", e.value) },
            e.unlumped_hz,
            e.lumped_hz,
            100.0 * e.misfit
        ));
    }
    sentences.push(
        "More inertia at the output lowers the unlumped peak but hardly the lumped one, whose mass is the reflected rotor; only less stiffness lowers both alike. The text states no such compliance, so this stays a hint, and no parameter of ours is changed by it."
            .to_owned(),
    );
    Finding {
        title: "15.76 and 6.35 Hz point to a missing compliance rather than to a missing inertia".to_owned(),
        sentences,
    }
}

fn table_8(r: &Reproduction) -> Finding {
    let cell = |i: usize| r.table_8[i].pure_force_source_hz;
    Finding {
        title: "Table 8 has its omega_max row sorted by size, and a -3 dB frequency called natural frequency"
            .to_owned(),
        sentences: vec![
            format!(
                "By column (soft SBN, soft SMH, stiff SBN, stiff SMH) omega_max is {:.1}, {:.1}, {:.1}, {:.1} Hz; printed 65.3, 86.6, 135.4, 179.7.",
                cell(0),
                cell(1),
                cell(2),
                cell(3)
            ),
            format!(
                "The plants' natural frequencies are {:.2} and {:.2} Hz; the printed 6.84 and 10.19 Hz are their -3 dB frequencies ({:.2} and {:.2} Hz).",
                r.table_8[1].natural_frequency_hz,
                r.table_8[3].natural_frequency_hz,
                r.table_8[1].plant_bandwidth_hz,
                r.table_8[3].plant_bandwidth_hz
            ),
        ],
    }
}

fn bound(r: &Reproduction) -> Finding {
    let (soft, stiff) = (&r.table_8[1], &r.table_8[3]);
    let loose = |p: &sealegs_actuator::design::Performance| {
        100.0 * (p.bound_hz / p.simulated_hz.unwrap_or(f64::NAN) - 1.0)
    };
    Finding {
        title: "The bandwidth bound of eq 4-52 holds for THOR, loosely, and is not universal".to_owned(),
        sentences: vec![
            format!(
                "At 10 A and 200 N the clipped ideal compensator reaches {:.2} Hz soft and {:.2} Hz stiff; the bound says {:.2} and {:.2} Hz, {:.0} and {:.0} % more.",
                soft.simulated_hz.unwrap_or(f64::NAN),
                stiff.simulated_hz.unwrap_or(f64::NAN),
                soft.bound_hz,
                stiff.bound_hz,
                loose(soft),
                loose(stiff)
            ),
            format!(
                "For plants with a damping ratio above {:.2} the achieved bandwidth exceeds the bound.",
                r.ours("R4-04").unwrap_or(f64::NAN)
            ),
        ],
    }
}
