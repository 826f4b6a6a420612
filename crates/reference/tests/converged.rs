//! The independent simulator against itself at half the step, and against closed forms.

use sealegs_actuator::ActuatorSpec;
use sealegs_reference::campaign::{BEYOND, CATALOGUE, Hidden, Individual, Rig, SUBSTEPS};
use sealegs_reference::{Outputs, Reference};

const PERIOD_S: f64 = 1e-3;

/// A staircase with a fast sine on it: reversals, rest and resonance, A.
fn command(samples: usize) -> Vec<f64> {
    let stairs = [0.0, 2.1, -1.4, 0.6, 2.4, -2.0];
    (0..samples)
        .map(|n| {
            let t = n as f64 * PERIOD_S;
            stairs[(n / 80) % stairs.len()] + 0.8 * (std::f64::consts::TAU * 23.0 * t).sin()
        })
        .collect()
}

/// Signals with one standard deviation of their sensor's error, in the reference's own units.
fn signals(out: &Outputs) -> [(&'static str, &[f64], f64); 4] {
    // Encoders of 4096 counts a turn at 0.106 mm/rad and of 65536 at an arm of 72.5 mm.
    [
        ("force 1", &out.force_1, 2.0),
        ("force 2", &out.force_2, 2.0),
        ("extension", &out.extension, 4.4e-4 * 1.061e-4),
        ("link 2", &out.link_2, 2.77e-5 * 0.0725),
    ]
}

#[test]
fn reference_halving_the_step_changes_no_signal_by_a_tenth_of_its_noise() {
    let spec = ActuatorSpec::preset("thor-linear").unwrap();
    let individual = Individual::drawn(3);
    let command = command(480);
    for rig in [Rig::Locked, Rig::Pendulum] {
        for id in CATALOGUE.iter().chain(&BEYOND).filter(|id| Hidden::applies(id, rig)) {
            let machine = Hidden::drawn(id, 3, 1.0).put_into(individual.on(&spec, rig.bench()));
            let [coarse, fine] = [1, 2].map(|n| machine.run(PERIOD_S, &command, n * SUBSTEPS));
            for ((name, coarse, noise), (_, fine, _)) in signals(&coarse).iter().zip(signals(&fine)) {
                let squares: f64 = coarse.iter().zip(fine).map(|(c, f)| (c - f).powi(2)).sum();
                let rms = (squares / fine.len() as f64).sqrt() / noise;
                assert!(rms < 0.1, "{id}, {rig:?}: {name} changes by {rms:.2e} of its noise");
            }
        }
    }
}

#[test]
fn analytic_a_late_command_acts_at_its_own_instant() {
    // A free mass under a constant push moves by F t^2 / 2m from the instant at which the push begins.
    for late_s in [0.0, 3.3e-6, 1e-5, 4.2e-4, 2.34e-3] {
        let free = Reference { command_delay_s: late_s, ..Reference::new(2.0, 0.0, 0.0, 0.0) };
        let mut command = vec![5.0; 20];
        command[0] = 0.0;
        let got = free.run(PERIOD_S, &command, 10).extension;
        for (n, got) in got.iter().enumerate() {
            let pushed = (n as f64 * PERIOD_S - PERIOD_S - late_s).max(0.0);
            let truth = 5.0 * pushed * pushed / (2.0 * 2.0);
            assert!((got - truth).abs() < 1e-12, "{late_s} s late, row {n}: {got} for {truth}");
        }
    }
}

#[test]
fn analytic_a_damped_mass_on_a_spring_rings_as_it_must() {
    let (m, b, k, push) = (290.0, 4000.0, 6.5e5, 300.0);
    let got = Reference::new(m, 0.0, b, k).run(PERIOD_S, &vec![push; 400], SUBSTEPS).extension;
    let (decay, natural) = (b / (2.0 * m), (k / m).sqrt());
    let damped = (natural * natural - decay * decay).sqrt();
    for (n, got) in got.iter().enumerate() {
        let t = n as f64 * PERIOD_S;
        let (sin, cos) = (damped * t).sin_cos();
        let truth = push / k * (1.0 - (-decay * t).exp() * (cos + decay / damped * sin));
        assert!((got - truth).abs() < 1e-13, "at {t} s: {got} for {truth}");
    }
}

#[test]
fn analytic_friction_halts_a_mass_where_it_must_and_holds_it() {
    // Pushed at 30 N against 20 N for 10 ms, then let go: it comes to rest after half that time, and stays.
    let (m, push, rub) = (4.0, 30.0, 20.0);
    let sliding = Reference { coulomb: rub, ..Reference::new(m, 0.0, 0.0, 0.0) };
    let command: Vec<f64> = (0..40).map(|n| if n < 10 { push } else { 0.0 }).collect();
    let got = sliding.run(PERIOD_S, &command, 7).extension;
    let (speed, t) = ((push - rub) / m * 0.01, 0.01);
    let truth = 0.5 * speed * t + 0.5 * speed * speed / (rub / m);
    assert!((got[39] - truth).abs() < 1e-15, "{} for {truth}", got[39]);
    assert!(got[16..].iter().all(|x| *x == got[39]), "it creeps");
}
