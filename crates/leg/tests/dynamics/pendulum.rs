//! Pendulums without actuators: the bodies alone against the analytic period and a fine integration.

use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::{Observer, Sample};
use sealegs_leg::{LegError, run_robot};

/// Two rods of 1 m that hang from a fixed base and swing about y; the joints lie at the upper ends.
const DOUBLE: &str = r#"<robot name="double">
  <link name="base"/>
  <joint name="first" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <link name="upper"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0.17" iyy="0.17" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="second" type="continuous"><origin xyz="0 0 -1"/><parent link="upper"/><child link="lower"/>
    <axis xyz="0 1 0"/></joint>
  <link name="lower"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
    <inertia ixx="0.08" iyy="0.08" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>"#;

#[derive(Default)]
struct Angles {
    time: Vec<f64>,
    q: Vec<Vec<f64>>,
    residual: f64,
}

impl Observer for Angles {
    fn sample(&mut self, s: &Sample) -> Result<(), LegError> {
        self.time.push(s.time_s);
        self.q.push(s.joint_angles_rad.clone());
        self.residual = self.residual.max(s.energy.relative().abs());
        Ok(())
    }
}

fn swing(urdf: &str, posture: &str, duration_s: f64, step_s: f64) -> Angles {
    swing_with(urdf, posture, duration_s, step_s, "")
}

/// The same with more lines of the scenario.
fn swing_with(urdf: &str, posture: &str, duration_s: f64, step_s: f64, more: &str) -> Angles {
    let text = format!(
        "robot = 'x'\nduration_s = {duration_s:?}\nstep_s = {step_s:?}\n[start]\nposture_rad = {{ {posture} }}\n{more}"
    );
    let scenario = Scenario::from_toml(&text, "test", &[]).expect("good");
    let robot = Robot::from_urdf(urdf, "test", None).expect("good");
    let mut angles = Angles::default();
    let result = run_robot(&scenario, robot, &mut angles).expect("runs");
    assert_eq!(result.stopped, None);
    angles
}

#[test]
fn analytic_period_of_a_pendulum() {
    let single = DOUBLE.split("  <joint name=\"second\"").next().expect("a part").to_owned() + "</robot>";
    let angles = swing(&single, "first = 0.01", 10.0, 1e-3);
    // I = 0.17 + 2 * 0.5^2 about the joint; the amplitude adds a^2/16.
    let period =
        std::f64::consts::TAU * (0.67 / (2.0 * 9.81 * 0.5_f64)).sqrt() * (1.0 + 0.01_f64.powi(2) / 16.0);
    // Zeros by linear interpolation.
    let zeros: Vec<f64> = (1..angles.q.len())
        .filter(|&i| angles.q[i - 1][0] * angles.q[i][0] < 0.0)
        .map(|i| {
            let (a, b) = (angles.q[i - 1][0], angles.q[i][0]);
            angles.time[i - 1] + 1e-3 * a / (a - b)
        })
        .collect();
    let measured = 2.0 * (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64;
    assert!((measured / period - 1.0).abs() < 2e-6, "{measured} {period}");
    // No loss in six periods.
    let largest = angles.q[8_000..].iter().fold(0.0, |m: f64, q| m.max(q[0].abs()));
    assert!((largest / 0.01 - 1.0).abs() < 1e-4, "{largest}");
}

#[test]
fn analytic_output_friction_at_a_joint_takes_its_torque_times_the_way() {
    let single = DOUBLE.split("  <joint name=\"second\"").next().expect("a part").to_owned() + "</robot>";
    let (weight, friction) = (2.0 * 9.81 * 0.5_f64, 0.4);
    let effect = "[[effect]]\nid = \"first/output-friction\"\nparameters = { torque_nm = 0.4 }\n";
    let angles = swing_with(&single, "first = 0.6", 12.0, 5e-4, effect);
    let q: Vec<f64> = angles.q.iter().map(|q| q[0]).collect();
    // From one turning point to the next the height that is lost is the friction's torque times the angle between.
    let mut at: Vec<f64> = vec![q[0]];
    at.extend(q.windows(3).filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0).map(|w| w[1]));
    assert!(at.len() > 5, "{at:?}");
    for pair in at.windows(2).take(5) {
        let lost = weight * (pair[1].cos() - pair[0].cos());
        let taken = friction * (pair[0] - pair[1]).abs();
        assert!((lost / taken - 1.0).abs() < 5e-3, "{pair:?}: {lost} and {taken} J");
    }
    // Where the weight is less than the friction it stays: within the 1e-4 rad over which a joint's friction is elastic,
    // and without creep.
    let rest = &q[q.len() - 2000..];
    let (early, late) = rest.split_at(1000);
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    assert!(weight * mean(rest).sin().abs() < friction);
    assert!(rest.iter().all(|q| (q - mean(rest)).abs() < 1e-4));
    // A second holds no whole number of the ringing's periods: 5e-5 rad at some 60 Hz.
    assert!((mean(early) - mean(late)).abs() < 1e-5, "{} {}", mean(early), mean(late));
}

