//! Time of a step of the THOR leg in flight and on the ground, beside a step of the bare engine and a step as fits take it,
//! by the equations of motion, with the same leg in the same run; the ratios are printed at the end.

use criterion::{Criterion, criterion_group, criterion_main};
use sealegs_leg::LegError;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::Simulation;
use std::hint::black_box;
use std::time::Instant;

/// The leg in flight, or standing after it has landed.
fn leg(on_the_ground: bool, build: impl Fn(&Scenario) -> Result<Simulation, LegError>) -> Simulation {
    // Without gravity the leg stays in flight however long it is measured.
    let set: &[&str] = if on_the_ground {
        &["start.drop_height_m=0.001"]
    } else {
        &["start.drop_height_m=1.0", "gravity_m_s2=0.0"]
    };
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    let scenario = Scenario::load("thor-drop", &set).expect("embedded");
    let mut simulation = build(&scenario).expect("good");
    for _ in 0..10_000 {
        simulation.advance(false).expect("runs");
    }
    simulation
}

fn steps(c: &mut Criterion) {
    for (name, ground) in [("flight", false), ("ground", true)] {
        let mut whole = leg(ground, Simulation::new);
        c.bench_function(&format!("step in {name}"), |b| {
            b.iter(|| whole.advance(black_box(false)).expect("runs"));
        });
        let mut fit = leg(ground, Simulation::as_in_fits);
        c.bench_function(&format!("step of a fit in {name}"), |b| {
            b.iter(|| fit.advance(black_box(false)).expect("runs"));
        });
        let mut bare = leg(ground, Simulation::new);
        c.bench_function(&format!("bare engine in {name}"), |b| b.iter(|| bare.bare_engine_step()));
    }
    ratio();
}

/// Whole steps and bare ones in turn, so that the machine's moods fall on both.
fn ratio() {
    for (name, ground) in [("flight", false), ("ground", true)] {
        let (mut whole, mut bare) = (leg(ground, Simulation::new), leg(ground, Simulation::new));
        let mut fit = leg(ground, Simulation::as_in_fits);
        let mut best = [f64::INFINITY; 3];
        for _ in 0..200 {
            let mut time = |i: usize, step: &mut dyn FnMut()| {
                let start = Instant::now();
                (0..200).for_each(|_| step());
                best[i] = f64::min(best[i], start.elapsed().as_secs_f64() / 200.0);
            };
            time(0, &mut || whole.advance(black_box(false)).expect("runs"));
            time(1, &mut || bare.bare_engine_step());
            time(2, &mut || fit.advance(black_box(false)).expect("runs"));
        }
        println!(
            "{name}: {:.2} us a step, bare engine {:.2} us, ratio {:.3}; a fit's step {:.2} us, ratio {:.3}",
            1e6 * best[0],
            1e6 * best[1],
            best[0] / best[1],
            1e6 * best[2],
            best[0] / best[2]
        );
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
