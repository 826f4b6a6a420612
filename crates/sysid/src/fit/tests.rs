//! Recovery of known parameters of a closed-form system, and what a fit must respect.

use super::*;
use crate::campaign::{Campaign, Role};
use crate::toy::{Noise, Toy, campaign, run};

const TRUTH: [f64; 3] = [1.1, 5.0, 380.0];
const NOISE: (f64, f64) = (0.2, 0.001);

fn toy_campaign(seed: u64) -> Campaign {
    // Sensors' gains as their priors say, the same for all runs.
    let mut noise = Noise::new(seed);
    let (force, length) = (1.0 + 0.01 * noise.normal(), 1.0 + 0.01 * noise.normal());
    campaign(
        vec![
            (Role::Fit, run(&TRUTH, 800, 10 * seed + 1, NOISE, (force, 0.3), length)),
            (Role::Fit, run(&TRUTH, 800, 10 * seed + 2, NOISE, (force, 0.3), length)),
            (Role::Holdout, run(&TRUTH, 800, 10 * seed + 3, NOISE, (force, 0.3), length)),
        ],
        NOISE,
    )
}

fn with_fit(toy: &Toy, seed: u64, check: impl Fn(&Fit, &Campaign)) {
    let campaign = toy_campaign(seed);
    let data = Data::new(&campaign, Some(Role::Fit), toy).unwrap();
    check(&fit(&data, toy, &FitOptions::default()).unwrap(), &campaign);
}

#[test]
fn analytic_known_parameters_are_recovered_to_the_noise_floor() {
    let toy = Toy::new();
    with_fit(&toy, 1, |fit, campaign| {
        assert!(fit.converged && (fit.error() - 1.0).abs() < 0.03, "{}", fit.error());
        for (p, truth) in fit.parameters.iter().zip(TRUTH) {
            assert!((p.value - truth).abs() < 4.0 * p.std, "{p:?}");
            assert!(p.std < 0.03 * truth && p.felt && p.at_bound.is_none(), "{p:?}");
        }
        let force = fit.sensors().iter().find(|s| s.channel == "force_1_n").unwrap();
        assert!((force.bias - 0.3).abs() < 0.05 && !force.gain_at_limit, "{force:?}");
        let held = Data::new(campaign, Some(Role::Holdout), &toy).unwrap();
        let judged = held.judge(&toy, &fit.values, fit.sensors()).unwrap();
        assert!((judged.rms - 1.0).abs() < 0.05, "{}", judged.rms);
        assert!(fit.simulations > 10 && (fit.simulated_s / fit.simulations as f64 - 3.995).abs() < 0.01);
    });
}

#[test]
fn analytic_stated_intervals_cover_the_truth_at_their_rate() {
    let toy = Toy::new();
    let (mut inside, mut all) = (0, 0);
    for seed in 0..40 {
        let campaign = toy_campaign(100 + seed);
        let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
        let fit = fit(&data, &toy, &FitOptions::default()).unwrap();
        for (p, truth) in fit.parameters.iter().zip(TRUTH) {
            inside += usize::from((p.value - truth).abs() < p.std);
            all += 1;
        }
    }
    // One standard error covers 68 %; 120 (partly correlated) trials scatter by about 6 %.
    let rate = f64::from(u32::try_from(inside).unwrap()) / f64::from(all);
    assert!((0.52..0.84).contains(&rate), "{rate}");
}

#[test]
fn bounds_hold_and_are_reported() {
    let mut toy = Toy::new();
    toy.parameters[2].max = 340.0;
    toy.parameters[2].value = 300.0;
    with_fit(&toy, 2, |fit, _| {
        assert!(fit.parameters[2].value <= 340.0);
        assert_eq!(fit.parameters[2].at_bound, Some(Bound::Max));
    });
}

#[test]
fn a_tight_prior_outweighs_the_data_and_a_loose_one_does_not() {
    for (std, near_nominal) in [(1e-4, true), (1e3, false)] {
        let mut toy = Toy::new();
        toy.parameters[2].prior_std = Some(std);
        with_fit(&toy, 3, |fit, _| {
            assert_eq!((fit.parameters[2].value - 400.0).abs() < 1.0, near_nominal);
            assert_eq!(fit.parameters[2].felt, !near_nominal);
        });
    }
}

#[test]
fn a_direction_that_only_priors_tell_anything_of_is_followed_to_its_minimum() {
    // Mass, damping and stiffness in proportion are a gain of the deflection's sensor; with so little noise other directions are
    // millions of times steeper than the priors.
    let noise = (2e-4, 1e-6);
    let records = (0..2).map(|seed| (Role::Fit, run(&TRUTH, 800, seed, noise, (1.0, 0.0), 1.0))).collect();
    let campaign = campaign(records, noise);
    let mut toy = Toy::new();
    for (p, truth) in toy.parameters.iter_mut().zip(TRUTH) {
        (p.value, p.prior_std) = (truth, Some(0.01 * truth));
    }
    let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
    let from = |start: Vec<f64>| {
        fit(&data, &toy, &FitOptions { start: Some(start), ..FitOptions::default() }).unwrap()
    };
    let near = from(TRUTH.to_vec());
    let far = from(near.values.iter().map(|v| 1.03 * v).collect());
    assert!((far.cost - near.cost).abs() < 0.1, "{} {}", near.cost, far.cost);
    assert!((far.values[0] - near.values[0]).abs() < 0.2 * near.parameters[0].std);
}

