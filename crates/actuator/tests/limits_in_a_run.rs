//! A beam past yield, past its rated force or out of its range is reported by a bench, with the time.

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel};
use sealegs_model::{InputHold, Model, Record, Signal};

/// Events of half a second at a constant current that sets in at 0.1 s.
fn events(spec: ActuatorSpec, current_a: f64) -> Vec<String> {
    let model = BenchModel::new(spec, Bench::Locked).expect("no effects");
    let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let time_s: Vec<f64> = (0..500).map(|i| 1e-3 * f64::from(i)).collect();
    let command = time_s.iter().map(|t| if *t < 0.1 { 0.0 } else { current_a }).collect();
    let record = Record {
        cut: false,
        name: "step".to_owned(),
        time_s,
        hold: InputHold::ZeroOrder,
        inputs: vec![Signal { channel: "current_a".to_owned(), values: command }],
        outputs: Vec::new(),
    };
    let channels = ["force_1_n".to_owned()];
    model.predict(&values, &record, &channels).expect("a stable plant").events
}

#[test]
fn a_step_beyond_the_rated_force_is_reported_with_its_time() {
    let thor = ActuatorSpec::preset("thor-linear").expect("preset");
    // 8 A settle at 1923 N, but the step overshoots 2225 N: by exp(-pi zeta/sqrt(1-zeta^2)) = 23 % at zeta = 0.42.
    let found = events(thor.clone(), 8.0);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("past the rated force") && found[0].contains("rated 2225.0 N"), "{found:?}");
    let time_s: f64 = found[0].split(' ').next().expect("a time").parse().expect("a number");
    // The overshoot's peak comes pi/w_d = 73 ms after the step.
    assert!(time_s > 0.1 && time_s < 0.1 + 0.0735, "{time_s}");
    assert!(events(thor, 7.0).is_empty());
}

#[test]
fn a_pivot_out_of_range_is_reported_at_the_start() {
    let saffir = ActuatorSpec::preset("saffir-linear").expect("preset");
    let found = events(saffir.with_spring_setting("115mm").expect("a length"), 1.0);
    assert_eq!(found, ["0.0000 s: pivot out of range: 115.00 mm, limit 110.00 mm"]);
}
