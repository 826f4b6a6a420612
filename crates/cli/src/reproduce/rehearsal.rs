//! Rehearsals in the time domain: the identifications of section 3-4 carried out on simulated benches, sampled at
//! 400 Hz, through the product's own integrator and H1 estimate.

use rayon::prelude::*;
use sealegs::actuator::Configuration;
use sealegs::actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs::actuator::excitation::Profile;
use sealegs::model::{InputHold, Model, Record, Signal};
use sealegs::sysid::frf::{
    Estimator, FitWeight, FrequencyResponse, Hold, SecondOrder, Welch, fit_second_order, peak_near,
    trough_near,
};

use super::ledger::Ledger;
use super::thor::{STIFF_N_M, Thor};

const RATE_HZ: f64 = 400.0;
const SAMPLES: usize = 65_536;
/// Samples of a Welch segment: 20.48 s, lines 0.049 Hz apart.
const SEGMENT: usize = 8192;
/// Runs of the moving test; the text has one, more of them narrow the estimate.
const RUNS: u64 = 12;
/// Steps of 0.25 ms halve nothing visible: against 0.1 ms the peaks move by less than 0.01 Hz.
const STEP_S: f64 = 2.5e-4;

/// What the rehearsals found, for the figures.
#[derive(Debug, Clone)]
pub struct Rehearsals {
    /// F1/Fm of the locked bench, hold taken out.
    pub locked: FrequencyResponse,
    /// F2/Fm of the locked bench, hold taken out.
    pub locked_force_2: FrequencyResponse,
    /// The fit of `locked`.
    pub fit: SecondOrder,
    /// F1/Fm of the moving test, unlumped.
    pub moving_unlumped: FrequencyResponse,
    /// F1/Fm of the moving test, lumped.
    pub moving_lumped: FrequencyResponse,
}

fn times() -> Vec<f64> {
    (0..SAMPLES).map(|i| i as f64 / RATE_HZ).collect()
}

/// One run of noise of 150 Hz bandwidth, N.
fn noise(rms: f64, seed: u64) -> Vec<f64> {
    Profile::Noise { rms, bandwidth_hz: 150.0, seed }.sample(&times())
}

fn record(name: &str, force_n: Vec<f64>) -> Record {
    Record {
        name: name.to_owned(),
        time_s: times(),
        hold: InputHold::ZeroOrder,
        inputs: vec![Signal { channel: "motor_force_n".to_owned(), values: force_n }],
        outputs: Vec::new(),
    }
}

fn predicted(model: &BenchModel, record: &Record, channels: &[&str]) -> anyhow::Result<Vec<Vec<f64>>> {
    let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let names: Vec<String> = channels.iter().map(|c| (*c).to_owned()).collect();
    let prediction =
        model.predict(&values, record, &names).map_err(|e| anyhow::anyhow!("{}: {e}", record.name))?;
    Ok(prediction.outputs.into_iter().map(|s| s.values).collect())
}

/// A load cell's resolution of +-2 N: readings in steps of 4 N.
fn resolved(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| 4.0 * (v / 4.0).round()).collect()
}