#[test]
fn fixed_parameters_stay_and_silent_ones_are_named() {
    let mut toy = Toy::new();
    toy.parameters[0].fixed = true;
    toy.parameters.push(sealegs_model::Parameter::new("idle", "m", 1.0, 0.0, 2.0));
    with_fit(&toy, 4, |fit, _| {
        assert_eq!(fit.values[0], 1.0);
        assert_eq!(fit.parameters[0].std, 0.0);
        assert_eq!(fit.values[3], 1.0, "nothing pulls at it");
        assert!(!fit.parameters[3].felt && fit.parameters[1].felt);
    });
}

#[test]
fn a_wrong_model_widens_the_standard_errors() {
    let mut toy = Toy::new();
    toy.parameters[0].fixed = true;
    toy.parameters[0].value = 0.6;
    with_fit(&toy, 5, |fit, _| {
        assert!(
            fit.error() > 2.0 && fit.std_inflation > 0.9 * fit.error(),
            "{} {}",
            fit.error(),
            fit.std_inflation
        );
    });
}

#[test]
fn other_starts_are_tried_where_the_model_names_them() {
    let mut toy = Toy::new();
    // From here the resonance is far away, and the search can strand.
    toy.parameters[2].value = 1900.0;
    toy.parameters[2].starts = vec![100.0, 500.0];
    with_fit(&toy, 6, |fit, _| assert!((fit.error() - 1.0).abs() < 0.05, "{}", fit.error()));
}

#[test]
fn the_same_bits_whatever_the_number_of_threads() {
    let run_on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let toy = Toy::new();
            let campaign = toy_campaign(7);
            let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
            let fit = fit(&data, &toy, &FitOptions::default()).unwrap();
            (fit.values, fit.covariance, fit.cost, fit.simulations)
        })
    };
    let one = run_on(1);
    assert_eq!(one, run_on(2));
    assert_eq!(one, run_on(5));
}

#[test]
fn a_failed_simulation_rejects_the_step_and_an_impossible_start_is_an_error() {
    let toy = Toy::new();
    let campaign = toy_campaign(8);
    let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
    let options = FitOptions { start: Some(vec![f64::NAN; 3]), ..FitOptions::default() };
    assert!(matches!(fit(&data, &toy, &options), Err(Error::NoStart { .. })));
}

#[test]
fn a_missing_effect_is_seen_in_its_signature() {
    let mut truth = TRUTH.to_vec();
    let a = 5e-5;
    let mut record = run(&truth, 800, 91, NOISE, (1.0, 0.0), 1.0);
    for v in &mut record.outputs[0].values {
        *v += a * v.powi(3);
    }
    truth.push(a);
    let campaign = campaign(vec![(Role::Fit, record)], NOISE);
    let toy = Toy::new();
    let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
    let base = fit(&data, &toy, &FitOptions::default()).unwrap();
    let seen = data.excitation(&base.evaluation.predictions);
    let with = toy.with_effect("cubic-sensor", &seen).unwrap();
    let mut values = base.values.clone();
    values.push(1e-4);
    let changed = data.predict(&*with, &values).unwrap();
    let signatures = Signatures::new(&data, &base, &base.evaluation.predictions, &[&changed]);
    let (drop, amplitude) = signatures.drop(&[0]);
    // Linear in the amplitude, so that screening is all but exact: 5e-5 is half the guess.
    assert!(drop > 10.0 && (amplitude[0] - 0.5).abs() < 0.1, "{drop} {amplitude:?}");
    let full = fit(&data, &*with, &FitOptions { start: Some(values), ..FitOptions::default() }).unwrap();
    assert!((base.cost - full.cost - drop).abs() < 0.1 * drop, "{} {} {drop}", base.cost, full.cost);
    assert!((signatures.cosine(0, 0) - 1.0).abs() < 1e-9);
}

#[test]
fn what_a_bound_holds_back_is_seen_as_large_as_it_is() {
    let campaign = toy_campaign(11);
    let mut toy = Toy::new();
    let free = {
        let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
        fit(&data, &toy, &FitOptions::default()).unwrap()
    };
    let most = 340.0;
    (toy.parameters[2].max, toy.parameters[2].value) = (most, 300.0);
    let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
    let base = fit(&data, &toy, &FitOptions::default()).unwrap();
    assert_eq!(base.parameters[2].at_bound, Some(Bound::Max));
    // A change that does what the parameter would do beyond its bound.
    let mut values = base.values.clone();
    values[2] += 1.0;
    let changed = data.predict(&toy, &values).unwrap();
    let signatures = Signatures::new(&data, &base, &base.evaluation.predictions, &[&changed]);
    let (drop, amplitude) = signatures.drop(&[0]);
    let gain = base.cost - free.cost;
    // Linear from a tenth below what is free: a fifth off. Never more than there is.
    assert!(gain > 20.0 && (drop - gain).abs() < 0.2 * gain, "{drop} {gain}");
    assert!(amplitude[0] > 20.0, "{amplitude:?}");
}
