//! Chapter 4: constants, the pure-force-source criterion, spring locations, moving links and Table 8.

use std::f64::consts::TAU;

use anyhow::Context;
use sealegs::actuator::bench::{Bench, BenchModel};
use sealegs::actuator::response::{
    CompensatorBound, ForceResponse, Link, Transfer, db, forces_differ_hz, peaks, plant, plant_bandwidth_hz,
    pure_force_source_hz, pure_force_source_min_stiffness,
};
use sealegs::actuator::{Coefficients, Configuration};
use sealegs::model::{InputHold, Model, Record, Signal};

use super::equations::{sbn_deviation, smh_deviation};
use super::ledger::Ledger;
use super::thor::{SBN_MASS_KG, SOFT_N_M, STIFF_N_M, Thor};

/// The working point of section 4-7: current limit in A and force amplitude in N.
pub const CURRENT_LIMIT_A: f64 = 10.0;
/// See [`CURRENT_LIMIT_A`].
pub const AMPLITUDE_N: f64 = 200.0;

/// Enters chapter 4 but for the clipped compensator.
///
/// # Errors
///
/// If a printed value is missing or a response lacks a feature.
pub fn enter(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    ledger.put(
        "E4-02",
        sbn_deviation(&thor.sbn(STIFF_N_M)),
        "F_k and F_bs of the printed set between moving links against the one formula, relative",
    );
    ledger.put("E4-13", smh_deviation(&thor.smh(STIFF_N_M)), "consistent with x_p counted towards link 1 and F_k = k (x_1 + x_p), which is not printed in general form");
    criterion(ledger, thor)?;
    spring_location(ledger, thor)?;
    moving_links(ledger, thor)?;
    table_8(ledger, thor)
}

fn criterion(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    let three_db = 10f64.powf(3.0 / 20.0);
    ledger.put("E4-35", three_db, "10^(3/20)");
    let share = TAU * TAU / pure_force_source_min_stiffness(1.0, 1.0);
    ledger.put("E4-37", share, "1 - 10^(-3/20), as the product's criterion has it");
    let m_s = thor.spec.sprung_mass_kg;
    let (stiff, soft) = (pure_force_source_hz(STIFF_N_M, m_s), pure_force_source_hz(SOFT_N_M, m_s));
    ledger.put("R4-wmax-stiff-SMH", stiff, "eq 4-37 with 0.6461 kg");
    ledger.put("R4-wmax-soft-SMH", soft, "eq 4-37 with 0.6461 kg");
    let printed = ledger.printed("R4-wmax-stiff-SMH")?;
    ledger.put(
        "E4-32",
        m_s * (stiff / printed).powi(2),
        "eq 4-37 solved for the mass at the printed 86.6 Hz: the sprung mass, not the 294.9 kg of Table 6",
    );
    let constant = pure_force_source_min_stiffness(1.0, 1.0);
    ledger.put(
        "E4-38",
        constant,
        format!("4 pi^2/0.29205; {:.2} is 4 pi^2/(1 - 1/1.414)", TAU * TAU / (1.0 - 1.0 / 1.414)),
    );
    let c = thor.smh(STIFF_N_M);
    ledger.put("E4-48", c.force_constant, "K_tau/r");
    let bound = CompensatorBound::new(&c, CURRENT_LIMIT_A, AMPLITUDE_N);
    ledger.put(
        "E4-50",
        bound.max_gain_db,
        format!(
            "root mean square of a square wave; its fundamental, which makes the force, is {:.2} dB",
            bound.max_gain_fundamental_db
        ),
    );
    ledger.put("E4-52", bound.increase_decades, "G_max/40 dB, exact r");
    Ok(())
}

fn first_mode_hz(transfer: &Transfer) -> f64 {
    transfer.resonances().first().map_or(f64::NAN, |m| m.frequency_hz)
}

