//! An effect that the base model hides: where nothing is known of its damping, a slow torque sensor's lag is taken up by
//! it, and alone or beside friction the lag promises nothing from there.

use sealegs::bench_model;
use sealegs_actuator::excitation::Profile;
use sealegs_reference::Reference;
use sealegs_sysid::diagnose::{Diagnosis, VerdictKind};
use sealegs_sysid::{Campaign, diagnose};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

const PERIOD_S: f64 = 2e-3;
const CUTOFF_HZ: f64 = 4.3;
const NOISE_NM: f64 = 0.002;

/// Steps of a geared servo on a torsion spring: presliding friction, and a torque sensor behind a low-pass.
fn write(folder: &Path, steps: &[(&str, f64)]) {
    let mut truth = Reference::new(0.018, 0.0, 1.2, 2450.0);
    truth.presliding = Some([0.2, 1500.0]);
    let mut campaign = format!(
        "name = \"slow-sensor\"\nbench = \"locked\"\nactuator = \"rmd-x8-rotary-sea\"\nsample_rate_hz = 500.0\n\n\
         [noise_std]\noutput_torque_nm = {NOISE_NM}\n"
    );
    for (seed, (role, amplitude)) in (1..).zip(steps) {
        let levels = [0.0, 1.0, 0.4, -0.7];
        // Whole counts of the drive, so that its known quantisation changes nothing.
        let count = 0.022_29;
        let held = |n: usize| (amplitude * levels[(n / 250) % 4] / count).round() * count * (1.0 + 1e-9);
        let command: Vec<f64> = (0..1000).map(held).collect();
        let torque = truth.run(PERIOD_S, &command, 200).force_1;
        let time_s: Vec<f64> = (0..command.len()).map(|n| n as f64 * PERIOD_S).collect();
        let noise = Profile::Noise { rms: NOISE_NM, bandwidth_hz: 250.0, seed }.sample(&time_s);
        let kept = (-TAU * CUTOFF_HZ * PERIOD_S).exp();
        let mut shown = 0.0;
        let mut csv = String::from("time_s,motor_torque_nm,output_torque_nm\n");
        for n in 0..command.len() {
            // The low-pass of a torque that is straight between samples, to the second order of the period.
            let before = torque[n.saturating_sub(1)];
            shown = kept * shown + (1.0 - kept) * 0.5 * (before + torque[n]);
            writeln!(csv, "{:.4},{:.8},{:.6}", time_s[n], command[n], shown + noise[n]).unwrap();
        }
        std::fs::write(folder.join(format!("run_{seed}.csv")), csv).unwrap();
        write!(campaign, "\n[[run]]\nfile = \"run_{seed}.csv\"\nrole = \"{role}\"\n").unwrap();
    }
    std::fs::write(folder.join("campaign.toml"), campaign).unwrap();
}

#[test]
fn a_slow_sensor_is_found_behind_the_damping_that_takes_its_place() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[("fit", 0.5), ("fit", 3.0), ("holdout", 1.0), ("holdout", 2.0)]);
    let mut campaign = Campaign::read(folder.path()).unwrap();
    let model = bench_model::of_campaign(&mut campaign, None, Vec::new()).unwrap();
    let Diagnosis { verdict, found, .. } = diagnose::diagnose(&campaign, &model, &|_, _| ()).unwrap();
    let pair = ["presliding-friction", "sensor-lag"];
    let tried: Vec<String> =
        found.tried.iter().map(|t| format!("{}: {:.3}", t.effects.join(" + "), t.fit.error())).collect();
    assert_eq!(
        (verdict.kind, verdict.effects.as_slice()),
        (VerdictKind::MissingEffect, &pair.map(str::to_owned)[..]),
        "{tried:#?}"
    );
    let named = &found.tried[verdict.after.index];
    let value = |name: &str| named.fit.parameters.iter().find(|p| p.name == name).unwrap().value;
    let cutoff = value("sensor-lag.cutoff_hz");
    assert!((cutoff / CUTOFF_HZ - 1.0).abs() < 0.01, "{cutoff} Hz");
    assert!(verdict.after.holdout_error < 1.15, "{} noise units", verdict.after.holdout_error);
}
