//! Figures of frequency responses: the locked bench, the pendulum, both spring locations, moving links.

use sealegs_actuator::bench::PendulumRig;
use sealegs_actuator::response::{ForceResponse, Link, Transfer, db};
use sealegs_actuator::{Coefficients, Configuration};
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker};
use sealegs_sysid::frf::FrequencyResponse;

use super::{Figure, logarithmic};
use crate::Reproduction;
use crate::thor::{STIFF_N_M, Thor, pendulum_link};

const LOW_HZ: f64 = 0.1;

fn magnitude(title: &str, high_hz: f64) -> Chart {
    Chart::new(title, Axis::new("Frequency", "Hz").log().range(LOW_HZ, high_hz), Axis::new("Magnitude", "dB"))
}

fn phase(title: &str, high_hz: f64) -> Chart {
    Chart::new(title, Axis::new("Frequency", "Hz").log().range(LOW_HZ, high_hz), Axis::new("Phase", "deg"))
}

fn gain_of(transfer: &Transfer, grid: &[f64]) -> Vec<(f64, f64)> {
    grid.iter().map(|f| (*f, db(transfer.at_hz(*f)))).collect()
}

fn phase_of(transfer: &Transfer, grid: &[f64]) -> Vec<(f64, f64)> {
    let values = grid.iter().map(|f| transfer.at_hz(*f)).collect();
    let response = FrequencyResponse::exact(grid.to_vec(), values);
    let degrees = response.phase_rad();
    grid.iter().zip(degrees).map(|(f, p)| (*f, p.to_degrees())).collect()
}

/// Some lines of an estimate, evenly spread over a logarithmic axis, where its coherence allows it.
fn thinned(r: &FrequencyResponse, low_hz: f64, high_hz: f64, n: usize) -> Vec<usize> {
    let mut kept = Vec::new();
    for f in logarithmic(low_hz, high_hz, n) {
        let i = r.frequency_hz.partition_point(|v| *v < f).min(r.frequency_hz.len() - 1);
        if kept.last() != Some(&i) && r.coherence[i] > 0.5 && r.frequency_hz[i] <= high_hz {
            kept.push(i);
        }
    }
    kept
}

fn estimate_gain(r: &FrequencyResponse, lines: &[usize]) -> Vec<(f64, f64)> {
    let db = r.magnitude_db();
    lines.iter().map(|&i| (r.frequency_hz[i], db[i])).collect()
}

fn estimate_phase(r: &FrequencyResponse, lines: &[usize]) -> Vec<(f64, f64)> {
    // Into -270 to 90 degrees: noise about -180 must not jump to the other end.
    let wrapped = |p: f64| if p > 90.0 { p - 360.0 } else { p };
    lines.iter().map(|&i| (r.frequency_hz[i], wrapped(r.value[i].arg().to_degrees()))).collect()
}

/// A curve over a frequency grid (Hz) from a transfer function.
type CurveOf = fn(&Transfer, &[f64]) -> Vec<(f64, f64)>;

