//! A robot whose drives follow goals or take voltages, or whose transmissions yield: against benches and another integrator.

mod double_pendulum;

use double_pendulum::{TORQUE, TWO, farthest, robot, values};
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig, RunSetup};
use sealegs_actuator::excitation::gaussian;
use sealegs_leg::bench::{RobotFile, RobotModel};
use sealegs_model::{Excitation, InputHold, Model, Record, Signal};
use std::path::Path;

/// A mass of 0.5 kg, 0.22 m below its hinge, of next to no size.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="link"><inertial><origin xyz="0 0 -0.22"/><mass value="0.5"/>
    <inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="link"/><axis xyz="0 -1 0"/></joint>
</robot>"#;

const SERVO: &str = "id = \"servo\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.5\n\
                     rotor_inertia_kg_m2 = 0.004\nrotor_damping_nm_s = 0.01\nwinding_resistance_ohm = 2.0\nsupply_v = 12.0\n\
                     [transmission]\ntype = \"direct\"\n[servo]\nproportional_per_rad = 6.0\nderivative_s_per_rad = 0.02\n\
                     duty_limit = 0.8\ncurrent_limit_a = 4.0\nfeedback_delay_s = 0.004\n";

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn record(inputs: &[(&str, &dyn Fn(f64) -> f64)], outputs: &[(&str, f64)]) -> Record {
    let time_s: Vec<f64> = (0..1500).map(|n| f64::from(n) * 2e-3).collect();
    let signal = |name: &str, values| Signal { channel: name.to_owned(), values };
    Record {
        cut: false,
        name: "run".to_owned(),
        hold: InputHold::ZeroOrder,
        inputs: inputs.iter().map(|(name, f)| signal(name, time_s.iter().map(|t| f(*t)).collect())).collect(),
        outputs: outputs.iter().map(|(name, at)| signal(name, vec![*at; time_s.len()])).collect(),
        time_s,
    }
}

/// A robot for a record that begins at rest at the first row of each of its outputs, whatever the sensors show then.
fn at_rest(model: RobotModel, record: &Record) -> RobotModel {
    let start = record.outputs.iter().map(|angle| (angle.values[0], 0.0)).collect();
    model.for_records(&[record]).with_start(&record.name, start)
}

/// The values of a model with those of its last parameters replaced.
fn ending(model: &dyn Model, last: &[f64]) -> Vec<f64> {
    let mut all = values(model);
    let first = all.len() - last.len();
    all[first..].copy_from_slice(last);
    all
}

/// The arm on the pendulum bench, which integrates otherwise: the linear part exactly.
fn on_bench(drive: &str) -> BenchModel {
    let spec = ActuatorSpec::from_toml(drive, "drive").unwrap_or_else(|e| panic!("{e}"));
    let inertia = 0.5 * 0.22 * 0.22 + 1e-6;
    let length_m = inertia / (0.5 * 0.22);
    let rig = PendulumRig { arm_m: 1.0, length_m, mass_kg: inertia / length_m.powi(2), rod_mass_kg: 0.0 };
    BenchModel::new(spec, Bench::Pendulum(rig)).expect("a bench")
}

fn bench_record(of: &Record, spec: &ActuatorSpec) -> Record {
    let effort = if spec.is_rigid() { "joint_torque_nm" } else { "motor_torque_nm" };
    let bench_name = |column: &str| match column.rsplit_once('.').map_or(column, |(_, what)| what) {
        "torque_nm" => effort.to_owned(),
        "angle_rad" => "joint_angle_rad".to_owned(),
        other => other.to_owned(),
    };
    let renamed = |signals: &[Signal]| -> Vec<Signal> {
        signals.iter().map(|s| Signal { channel: bench_name(&s.channel), ..s.clone() }).collect()
    };
    Record { inputs: renamed(&of.inputs), outputs: renamed(&of.outputs), ..of.clone() }
}

/// How far the arm as a robot is from the arm on a bench at a finer step, rad: angles of joint and rotor.
fn off(drive: &str, record: &Record, effect: Option<(&str, &[f64])>, step_s: f64) -> f64 {
    let columns = [("hinge.angle_rad", "joint_angle_rad"), ("hinge.motor_angle_rad", "motor_angle_rad")];
    apart(drive, record, effect, step_s, &columns).into_iter().fold(0.0, f64::max)
}

