//! The coupling of actuators and links against the independent reference.

use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::{Observer, Sample};
use sealegs_leg::{LegError, run_robot};
use sealegs_reference::leg::{Instant, LegIndividual, LegReference};

/// Forces and motion every millisecond.
#[derive(Default)]
struct Seen(Vec<Instant>);

impl Observer for Seen {
    fn sample(&mut self, s: &Sample) -> Result<(), LegError> {
        self.0.push(Instant {
            force_1: s.actuators.iter().map(|a| a.force_1_n).collect(),
            force_2: s.actuators.iter().map(|a| a.force_2_n).collect(),
            ground: s.ground.normal_force_n,
            q: s.joint_angles_rad.clone(),
            ..Instant::default()
        });
        Ok(())
    }
}

/// Greatest differences: forces as a ratio of the greatest actuator force, angles in rad, ground peak.
#[derive(Debug)]
struct Error {
    forces: f64,
    angles: f64,
    ground_peak: f64,
}

fn compare(truth: &[Instant], seen: &[Instant]) -> Error {
    assert_eq!(truth.len(), seen.len());
    let peak = |f: &dyn Fn(&Instant) -> f64, all: &[Instant]| all.iter().map(f).fold(0.0, f64::max);
    let strongest =
        peak(&|i| i.force_1.iter().chain(&i.force_2).fold(0.0, |m: f64, f| m.max(f.abs())), truth);
    let mut error = Error { forces: 0.0, angles: 0.0, ground_peak: 0.0 };
    for (t, s) in truth.iter().zip(seen) {
        let pairs = t.force_1.iter().zip(&s.force_1).chain(t.force_2.iter().zip(&s.force_2));
        for (a, b) in pairs {
            error.forces = error.forces.max((a - b).abs() / strongest);
        }
        for (a, b) in t.q.iter().zip(&s.q) {
            error.angles = error.angles.max((a - b).abs());
        }
    }
    let ground = peak(&|i| i.ground, truth);
    if ground > 0.0 {
        error.ground_peak = (peak(&|i| i.ground, seen) / ground - 1.0).abs();
    }
    error
}

/// The errors at 200, 100 and 50 us against the reference at `fine_s`.
fn errors(text: &str, fine_s: f64) -> [Error; 3] {
    errors_with(text, &[], fine_s)
}

/// The same with compliances (N/m) between screw and link 2 of these actuators.
fn errors_with(text: &str, compliances: &[(&str, f64)], fine_s: f64) -> [Error; 3] {
    let robot = || Robot::load("thor-leg", None).expect("embedded");
    let effect = |(place, stiffness): &(&str, f64)| {
        format!(
            "[[effect]]\nid = '{place}/series-compliance'\nparameters = {{ stiffness_n_m = {stiffness:e} }}\n"
        )
    };
    let text: String = text.to_owned() + &compliances.iter().map(effect).collect::<String>();
    let scenario = Scenario::from_toml(&text, "test", &[]).expect("good");
    let reference = LegReference::new(&scenario, robot(), &LegIndividual::nominal(6)).expect("good");
    let reference = compliances.iter().fold(reference, |leg, (place, stiffness)| {
        leg.with(&format!("{place}/series-compliance"), &[*stiffness, 0.08])
    });
    let truth = reference.run(fine_s, 1e-3).expect("runs");
    [2e-4, 1e-4, 5e-5].map(|step_s| {
        let mut seen = Seen::default();
        let scenario = Scenario { step_s, ..scenario.clone() };
        run_robot(&scenario, robot(), &mut seen).expect("runs");
        compare(&truth, &seen.0)
    })
}

#[test]
fn reference_forces_and_motion_in_free_swing() {
    // Hip fixed, springs unloaded at the start and currents switched on: every mode is excited.
    let text = "robot = 'thor-leg'\nduration_s = 0.3\n[base]\nkind = 'fixed'\nheight_m = 2.0\n\
                [start]\nposture_rad = { hip_pitch = -0.5, knee = 0.9, ankle_pitch = 0.1 }\n\
                [current.knee]\nshape = 'step'\namplitude = 4.0\n[current.hip_front]\nshape = 'step'\namplitude = -3.0\n\
                [current.ankle_inner]\nshape = 'step'\namplitude = 2.0\n";
    let found = errors(text, 2e-5);
    println!("free swing: {found:?}");
    assert!(found[1].forces < 2e-3 && found[1].angles < 1e-4, "{found:?}");
    // At least first order: halving the step halves the error (a little slack for what is not asymptotic).
    assert!(found[0].forces > 1.8 * found[1].forces && found[1].forces > 1.8 * found[2].forces, "{found:?}");
}

