//! The moving output by closed form, and what would have to differ for the printed peaks to come out.

use anyhow::Context;
use sealegs::actuator::Coefficients;
use sealegs::actuator::bench::PendulumRig;
use sealegs::actuator::response::{Feature, ForceResponse, Link, dips, peaks};
use serde::Serialize;

use super::ledger::Ledger;
use super::thor::{STIFF_N_M, Thor, pendulum_link};

/// The closed-form peak of F1/Fm above 3 Hz with a moving link at the screw side.
///
/// # Errors
///
/// If there is none.
pub fn peak(c: &Coefficients, link: Link) -> anyhow::Result<Feature> {
    let response = ForceResponse::between(c, Link::Fixed, link);
    peaks(|f| response.force_1().at_hz(f), [3.0, 100.0]).first().copied().context("F1/Fm has no peak")
}

/// Enters the closed-form rows of section 3-4-5.
///
/// # Errors
///
/// If a response has no peak.
pub fn enter(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    let rig = PendulumRig::default();
    let link = pendulum_link(&rig);
    let (unlumped, lumped) = (thor.smh(STIFF_N_M), thor.lumped(STIFF_N_M));
    let (high, low) = (peak(&unlumped, link)?, peak(&lumped, link)?);
    let pole = |c: &Coefficients| {
        let modes = ForceResponse::between(c, Link::Fixed, link).sprung.resonances();
        modes
            .iter()
            .find(|m| m.frequency_hz > 3.0)
            .map(|m| format!("pole at {:.2} Hz, damping ratio {:.4}", m.frequency_hz, m.damping_ratio))
            .unwrap_or_default()
    };
    ledger.put(
        "R3-11",
        high.frequency_hz,
        format!("follows from the stated parameters ({}); 15.76 does not: see the findings", pole(&unlumped)),
    );
    ledger.put(
        "R3-12",
        low.frequency_hz,
        format!("follows from the stated parameters ({}); 6.35 does not: see the findings", pole(&lumped)),
    );
    ledger.put(
        "R3-13",
        high.frequency_hz / low.frequency_hz,
        "the ratio is as published: both prints are low by the same share",
    );
    ledger.put("S3-24", high.gain_db, "closed form");
    ledger.put("S3-25", low.gain_db, "closed form");
    let response = ForceResponse::between(&unlumped, Link::Fixed, link);
    let dip = dips(|f| response.force_1().at_hz(f), [0.3, 3.0]).first().copied().context("no dip")?;
    ledger.put("R3-14", dip.frequency_hz, "sqrt(g/L)/2 pi with L = 0.300 m");
    let Link::Mass { mass_kg, stiffness_n_m } = link else { anyhow::bail!("a pendulum is a mass") };
    ledger.put("R3-15", mass_kg, "m (L/a)^2");
    ledger.put("R3-16", stiffness_n_m, "m g L/a^2");
    for (id, c) in [("S3-26", &unlumped), ("S3-27", &lumped)] {
        let moved = ForceResponse::between(c, link, Link::Fixed);
        let at = peaks(|f| moved.force_1().at_hz(f), [3.0, 100.0]).first().copied().context("no peak")?;
        ledger.put(id, at.frequency_hz, "with the spring side moving both models are the same: the low lumped peak needs the screw side to move");
    }
    Ok(())
}

/// One thing changed so that the unlumped peak is as printed, and what the lumped peak then is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// What is changed.
    pub change: String,
    /// To what.
    pub value: String,
    /// Unlumped peak, Hz.
    pub unlumped_hz: f64,
    /// Lumped peak, Hz.
    pub lumped_hz: f64,
    /// Pendulum dip, Hz.
    pub dip_hz: f64,
    /// Root mean square of the two peaks' relative errors against the print.
    pub misfit: f64,
}

/// The printed peaks, unlumped and lumped, Hz.
pub const PRINTED_HZ: [f64; 2] = [15.76, 6.35];

/// The number sought as a person reads it.
type Shown<'a> = &'a dyn Fn(f64) -> String;

/// A model and a link that depend on one number.
type Change<'a> = &'a dyn Fn(f64) -> (f64, f64, f64);

