//! Features of frequency responses in closed form: resonances, peaks, dips, gains, limits.

use num_complex::Complex64;
use sealegs_actuator::Coefficients;
use sealegs_actuator::bench::PendulumRig;
use sealegs_actuator::response::{
    Feature, ForceResponse, HALF_POWER_DB, Link, Mode, SecondOrderFit, Transfer, crossings, db, dips,
    forces_differ_hz, peaks, plant, plant_bandwidth_hz, pure_force_source_hz,
    pure_force_source_min_stiffness,
};

use super::{Call, Function};
use crate::ReproduceError;
use crate::equations::{sbn_deviation, smh_deviation};
use crate::setup::Setup;
use crate::thor::{SOFT_N_M, STIFF_N_M, pendulum_link};

/// The pendulum swings below this frequency; the actuator's own resonances lie above it, Hz.
const SWINGS_BELOW_HZ: f64 = 3.0;

pub(super) const FUNCTIONS: [Function; 15] = [
    Function {
        name: "resonance_hz",
        usage: "RESPONSE [, links]: first pole above 3 Hz, undamped",
        law: resonance_hz,
    },
    Function {
        name: "damping_ratio",
        usage: "RESPONSE [, links]: of that pole, as a ratio",
        law: damping_ratio,
    },
    Function { name: "anti_resonance_hz", usage: "RESPONSE [, links]: first zero", law: anti_resonance_hz },
    Function {
        name: "peak_hz",
        usage: "RESPONSE, from and to in Hz [, links]: where it is greatest",
        law: peak_hz,
    },
    Function {
        name: "peak_db",
        usage: "RESPONSE, from and to in Hz [, links]: how great it is there",
        law: peak_db,
    },
    Function {
        name: "dip_hz",
        usage: "RESPONSE, from and to in Hz [, links]: where it is least",
        law: dip_hz,
    },
    Function {
        name: "half_power_hz",
        usage: "RESPONSE, from and to in Hz [, links]: first -3 dB",
        law: half_power_hz,
    },
    Function { name: "gain", usage: "RESPONSE, Hz [, links]: magnitude as a ratio", law: gain },
    Function { name: "gain_db", usage: "RESPONSE, Hz [, links]: magnitude in dB", law: gain_db },
    Function {
        name: "forces_differ_hz",
        usage: "model, stiffness, links: first 3 dB between both ends",
        law: differ_hz,
    },
    Function {
        name: "unsprung_link_change",
        usage: "greatest change of F_sprung/F_unsprung, as a ratio",
        law: change,
    },
    Function { name: "plant_bandwidth_hz", usage: "stiffness: -3 dB of eq 4-41", law: bandwidth_hz },
    Function {
        name: "pure_force_source_hz",
        usage: "model, stiffness: omega_max of eq 4-37",
        law: force_source_hz,
    },
    Function { name: "least_stiffness_n_m", usage: "sprung mass in kg, Hz: eq 4-38", law: least_stiffness },
    Function {
        name: "printed_equations_deviate",
        usage: "sbn or smh: printed equations of motion against the one formula, as a ratio",
        law: deviation,
    },
];

/// `soft`, `stiff` or N/m.
pub(super) fn stiffness(call: &Call<'_>, at: usize) -> Result<f64, ReproduceError> {
    match call.word(at)? {
        "soft" => Ok(SOFT_N_M),
        "stiff" => Ok(STIFF_N_M),
        _ => call.number(at),
    }
}

/// `smh`, `sbn` or `lumped`, with a stiffness in N/m.
fn model(setup: &Setup, call: &Call<'_>, at: usize, k: f64) -> Result<Coefficients, ReproduceError> {
    match call.word(at)? {
        "smh" => Ok(setup.thor.smh(k)),
        "sbn" => Ok(setup.thor.sbn(k)),
        "lumped" => Ok(setup.thor.lumped(k)),
        other => Err(call.unknown("model", other)),
    }
}

/// Both links from word `at` on; both held if there is none. `fixed`, `pendulum` or `free:KG`.
fn links(call: &Call<'_>, at: usize) -> Result<[Link; 2], ReproduceError> {
    let link = |at: usize| {
        let word = call.word(at)?;
        match (word, word.strip_prefix("free:").and_then(|kg| kg.parse().ok())) {
            ("fixed", _) => Ok(Link::Fixed),
            ("pendulum", _) => Ok(pendulum_link(&PendulumRig::default())),
            (_, Some(mass_kg)) => Ok(Link::free(mass_kg)),
            _ => Err(call.unknown("link", word)),
        }
    };
    if call.words.len() == at { Ok([Link::Fixed; 2]) } else { Ok([link(at)?, link(at + 1)?]) }
}

