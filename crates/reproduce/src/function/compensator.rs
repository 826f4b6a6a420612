//! The ideal inverse compensator with a clipped current: all current limits and amplitudes of figures 4-16 and 4-17, by
//! the exact periodic steady state and again by the bench in small steps.

use std::f64::consts::TAU;

use rayon::prelude::*;
use sealegs_actuator::bench::{Bench, BenchModel};
use sealegs_actuator::compensator::ClippedCompensator;
use sealegs_actuator::plant::Grid;
use sealegs_actuator::response::{CompensatorBound, HALF_POWER_DB};
use sealegs_actuator::{Coefficients, Configuration};
use sealegs_model::Model;

use super::response::stiffness;
use super::{Call, Function};
use crate::ReproduceError;
use crate::figures::control::{AMPLITUDES_N, CURRENTS_A, curve};
use crate::setup::Setup;
use crate::thor::{AMPLITUDE_N, CURRENT_LIMIT_A, SOFT_N_M, STIFF_N_M, Thor};

pub(super) const FUNCTIONS: [Function; 6] = [
    Function {
        name: "bound",
        usage: "stiffness, amplitude in N, current in A, field: eq 4-50 to 4-52",
        law: bound,
    },
    Function {
        name: "clipped",
        usage: "stiffness, amplitude in N, current in A, bandwidth_hz or onset_hz: exact periodic steady state",
        law: clipped,
    },
    Function {
        name: "clipped_gain_db",
        usage: "stiffness, amplitude in N, current in A, Hz: dB",
        law: clipped_gain_db,
    },
    Function {
        name: "clipped_bench_differs_db",
        usage: "the bench in small steps at the -3 dB of all 18 cases: the greatest difference, dB",
        law: bench_differs_db,
    },
    Function {
        name: "clipped_figures_differ_db",
        usage: "figures 4-16 and 4-17 at equal limit over amplitude: the greatest difference, dB",
        law: figures_differ_db,
    },
    Function {
        name: "bound_ends",
        usage: "damping_ratio, or stiffness_n_m: where eq 4-52 stops being an upper bound",
        law: bound_ends,
    },
];

fn bound(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let c = setup.thor.smh(stiffness(call, 0)?);
    let bound = CompensatorBound::new(&c, call.number(2)?, call.number(1)?);
    match call.word(3)? {
        "max_gain_db" => Ok(bound.max_gain_db),
        "max_gain_fundamental_db" => Ok(bound.max_gain_fundamental_db),
        "increase_decades" => Ok(bound.increase_decades),
        "bandwidth_hz" => Ok(bound.bandwidth_hz),
        other => Err(call.unknown("field", other)),
    }
}

fn compensator(setup: &Setup, call: &Call<'_>) -> Result<ClippedCompensator, ReproduceError> {
    Ok(ClippedCompensator::new(&setup.thor.smh(stiffness(call, 0)?), call.number(2)?))
}

fn reached_hz(clipped: &ClippedCompensator, amplitude_n: f64) -> Result<f64, ReproduceError> {
    let missing =
        || ReproduceError::missing(format!("{amplitude_n} N is beyond the current limit at any frequency"));
    clipped.bandwidth_hz(amplitude_n).ok_or_else(missing)
}

fn clipped(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let (clipped, amplitude_n) = (compensator(setup, call)?, call.number(1)?);
    match call.word(3)? {
        "bandwidth_hz" => reached_hz(&clipped, amplitude_n),
        "onset_hz" => Ok(clipped.clip_onset_hz(amplitude_n)),
        other => Err(call.unknown("field", other)),
    }
}

fn clipped_gain_db(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    Ok(compensator(setup, call)?.steady_state(call.number(1)?, call.number(3)?).gain_rms_db)
}

fn bench_differs_db(setup: &Setup, _: &Call<'_>) -> Result<f64, ReproduceError> {
    let by_current = CURRENTS_A.map(|i| (i, AMPLITUDE_N));
    let by_amplitude = AMPLITUDES_N.map(|a| (CURRENT_LIMIT_A, a));
    let pairs = by_current.into_iter().chain(by_amplitude.into_iter().filter(|(_, a)| *a != AMPLITUDE_N));
    let cases: Vec<(f64, f64, f64)> =
        [SOFT_N_M, STIFF_N_M].into_iter().flat_map(|k| pairs.clone().map(move |(i, a)| (k, i, a))).collect();
    let differences: Vec<Result<f64, ReproduceError>> = cases
        .par_iter()
        .map(|&(k, i, a)| {
            let edge_hz = reached_hz(&ClippedCompensator::new(&setup.thor.smh(k), i), a)?;
            Ok(bench_gain_db(&setup.thor, k, i, a, edge_hz)? - HALF_POWER_DB)
        })
        .collect();
    let mut worst: f64 = 0.0;
    for difference in differences {
        let difference = difference?;
        if difference.abs() > worst.abs() {
            worst = difference;
        }
    }
    Ok(worst)
}

