//! Drives without a spring: what holds for every effect that they can have, and their motion against other integrators.

use sealegs_actuator::bench::{Bench, BenchModel, OUTPUTS, PendulumRig, RunSetup};
use sealegs_actuator::excitation::Profile;
use sealegs_actuator::plant::Grid;
use sealegs_actuator::spec::{Feedback, ServoSpec};
use sealegs_actuator::{ActuatorError, ActuatorSpec};
use sealegs_model::{Excitation, InputHold, Model, Record, Signal, SignalRange, internal};

const PENDULUM: PendulumRig = PendulumRig { arm_m: 1.0, length_m: 0.1, mass_kg: 0.49, rod_mass_kg: 0.0 };

/// A carriage of 95 kg, roughly.
fn carriage() -> BenchModel {
    let mut spec = ActuatorSpec::preset("rigid-linear").expect("preset");
    spec.motor.rotor_inertia_kg_m2 = 60.0;
    spec.motor.rotor_damping_nm_s = 200.0;
    BenchModel::new(spec, Bench::Free { load: 35.0 }).expect("good")
}

/// A small servo with a pendulum.
fn servo() -> BenchModel {
    let mut spec = ActuatorSpec::preset("rigid-rotary").expect("preset");
    spec.motor.torque_constant_nm_a = 0.26;
    spec.motor.rotor_inertia_kg_m2 = 0.0019;
    spec.motor.rotor_damping_nm_s = 0.005;
    spec.motor.winding_resistance_ohm = Some(1.9);
    spec.motor.supply_v = Some(7.4);
    spec.servo = Some(ServoSpec {
        proportional_nm_per_rad: None,
        derivative_nm_s_per_rad: 0.0,
        torque_limit_nm: None,
        proportional_per_rad: 1.2,
        derivative_s_per_rad: 0.0,
        integral_per_rad_s: 0.0,
        duty_limit: 1.0,
        duty_dead_zone: 0.0,
        current_limit_a: None,
        dead_band_rad: 0.0,
        command_delay_s: 0.0,
        feedback_delay_s: 0.0,
        feedback: Feedback::Joint,
        rate_hz: None,
    });
    BenchModel::new(spec, Bench::Pendulum(PENDULUM)).expect("good")
}

