//! Every effect at every place of the legs: ids, cards, neutral values, energy; and the leg as a model.

use sealegs_actuator::effect::{CommandKind, Setting, is_of_actuator};
use sealegs_actuator::spec::{EffectSpec, EffectValue};
use sealegs_leg::effect::CATALOGUE;
use sealegs_leg::model::LegModel;
use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::{Observer, Sample};
use sealegs_leg::{LegError, channels, run};
use sealegs_model::{Excitation, InputHold, Model, Prediction, Record, Signal};
use std::collections::BTreeSet;

/// A drop that has landed after 60 ms.
const DROP: &str = "robot = \"thor-leg\"\nduration_s = 0.12\nstep_s = 2e-4\n[base]\nkind = \"rail\"\n\
    carriage_mass_kg = 20.0\n[start]\ndrop_height_m = 0.015\n\
    posture_rad = { hip_pitch = -0.45, knee = 0.90, ankle_pitch = -0.45 }\n[ground]\n";

fn scenario(more: &str) -> Scenario {
    Scenario::from_toml(&format!("{DROP}{more}"), "drop.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn model(scenario: &Scenario) -> LegModel {
    LegModel::new(scenario.clone(), scenario, Vec::new(), Vec::new()).unwrap_or_else(|e| panic!("{e}"))
}

fn record(seconds: f64, inputs: Vec<Signal>) -> Record {
    let time_s = (0..=(seconds * 1e3).round() as usize).map(|i| i as f64 * 1e-3).collect();
    Record {
        cut: false,
        name: "run.csv".to_owned(),
        time_s,
        hold: InputHold::ZeroOrder,
        inputs,
        outputs: Vec::new(),
    }
}

fn names() -> Vec<String> {
    ["knee.angle_rad", "ankle_roll.angle_rad", "knee.force_1_n", "ankle_outer.force_2_n", "knee.current_a"]
        .iter()
        .chain(&["hip_pitch.rotor_angle_rad", "base.height_m", "foot.normal_force_n"])
        .map(|name| (*name).to_owned())
        .collect()
}

fn values(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

fn predict(model: &dyn Model, values: &[f64], seconds: f64) -> Prediction {
    model.predict(values, &record(seconds, Vec::new()), &names()).unwrap_or_else(|e| panic!("{e}"))
}

fn seen() -> Excitation {
    Excitation { measured: names(), ranges: Vec::new(), sample_period_s: 1e-3 }
}

#[test]
fn every_effect_has_a_place_a_full_card_and_few_starts() {
    let leg = model(&scenario(""));
    let cards = leg.effects(&seen());
    let mut ids = BTreeSet::new();
    for card in &cards {
        assert!(ids.insert(card.id.clone()), "{} twice", card.id);
        assert!(
            card.id.split_once('/').is_some_and(|(place, effect)| !place.is_empty() && !effect.is_empty())
        );
        let texts = [&card.summary, &card.acts_on, &card.equation, &card.validity, &card.reference];
        assert!(texts.iter().all(|t| t.len() > 2), "{card:?}");
        assert!(card.symbols.contains(": "), "{card:?}");
        let guide = [&card.told_apart, &card.cure];
        assert!(guide.iter().all(|t| t.ends_with('.') && t.len() > 40), "{card:?}");
        assert!(card.parameters.iter().any(|p| p.neutral.is_some()), "{}", card.id);
        let starts: usize = card.parameters.iter().map(|p| 1 + p.starts.len()).product();
        assert!(starts <= 8 || card.is_periodic(), "{}: {starts} starts", card.id);
        for p in &card.parameters {
            let within = p.min <= p.value && p.value <= p.max && p.min < p.max;
            assert!(within && p.typical > 0.0 && p.typical.is_finite(), "{} {p:?}", card.id);
            assert!(p.starts.iter().all(|s| (p.min..=p.max).contains(s)), "{} {p:?}", card.id);
        }
    }
    for id in [
        "knee/coulomb-friction",
        "ankle_outer/backlash",
        "hip_pitch/transport-delay",
        "ankle_pitch/output-friction",
        "knee/joint-stop",
        "foot/contact-compliance",
        "foot/ground-friction",
        "shank/link-mass",
        "knee/spring-setting",
        "knee/sensor-lag",
        "foot/sensor-delay",
    ] {
        assert!(ids.contains(id), "{id} is missing: {ids:?}");
    }
    for own in CATALOGUE {
        assert!(ids.iter().any(|id| id.ends_with(&format!("/{}", own.id()))), "{}", own.id());
    }
    // Of the actuators' catalogue a leg has what acts in an actuator and needs no bridge, and nothing else.
    for effect in sealegs_actuator::effect::CATALOGUE {
        let id = effect.card(&Setting::unknown()).id;
        // The knee is a joint, too, with friction of its own.
        if CATALOGUE.iter().any(|own| own.id() == id) {
            continue;
        }
        let offered = ids.contains(&format!("knee/{id}"));
        let setting = Setting {
            command: CommandKind::Current,
            force_per_command: 240.0,
            base_is_held: false,
            ..Setting::unknown()
        };
        assert_eq!(offered, is_of_actuator(*effect) && effect.applies(&setting), "{id}");
    }
}

#[test]
fn a_finer_model_can_be_made_finer_again() {
    let leg = model(&scenario(""));
    let finer = leg.finer().expect("a finer one");
    let finest = finer.finer().expect("a finer one");
    let of = |model: &dyn Model| predict(model, &values(&leg), 0.1).outputs;
    let apart = |a: &[Signal], b: &[Signal]| {
        let force = |s: &[Signal]| {
            s.iter().find(|s| s.channel == "foot.normal_force_n").expect("a force").values.clone()
        };
        force(a).iter().zip(force(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (usual, once, twice) = (of(&leg), of(finer.as_ref()), of(finest.as_ref()));
    let (first, second) = (apart(&usual, &once), apart(&once, &twice));
    assert!(0.0 < second && second < 0.7 * first, "{first} and {second} N");
}

#[test]
fn neutral_values_change_no_bit() {
    let leg = model(&scenario(""));
    let truth = predict(&leg, &values(&leg), 0.08).outputs;
    for card in leg.effects(&seen()) {
        let with = leg.with_effect(&card.id, &seen()).unwrap_or_else(|e| panic!("{e}"));
        let mut all = values(&*with);
        let first = all.len() - card.parameters.len();
        for (value, p) in all[first..].iter_mut().zip(&card.parameters) {
            *value = p.neutral.unwrap_or(p.value);
        }
        assert!(predict(&*with, &all, 0.08).outputs == truth, "{}", card.id);
    }
}

#[test]
fn a_gap_below_zero_is_none() {
    let leg = model(&scenario(""));
    let with = leg.with_effect("ankle_inner/backlash", &seen()).unwrap_or_else(|e| panic!("{e}"));
    let of_gap = |gap_m: f64| {
        let mut all = values(&*with);
        *all.last_mut().expect("a gap") = gap_m;
        predict(&*with, &all, 0.08).outputs
    };
    assert!(of_gap(-4e-4) == of_gap(0.0) && of_gap(4e-4) != of_gap(0.0));
}

/// Kinetic and potential energy against the energy at the start.
#[derive(Default)]
struct Energy {
    worst_gain_j: f64,
    turnover_j: f64,
}

impl Observer for Energy {
    fn sample(&mut self, s: &Sample) -> Result<(), LegError> {
        // What springs hold is not negative, whatever their law.
        let gain = s.energy.kinetic_j + s.energy.potential_j - s.energy.initial_j;
        self.worst_gain_j = self.worst_gain_j.max(gain);
        self.turnover_j = self.turnover_j.max(s.energy.turnover_j);
        Ok(())
    }
}

#[test]
fn energy_no_passive_effect_gives_any() {
    let leg = model(&scenario(""));
    for card in leg.effects(&seen()).into_iter().filter(|c| c.passive) {
        let with = leg.including(&card.id, &seen()).unwrap_or_else(|e| panic!("{e}"));
        let scenario = with.fitted_scenario(&values(&with), &[]);
        let mut energy = Energy::default();
        run(&scenario, &mut energy).unwrap_or_else(|e| panic!("{}: {e}", card.id));
        // The placement of the sprung masses is off by this much, at this step, without any effect.
        assert!(energy.worst_gain_j < 2e-3 * energy.turnover_j, "{}: {}", card.id, energy.worst_gain_j);
        assert!(energy.turnover_j > 1.0, "{}: {}", card.id, energy.turnover_j);
    }
}

#[test]
fn a_prediction_is_the_run_itself_and_nearer_with_the_step() {
    let friction = "[[effect]]\nid = \"knee/coulomb-friction\"\nparameters = { force_n = 80.0 }\n";
    let robot = || Robot::load("thor-leg", None).expect("embedded");
    // Fits move the bodies otherwise than runs do. Greatest difference of every channel in shares of its peak.
    let apart = |step_s: f64| {
        let scenario = Scenario { step_s, ..scenario(friction) };
        let leg = model(&scenario).with_step(step_s);
        assert_eq!(leg.included(), ["knee/coulomb-friction"]);
        let predicted = predict(&leg, &values(&leg), scenario.duration_s);
        let (run, _) = channels(&scenario, robot()).expect("runs");
        let share = |signal: &Signal| {
            let values = run.get(&signal.channel).expect("a channel");
            let off = signal.values.iter().zip(values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            off / values.iter().fold(1e-9, |m: f64, v| m.max(v.abs()))
        };
        predicted.outputs.iter().map(share).collect::<Vec<f64>>()
    };
    for ((name, coarse), fine) in names().iter().zip(apart(1e-4)).zip(apart(2.5e-5)) {
        // Nothing is commanded here.
        if name == "knee.current_a" {
            assert_eq!((coarse, fine), (0.0, 0.0));
            continue;
        }
        assert!(coarse < 1e-3 && fine < 0.5 * coarse, "{name}: {coarse:e} {fine:e}");
    }
    let scenario = scenario(friction);
    let (run, _) = channels(&scenario, robot()).expect("runs");
    let without = Scenario { effects: Vec::new(), ..scenario.clone() };
    let (plain, _) = channels(&without, robot()).expect("runs");
    assert!(plain.get("knee.force_1_n") != run.get("knee.force_1_n"));
}

/// THOR's leg whose knee has an actuator file with this effect.
fn with_knee_effect(id: &str, parameters: &[(&str, f64)]) -> Robot {
    let mut robot = Robot::load("thor-leg", None).expect("embedded");
    let knee = robot.actuators.iter_mut().find(|a| a.name == "knee").expect("a knee");
    let value = |v: f64| EffectValue { value: v, std: None };
    let parameters = parameters.iter().map(|(name, v)| ((*name).to_owned(), value(*v))).collect();
    let effect = EffectSpec { id: id.to_owned(), parameters, definition: None };
    knee.spec.as_mut().expect("its file").effects.push(effect);
    robot
}

#[test]
fn an_actuator_files_effects_come_with_it() {
    let named = scenario("[[effect]]\nid = \"knee/coulomb-friction\"\nparameters = { force_n = 80.0 }\n");
    let (wanted, _) = channels(&named, Robot::load("thor-leg", None).expect("embedded")).expect("runs");
    let knee = || wanted.get("knee.force_1_n").expect("a channel");
    let (brought, _) =
        channels(&scenario(""), with_knee_effect("coulomb-friction", &[("force_n", 80.0)])).expect("runs");
    assert_eq!(brought.get("knee.force_1_n"), Some(knee()));
    // What the scenario says of the same effect goes before.
    let (both, _) =
        channels(&named, with_knee_effect("coulomb-friction", &[("force_n", 10.0)])).expect("runs");
    assert_eq!(both.get("knee.force_1_n"), Some(knee()));
    // An effect that belongs to a bench's load is refused, not dropped.
    let refused = channels(&scenario(""), with_knee_effect("output-friction", &[("torque_nm", 1.0)]));
    let message = refused.expect_err("refused").to_string();
    assert!(message.contains("knee") && message.contains("output-friction"), "{message}");
    assert!(message.contains("joints"), "{message}");
    for id in ["wobbling-mass", "cable-stiffness", "load-mismatch", "feedback-delay"] {
        let refused = channels(&scenario(""), with_knee_effect(id, &[]));
        let message = refused.expect_err("refused").to_string();
        assert!(message.contains(id) && message.contains("bench"), "{message}");
    }
}

#[test]
fn recorded_currents_command_as_a_profile_does() {
    let profile = "[current.knee]\nshape = \"sine\"\namplitude = 3.0\nfrequency_hz = 12.0\nphase_rad = 0.0\n";
    let commanded = model(&scenario(profile));
    let at = record(0.08, Vec::new());
    let wave = at.time_s.iter().map(|t| 3.0 * (std::f64::consts::TAU * 12.0 * t).sin()).collect();
    let input = Signal { channel: "knee.current_a".to_owned(), values: wave };
    let names: Vec<String> = names().into_iter().filter(|n| n != "knee.current_a").collect();
    let free = model(&scenario(""));
    let given = free.predict(&values(&free), &record(0.08, vec![input]), &names).expect("runs");
    let wanted = commanded.predict(&values(&commanded), &at, &names).expect("runs");
    for (a, b) in given.outputs.iter().zip(&wanted.outputs) {
        let peak = b.values.iter().fold(1e-6, |m: f64, v| m.max(v.abs()));
        let off = a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // A record's time stamps are decimal digits: a command may come into force a rounding early.
        assert!(off < 1e-6 * peak, "{}: {off:e} of {peak}", a.channel);
    }
    assert!(free.refuses_input("run.csv", "ankle.current_a").is_some_and(|m| m.contains("ankle_outer")));
    assert!(free.refuses_input("run.csv", "knee.target_rad").is_none());
}

#[test]
fn runs_have_scenarios_of_their_own_and_share_the_parts() {
    let low = scenario("");
    let stiff = scenario("[actuators]\nspring = \"stiff\"\n");
    let leg = LegModel::new(low.clone(), &low, vec![("run.csv".to_owned(), stiff.clone())], Vec::new())
        .unwrap_or_else(|e| panic!("{e}"));
    let mut all = values(&leg);
    let knee = leg.parameters().iter().position(|p| p.name == "knee/stiffness").expect("a parameter");
    all[knee] *= 1.1;
    let as_own = predict(&leg, &all, 0.06);
    let of_stiff = model(&stiff);
    let mut own = values(&of_stiff);
    own[knee] *= 1.1;
    for (a, b) in as_own.outputs.iter().zip(&predict(&of_stiff, &own, 0.06).outputs) {
        let off = a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{}: {off:e}", a.channel);
    }
}

#[test]
fn faults_name_the_effect_and_suggest() {
    let message = |text: &str| match LegModel::new(scenario(text), &scenario(""), Vec::new(), Vec::new()) {
        Err(e) => e.to_string(),
        Ok(_) => panic!("{text} is bad"),
    };
    let unknown = message("[[effect]]\nid = \"knee/coulomb-fricton\"\n");
    assert!(unknown.contains("did you mean 'knee/coulomb-friction'"), "{unknown}");
    let parameter = message("[[effect]]\nid = \"knee/backlash\"\nparameters = { gap = 1e-4 }\n");
    assert!(parameter.contains("gap_m"), "{parameter}");
    let twice = "[[effect]]\nid = \"knee/backlash\"\n".repeat(2);
    assert!(message(&twice).contains("twice"));
}
