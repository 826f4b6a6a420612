//! A residual that was put somewhere is found there.

use super::*;
use crate::campaign::Role;
use crate::fit::{Difference, at_values};
use crate::structure;
use crate::toy::{Toy, campaign, run};
use sealegs_model::internal;

const TRUTH: [f64; 3] = [1.0, 4.0, 400.0];
const NOISE: (f64, f64) = (0.2, 0.001);

/// Locates and tests the residual of the true model on a run to whose force channel `add(row, speed)` was added.
fn with_added(add: impl Fn(usize, f64) -> f64, check: impl Fn(&Location, &[structure::StructureTest])) {
    with_parts(add, |parts| check(&locate(parts), &structure::tests(parts)));
}

/// The same with what there is to locate.
fn with_parts(add: impl Fn(usize, f64) -> f64, check: impl Fn(&[(&Data, &Evaluation)])) {
    let toy = Toy::new();
    let mut record = run(&TRUTH, 4000, 77, NOISE, (1.0, 0.0), 1.0);
    let clean = toy.predict_speed(&TRUTH, &record);
    for (i, v) in record.outputs[0].values.iter_mut().enumerate() {
        *v += add(i, clean[i]);
    }
    let campaign = campaign(vec![(Role::Fit, record)], NOISE);
    let data = Data::new(&campaign, None, &toy).unwrap();
    let at = at_values(&data, &toy, &TRUTH, Difference::Forward).unwrap().evaluation;
    check(&[(&data, &at)]);
}

impl Toy {
    fn predict_speed(&self, values: &[f64], record: &sealegs_model::Record) -> Vec<f64> {
        use sealegs_model::Model;
        let prediction = self.predict(values, record, &["force_1_n".to_owned()]).unwrap();
        prediction.internal(internal::SCREW_SPEED).unwrap().to_vec()
    }
}

#[test]
fn noise_sits_nowhere() {
    with_added(
        |_, _| 0.0,
        |location, tests| {
            assert!((location.error - 1.0).abs() < 0.05);
            assert!(location.worst(5).is_empty());
            for region in &location.regions {
                assert!(region.excess().abs() < 0.05, "{region:?}");
            }
            for test in tests {
                assert!(!test.depends(), "{test:?}");
            }
        },
    );
}

#[test]
fn an_error_in_one_direction_is_found_there() {
    // Of alternating sign, so that no bias can take it up.
    let rough = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    with_added(
        |i, v| if v > 0.01 { rough(i) } else { 0.0 },
        |location, _| {
            let direction = location.worst(9).into_iter().find(|r| r.axis == "direction").unwrap();
            assert!(direction.label.contains("lengthening"), "{direction:?}");
            assert!(direction.error > 1.5 * direction.error_elsewhere);
            assert!(direction.sentence().contains('%'));
        },
    );
}

#[test]
fn an_error_with_the_sign_of_the_speed_suggests_friction() {
    with_added(
        |_, v| 0.5 * v.signum(),
        |_, tests| {
            let sign = tests.iter().find(|t| t.on == "sign of the speed").unwrap();
            assert!(sign.depends() && sign.suggests.contains("coulomb-friction"), "{sign:?}");
            assert!(tests[0].depends(), "it is not white");
        },
    );
}

#[test]
fn an_error_at_one_time_and_one_frequency_is_found_there() {
    with_added(
        |i, _| if i >= 3600 { 2.0 * (0.005 * i as f64 * std::f64::consts::TAU * 30.0).sin() } else { 0.0 },
        |location, tests| {
            let worst = location.worst(9);
            let time = worst.iter().find(|r| r.axis == "time in the run").unwrap();
            assert!(time.label.starts_with("above 17.5"), "{time:?}");
            let band = worst.iter().find(|r| r.axis == "frequency").unwrap();
            assert_eq!(band.label, "20 to 50 Hz");
            let channel = worst.iter().find(|r| r.axis == "channel").unwrap();
            assert_eq!(channel.label, "force_1_n");
            assert!(tests[0].depends(), "{:?}", tests[0]);
        },
    );
}

#[test]
fn shares_of_every_axis_sum_to_one() {
    with_added(
        |_, _| 0.1,
        |location, _| {
            let mut axes: Vec<&str> = location.regions.iter().map(|r| r.axis).collect();
            axes.dedup();
            assert!(axes.len() >= 7, "{axes:?}");
            for axis in axes {
                let of = || location.regions.iter().filter(|r| r.axis == axis);
                assert!((of().map(|r| r.sample_share).sum::<f64>() - 1.0).abs() < 1e-9, "{axis}");
                assert!((of().map(|r| r.error_share).sum::<f64>() - 1.0).abs() < 1e-9, "{axis}");
            }
        },
    );
}

#[test]
fn what_is_left_is_described_by_its_band_and_what_it_follows() {
    let number =
        |text: &str| text.split_whitespace().filter_map(|w| w.parse::<f64>().ok()).collect::<Vec<_>>();
    let wave = |i: usize| 3.0 * (0.005 * i as f64 * std::f64::consts::TAU * 30.0).sin();
    with_parts(
        |i, _| wave(i),
        |parts| {
            let said = remainder(parts);
            let band = number(&said[0]);
            assert!(band[0] < 30.0 && band[1] > 30.0 && band[1] < 1.2 * band[0], "{said:?}");
            assert!(said[1].contains("follows none"), "{said:?}");
        },
    );
    with_parts(
        |_, v| 0.5 * v.signum(),
        |parts| {
            assert!(remainder(parts)[1].contains("follows the sign of the speed"), "{:?}", remainder(parts))
        },
    );
    // Sampled at 200 Hz: what fades within a fifth of a second is where a run begins and no drift, and a line is no start.
    let follows = |parts: &[(&Data, &Evaluation)], on: &str| {
        let said = remainder(parts);
        assert!(said[1].contains(&format!("follows the {on}")), "{said:?}");
    };
    with_parts(|i, _| 9.0 * (-0.005 * i as f64 / 0.2).exp(), |parts| follows(parts, "start of the run"));
    with_parts(|i, _| 1e-3 * i as f64, |parts| follows(parts, "time in the run"));
    with_parts(|_, _| 0.0, |parts| assert!(remainder(parts).is_empty()));
}

#[test]
fn a_leg_is_located_by_each_actuators_signals() {
    with_parts(
        |_, v| if v > 0.01 { 1.0 } else { 0.0 },
        |parts| {
            let (data, at) = parts[0];
            let mut leg = at.clone();
            for signal in &mut leg.predictions[0].internals {
                signal.channel = format!("knee.{}", signal.channel);
            }
            let named = |of: &Location| {
                of.regions.iter().filter(|r| r.axis == "direction").map(Region::subject).collect::<Vec<_>>()
            };
            assert!(named(&locate(parts)).iter().all(|s| s == "direction"));
            let located = locate(&[(data, &leg)]);
            assert!(named(&located).iter().all(|s| s == "direction of knee"), "{located:?}");
            assert_eq!(located.regions.len(), locate(parts).regions.len());
        },
    );
}
