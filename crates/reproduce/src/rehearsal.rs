//! Rehearsals in the time domain: the identifications of section 3-4 carried out on simulated benches, sampled at
//! 400 Hz, through the product's own integrator and H1 estimate.

use rayon::prelude::*;
use sealegs_actuator::Configuration;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs_actuator::excitation::Profile;
use sealegs_model::{InputHold, Model, Record, Signal};
use sealegs_sysid::frf::{
    Estimator, FitWeight, FrequencyResponse, Hold, Peak, SecondOrder, Welch, fit_second_order, peak_near,
    trough_near,
};

use crate::ReproduceError;
use crate::thor::{STIFF_N_M, Thor};

const RATE_HZ: f64 = 400.0;
const SAMPLES: usize = 65_536;
/// Samples of a Welch segment: 20.48 s, lines 0.049 Hz apart.
const SEGMENT: usize = 8192;
/// Runs of the moving test; the text has one, more of them narrow the estimate.
const RUNS: u64 = 12;
/// Steps of 0.25 ms halve nothing visible: against 0.1 ms the peaks move by less than 0.01 Hz.
const STEP_S: f64 = 2.5e-4;

/// What the rehearsals found.
#[derive(Debug, Clone)]
pub struct Rehearsals {
    /// The locked bench's own numerator, first-order coefficient and constant term, in 1/s^2, 1/s and 1/s^2.
    pub truth: [f64; 3],
    /// The fit of F1/Fm of the locked bench, hold ignored.
    pub fit_with_hold: SecondOrder,
    /// The moving test.
    pub moving: Moving,
    /// F1/Fm of the locked bench, hold taken out.
    pub locked: FrequencyResponse,
    /// F2/Fm of the locked bench, hold taken out.
    pub locked_force_2: FrequencyResponse,
    /// The fit of `locked`.
    pub fit: SecondOrder,
}

/// What the moving test found.
#[derive(Debug, Clone)]
pub struct Moving {
    /// F1/Fm, unlumped.
    pub unlumped: FrequencyResponse,
    /// F1/Fm, lumped.
    pub lumped: FrequencyResponse,
    /// Its peak, unlumped.
    pub unlumped_peak: Peak,
    /// Its peak, lumped.
    pub lumped_peak: Peak,
    /// The pendulum's dip, unlumped, Hz.
    pub dip_hz: f64,
    /// Root mean square of the swing, rad.
    pub swing_rms_rad: f64,
    /// Greatest swing, rad.
    pub swing_greatest_rad: f64,
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
        cut: false,
        name: name.to_owned(),
        time_s: times(),
        hold: InputHold::ZeroOrder,
        inputs: vec![Signal { channel: "motor_force_n".to_owned(), values: force_n }],
        outputs: Vec::new(),
    }
}

fn predicted(
    model: &BenchModel,
    record: &Record,
    channels: &[&str],
) -> Result<Vec<Vec<f64>>, ReproduceError> {
    let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let names: Vec<String> = channels.iter().map(|c| (*c).to_owned()).collect();
    let prediction =
        model.predict(&values, record, &names).map_err(|e| ReproduceError::simulation(&record.name, e))?;
    Ok(prediction.outputs.into_iter().map(|s| s.values).collect())
}

/// A load cell's resolution of +-2 N: readings in steps of 4 N.
fn resolved(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| 4.0 * (v / 4.0).round()).collect()
}

/// Carries out both identifications.
///
/// # Errors
///
/// If a simulation or an estimate fails.
pub fn rehearse(thor: &Thor) -> Result<Rehearsals, ReproduceError> {
    let moving = moving(thor)?;
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
    let estimate = |force: &[f64]| -> Result<FrequencyResponse, ReproduceError> {
        let measured = resolved(force);
        let spectra = Welch::hann(SEGMENT).spectra(1.0 / RATE_HZ, &[(&command, &measured)])?;
        Ok(spectra.response(Estimator::H1))
    };
    let raw = estimate(&forces[0])?;
    let clean = raw.clone().without_hold(Hold::ZeroOrder);
    let fit_of = |r: &FrequencyResponse| fit_second_order(&r.band(0.05, 60.0, 0.5), FitWeight::Coherence);
    Ok(Rehearsals {
        truth: [c.stiffness / c.total_mass(), c.damping / c.total_mass(), c.stiffness / c.total_mass()],
        fit: fit_of(&clean)?,
        fit_with_hold: fit_of(&raw)?,
        locked_force_2: estimate(&forces[1])?.without_hold(Hold::ZeroOrder),
        locked: clean,
        moving,
    })
}

/// One run of the moving test: force 1 (N) as the load cell reads it, mean square (rad^2) and greatest swing (rad).
type Swung = (Vec<f64>, f64, f64);

/// The response of a pendulum bench to the noise of section 3-4-5, and the root mean square and greatest swing, rad.
fn moving_response(
    thor: &Thor,
    configuration: Configuration,
    commands: &[Vec<f64>],
) -> Result<(FrequencyResponse, f64, f64), ReproduceError> {
    let spec = thor.spec_with(configuration, STIFF_N_M);
    let model = BenchModel::new(spec, Bench::Pendulum(PendulumRig::default()))?.with_step(STEP_S);
    let runs: Vec<Result<Swung, ReproduceError>> = commands
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
    let runs = runs.into_iter().collect::<Result<Vec<_>, _>>()?;
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

fn moving(thor: &Thor) -> Result<Moving, ReproduceError> {
    let commands: Vec<Vec<f64>> = (0..RUNS).into_par_iter().map(|run| noise(841.0, 100 + run)).collect();
    let (unlumped, swing_rms_rad, swing_greatest_rad) =
        moving_response(thor, Configuration::SprungMotorHousing, &commands)?;
    let (lumped, ..) = moving_response(thor, Configuration::Lumped, &commands)?;
    let peak = |response: &FrequencyResponse, [from, to]: [f64; 2], half_width| {
        peak_near(&response.frequency_hz, &response.magnitude_db(), from, to, half_width)
            .ok_or_else(|| ReproduceError::missing(format!("no peak between {from} and {to} Hz")))
    };
    let dip = trough_near(&unlumped.frequency_hz, &unlumped.magnitude_db(), 0.5, 1.5, 0.0)
        .ok_or_else(|| ReproduceError::missing("no dip near 1 Hz"))?;
    Ok(Moving {
        unlumped_peak: peak(&unlumped, [12.0, 22.0], 0.35)?,
        lumped_peak: peak(&lumped, [5.0, 9.0], 0.12)?,
        dip_hz: dip.frequency_hz,
        swing_rms_rad,
        swing_greatest_rad,
        unlumped,
        lumped,
    })
}