#[test]
fn reference_forces_and_motion_through_an_impact() {
    let text = "robot = 'thor-leg'\nduration_s = 0.16\n[base]\nkind = 'rail'\ncarriage_mass_kg = 20.0\n\
                [start]\ndrop_height_m = 0.05\n\
                posture_rad = { hip_pitch = -0.45, knee = 0.9, ankle_pitch = -0.45 }\n[ground]\n\
                [current.knee]\nshape = 'step'\namplitude = 5.0\n";
    let found = errors(text, 2.5e-6);
    println!("impact: {found:?}");
    assert!(found[1].forces < 1e-3 && found[1].ground_peak < 2e-3, "{found:?}");
    assert!(found[0].forces > 1.8 * found[1].forces, "{found:?}");
}

#[test]
fn reference_forces_and_motion_under_the_controller() {
    // Weight, moment arms, what the motors see of the joints and feed-forward: the whole controller in the loop.
    let text = "robot = 'thor-leg'\nduration_s = 0.4\n[base]\nkind = 'fixed'\nheight_m = 1.2\n[start]\n\
                springs = 'balanced'\nposture_rad = { hip_pitch = -0.6, knee = 0.4 }\n[controller]\nkind = 'pd'\n\
                damping_nm_s_rad = 10.0\ncurrent_limit_a = 10.0\n[motion]\n\
                hip_pitch = { shape = 'half-cosine', to_rad = -0.9, start_s = 0.05, duration_s = 0.4 }\n\
                knee = { shape = 'sine', amplitude_rad = 0.15, frequency_hz = 2.0 }\n\
                ankle_pitch = { shape = 'sine', amplitude_rad = 0.07, frequency_hz = 3.0 }\n\
                ankle_roll = { shape = 'sine', amplitude_rad = 0.05, frequency_hz = 2.5 }\n\
                hip_yaw = { shape = 'sine', amplitude_rad = 0.06, frequency_hz = 2.0 }\n";
    let found = errors(text, 2e-5);
    println!("controlled: {found:?}");
    // At the controller's instants the product feels the mean of the old and the new current, the reference the new
    // one: that difference in the load cells (0.02 % of the greatest force) does not fall with the step.
    assert!(found[1].forces < 4e-4 && found[1].angles < 1e-5, "{found:?}");
    assert!(found[0].angles > 1.8 * found[1].angles && found[1].angles > 1.8 * found[2].angles, "{found:?}");
}

#[test]
fn reference_forces_and_motion_over_compliant_screw_ends() {
    // A rod on a foot that is lighter than the sprung mass and a linkage, through an impact that excites their modes;
    // then one that is stiffer than the step can follow.
    let text = "robot = 'thor-leg'\nduration_s = 0.16\n[base]\nkind = 'rail'\ncarriage_mass_kg = 20.0\n\
                [start]\ndrop_height_m = 0.05\nsprings = 'balanced'\n\
                posture_rad = { hip_pitch = -0.45, knee = 0.9, ankle_pitch = -0.45 }\n[ground]\n\
                [current.knee]\nshape = 'step'\namplitude = 5.0\n";
    for compliances in [[("ankle_outer", 1.5e5), ("knee", 6e5)], [("ankle_outer", 1.5e7), ("knee", 2.771e6)]]
    {
        let found = errors_with(text, &compliances, 5e-6);
        println!("{compliances:?}: {found:?}");
        assert!(found[2].forces < 5e-3 && found[2].ground_peak < 5e-3, "{found:?}");
        assert!(
            found[0].forces > 1.7 * found[1].forces && found[1].forces > 1.7 * found[2].forces,
            "{found:?}"
        );
    }
}
