//! A performance as a line of a table for people.

use super::{Criterion, Performance};

/// Heads of the table of performances, with units.
pub const PERFORMANCE_HEADS: [(&str, &str); 11] = [
    ("configuration", ""),
    ("k", "kN/m"),
    ("sprung", "kg"),
    ("natural", "Hz"),
    ("-3 dB", "Hz"),
    ("force source", "Hz"),
    ("increase", "decades"),
    ("bound", "Hz"),
    ("simulated", "Hz"),
    ("usable", "Hz"),
    ("limit", ""),
];

/// One line of the table of performances.
#[must_use]
pub fn performance_cells(name: &str, p: &Performance) -> Vec<String> {
    vec![
        name.to_owned(),
        format!("{:.1}", 1e-3 * p.stiffness_n_m),
        format!("{}", p.sprung_mass_kg),
        format!("{:.2}", p.natural_frequency_hz),
        format!("{:.2}", p.plant_bandwidth_hz),
        format!("{:.1}", p.pure_force_source_hz),
        format!("{:.4}", p.increase_decades),
        format!("{:.2}{}", p.bound_hz, if p.bound_holds { "" } else { " (fails)" }),
        p.simulated_hz.map_or_else(|| "none".to_owned(), |f| format!("{f:.2}")),
        format!("{:.2}", p.usable_hz),
        match p.limited_by {
            Criterion::PureForceSource => "force source",
            Criterion::ControlledBandwidth => "current",
        }
        .to_owned(),
    ]
}