/// The double pendulum's accelerations, written down from its Lagrangian (absolute angles a, a + b).
fn accelerations(q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
    let (m1, i1, m2, i2, g) = (2.0, 0.17, 1.0, 0.08, 9.81);
    let (a, b) = (q[0], q[0] + q[1]);
    let (wa, wb) = (v[0], v[0] + v[1]);
    let (c, s) = ((a - b).cos(), (a - b).sin());
    let (maa, mab, mbb) = (i1 + m1 * 0.25 + m2, 0.5 * m2 * c, i2 + 0.25 * m2);
    // The axis is +y: a positive angle swings the rod to -x; gravity turns it back.
    let fa = -0.5 * m2 * s * wb * wb - (0.5 * m1 + m2) * g * a.sin();
    let fb = 0.5 * m2 * s * wa * wa - 0.5 * m2 * g * b.sin();
    let det = maa * mbb - mab * mab;
    let (aa, ab) = ((mbb * fa - mab * fb) / det, (maa * fb - mab * fa) / det);
    [aa, ab - aa]
}

#[test]
fn reference_double_pendulum() {
    let (mut q, mut v) = ([1.2, -0.7], [0.0, 0.0]);
    let h = 1e-5;
    let mut truth = vec![q];
    for step in 1..=200_000 {
        let f = |q: [f64; 2], v: [f64; 2]| (v, accelerations(q, v));
        let add = |x: [f64; 2], k: [f64; 2], s: f64| [x[0] + s * k[0], x[1] + s * k[1]];
        let (a1, b1) = f(q, v);
        let (a2, b2) = f(add(q, a1, 0.5 * h), add(v, b1, 0.5 * h));
        let (a3, b3) = f(add(q, a2, 0.5 * h), add(v, b2, 0.5 * h));
        let (a4, b4) = f(add(q, a3, h), add(v, b3, h));
        for i in 0..2 {
            q[i] += h / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i]);
            v[i] += h / 6.0 * (b1[i] + 2.0 * b2[i] + 2.0 * b3[i] + b4[i]);
        }
        if step % 100 == 0 {
            truth.push(q);
        }
    }
    let error = |step_s: f64| {
        let angles = swing(DOUBLE, "first = 1.2, second = -0.7", 2.0, step_s);
        let worst = truth.iter().zip(&angles.q).flat_map(|(t, q)| [(t[0] - q[0]).abs(), (t[1] - q[1]).abs()]);
        (worst.fold(0.0, f64::max), angles.residual)
    };
    let (coarse, fine) = (error(2e-4), error(1e-4));
    println!("double pendulum: {coarse:?} {fine:?}");
    // Without damping nothing forgives an error: 2 s of large swings, rad.
    assert!(fine.0 < 2e-3, "{fine:?}");
    assert!(coarse.0 > 1.8 * fine.0, "{coarse:?} {fine:?}");
    assert!(fine.1 < 2e-3, "energy {fine:?}");
}

#[test]
fn energy_of_what_hangs_still_is_explained() {
    // In motion are 1e-17 J of some 25 J: the rounding of the sum is more.
    let angles = swing(DOUBLE, "first = 1e-9", 0.3, 1e-3);
    assert!(angles.residual < 1e-6, "{}", angles.residual);
}