/// How far the arm as a robot is from the arm on a bench at a finer step, by columns there and here.
fn apart(
    drive: &str,
    record: &Record,
    effect: Option<(&str, &[f64])>,
    step_s: f64,
    columns: &[(&str, &str)],
) -> Vec<f64> {
    let folder = folder();
    let mut arm = at_rest(robot(folder.path(), ARM, drive), record).with_step(step_s);
    let mut bench = on_bench(drive).with_step(2e-5);
    let at = bench_record(record, bench.spec());
    let setup = RunSetup::of_record(&at, bench.spec(), bench.bench(), 1.0);
    bench = bench.with_runs(vec![setup]).expect("a rig");
    let last = effect.map_or(&[][..], |(_, last)| last);
    if let Some((id, _)) = effect {
        let seen = Excitation::default();
        arm = arm.including(&format!("hinge/{id}"), &seen).unwrap_or_else(|e| panic!("{e}"));
        bench = bench.including(id, &seen).unwrap_or_else(|e| panic!("{e}"));
    }
    let (here, there): (Vec<String>, Vec<String>) =
        columns.iter().map(|(here, there)| ((*here).to_owned(), (*there).to_owned())).unzip();
    let got = arm.predict(&ending(&arm, last), record, &here).unwrap_or_else(|e| panic!("{e}"));
    let truth = bench.predict(&ending(&bench, last), &at, &there).unwrap_or_else(|e| panic!("{e}"));
    let moved = truth.outputs[0].values.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
    assert!(moved > 0.1, "{moved}");
    got.outputs.iter().zip(&truth.outputs).map(|(got, truth)| farthest(&got.values, &truth.values)).collect()
}

fn goal(t: f64) -> f64 {
    0.6 * (2.0 * t).sin() + if t > 1.0 { 0.4 } else { 0.0 }
}

#[test]
fn reference_a_joint_that_follows_goals_is_as_on_its_bench() {
    let record = record(&[("hinge.position_rad", &goal)], &[("hinge.angle_rad", 0.0)]);
    let error = |step_s: f64| off(SERVO, &record, None, step_s);
    assert!(error(5e-4) < 1e-3, "{}", error(5e-4));
    assert!(error(2.5e-4) < 0.5 * error(1e-3), "{} {}", error(2.5e-4), error(1e-3));
}

/// A joint under impedance control: 30 N m/rad, 0.4 N m s/rad, 6 N m at most.
const IMPEDANCE: &str = "id = \"impedance\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 1.0\n\
                         rotor_inertia_kg_m2 = 0.004\nrotor_damping_nm_s = 0.01\n[transmission]\ntype = \"direct\"\n[servo]\n\
                         proportional_nm_per_rad = 30.0\nderivative_nm_s_per_rad = 0.4\ntorque_limit_nm = 6.0\n";

#[test]
fn reference_a_joint_under_impedance_control_is_as_on_its_bench() {
    let speed = |t: f64| (goal(t + 1e-4) - goal(t - 1e-4)) / 2e-4;
    let added = |t: f64| if t > 1.0 { 0.8 } else { 0.0 };
    let record = record(
        &[
            ("hinge.position_rad", &goal),
            ("hinge.goal_speed_rad_s", &|t| speed(t).clamp(-5.0, 5.0)),
            ("hinge.feedforward_nm", &added),
        ],
        &[("hinge.angle_rad", 0.0)],
    );
    let error = |drive: &str, step_s: f64| off(drive, &record, None, step_s);
    assert!(error(IMPEDANCE, 5e-4) < 1e-3, "{}", error(IMPEDANCE, 5e-4));
    assert!(error(IMPEDANCE, 2.5e-4) < 0.5 * error(IMPEDANCE, 1e-3));
    // A loop that samples at 500 Hz and sees its joint late rings more than one that does not.
    let sampled = format!("{IMPEDANCE}rate_hz = 500.0\nfeedback_delay_s = 0.002\n");
    assert!(error(&sampled, 2.5e-4) < 3e-3, "{}", error(&sampled, 2.5e-4));
    let moves = |drive: &str| {
        let folder = folder();
        let arm = at_rest(robot(folder.path(), ARM, drive), &record);
        arm.predict(&values(&arm), &record, &["hinge.angle_rad".to_owned()]).expect("finite").outputs
    };
    assert!(farthest(&moves(&sampled)[0].values, &moves(IMPEDANCE)[0].values) > 5e-3);
}

