//! Drives at joints run in MuJoCo itself: what a model gains in our simulator it must gain there.
//!
//! The carriage's truth is the independent simulator's: a drive on a locked bench without stiffness, whose sprung mass is the
//! load. It has no pendulum that a drive turns directly, and no robot with drives at joints: there the truth is our own model
//! at a twentieth of its step, and what is tested is MuJoCo. Its error may be 2 % of what the effects do: friction is a soft
//! constraint in MuJoCo and takes two steps, 0.2 ms, to stop a joint, of stops that are some 0.1 s apart.

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig, RunSetup};
use sealegs_export::Fate;
use sealegs_leg::bench::{RobotFile, RobotModel};
use sealegs_model::{Excitation, InputHold, Model, Record, Signal};
use sealegs_reference::Reference;
use sealegs_tests::mujoco::{BenchJob, at, everything, job, python, rms, robot_job, run};
use std::path::Path;

/// Rows per second.
const RATE_HZ: f64 = 1000.0;

/// A drive without a spring: 0.354 N m/A, 3.4 ohm, and `more` of its file.
fn drive(kind: &str, more: &str) -> ActuatorSpec {
    let text = format!(
        "id = \"drive\"\nkind = \"{kind}\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.354\nwinding_resistance_ohm = \
         3.4\nsupply_v = 7.4\nrotor_inertia_kg_m2 = 2e-3\nrotor_damping_nm_s = 4e-3\n[transmission]\ntype = \"direct\"\n{more}"
    );
    ActuatorSpec::from_toml(&text, "drive.toml").unwrap()
}

/// Two sines and a step, of so many seconds: it turns round, and rests at last.
fn command(size: f64, seconds: f64) -> Vec<f64> {
    let n = (seconds * RATE_HZ) as usize;
    let of = |t: f64| {
        let step = if (0.4..0.6).contains(&(t / seconds)) { 0.5 } else { 0.0 };
        let moves = if t < 0.85 * seconds { 0.7 * (7.0 * t).sin() + 0.4 * (19.0 * t).sin() } else { 0.1 };
        size * (moves + step)
    };
    (0..n).map(|i| of(i as f64 / RATE_HZ)).collect()
}

fn record(inputs: Vec<(&str, Vec<f64>)>) -> Record {
    let rows = inputs[0].1.len();
    Record {
        cut: false,
        name: "run.csv".to_owned(),
        time_s: (0..rows).map(|i| i as f64 / RATE_HZ).collect(),
        hold: InputHold::ZeroOrder,
        inputs: inputs
            .into_iter()
            .map(|(channel, values)| Signal { channel: channel.to_owned(), values })
            .collect(),
        outputs: Vec::new(),
    }
}

/// A model on a bench, beginning at a position and speed of its own coordinate, with effects and their values.
fn on_bench(spec: &ActuatorSpec, bench: Bench, start: (f64, f64), effects: &[(&str, &[f64])]) -> BenchModel {
    let mut model = BenchModel::new(spec.clone(), bench).unwrap();
    let mut values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    for (id, own) in effects {
        model = model.including(id, &everything()).unwrap();
        values.extend(*own);
    }
    let setup = RunSetup { record: "run.csv".to_owned(), bench, start, first_rows: None, servo_gain: 1.0 };
    at(&model, &values).with_runs(vec![setup]).unwrap()
}