fn spring_location(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    for (id, k, setting) in [("S4-01", STIFF_N_M, "stiff"), ("S4-02", SOFT_N_M, "soft")] {
        let (sbn, smh) = (plant(&thor.sbn(k)), plant(&thor.smh(k)));
        ledger.put(
            id,
            first_mode_hz(&sbn),
            format!("SMH, {setting}: {:.3} Hz; the spring's place does not matter here", first_mode_hz(&smh)),
        );
    }
    for (id, c) in
        [("S4-03", thor.sbn(STIFF_N_M)), ("S4-04", thor.sbn(SOFT_N_M)), ("S4-05", thor.smh(SOFT_N_M))]
    {
        let ratio = ForceResponse::locked(&c).ratio;
        ledger.put(id, first_mode_hz(&ratio), format!("sqrt(k/m_s)/2 pi with {} kg", c.sprung_mass));
    }
    Ok(())
}

/// `F_sprung/F_unsprung` with a free sprung link of this mass, kg.
#[must_use]
pub fn sprung_link_free(c: &Coefficients, mass_kg: f64) -> ForceResponse {
    ForceResponse::new(c, Link::free(mass_kg), Link::Fixed)
}

fn moving_links(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    let c = thor.smh(STIFF_N_M);
    let locked = ForceResponse::locked(&c);
    let grid: Vec<f64> = (0..400).map(|i| 0.1 * 5000f64.powf(f64::from(i) / 399.0)).collect();
    let change = |link| {
        let moved = ForceResponse::new(&c, Link::Fixed, link);
        grid.iter().map(|f| (moved.ratio.at_hz(*f) / locked.ratio.at_hz(*f) - 1.0).norm()).fold(0.0, f64::max)
    };
    let unsprung = [Link::free(0.5), Link::free(68.5), Link::Mass { mass_kg: 68.5, stiffness_n_m: 2240.0 }]
        .map(change)
        .into_iter()
        .fold(0.0, f64::max);
    ledger.put("R4-01", unsprung, "the unsprung side's impedance does not appear in 1/[1 + m_s s^2 (1/k + 1/D_s)]: proved, and largest relative change computed");
    let low = |m: f64| db(sprung_link_free(&c, m).ratio.at_hz(1e-3));
    let resonance = |m: f64| first_mode_hz(&sprung_link_free(&c, m).ratio);
    let crossing = |m: f64| {
        forces_differ_hz(&sprung_link_free(&c, m), [1.0, 1000.0]).context("the forces never differ by 3 dB")
    };
    ledger.put(
        "R4-02",
        low(68.5),
        format!("1/(1 + m_s/m); resonance {:.1} Hz: invisible on a plot", resonance(68.5)),
    );
    ledger.put("R4-03", low(5.0), format!(
        "1/(1 + m_s/m): m_s has an absolute acceleration, so the sprung link's impedance enters; 20 kg {:+.2} dB, 1 kg {:+.1} dB", low(20.0), low(1.0)
    ));
    ledger.put("S4-10", resonance(5.0), "times sqrt(1 + m_s/m); the text says it does not move");
    ledger.put("S4-11", crossing(5.0)?, "the limit of the pure force source moves with it");
    ledger.put("S4-12", crossing(68.5)?, "the link of the bench: hardly moves");
    ledger.put(
        "S4-13",
        simulated_ratio(thor)?,
        format!(
            "bench with a free 5 kg link at the spring; closed form {:.3}; for held links {:.3}",
            sprung_link_free(&c, 5.0).ratio.at_hz(40.0).norm(),
            locked.ratio.at_hz(40.0).norm()
        ),
    );
    let free = Link::free(68.5);
    for (id, sprung, unsprung) in
        [("S4-14", Link::Fixed, free), ("S4-15", free, Link::Fixed), ("S4-16", free, free)]
    {
        let response = ForceResponse::new(&c, sprung, unsprung);
        let top = peaks(|f| response.sprung.at_hz(f), [3.0, 100.0]);
        let top = top.first().context("no peak")?;
        ledger.put(
            id,
            top.frequency_hz,
            "free links of the bench's 68.5 kg; the text does not state its masses",
        );
    }
    Ok(())
}

