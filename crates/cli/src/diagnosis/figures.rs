//! The pictures of a diagnosis: measured, before and after in time and in frequency, maps and loops.

use super::story::Story;
use crate::comparison::Part;
use crate::comparison::text::unit;
use sealegs_model::internal;
use sealegs_recorder::chart::{Axis, Chart, Dash, HeatMap, Hue, Marker};
use sealegs_recorder::report::Report;
use sealegs_sysid::{Evaluation, stats};

/// Names of the two models in legends.
const BEFORE: &str = "before";
const AFTER: &str = "after";

/// What a model says a sensor shows, at all time stamps of a run.
pub(super) fn shown(part: &Part, at: &Evaluation, run: usize, slot: usize) -> Option<Vec<f64>> {
    let r = &part.data.runs[run];
    let sensor = &at.sensors[r.channels[slot]];
    let bias = sensor.bias_of(run);
    Some(at.predictions[run].output(&r.names[slot])?.iter().map(|p| sensor.gain * p + bias).collect())
}

/// The two models with their colours.
fn models<'a>(part: &'a Part<'_>) -> Vec<(&'static str, Hue, Dash, &'a Evaluation)> {
    let mut all = vec![(BEFORE, Hue::Vermillion, Dash::Dashed, &part.before)];
    all.extend(part.after.as_ref().map(|a| (AFTER, Hue::Blue, Dash::Solid, a)));
    all
}

/// The run of a part on which the first model fails most.
fn worst_run(part: &Part) -> usize {
    let squares = |run: usize| -> f64 {
        part.before.blocks.iter().filter(|b| b.run == run).flat_map(|b| &b.residual).map(|r| r * r).sum()
    };
    (0..part.data.runs.len()).reduce(|a, b| if squares(b) > squares(a) { b } else { a }).unwrap_or(0)
}

/// Measured, before and after in time, with the residuals below, of the worst run of each role.
pub fn motion(page: &mut Report, story: &Story) {
    page.section("Measured, before and after in time");
    for part in story.compared.parts.iter().rev() {
        let run = worst_run(part);
        let r = &part.data.runs[run];
        for slot in 0..r.names.len() {
            let (name, unit) = (&r.names[slot], unit(&r.names[slot]));
            let group = format!("{}-{run}", r.role.as_str());
            let time = &r.record.time_s;
            let points = |v: &[f64]| time.iter().copied().zip(v.iter().copied()).collect::<Vec<_>>();
            let measured = r.measured[slot];
            let mut above = Chart::new(
                &format!("{name} in {} ({})", r.record.name, r.role.as_str()),
                Axis::new("time", "s"),
                Axis::new(name, unit),
            )
            .line("measured", Hue::Ink, Dash::Solid, points(measured));
            let mut below = Chart::new(
                "Residual, measured minus predicted",
                Axis::new("time", "s"),
                Axis::new("residual", unit),
            );
            for (label, hue, dash, at) in models(part) {
                let Some(predicted) = shown(part, at, run, slot) else { continue };
                let residual: Vec<f64> = measured.iter().zip(&predicted).map(|(m, p)| m - p).collect();
                above = above.line(label, hue, dash, points(&predicted));
                below = below.line(label, hue, Dash::Solid, points(&residual));
            }
            page.figure_of(
                &[&above.zoomable(&group), &below.zoomable(&group).tall(200.0)],
                &format!("{name}, measured and predicted, and what is left, in the {} run with the greatest error.", r.role.as_str()),
            );
        }
    }
}

/// Frequency responses, measured, before and after.
pub fn responses(page: &mut Report, story: &Story) {
    let mut begun = false;
    for r in &story.compared.responses {
        let m = &r.measured;
        let coherent: Vec<usize> =
            (0..m.frequency_hz.len()).filter(|&i| m.frequency_hz[i] > 0.0 && m.coherence[i] > 0.5).collect();
        if coherent.len() < 3 {
            continue;
        }
        if !begun {
            page.section("Measured, before and after in frequency");
            begun = true;
        }
        let at = |v: &[f64]| coherent.iter().map(|&i| (m.frequency_hz[i], v[i])).collect::<Vec<_>>();
        let degrees = |v: Vec<f64>| v.into_iter().map(f64::to_degrees).collect::<Vec<_>>();
        let bounds = m.bounds_db(2.0);
        let hz = || Axis::new("frequency", "Hz").log();
        let after = story.after_responses.iter().find(|a| a.channel == r.channel);
        let mut magnitude =
            Chart::new(&format!("{} per {}", r.channel, r.input), hz(), Axis::new("magnitude", "dB"))
                .band(
                    "95 % confidence",
                    Hue::Grey,
                    coherent.iter().map(|&i| (m.frequency_hz[i], bounds[i].0, bounds[i].1)).collect(),
                )
                .scatter("measured", Hue::Ink, Marker::Dot, at(&m.magnitude_db()))
                .line(BEFORE, Hue::Vermillion, Dash::Dashed, at(&r.predicted.magnitude_db()));
        let mut phase = Chart::new("Phase", hz(), Axis::new("phase", "degrees"))
            .scatter("", Hue::Ink, Marker::Dot, at(&degrees(m.phase_rad())))
            .line("", Hue::Vermillion, Dash::Dashed, at(&degrees(r.predicted.phase_rad())))
            .tall(220.0);
        if let Some(a) = after {
            magnitude = magnitude.line(AFTER, Hue::Blue, Dash::Solid, at(&a.predicted.magnitude_db()));
            phase = phase.line("", Hue::Blue, Dash::Solid, at(&degrees(a.predicted.phase_rad())));
        }
        page.figure_of(
            &[&magnitude, &phase],
            &format!(
                "{}: H1 estimates over all runs, measurement and models alike, where the coherence is above 0.5.",
                r.channel
            ),
        );
    }
}

