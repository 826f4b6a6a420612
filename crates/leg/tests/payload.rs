//! A mass that a robot's link carries beyond what its URDF says: against a pendulum on a bench, whose integrator is another one.

mod double_pendulum;

use double_pendulum::{TORQUE, TWO, farthest, robot, values};
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel, PendulumRig, RunSetup};
use sealegs_leg::bench::RobotModel;
use sealegs_model::{Excitation, InputHold, Model, Record, Signal};

/// 0.5 kg, 0.22 m below its hinge, 0.004 kg m^2 about its centre.
const ARM: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="link"><inertial><origin xyz="0 0 -0.22"/><mass value="0.5"/>
    <inertia ixx="4e-3" iyy="4e-3" izz="4e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="link"/><axis xyz="0 -1 0"/></joint>
</robot>"#;

/// A payload: kg, and m below the hinge.
const PAYLOAD: (f64, f64) = (0.3, 0.4);

fn record(input: &str, output: &str) -> Record {
    let time_s: Vec<f64> = (0..1500).map(|n| f64::from(n) * 2e-3).collect();
    let torque = |t: &f64| 0.8 * (2.0 * t).sin() + if *t > 1.0 { 0.4 } else { 0.0 };
    let signal = |name: &str, values| vec![Signal { channel: name.to_owned(), values }];
    Record {
        cut: false,
        name: "run".to_owned(),
        hold: InputHold::ZeroOrder,
        inputs: signal(input, time_s.iter().map(torque).collect()),
        outputs: signal(output, vec![0.0; time_s.len()]),
        time_s,
    }
}

/// The arm with the payload as a pendulum on a bench: mass, centre and moment by the parallel axis theorem.
fn on_bench() -> (Vec<f64>, [f64; 5]) {
    let ((own, at), (more, there)) = ((0.5, 0.22), PAYLOAD);
    let mass = own + more;
    let centre = (own * at + more * there) / mass;
    let moment = 4e-3 + own * (centre - at).powi(2) + more * (there - centre).powi(2);
    let inertia = moment + mass * centre.powi(2);
    let length_m = inertia / (mass * centre);
    let rig = PendulumRig { arm_m: 1.0, length_m, mass_kg: inertia / length_m.powi(2), rod_mass_kg: 0.0 };
    let spec = ActuatorSpec::from_toml(TORQUE, "drive").unwrap_or_else(|e| panic!("{e}"));
    let bench = BenchModel::new(spec, Bench::Pendulum(rig)).expect("a bench").with_step(2e-5);
    let record = record("joint_torque_nm", "joint_angle_rad");
    let setup = RunSetup::of_record(&record, bench.spec(), bench.bench(), 1.0);
    let bench = bench.with_runs(vec![setup]).expect("a rig");
    let swung = bench.predict(&values(&bench), &record, &["joint_angle_rad".to_owned()]).expect("finite");
    // What the effect says of the same: dm, dx, dy, dz and the ratio of the moments.
    (swung.outputs[0].values.clone(), [more, 0.0, 0.0, at - centre, moment / (4e-3 * mass / own)])
}

#[test]
fn reference_a_link_with_a_payload_swings_as_a_pendulum_of_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let record = record("hinge.torque_nm", "hinge.angle_rad");
    let (truth, effect) = on_bench();
    let off = |values_of: &[f64], step_s: f64| {
        let arm = robot(folder.path(), ARM, TORQUE).with_step(step_s);
        let arm = arm.including("link/link-mass", &Excitation::default()).expect("it can carry one");
        let arm = arm.for_records(&[&record]).with_start(&record.name, vec![(0.0, 0.0)]);
        let mut all = values(&arm);
        let first = all.len() - values_of.len();
        all[first..].copy_from_slice(values_of);
        let swung = arm.predict(&all, &record, &["hinge.angle_rad".to_owned()]).expect("finite");
        farthest(&swung.outputs[0].values, &truth)
    };
    assert!(off(&effect, 2.5e-4) < 1e-3, "{}", off(&effect, 2.5e-4));
    assert!(off(&effect, 2.5e-4) < 0.5 * off(&effect, 1e-3), "{}", off(&effect, 1e-3));
    assert!(off(&[0.0, 0.0, 0.0, 0.0, 1.0], 2.5e-4) > 0.1);
}

#[test]
fn a_payload_is_offered_at_every_link_once_and_a_file_keeps_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let seen = Excitation::default();
    let arm = robot(folder.path(), TWO, TORQUE);
    let offered = |model: &RobotModel| -> Vec<String> {
        let cards = model.effects(&seen).into_iter();
        cards.filter(|card| card.acts_on == "link").map(|card| card.id).collect()
    };
    assert_eq!(offered(&arm), ["upper/link-mass", "lower/link-mass"]);
    let arm = arm.including("lower/link-mass", &seen).expect("it can carry one");
    assert_eq!(offered(&arm), ["upper/link-mass"]);
    assert_eq!(arm.included(), ["lower/link-mass"]);
    assert!(
        arm.including("lower/link-mass", &seen).is_err() && arm.including("base/link-mass", &seen).is_err()
    );
    let mut all = values(&arm);
    let first = all.len() - 5;
    all[first..].copy_from_slice(&[0.4, 0.01, 0.0, -0.02, 1.2]);
    let file = arm.fitted_file(&all, &[]);
    let again = RobotModel::new(file, &[]).unwrap_or_else(|e| panic!("{e}"));
    let record = record("shoulder.torque_nm", "shoulder.angle_rad");
    let moves = |model: &RobotModel, values: &[f64]| {
        model.predict(values, &record, &["elbow.angle_rad".to_owned()]).expect("finite").outputs
    };
    assert_eq!(moves(&again, &values(&again)), moves(&arm, &all));
    assert!(farthest(&moves(&arm, &all)[0].values, &moves(&arm, &values(&arm))[0].values) > 1e-3);
    // Whoever is given the robot in another format gets the link as it is.
    let lower = again.robot_at(&values(&again));
    let lower = &lower.links[lower.link_index("lower").expect("a link")];
    assert!((lower.inertial.as_ref().expect("a mass").mass_kg - 1.03).abs() < 1e-12);
}
