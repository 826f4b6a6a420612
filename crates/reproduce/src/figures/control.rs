//! Figures of the pure-force-source criterion and of the clipped ideal compensator.

use sealegs_actuator::compensator::ClippedCompensator;
use sealegs_actuator::response::{CompensatorBound, HALF_POWER_DB, db, plant, pure_force_source_hz};
use sealegs_recorder::chart::{Axis, Chart, Contours, Dash, Hue, Marker};

use super::{Figure, linear, logarithmic};
use crate::thor::{AMPLITUDE_N, CURRENT_LIMIT_A, SBN_MASS_KG, SOFT_N_M, STIFF_N_M, Thor};
use sealegs_actuator::Coefficients;

/// Current limits of figure 4-16, A (2.5 and 40 are printed, doublings between them assumed).
pub const CURRENTS_A: [f64; 5] = [2.5, 5.0, 10.0, 20.0, 40.0];
/// Amplitudes of figure 4-17, N (50 and 800 are printed, doublings between them assumed).
pub const AMPLITUDES_N: [f64; 5] = [50.0, 100.0, 200.0, 400.0, 800.0];

/// Gain in dB of the clipped compensator on a logarithmic grid.
#[must_use]
pub fn curve(c: &Coefficients, current_a: f64, amplitude_n: f64, grid_hz: &[f64]) -> Vec<f64> {
    let clipped = ClippedCompensator::new(c, current_a);
    grid_hz.iter().map(|f| clipped.steady_state(amplitude_n, *f).gain_rms_db).collect()
}

const DASHES: [Dash; 5] = [Dash::Dotted, Dash::DashDot, Dash::Dashed, Dash::Solid, Dash::Dashed];

/// Contours of omega_max over sprung mass and stiffness with the four designs.
pub fn figure_4_11(thor: &Thor) -> Figure {
    let (x, y) = (linear(0.05, 1.0, 96), linear(100.0, 1000.0, 91));
    let hz = |k: f64, m: f64| pure_force_source_hz(1e3 * k, m);
    let values = y.iter().flat_map(|&k| x.iter().map(move |&m| hz(k, m))).collect();
    let levels =
        [40.0, 60.0, 80.0, 100.0, 120.0, 150.0, 200.0, 250.0].map(|hz| (hz, format!("{hz:.0} Hz"))).to_vec();
    let mut chart = Chart::new(
        "Greatest bandwidth of a pure force source",
        Axis::new("Sprung mass", "kg").range(0.05, 1.0),
        Axis::new("Stiffness", "kN/m").range(100.0, 1000.0),
    )
    .contours(Contours {
        x,
        y,
        values,
        levels,
        hue: Hue::Blue,
        dash: Dash::Solid,
        label: "omega_max".into(),
    });
    let smh = thor.spec.sprung_mass_kg;
    for (name, k, m, marker) in [
        ("stiff SMH", STIFF_N_M, smh, Marker::Circle),
        ("soft SMH", SOFT_N_M, smh, Marker::Square),
        ("stiff SBN", STIFF_N_M, SBN_MASS_KG, Marker::Triangle),
        ("soft SBN", SOFT_N_M, SBN_MASS_KG, Marker::Diamond),
    ] {
        let text = format!("{name}: {:.1}", pure_force_source_hz(k, m));
        chart = chart.note((m, 1e-3 * k), &text, marker, Hue::Vermillion);
    }
    Figure {
        number: "4-11",
        title: "Stiffness, sprung mass and the bandwidth up to which the actuator is a pure force source",
        caption: "Eq 4-37. The markers are THOR's settings and what a sprung ball nut of 0.15 kg (an estimate of the text) would make of them; Table 8 prints these four numbers in the wrong columns.".to_owned(),
        charts: vec![chart.tall(460.0)],
    }
}