/// The locked bench by both models, with the rehearsed identification.
pub fn figure_3_7(r: &Reproduction, thor: &Thor) -> Figure {
    let grid = logarithmic(LOW_HZ, 200.0, 600);
    let unlumped = ForceResponse::locked(&thor.smh(STIFF_N_M));
    let lumped = ForceResponse::locked(&thor.lumped(STIFF_N_M));
    let pair = |chart: Chart, pick: &dyn Fn(&ForceResponse) -> Transfer, of: CurveOf| {
        chart.line("unlumped", Hue::Blue, Dash::Solid, of(&pick(&unlumped), &grid)).line(
            "lumped",
            Hue::Vermillion,
            Dash::Dashed,
            of(&pick(&lumped), &grid),
        )
    };
    let force_1 = |f: &ForceResponse| f.force_1().clone();
    let force_2 = |f: &ForceResponse| f.force_2().clone();
    let ratio = |f: &ForceResponse| f.ratio.clone();
    let h = &r.rehearsals;
    let lines_1 = thinned(&h.locked, 0.1, 150.0, 90);
    let lines_2 = thinned(&h.locked_force_2, 0.1, 150.0, 90);
    let rehearsed = "rehearsal: simulated at 400 Hz, H1";
    let charts = vec![
        pair(magnitude("(a) F1/Fm", 200.0), &force_1, gain_of).scatter(
            rehearsed,
            Hue::Ink,
            Marker::Dot,
            estimate_gain(&h.locked, &lines_1),
        ),
        pair(phase("(a) F1/Fm", 200.0), &force_1, phase_of).scatter(
            rehearsed,
            Hue::Ink,
            Marker::Dot,
            estimate_phase(&h.locked, &lines_1),
        ),
        pair(magnitude("(b) F2/Fm", 200.0), &force_2, gain_of).scatter(
            rehearsed,
            Hue::Ink,
            Marker::Dot,
            estimate_gain(&h.locked_force_2, &lines_2),
        ),
        pair(magnitude("(c) F1/F2", 200.0), &ratio, gain_of)
            .vertical(7.47, "printed 7.47 Hz")
            .vertical(160.0, "printed 160 Hz"),
    ];
    Figure {
        number: "3-7",
        title: "Force responses of the locked bench by both models",
        caption: format!(
            "F1/Fm is the same in both models: natural frequency {:.2} Hz, peak {:+.2} dB. F2/Fm and F1/F2 differ: the lumped model resonates at {:.2} Hz, the unlumped one at {:.1} Hz. The resonance measured at 70 to 80 Hz is in neither model.",
            r.ours("S3-04").unwrap_or(f64::NAN),
            r.ours("S3-02").unwrap_or(f64::NAN),
            r.ours("R3-01").unwrap_or(f64::NAN),
            r.ours("R3-02").unwrap_or(f64::NAN)
        ),
        charts,
    }
}

/// The pendulum by both models, formula and simulation.
pub fn figure_3_9(r: &Reproduction, thor: &Thor) -> Figure {
    let grid = logarithmic(LOW_HZ, 100.0, 900);
    let link = pendulum_link(&PendulumRig::default());
    let formula = |c: &Coefficients| ForceResponse::between(c, Link::Fixed, link).force_1().clone();
    let (unlumped, lumped) = (formula(&thor.smh(STIFF_N_M)), formula(&thor.lumped(STIFF_N_M)));
    let h = &r.rehearsals;
    let points = |r: &FrequencyResponse| estimate_gain(r, &thinned(r, 0.1, 100.0, 70));
    let band = {
        let bounds = h.moving.unlumped.bounds_db(1.96);
        thinned(&h.moving.unlumped, 0.1, 100.0, 130)
            .into_iter()
            .map(|i| (h.moving.unlumped.frequency_hz[i], bounds[i].0, bounds[i].1))
            .collect()
    };
    let chart = magnitude("F1/Fm with a moving output", 100.0)
        .band("95 % of the unlumped estimate", Hue::Blue, band)
        .line("unlumped, formula", Hue::Blue, Dash::Solid, gain_of(&unlumped, &grid))
        .line("lumped, formula", Hue::Vermillion, Dash::Dashed, gain_of(&lumped, &grid))
        .scatter("unlumped, simulated and H1", Hue::Blue, Marker::Circle, points(&h.moving.unlumped))
        .scatter("lumped, simulated and H1", Hue::Vermillion, Marker::Triangle, points(&h.moving.lumped))
        .vertical(15.76, "printed 15.76")
        .vertical(6.35, "6.35")
        .vertical(1.0, "dip 1");
    let phases = phase("F1/Fm with a moving output", 100.0)
        .line("unlumped", Hue::Blue, Dash::Solid, phase_of(&unlumped, &grid))
        .line("lumped", Hue::Vermillion, Dash::Dashed, phase_of(&lumped, &grid));
    Figure {
        number: "3-9",
        title: "Force response with a moving output: 4 kg pendulum on the screw side",
        caption: format!(
            "Peaks by formula {:.2} and {:.2} Hz, by nonlinear simulation and H1 {:.2} and {:.2} Hz; printed 15.76 and 6.35 Hz, a miss of {:+.1} and {:+.1} %. The dip is at {:.2} Hz.",
            r.ours("R3-11").unwrap_or(f64::NAN),
            r.ours("R3-12").unwrap_or(f64::NAN),
            r.ours("S3-20").unwrap_or(f64::NAN),
            r.ours("S3-21").unwrap_or(f64::NAN),
            100.0 * (r.ours("R3-11").unwrap_or(f64::NAN) / 15.76 - 1.0),
            100.0 * (r.ours("R3-12").unwrap_or(f64::NAN) / 6.35 - 1.0),
            r.ours("R3-14").unwrap_or(f64::NAN)
        ),
        charts: vec![chart.tall(420.0), phases],
    }
}

