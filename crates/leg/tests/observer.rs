//! A leg under an observer: along the motion of a run in open loop it shows the forces of that run, and a joint's encoder
//! that is mounted with an error is a parameter that takes it back.

use sealegs_leg::model::LegModel;
use sealegs_leg::scenario::Scenario;
use sealegs_model::{Excitation, InputHold, Model, Prediction, Record, Signal, internal};

const SWING: &str = "robot = \"thor-leg\"\nduration_s = 0.4\nstep_s = 2e-4\n[base]\nkind = \"fixed\"\nheight_m = 1.2\n\
    [start]\nsprings = \"balanced\"\nposture_rad = { hip_pitch = -0.6, knee = 0.4 }\n[controller]\nkind = \"pd\"\n\
    stiffness_nm_rad = 500.0\ndamping_nm_s_rad = 10.0\ngravity_compensation = true\nfeed_forward = true\n[motion]\n\
    knee = { shape = \"sine\", amplitude_rad = 0.15, frequency_hz = 1.5 }\n\
    ankle_pitch = { shape = \"sine\", amplitude_rad = 0.08, frequency_hz = 2.0 }\n";

const JOINTS: [&str; 6] = ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"];
const ACTUATORS: [&str; 6] = ["hip_front", "hip_back", "hip_pitch", "knee", "ankle_outer", "ankle_inner"];

/// Newtons that acceleration out of smoothed angles and another way of integrating are worth.
const ALIKE_N: f64 = 2.0;