/// Each single cause, chosen to fit both printed peaks as well as it can, the best first.
///
/// # Errors
///
/// If a response has no peak.
pub fn explanations(thor: &Thor) -> anyhow::Result<Vec<Explanation>> {
    let rig = PendulumRig::default();
    // Stiffness, effective mass and gravity stiffness as functions of the number sought.
    let base = pendulum_numbers(&rig);
    let series = |k_series: f64| (1.0 / (1.0 / STIFF_N_M + 1.0 / k_series), base.0, base.1);
    let rod = |kg: f64| {
        // A uniform rod of the link's length adds m L^2/3 of inertia and m g L/2 of gravity.
        let a2 = rig.arm_m * rig.arm_m;
        let gravity = kg * sealegs::actuator::plant::GRAVITY_M_S2 * rig.length_m / 2.0;
        (STIFF_N_M, base.0 + kg * rig.length_m.powi(2) / 3.0 / a2, base.1 + gravity / a2)
    };
    let centre = |m: f64| {
        let (mass, gravity) = pendulum_numbers(&PendulumRig { length_m: m, ..rig });
        (STIFF_N_M, mass, gravity)
    };
    let lever = |degrees: f64| {
        let arm_m = rig.arm_m * degrees.to_radians().cos();
        let (mass, gravity) = pendulum_numbers(&PendulumRig { arm_m, ..rig });
        (STIFF_N_M, mass, gravity)
    };
    let softer = |k: f64| (k, base.0, base.1);
    let as_stated = |_: f64| (STIFF_N_M, base.0, base.1);
    let list: [(&str, Change<'_>, f64, f64, Shown<'_>); 6] = [
        ("a stiffness in series with the spring", &series, 1e6, 40e6, &|v| {
            format!("{:.1} MN/m (leaves {:.0} kN/m)", 1e-6 * v, 1e-3 * series(v).0)
        }),
        ("a softer spring", &softer, 450e3, 655e3, &|v| format!("{:.0} kN/m", 1e-3 * v)),
        ("a uniform link of unstated mass", &rod, 0.0, 10.0, &|v| format!("{v:.2} kg")),
        ("the mass centre further out", &centre, 0.300, 0.400, &|v| format!("{v:.3} m")),
        ("the lever off perpendicular", &lever, 0.0, 40.0, &|v| format!("{v:.0} deg")),
        ("nothing: the stated parameters", &as_stated, 0.0, 1.0, &|_| "-".to_owned()),
    ];
    let mut found = Vec::new();
    for (change, law, from, to, show) in list {
        let misfit = |v: f64| explain(thor, law(v)).map_or(f64::INFINITY, |e| e.misfit);
        let best = minimum(&misfit, from, to);
        let e = explain(thor, law(best))?;
        found.push(Explanation { change: change.to_owned(), value: show(best), ..e });
    }
    found.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    Ok(found)
}

/// Effective mass (kg) and gravity stiffness (N/m) of a rig.
fn pendulum_numbers(rig: &PendulumRig) -> (f64, f64) {
    let link = rig.link();
    (link.mass_kg(), link.stiffness_n_m())
}

fn explain(thor: &Thor, (stiffness, mass_kg, gravity): (f64, f64, f64)) -> anyhow::Result<Explanation> {
    let link = Link::Mass { mass_kg, stiffness_n_m: gravity };
    let unlumped_hz = peak(&thor.smh(stiffness), link)?.frequency_hz;
    let lumped_hz = peak(&thor.lumped(stiffness), link)?.frequency_hz;
    let errors = [unlumped_hz / PRINTED_HZ[0] - 1.0, lumped_hz / PRINTED_HZ[1] - 1.0];
    Ok(Explanation {
        change: String::new(),
        value: String::new(),
        unlumped_hz,
        lumped_hz,
        dip_hz: (gravity / mass_kg).sqrt() / std::f64::consts::TAU,
        misfit: (0.5 * (errors[0].powi(2) + errors[1].powi(2))).sqrt(),
    })
}

/// The least value of a function with one minimum, by golden section.
fn minimum(f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..50 {
        let (left, right) = (high - ratio * (high - low), low + ratio * (high - low));
        if f(left) <= f(right) { high = right } else { low = left }
    }
    0.5 * (low + high)
}
