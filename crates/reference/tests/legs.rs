//! The reference leg against the product's model with the true parameters, and what its campaigns promise.

use sealegs_leg::model::LegModel;
use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_model::{Excitation, InputHold, Model, Record};
use sealegs_reference::campaign::Hidden;
use sealegs_reference::campaign::leg::{LegOrder, MadeLeg, Scene};
use sealegs_reference::leg::{Instant, LegIndividual, LegReference};

fn order(scene: Scene, hidden: Vec<Hidden>) -> LegOrder {
    LegOrder { name: "made".to_owned(), scene, seed: 5, hidden, step_s: 1e-4 }
}

fn hidden(id: &str, parameters: &[(&'static str, f64)]) -> Hidden {
    Hidden { id: id.to_owned(), parameters: parameters.to_vec(), beyond: None }
}

/// Root mean square of measured less predicted by the product's model with the true parameters, sensors and effects,
/// in units of the stated noise; the worst channel's name and error with it.
fn error(made: &MadeLeg, effects: &[Hidden]) -> (f64, String, f64) {
    let scenario = |name: &str, text: &str| Scenario::from_toml(text, name, &[]).unwrap();
    let preset = Scenario::load(made.scene.preset(), &[]).unwrap();
    let runs = made.runs.iter().map(|r| (r.name.to_owned(), scenario(r.name, &r.scenario))).collect();
    let channels: Vec<String> = made.sensors.iter().map(|s| s.channel.clone()).collect();
    let seen = Excitation { measured: channels.clone(), sample_period_s: 1e-3, ..Excitation::default() };
    let mut model = LegModel::new(preset.clone(), &preset, runs, Vec::new()).unwrap();
    for effect in effects {
        model = model.including(&effect.id, &seen).unwrap();
    }
    let truth = |name: &str| {
        let of_effect = |h: &Hidden| {
            let symbol = name.strip_prefix(&h.id)?.strip_prefix('.')?;
            h.parameters.iter().find(|p| p.0 == symbol).map(|p| p.1)
        };
        let base = made.parameters.iter().find(|p| p.0 == name).map(|p| p.1);
        base.or_else(|| effects.iter().find_map(of_effect)).unwrap_or_else(|| panic!("{name} has no truth"))
    };
    let values: Vec<f64> = model.parameters().iter().map(|p| truth(&p.name)).collect();
    let mut squares = vec![(0.0, 0usize); channels.len()];
    for run in &made.runs {
        let rows: Vec<Vec<f64>> = run
            .table
            .lines()
            .skip(1)
            .map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect())
            .collect();
        let record = Record {
            cut: false,
            name: run.name.to_owned(),
            time_s: rows.iter().map(|r| r[0]).collect(),
            hold: InputHold::ZeroOrder,
            inputs: Vec::new(),
            outputs: Vec::new(),
        };
        let predicted = model.predict(&values, &record, &channels).unwrap();
        for (c, sensor) in made.sensors.iter().enumerate() {
            let signal = predicted.outputs.iter().find(|s| s.channel == sensor.channel).unwrap();
            for (row, value) in rows.iter().zip(&signal.values) {
                let left = (row[c + 1] - sensor.gain * value - sensor.bias) / sensor.noise_std();
                squares[c].0 += left * left;
                squares[c].1 += 1;
            }
        }
    }
    let total: f64 = squares.iter().map(|s| s.0).sum();
    let count: usize = squares.iter().map(|s| s.1).sum();
    let of = |c: usize| (squares[c].0 / squares[c].1 as f64).sqrt();
    let worst = (0..channels.len()).max_by(|a, b| of(*a).total_cmp(&of(*b))).unwrap();
    ((total / count as f64).sqrt(), channels[worst].clone(), of(worst))
}

#[test]
fn reference_a_clean_leg_leaves_the_sensors_noise_and_nothing_else() {
    for scene in Scene::ALL {
        let made = LegOrder { step_s: scene.step_s(), ..order(scene, Vec::new()) }.make().unwrap();
        let (all, channel, worst) = error(&made, &[]);
        println!("{scene:?}: {all:.4}, worst {channel} {worst:.4}");
        // The product compares at 100 us, within a fifth of a sensor's noise of the converged motion while it swings
        // and half of it where the sole slides in landing: sqrt(1 + 0.5^2) = 1.12 and a little.
        let (most, worst_of_all) = if scene == Scene::Drop { (0.04, 1.2) } else { (0.02, 1.05) };
        assert!((all - 1.0).abs() < most && worst < worst_of_all, "{scene:?}: {all} {channel} {worst}");
    }
}

/// With the effect the product's model is at the noise, without it it is not.
fn explained(scene: Scene, id: &str, parameters: &[(&'static str, f64)]) {
    let effects = [hidden(id, parameters)];
    let made = order(scene, effects.to_vec()).make().unwrap();
    let without = error(&made, &[]).0;
    let (with, channel, worst) = error(&made, &effects);
    println!("{id}: {without:.2} without, {with:.4} with, worst {channel} {worst:.3}");
    assert!(without > 1.5, "{id}: {without}");
    assert!((with - 1.0).abs() < 0.04 && worst < 1.25, "{id}: {with} {channel} {worst}");
}

#[test]
fn reference_friction_in_a_leg_is_what_the_catalogue_says() {
    explained(Scene::Swing, "knee/coulomb-friction", &[("force_n", 45.0)]);
    let stribeck = [("coulomb_n", 30.0), ("static_n", 60.0), ("stribeck_velocity_m_s", 0.004)];
    explained(Scene::Swing, "ankle_inner/stribeck-friction", &stribeck);
    explained(Scene::Drop, "knee/load-dependent-friction", &[("coefficient", 0.1)]);
    let directed = [("force_n", 40.0), ("asymmetry", -0.5)];
    explained(Scene::Swing, "hip_pitch/direction-dependent-friction", &directed);
    explained(Scene::Swing, "hip_back/quadratic-drag", &[("coefficient_n_s2_m2", 2e5)]);
}

#[test]
fn reference_other_effects_in_a_leg_are_what_the_catalogue_says() {
    let ripple = [("amplitude_n", 60.0), ("cycles_per_rev", 1.0), ("phase_rad", 0.7)];
    explained(Scene::Swing, "hip_pitch/torque-ripple", &ripple);
    explained(Scene::Swing, "hip_front/transport-delay", &[("delay_s", 3e-3)]);
    explained(Scene::Drop, "knee/hardening-spring", &[("cubic_n_m3", 1e11)]);
    explained(Scene::Drop, "hip_pitch/spring-setting", &[("stiffness_ratio", 1.76)]);
    let mass = [("mass_kg", 0.5), ("shift_x_m", 0.0), ("shift_z_m", -0.02), ("inertia_ratio", 0.8)];
    explained(Scene::Swing, "shank/link-mass", &mass);
    let contact = [("stiffness_ratio", 0.5), ("damping_change_s_m", 0.2)];
    explained(Scene::Drop, "foot/contact-compliance", &contact);
}

#[test]
fn the_same_order_gives_the_same_bits_and_neutral_effects_change_none() {
    let plain = order(Scene::Swing, Vec::new()).make().unwrap();
    assert_eq!(plain.files(), order(Scene::Swing, Vec::new()).make().unwrap().files());
    let other = LegOrder { seed: 6, ..order(Scene::Swing, Vec::new()) }.make().unwrap();
    assert!(plain.runs.iter().zip(&other.runs).all(|(a, b)| a.table != b.table && a.scenario != b.scenario));
    let neutral = vec![
        hidden("knee/coulomb-friction", &[("force_n", 0.0)]),
        hidden("knee/load-dependent-friction", &[("coefficient", 0.0)]),
        hidden("hip_pitch/quadratic-drag", &[("coefficient_n_s2_m2", 0.0)]),
        hidden("knee/torque-ripple", &[("amplitude_n", 0.0), ("cycles_per_rev", 2.0), ("phase_rad", 0.3)]),
        hidden("hip_front/transport-delay", &[("delay_s", 0.0)]),
        hidden("hip_back/hardening-spring", &[("cubic_n_m3", 0.0)]),
        hidden("ankle_outer/backlash", &[("gap_m", 0.0)]),
        hidden("ankle_inner/spring-setting", &[("stiffness_ratio", 1.0)]),
        hidden("shank/link-mass", &[("mass_kg", 0.0), ("shift_x_m", 0.0), ("shift_z_m", 0.0)]),
    ];
    assert!(order(Scene::Swing, neutral).make().unwrap().runs == plain.runs);
}

#[test]
fn dry_friction_holds_the_weight_without_creep() {
    // Nobody commands: the hanging leg's weight comes onto springs that only the stuck rotors hold.
    let text = "robot = 'thor-leg'\nduration_s = 1.0\n[base]\nkind = 'fixed'\nheight_m = 1.2\n[start]\n\
                posture_rad = { hip_pitch = -0.6, knee = 0.4 }\n";
    let scenario = Scenario::from_toml(text, "held", &[]).unwrap();
    let robot = Robot::load("thor-leg", None).unwrap();
    let mut leg = LegReference::new(&scenario, robot, &LegIndividual::nominal(6)).unwrap();
    let names: Vec<String> = leg.actuators().map(str::to_owned).collect();
    for name in &names {
        leg = leg.with(&format!("{name}/coulomb-friction"), &[900.0]);
    }
    let seen: Vec<Instant> = leg.run(1e-4, 1e-3).unwrap();
    let knee = names.iter().position(|n| n == "hip_pitch").unwrap();
    let strongest = seen.iter().map(|i| i.force_1[knee].abs()).fold(0.0, f64::max);
    assert!(strongest > 200.0, "the hip's spring carries {strongest} N");
    // To the last bit, under a load that swings.
    assert!(seen.iter().all(|i| i.rotor_angle.iter().all(|a| *a == 0.0)));
}

/// The greatest change of any true signal, in units of its sensor's noise, by halving the step.
fn change(scene: Scene, id: &str, parameters: &[(&'static str, f64)]) -> f64 {
    let at = |step_s: f64| {
        LegOrder { step_s, ..order(scene, vec![hidden(id, parameters)]) }.true_signals().unwrap()
    };
    let (coarse, fine) = (at(scene.step_s()), at(0.5 * scene.step_s()));
    coarse.iter().zip(&fine).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn converged_halving_the_step_changes_no_signal_of_a_swing_by_a_tenth_of_its_noise() {
    let friction = change(Scene::Swing, "knee/coulomb-friction", &[("force_n", 60.0)]);
    let sticky = [("coulomb_n", 30.0), ("static_n", 75.0), ("stribeck_velocity_m_s", 0.003)];
    let sticky = change(Scene::Swing, "ankle_outer/stribeck-friction", &sticky);
    println!("friction {friction:.2e}, sticky {sticky:.2e}");
    assert!(friction < 0.1 && sticky < 0.1, "{friction} {sticky}");
}

#[test]
fn converged_halving_the_step_changes_no_signal_of_a_landing_by_a_tenth_of_its_noise() {
    let landing = change(Scene::Drop, "knee/coulomb-friction", &[("force_n", 60.0)]);
    println!("landing {landing:.2e}");
    assert!(landing < 0.1, "{landing}");
}
