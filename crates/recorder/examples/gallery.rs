//! Writes a page with one of each picture, to look at.
//!
//! `cargo run --release -p sealegs-recorder --example gallery -- gallery.html [comparison.rrd]`
//!
//! All curves are made up.

use sealegs_recorder::chart::{Axis, Bar, BarChart, Chart, Contours, Dash, HeatMap, Hue, Marker};
use sealegs_recorder::recording::{ComparedChannel, ComparedRun, Comparison, Output};
use sealegs_recorder::report::{Provenance, Report, Table, Tone};
use std::f64::consts::{PI, TAU};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "gallery.html".into());
    let mut report = Report::new("Gallery of made-up results");
    report
        .subtitle("thor-linear on the locked bench, 3 runs")
        .verdict(
            Tone::Good,
            "Backlash of 0.12 mm in the screw explains what the model missed.",
            "Error on the holdout run 8.4 → 1.03 noise units; the next best explanation is 41 times less likely.",
        )
        .numbers(&[
            ("Error before", "8.4", "noise units"),
            ("Error after", "1.03", "noise units"),
            ("Backlash", "0.121 mm", "± 0.002 mm"),
        ]);
    pictures(&mut report);
    tables(&mut report);
    report.provenance(&Provenance {
        command: "sealegs diagnose campaign --report gallery.html".into(),
        versions: vec![("sealegs".into(), "0.1.0".into())],
        inputs: vec![("run-01.csv".into(), format!("sha256:{}", "9f86d081".repeat(8)))],
        seed: Some(1),
        notes: vec![("Note".into(), "nothing on this page was measured".into())],
    });
    let html = report.to_html();
    std::fs::write(&file, &html)?;
    println!("{file}: {:.0} kB", html.len() as f64 / 1e3);
    if let Some(recording) = arguments.next() {
        comparison().write(&Output::File(recording.into()))?;
    }
    Ok(())
}

fn force(t: f64, k: f64) -> f64 {
    let phase = TAU * (0.4 * t + 0.12 * t * t);
    600.0 * phase.sin() * k + 90.0 * (k - 0.9) * (3.0 * phase).sin()
}

fn noise(i: usize) -> f64 {
    let hash = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
    hash as f64 / (1u64 << 24) as f64 - 0.5
}

fn curve(k: f64, noisy: bool) -> Vec<(f64, f64)> {
    (0..20_000)
        .map(|i| (i as f64 * 1e-3, force(i as f64 * 1e-3, k) + if noisy { 30.0 * noise(i) } else { 0.0 }))
        .collect()
}

