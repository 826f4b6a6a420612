//! Made campaigns against the product's own model with the true parameters: two integrators that share nothing must
//! leave the sensors' errors between them, and nothing else.

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{BenchModel, OUTPUTS};
use sealegs_model::{Excitation, Model};
use sealegs_reference::campaign::{CATALOGUE, Hidden, Made, Order, Rig, SUBSTEPS, Stamp};

fn order(rig: Rig, seed: u64) -> Order {
    Order {
        name: "made".to_owned(),
        rig,
        seed,
        hidden: Vec::new(),
        duration_s: 2.0,
        substeps: SUBSTEPS,
        rough: Vec::new(),
    }
}

/// A seed whose individual stamps its rows so.
fn seed_of(stamp: Stamp) -> u64 {
    (0..).find(|seed| sealegs_reference::campaign::Individual::drawn(*seed).stamp == stamp).unwrap()
}

fn model(rig: Rig) -> BenchModel {
    BenchModel::new(ActuatorSpec::preset("thor-linear").unwrap(), rig.bench()).unwrap()
}

/// Root mean square of measured less predicted in units of the stated noise, by channel, all runs together. The
/// load cells' gain and bias are the individual's.
fn errors(made: &Made, lead: f64, effects: &[(&str, Vec<f64>)]) -> Vec<(String, f64)> {
    let seen = Excitation { measured: OUTPUTS.map(str::to_owned).to_vec(), ..Excitation::default() };
    let mut model: Box<dyn Model> = Box::new(model(made.rig));
    for (id, _) in effects {
        model = model.with_effect(id, &seen).unwrap();
    }
    let spec = ActuatorSpec::preset(made.actuator).unwrap();
    let truth = made.individual.base_parameters(&spec);
    let values: Vec<f64> = model
        .parameters()
        .iter()
        .filter(|p| !p.name.contains('.'))
        .map(|p| match p.name.as_str() {
            "command_lead" => lead,
            "clock_skew" => made.individual.command_lateness_s * sealegs_reference::campaign::RATE_HZ,
            name => truth.iter().find(|t| t.0 == name).map_or(p.value, |t| t.1),
        })
        .chain(effects.iter().flat_map(|e| e.1.clone()))
        .collect();
    let channels: Vec<String> = made.noise_std.iter().map(|n| n.0.to_owned()).collect();
    let mut sums = vec![(0.0, 0usize); channels.len()];
    for run in &made.runs {
        let predicted = model.predict(&values, &run.record, &channels).unwrap();
        for (i, (channel, noise)) in made.noise_std.iter().enumerate() {
            let (gain, bias) = match *channel {
                "force_1_n" => (made.individual.gain[0], made.individual.bias_n[0]),
                "force_2_n" => (made.individual.gain[1], made.individual.bias_n[1]),
                _ => (1.0, 0.0),
            };
            let pairs = run.record.output(channel).unwrap().iter().zip(predicted.output(channel).unwrap());
            sums[i].0 += pairs.map(|(m, p)| ((m - gain * p - bias) / noise).powi(2)).sum::<f64>();
            sums[i].1 += run.record.len();
        }
    }
    channels.into_iter().zip(sums).map(|(c, (sum, n))| (c, (sum / n as f64).sqrt())).collect()
}

#[test]
fn reference_two_integrators_leave_the_noise_between_them_under_both_stamps() {
    for rig in [Rig::Locked, Rig::Pendulum] {
        for (stamp, lead) in [(Stamp::Start, 0.0), (Stamp::End, 1.0)] {
            let made = order(rig, seed_of(stamp)).make();
            assert!(made.individual.command_lateness_s > 1e-7);
            for (channel, error) in errors(&made, lead, &[]) {
                // 8000 samples: 0.8 % standard error of an rms.
                assert!((error - 1.0).abs() < 0.03, "{rig:?} {stamp:?}: {channel} {error}");
            }
            let wrong = errors(&made, 1.0 - lead, &[]);
            assert!(wrong.iter().any(|(_, e)| *e > 10.0), "a row's command may be a period off: {wrong:?}");
        }
    }
}

#[test]
fn reference_hidden_effects_are_those_of_the_catalogue() {
    let seen = Excitation { measured: OUTPUTS.map(str::to_owned).to_vec(), ..Excitation::default() };
    let lead = |made: &Made| if made.individual.stamp == Stamp::End { 1.0 } else { 0.0 };
    for id in CATALOGUE.iter().chain(&["sensor-lag@force_1_n", "sensor-delay@motor_angle_rad"]) {
        let rig = if Hidden::applies(id, Rig::Locked) { Rig::Locked } else { Rig::Pendulum };
        let model = model(rig);
        let card = model.effects(&seen).into_iter().find(|c| c.id == *id).unwrap();
        // Weak enough that the model's own step, a tenth of a millisecond, is not what is measured.
        let hidden = Hidden::drawn(id, 5, 0.05);
        let named: Vec<&str> = hidden.parameters.iter().map(|p| p.0).collect();
        let carded: Vec<&str> = card.parameters.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(named, carded, "{id}");
        let made = Order { hidden: vec![hidden.clone()], duration_s: 1.0, ..order(rig, 5) }.make();
        let values = hidden.parameters.iter().map(|p| p.1).collect();
        for (channel, error) in errors(&made, lead(&made), &[(id, values)]) {
            assert!((error - 1.0).abs() < 0.15, "{id}: {channel} {error}");
        }
    }
}

#[test]
fn sensors_count_and_the_same_order_gives_the_same_files() {
    let made = order(Rig::Pendulum, 11).make();
    for (channel, counts) in [("motor_angle_rad", 4096.0), ("joint_angle_rad", 65536.0)] {
        let count = std::f64::consts::TAU / counts;
        for value in made.runs[0].record.output(channel).unwrap() {
            assert!((value / count - (value / count).round()).abs() < 1e-9, "{channel}: {value}");
        }
    }
    assert_eq!(made.files(), order(Rig::Pendulum, 11).make().files());
    assert_ne!(made.files(), order(Rig::Pendulum, 12).make().files());
    let swing = made.runs.iter().flat_map(|r| r.record.output("joint_angle_rad").unwrap());
    assert!(swing.fold(0.0f64, |m, x| m.max(x.abs())) < 1.3, "the pendulum stays upright");
    let text = &made.files()[0].1;
    assert!(text.contains("bench = \"pendulum\"") && text.contains("joint_angle_rad = 2.768e-5"), "{text}");
}