#[test]
fn a_joint_under_impedance_control_says_what_it_takes() {
    let folder = folder();
    let arm = robot(folder.path(), ARM, IMPEDANCE);
    let told = |columns: &[&str]| {
        record(&columns.iter().map(|c| (*c, &goal as &dyn Fn(f64) -> f64)).collect::<Vec<_>>(), &[])
    };
    let beside = told(&["hinge.position_rad", "hinge.goal_speed_rad_s"]);
    assert_eq!(arm.refuses_input(&beside, "hinge.goal_speed_rad_s"), None);
    // Beside a torque there is no loop, and a hobby servo's takes neither.
    let torque = told(&["hinge.torque_nm", "hinge.feedforward_nm"]);
    assert!(arm.refuses_input(&torque, "hinge.feedforward_nm").expect("refused").contains("position_rad"));
    let hobby = robot(folder.path(), ARM, SERVO);
    assert!(hobby.refuses_input(&beside, "hinge.goal_speed_rad_s").is_some());
    assert!(arm.refuses_input(&told(&["hinge.voltage_v"]), "hinge.voltage_v").is_some());
    for (wrong, says) in [
        ("proportional_per_rad = 2.0\n", "proportional_per_rad"),
        ("current_limit_a = 2.0\n", "current_limit_a"),
    ] {
        let error = ActuatorSpec::from_toml(&format!("{IMPEDANCE}{wrong}"), "drive").expect_err(wrong);
        assert!(
            error.to_string().contains(says) && error.to_string().contains("commands a torque"),
            "{error}"
        );
    }
    let none = IMPEDANCE.replace("proportional_nm_per_rad = 30.0\n", "");
    let error = ActuatorSpec::from_toml(&none, "drive").expect_err("no gain");
    assert!(error.to_string().contains("derivative_nm_s_per_rad"), "{error}");
}

#[test]
fn reference_a_run_has_its_servo_gain() {
    const GAIN: f64 = 0.3;
    let record = record(&[("hinge.position_rad", &goal)], &[("hinge.angle_rad", 0.0)]);
    let folder = folder();
    let arm = robot(folder.path(), ARM, SERVO);
    let bench = on_bench(SERVO).with_step(2e-5);
    let at = bench_record(&record, bench.spec());
    let setup = RunSetup::of_record(&at, bench.spec(), bench.bench(), GAIN);
    let bench = bench.with_runs(vec![setup]).expect("a rig");
    let truth = bench.predict(&values(&bench), &at, &["joint_angle_rad".to_owned()]).expect("finite");
    let off = |arm: &RobotModel| {
        let shown = arm.predict(&values(arm), &record, &["hinge.angle_rad".to_owned()]).expect("finite");
        farthest(&shown.outputs[0].values, &truth.outputs[0].values)
    };
    assert!(off(&at_rest(arm.clone(), &record)) > 0.05);
    assert_eq!(arm.servos(), ["hinge"]);
    let gains = [("hinge".to_owned(), GAIN)].into();
    let with = arm.with_servo_gains([(record.name.clone(), gains)].into()).with_step(5e-4);
    let with = at_rest(with, &record);
    assert!(off(&with) < 1e-3, "{}", off(&with));
}