fn pictures(report: &mut Report) {
    let difference = |a: &[(f64, f64)], b: &[(f64, f64)]| -> Vec<(f64, f64)> {
        a.iter().zip(b).map(|(p, q)| (p.0, p.1 - q.1)).collect()
    };
    let (measured, before, after) = (curve(1.0, true), curve(0.9, false), curve(1.0, false));
    let overlay =
        Chart::new("Force on link 1, run 3 (holdout)", Axis::new("Time", "s"), Axis::new("Force F1", "N"))
            .line("measured", Hue::Ink, Dash::Solid, measured.clone())
            .line("model before", Hue::Vermillion, Dash::Dashed, before.clone())
            .line("model after", Hue::Blue, Dash::Solid, after.clone())
            .zoomable("run 3");
    let residual =
        Chart::new("Residual, measured − model", Axis::new("Time", "s"), Axis::new("Residual", "N"))
            .line("before", Hue::Vermillion, Dash::Solid, difference(&measured, &before))
            .line("after", Hue::Blue, Dash::Solid, difference(&measured, &after))
            .zoomable("run 3")
            .tall(260.0);
    report.section("Measured, before and after");
    report.figure_of(&[&overlay, &residual], "The holdout run in time; both pictures zoom together.");

    report.section("Frequency");
    let f: Vec<f64> = (0..160).map(|i| 0.5 * 10_f64.powf(f64::from(i) / 68.0)).collect();
    let gain = |f: f64, f0: f64| 1.0 / ((1.0 - (f / f0).powi(2)).powi(2) + (0.12 * f / f0).powi(2)).sqrt();
    let phase = |f: f64, f0: f64| -(0.12 * f / f0).atan2(1.0 - (f / f0).powi(2)) * 180.0 / PI;
    let magnitude = Chart::new(
        "Frequency response F1 / current",
        Axis::new("Frequency", "Hz").log(),
        Axis::new("Gain", "N/A").log(),
    )
    .band(
        "95 % confidence",
        Hue::Ink,
        f.iter().map(|&f| (f, 180.0 * gain(f, 17.02), 240.0 * gain(f, 17.02))).collect(),
    )
    .marked(
        "measured",
        Hue::Ink,
        Dash::Solid,
        Marker::Circle,
        f.iter().map(|&f| (f, 210.0 * gain(f, 17.02))).collect(),
    )
    .line(
        "model before",
        Hue::Vermillion,
        Dash::Dashed,
        f.iter().map(|&f| (f, 210.0 * gain(f, 22.0))).collect(),
    )
    .line("model after", Hue::Blue, Dash::DashDot, f.iter().map(|&f| (f, 208.0 * gain(f, 17.2))).collect())
    .vertical(15.76, "15.76 Hz printed")
    .vertical(17.02, "17.02 Hz from the stated parameters");
    let angle = Chart::new("", Axis::new("Frequency", "Hz").log(), Axis::new("Phase", "°"))
        .line("measured", Hue::Ink, Dash::Solid, f.iter().map(|&f| (f, phase(f, 17.02))).collect())
        .line("model before", Hue::Vermillion, Dash::Dashed, f.iter().map(|&f| (f, phase(f, 22.0))).collect())
        .tall(240.0);
    report
        .figure_of(&[&magnitude, &angle], "Measured response with its confidence band against both models.");

    report.section("Where it failed");
    let loop_of = |lag: f64| -> Vec<(f64, f64)> {
        (0..=400)
            .map(|i| TAU * f64::from(i) / 400.0)
            .map(|p| (0.0015 * p.sin(), 900.0 * (p + lag).sin()))
            .collect()
    };
    let hysteresis =
        Chart::new("Force over deflection", Axis::new("Spring deflection", "m"), Axis::new("Force", "N"))
            .scatter(
                "measured",
                Hue::Ink,
                Marker::Dot,
                (0..700)
                    .map(|i| {
                        let p = TAU * f64::from(i) / 350.0;
                        (
                            0.0015 * p.sin() + 4e-5 * noise(i as usize),
                            900.0 * (p + 0.22).sin() + 60.0 * noise(i as usize + 999),
                        )
                    })
                    .collect(),
            )
            .line("model before", Hue::Vermillion, Dash::Dashed, loop_of(0.0))
            .line("model after", Hue::Blue, Dash::Solid, loop_of(0.22));
    report.figure(&hysteresis, "A loop that the first model does not have.");
    let shares = BarChart {
        title: "Share of the squared error against share of the samples".into(),
        axis: Axis::new("Share", "%"),
        series: vec![("of the error".into(), Hue::Vermillion), ("of the samples".into(), Hue::Grey)],
        bars: [
            ("within 20 ms after a reversal", 61.0, 9.0),
            ("screw speed below 2 mm/s", 22.0, 14.0),
            ("load above 800 N", 9.0, 31.0),
            ("elsewhere", 8.0, 46.0),
        ]
        .map(|(label, e, s)| Bar { label: label.into(), values: vec![e, s], text: format!("{e} %") })
        .into(),
        ..BarChart::default()
    };
    report.figure(&shares, "Most of the error sits where the screw turns round.");
    let map = HeatMap {
        title: "Residual by speed and load".into(),
        x: Axis::new("Screw speed", "mm/s"),
        y: Axis::new("Load", "N"),
        columns: ["−20", "−12", "−4", "4", "12", "20"].map(String::from).into(),
        rows: ["−800", "−400", "0", "400", "800"].map(String::from).into(),
        values: (0..30)
            .map(|i| {
                if i == 5 {
                    f64::NAN
                } else {
                    1.0 + 8.0 * (-f64::powi(f64::from(i % 6) - 2.5, 2)).exp() + 0.1 * f64::from(i / 6)
                }
            })
            .collect(),
        value_label: "RMS of the residual in noise units".into(),
        decimals: 1,
        shades: None,
        ..HeatMap::default()
    };
    report.figure(&map, "Empty cells hold no samples.");
    let heights: Vec<f64> =
        (0..40).map(|i| (900.0 * (-0.5 * (f64::from(i) / 5.0 - 3.9).powi(2)).exp()).round()).collect();
    let histogram =
        Chart::new("Residual after", Axis::new("Residual", "noise units"), Axis::new("Samples", ""))
            .histogram("holdout", Hue::Blue, (0..=40).map(|i| -4.0 + 0.2 * f64::from(i)).collect(), heights)
            .tall(260.0);
    report.figure(&histogram, "What is left looks like noise.");

    let x: Vec<f64> = (0..60).map(|i| 10_f64.powf(4.5 + f64::from(i) * 0.04)).collect();
    let y: Vec<f64> = (0..50).map(|i| 100.0 + 50.0 * f64::from(i)).collect();
    let bandwidth = |k: f64, a: f64| (k / 260.0).sqrt() / TAU / (1.0 + a / 900.0);
    let values = y.iter().flat_map(|&a| x.iter().map(move |&k| bandwidth(k, a))).collect();
    let contours = Chart::new(
        "Controlled bandwidth",
        Axis::new("Stiffness", "N/m").log(),
        Axis::new("Force amplitude", "N"),
    )
    .contours(Contours {
        x,
        y,
        values,
        levels: [2.0, 3.0, 5.0, 8.0, 12.0, 20.0].map(|l| (l, format!("{l} Hz"))).into(),
        label: "bandwidth".into(),
        hue: Hue::Blue,
        ..Contours::default()
    })
    .note((372e3, 700.0), "THOR compliant", Marker::Circle, Hue::Vermillion)
    .note((655e3, 900.0), "THOR stiff", Marker::Square, Hue::Vermillion)
    .note((145e3, 1800.0), "SAFFiR", Marker::Triangle, Hue::Green);
    report.figure(&contours, "Contours with marked designs.");
}

