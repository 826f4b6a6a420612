//! What a campaign can identify, on a closed-form system; oddities of columns.

use super::*;
use crate::campaign::Role;
use crate::fit::{FitOptions, fit};
use crate::toy::{Toy, campaign, run};

const NOISE: (f64, f64) = (0.2, 0.001);

#[test]
fn achievable_errors_are_those_of_the_fit() {
    let toy = Toy::new();
    let truth: Vec<f64> = toy.parameters.iter().map(|p| p.value).collect();
    let campaign = campaign(vec![(Role::Fit, run(&truth, 2000, 3, NOISE, (1.0, 0.0), 1.0))], NOISE);
    let found = check(&campaign, &toy).unwrap();
    let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
    let fitted = fit(&data, &toy, &FitOptions::default()).unwrap();
    for (checked, p) in found.parameters.iter().zip(&fitted.parameters) {
        assert!(checked.identifiable, "{checked:?}");
        assert!((checked.std / p.std - 1.0).abs() < 0.2, "{checked:?} {p:?}");
    }
    assert!(found.simulations > 0);
}

#[test]
fn an_idle_parameter_and_a_weak_effect_are_not_identifiable() {
    let mut toy = Toy::new();
    toy.parameters.push(sealegs_model::Parameter::new("idle", "m", 1.0, 0.0, 2.0));
    let truth: Vec<f64> = toy.parameters.iter().map(|p| p.value).collect();
    let weak = campaign(vec![(Role::Fit, run(&truth, 400, 4, NOISE, (1.0, 0.0), 1.0))], (200.0, 1.0));
    let found = check(&weak, &toy).unwrap();
    assert!(!found.parameters[3].identifiable);
    let found = check(&weak, &Toy::new()).unwrap();
    assert!(!found.effects[0].identifiable(), "{:?}", found.effects);
}

#[test]
fn a_visible_effect_is_said_to_be_so() {
    let toy = Toy::new();
    let truth: Vec<f64> = toy.parameters.iter().map(|p| p.value).collect();
    let campaign = campaign(vec![(Role::Fit, run(&truth, 2000, 5, NOISE, (1.0, 0.0), 1.0))], NOISE);
    let found = check(&campaign, &toy).unwrap();
    assert!(found.effects[0].identifiable() && found.effects[0].alike.is_empty(), "{:?}", found.effects);
    assert!(found.excited[0].reversals > 10 && found.excited[0].quiet_rows == 40);
    let (low, high) = found.excited[0].band_hz.unwrap();
    // A random staircase of 0.1 s steps has its power below its first zero at 10 Hz.
    assert!(low < 1.0 && high > 1.0 && high < 20.0, "{low} {high}");
}

#[test]
fn dear_simulations_are_judged_on_ten_seconds_and_it_is_said() {
    let toy = Toy::new();
    let truth: Vec<f64> = toy.parameters.iter().map(|p| p.value).collect();
    // 30 s at 200 Hz.
    let campaign = campaign(vec![(Role::Fit, run(&truth, 6000, 5, NOISE, (1.0, 0.0), 1.0))], NOISE);
    let whole = check(&campaign, &toy).unwrap();
    assert_eq!(whole.judged_on_first_s, None);
    let told = std::sync::Mutex::new(Vec::new());
    let tell = |what: &str| told.lock().unwrap().push(what.to_owned());
    let short = check_within(&campaign, &toy, 0.0, &tell).unwrap();
    assert_eq!(short.judged_on_first_s, Some(10.0));
    assert_eq!(short.excited, whole.excited, "what the runs hold is seen on all of them");
    // A third of the rows: what an effect changes, summed over them, is less by the root of 3.
    let visible = |found: &Check| found.effects[0].visible.unwrap();
    let ratio = visible(&short) / visible(&whole) * 3f64.sqrt();
    assert!((ratio - 1.0).abs() < 0.25, "{ratio}");
    let told = told.into_inner().unwrap();
    assert!(told.iter().any(|line| line.starts_with("simulating effect 1 of ")), "{told:?}");
}

#[test]
fn saturation_and_quanta_are_seen() {
    let clipped: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.01).sin().clamp(-0.8, 0.8)).collect();
    let share = saturated(&clipped, (-0.8, 0.8));
    assert!((share - 0.41).abs() < 0.03, "{share}");
    let free: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.01).sin()).collect();
    assert!(saturated(&free, (-1.0, 1.0)) < 0.01);
    assert!(is_decimal(0.001) && !is_decimal(0.001534));
}