#[test]
fn reference_a_joint_under_a_voltage_with_supply_and_switch() {
    let volts = |t: f64| 3.0 * (5.0 * t).sin() + if t > 0.5 { 2.0 } else { -1.0 };
    let voltage = record(&[("hinge.voltage_v", &volts)], &[("hinge.angle_rad", 0.3)]);
    assert!(off(SERVO, &voltage, None, 5e-4) < 1e-3);
    // All joints share a supply that sags and a switch that is off in the middle.
    let supply = |t: f64| 12.0 - 3.0 * t;
    let enable = |t: f64| f64::from(!(1.2..1.8).contains(&t));
    let fed = record(
        &[("hinge.position_rad", &goal), ("supply_v", &supply), ("hinge.enable", &enable)],
        &[("hinge.angle_rad", 0.0)],
    );
    assert!(off(SERVO, &fed, None, 5e-4) < 1e-3);
    let plain = record(&[("hinge.position_rad", &goal)], &[("hinge.angle_rad", 0.0)]);
    let (a, b) = (folder(), folder());
    let moves = |at: &Path, record: &Record| {
        let arm = at_rest(robot(at, ARM, SERVO), record);
        arm.predict(&values(&arm), record, &["hinge.angle_rad".to_owned()]).expect("finite").outputs
    };
    let parted = farthest(&moves(a.path(), &fed)[0].values, &moves(b.path(), &plain)[0].values);
    assert!(parted > 0.1, "the switch does nothing: {parted}");
}

#[test]
fn reference_a_transmission_that_yields_or_has_play_is_as_on_its_bench() {
    let torque = |t: f64| 0.9 * (4.0 * t).sin() + 0.2 * (17.0 * t).cos();
    let torques = record(&[("hinge.torque_nm", &torque)], &[("hinge.angle_rad", 0.2)]);
    let goals = record(&[("hinge.position_rad", &goal)], &[("hinge.angle_rad", 0.0)]);
    // A stiff loop that sees the joint behind a soft transmission would swing up; that of a rotor does not.
    let by_motor = format!("{IMPEDANCE}feedback = \"motor\"\n");
    for (drive, record) in [(TORQUE, &torques), (SERVO, &goals), (by_motor.as_str(), &goals)] {
        let soft = |step_s| off(drive, record, Some(("series-compliance", &[25.0, 0.05])), step_s);
        assert!(soft(5e-4) < 2e-3, "{}", soft(5e-4));
        assert!(soft(2.5e-4) < 0.5 * soft(1e-3), "{} {}", soft(2.5e-4), soft(1e-3));
        let play = |step_s| off(drive, record, Some(("backlash", &[0.04, 300.0])), step_s);
        assert!(play(2e-4) < 4e-3, "{}", play(2e-4));
    }
    // A loop that sees the rotor leaves the joint behind by what the transmission yields and by its play.
    let ends = |drive: &str| {
        let folder = folder();
        let arm = robot(folder.path(), ARM, drive).including("hinge/backlash", &Excitation::default());
        let arm = at_rest(arm.expect("play"), &goals);
        let shown = arm.predict(&ending(&arm, &[0.04, 300.0]), &goals, &["hinge.angle_rad".to_owned()]);
        shown.expect("finite").outputs.swap_remove(0).values
    };
    assert!(farthest(&ends(IMPEDANCE), &ends(&by_motor)) > 0.01);
}

/// A rotary drive with a spring of 60 N m/rad and 0.02 kg m^2 of rotor at the joint.
const SPRUNG: &str = "id = \"sprung\"\nkind = \"rotary\"\n[motor]\ntorque_constant_nm_a = 0.1\n\
                      rotor_inertia_kg_m2 = 2e-4\nrotor_damping_nm_s = 1e-3\n[transmission]\ntype = \"gear\"\n\
                      gear_ratio = 10.0\n[spring]\ntype = \"torsion\"\nstiffness_nm_rad = 60.0\n";