/// Plant, clipped compensator and controlled response.
pub fn figure_4_14(thor: &Thor) -> Figure {
    let grid = logarithmic(1.0, 100.0, 240);
    let mut charts = Vec::new();
    let mut edges = Vec::new();
    for (name, k) in [("stiff", STIFF_N_M), ("soft", SOFT_N_M)] {
        let c = thor.smh(k);
        let clipped = ClippedCompensator::new(&c, CURRENT_LIMIT_A);
        let p = plant(&c);
        let demand = |f: f64| {
            let period = clipped.period(AMPLITUDE_N, f, 64);
            let rms =
                (period.iter().map(|i| i.motor_force_n.powi(2)).sum::<f64>() / period.len() as f64).sqrt();
            20.0 * (rms * std::f64::consts::SQRT_2 / AMPLITUDE_N).log10()
        };
        let bound = CompensatorBound::new(&c, CURRENT_LIMIT_A, AMPLITUDE_N);
        let edge = clipped.bandwidth_hz(AMPLITUDE_N).unwrap_or(f64::NAN);
        edges.push(format!("{name} {edge:.1} Hz simulated, {:.1} Hz by the bound", bound.bandwidth_hz));
        charts.push(
            Chart::new(
                &format!("{name} setting, {:.0} kN/m", 1e-3 * k),
                Axis::new("Frequency", "Hz").log().range(1.0, 100.0),
                Axis::new("Magnitude", "dB"),
            )
            .line("plant", Hue::Ink, Dash::Dashed, grid.iter().map(|f| (*f, db(p.at_hz(*f)))).collect())
            .line(
                "clipped compensator (RMS)",
                Hue::Vermillion,
                Dash::DashDot,
                grid.iter().map(|f| (*f, demand(*f))).collect(),
            )
            .line(
                "controlled",
                Hue::Blue,
                Dash::Solid,
                grid.iter().copied().zip(curve(&c, CURRENT_LIMIT_A, AMPLITUDE_N, &grid)).collect(),
            )
            .horizontal(bound.max_gain_db, "G_max")
            .vertical(bound.bandwidth_hz, "bound of eq 4-52")
            .note(
                (edge, HALF_POWER_DB),
                &format!("−3 dB at {edge:.1} Hz"),
                Marker::Circle,
                Hue::Blue,
            ),
        );
    }
    Figure {
        number: "4-14",
        title: "Controlled response of the ideal compensator at 200 N and 10 A",
        caption: format!(
            "Exact periodic steady state with clipping. -3 dB: {}. The text does not say which setting its figure shows.",
            edges.join("; ")
        ),
        charts,
    }
}

/// One family of controlled responses.
fn family(thor: &Thor, title: &str, members: &[(String, f64, f64)]) -> Vec<Chart> {
    let grid = logarithmic(3.0, 200.0, 200);
    [("stiff", STIFF_N_M), ("soft", SOFT_N_M)]
        .into_iter()
        .map(|(name, k)| {
            let c = thor.smh(k);
            let mut chart = Chart::new(
                &format!("{title}, {name} setting"),
                Axis::new("Frequency", "Hz").log().range(3.0, 200.0),
                Axis::new("Controlled response", "dB").range(-30.0, 3.0),
            )
            .horizontal(HALF_POWER_DB, "−3 dB");
            for (i, (label, current, amplitude)) in members.iter().enumerate() {
                let edge = ClippedCompensator::new(&c, *current).bandwidth_hz(*amplitude).unwrap_or(f64::NAN);
                let points = grid.iter().copied().zip(curve(&c, *current, *amplitude, &grid)).collect();
                chart = chart.line(&format!("{label}: {edge:.1} Hz"), Hue::SERIES[i], DASHES[i], points);
            }
            chart
        })
        .collect()
}

/// The current limit varied.
pub fn figure_4_16(thor: &Thor) -> Figure {
    let members = CURRENTS_A.map(|i| (format!("{i} A"), i, AMPLITUDE_N));
    Figure {
        number: "4-16",
        title: "Controlled response at 200 N for current limits of 2.5 to 40 A",
        caption: "The legend has each curve's -3 dB frequency. 2.5 and 40 A are printed; the doublings between them are assumed.".to_owned(),
        charts: family(thor, "200 N", &members),
    }
}

/// The amplitude varied.
pub fn figure_4_17(thor: &Thor) -> Figure {
    let members = AMPLITUDES_N.map(|a| (format!("{a} N"), CURRENT_LIMIT_A, a));
    Figure {
        number: "4-17",
        title: "Controlled response at 10 A for amplitudes of 50 to 800 N",
        caption: "Exactly the curves of figure 4-16: only the ratio of limit and amplitude enters. 50 and 800 N are printed; the doublings between them are assumed.".to_owned(),
        charts: family(thor, "10 A", &members),
    }
}