/// The bench, its input column, its commands' size, and the sizes of what was seen of it.
fn rigs() -> [(BenchModel, &'static str, f64, Excitation); 4] {
    let seen = |model: &BenchModel, input: &str, command: f64, force: f64, speed: f64, travel: f64| {
        let range =
            |name: &str, peak: f64| SignalRange { name: name.to_owned(), min: -peak, max: peak, rms: peak };
        Excitation {
            measured: OUTPUTS.iter().filter(|c| model.predicts(c)).map(|c| (*c).to_owned()).collect(),
            ranges: vec![
                range(input, command),
                range(internal::MOTOR_FORCE, force),
                range(internal::SCREW_SPEED, speed),
                range(internal::SCREW_POSITION, travel),
            ],
            sample_period_s: 1e-3,
        }
    };
    let (free, loop_) = (carriage(), servo());
    [
        (free.clone(), "motor_force_n", 150.0, seen(&free, "motor_force_n", 150.0, 150.0, 0.3, 0.1)),
        (loop_.clone(), "position_rad", 1.0, seen(&loop_, "position_rad", 1.0, 0.8, 6.0, 1.5)),
        (loop_.clone(), "voltage_v", 3.0, seen(&loop_, "voltage_v", 3.0, 0.3, 6.0, 1.5)),
        (loop_.clone(), "joint_torque_nm", 0.3, seen(&loop_, "joint_torque_nm", 0.3, 0.3, 6.0, 1.5)),
    ]
}

fn record(input: &str, values: Vec<f64>) -> Record {
    Record {
        cut: false,
        name: "test".to_owned(),
        time_s: (0..values.len()).map(|n| n as f64 * 1e-3).collect(),
        hold: InputHold::ZeroOrder,
        inputs: vec![Signal { channel: input.to_owned(), values }],
        outputs: Vec::new(),
    }
}

fn noise(samples: usize, rms: f64, seed: u64) -> Vec<f64> {
    let time_s: Vec<f64> = (0..samples).map(|n| n as f64 * 1e-3).collect();
    Profile::Noise { rms, bandwidth_hz: 5.0, seed }.sample(&time_s)
}

fn values(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

#[test]
fn what_needs_a_spring_is_not_offered_and_all_else_is() {
    let (free, _, _, seen) = &rigs()[0];
    let ids: Vec<String> = free.effects(seen).into_iter().map(|c| c.id).collect();
    for id in ["hardening-spring", "output-friction", "voltage-saturation", "supply-sag"] {
        assert!(!ids.iter().any(|i| i == id), "{id}: {ids:?}");
    }
    for id in [
        "coulomb-friction",
        "presliding-friction",
        "load-dependent-friction",
        "output-offset",
        "transport-delay",
        "backlash",
        "series-compliance",
    ] {
        assert!(ids.iter().any(|i| i == id), "{id}: {ids:?}");
    }
    // Nothing parts a rotor from a load that has no mass of its own.
    let unloaded = free.on(Bench::Free { load: 0.0 });
    let ids: Vec<String> = unloaded.effects(seen).into_iter().map(|c| c.id).collect();
    assert!(!ids.iter().any(|i| i == "backlash" || i == "series-compliance"), "{ids:?}");
    let (loop_, _, _, seen) = &rigs()[1];
    let ids: Vec<String> = loop_.effects(seen).into_iter().map(|c| c.id).collect();
    for id in
        ["feedback-delay", "supply-sag", "pwm-dead-zone", "current-saturation", "directional-efficiency"]
    {
        assert!(ids.iter().any(|i| i == id), "{id}: {ids:?}");
    }
}

#[test]
fn neutral_values_reproduce_the_baseline() {
    for (base, input, size, seen) in rigs() {
        let record = record(input, noise(600, size, 3));
        let truth = base.predict(&values(&base), &record, &seen.measured).expect("finite").outputs;
        assert!(truth.iter().all(|s| s.values.iter().any(|v| *v != 0.0)), "{input}: all outputs move");
        for card in base.effects(&seen) {
            let with = base.with_effect(&card.id, &seen).unwrap_or_else(|e| panic!("{e}"));
            let mut all = values(&*with);
            let first = all.len() - card.parameters.len();
            for (value, p) in all[first..].iter_mut().zip(&card.parameters) {
                assert!(p.min <= p.value && p.value <= p.max && p.typical > 0.0, "{} {p:?}", card.id);
                assert!(p.starts.iter().all(|s| (p.min..=p.max).contains(s)), "{} {p:?}", card.id);
                *value = p.neutral.unwrap_or(p.value);
            }
            let got = with.predict(&all, &record, &seen.measured).expect("finite").outputs;
            assert!(got == truth, "{input} {}", card.id);
            // And at its guess it does something.
            let guess = with.predict(&values(&*with), &record, &seen.measured).expect("finite").outputs;
            let felt = card.parameters.iter().any(|p| p.neutral == Some(p.value)) || guess != truth;
            assert!(felt, "{input} {} changes nothing", card.id);
        }
    }
}

#[test]
fn energy_passive_effects_never_add_any() {
    for (base, input, size, seen) in rigs().into_iter().filter(|(_, input, ..)| *input != "position_rad") {
        let command = noise(2000, 0.5 * size, 11);
        for card in base.effects(&seen).into_iter().filter(|c| c.passive && !c.id.contains('@')) {
            let with = base.including(&card.id, &seen).expect("offered");
            let own = with.parameters().iter();
            let all: Vec<f64> = own.map(|p| if p.name == "damping" { 0.0 } else { p.value }).collect();
            let excess = |step_s: f64| {
                let plant = with.plant(&all, input).expect("good");
                let per_sample = (1e-3 / step_s).round() as usize;
                let commands: Vec<f64> =
                    command.iter().flat_map(|c| std::iter::repeat_n(*c, per_sample)).collect();
                let grid = Grid { start_s: 0.0, step_s, steps: commands.len() };
                let ledger = plant.energy(grid, &commands).expect("finite");
                let (mut least, mut most, mut excess) = (f64::INFINITY, 0.0_f64, 0.0_f64);
                for ((kinetic, stored), work) in
                    ledger.kinetic.iter().zip(&ledger.stored).zip(&ledger.motor_work)
                {
                    most = most.max((kinetic + stored).abs());
                    least = least.min(kinetic + stored - work);
                    excess = excess.max(kinetic + stored - work - least);
                }
                excess / most
            };
            let (coarse, fine) = (excess(1e-4), excess(5e-5));
            assert!(coarse < 2e-3, "{input} {}: {coarse:e} of the energy is won", card.id);
            // The ledger integrates a spring with play by Simpson's rule in 256 parts: at its corners that is 1e-6 off.
            let ledger = if card.id == "backlash" { 1e-6 } else { 1e-8 };
            assert!(fine < 0.7 * coarse + ledger, "{input} {}: {coarse:e} {fine:e}", card.id);
        }
    }
}

/// Semi-implicit steps of a microsecond with friction by projection: another integrator, for truth.
fn truth(
    samples: usize,
    start: (f64, f64),
    inertia: f64,
    force: impl Fn(usize, f64, f64) -> f64,
    bound: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    const FINE: usize = 1000;
    let h = 1e-3 / FINE as f64;
    let (mut x, mut v) = start;
    let mut out = vec![x];
    for n in 0..samples - 1 {
        for _ in 0..FINE {
            let free = v + h * force(n, x, v) / inertia;
            let most = h * bound(x, v) / inertia;
            v = if free.abs() <= most { 0.0 } else { free - most * free.signum() };
            x += h * v;
        }
        out.push(x);
    }
    out
}

#[test]
fn reference_a_carriage_that_begins_in_motion() {
    let (base, input, size, seen) = rigs().into_iter().next().expect("the carriage");
    let model = base.including("coulomb-friction", &seen).expect("offered");
    let model = model.including("output-offset", &seen).expect("offered");
    let command = noise(4000, 0.5 * size, 7);
    let run = RunSetup {
        record: "test".to_owned(),
        bench: Bench::Free { load: 35.0 },
        start: (0.2, -0.3),
        first_rows: None,
        servo_gain: 1.0,
    };
    let model = model.with_runs(vec![run]).expect("good");
    let mut all = values(&model);
    let last = all.len();
    (all[last - 2], all[last - 1]) = (20.0, -3.0);
    let record = record(input, command.clone());
    let got =
        model.predict(&all, &record, &["position_m".to_owned()]).expect("finite").outputs.remove(0).values;
    let force = |n: usize, _x: f64, v: f64| command[n] - 200.0 * v - 3.0;
    let truth = truth(4000, (0.2, -0.3), 95.0, force, |_, _| 20.0);
    let off = got.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let travel = truth.iter().fold(0.0_f64, |m, x| m.max((x - 0.2).abs()));
    // The reference is of first order at a microsecond.
    assert!(off < 2e-4 * travel, "{off:e} of {travel}");
}

#[test]
fn reference_a_servo_with_a_pendulum_and_friction_by_its_load() {
    let (base, _, _, seen) = rigs().into_iter().nth(1).expect("the servo");
    let model = base.including("load-dependent-friction", &seen).expect("offered");
    let model = model.including("coulomb-friction", &seen).expect("offered");
    let mut all = values(&model);
    let last = all.len();
    (all[last - 2], all[last - 1]) = (0.3, 0.02);
    let goal: Vec<f64> = (0..3000).map(|n| 1.2 * (f64::from(n) * 2e-3).sin()).collect();
    // Released at 2 s: the pendulum falls.
    let enable: Vec<f64> = (0..3000).map(|n| if n < 2000 { 1.0 } else { 0.0 }).collect();
    let mut record = record("position_rad", goal.clone());
    record.inputs.push(Signal { channel: "enable".to_owned(), values: enable.clone() });
    let got = model
        .predict(&all, &record, &["joint_angle_rad".to_owned()])
        .expect("finite")
        .outputs
        .remove(0)
        .values;
    let (load, weight) = (0.49 * 0.01, 0.49 * 9.81 * 0.1);
    let motor = |n: usize, x: f64, v: f64| {
        let volts = 7.4 * (1.2 * (goal[n] - x)).clamp(-1.0, 1.0);
        enable[n] * 0.26 * (volts - 0.26 * v) / 1.9
    };
    // What passes to the load is its weight and inertia force, which the friction itself changes: with
    // m a = f - mu |w + m_l a| s the bound follows in closed form from the two signs of the load.
    const FINE: usize = 100;
    let h = 1e-3 / FINE as f64;
    let (mut x, mut v, mut truth) = (0.0_f64, 0.0_f64, vec![0.0]);
    let inertia = 0.0019 + load;
    for n in 0..2999 {
        for _ in 0..FINE {
            let w = weight * x.sin();
            let free = motor(n, x, v) - w - 0.005 * v;
            let direction = if v == 0.0 { free.signum() } else { v.signum() };
            let solve = |sign: f64| {
                let a =
                    (free - direction * (0.02 + 0.3 * sign * w)) / (inertia + direction * 0.3 * sign * load);
                (a, sign * (w + load * a))
            };
            let (up, down) = (solve(1.0), solve(-1.0));
            let a = if up.1 >= 0.0 { up.0 } else { down.0 };
            let next = v + h * a;
            let sticks = v == 0.0 && free.abs() <= 0.02 + 0.3 * w.abs();
            v = if sticks || (v != 0.0 && next * v < 0.0) { 0.0 } else { next };
            x += h * v;
        }
        truth.push(x);
    }
    let off = got.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 0.01, "{off}");
    assert!((got[2000] - got[2999]).abs() > 0.2, "it was let go: {} {}", got[2000], got[2999]);
}

#[test]
fn reference_a_servo_that_is_sent_away_at_once_begins_at_rest() {
    const ROW_S: f64 = 7e-3;
    const COUNT: f64 = std::f64::consts::TAU / 4096.0;
    let model = servo();
    let (inertia, weight) = (0.0019 + 0.49 * 0.01, 0.49 * 9.81 * 0.1);
    let h = 1e-6;
    let (mut x, mut v, mut truth) = (0.0_f64, 0.0_f64, vec![0.0]);
    for _ in 1..100 {
        for _ in 0..(ROW_S / h).round() as usize {
            let volts = 7.4 * (1.2 * (1.0 - x)).clamp(-1.0, 1.0);
            v += h * (0.26 * (volts - 0.26 * v) / 1.9 - 0.005 * v - weight * x.sin()) / inertia;
            x += h * v;
        }
        truth.push(x);
    }
    let shown = truth.iter().map(|x| COUNT * (x / COUNT).round()).collect();
    let mut log = record("position_rad", vec![1.0; 100]);
    log.time_s.iter_mut().enumerate().for_each(|(n, t)| *t = n as f64 * ROW_S);
    log.outputs.push(Signal { channel: "joint_angle_rad".to_owned(), values: shown });
    let setup = RunSetup::of_record(&log, model.spec(), model.bench(), 1.0);
    let by_rows = RunSetup { first_rows: None, ..setup.clone() };
    let shown_by = |model: &BenchModel| {
        let got = model.predict(&values(model), &log, &["joint_angle_rad".to_owned()]).expect("finite");
        got.outputs.into_iter().next().expect("the angle").values
    };
    let with = |setup: RunSetup| model.clone().with_runs(vec![setup]).expect("good");
    let off = |model: &BenchModel| {
        shown_by(model).iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    // A cubic through its first rows is several counts off.
    let met = with(setup);
    let (found, by_rows) = (off(&met), off(&with(by_rows)));
    assert!(by_rows > 3.0 * COUNT && found < 0.5 * COUNT, "{found} {by_rows}");
    let told = met.clone().starting_as(&log).expect("finite");
    assert!(told.run(&log.name).expect("its run").first_rows.is_none());
    assert_eq!(shown_by(&told), shown_by(&met));
}

#[test]
fn reference_a_servo_with_play_that_sees_its_output() {
    let (base, _, _, seen) = rigs().into_iter().nth(1).expect("the servo");
    let model = base.including("backlash", &seen).expect("offered");
    let model = model.including("coulomb-friction", &seen).expect("offered");
    let mut all = values(&model);
    let last = all.len();
    let (gap, stiffness, dry) = (0.02, 120.0, 0.01);
    all[last - 3..].copy_from_slice(&[gap, stiffness, dry]);
    let goal: Vec<f64> = (0..3000).map(|n| 0.8 * (f64::from(n) * 5e-3).sin()).collect();
    let channels = ["joint_angle_rad", "motor_angle_rad", "speed_rad_s"].map(str::to_owned);
    let got = model.predict(&all, &record("position_rad", goal.clone()), &channels).expect("finite").outputs;
    // Semi-implicit steps of a microsecond of two bodies, friction by projection.
    let (rotor, load, weight): (f64, f64, f64) = (0.0019, 0.49 * 0.01, 0.49 * 9.81 * 0.1);
    let damper = 2.0 * 0.1 * (stiffness * rotor * load / (rotor + load)).sqrt();
    let h = 1e-6;
    let (mut y, mut w, mut x, mut v) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let mut truth = vec![[0.0; 3]];
    for goal in &goal[..2999] {
        for _ in 0..1000 {
            let d = y - x;
            let left = d - d.clamp(-0.5 * gap, 0.5 * gap);
            let s = if left == 0.0 { 0.0 } else { stiffness * left + damper * (w - v) };
            let volts = 7.4 * (1.2 * (goal - x)).clamp(-1.0, 1.0);
            let free = w + h * (0.26 * (volts - 0.26 * w) / 1.9 - 0.005 * w - s) / rotor;
            let most = h * dry / rotor;
            w = if free.abs() <= most { 0.0 } else { free - most * free.signum() };
            v += h * (s - weight * x.sin()) / load;
            y += h * w;
            x += h * v;
        }
        truth.push([x, y, v]);
    }
    for (i, most) in [(0, 1e-3), (1, 1e-3), (2, 0.1)] {
        let pairs = got[i].values.iter().zip(&truth);
        let off = (pairs.map(|(a, b)| (a - b[i]).powi(2)).sum::<f64>() / 3000.0).sqrt();
        assert!(off < most, "{}: {off}", channels[i]);
    }
    let crossed = truth.iter().filter(|t| (t[1] - t[0]).abs() < 0.4 * gap).count();
    assert!(crossed > 20, "the play is crossed in {crossed} rows");
}

#[test]
fn dry_friction_holds_and_a_start_is_where_the_log_begins() {
    let (base, input, _, seen) = rigs().into_iter().next().expect("the carriage");
    let model = base.including("coulomb-friction", &seen).expect("offered");
    let mut all = values(&model);
    *all.last_mut().expect("force") = 20.0;
    let run = RunSetup {
        record: "test".to_owned(),
        bench: Bench::Free { load: 35.0 },
        start: (0.2, 0.0),
        first_rows: None,
        servo_gain: 1.0,
    };
    let model = model.with_runs(vec![run]).expect("good");
    let held =
        model.predict(&all, &record(input, vec![19.9; 3000]), &["position_m".to_owned()]).expect("finite");
    assert!(held.outputs[0].values.iter().all(|x| *x == 0.2));
}

#[test]
fn bad_files_and_benches_are_refused_by_field() {
    let text = ActuatorSpec::preset_text("rigid-rotary").expect("preset");
    let message = |from: &str, to: &str| match ActuatorSpec::from_toml(&text.replace(from, to), "mine.toml") {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{to} was taken"),
    };
    let word = message("spring = \"none\"", "spring = \"nothing\"");
    assert!(word.starts_with("mine.toml:") && word.contains("\"none\""), "{word}");
    let table = message("spring = \"none\"", "spring = { type = \"none\", stiffness_n_m = 1.0 }");
    assert!(table.contains("has no 'stiffness_n_m'"), "{table}");
    let servo = "[servo]\nproportional_per_rad = 1.0\n[motor]";
    assert!(message("[motor]", servo).contains("motor.winding_resistance_ohm"));
    let gain = message("[motor]", "[servo]\nproportional_per_rad = -1.0\n[motor]");
    assert!(gain.contains("servo.proportional_per_rad = -1"), "{gain}");
    let key = message("[motor]", "[servo]\nproportional_per_rd = 1.0\n[motor]");
    assert!(key.contains("did you mean 'proportional_per_rad'?"), "{key}");
    let elastic = ActuatorSpec::preset_text("thor-linear").expect("preset");
    let looped = elastic.replace("[motor]", servo);
    let error = ActuatorSpec::from_toml(&looped, "mine.toml").expect_err("a spring and a loop").to_string();
    assert!(error.contains("without a spring only"), "{error}");

    let spec = ActuatorSpec::from_toml(text, "mine.toml").expect("good");
    assert_eq!(ActuatorSpec::from_toml(&spec.to_toml(), "again.toml").expect("good"), spec);
    let locked = BenchModel::new(spec.clone(), Bench::Locked).expect_err("nothing moves");
    assert!(matches!(locked, ActuatorError::Value { .. }), "{locked}");
    let massless =
        BenchModel::new(ActuatorSpec::preset("thor-linear").expect("preset"), Bench::Free { load: 0.0 });
    assert!(massless.is_err());
    // A goal for a drive that has no loop.
    let plain = BenchModel::new(spec, Bench::Free { load: 0.1 }).expect("good");
    let goal = record("position_rad", vec![0.0; 20]);
    assert!(plain.predict(&values(&plain), &goal, &["joint_angle_rad".to_owned()]).is_err());
}