/// Both spring locations between held links, with the same sprung mass as the text takes.
pub fn figure_4_10(thor: &Thor) -> Figure {
    let grid = logarithmic(LOW_HZ, 300.0, 800);
    let smh = thor.smh(STIFF_N_M);
    let sbn = Coefficients { configuration: Configuration::SprungBallNut, ..smh };
    let (a, b) = (ForceResponse::locked(&sbn), ForceResponse::locked(&smh));
    let pair = |title: &str, of: &dyn Fn(&ForceResponse) -> Transfer| {
        magnitude(title, 300.0).line("SBN", Hue::Vermillion, Dash::Dashed, gain_of(&of(&a), &grid)).line(
            "SMH",
            Hue::Blue,
            Dash::Solid,
            gain_of(&of(&b), &grid),
        )
    };
    Figure {
        number: "4-10",
        title: "Locked bench for both spring locations",
        caption: "With the same sprung mass the two locations only exchange F1 and F2; F_sprung/F_unsprung is one curve. Resonance of F_sprung/F_unsprung at 160 Hz; first 3 dB of difference at 86.6 Hz.".to_owned(),
        charts: vec![
            pair("F1/Fm", &|f| f.force_1().clone()),
            pair("F2/Fm", &|f| f.force_2().clone()),
            pair("F_sprung/F_unsprung", &|f| f.ratio.clone()).vertical(86.6, "printed 86.6").horizontal(3.0, "+3 dB"),
        ],
    }
}

/// Moving links: which of them, and a light one.
pub fn figure_4_12(thor: &Thor) -> Figure {
    let grid = logarithmic(LOW_HZ, 300.0, 800);
    let c = thor.smh(STIFF_N_M);
    let free = Link::free(68.5);
    let cases = [
        ("unsprung link moves", Link::Fixed, free, Hue::Blue, Dash::Solid),
        ("sprung link moves", free, Link::Fixed, Hue::Vermillion, Dash::Dashed),
        ("both move", free, free, Hue::Green, Dash::DashDot),
    ];
    let charts = [("F_sprung/Fm", 0), ("F_unsprung/Fm", 1), ("F_sprung/F_unsprung", 2)]
        .into_iter()
        .map(|(title, which)| {
            let pick = |f: ForceResponse| match which {
                0 => f.sprung,
                1 => f.unsprung,
                _ => f.ratio,
            };
            let mut chart = magnitude(title, 300.0);
            for (name, sprung, unsprung, hue, dash) in cases {
                chart = chart.line(
                    name,
                    hue,
                    dash,
                    gain_of(&pick(ForceResponse::new(&c, sprung, unsprung)), &grid),
                );
            }
            if which == 2 {
                let light = ForceResponse::new(&c, Link::free(5.0), Link::Fixed);
                chart = chart.line(
                    "sprung link of 5 kg moves",
                    Hue::Purple,
                    Dash::Dotted,
                    gain_of(&light.ratio, &grid),
                );
            }
            chart
        })
        .collect();
    Figure {
        number: "4-12",
        title: "Moving links of 68.5 kg (the text does not state its masses)",
        caption: "F_sprung/F_unsprung does not change when the unsprung link moves, which is exact, and hardly when a heavy sprung link moves. A light one changes it: with 5 kg by -1.06 dB at low frequency and 170 Hz instead of 160 Hz.".to_owned(),
        charts,
    }
}
