//! What holds for every effect of the catalogue, unasked: cards, neutral values, passivity, sticking.

use std::collections::BTreeSet;

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, OUTPUTS, PendulumRig};
use sealegs_actuator::effect::CATALOGUE;
use sealegs_actuator::excitation::Profile;
use sealegs_actuator::plant::Grid;
use sealegs_model::{EffectCard, Excitation, InputHold, Model, Record, Signal, SignalRange, internal};

const PRESETS: [&str; 3] = ["thor-linear", "rmd-x8-rotary-sea", "mass-spring-damper"];

fn benches() -> [Bench; 2] {
    [Bench::Locked, Bench::Pendulum(PendulumRig::default())]
}

fn model(preset: &str, bench: Bench) -> BenchModel {
    let spec = ActuatorSpec::preset(preset).unwrap_or_else(|e| panic!("{e}"));
    BenchModel::new(spec, bench).unwrap_or_else(|e| panic!("{e}"))
}

fn channels(model: &dyn Model) -> Vec<String> {
    OUTPUTS.iter().filter(|c| model.predicts(c)).map(|c| (*c).to_owned()).collect()
}

/// What was seen, in the sizes of THOR's bench.
fn seen(model: &dyn Model) -> Excitation {
    let range =
        |name: &str, peak: f64| SignalRange { name: name.to_owned(), min: -peak, max: peak, rms: peak };
    Excitation {
        measured: channels(model),
        ranges: vec![
            range(internal::MOTOR_FORCE, 1200.0),
            range(internal::SCREW_SPEED, 0.05),
            range(internal::SPRING_DEFLECTION, 2e-3),
        ],
        sample_period_s: 1e-3,
    }
}

fn record(values: Vec<f64>, input: &str) -> Record {
    Record {
        name: "test".to_owned(),
        time_s: (0..values.len()).map(|n| n as f64 * 1e-3).collect(),
        hold: InputHold::ZeroOrder,
        inputs: vec![Signal { channel: input.to_owned(), values }],
        outputs: Vec::new(),
    }
}

fn noise(samples: usize, rms: f64, seed: u64) -> Vec<f64> {
    let time_s: Vec<f64> = (0..samples).map(|n| n as f64 * 1e-3).collect();
    Profile::Noise { rms, bandwidth_hz: 40.0, seed }.sample(&time_s)
}

