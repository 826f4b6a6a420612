//! `sealegs design`: the spring for a force bandwidth, as chapter 4 would choose it.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use sealegs::actuator::design::{
    Criterion, Design, DesignRequest, PERFORMANCE_HEADS, Performance, design, performance_cells, table_8,
};
use sealegs::actuator::spring::Spring;
use sealegs::actuator::{ActuatorSpec, Configuration};
use sealegs::leg::impact::{ImpactTable, sweep};
use sealegs::leg::scenario::{Scenario, SweepSpec};
use serde_json::json;

use crate::failure::OrBadInput;
use crate::output::Destination;

/// Choose spring stiffness and spring side for a force bandwidth.
#[derive(Args)]
pub struct DesignArguments {
    /// Amplitude of the force to be controlled, N
    #[arg(long, value_name = "N", default_value_t = 200.0)]
    force: f64,
    /// Bandwidth that is wanted at this amplitude, Hz
    #[arg(long, value_name = "HZ", default_value_t = 30.0)]
    bandwidth: f64,
    /// Current limit, A; the actuator's own without it
    #[arg(long, value_name = "A")]
    current: Option<f64>,
    /// Sprung mass, kg; the actuator's own for its own spring side, else 0.15 (SBN, an estimate of the
    /// dissertation)
    #[arg(long, value_name = "KG")]
    sprung_mass: Option<f64>,
    /// Side of the spring; the actuator's own without it
    #[arg(long)]
    spring_side: Option<Side>,
    /// Actuator: a preset or a file
    #[arg(long, default_value = "thor-linear")]
    actuator: String,
    /// Height of the drop that shows what the spring costs at impact, m
    #[arg(long, value_name = "M", default_value_t = 0.05)]
    drop_height: f64,
    /// Leave the drops out
    #[arg(long)]
    no_drop: bool,
    /// Write everything as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Write a report
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Side of the spring.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Side {
    /// Sprung motor housing
    Smh,
    /// Sprung ball nut
    Sbn,
}

/// The design, the corrected Table 8 and the drops.
pub struct Answer {
    /// The design.
    pub design: Design,
    /// Table 8 at the request's current and force.
    pub table_8: [Performance; 4],
    /// What was dropped, and what it cost.
    pub drops: Option<ImpactTable>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input: an unknown actuator, a number that is not positive, a file that cannot be written.
pub fn run(arguments: &DesignArguments) -> anyhow::Result<u8> {
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let spec = ActuatorSpec::load(&arguments.actuator, None).or_bad_input()?;
    let answer = answer(arguments, &spec)?;
    if let Some(destination) = json {
        let value = json!({
            "actuator": spec.id,
            "design": answer.design,
            "table_8": answer.table_8,
            "drops": answer.drops,
        });
        destination.write(format!("{}\n", serde_json::to_string_pretty(&value)?).as_bytes())?;
    }
    if let Some(destination) = report {
        destination.write(super::design_report::html(&spec, &answer).as_bytes())?;
    }
    let to_stdout = |p: &Option<PathBuf>| p.as_deref() == Some(Path::new("-"));
    if !to_stdout(&arguments.json) && !to_stdout(&arguments.report) {
        write!(std::io::stdout().lock(), "{}", text(&spec, &answer))?;
    }
    Ok(0)
}

fn answer(arguments: &DesignArguments, spec: &ActuatorSpec) -> anyhow::Result<Answer> {
    let spring_side = match arguments.spring_side {
        Some(Side::Smh) => Configuration::SprungMotorHousing,
        Some(Side::Sbn) => Configuration::SprungBallNut,
        None => spec.configuration,
    };
    let own = spec.coefficients().sprung_mass;
    let usual = if spring_side == spec.configuration { own } else { 0.15 };
    let request = DesignRequest {
        amplitude_n: arguments.force,
        bandwidth_hz: arguments.bandwidth,
        current_limit_a: arguments.current.or(spec.motor.current_limit_a).unwrap_or(10.0),
        sprung_mass_kg: arguments.sprung_mass.unwrap_or(usual),
        spring_side,
    };
    let design = design(spec, &request).or_bad_input()?;
    let thor = ActuatorSpec::preset("thor-linear")?;
    let table_8 = table_8(&thor, request.current_limit_a, request.amplitude_n);
    let drops = if arguments.no_drop { None } else { Some(drops(arguments, spec, &design)?) };
    Ok(Answer { design, table_8, drops })
}

/// One drop of the leg that bears this kind of beam, for each setting of interest.
fn drops(arguments: &DesignArguments, spec: &ActuatorSpec, design: &Design) -> anyhow::Result<ImpactTable> {
    let saffir = matches!(spec.spring, Spring::EndLoadedBeam(_));
    let beam = &design.beams.get(usize::from(!saffir));
    let mut springs: Vec<String> =
        beam.and_then(|b| b.length_m).map(|m| format!("{:.2}mm", 1e3 * m)).into_iter().collect();
    let usual: &[&str] = if saffir { &["110mm", "65mm"] } else { &["compliant", "stiff", "locked-out"] };
    springs.extend(usual.iter().map(|s| (*s).to_owned()));
    let scenario = Scenario::load(if saffir { "saffir-drop" } else { "thor-drop" }, &[])?;
    let over = SweepSpec { heights_m: vec![arguments.drop_height], springs };
    sweep(&scenario, &over, false, &|| ()).or_bad_input()
}

/// What is sprung, in words.
#[must_use]
pub fn side_name(side: Configuration) -> &'static str {
    match side {
        Configuration::SprungMotorHousing => "sprung motor housing",
        Configuration::SprungBallNut => "sprung ball nut",
        Configuration::Lumped => "lumped",
    }
}

/// What limits, in words.
#[must_use]
pub fn limit_name(criterion: Criterion) -> &'static str {
    match criterion {
        Criterion::PureForceSource => "pure force source (eq 4-37)",
        Criterion::ControlledBandwidth => "current limit (clipped compensator)",
    }
}