fn tables(report: &mut Report) {
    report.section("Ranking");
    let mut table = Table::new()
        .words("Effect")
        .numbers("Holdout error", "noise units")
        .numbers("Evidence", "ΔBIC")
        .words("Remark");
    table
        .strong_row(["backlash", "1.03", "0", "accepted"])
        .row(["series-compliance", "3.91", "812", "leaves the corners of the force"])
        .row(["coulomb-friction", "5.20", "1204", "at its lower bound"]);
    report.table(&table, "Effects that were tried, best first.");
    report.verdict(
        Tone::Caution,
        "Backlash and a dead band of the load cell cannot be told apart in run 2.",
        "",
    );
}

fn comparison() -> Comparison {
    let values = |points: Vec<(f64, f64)>| points.into_iter().map(|p| p.1).collect::<Vec<f64>>();
    let run = |name: &str| ComparedRun {
        name: name.into(),
        time_s: (0..20_000).map(|i| f64::from(i) * 1e-3).collect(),
        channels: ["force_1_n", "force_2_n"]
            .map(|name| ComparedChannel {
                name: name.into(),
                unit: "N".into(),
                measured: values(curve(1.0, true)),
                before: Some(values(curve(0.9, false))),
                after: Some(values(curve(1.0, false))),
                noise: 1.0,
            })
            .into(),
    };
    Comparison {
        name: "gallery".into(),
        runs: vec![run("run-01 (fit)"), run("run-03 (holdout)")],
        summary_markdown: "# Backlash of 0.12 mm\n\nError on the holdout run: 8.4 → 1.03 noise units.\n"
            .into(),
    }
}
