//! Damaged actuator and effect files: whatever the text, reading ends soon with a model that can be simulated
//! without panic, or with a message that names the file.

use proptest::prelude::*;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs_actuator::effect::{Effect, Expression, OwnEffect};
use sealegs_actuator::{ActuatorError, ActuatorSpec};
use sealegs_damage::{cases, damaged, survives};
use sealegs_model::{Excitation, InputHold, Model, Record, Signal};
use std::sync::Arc;

const OWN: &str = "id = \"belt-drag\"\nacts-on = \"rotor\"\nlaw = \"a*y_dot + b*abs(F_bs)*tanh(y_dot/v0)\"\n\
    [parameters]\na = { guess = 10.0, min = 0.0, max = 1e4, unit = \"N s/m\" }\n\
    b = { guess = 0.01, min = 0.0, max = 1.0 }\nv0 = { fixed = 1e-3 }\n";

/// The text after damage, if it still is one: readers take text.
fn text(bytes: Vec<u8>) -> String {
    String::from_utf8_lossy(&bytes).into_owned()
}

fn names(file: &str, error: &ActuatorError) {
    let message = error.to_string();
    assert!(message.contains(file), "{message:?}");
}

/// Simulates a tenth of a second of the model; a state that runs away is an error, not a panic.
fn simulate(model: &dyn Model) {
    for channel in model.inputs() {
        let record = Record {
            cut: false,
            name: "r".to_owned(),
            time_s: (0..50).map(|i| 2e-3 * f64::from(i)).collect(),
            hold: InputHold::ZeroOrder,
            inputs: vec![Signal {
                channel: (*channel).to_owned(),
                values: (0..50).map(|i| f64::from(i % 9) - 4.0).collect(),
            }],
            outputs: Vec::new(),
        };
        let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
        let _ = model.predict(&values, &record, &["force_1_n".to_owned()]);
        let _ = model.predict(&values, &record, &["spring_deflection_rad".to_owned()]);
    }
}

/// Laws that damage begins with.
const LAWS: [&str; 4] = [
    "a*y_dot + b*abs(F_bs)*tanh(y_dot/v0)",
    "-a^2^-y_dot*max(min(F_bs, 1.5e3), -square(b)) - (sqrt(abs(v0)) + ln(exp(b)))/(1 + cos(2*pi*y_dot)^2)",
    "((((((((((((a))))))))))))*-(-(-(-(-(-b)))))",
    "sign(y_dot)*(a + (b - a)*exp(-(y_dot/v0)^2))",
];

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn a_damaged_actuator_file_is_simulated_or_refused(
        bytes in (0..ActuatorSpec::preset_names().len()).prop_flat_map(|i| {
            damaged(ActuatorSpec::preset_text(ActuatorSpec::preset_names()[i]).unwrap().as_bytes())
        }),
        pendulum in any::<bool>(),
    ) {
        survives(move || {
            let bench = if pendulum { Bench::Pendulum(PendulumRig::default()) } else { Bench::Locked };
            match ActuatorSpec::from_toml(&text(bytes), "own.toml") {
                Ok(spec) => {
                    let _ = ActuatorSpec::from_toml(&spec.to_toml(), "again.toml");
                    if let Ok(model) = BenchModel::new(spec, bench) {
                        simulate(&model);
                    }
                }
                Err(error) => names("own.toml", &error),
            }
        });
    }

    #[test]
    fn a_damaged_effect_file_is_simulated_or_refused(bytes in damaged(OWN.as_bytes())) {
        survives(move || match OwnEffect::from_toml(&text(bytes), "own.toml") {
            Ok(effect) => {
                let spec = ActuatorSpec::preset("thor-linear").unwrap();
                let id = effect.table()["id"].as_str().unwrap().to_owned();
                let own: Vec<Arc<dyn Effect>> = vec![Arc::new(effect)];
                let model = BenchModel::with_own_effects(spec, Bench::Locked, own).unwrap();
                if let Ok(model) = model.with_effect(&id, &Excitation::default()) {
                    simulate(model.as_ref());
                }
            }
            Err(error) => names("own.toml", &error),
        });
    }

    #[test]
    fn no_law_makes_the_reader_panic(law in "[a-c0-9+*/^().,eyFx_ -]{0,60}") {
        let text = OWN.replace("a*y_dot + b*abs(F_bs)*tanh(y_dot/v0)", &law);
        if let Err(error) = OwnEffect::from_toml(&text, "own.toml") {
            names("own.toml", &error);
        }
    }

    #[test]
    fn a_damaged_law_is_compiled_or_refused(
        bytes in prop_oneof![
            (0..LAWS.len()).prop_flat_map(|i| damaged(LAWS[i].as_bytes())),
            r"([a-z0-9+*/^(),. -]|y_dot|F_bs|tanh\(|min\(|1e|-|\(|v0){0,200}".prop_map(String::into_bytes),
            prop_oneof![Just("("), Just("-"), Just("a^"), Just("sin("), Just("min(a,"), Just("1+(")]
                .prop_flat_map(|part| (0_usize..900).prop_map(move |n| part.repeat(n).into_bytes())),
        ],
        values in prop::array::uniform5(any::<f64>()),
    ) {
        survives(move || {
            let law = text(bytes);
            match Expression::parse(&law, &["y_dot", "F_bs", "a", "b", "v0"]) {
                Ok(compiled) => {
                    let value = compiled.value(&values);
                    match compiled.checked(&values) {
                        Ok(checked) => assert_eq!(checked.to_bits(), value.to_bits(), "{law}"),
                        Err(fault) => assert!(fault.character <= law.chars().count(), "{fault:?} in {law}"),
                    }
                    let bound = compiled.bind(2, &values[2..]).value(&values[..2]);
                    assert!(bound.to_bits() == value.to_bits() || bound.is_nan() && value.is_nan(), "{law}");
                }
                Err(fault) => {
                    // A message's text may quote the law's own characters, but stays short.
                    let end = law.chars().count() + 1;
                    assert!((1..=end).contains(&fault.character) && fault.message.len() < 500, "{fault:?} in {law}");
                }
            }
        });
    }
}
