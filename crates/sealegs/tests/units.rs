//! Two units in one campaign: each has a spring and a damper of its own, both have the same dry friction.

use sealegs::actuator::ActuatorSpec;
use sealegs::model::Signal;
use sealegs::reference::campaign::{Draws, Hidden, Individual, Rig};
use sealegs::sysid::units::split;
use sealegs::{Bench, Campaign, Error, Options, Role, RunColumns, add, compare, diagnose};
use std::path::Path;

/// Rows per second, and steps of the reference integrator in a row: 20 us.
const RATE_HZ: f64 = 500.0;
const SUBSTEPS: usize = 100;

/// Noise of both load cells, N, and of the rotor's encoder, rad.
const NOISE_N: f64 = 2.0;
const NOISE_RAD: f64 = 4.4e-4;

/// The dry friction at both rotors, N.
const FRICTION_N: f64 = 40.0;

/// How the units differ from the nominal actuator.
const UNITS: [(&str, f64, f64); 2] = [("left", 1.03, 1.08), ("right", 0.96, 0.9)];

fn individual(stiffness: f64, damping: f64) -> Individual {
    Individual { stiffness, damping, ..Individual::NOMINAL }
}

/// Currents of a run, A: a chirp and a slow sine, of another size and phase where it is held out.
fn command(held_out: bool) -> Vec<f64> {
    let (size, phase) = if held_out { (0.8, 1.0) } else { (1.0, 0.0) };
    (0..(3.0 * RATE_HZ) as usize)
        .map(|n| {
            let t = n as f64 / RATE_HZ;
            size * (1.6 * (6.3 * t * (0.5 + 6.0 * t) + phase).sin() + 1.2 * (5.0 * t + phase).sin())
        })
        .collect()
}

/// One run of a unit, by the reference integrator.
fn run(unit: &str, individual: &Individual, held_out: bool, noise: &mut Draws) -> RunColumns {
    let spec = ActuatorSpec::preset("thor-linear").expect("a preset");
    let friction =
        Hidden { id: "coulomb-friction".to_owned(), parameters: vec![("force_n", FRICTION_N)], beyond: None };
    let machine = friction.put_into(individual.on(&spec, Rig::Locked.bench()));
    let current = command(held_out);
    let truth = machine.run(1.0 / RATE_HZ, &current, SUBSTEPS);
    let mut noisy = |values: Vec<f64>, std: f64| -> Vec<f64> {
        values.into_iter().map(|v| v + std * noise.normal()).collect()
    };
    // Load cells alone know the spring only as far as the force constant's ratio to it: the encoder says how far it gives.
    let angle = truth.extension.iter().map(|x| x / machine.travel_per_rad).collect();
    let columns = vec![
        ("time_s", (0..current.len()).map(|n| n as f64 / RATE_HZ).collect()),
        ("force_1_n", noisy(truth.force_1, NOISE_N)),
        ("force_2_n", noisy(truth.force_2, NOISE_N)),
        ("motor_angle_rad", noisy(angle, NOISE_RAD)),
        ("current_a", current),
    ];
    let (role, what) = if held_out { (Role::Holdout, "check") } else { (Role::Fit, "fit") };
    RunColumns::new(format!("{unit}_{what}"), role, columns).unit(unit)
}

fn campaign() -> Campaign {
    let mut noise = Draws::of(5, "noise of two units");
    let builder = Campaign::builder("two legs", Bench::Locked, "thor-linear")
        .noise_std("force_1_n", NOISE_N)
        .noise_std("force_2_n", NOISE_N)
        .noise_std("motor_angle_rad", NOISE_RAD);
    let runs = UNITS.iter().flat_map(|(unit, stiffness, damping)| {
        let individual = individual(*stiffness, *damping);
        [false, true].map(|held_out| run(unit, &individual, held_out, &mut noise))
    });
    let runs: Vec<RunColumns> = runs.collect();
    runs.into_iter().fold(builder, sealegs::CampaignBuilder::run).build().expect("a campaign")
}

/// What the reference integrator was given.
fn truth(unit: &str, parameter: &str) -> f64 {
    let spec = ActuatorSpec::preset("thor-linear").expect("a preset");
    let (_, stiffness, damping) = UNITS.iter().find(|u| u.0 == unit).expect("a unit");
    let base = individual(*stiffness, *damping).base_parameters(&spec);
    base.iter().find(|(name, _)| *name == parameter).expect("a parameter").1
}