#[test]
fn reference_a_joint_with_a_series_spring_is_as_on_its_bench() {
    let torque = |t: f64| 1.2 * (4.0 * t).sin() + 0.3 * (17.0 * t).cos();
    let current = |t: f64| torque(t);
    let torques = record(&[("hinge.torque_nm", &torque)], &[("hinge.angle_rad", 0.0)]);
    let currents = record(&[("hinge.current_a", &current)], &[("hinge.angle_rad", 0.0)]);
    let columns = [
        ("hinge.angle_rad", "joint_angle_rad"),
        ("hinge.motor_angle_rad", "motor_angle_rad"),
        ("hinge.spring_deflection_rad", "spring_deflection_rad"),
        ("hinge.spring_torque_nm", "spring_torque_nm"),
        ("hinge.output_torque_nm", "output_torque_nm"),
    ];
    // Swings of 0.5 rad, 5 rad of the rotor, 0.02 rad of the spring, 1 N m.
    let admitted = [1e-3, 1e-2, 1e-4, 5e-3, 5e-3];
    for effect in [
        None,
        Some(("coulomb-friction", &[0.3][..])),
        Some(("spring-hysteresis", &[40.0, 0.2])),
        Some(("spring-damping", &[0.3])),
        Some(("output-friction", &[0.2])),
        Some(("backlash", &[0.02])),
    ] {
        let error = |step_s| apart(SPRUNG, &torques, effect, step_s, &columns);
        let (coarse, fine) = (error(4e-4), error(1e-4));
        for (i, at_most) in admitted.into_iter().enumerate() {
            assert!(fine[i] < at_most && fine[i] < 0.5 * coarse[i], "{effect:?} {fine:?} {coarse:?}");
        }
    }
    assert!(apart(SPRUNG, &currents, None, 2e-4, &columns)[0] < 1e-3);
}

#[test]
fn reference_a_start_is_told_from_noisy_rows_under_torque() {
    let noise = |n: i64| 3e-4 * gaussian(1, n);
    let torque = |t: f64| 1.2 * (4.0 * t).cos();
    for (drive, start) in [(SPRUNG, (0.0, 0.0)), (TORQUE, (0.2, 1.5)), (TORQUE, (0.2, 0.0))] {
        let mut seen = record(&[("hinge.torque_nm", &torque)], &[("hinge.angle_rad", 0.0)]);
        let bench = on_bench(drive).with_step(2e-5);
        let at = bench_record(&seen, bench.spec());
        let setup = RunSetup { start, ..RunSetup::of_record(&at, bench.spec(), bench.bench(), 1.0) };
        let bench = bench.with_runs(vec![setup]).expect("a rig");
        let truth = bench.predict(&values(&bench), &at, &["joint_angle_rad".to_owned()]).expect("finite");
        seen.outputs[0].values = truth.outputs[0].values.iter().zip(0..).map(|(a, n)| a + noise(n)).collect();
        let folder = folder();
        let arm = robot(folder.path(), ARM, drive).for_records(&[&seen]).starting_as(&seen).expect("finite");
        let (q, v) = arm.starts().next().expect("a start").1[0];
        // Its first 20 ms tell the speed to 0.1 rad/s, 0.5 s without what the torque does to 0.03.
        assert!((q - start.0).abs() < 3e-4 && (v - start.1).abs() < 5e-3, "{start:?} {q} {v}");
    }
}

