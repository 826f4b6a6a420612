//! What holds for every effect of the catalogue, unasked: cards, neutral values, passivity, sticking.

use std::collections::BTreeSet;

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, OUTPUTS, PendulumRig, TEMPERATURE};
use sealegs_actuator::effect::{CATALOGUE, Expression, FRICTION_NAMES, Setting};
use sealegs_actuator::excitation::Profile;
use sealegs_actuator::plant::{Grid, Plant, Slip};
use sealegs_model::{
    EffectCard, Excitation, InputHold, Model, Record, Signal, SignalRange, SimplerAt, Unit, internal,
};

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
            range(TEMPERATURE, 40.0),
        ],
        sample_period_s: 1e-3,
    }
}

fn record(values: Vec<f64>, input: &str) -> Record {
    Record {
        cut: false,
        name: "test".to_owned(),
        time_s: (0..values.len()).map(|n| n as f64 * 1e-3).collect(),
        hold: InputHold::ZeroOrder,
        inputs: vec![
            Signal {
                channel: TEMPERATURE.to_owned(),
                values: (0..values.len()).map(|n| 25.0 + 5e-3 * n.min(1000) as f64).collect(),
            },
            Signal { channel: input.to_owned(), values },
        ],
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
    // All of the catalogue but what says that it needs something else, such as a bridge or a servo's loop.
    let seen = seen(&model("thor-linear", benches()[1]));
    let setting = Setting {
        output_moves: true,
        output_arm_m: Some(0.1),
        force_per_command: 240.0,
        seen,
        ..Setting::unknown()
    };
    for effect in CATALOGUE {
        let id = effect.card(&setting).id;
        assert_eq!(ids.contains(&id), effect.applies(&setting), "{id}");
    }
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
                    // A ratio has no unit, and no ending that says one.
                    let unit = !p.unit.is_empty() || Unit::of_channel(&p.name).is_err();
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
        let simpler = base.effects(&seen(&base)).into_iter().find(|c| c.id == law.id).expect("a card");
        let first = card.parameters.iter().zip(&simpler.parameters).all(|(a, b)| a.unit == b.unit);
        assert!(first && simpler.parameters.len() < card.parameters.len(), "{}", card.id);
        let strength = predicted(law.id, vec![own[0]; simpler.parameters.len()]);
        if law.at == SimplerAt::Infinity {
            let apart = |own: &[f64]| -> f64 {
                let squares = |(a, b): (&Signal, &Signal)| -> f64 {
                    a.values.iter().zip(&b.values).map(|(a, b)| (a - b).powi(2)).sum()
                };
                let richer = predicted(&card.id, own.to_vec());
                let angles = richer.iter().zip(&strength).filter(|(s, _)| s.channel == "motor_angle_rad");
                angles.map(squares).sum()
            };
            let (soft, mut stiff) = (apart(&own), own.clone());
            stiff[law.departure] = card.parameters[law.departure].max;
            assert!(apart(&stiff) < 1e-2 * soft, "{}: {} {soft}", card.id, apart(&stiff));
            continue;
        }
        own[law.departure] = law.at.value(|i| own[i]);
        assert_eq!(predicted(&card.id, own), strength, "{}", card.id);
    }
    assert!(named >= 4, "{named}");
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

/// What a bench holds its rotor with at rest at an effect's guesses, N, the weaker way; none where that is no dry friction.
fn holds(base: &BenchModel, card: &EffectCard) -> Option<(Vec<f64>, f64)> {
    let with = base.including(&card.id, &seen(base)).unwrap_or_else(|e| panic!("{e}"));
    let all = values(&with);
    let laws = with.plant(&all, "current_a").unwrap_or_else(|e| panic!("{e}")).laws;
    let bound = |direction| laws.rotor_friction_bound(&Slip { direction, ..Slip::default() });
    let least = bound(1.0).min(bound(-1.0));
    (least > 0.0).then_some((all, least))
}

#[test]
fn dry_friction_holds_without_creep() {
    let mut held = 0;
    for bench in benches() {
        let base = model("thor-linear", bench);
        for card in cards(&base) {
            let on_output = card.id == "output-friction";
            let (all, least) = if on_output {
                (values(&base).into_iter().chain([5.0]).collect(), 60.0)
            } else if let Some(found) = holds(&base, &card) {
                found
            } else {
                continue;
            };
            held += 1;
            let with = base.with_effect(&card.id, &seen(&base)).unwrap_or_else(|e| panic!("{e}"));
            let angle = if on_output { "joint_angle_rad" } else { "motor_angle_rad" };
            let push = 0.8 * least / base.spec().coefficients().force_constant;
            for current in [push, -push] {
                // For ten seconds.
                let record = record(vec![current; 10_000], "current_a");
                let prediction = with.predict(&all, &record, &[angle.to_owned()]).expect("finite");
                let still = prediction.outputs[0].values.iter().all(|v| *v == 0.0);
                assert!(still, "{bench:?} {}", card.id);
            }
            // Pushed beyond the bound, let go within it: it comes to rest and then stays to the last bit.
            let mut command = vec![2.0; 300];
            command.extend(vec![0.0; 4000]);
            let prediction =
                with.predict(&all, &record(command, "current_a"), &[angle.to_owned()]).expect("finite");
            let values = &prediction.outputs[0].values;
            if bench == Bench::Locked {
                let stays = values[3300..].iter().all(|v| *v == values[4299]);
                assert!(values[4299] != 0.0 && stays, "{}", card.id);
            }
        }
    }
    // At least Coulomb, Stribeck, by direction, warming on both, and that of the output.
    assert!(held >= 9, "{held}");
}

#[test]
fn a_friction_says_its_bound_to_other_simulators_as_it_is() {
    let setting = Setting::unknown();
    for effect in CATALOGUE {
        let card = effect.card(&setting);
        let values: Vec<f64> = card.parameters.iter().map(|p| p.value).collect();
        let Some(text) = effect.friction_bound(&values) else { continue };
        let expression =
            Expression::parse(&text, &FRICTION_NAMES).unwrap_or_else(|e| panic!("{text}: {e:?}"));
        let mut plant = Plant::new(1.0, 0.0, 0.0, 1.0);
        effect.install(&values, None, &mut plant);
        for (y, speed, load) in [(0.0, 0.3, 0.0), (0.13, -0.2, 5.0), (-0.4, 0.01, -20.0), (2.3, 1.5, 0.5)] {
            let slip = Slip { position: y, speed, direction: speed.signum(), load, ..Slip::default() };
            let (said, law) = (expression.value(&[y, speed, load]), plant.laws.rotor_friction_bound(&slip));
            assert!((said - law).abs() < 1e-9 * (1.0 + law), "{}: {text}: {said} and {law}", card.id);
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