/// RMS gain of the locked bench under the clipped demand of the ideal inverse, by time integration, dB.
fn bench_gain_db(
    thor: &Thor,
    stiffness: f64,
    current_a: f64,
    amplitude_n: f64,
    hz: f64,
) -> Result<f64, ReproduceError> {
    const PER_PERIOD: usize = 1000;
    let model = BenchModel::new(thor.spec_with(Configuration::SprungMotorHousing, stiffness), Bench::Locked)?;
    let c = model.spec().coefficients();
    let limit = c.force_constant * current_a;
    let demand = ClippedCompensator::new(&c, current_a).demand_n(amplitude_n, hz);
    // The free oscillation decays with b/(2 m_T): twelve time constants leave 6e-6.
    let settle_s = 12.0 * 2.0 * c.total_mass() / c.damping;
    let periods = (settle_s * hz).ceil() as usize + 1;
    let step_s = 1.0 / (hz * PER_PERIOD as f64);
    let grid = Grid { start_s: 0.0, step_s, steps: periods * PER_PERIOD };
    let commands: Vec<f64> = (0..grid.steps)
        .map(|i| (demand * (TAU * hz * (i as f64 + 0.5) * step_s).sin()).clamp(-limit, limit))
        .collect();
    let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let plant =
        model.plant(&values, "motor_force_n").map_err(|e| ReproduceError::simulation("clipped bench", e))?;
    let trace =
        plant.simulate(grid, &commands).map_err(|e| ReproduceError::simulation("clipped bench", e))?;
    let last = &trace.force_1[grid.steps - PER_PERIOD..grid.steps];
    let rms = (last.iter().map(|f| f * f).sum::<f64>() / PER_PERIOD as f64).sqrt();
    Ok(20.0 * (rms * std::f64::consts::SQRT_2 / amplitude_n).log10())
}

fn bound_ends(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let stiff = setup.thor.smh(STIFF_N_M);
    let exceeds = |c: &Coefficients| {
        let reached = ClippedCompensator::new(c, CURRENT_LIMIT_A).bandwidth_hz(AMPLITUDE_N);
        reached.is_some_and(|hz| hz > CompensatorBound::new(c, CURRENT_LIMIT_A, AMPLITUDE_N).bandwidth_hz)
    };
    let critical = 2.0 * (stiff.stiffness * stiff.total_mass()).sqrt();
    match call.word(0)? {
        "damping_ratio" => {
            Ok(bisect(0.3, 1.0, |z| exceeds(&Coefficients { damping: z * critical, ..stiff })))
        }
        "stiffness_n_m" => Ok(bisect(600e3, 150e3, |k| exceeds(&Coefficients { stiffness: k, ..stiff }))),
        other => Err(call.unknown("field", other)),
    }
}

/// Where a condition that is false at `no` and true at `yes` begins.
fn bisect(mut no: f64, mut yes: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..40 {
        let middle = 0.5 * (no + yes);
        if holds(middle) { yes = middle } else { no = middle }
    }
    0.5 * (no + yes)
}

fn figures_differ_db(setup: &Setup, _: &Call<'_>) -> Result<f64, ReproduceError> {
    let c = setup.thor.smh(STIFF_N_M);
    let grid: Vec<f64> = (0..60).map(|i| 10f64.powf(f64::from(i) / 30.0)).collect();
    let mut worst: f64 = 0.0;
    for (current, amplitude) in CURRENTS_A.into_iter().zip(AMPLITUDES_N.into_iter().rev()) {
        let by_current = curve(&c, current, AMPLITUDE_N, &grid);
        let by_amplitude = curve(&c, CURRENT_LIMIT_A, amplitude, &grid);
        for (a, b) in by_current.iter().zip(&by_amplitude) {
            worst = worst.max((a - b).abs());
        }
    }
    Ok(worst)
}