/// A stiffness in kN/m, or a dash.
#[must_use]
pub fn kn_m(stiffness: Option<f64>) -> String {
    stiffness.map_or_else(|| "none".to_owned(), |k| format!("{:.1}", 1e-3 * k))
}

/// The sentences of the answer, most important first.
#[must_use]
pub fn sentences(spec: &ActuatorSpec, answer: &Answer) -> Vec<String> {
    let d = &answer.design;
    let r = &d.request;
    let mut lines = vec![match d.min_stiffness_n_m {
        Some(k) => format!(
            "{} for {} N at {} Hz within {} A ({}, {} kg sprung): a spring of at least {:.1} kN/m. What decides: {}.",
            spec.id,
            r.amplitude_n,
            r.bandwidth_hz,
            r.current_limit_a,
            side_name(r.spring_side),
            r.sprung_mass_kg,
            1e-3 * k,
            limit_name(d.limited_by)
        ),
        None => format!(
            "{}: no spring gives {} N at {} Hz within {} A.",
            spec.id, r.amplitude_n, r.bandwidth_hz, r.current_limit_a
        ),
    }];
    lines.push(format!(
        "Least stiffness [kN/m]: {} as a pure force source (eq 4-38 with 135.2), {} by the bound of eq 4-52, {} by the clipped compensator in the time domain.",
        kn_m(Some(d.pure_force_source_min_stiffness_n_m)),
        kn_m(d.bound_min_stiffness_n_m),
        kn_m(d.simulated_min_stiffness_n_m)
    ));
    lines.push(match d.bound_fails_below_n_m {
        Some(k) => {
            format!("Below {:.0} kN/m eq 4-52 is no upper bound: the plant is damped too well.", 1e-3 * k)
        }
        None => "Eq 4-52 is an upper bound at every stiffness here.".to_owned(),
    });
    for b in &d.beams {
        let length = match b.length_m {
            None => "no length gives this stiffness".to_owned(),
            Some(l) => format!(
                "{:.1} mm ({}), deflection {:.2} mm at {} N and {:.2} mm at peak force, peak stress {}, safety factor {}",
                1e3 * l,
                if b.in_range {
                    "within its range".to_owned()
                } else {
                    format!("outside its {:.0} to {:.0} mm", 1e3 * b.range_m[0], 1e3 * b.range_m[1])
                },
                1e3 * b.deflection_m,
                r.amplitude_n,
                1e3 * b.peak_deflection_m,
                b.peak_stress_pa.map_or_else(|| "-".to_owned(), |s| format!("{:.0} MPa", 1e-6 * s)),
                b.safety_factor.map_or_else(|| "-".to_owned(), |s| format!("{s:.2}"))
            ),
        };
        let available = b.available.as_ref().map_or_else(
            || "nothing that it has is stiff enough".to_owned(),
            |a| format!("softest that it has: {} ({:.0} kN/m)", a.setting, 1e-3 * a.stiffness_n_m),
        );
        lines.push(format!("{}: {length}; {available}.", b.beam));
    }
    lines
}