#[test]
fn reference_two_units_share_the_effect_and_keep_their_springs() {
    let campaign = campaign();
    let verdict = diagnose(&campaign, Options::new()).expect("a verdict");
    let outcome = verdict.outcome();
    assert_eq!(outcome.effects, ["coulomb-friction"], "{}", outcome.sentence);
    let units = outcome.units.as_ref().expect("units");
    assert_eq!(units.holds, Some(true), "{units:?}");
    for (said, (unit, ..)) in units.each.iter().zip(UNITS) {
        assert_eq!(said.unit, unit);
        assert_eq!(said.holds, Some(true), "{said:?}");
        assert!(said.taken_share > Some(0.98), "{said:?}");
        assert!(said.holdout_error_before > Some(2.0) && said.holdout_error_after < Some(1.1), "{said:?}");
    }
    let spring = units.differing.iter().find(|d| d.parameter == "stiffness");
    let spring = spring.unwrap_or_else(|| panic!("no different springs: {}", verdict.to_text()));
    assert_eq!(spring.unit, "N/m");
    assert!(spring.standard_errors > 3.0, "{spring:?}");
    for value in &spring.values {
        // A load cell's gain is known to 1 %, and the stiffness by the frequency of the resonance.
        let truth = truth(&value.unit, "stiffness");
        assert!((value.value / truth - 1.0).abs() < 0.03, "{value:?}, not {truth}");
    }
    let after = outcome.after.as_ref().expect("a model with the effect");
    let friction = after.parameters.iter().filter(|p| p.name.starts_with("coulomb-friction"));
    let friction: Vec<f64> = friction.map(|p| p.value).collect();
    assert_eq!(friction.len(), 1, "one friction for both");
    assert!((friction[0] / FRICTION_N - 1.0).abs() < 0.05, "{friction:?}");
    // Every sensor of every unit is there once.
    assert_eq!(after.sensors.iter().filter(|s| s.of_unit.as_deref() == Some("left")).count(), 3);
    let text = verdict.to_text();
    for words in ["The verdict holds for both units.", "The units differ in stiffness: left", "damping@right"]
    {
        assert!(text.contains(words), "'{words}' in {text}");
    }
    let html = verdict.to_html().expect("a report");
    assert!(html.contains("The verdict holds for both units.") && html.contains(">Units<"), "no section");
    let json: serde_json::Value = serde_json::from_str(&verdict.to_json().expect("JSON")).expect("JSON");
    assert_eq!(json["units"]["each"][1]["unit"], "right");
    // Two fit runs, one of each unit: nothing can be left out.
    assert!(json.get("splits").is_none());
}

#[test]
fn reference_each_unit_gets_a_model_file_that_predicts_its_own_runs() {
    let campaign = campaign();
    let added = add(&["coulomb-friction"], &campaign, Options::new()).expect("an addition");
    let refused = added.model_file(Path::new(".")).expect_err("one file cannot hold two units");
    assert!(matches!(&refused, Error::SeveralUnits { units, .. } if units == &["left", "right"]));
    assert!(refused.is_bad_input() && refused.to_string().contains("'left', 'right'"), "{refused}");
    let unknown = added.model_file_of("middle", Path::new(".")).expect_err("no such unit");
    assert!(unknown.to_string().contains("has no unit 'middle'; it has 'left', 'right'"), "{unknown}");
    assert_eq!(added.summary().units.as_ref().map(|u| u.each.len()), Some(2));
    for (unit, ..) in UNITS {
        let text = added.model_file_of(unit, Path::new(".")).expect("a file");
        assert!(!text.contains('@'), "{text}");
        let spec = ActuatorSpec::from_toml(&text, "better.toml").expect("it loads again");
        let stiffness = spec.parameters["stiffness"].value.expect("a value");
        assert!(
            (stiffness / truth(unit, "stiffness") - 1.0).abs() < 0.03,
            "{unit}: {stiffness}, not {}",
            truth(unit, "stiffness")
        );
        assert_eq!(spec.provenance["unit"], unit);
        // As it is, without a refit, it predicts the unit's own runs.
        let mut own = campaign.clone();
        own.runs.retain(|run| run.unit.as_deref() == Some(unit));
        let as_is = compare(&own, Options::new().model(spec).as_is(true)).expect("a comparison");
        assert!(as_is.summary().given.holdout_error < Some(1.1), "{:?}", as_is.summary().given);
        assert!(as_is.summary().units.is_none());
    }
}

#[test]
fn reference_a_comparison_says_in_what_units_differ_before_anything_is_searched() {
    let mut campaign = campaign();
    let comparison = compare(&campaign, Options::new()).expect("a comparison");
    let units = comparison.summary().units.as_ref().expect("units");
    assert!(units.holds.is_none() && units.each.iter().all(|u| u.holds.is_none()));
    assert!(units.each.iter().all(|u| u.holdout_error_after <= u.holdout_error_before), "{units:?}");
    let names = comparison.summary().base.parameters.iter().map(|p| split(&p.name));
    assert!(names.clone().any(|name| name == ("stiffness", Some("left"))), "{:?}", names.collect::<Vec<_>>());
    assert!(comparison.to_html().expect("a report").contains(">Units<"));
    assert!(comparison.to_text().expect("a text").contains("Units, held-out error in noise units"));
    // Without a refit the units have the errors that they have, and no values.
    let as_is = compare(&campaign, Options::new().as_is(true)).expect("a comparison");
    let units = as_is.summary().units.as_ref().expect("units");
    assert!(units.differing.is_empty() && units.each.len() == 2);
    // Twins under one command are no repeats of one run: what differs between them is no noise floor.
    assert!(campaign.repeats.is_empty() && campaign.noise_floor() == 1.0);
    // A run of no unit beside others is refused.
    campaign.runs[0].unit = None;
    let refused = compare(&campaign, Options::new()).expect_err("a run without a unit");
    assert!(refused.is_bad_input() && refused.to_string().contains("left_fit"), "{refused}");
}

/// The record of a unit's run reads as any other.
#[test]
fn a_unit_is_no_column() {
    let campaign = campaign();
    let names = |signals: &[Signal]| signals.iter().map(|s| s.channel.clone()).collect::<Vec<_>>();
    assert_eq!(names(&campaign.runs[0].record.outputs), ["force_1_n", "force_2_n", "motor_angle_rad"]);
    assert_eq!(campaign.runs[3].unit.as_deref(), Some("right"));
}