fn nominal(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

/// One comparison: a channel's truth, and what our simulator and MuJoCo show of it without and with the effects.
struct Case {
    name: &'static str,
    channel: &'static str,
    truth: Vec<f64>,
    ours: [Vec<f64>; 2],
    /// The greatest departure of MuJoCo's fall from ours, as a share.
    most: f64,
}

/// Without and with: our predictions, and MuJoCo's jobs.
fn pair(models: [&BenchModel; 2], record: &Record, channel: &str) -> ([Vec<f64>; 2], [BenchJob; 2]) {
    let ours = models.map(|model| {
        let shown = model.predict(&nominal(model), record, &[channel.to_owned()]).unwrap();
        shown.outputs[0].values.clone()
    });
    (ours, models.map(|model| job(model, &[record])))
}

/// What our model shows at a twentieth of its step.
fn fine(model: &BenchModel, record: &Record, channel: &str) -> Vec<f64> {
    let fine = model.clone().with_step(5e-6);
    fine.predict(&nominal(model), record, &[channel.to_owned()]).unwrap().outputs[0].values.clone()
}

fn carriage() -> (Case, [BenchJob; 2]) {
    let spec =
        drive("linear", "[parameters.reflected_inertia]\nvalue = 20.0\n[parameters.damping]\nvalue = 30.0\n");
    let bench = Bench::Free { load: 12.0 };
    let record = record(vec![("motor_force_n", command(60.0, 2.0))]);
    let (plain, rubbed) = (
        on_bench(&spec, bench, (0.0, 0.0), &[]),
        on_bench(&spec, bench, (0.0, 0.0), &[("coulomb-friction", &[15.0])]),
    );
    let truth = Reference::new(20.0, 12.0, 30.0, 0.0).with("coulomb-friction", &[15.0]).run(
        1.0 / RATE_HZ,
        &record.inputs[0].values,
        100,
    );
    let (ours, jobs) = pair([&plain, &rubbed], &record, "position_m");
    (Case { name: "carriage, Coulomb", channel: "position_m", truth: truth.extension, ours, most: 0.1 }, jobs)
}

fn on_pendulum(
    name: &'static str,
    (spec, rig): (ActuatorSpec, PendulumRig),
    (input, size): (&str, f64),
    effects: &[(&str, &[f64])],
) -> (Case, [BenchJob; 2]) {
    let bench = Bench::Pendulum(rig);
    let start = (0.1 * rig.arm_m, 0.2 * rig.arm_m);
    let record = record(vec![(input, command(size, 2.0))]);
    let (plain, with) = (on_bench(&spec, bench, start, &[]), on_bench(&spec, bench, start, effects));
    let truth = fine(&with, &record, "joint_angle_rad");
    let (ours, jobs) = pair([&plain, &with], &record, "joint_angle_rad");
    (Case { name, channel: "joint_angle_rad", truth, ours, most: 0.02 }, jobs)
}

/// The double pendulum, its elbow driven by `elbow` in the place of its own drive if that is something, without and with
/// effects, and with a lower link that is heavier than the URDF's, as a fit leaves it.
fn robot(
    name: &'static str,
    elbow: Option<&str>,
    effects: &[(&str, &[f64])],
    channel: &'static str,
) -> (Case, [BenchJob; 2]) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/campaigns/real/double-pendulum");
    let mut file = RobotFile::of_urdf("design-a.urdf", "drive-a.toml", &folder);
    let own = tempfile::tempdir().unwrap();
    if let Some(elbow) = elbow {
        let path = own.path().join("elbow.toml");
        std::fs::write(&path, elbow).unwrap();
        file.drive.insert("elbow".to_owned(), path.to_str().unwrap().to_owned());
    }
    let plain = RobotModel::new(file, &[]).unwrap();
    let (mut with, mut values) = (plain.clone(), plain.nominal());
    for (id, own) in effects {
        with = with.including(id, &Excitation::default()).unwrap();
        values.extend(*own);
    }
    let mass = with.parameters().iter().position(|p| p.name == "lower/mass").unwrap();
    values[mass] *= 1.05;
    let with = RobotModel::new(with.fitted_file(&values, &[]), &[]).unwrap();
    let torque = command(1.0, 2.0);
    let late: Vec<f64> = torque.iter().map(|u| 1.5 * u).collect();
    let mut record = record(vec![("shoulder.torque_nm", late), ("elbow.torque_nm", torque)]);
    for (channel, start) in [("shoulder.angle_rad", 0.2), ("elbow.angle_rad", -0.3)] {
        let values = vec![start; record.time_s.len()];
        record.outputs.push(Signal { channel: channel.to_owned(), values });
    }
    let models = [plain, with].map(|model| model.for_records(&[&record]));
    let show = |model: &RobotModel| {
        let shown = model.predict(&model.nominal(), &record, &[channel.to_owned()]).unwrap();
        shown.outputs[0].values.clone()
    };
    let truth = show(&models[1].clone().with_step(2.5e-5));
    let ours = models.each_ref().map(show);
    let jobs = models.each_ref().map(|model| robot_job(model, &[&record]));
    (Case { name, channel, truth, ours, most: 0.02 }, jobs)
}

/// A drive with a series spring for a joint of that robot.
const SPRUNG: &str = "id = \"sprung\"\nkind = \"rotary\"\n[motor]\ntorque_constant_nm_a = 0.1\n\
                      rotor_inertia_kg_m2 = 2e-4\nrotor_damping_nm_s = 1e-3\n[transmission]\ntype = \"gear\"\n\
                      gear_ratio = 10.0\n[spring]\ntype = \"torsion\"\nstiffness_nm_rad = 60.0\n";

