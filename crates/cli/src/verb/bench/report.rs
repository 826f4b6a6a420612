//! The page of a run on a bench: what was commanded, what the sensors showed, and the force response.

use sealegs::actuator::bench::Bench;
use sealegs::actuator::plant::GRAVITY_M_S2;
use sealegs::actuator::response::{ForceResponse, Link, db};
use sealegs::actuator::{Configuration, Kind};
use sealegs::model::{Model, Signal, Unit};
use sealegs::recorder::chart::{Axis, Chart, Dash, Hue, Marker};
use sealegs::recorder::report::{Provenance, Report, Table, Tone};
use sealegs::sysid::frf::{Estimator, Hold, Welch};

use super::{BenchRun, extremes};

/// The page.
///
/// # Errors
///
/// None beyond those of the estimate, which is left out where the run is too short for it.
pub fn html(done: &BenchRun) -> anyhow::Result<String> {
    let mut page = Report::new(&done.model.name());
    let spec = done.model.spec();
    page.subtitle(&format!("{}; spring {}", spec.description, spec.spring.setting()));
    if done.prediction.events.is_empty() {
        page.verdict(Tone::Good, "No limit of the spring or of the actuator's rating was exceeded.", "");
    } else {
        page.verdict(Tone::Caution, "Limits were exceeded.", &done.prediction.events.join("; "));
    }
    let signals: Vec<&Signal> = done.record.inputs.iter().chain(&done.outputs).collect();
    let unit = |s: &Signal| Unit::symbol_of(&s.channel);
    let mut table = Table::new()
        .words("Channel")
        .words("Unit")
        .numbers("RMS", "")
        .numbers("Least", "")
        .numbers("Greatest", "");
    for s in &signals {
        let (rms, low, high) = extremes(&s.values);
        table.row([
            s.channel.clone(),
            unit(s).to_owned(),
            format!("{rms:.5}"),
            format!("{low:.5}"),
            format!("{high:.5}"),
        ]);
    }
    page.table(&table, "Channels of the run.");
    page.section("In time");
    for s in &signals {
        let points = done.record.time_s.iter().copied().zip(s.values.iter().copied()).collect();
        let chart = Chart::new(&s.channel, Axis::new("Time", "s"), Axis::new(&s.channel, unit(s)))
            .line("", Hue::Blue, Dash::Solid, points)
            .zoomable("time");
        page.figure(&chart, &s.channel);
    }
    if let Some(chart) = response(done) {
        page.section("Force response");
        page.figure(&chart, "Spring force per motor force by an H1 estimate of this run (Hann windows, half overlap, the hold taken out, lines of coherence above 0.5) and by the closed form of the same actuator without effects and friction.");
    }
    page.section("Actuator");
    page.details("The actuator's file", |page| {
        page.preformatted(&spec.to_toml());
    });
    page.provenance(&Provenance {
        command: crate::command(),
        versions: vec![("sealegs".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        ..Provenance::default()
    });
    Ok(page.to_html())
}

/// F1 per motor force, estimated and in closed form; `None` for a rotary actuator or a run that is too short.
fn response(done: &BenchRun) -> Option<Chart> {
    let spec = done.model.spec();
    if spec.kind != Kind::Linear || spec.configuration == Configuration::SprungBallNut {
        return None;
    }
    let c = spec.coefficients();
    let input = done.record.inputs.first()?;
    let per_command = if input.channel == "current_a" { c.force_constant } else { 1.0 };
    let force: Vec<f64> = input.values.iter().map(|v| v * per_command).collect();
    let measured = &done.outputs.iter().find(|s| s.channel == "force_1_n")?.values;
    let segment = 1usize << (force.len() / 4).checked_ilog2()?.min(14);
    let period = done.record.time_s.get(1)? - done.record.time_s.first()?;
    let estimate = Welch::hann(segment)
        .spectra(period, &[(&force, measured)])
        .ok()?
        .response(Estimator::H1)
        .without_hold(Hold::ZeroOrder)
        .band(1.5 / (segment as f64 * period), 0.4 / period, 0.5);
    let link = match done.model.bench() {
        Bench::Pendulum(rig) => Link::pendulum(rig.arm_m, rig.length_m, rig.mass_kg, GRAVITY_M_S2),
        _ => Link::Fixed,
    };
    let formula = ForceResponse::between(&c, Link::Fixed, link);
    let (low, high) = (1.0 / (segment as f64 * period), 0.5 / period);
    let grid = (0..500).map(|i| low * (high / low).powf(f64::from(i) / 499.0));
    let magnitude = estimate.magnitude_db();
    Some(
        Chart::new("F1/Fm", Axis::new("Frequency", "Hz").log(), Axis::new("Magnitude", "dB"))
            .line(
                "closed form",
                Hue::Blue,
                Dash::Solid,
                grid.map(|f| (f, db(formula.force_1().at_hz(f)))).collect(),
            )
            .scatter(
                "estimate of this run",
                Hue::Ink,
                Marker::Dot,
                estimate.frequency_hz.iter().copied().zip(magnitude).collect(),
            ),
    )
}