fn values(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

fn cards(model: &dyn Model) -> Vec<EffectCard> {
    model.effects(&seen(model)).into_iter().filter(|card| !card.id.contains('@')).collect()
}

#[test]
fn ids_are_unique_and_kebab_case_and_all_of_the_catalogue() {
    let mut ids = BTreeSet::new();
    for card in cards(&model("thor-linear", benches()[1])) {
        let kebab = card.id.split('-').all(|w| !w.is_empty() && w.chars().all(|c| c.is_ascii_lowercase()));
        assert!(kebab, "{}", card.id);
        assert!(ids.insert(card.id.clone()), "{} twice", card.id);
    }
    // All of the catalogue but what belongs to a bridge (dead zone, sag) and to a servo's loop.
    assert_eq!(ids.len(), CATALOGUE.len() - 3, "{ids:?}");
}

#[test]
fn every_card_is_filled_and_its_numbers_make_sense() {
    for preset in PRESETS {
        for bench in benches() {
            for card in model(preset, bench).effects(&seen(&model(preset, bench))) {
                let texts = [&card.summary, &card.acts_on, &card.equation, &card.validity, &card.reference];
                assert!(texts.iter().all(|t| t.len() > 2), "{card:?}");
                assert!(card.symbols.contains(": "), "{card:?}");
                let guide = [&card.told_apart, &card.cure];
                assert!(guide.iter().all(|t| t.ends_with('.') && t.len() > 40), "{card:?}");
                assert!(!card.parameters.is_empty(), "{card:?}");
                // At least one parameter switches the effect off.
                assert!(card.parameters.iter().any(|p| p.neutral.is_some()), "{}", card.id);
                for p in &card.parameters {
                    let unit = ["coefficient", "asymmetry", "cycles_per_rev", "rounding", "damping_ratio"]
                        .iter()
                        .chain(&["participation", "fall", "driving_coefficient", "driven_coefficient"])
                        .any(|ratio| p.name == *ratio)
                        || (card.id == "load-dependent-friction")
                        || !p.unit.is_empty()
                        || p.name.ends_with("count")
                        || p.name.ends_with("limit");
                    assert!(unit, "{} has no unit: {p:?}", card.id);
                    let within = p.min <= p.value && p.value <= p.max && p.min < p.max;
                    assert!(within && p.typical > 0.0 && p.typical.is_finite(), "{} {p:?}", card.id);
                    assert!(p.starts.iter().all(|s| (p.min..=p.max).contains(s)), "{} {p:?}", card.id);
                }
            }
        }
    }
}

#[test]
fn neutral_values_reproduce_the_baseline() {
    for preset in PRESETS {
        for bench in benches() {
            let base = model(preset, bench);
            let input = if preset == "rmd-x8-rotary-sea" { "motor_torque_nm" } else { "current_a" };
            let record = record(noise(400, 2.0, 3), input);
            let channels = channels(&base);
            let truth = base.predict(&values(&base), &record, &channels).expect("finite").outputs;
            for card in base.effects(&seen(&base)) {
                let with = base.with_effect(&card.id, &seen(&base)).unwrap_or_else(|e| panic!("{e}"));
                let mut all = values(&*with);
                let first = all.len() - card.parameters.len();
                for (value, p) in all[first..].iter_mut().zip(&card.parameters) {
                    *value = p.neutral.unwrap_or(p.value);
                }
                let got = with.predict(&all, &record, &channels).expect("finite").outputs;
                for (got, truth) in got.iter().zip(&truth) {
                    let peak = truth.values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                    let off = got.values.iter().zip(&truth.values).map(|(g, t)| (g - t).abs());
                    let off = off.fold(0.0, f64::max);
                    // The forces at neutral are zero, and adding zero changes no bit.
                    assert!(
                        off == 0.0,
                        "{preset} {bench:?} {}: {} by {off:e} of {peak}",
                        card.id,
                        got.channel
                    );
                }
            }
        }
    }
}

#[test]
fn richer_laws_become_the_simpler_ones_that_they_name() {
    let base = model("thor-linear", benches()[0]);
    let record = record(noise(400, 2.0, 3), "current_a");
    let channels = channels(&base);
    let mut named = 0;
    for card in base.effects(&seen(&base)) {
        let Some(law) = &card.becomes else { continue };
        named += 1;
        let predicted = |id: &str, own: Vec<f64>| {
            let with = base.with_effect(id, &seen(&base)).unwrap_or_else(|e| panic!("{e}"));
            let all: Vec<f64> = values(&base).into_iter().chain(own).collect();
            with.predict(&all, &record, &channels).expect("finite").outputs
        };
        let mut own: Vec<f64> = card.parameters.iter().map(|p| p.value).collect();
        own[law.departure] = law.like.map_or(0.0, |i| own[i]);
        let simpler = base.effects(&seen(&base)).into_iter().find(|c| c.id == law.id).expect("a card");
        let strength = vec![own[0]; simpler.parameters.len()];
        assert_eq!(predicted(&card.id, own), predicted(law.id, strength), "{}", card.id);
    }
    assert_eq!(named, 4);
}

/// Greatest excess of energy over the motor's work, relative to the greatest energy, at a step.
fn excess(model: &BenchModel, values: &[f64], command: &[f64], step_s: f64) -> f64 {
    let plant = model.plant(values, "current_a").unwrap_or_else(|e| panic!("{e}"));
    let per_sample = (1e-3 / step_s).round() as usize;
    let commands: Vec<f64> = command.iter().flat_map(|c| std::iter::repeat_n(*c, per_sample)).collect();
    let grid = Grid { start_s: 0.0, step_s, steps: commands.len() };
    let ledger = plant.energy(grid, &commands).unwrap_or_else(|e| panic!("{e}"));
    let energy: Vec<f64> = ledger.kinetic.iter().zip(&ledger.stored).map(|(k, s)| k + s).collect();
    let most = energy.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
    // From any earlier point on, not only from the start: what was lost is not to be won back.
    let mut least = f64::INFINITY;
    let mut excess: f64 = 0.0;
    for (energy, work) in energy.iter().zip(&ledger.motor_work) {
        least = least.min(energy - work);
        excess = excess.max(energy - work - least);
    }
    excess / most
}

#[test]
fn energy_passive_effects_never_add_any() {
    for bench in benches() {
        let mut base = model("thor-linear", bench);
        let command = noise(1000, 2.5, 11);
        let mut passive: Vec<String> = cards(&base).into_iter().filter(|c| c.passive).map(|c| c.id).collect();
        passive.insert(0, String::new());
        for id in passive {
            if !id.is_empty() {
                let mut spec = base.spec().clone();
                spec.effects = vec![sealegs_actuator::spec::EffectSpec {
                    id: id.clone(),
                    parameters: std::collections::BTreeMap::new(),
                    definition: None,
                }];
                base = BenchModel::new(spec, bench).unwrap_or_else(|e| panic!("{e}"));
            }
            let guesses: Vec<f64> = if id.is_empty() {
                Vec::new()
            } else {
                let plain = model("thor-linear", bench);
                let card = cards(&plain).into_iter().find(|c| c.id == id).expect("a card");
                card.parameters.iter().map(|p| p.value).collect()
            };
            let own = base.parameters().iter().filter(|p| !p.name.contains('.'));
            // Without the base model's own damping, which would cover what an effect adds.
            let base_values = own.map(|p| if p.name == "damping" { 0.0 } else { p.value });
            let all: Vec<f64> = base_values.chain(guesses).collect();
            let (coarse, fine) = (excess(&base, &all, &command, 1e-4), excess(&base, &all, &command, 5e-5));
            assert!(coarse < 2e-3, "{bench:?} {id}: {coarse:e} of the energy is won");
            // 1e-8: rounding of a stiff spring's energy.
            assert!(fine < 0.7 * coarse + 1e-8, "{bench:?} {id}: {coarse:e} {fine:e}");
        }
    }
}

/// A friction of the rotor below whose bound a constant push must not move it; values, least bound in N.
const RUBBING: [(&str, &[f64]); 4] = [
    ("coulomb-friction", &[60.0]),
    ("stribeck-friction", &[30.0, 60.0, 0.004]),
    ("direction-dependent-friction", &[80.0, 0.25]),
    ("output-friction", &[5.0]),
];

#[test]
fn dry_friction_holds_without_creep() {
    for bench in benches() {
        let base = model("thor-linear", bench);
        for (id, own) in RUBBING {
            if id == "output-friction" && bench == Bench::Locked {
                continue;
            }
            let with = base.with_effect(id, &seen(&base)).unwrap_or_else(|e| panic!("{e}"));
            let all: Vec<f64> = values(&base).into_iter().chain(own.iter().copied()).collect();
            let angle = if id == "output-friction" { "joint_angle_rad" } else { "motor_angle_rad" };
            for current in [0.2, -0.2] {
                // 48 N for ten seconds.
                let record = record(vec![current; 10_000], "current_a");
                let prediction = with.predict(&all, &record, &[angle.to_owned()]).expect("finite");
                assert!(prediction.outputs[0].values.iter().all(|v| *v == 0.0), "{bench:?} {id}");
            }
            // Pushed beyond the bound, let go within it: it comes to rest and then stays to the last bit.
            let mut command = vec![2.0; 300];
            command.extend(vec![0.0; 4000]);
            let prediction =
                with.predict(&all, &record(command, "current_a"), &[angle.to_owned()]).expect("finite");
            let values = &prediction.outputs[0].values;
            if bench == Bench::Locked {
                assert!(values[4299] != 0.0 && values[3300..].iter().all(|v| *v == values[4299]), "{id}");
            }
        }
    }
}

#[test]
fn two_frictions_hold_together() {
    let mut spec = ActuatorSpec::preset("thor-linear").expect("preset");
    for configuration in
        [sealegs_actuator::Configuration::SprungMotorHousing, sealegs_actuator::Configuration::Lumped]
    {
        spec.configuration = configuration;
        let base = BenchModel::new(spec.clone(), benches()[1]).expect("good");
        let both = base.with_effect("coulomb-friction", &seen(&base)).expect("an effect");
        let both = both.with_effect("output-friction", &seen(&base)).expect("an effect");
        let all: Vec<f64> = values(&base).into_iter().chain([60.0, 3.0]).collect();
        let angles = ["motor_angle_rad", "joint_angle_rad"].map(str::to_owned);
        let held = both.predict(&all, &record(vec![0.2; 5000], "current_a"), &angles).expect("finite");
        assert!(held.outputs.iter().all(|s| s.values.iter().all(|v| *v == 0.0)), "{configuration:?}");
    }
}