/// Lines of performance: at the answer, at present, and the corrected Table 8.
#[must_use]
pub fn performances(answer: &Answer) -> Vec<Vec<String>> {
    let d = &answer.design;
    let mut rows = Vec::new();
    if let Some(p) = &d.at_min_stiffness {
        rows.push(performance_cells("at the least stiffness", p));
    }
    rows.push(performance_cells("with the present spring", &d.at_present));
    for (name, p) in ["soft SBN", "soft SMH", "stiff SBN", "stiff SMH"].into_iter().zip(&answer.table_8) {
        rows.push(performance_cells(&format!("Table 8, {name}"), p));
    }
    rows
}

/// Heads of the table of drops, with units.
pub const DROP_HEADS: [(&str, &str); 6] = [
    ("spring", ""),
    ("height", "m"),
    ("ground peak", "N"),
    ("actuator peak", "N"),
    ("which", ""),
    ("rated/peak", ""),
];

/// Lines of the drops.
#[must_use]
pub fn drop_rows(drops: &ImpactTable) -> Vec<Vec<String>> {
    drops
        .rows
        .iter()
        .map(|row| {
            let (force, name) = row.greatest_force();
            let margin = row.actuators.iter().filter_map(|a| a.force_margin).fold(f64::INFINITY, f64::min);
            vec![
                row.spring.clone(),
                format!("{}", row.height_m),
                format!("{:.0}", row.ground_force_n),
                format!("{force:.0}"),
                name.to_owned(),
                if margin.is_finite() { format!("{margin:.2}") } else { "-".to_owned() },
            ]
        })
        .collect()
}

fn text(spec: &ActuatorSpec, answer: &Answer) -> String {
    let mut out = String::new();
    for sentence in sentences(spec, answer) {
        out.push_str(&sentence);
        out.push('\n');
    }
    out.push('\n');
    out.push_str(&aligned(&PERFORMANCE_HEADS, &performances(answer)));
    out.push_str("-3 dB: the plant's own; force source: up to where both ends feel the same force (eq 4-37); bound: eq 4-52. Table 8 as it\nshould be: the print sorts its omega_max row and calls the -3 dB frequency natural.\n");
    if let Some(drops) = &answer.drops {
        out.push_str(&format!(
            "\nWhat it costs at impact ({}, estimates of ground and rail as in that scenario):\n",
            drops.scenario
        ));
        out.push_str(&aligned(&DROP_HEADS, &drop_rows(drops)));
    }
    out
}

/// Columns in line: the first to the left, the others to the right.
fn aligned(heads: &[(&str, &str)], rows: &[Vec<String>]) -> String {
    let heads: Vec<String> = heads
        .iter()
        .map(|(name, unit)| if unit.is_empty() { (*name).to_owned() } else { format!("{name} [{unit}]") })
        .collect();
    let width = |i: usize| {
        rows.iter().map(|r| r[i].chars().count()).chain([heads[i].chars().count()]).max().unwrap_or(0)
    };
    let line = |cells: Vec<&str>| {
        let padded: Vec<String> = cells
            .iter()
            .enumerate()
            .map(
                |(i, c)| {
                    if i == 0 { format!("{c:<w$}", w = width(i)) } else { format!("{c:>w$}", w = width(i)) }
                },
            )
            .collect();
        format!("{}\n", padded.join("  ").trim_end())
    };
    let mut out = line(heads.iter().map(String::as_str).collect());
    for row in rows {
        out.push_str(&line(row.iter().map(String::as_str).collect()));
    }
    out
}