fn leg() -> LegModel {
    let scenario = Scenario::from_toml(SWING, "swing.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    LegModel::new(scenario.clone(), &scenario, Vec::new(), Vec::new()).unwrap_or_else(|e| panic!("{e}"))
}

fn values(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

fn channels() -> Vec<String> {
    let of = |what: &'static str| ACTUATORS.iter().map(move |a| format!("{a}.{what}"));
    let joints = JOINTS.iter().map(|j| format!("{j}.angle_rad"));
    joints.chain(of("force_1_n")).chain(of("current_a")).chain(of("rotor_angle_rad")).collect()
}

/// The run in open loop, the encoder of a joint showing so much more than the angle, rad.
fn recorded(model: &LegModel, more: &[(&str, f64)]) -> Record {
    let time_s: Vec<f64> = (0..=400).map(|i| f64::from(i) * 1e-3).collect();
    let empty = || Record {
        cut: false,
        name: "run.csv".to_owned(),
        time_s: time_s.clone(),
        hold: InputHold::ZeroOrder,
        inputs: Vec::new(),
        outputs: Vec::new(),
    };
    let run = model.predict(&values(model), &empty(), &channels()).unwrap_or_else(|e| panic!("{e}"));
    let shown = |mut s: Signal| {
        let more = more.iter().find(|(joint, _)| s.channel == format!("{joint}.angle_rad"));
        s.values.iter_mut().for_each(|v| *v += more.map_or(0.0, |(_, more)| *more));
        s
    };
    Record { outputs: run.outputs.into_iter().map(shown).collect(), ..empty() }
}

/// Root mean square difference of an actuator's force from the recorded one, N.
fn off(prediction: &Prediction, record: &Record, actuator: &str) -> f64 {
    let channel = format!("{actuator}.force_1_n");
    let (own, other) = (prediction.output(&channel).unwrap(), record.output(&channel).unwrap());
    (own.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / own.len() as f64).sqrt()
}

#[test]
fn the_zero_of_an_encoder_takes_back_what_its_error_does_to_the_springs() {
    let model = leg();
    let mounted = [("knee", 1e-3), ("hip_roll", -0.8e-3)];
    let record = recorded(&model, &mounted);
    let observing = model.observing(&[&record]).expect("every joint and rotor was measured");
    let as_shown = observing.predict(&values(observing.as_ref()), &record, &channels()).unwrap();
    // A spring of 375 kN/m at some 4 cm of arm.
    assert!(off(&as_shown, &record, "knee") > 5.0, "{}", off(&as_shown, &record, "knee"));
    let zeros: Vec<f64> = observing
        .parameters()
        .iter()
        .map(|p| mounted.iter().find(|(j, _)| p.name == format!("{j}/encoder_zero")).map_or(p.value, |m| m.1))
        .collect();
    let taken_back = observing.predict(&zeros, &record, &channels()).unwrap();
    for actuator in ACTUATORS {
        let left = off(&taken_back, &record, actuator);
        assert!(left < ALIKE_N, "{actuator}: {left} N");
    }
}

#[test]
fn zeros_stand_behind_the_base_parameters_whatever_is_included_first() {
    let (model, seen) = (leg(), Excitation::default());
    let record = recorded(&model, &[]);
    let names = |m: &dyn Model| m.parameters().iter().map(|p| p.name.clone()).collect::<Vec<_>>();
    let observed = model.observing(&[&record]).unwrap();
    let then = observed.with_effect("knee/coulomb-friction", &seen).unwrap();
    let first = model.with_effect("knee/coulomb-friction", &seen).unwrap().observing(&[&record]).unwrap();
    assert_eq!(names(then.as_ref()), names(first.as_ref()));
    // Observing again adds none.
    assert_eq!(names(observed.observing(&[&record]).unwrap().as_ref()), names(observed.as_ref()));
    // The effect's value is read from its own place: a friction of the knee changes its force, and no other
    let with_friction = |m: &dyn Model| {
        let mut values = values(m);
        *values.last_mut().unwrap() = 60.0;
        m.predict(&values, &record, &channels()).unwrap()
    };
    let (then, first) = (with_friction(then.as_ref()), with_friction(first.as_ref()));
    assert_eq!(then.outputs, first.outputs);
    assert!(off(&then, &record, "knee") > 0.05 && off(&then, &record, "hip_front") < ALIKE_N);
}

#[test]
fn analytic_a_screw_goes_where_its_rotor_and_its_speed_take_it() {
    let model = leg();
    let record = recorded(&model, &[]);
    let observing = model.observing(&[&record]).expect("every joint and rotor was measured");
    for model in [&model as &dyn Model, observing.as_ref()] {
        let got = model.predict(&values(model), &record, &channels()).unwrap();
        let of = |name: &str| got.internal(&format!("knee.{name}")).expect("there");
        let (position, speed) = (of(internal::SCREW_POSITION), of(internal::SCREW_SPEED));
        let (angle, load) = (of(internal::ROTOR_ANGLE), of(internal::SCREW_FORCE));
        assert_eq!(angle, got.output("knee.rotor_angle_rad").unwrap());
        let (last, middle) = (position.len() - 1, position.len() / 2);
        let moved: f64 = speed.windows(2).map(|v| 0.5e-3 * (v[0] + v[1])).sum();
        assert!((position[last] - position[0] - moved).abs() < 1e-5 && moved.abs() > 1e-3, "{moved}");
        assert!((position[last] / angle[last] / (position[middle] / angle[middle]) - 1.0).abs() < 1e-9);
        // Spring and screw bear the same but for the sprung mass; an observer knows no acceleration in the last row.
        let spring = of(internal::SPRING_FORCE);
        let off = load[..last].iter().zip(spring).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 50.0 && load[..last].iter().any(|f| f.abs() > 100.0), "{off}");
    }
}

#[test]
fn outputs_alone_are_those_of_a_prediction_bit_for_bit() {
    let model = leg();
    let record = recorded(&model, &[]);
    let observing = model.observing(&[&record]).expect("every joint and rotor was measured");
    for model in [&model as &dyn Model, observing.as_ref()] {
        let whole = model.predict(&values(model), &record, &channels()).expect("it runs");
        let alone = model.predict_outputs(&values(model), &record, &channels()).expect("it runs");
        assert!(!whole.internals.is_empty() && alone.internals.is_empty());
        assert_eq!(whole.outputs, alone.outputs);
    }
}