/// The textbook's double pendulum whose motors drive both joints by springs, in steps of 1 us; `gap` is the play of both.
fn reference(stiffness: [f64; 2], damping_ratio: f64, gap: f64) -> [Vec<f64>; 2] {
    const FINE: usize = 2000;
    let (m1, r1, i1, l1, m2, r2, i2) = (0.608, 0.275, 0.0087, 0.3, 0.63, 0.166, 0.0078);
    let (rotor, damping, g) = (6e-5 * 36.0, 1e-3 * 36.0, 9.81);
    let inertia = |c: f64| {
        let lower = i2 + m2 * r2 * r2;
        (i1 + m1 * r1 * r1 + lower + m2 * l1 * l1 + 2.0 * m2 * l1 * r2 * c, lower + m2 * l1 * r2 * c, lower)
    };
    // The damper is that of rotor against the load of the posture zero.
    let (at_zero, _, lower) = inertia(1.0);
    let damper = [at_zero, lower].map(|load| 1.0 / (1.0 / rotor + 1.0 / load));
    let damper = [0, 1].map(|i| 2.0 * damping_ratio * (stiffness[i] * damper[i]).sqrt());
    let (mut q, mut v) = ([0.0_f64; 2], [0.0_f64; 2]);
    let (mut y, mut w) = (q, v);
    let h = 2e-3 / FINE as f64;
    let mut out = [vec![q[0]], vec![q[1]]];
    for n in 0..1499 {
        let t = f64::from(n) * 2e-3;
        let u = [torque(0, t), torque(1, t)];
        for _ in 0..FINE {
            let pass = [0, 1].map(|i| {
                let e = y[i] - q[i];
                let left = e - e.clamp(-0.5 * gap, 0.5 * gap);
                if left == 0.0 && gap > 0.0 { 0.0 } else { stiffness[i] * left + damper[i] * (w[i] - v[i]) }
            });
            let s = m2 * l1 * r2 * q[1].sin();
            let (a, b, d) = inertia(q[1].cos());
            let g2 = m2 * g * r2 * (q[0] + q[1]).sin();
            let f0 =
                pass[0] + s * (2.0 * v[0] * v[1] + v[1] * v[1]) - (m1 * r1 + m2 * l1) * g * q[0].sin() - g2;
            let f1 = pass[1] - s * v[0] * v[0] - g2;
            let det = a * d - b * b;
            v[0] += h * (d * f0 - b * f1) / det;
            v[1] += h * (a * f1 - b * f0) / det;
            for i in 0..2 {
                w[i] += h * (u[i] - damping * w[i] - pass[i]) / rotor;
                q[i] += h * v[i];
                y[i] += h * w[i];
            }
        }
        out[0].push(q[0]);
        out[1].push(q[1]);
    }
    out
}

fn torque(joint: usize, t: f64) -> f64 {
    [2.0 * (3.0 * t).sin() + 0.5 * (11.0 * t).sin(), 0.8 * (5.0 * t).sin()][joint]
}

#[test]
fn reference_a_double_pendulum_with_soft_and_loose_joints() {
    let folder = folder();
    let record = record(
        &[("shoulder.torque_nm", &|t| torque(0, t)), ("elbow.torque_nm", &|t| torque(1, t))],
        &[("shoulder.angle_rad", 0.0), ("elbow.angle_rad", 0.0)],
    );
    let channels = ["shoulder.angle_rad", "elbow.angle_rad"].map(str::to_owned);
    let mut soft = at_rest(robot(folder.path(), TWO, TORQUE), &record);
    let mut loose = soft.clone();
    for joint in ["shoulder", "elbow"] {
        let seen = Excitation::default();
        soft = soft.including(&format!("{joint}/series-compliance"), &seen).expect("offered");
        loose = loose.including(&format!("{joint}/backlash"), &seen).expect("offered");
    }
    let error = |model: &RobotModel, last: &[f64], truth: &[Vec<f64>; 2], step_s: f64| {
        let model = model.clone().with_step(step_s);
        let got = model.predict(&ending(&model, last), &record, &channels).expect("finite").outputs;
        (0..2).map(|i| farthest(&got[i].values, &truth[i])).fold(0.0, f64::max)
    };
    let truth = reference([40.0, 15.0], 0.05, 0.0);
    let values = [40.0, 0.05, 15.0, 0.05];
    let (coarse, fine) = (error(&soft, &values, &truth, 1e-3), error(&soft, &values, &truth, 2.5e-4));
    assert!(fine < 3e-3 && fine < 0.3 * coarse, "{fine} {coarse}");
    let truth = reference([300.0, 300.0], 0.1, 0.03);
    let loose = error(&loose, &[0.03, 300.0, 0.03, 300.0], &truth, 1e-4);
    assert!(loose < 0.03, "{loose}");
}

