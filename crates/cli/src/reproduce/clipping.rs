//! The ideal inverse compensator with a clipped current: all current limits and amplitudes of figures 4-16 and 4-17, by
//! the exact periodic steady state and again by the bench in small steps.

use std::f64::consts::TAU;

use anyhow::Context;
use rayon::prelude::*;
use sealegs::actuator::Coefficients;
use sealegs::actuator::Configuration;
use sealegs::actuator::bench::{Bench, BenchModel};
use sealegs::actuator::compensator::ClippedCompensator;
use sealegs::actuator::plant::Grid;
use sealegs::actuator::response::{CompensatorBound, HALF_POWER_DB};
use sealegs::model::Model;

use super::chapter4::{AMPLITUDE_N, CURRENT_LIMIT_A};
use super::ledger::Ledger;
use super::thor::{SOFT_N_M, STIFF_N_M, Thor};

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

/// Enters all 18 rows, the bound's reach and figure 4-14.
///
/// # Errors
///
/// If an amplitude is beyond the current limit at any frequency.
pub fn enter(ledger: &mut Ledger<'_>, thor: &Thor) -> anyhow::Result<()> {
    let mut checks = Vec::new();
    for (k, name) in [(SOFT_N_M, "372"), (STIFF_N_M, "655")] {
        let c = thor.smh(k);
        let by_current = CURRENTS_A.map(|i| (i, AMPLITUDE_N));
        let by_amplitude = AMPLITUDES_N.map(|a| (CURRENT_LIMIT_A, a));
        for (i, a) in
            by_current.into_iter().chain(by_amplitude.into_iter().filter(|(_, a)| *a != AMPLITUDE_N))
        {
            let clipped = ClippedCompensator::new(&c, i);
            let edge = clipped.bandwidth_hz(a).with_context(|| format!("{a} N at {i} A"))?;
            let bound = CompensatorBound::new(&c, i, a);
            ledger.put(&format!("F4-bw-{name}-{a}N-{i}A"), edge, format!(
                "exact periodic steady state; clips from {:.2} Hz; bound of eq 4-52 {:.2} Hz ({:.0} % loose)",
                clipped.clip_onset_hz(a),
                bound.bandwidth_hz,
                100.0 * (bound.bandwidth_hz / edge - 1.0)
            ));
            checks.push((k, i, a, edge));
        }
    }
    let off: Vec<anyhow::Result<f64>> = checks
        .par_iter()
        .map(|&(k, i, a, hz)| Ok(bench_gain_db(thor, k, i, a, hz)? - HALF_POWER_DB))
        .collect();
    let mut worst: f64 = 0.0;
    for difference in off {
        let difference = difference?;
        if difference.abs() > worst.abs() {
            worst = difference;
        }
    }
    ledger.put(
        "S4-20",
        worst,
        "an independent path: the bench driven by the clipped sine in 1/1000 of a period from rest",
    );

    let stiff = thor.smh(STIFF_N_M);
    let clipped = ClippedCompensator::new(&stiff, CURRENT_LIMIT_A);
    for (id, hz) in [("S4-21", 42.0), ("S4-22", 60.0)] {
        ledger.put(id, clipped.steady_state(AMPLITUDE_N, hz).gain_rms_db, "stiff setting, 200 N, 10 A");
    }
    bound_reach(ledger, &stiff);
    figures_equal(ledger, &stiff);
    let soft = ClippedCompensator::new(&thor.smh(SOFT_N_M), CURRENT_LIMIT_A).bandwidth_hz(AMPLITUDE_N);
    let goal = clipped.bandwidth_hz(AMPLITUDE_N).context("200 N at 10 A")?;
    ledger.note_value("R4-06", goal, format!(
        "what the ideal compensator reaches at 10 A and 200 N, stiff ({:.1} Hz soft): the goals lie below",
        soft.unwrap_or(f64::NAN)
    ));
    Ok(())
}

/// RMS gain of the locked bench under the clipped demand of the ideal inverse, by time integration, dB.
fn bench_gain_db(
    thor: &Thor,
    stiffness: f64,
    current_a: f64,
    amplitude_n: f64,
    hz: f64,
) -> anyhow::Result<f64> {
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
    let plant = model.plant(&values, "motor_force_n").map_err(|e| anyhow::anyhow!("{e}"))?;
    let trace = plant.simulate(grid, &commands).map_err(|e| anyhow::anyhow!("{e}"))?;
    let last = &trace.force_1[grid.steps - PER_PERIOD..grid.steps];
    let rms = (last.iter().map(|f| f * f).sum::<f64>() / PER_PERIOD as f64).sqrt();
    Ok(20.0 * (rms * std::f64::consts::SQRT_2 / amplitude_n).log10())
}

/// The damping ratio at which the bound stops being one, and the stiffness that this means on THOR.
fn bound_reach(ledger: &mut Ledger<'_>, stiff: &Coefficients) {
    let exceeds = |c: &Coefficients| {
        let reached = ClippedCompensator::new(c, CURRENT_LIMIT_A).bandwidth_hz(AMPLITUDE_N);
        reached.is_some_and(|hz| hz > CompensatorBound::new(c, CURRENT_LIMIT_A, AMPLITUDE_N).bandwidth_hz)
    };
    let critical = 2.0 * (stiff.stiffness * stiff.total_mass()).sqrt();
    let zeta = bisect(0.3, 1.0, |z| exceeds(&Coefficients { damping: z * critical, ..*stiff }));
    let k = bisect(600e3, 150e3, |k| exceeds(&Coefficients { stiffness: k, ..*stiff }));
    ledger.put("R4-04", zeta, format!(
        "above this damping ratio the achieved bandwidth exceeds the bound (10 A, 200 N); with THOR's inertia and damping: below {:.0} kN/m", 1e-3 * k
    ));
}

/// Where a condition that is false at `no` and true at `yes` begins.
fn bisect(mut no: f64, mut yes: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..40 {
        let middle = 0.5 * (no + yes);
        if holds(middle) { yes = middle } else { no = middle }
    }
    0.5 * (no + yes)
}

fn figures_equal(ledger: &mut Ledger<'_>, c: &Coefficients) {
    let grid: Vec<f64> = (0..60).map(|i| 10f64.powf(f64::from(i) / 30.0)).collect();
    let mut worst: f64 = 0.0;
    for (current, amplitude) in CURRENTS_A.into_iter().zip(AMPLITUDES_N.into_iter().rev()) {
        let by_current = curve(c, current, AMPLITUDE_N, &grid);
        let by_amplitude = curve(c, CURRENT_LIMIT_A, amplitude, &grid);
        for (a, b) in by_current.iter().zip(&by_amplitude) {
            worst = worst.max((a - b).abs());
        }
    }
    ledger.put(
        "R4-05",
        worst,
        "largest difference in dB between the curves of I_max/A = 0.0125 to 0.2 A/N: only that ratio enters",
    );
}