/// Carries out both identifications and enters what they give.
///
/// # Errors
///
/// If a simulation or an estimate fails.
pub fn enter(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<Rehearsals> {
    let (locked, locked_force_2, fit) = locked(ledger, thor)?;
    let (moving_unlumped, moving_lumped) = moving(ledger, thor)?;
    Ok(Rehearsals { locked, locked_force_2, fit, moving_unlumped, moving_lumped })
}

fn locked(
    ledger: &mut Ledger<'_>,
    thor: &Thor,
) -> anyhow::Result<(FrequencyResponse, FrequencyResponse, SecondOrder)> {
    let spec = thor.spec_with(Configuration::SprungMotorHousing, STIFF_N_M);
    let c = spec.coefficients();
    let model = BenchModel::new(spec, Bench::Locked)?;
    let chirp = Profile::Chirp {
        amplitude: 2.0 * c.force_constant,
        from_hz: 0.01,
        to_hz: 150.0,
        duration_s: SAMPLES as f64 / RATE_HZ,
        logarithmic: true,
    };
    let (chirp, noise) = (chirp.sample(&times()), noise(c.force_constant, 1));
    let command: Vec<f64> = chirp.iter().zip(&noise).map(|(a, b)| a + b).collect();
    let run = record("identification rehearsal", command.clone());
    let forces = predicted(&model, &run, &["force_1_n", "force_2_n"])?;
    let estimate = |force: &[f64]| -> anyhow::Result<FrequencyResponse> {
        let measured = resolved(force);
        let spectra = Welch::hann(SEGMENT).spectra(1.0 / RATE_HZ, &[(&command, &measured)])?;
        Ok(spectra.response(Estimator::H1))
    };
    let raw = estimate(&forces[0])?;
    let clean = raw.clone().without_hold(Hold::ZeroOrder);
    let fit_of = |r: &FrequencyResponse| fit_second_order(&r.band(0.05, 60.0, 0.5), FitWeight::Coherence);
    let (with, without) = (fit_of(&clean)?, fit_of(&raw)?);
    let truth = [c.stiffness / c.total_mass(), c.damping / c.total_mass(), c.stiffness / c.total_mass()];
    let per_cent = |found: f64, truth: f64| 100.0 * (found / truth - 1.0);
    let why = "simulated at 400 Hz with held commands and +-2 N readings, H1 with 20.48 s Hann segments, fit over 0.05 to 60 Hz by coherence";
    ledger.put("S3-10", per_cent(with.numerator, truth[0]), why);
    ledger.put("S3-11", per_cent(with.first, truth[1]), why);
    ledger.put("S3-12", per_cent(with.zeroth, truth[2]), why);
    ledger.put("S3-13", per_cent(without.zeroth, truth[2]), "half a sample of delay taken for dynamics");
    ledger.put("S3-14", per_cent(without.first, truth[1]), "half a sample of delay taken for dynamics");
    ledger.put("S3-15", without.static_gain(), "neither hold nor noise lowers the static gain: 0.95 of the printed fit needs another cause, such as friction or a drive of 95 % (inference)");
    let second = estimate(&forces[1])?.without_hold(Hold::ZeroOrder);
    Ok((clean, second, with))
}

/// The response of a pendulum bench to the noise of section 3-4-5, and the root mean square and greatest swing, rad.
fn moving_response(
    thor: &Thor,
    configuration: Configuration,
    commands: &[Vec<f64>],
) -> anyhow::Result<(FrequencyResponse, f64, f64)> {
    let spec = thor.spec_with(configuration, STIFF_N_M);
    let model = BenchModel::new(spec, Bench::Pendulum(PendulumRig::default()))?.with_step(STEP_S);
    let runs: Vec<anyhow::Result<(Vec<f64>, f64, f64)>> = commands
        .par_iter()
        .map(|command| {
            let run = record("moving output", command.clone());
            let mut outputs = predicted(&model, &run, &["force_1_n", "joint_angle_rad"])?;
            let swing = outputs.pop().unwrap_or_default();
            let square = swing.iter().map(|a| a * a).sum::<f64>() / swing.len() as f64;
            let most = swing.iter().fold(0.0f64, |m, a| m.max(a.abs()));
            Ok((resolved(&outputs[0]), square, most))
        })
        .collect();
    let runs = runs.into_iter().collect::<anyhow::Result<Vec<_>>>()?;
    let pairs: Vec<(&[f64], &[f64])> =
        commands.iter().zip(&runs).map(|(c, r)| (c.as_slice(), r.0.as_slice())).collect();
    let response = Welch::hann(SEGMENT)
        .spectra(1.0 / RATE_HZ, &pairs)?
        .response(Estimator::H1)
        .without_hold(Hold::ZeroOrder);
    let rms = (runs.iter().map(|r| r.1).sum::<f64>() / runs.len() as f64).sqrt();
    let most = runs.iter().fold(0.0f64, |m, r| m.max(r.2));
    Ok((response, rms, most))
}

fn moving(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<(FrequencyResponse, FrequencyResponse)> {
    let commands: Vec<Vec<f64>> = (0..RUNS).into_par_iter().map(|run| noise(841.0, 100 + run)).collect();
    let (unlumped, rms, most) = moving_response(thor, Configuration::SprungMotorHousing, &commands)?;
    let (lumped, ..) = moving_response(thor, Configuration::Lumped, &commands)?;
    for (id, response, band, half_width) in
        [("S3-20", &unlumped, [12.0, 22.0], 0.35), ("S3-21", &lumped, [5.0, 9.0], 0.12)]
    {
        let db = response.magnitude_db();
        let peak = peak_near(&response.frequency_hz, &db, band[0], band[1], half_width)
            .ok_or_else(|| anyhow::anyhow!("{id}: no peak between {} and {} Hz", band[0], band[1]))?;
        ledger.put(id, peak.frequency_hz, format!(
            "nonlinear pendulum in 0.25 ms steps, 841 N noise held at 400 Hz, {RUNS} x 163.84 s, H1; peak {:+.1} dB",
            peak.magnitude_db
        ));
    }
    let dip = trough_near(&unlumped.frequency_hz, &unlumped.magnitude_db(), 0.5, 1.5, 0.0)
        .ok_or_else(|| anyhow::anyhow!("no dip near 1 Hz"))?;
    ledger.put("S3-22", dip.frequency_hz, "the lines of the estimate are 0.049 Hz apart");
    ledger.put("S3-23", rms.to_degrees(), format!("greatest swing {:.0} deg", most.to_degrees()));
    Ok((unlumped, lumped))
}