#[test]
fn reference_the_error_of_drives_at_joints_falls_in_mujoco_as_it_falls_here() {
    let Some(python) = python(Path::new(env!("CARGO_TARGET_TMPDIR"))) else { return };
    let rod = PendulumRig { arm_m: 1.0, length_m: 0.15, mass_kg: 0.3, rod_mass_kg: 0.1 };
    let lever = PendulumRig { arm_m: -0.05, length_m: 0.3, mass_kg: 2.0, rod_mass_kg: 0.0 };
    let heavy = "[parameters.reflected_inertia]\nvalue = 20.0\n[parameters.damping]\nvalue = 60.0\n";
    let simple = "[servo]\nproportional_per_rad = 1.5\n";
    let impedance = "[servo]\nproportional_nm_per_rad = 12.0\nderivative_nm_s_per_rad = 0.3\ntorque_limit_nm = 1.5\n\
                     command_delay_s = 0.01\n";
    let full = "[servo]\nproportional_per_rad = 1.5\nderivative_s_per_rad = 0.01\nintegral_per_rad_s = 2.0\nduty_dead_zone = \
                0.03\ncurrent_limit_a = 1.0\ndead_band_rad = 0.01\ncommand_delay_s = 0.01\nfeedback_delay_s = 0.004\nrate_hz = \
                250.0\n";
    let stribeck: (&str, &[f64]) = ("stribeck-friction", &[0.03, 0.08, 0.5]);
    let load: (&str, &[f64]) = ("load-dependent-friction", &[0.15]);
    let cases = [
        carriage(),
        on_pendulum(
            "torque, friction by the load",
            (drive("rotary", ""), rod),
            ("joint_torque_nm", 0.5),
            &[load],
        ),
        on_pendulum(
            "servo, Stribeck and load",
            (drive("rotary", simple), rod),
            ("position_rad", 0.8),
            &[stribeck, load],
        ),
        on_pendulum(
            "servo on a lever, Coulomb",
            (drive("rotary", simple), PendulumRig { arm_m: -0.5, ..rod }),
            ("position_rad", 0.4),
            &[("coulomb-friction", &[0.05])],
        ),
        on_pendulum(
            "impedance control with a limit, Stribeck and load",
            (drive("rotary", impedance), PendulumRig { arm_m: -0.5, ..rod }),
            ("position_rad", 0.4),
            &[stribeck, load],
        ),
        on_pendulum(
            "servo with all it may have",
            (drive("rotary", full), rod),
            ("position_rad", 0.8),
            &[stribeck, load],
        ),
        on_pendulum(
            "voltage, sag and Coulomb",
            (drive("rotary", ""), rod),
            ("voltage_v", 4.0),
            &[("supply-sag", &[2.0]), ("coulomb-friction", &[0.05])],
        ),
        on_pendulum(
            "lever of negative arm, Stribeck and ripple",
            (drive("linear", heavy), lever),
            ("motor_force_n", 150.0),
            &[("stribeck-friction", &[20.0, 40.0, 0.01]), ("torque-ripple", &[10.0, 1.0, 0.3])],
        ),
        on_pendulum(
            "servo with play that sees its output",
            (drive("rotary", simple), rod),
            ("position_rad", 0.8),
            &[("backlash", &[0.03, 40.0])],
        ),
        robot(
            "robot of two joints",
            None,
            &[
                ("shoulder/coulomb-friction", &[0.15]),
                ("shoulder/quadratic-drag", &[0.01]),
                ("shoulder/transport-delay", &[0.005]),
                ("elbow/stribeck-friction", &[0.05, 0.12, 0.3]),
                ("elbow/load-dependent-friction", &[0.08]),
                ("elbow/current-saturation", &[0.9]),
            ],
            "elbow.angle_rad",
        ),
        robot(
            "robot, elbow behind a spring",
            Some(SPRUNG),
            &[
                ("elbow/coulomb-friction", &[0.1]),
                ("elbow/hardening-spring", &[2e4]),
                ("elbow/spring-damping", &[0.2]),
                ("elbow/output-friction", &[0.08]),
            ],
            "elbow.angle_rad",
        ),
        robot(
            "the same, its spring's torque, by the load",
            Some(SPRUNG),
            &[("elbow/load-dependent-friction", &[0.1]), ("elbow/spring-damping", &[0.2])],
            "elbow.spring_torque_nm",
        ),
        robot(
            "robot, play in the elbow",
            None,
            &[("elbow/backlash", &[0.04, 100.0]), ("elbow/coulomb-friction", &[0.05])],
            "elbow.angle_rad",
        ),
    ];
    let (mut jobs, mut kept) = (Vec::new(), Vec::new());
    for (case, pair) in cases {
        let lost = pair[1].exported.notes.iter().find(|n| n.fate == Fate::Lost && !n.what.contains("URDF"));
        assert!(lost.is_none(), "{}: {lost:?}", case.name);
        kept.push(case);
        jobs.extend(pair);
    }
    let (shown, _) = run(&python, jobs, &[]);
    let mut faults = Vec::new();
    println!("{:<44} {:>22}   {:>22}   falls", "rad or m", "sealegs: before after", "MuJoCo: before after");
    for (case, shown) in kept.iter().zip(shown.chunks(2)) {
        let error = |values: &[f64]| rms(values.iter().zip(&case.truth).map(|(a, b)| a - b));
        let theirs = [0, 1].map(|side| {
            let signal = shown[side][0].iter().find(|s| s.channel == case.channel).unwrap();
            assert_eq!(signal.values.len(), case.truth.len(), "{}", case.name);
            error(&signal.values)
        });
        let ours = case.ours.each_ref().map(|values| error(values));
        let falls = (theirs[0] - theirs[1]) / (ours[0] - ours[1]);
        println!(
            "{:<44} {:>12.3e} {:>9.1e}   {:>12.3e} {:>9.1e}   {falls:.4}",
            case.name, ours[0], ours[1], theirs[0], theirs[1]
        );
        if ours[1].is_nan() || ours[1] >= 0.1 * ours[0] {
            faults.push(format!("{}: our own error does not fall: {ours:?}", case.name));
        }
        let near = (falls - 1.0).abs() <= case.most && theirs[1] <= case.most * ours[0] + ours[1];
        if !near {
            faults.push(format!("{}: ours {ours:?}, theirs {theirs:?}, falls {falls}", case.name));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
