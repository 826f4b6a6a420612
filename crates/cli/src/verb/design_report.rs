//! The page of `sealegs design`.

use sealegs::actuator::ActuatorSpec;
use sealegs::actuator::Coefficients;
use sealegs::actuator::compensator::ClippedCompensator;
use sealegs::actuator::response::{CompensatorBound, pure_force_source_hz};
use sealegs::recorder::chart::{Axis, Chart, Dash, Hue, Marker};
use sealegs::recorder::report::{Provenance, Report, Table, Tone};

use super::design::{Answer, DROP_HEADS, drop_rows, performances, sentences};
use sealegs::actuator::design::PERFORMANCE_HEADS;

/// The page.
pub fn html(spec: &ActuatorSpec, answer: &Answer) -> String {
    let mut page = Report::new("Spring for a force bandwidth");
    page.subtitle(&format!("{}: {}", spec.id, spec.description));
    let sentences = sentences(spec, answer);
    let tone = if answer.design.min_stiffness_n_m.is_some() { Tone::Good } else { Tone::Bad };
    page.verdict(tone, &sentences[0], "");
    page.list(&sentences[1..]);
    page.section("Bandwidth and stiffness");
    page.figure(
        &chart(spec, answer),
        "Bandwidth against stiffness: up to where the actuator is a pure force source, and how far an ideal compensator with clipped current controls the force, by the bound of eq 4-52 and in the time domain. The answer is the softest spring above the wanted bandwidth on both.",
    );
    page.section("Performance");
    page.table(&table(&PERFORMANCE_HEADS, performances(answer)), "At the requested current and force. -3 dB: the plant's own; force source: up to where both ends feel the same force (eq 4-37); bound: eq 4-52; increase: its decades. Table 8 as it should be: the print sorts its omega_max row and calls the -3 dB frequency natural.");
    if let Some(drops) = &answer.drops {
        page.section("What it costs at impact");
        page.table(&table(&DROP_HEADS, drop_rows(drops)), &format!("One drop each, scenario {}; ground and carriage are estimates of that scenario. The spring is that of all actuators.", drops.scenario));
    }
    page.provenance(&Provenance {
        command: crate::command(),
        versions: vec![("sealegs".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        ..Provenance::default()
    });
    page.to_html()
}

fn table(heads: &[(&str, &str)], rows: Vec<Vec<String>>) -> Table {
    let mut table = Table::new().words(heads[0].0);
    for (name, unit) in &heads[1..] {
        table = table.numbers(name, unit);
    }
    for row in rows {
        table.row(row);
    }
    table
}

fn chart(spec: &ActuatorSpec, answer: &Answer) -> Chart {
    let r = &answer.design.request;
    let nominal =
        Coefficients { configuration: r.spring_side, sprung_mass: r.sprung_mass_kg, ..spec.coefficients() };
    let grid: Vec<f64> = (0..81).map(|i| 50e3 * 60f64.powf(f64::from(i) / 80.0)).collect();
    let line = |f: &dyn Fn(f64) -> f64| grid.iter().map(|k| (1e-3 * k, f(*k))).collect::<Vec<_>>();
    let at = |stiffness| Coefficients { stiffness, ..nominal };
    let (current, force) = (r.current_limit_a, r.amplitude_n);
    let simulated = |k: f64| ClippedCompensator::new(&at(k), current).bandwidth_hz(force).unwrap_or(f64::NAN);
    let mut chart = Chart::new(
        "Bandwidth and stiffness",
        Axis::new("Stiffness", "kN/m").log(),
        Axis::new("Bandwidth", "Hz").log(),
    )
    .line(
        "pure force source (4-37)",
        Hue::Green,
        Dash::DashDot,
        line(&|k| pure_force_source_hz(k, r.sprung_mass_kg)),
    )
    .line(
        "bound (4-52)",
        Hue::Vermillion,
        Dash::Dashed,
        line(&|k| CompensatorBound::new(&at(k), current, force).bandwidth_hz),
    )
    .line("simulated, clipped", Hue::Blue, Dash::Solid, line(&simulated))
    .horizontal(r.bandwidth_hz, "wanted");
    if let Some(k) = answer.design.min_stiffness_n_m {
        let text = format!("{:.0} kN/m", 1e-3 * k);
        chart = chart.note((1e-3 * k, r.bandwidth_hz), &text, Marker::Circle, Hue::Ink);
    }
    chart.tall(400.0)
}
