//! What would have to differ in the moving output for the printed peaks to come out.

use sealegs_actuator::Coefficients;
use sealegs_actuator::bench::PendulumRig;
use sealegs_actuator::response::{Feature, ForceResponse, Link, peaks};
use serde::Serialize;

use crate::ReproduceError;
use crate::thor::{STIFF_N_M, Thor};

/// The closed-form peak of F1/Fm above 3 Hz with a moving link at the screw side.
///
/// # Errors
///
/// If there is none.
pub fn peak(c: &Coefficients, link: Link) -> Result<Feature, ReproduceError> {
    let response = ForceResponse::between(c, Link::Fixed, link);
    peaks(|f| response.force_1().at_hz(f), [3.0, 100.0])
        .first()
        .copied()
        .ok_or_else(|| ReproduceError::missing("F1/Fm has no peak"))
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
pub fn explanations(thor: &Thor) -> Result<Vec<Explanation>, ReproduceError> {
    let rig = PendulumRig::default();
    // Stiffness, effective mass and gravity stiffness as functions of the number sought.
    let base = pendulum_numbers(&rig);
    let series = |k_series: f64| (1.0 / (1.0 / STIFF_N_M + 1.0 / k_series), base.0, base.1);
    let rod = |kg: f64| {
        // A uniform rod of the link's length adds m L^2/3 of inertia and m g L/2 of gravity.
        let a2 = rig.arm_m * rig.arm_m;
        let gravity = kg * sealegs_actuator::plant::GRAVITY_M_S2 * rig.length_m / 2.0;
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

fn explain(
    thor: &Thor,
    (stiffness, mass_kg, gravity): (f64, f64, f64),
) -> Result<Explanation, ReproduceError> {
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
