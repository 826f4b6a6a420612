//! Standing still, and the physics that a drop must obey.

use sealegs_leg::impact::sweep;
use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::{Scenario, SweepSpec};
use sealegs_leg::simulation::{Observer, Sample};
use sealegs_leg::{LegError, run, run_robot};

#[derive(Default)]
struct Standing {
    /// Time, foot position x y z, normal force.
    seen: Vec<(f64, [f64; 3], f64)>,
}

impl Observer for Standing {
    fn sample(&mut self, s: &Sample) -> Result<(), LegError> {
        let foot = s.world_from_link[s.world_from_link.len() - 1].translation;
        self.seen.push((s.time_s, [foot.x, foot.y, foot.z], s.ground.normal_force_n));
        Ok(())
    }
}

#[test]
fn analytic_stance_carries_the_weight_and_does_not_creep() {
    let set = ["duration_s=14", "start.drop_height_m=0.0", "step_s=2e-4", "sample_period_s=0.01"];
    let scenario = Scenario::load("thor-drop", &set.map(str::to_owned)).expect("good");
    let robot = Robot::load("thor-leg", None).expect("embedded");
    // Links, carriage, and the sprung masses, which the links do not contain.
    let sprung: f64 = robot.actuators.iter().map(|p| p.spec.as_ref().map_or(0.0, |s| s.sprung_mass_kg)).sum();
    let weight = 9.81 * (robot.mass_kg() + 20.0 + sprung);
    let mut standing = Standing::default();
    run(&scenario, &mut standing).expect("runs");
    let settled: Vec<_> = standing.seen.iter().filter(|s| s.0 > 4.0).collect();
    for (time, _, force) in &settled {
        assert!((force / weight - 1.0).abs() < 1e-3, "{force} N of {weight} N at {time} s");
    }
    let (first, last) = (settled[0].1, settled[settled.len() - 1].1);
    let crept = (0..2).map(|i| (last[i] - first[i]).powi(2)).sum::<f64>().sqrt();
    println!("crept {crept:e} m in 10 s");
    assert!(crept < 1e-6, "the foot crept {crept} m in 10 s");
}

#[test]
fn peak_knee_force_grows_with_spring_stiffness() {
    let scenario = Scenario::load("thor-impact", &["duration_s=0.25".to_owned()]).expect("good");
    let springs = ["compliant", "stiff", "locked-out"].map(str::to_owned).to_vec();
    let table =
        sweep(&scenario, &SweepSpec { heights_m: vec![0.05, 0.1], springs }, true, &|| ()).expect("runs");
    for rows in table.rows.chunks(3) {
        let knee = |i: usize| rows[i].actuators.iter().find(|a| a.name == "knee").expect("there").force_1_n;
        println!("knee {} {} {}", knee(0), knee(1), knee(2));
        assert!(knee(0) < knee(1) && knee(1) < knee(2));
    }
    for row in &table.rows {
        let change = row.change_at_half_step.expect("checked");
        println!(
            "{} {} {change:e} {:?} {:e}",
            row.height_m, row.spring, row.changes_most, row.energy_residual
        );
        assert!(change < 0.01, "{} m, {}: {change}", row.height_m, row.spring);
        assert!(row.energy_residual < 5e-3, "{}", row.energy_residual);
    }
}

#[test]
fn a_light_foot_is_stable_at_the_default_step() {
    for spring in ["compliant", "stiff", "locked-out"] {
        let set = format!("actuators.spring={spring}");
        let scenario = Scenario::load("thor-drop", &[set, "duration_s=0.4".to_owned()]).expect("good");
        let mut robot = Robot::load("thor-leg", None).expect("embedded");
        let foot = robot.link_index("foot").expect("there");
        let inertial = robot.links[foot].inertial.as_mut().expect("has mass");
        inertial.inertia *= 0.25 / inertial.mass_kg;
        inertial.mass_kg = 0.25;
        let result = run_robot(&scenario, robot, &mut ()).expect("runs");
        assert_eq!(result.stopped, None, "{spring}");
        let force = result.peaks.ground_force_n.value;
        println!("light foot {spring}: {force} N, energy {:e}", result.worst_energy_residual);
        assert!(force > 1e3 && force < 2e4, "{spring}: {force}");
        assert!(result.worst_energy_residual < 0.01, "{spring}: {}", result.worst_energy_residual);
    }
}