/// `|F_sprung/F_unsprung|` at 40 Hz by time integration with a free sprung link of 5 kg.
fn simulated_ratio(thor: &Thor) -> anyhow::Result<f64> {
    let bench = Bench::Masses { link_1_kg: 5.0, link_2_kg: f64::INFINITY };
    let model = BenchModel::new(thor.spec_with(Configuration::SprungMotorHousing, STIFF_N_M), bench)?;
    let (hz, rate_hz) = (40.0, 2000.0);
    let time_s: Vec<f64> = (0..40_001).map(|i| f64::from(i) / rate_hz).collect();
    // Rising slowly, so that the free oscillation of the link stays small.
    let values = time_s.iter().map(|t| 500.0 * (t / 5.0).min(1.0) * (TAU * hz * t).sin()).collect();
    let record = Record {
        name: "free sprung link".to_owned(),
        time_s: time_s.clone(),
        hold: InputHold::Linear,
        inputs: vec![Signal { channel: "motor_force_n".to_owned(), values }],
        outputs: Vec::new(),
    };
    let parameters: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let channels = ["force_1_n".to_owned(), "force_2_n".to_owned()];
    let outputs = model.predict(&parameters, &record, &channels).map_err(|e| anyhow::anyhow!("{e}"))?.outputs;
    // The 40 Hz part of the last 10 s under a Hann window, which what is left of the free oscillation does not reach.
    let part = |values: &[f64]| {
        let (mut re, mut im) = (0.0, 0.0);
        for i in 20_000..40_000 {
            let window = 0.5 - 0.5 * (TAU * (i - 20_000) as f64 / 20_000.0).cos();
            let (sin, cos) = (TAU * hz * time_s[i]).sin_cos();
            re += window * values[i] * cos;
            im += window * values[i] * sin;
        }
        re.hypot(im)
    };
    Ok(part(&outputs[0].values) / part(&outputs[1].values))
}

fn table_8(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    let m_s = thor.spec.sprung_mass_kg;
    for (id, k, m) in [
        ("T8-wmax-stiff-SMH", STIFF_N_M, m_s),
        ("T8-wmax-soft-SMH", SOFT_N_M, m_s),
        ("T8-wmax-stiff-SBN", STIFF_N_M, SBN_MASS_KG),
        ("T8-wmax-soft-SBN", SOFT_N_M, SBN_MASS_KG),
    ] {
        ledger.put(id, pure_force_source_hz(k, m), "eq 4-37 for this column; the printed row is sorted by size, which puts every cell in the wrong column");
    }
    for (natural, bandwidth, cmax, k) in [
        ("T8-wn-soft", "T8-bw3-soft", "T8-cmax-soft", SOFT_N_M),
        ("T8-wn-stiff", "T8-bw3-stiff", "T8-cmax-stiff", STIFF_N_M),
    ] {
        let c = thor.smh(k);
        let edge = plant_bandwidth_hz(&c);
        ledger.put(
            natural,
            first_mode_hz(&plant(&c)),
            format!("sqrt(k/m_T)/2 pi; what is printed is the -3 dB frequency of eq 4-41 ({edge:.3} Hz)"),
        );
        ledger.put(bandwidth, edge, "-3 dB (half power) of eq 4-41");
        let bound = CompensatorBound::new(&c, CURRENT_LIMIT_A, AMPLITUDE_N);
        let printed = ledger.printed(bandwidth)?;
        ledger.put(
            cmax,
            printed * 10f64.powf(bound.increase_decades),
            format!(
                "printed bandwidth x 10^{:.4}; from our own bandwidth {:.2} Hz",
                bound.increase_decades, bound.bandwidth_hz
            ),
        );
    }
    Ok(())
}