#[test]
fn a_soft_joint_without_damping_gains_no_energy() {
    let folder = folder();
    let drive = TORQUE.replace("rotor_damping_nm_s = 1e-3", "rotor_damping_nm_s = 0.0");
    let record = record(&[("hinge.torque_nm", &|_| 0.0)], &[("hinge.angle_rad", 1.0)]);
    let arm = at_rest(robot(folder.path(), ARM, &drive), &record);
    for (id, last) in [("series-compliance", [30.0, 0.0]), ("backlash", [0.05, 200.0])] {
        let arm = arm.including(&format!("hinge/{id}"), &Excitation::default()).expect("offered");
        for step_s in [1e-3, 2e-4] {
            let arm = arm.clone().with_step(step_s);
            let channels =
                ["hinge.angle_rad", "hinge.speed_rad_s", "hinge.motor_angle_rad"].map(str::to_owned);
            let got = arm.predict(&ending(&arm, &last), &record, &channels).expect("finite").outputs;
            let energy = |n: usize| {
                let (q, v, y) = (got[0].values[n], got[1].values[n], got[2].values[n] / 6.0);
                let rotor = if n == 0 { 0.0 } else { (y - got[2].values[n - 1] / 6.0) / 2e-3 };
                let (half, k) = if id == "backlash" { (0.5 * last[0], last[1]) } else { (0.0, last[0]) };
                let left = (y - q) - (y - q).clamp(-half, half);
                0.5 * (0.5 * 0.22 * 0.22 + 1e-6) * v * v
                    + 0.5 * 6e-5 * 36.0 * rotor * rotor
                    + 0.5 * k * left * left
                    - 0.5 * 9.81 * 0.22 * q.cos()
            };
            let depth = 2.0 * 0.5 * 9.81 * 0.22;
            let most = (0..1500).map(energy).fold(f64::MIN, f64::max);
            // The rotor's speed is taken from its angles, half a sample late: 2 % of the energy.
            assert!(most < energy(0) + 0.02 * depth, "{id} {step_s}: {most} {}", energy(0));
        }
    }
}

#[test]
fn what_commands_a_joint_is_said() {
    let folder = folder();
    let arm = robot(folder.path(), ARM, SERVO);
    let told = |columns: &[&str]| {
        record(&columns.iter().map(|c| (*c, &goal as &dyn Fn(f64) -> f64)).collect::<Vec<_>>(), &[])
    };
    for column in [
        "hinge.position_rad",
        "hinge.voltage_v",
        "hinge.current_a",
        "hinge.torque_nm",
        "hinge.enable",
        "supply_v",
    ] {
        assert_eq!(arm.refuses_input(&told(&[column, "hinge.enable"]), column), None, "{column}");
    }
    assert!(arm.refuses_input(&told(&[]), "hinge.force_n").is_some());
    // A plain drive has neither winding nor loop.
    let plain = robot(folder.path(), ARM, TORQUE);
    assert!(
        plain.refuses_input(&told(&[]), "hinge.position_rad").expect("no loop").contains("hinge.torque_nm")
    );
    let both = record(&[("hinge.position_rad", &goal), ("hinge.torque_nm", &goal)], &[]);
    let arm = robot(folder.path(), ARM, SERVO);
    let error = arm.predict(&values(&arm), &both, &["hinge.angle_rad".to_owned()]).expect_err("two commands");
    assert!(error.to_string().contains("hinge.torque_nm"), "{error}");
    let twice = arm.refuses_input(&both, "hinge.position_rad").expect("two commands");
    assert!(twice.contains("'hinge.torque_nm'"), "{twice}");
    // Only what a torque does not feel is kept from a fit.
    let fixed = |record: &Record| {
        let arm = robot(folder.path(), ARM, SERVO).for_records(&[record]);
        arm.parameters().iter().any(|p| p.name == "hinge/force_constant" && p.fixed)
    };
    assert!(fixed(&record(&[("hinge.torque_nm", &goal)], &[])));
    assert!(!fixed(&record(&[("hinge.position_rad", &goal)], &[])));
}