/// The response that the first three words name, with links behind `numbers` more words.
fn transfer(setup: &Setup, call: &Call<'_>, numbers: usize) -> Result<Transfer, ReproduceError> {
    let c = model(setup, call, 1, stiffness(call, 2)?)?;
    let [link_1, link_2] = links(call, 3 + numbers)?;
    let response = ForceResponse::between(&c, link_1, link_2);
    match call.word(0)? {
        "sprung" => Ok(response.sprung),
        "unsprung" => Ok(response.unsprung),
        "ratio" => Ok(response.ratio),
        "force_1" => Ok(response.force_1().clone()),
        "plant" => Ok(plant(&c)),
        other => Err(call.unknown("response", other)),
    }
}

fn resonance(setup: &Setup, call: &Call<'_>) -> Result<Mode, ReproduceError> {
    let modes = transfer(setup, call, 0)?.resonances();
    let found = modes.into_iter().find(|m| m.frequency_hz > SWINGS_BELOW_HZ);
    found.ok_or_else(|| ReproduceError::missing("no resonance"))
}

fn resonance_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(resonance(setup, call)?.frequency_hz)
}

fn damping_ratio(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(resonance(setup, call)?.damping_ratio)
}

fn anti_resonance_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let modes = transfer(setup, call, 0)?.anti_resonances();
    Ok(modes.first().ok_or_else(|| ReproduceError::missing("no anti-resonance"))?.frequency_hz)
}

fn range(call: &Call<'_>) -> Result<[f64; 2], ReproduceError> {
    Ok([call.number(3)?, call.number(4)?])
}

fn peak(setup: &Setup, call: &Call<'_>) -> Result<Feature, ReproduceError> {
    let response = transfer(setup, call, 2)?;
    first(peaks(|f| response.at_hz(f), range(call)?), "peak")
}

fn first(features: Vec<Feature>, what: &str) -> Result<Feature, ReproduceError> {
    features.first().copied().ok_or_else(|| ReproduceError::missing(format!("no {what}")))
}

fn peak_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(peak(setup, call)?.frequency_hz)
}

fn peak_db(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(peak(setup, call)?.gain_db)
}

fn dip_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let response = transfer(setup, call, 2)?;
    Ok(first(dips(|f| response.at_hz(f), range(call)?), "dip")?.frequency_hz)
}

fn half_power_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let response = transfer(setup, call, 2)?;
    let edges = crossings(|f| response.at_hz(f), HALF_POWER_DB, range(call)?);
    edges.first().copied().ok_or_else(|| ReproduceError::missing("no crossing of -3 dB"))
}

fn gain(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(transfer(setup, call, 1)?.at_hz(call.number(3)?).norm())
}

fn gain_db(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(db(transfer(setup, call, 1)?.at_hz(call.number(3)?)))
}

fn differ_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let c = model(setup, call, 0, stiffness(call, 1)?)?;
    let [link_1, link_2] = links(call, 2)?;
    forces_differ_hz(&ForceResponse::between(&c, link_1, link_2), [1.0, 1000.0])
        .ok_or_else(|| ReproduceError::missing("the forces never differ by 3 dB"))
}

/// Between held links and a moving link on the unsprung side, over 0.1 to 500 Hz and three such links.
fn change(setup: &Setup, _: &Call<'_>) -> Result<f64, ReproduceError> {
    let c = setup.thor.smh(STIFF_N_M);
    let locked = ForceResponse::locked(&c);
    let grid: Vec<f64> = (0..400).map(|i| 0.1 * 5000f64.powf(f64::from(i) / 399.0)).collect();
    let on = |link| {
        let moved = ForceResponse::new(&c, Link::Fixed, link);
        grid.iter().map(|f| (moved.ratio.at_hz(*f) / locked.ratio.at_hz(*f) - 1.0).norm()).fold(0.0, f64::max)
    };
    let links = [Link::free(0.5), Link::free(68.5), Link::Mass { mass_kg: 68.5, stiffness_n_m: 2240.0 }];
    Ok(links.map(on).into_iter().fold(0.0, f64::max))
}

fn bandwidth_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(plant_bandwidth_hz(&setup.thor.smh(stiffness(call, 0)?)))
}

fn force_source_hz(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let k = stiffness(call, 1)?;
    Ok(pure_force_source_hz(k, model(setup, call, 0, k)?.sprung_mass))
}

fn least_stiffness(_: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(pure_force_source_min_stiffness(call.number(0)?, call.number(1)?))
}

fn deviation(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    match call.word(0)? {
        "sbn" => Ok(sbn_deviation(&setup.thor.sbn(STIFF_N_M))),
        "smh" => Ok(smh_deviation(&setup.thor.smh(STIFF_N_M))),
        other => Err(call.unknown("model", other)),
    }
}

/// Where the printed fit is greatest (Hz), or how great it is there (dB).
pub(super) fn peak_of_fit(fit: &SecondOrderFit, frequency: bool) -> Result<f64, ReproduceError> {
    let response = |f: f64| {
        let s = Complex64::new(0.0, std::f64::consts::TAU * f);
        fit.numerator_1_s2 / (s * s + fit.damping_1_s * s + fit.constant_1_s2)
    };
    let peak = first(peaks(response, [0.05, 1000.0]), "peak of the fit")?;
    Ok(if frequency { peak.frequency_hz } else { peak.gain_db })
}