/// Rows and columns of a map.
const CELLS: usize = 7;

/// Root mean square residual by speed and load, before and after.
pub fn maps(page: &mut Report, story: &Story) {
    let parts = &story.compared.parts;
    let axis = |name: &str| -> Option<f64> {
        let values =
            parts.iter().flat_map(|p| &p.before.predictions).filter_map(|p| p.internal(name)).flatten();
        let sizes: Vec<f64> = values.map(|v| v.abs()).filter(|v| v.is_finite()).collect();
        Some(stats::quantile(&sizes, 0.99)).filter(|s| *s > 0.0)
    };
    let (Some(speed), Some(load)) = (axis(internal::SCREW_SPEED), axis(internal::SCREW_FORCE)) else {
        return;
    };
    let names = |range: f64| -> Vec<String> {
        (0..CELLS)
            .map(|i| {
                crate::diagnosis::text::figures(range * (2.0 * (i as f64 + 0.5) / CELLS as f64 - 1.0), 2)
            })
            .map(|t| t.replace('-', "−"))
            .collect()
    };
    let cell = |v: f64, range: f64| {
        (((v / range + 1.0) * 0.5 * CELLS as f64) as isize).clamp(0, CELLS as isize - 1) as usize
    };
    let rotary = parts.iter().flat_map(|p| &p.data.channels).any(|c| c.name.ends_with("_nm"));
    let (speed_unit, load_unit) = if rotary { ("rad/s", "N m") } else { ("m/s", "N") };
    let map = |title: &str, of: &dyn Fn(&Part) -> Option<Evaluation>| -> HeatMap {
        let mut sums = vec![(0.0, 0usize); CELLS * CELLS];
        for part in parts {
            let Some(at) = of(part) else { continue };
            for block in &at.blocks {
                let p = &part.before.predictions[block.run];
                let (Some(v), Some(f)) =
                    (p.internal(internal::SCREW_SPEED), p.internal(internal::SCREW_FORCE))
                else {
                    continue;
                };
                for (r, i) in block.residual.iter().zip(part.data.runs[block.run].rows()) {
                    let c = &mut sums[cell(f[i], load) * CELLS + cell(v[i], speed)];
                    *c = (c.0 + r * r, c.1 + 1);
                }
            }
        }
        HeatMap {
            title: title.to_owned(),
            x: Axis::new("screw speed", speed_unit),
            y: Axis::new("screw force", load_unit),
            columns: names(speed),
            rows: names(load),
            values: sums
                .iter()
                .map(|(s, n)| if *n >= 20 { (s / *n as f64).sqrt() } else { f64::NAN })
                .collect(),
            value_label: "root mean square residual, noise units".to_owned(),
            decimals: 1,
        }
    };
    page.section("Residual maps");
    let before = map("Before, by speed and load", &|p| Some(p.before.clone()));
    if parts.iter().any(|p| p.after.is_some()) {
        let after = map("After, by speed and load", &|p| p.after.clone());
        page.figure_of(
            &[&before, &after],
            "Residual of all runs and channels by predicted speed and load; empty: no data.",
        );
    } else {
        page.figure(
            &before,
            "Residual of all runs and channels by predicted speed and load; empty: no data.",
        );
    }
}

/// One slow cycle of both models, in which friction, play, slip and a spring's curve show as a loop, where an
/// effect is one of them.
pub fn law(page: &mut Report, story: &Story) {
    let shows = |e: &String| {
        ["friction", "hysteresis", "backlash", "spring", "compliance"].iter().any(|w| e.contains(w))
    };
    let Some(cycle) = story.cycle.as_ref().filter(|_| story.outcome.effects.iter().any(shows)) else {
        return;
    };
    page.section("Loop");
    let chart = Chart::new(
        &format!("{} over one slow cycle of {}", cycle.output, cycle.input),
        Axis::new(&cycle.input, unit(&cycle.input)),
        Axis::new(&cycle.output, unit(&cycle.output)),
    )
    .line(BEFORE, Hue::Vermillion, Dash::Dashed, cycle.before.clone())
    .line(AFTER, Hue::Blue, Dash::Solid, cycle.after.clone());
    page.figure(
        &chart,
        &format!(
            "Both models under one slow cycle of {:.0} s, simulated: the width of the loop is what friction, play or slip take, \
             its bend is the spring's.",
            cycle.seconds
        ),
    );
}
