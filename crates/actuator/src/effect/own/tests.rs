use super::*;
use crate::bench::{Bench, BenchModel, PendulumRig};
use crate::spec::{ActuatorSpec, EffectSpec, EffectValue};
use proptest::prelude::*;
use sealegs_model::{Excitation, InputHold, Model, Record, Signal};

const DRAG: &str = r#"id = "belt-drag"
acts-on = "rotor"
law = "a*y_dot*abs(y_dot) + b*tanh(y_dot/v0)"

[parameters]
a = { guess = 100.0, min = 0.0, max = 1e6, unit = "N s^2/m^2" }
b = { guess = 0.5, min = 0.0, max = 100.0 }
v0 = { fixed = 1e-3 }
"#;

fn thor() -> ActuatorSpec {
    ActuatorSpec::preset("thor-linear").expect("preset")
}

fn record() -> Record {
    let time_s: Vec<f64> = (0..800).map(|n| f64::from(n) * 1e-3).collect();
    let values = time_s.iter().map(|t| 4.0 * (40.0 * t).sin()).collect();
    Record {
        cut: false,
        name: "test".to_owned(),
        time_s,
        hold: InputHold::ZeroOrder,
        inputs: vec![Signal { channel: "current_a".to_owned(), values }],
        outputs: Vec::new(),
    }
}

/// Force 1 of THOR with one effect at the given values of its parameters.
fn force_1(bench: Bench, own: Option<&str>, id: &str, values: &[f64]) -> Vec<f64> {
    let own: Vec<Arc<dyn Effect>> = own
        .map(|text| Arc::new(OwnEffect::from_toml(text, "own.toml").unwrap_or_else(|e| panic!("{e}"))) as _)
        .into_iter()
        .collect();
    let model = BenchModel::with_own_effects(thor(), bench, own).unwrap_or_else(|e| panic!("{e}"));
    let base: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let model = if id.is_empty() {
        model.clone_box()
    } else {
        model.with_effect(id, &Excitation::default()).unwrap_or_else(|e| panic!("{e}"))
    };
    let values: Vec<f64> = base.iter().chain(values).copied().collect();
    let prediction = model.predict(&values, &record(), &["force_1_n".to_owned()]);
    prediction.unwrap_or_else(|e| panic!("{e}")).outputs.swap_remove(0).values
}

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

#[test]
fn a_law_does_what_the_catalogue_s_effect_does() {
    let own = force_1(Bench::Locked, Some(DRAG), "belt-drag", &[4e4, 0.0, 1e-3]);
    let known = force_1(Bench::Locked, None, "quadratic-drag", &[4e4]);
    assert!(farthest(&own, &known) < 1e-9);
    let spring = "id = \"cubic\"\nacts-on = \"spring\"\nlaw = \"c*delta^3\"\n\
                  parameters = { c = { guess = 1e9, min = 0, max = 1e12 } }";
    let own = force_1(Bench::Locked, Some(spring), "cubic", &[5e10]);
    assert!(farthest(&own, &force_1(Bench::Locked, None, "hardening-spring", &[5e10])) < 1e-9);
    let drive = "id = \"emf\"\nacts-on = \"drive\"\nlaw = \"u - e*theta_dot\"\n\
                 parameters = { e = { guess = 0.01, min = 0, max = 1 } }";
    let fading = force_1(Bench::Locked, Some(drive), "emf", &[0.02]);
    // A loss in proportion to speed is viscous damping of force_per_command * e / r, which the linear part has exactly.
    let viscous = thor().coefficients().force_constant * 0.02 / thor().ratio();
    let model = BenchModel::new(thor(), Bench::Locked).unwrap_or_else(|e| panic!("{e}"));
    let more = |p: &Parameter| if p.name == "damping" { p.value + viscous } else { p.value };
    let values: Vec<f64> = model.parameters().iter().map(more).collect();
    let damped = model.predict(&values, &record(), &["force_1_n".to_owned()]);
    let damped = damped.unwrap_or_else(|e| panic!("{e}")).outputs.swap_remove(0).values;
    assert!(farthest(&fading, &damped) < 1e-3, "{}", farthest(&fading, &damped));
}