#[test]
fn a_joint_that_is_held_is_one_that_the_urdf_fixes_there() {
    let (held, fixed) = (folder(), folder());
    robot(held.path(), TWO, TORQUE);
    let mut file = RobotFile::of_urdf("robot.urdf", "drive.toml", held.path());
    file.hold.insert("elbow".to_owned(), 0.4);
    let held = RobotModel::new(file.clone(), &[]).unwrap_or_else(|e| panic!("{e}"));
    // The elbow turns about -y.
    let at = "<origin xyz=\"0 0 -0.3\"/>";
    let urdf = TWO
        .replace("name=\"elbow\" type=\"continuous\"", "name=\"elbow\" type=\"fixed\"")
        .replace(at, "<origin xyz=\"0 0 -0.3\" rpy=\"0 -0.4 0\"/>");
    assert!(urdf.contains("rpy=\"0 -0.4 0\"") && urdf.contains("type=\"fixed\""));
    let fixed = robot(fixed.path(), &urdf, TORQUE);
    let record =
        record(&[("shoulder.torque_nm", &|t| 2.0 * (3.0 * t).sin())], &[("shoulder.angle_rad", 0.1)]);
    let angle = |model: RobotModel| {
        let model = at_rest(model, &record);
        let channels = ["shoulder.angle_rad".to_owned()];
        let predicted = model.predict(&values(&model), &record, &channels).unwrap_or_else(|e| panic!("{e}"));
        predicted.output("shoulder.angle_rad").expect("the angle").to_vec()
    };
    let (held, fixed) = (angle(held), angle(fixed));
    assert!(farthest(&held, &[held[0]; 1500]) > 0.1 && farthest(&held, &fixed) < 1e-9);

    file.hold = [("elbo".to_owned(), 0.0)].into();
    assert!(RobotModel::new(file.clone(), &[]).unwrap_err().to_string().contains("did you mean 'elbow'"));
    file.hold = [("elbow".to_owned(), f64::NAN)].into();
    assert!(RobotModel::new(file, &[]).unwrap_err().to_string().contains("hold.elbow"));
}

/// Two arms on one base.
const TWO_ARMS: &str = r#"<robot name="arms">
  <link name="base"/>
  <link name="left"><inertial><origin xyz="0 0 -0.22"/><mass value="0.5"/>
    <inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right"><inertial><origin xyz="0 0 -0.22"/><mass value="0.5"/>
    <inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="left"/><axis xyz="0 -1 0"/></joint>
  <joint name="other" type="continuous"><parent link="base"/><child link="right"/><axis xyz="0 -1 0"/></joint>
</robot>"#;

#[test]
fn parts_that_do_not_move_one_another_are_as_alone_whatever_was_simulated_before() {
    let slower = |t: f64| 0.5 * goal(0.7 * t);
    let both = record(
        &[("hinge.position_rad", &goal), ("other.position_rad", &slower)],
        &[("hinge.angle_rad", 0.0), ("other.angle_rad", 0.0)],
    );
    let alone = record(&[("hinge.position_rad", &goal)], &[("hinge.angle_rad", 0.0)]);
    let (a, b) = (folder(), folder());
    let arms = at_rest(robot(a.path(), TWO_ARMS, IMPEDANCE), &both);
    let arm = at_rest(robot(b.path(), ARM, IMPEDANCE), &alone);
    let shown = |model: &RobotModel, values: &[f64], record: &Record| {
        let channels: Vec<String> = record.outputs.iter().map(|o| o.channel.clone()).collect();
        model.predict(values, record, &channels).expect("finite").outputs
    };
    let first = shown(&arms, &values(&arms), &both);
    assert_eq!(first[0].values, shown(&arm, &values(&arm), &alone)[0].values);
    // A value of one arm changes that arm alone, and what was kept of the other one is what it was.
    let mut heavier = values(&arms);
    let mass = arms.parameters().iter().position(|p| p.name == "right/mass").expect("a mass");
    heavier[mass] *= 1.2;
    let changed = shown(&arms, &heavier, &both);
    assert_eq!(changed[0].values, first[0].values);
    assert!(farthest(&changed[1].values, &first[1].values) > 1e-4);
    let fresh = at_rest(robot(a.path(), TWO_ARMS, IMPEDANCE), &both);
    assert_eq!(shown(&fresh, &heavier, &both), changed);
    // Other commands under the same name are another run.
    let mut turned = both.clone();
    turned.inputs[0].values.iter_mut().for_each(|goal| *goal = -*goal);
    assert_eq!(shown(&arms, &values(&arms), &turned), shown(&fresh, &values(&fresh), &turned));
    assert_eq!(shown(&arms, &values(&arms), &both), first);
}
