//! The inner loop of everything: 20 s of a bench at a 100 us step, base model and each effect.
//!
//! `cargo bench -p sealegs-actuator --bench inner_loop` prints the time per run of 200 000 steps; divide by that
//! for a step. The time includes the prediction at the 20 001 time stamps of the record.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig};
use sealegs_actuator::excitation::Profile;
use sealegs_model::{Excitation, InputHold, Model, Record, Signal, SignalRange, internal};

const STEPS: u64 = 200_000;

fn record() -> Record {
    let time_s: Vec<f64> = (0..=20_000).map(|n| f64::from(n) * 1e-3).collect();
    let noise = Profile::Noise { rms: 2.5, bandwidth_hz: 60.0, seed: 1 };
    Record {
        cut: false,
        name: "bench".to_owned(),
        inputs: vec![Signal { channel: "current_a".to_owned(), values: noise.sample(&time_s) }],
        time_s,
        hold: InputHold::ZeroOrder,
        outputs: Vec::new(),
    }
}

/// What was seen, so that the effects' guesses suit the run.
fn seen(channels: &[String]) -> Excitation {
    let range =
        |name: &str, peak: f64| SignalRange { name: name.to_owned(), min: -peak, max: peak, rms: 0.4 * peak };
    Excitation {
        measured: channels.to_vec(),
        ranges: vec![
            range(internal::MOTOR_FORCE, 2000.0),
            range(internal::SCREW_SPEED, 0.05),
            range(internal::SPRING_DEFLECTION, 2e-3),
        ],
        sample_period_s: 1e-3,
    }
}

fn benches(criterion: &mut Criterion) {
    let record = record();
    let channels = ["force_1_n", "force_2_n", "motor_angle_rad"].map(str::to_owned);
    let seen = seen(&channels);
    // The last ones are what a search tries on a rig that nothing explains.
    let together: [&[&str]; 7] = [
        &[],
        &["coulomb-friction"],
        &["stribeck-friction", "torque-ripple"],
        &["dahl-friction", "torque-ripple"],
        &["presliding-friction", "torque-ripple"],
        &["direction-dependent-friction", "warming-friction", "torque-ripple"],
        &["coulomb-friction", "dahl-friction", "torque-ripple", "structural-mode"],
    ];
    for bench in [Bench::Locked, Bench::Pendulum(PendulumRig::default())] {
        let spec = ActuatorSpec::preset("thor-linear").expect("a preset");
        let base = BenchModel::new(spec, bench).expect("a good file");
        let label = if bench == Bench::Locked { "locked" } else { "pendulum" };
        let mut group = criterion.benchmark_group(label);
        group.throughput(Throughput::Elements(STEPS)).sample_size(10);
        group.warm_up_time(std::time::Duration::from_millis(200));
        group.measurement_time(std::time::Duration::from_millis(500));
        let single = base.effects(&seen).into_iter().map(|c| c.id).filter(|id| !id.contains('@'));
        let mut sets: Vec<Vec<String>> =
            together.iter().map(|ids| ids.iter().map(|id| (*id).to_owned()).collect()).collect();
        sets.extend(single.filter(|id| id != "coulomb-friction").map(|id| vec![id]));
        for ids in sets {
            let mut model = base.clone_box();
            for id in &ids {
                model = model.with_effect(id, &seen).expect("an effect of this bench");
            }
            let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
            let name = if ids.is_empty() { "base".to_owned() } else { ids.join("+") };
            group.bench_function(name, |b| {
                b.iter(|| model.predict(&values, &record, &channels).expect("a finite run"));
            });
        }
        group.finish();
    }
}

criterion_group!(inner_loop, benches);
criterion_main!(inner_loop);
