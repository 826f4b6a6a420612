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
    let toy = Toy::new();
    let mut record = run(&TRUTH, 4000, 77, NOISE, (1.0, 0.0), 1.0);
    let clean = toy.predict_speed(&TRUTH, &record);
    for (i, v) in record.outputs[0].values.iter_mut().enumerate() {
        *v += add(i, clean[i]);
    }
    let campaign = campaign(vec![(Role::Fit, record)], NOISE);
    let data = Data::new(&campaign, None, &toy).unwrap();
    let at = at_values(&data, &toy, &TRUTH, Difference::Forward).unwrap().evaluation;
    check(&locate(&[(&data, &at)]), &structure::tests(&[(&data, &at)]));
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