#[test]
fn an_output_law_slows_the_pendulum_and_needs_one() {
    let text = "id = \"joint-drag\"\nacts-on = \"output\"\nlaw = \"c*theta_dot\"\n\
                parameters = { c = { guess = 1.0, min = 0, max = 100, unit = \"N m s/rad\" } }";
    let bench = Bench::Pendulum(PendulumRig::default());
    let (none, some) = (force_1(bench, None, "", &[]), force_1(bench, Some(text), "joint-drag", &[5.0]));
    assert!(farthest(&none, &some) > 1.0);
    assert_eq!(force_1(bench, Some(text), "joint-drag", &[0.0]), none);
    let own = Arc::new(OwnEffect::from_toml(text, "own.toml").expect("good"));
    let locked = BenchModel::with_own_effects(thor(), Bench::Locked, vec![own]).expect("good");
    assert!(locked.with_effect("joint-drag", &Excitation::default()).is_err());
}

#[test]
fn neutral_values_change_nothing_and_are_found() {
    let own = OwnEffect::from_toml(DRAG, "own.toml").expect("good");
    let neutral: Vec<Option<f64>> = own.parameters.iter().map(|p| p.neutral).collect();
    assert_eq!(neutral, [Some(0.0), Some(0.0), None]);
    let without = force_1(Bench::Locked, None, "", &[]);
    assert_eq!(force_1(Bench::Locked, Some(DRAG), "belt-drag", &[0.0, 0.0, 1e-3]), without);
}

#[test]
fn a_model_file_embeds_it_and_loads_again() {
    let own = OwnEffect::from_toml(DRAG, "own.toml").expect("good");
    let mut spec = thor();
    spec.effects = vec![EffectSpec {
        id: "belt-drag".to_owned(),
        parameters: [("a".to_owned(), EffectValue { value: 4e4, std: Some(10.0) })].into(),
        definition: Some(own.table().clone()),
    }];
    let again = ActuatorSpec::from_toml(&spec.to_toml(), "model.toml").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(again, spec);
    let model = BenchModel::new(again, Bench::Locked).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(model.included(), ["belt-drag"]);
    let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    assert_eq!(model.effect_specs(&values, &[])[0].definition, spec.effects[0].definition);
    let force = |m: &dyn Model, v: &[f64]| {
        m.predict(v, &record(), &["force_1_n".to_owned()]).unwrap_or_else(|e| panic!("{e}")).outputs
    };
    let direct = force_1(Bench::Locked, Some(DRAG), "belt-drag", &[4e4, 0.5, 1e-3]);
    assert_eq!(force(&model, &values)[0].values, direct);
    spec.effects[0].id = "other".to_owned();
    assert!(BenchModel::new(spec, Bench::Locked).is_err());
}

#[test]
fn faults_name_file_key_and_place() {
    let message = |from: &str, to: &str| {
        OwnEffect::from_toml(&DRAG.replace(from, to), "own.toml").expect_err("bad").to_string()
    };
    let starts = |m: String, wanted: &str, holds: &str| {
        assert!(m.starts_with(wanted) && m.contains(holds), "{m}");
    };
    starts(message("tanh(y_dot/v0)", "tanh(y_dott/v0)"), "own.toml:3:36: law", "did you mean 'y_dot'");
    starts(message("abs(y_dot)", "abs(y_dot"), "own.toml:3:", "law, character");
    starts(message("tanh(y_dot/v0)", "1/y_dot"), "own.toml:3: law", "division by zero");
    starts(message("tanh(y_dot/v0)", "sqrt(y_dot)"), "own.toml:3: law", "character 24");
    starts(message("min = 0.0, max = 100.0", "min = 0.1, max = 100.0"), "own.toml:3: law", "neutral");
    starts(message("acts-on", "acts_on"), "own.toml:2:1", "did you mean 'acts-on'");
    starts(message("guess = 0.5", "gues = 0.5"), "own.toml:7", "guess");
    starts(message("belt-drag", "coulomb-friction"), "own.toml:1: id", "catalogue");
    starts(message("belt-drag", "Belt drag"), "own.toml:1: id", "lower-case");
    starts(message("fixed = 1e-3", "fixed = 0.0"), "own.toml:3: law", "division by zero");
    starts(message("guess = 0.5", "guess = -0.5"), "own.toml:7: parameters.b.guess", "between");
    starts(message("v0 =", "sin ="), "own.toml:5: parameters", "function");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_files_never_panic(text in ".{0,200}") {
        let _ = OwnEffect::from_toml(&text, "own.toml");
    }

    #[test]
    fn arbitrary_laws_never_panic(law in r"([a-z0-9+*/^(),. -]|y_dot|tanh\(|min\(|1e|abs\(|v0){0,60}") {
        let _ = OwnEffect::from_toml(&DRAG.replace("a*y_dot*abs(y_dot) + b*tanh(y_dot/v0)", &law), "own.toml");
        let _ = Expression::parse(&law, &["y_dot", "v0"]).map(|e| e.value(&[0.1, 2.0]));
    }
}
