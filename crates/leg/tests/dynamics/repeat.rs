//! The same run gives the same bits; the mirror image of a leg does the mirror image.

use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::{Channels, channels};

fn drop_channels(overrides: &[&str]) -> Channels {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let scenario = Scenario::load("thor-drop", &overrides).expect("good");
    let robot = Robot::load("thor-leg", None).expect("embedded");
    let robot = if scenario.mirrored { robot.mirrored() } else { robot };
    channels(&scenario, robot).expect("runs").0
}

#[test]
fn the_same_run_gives_the_same_bits() {
    let run = || drop_channels(&["duration_s=0.3"]);
    let (a, b) = (run(), run());
    for (a, b) in a.signals.iter().zip(&b.signals) {
        assert!(a.values.iter().zip(&b.values).all(|(x, y)| x.to_bits() == y.to_bits()), "{}", a.channel);
    }
}

#[test]
fn left_and_right_mirror_each_other() {
    let posture = |sign: f64| {
        format!(
            "start.posture_rad={{ hip_yaw = {}, hip_roll = {}, hip_pitch = -0.45, knee = 0.9, ankle_pitch = -0.45, \
             ankle_roll = {} }}",
            0.1 * sign,
            0.08 * sign,
            -0.08 * sign
        )
    };
    let left = drop_channels(&["duration_s=0.3", &posture(1.0)]);
    // The mirrored robot keeps its joints' names; yaw and roll may turn the other way round its axes, so
    // that both signs are tried: one of them must be the mirror image.
    let mirror = [1.0, -1.0].map(|s| drop_channels(&["duration_s=0.3", "mirrored=true", &posture(s)]));
    let ground = "foot.normal_force_n";
    let truth = left.get(ground).expect("a channel");
    let scale = truth.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let differences = mirror.map(|m| {
        let seen = m.get(ground).expect("a channel");
        let knee = |c: &Channels| c.get("knee.force_1_n").expect("a channel").to_vec();
        let worst = truth.iter().zip(seen).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let forces = knee(&left).iter().zip(knee(&m)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        worst.max(forces) / scale
    });
    println!("mirror: {differences:?}");
    assert!(differences[0].min(differences[1]) < 1e-6, "{differences:?}");
}
