//! Runs that a rig could make next: the scenario with another height, or with a joint that is driven.

use crate::robot::Robot;
use crate::scenario::{BaseSpec, Motion, Scenario};

/// Heights of a drop, as ratios of the scenario's.
const HEIGHTS: [f64; 2] = [0.5, 1.5];

/// Drops from higher are not proposed, m.
const HIGHEST_DROP_M: f64 = 0.15;

/// How far a joint is driven about its posture, rad, and how often a second: slowly, where friction and play show, and
/// fast, where inertias, lags and springs do.
const DRIVES: [(f64, f64); 3] = [(0.15, 0.5), (0.1, 2.0), (0.04, 6.0)];

/// Seconds of a run in which a joint is driven.
const DRIVEN_S: f64 = 2.0;

/// What to do, and the scenario of it. Nothing leaves the joints' limits.
pub(super) fn variants(scenario: &Scenario, robot: &Robot) -> Vec<(String, Scenario)> {
    let mut all = Vec::new();
    let plain = Scenario { effects: Vec::new(), sensors: Default::default(), ..scenario.clone() };
    let drop_m = scenario.start.drop_height_m;
    let drops = matches!(scenario.base, BaseSpec::Rail { .. }) && scenario.ground.is_some() && drop_m > 0.0;
    if drops {
        for ratio in HEIGHTS {
            let height_m = (1e3 * ratio * drop_m).round() * 1e-3;
            if height_m <= HIGHEST_DROP_M {
                let mut variant = plain.clone();
                variant.start.drop_height_m = height_m;
                all.push((format!("drop the leg from {height_m:.3} m"), variant));
            }
        }
    }
    for joint in robot.moving_joints() {
        let name = &joint.name;
        let posture = scenario.start.posture_rad.get(name).copied().unwrap_or(0.0);
        for (amplitude_rad, frequency_hz) in DRIVES {
            let inside = |q: f64| joint.limits.contain(q);
            if !inside(posture - 1.1 * amplitude_rad) || !inside(posture + 1.1 * amplitude_rad) {
                continue;
            }
            let mut variant = plain.clone();
            let motion = Motion::Sine { amplitude_rad, frequency_hz, phase_rad: 0.0 };
            variant.motion.insert(name.clone(), motion);
            variant.duration_s = DRIVEN_S;
            let from = if drops { ", after the drop" } else { "" };
            let what = format!(
                "swing {name} by {amplitude_rad:.2} rad at {frequency_hz:.1} Hz about its posture{from}, for {DRIVEN_S:.0} s"
            );
            all.push((what, variant));
        }
    }
    for (what, variant) in &mut all {
        variant.name = what.clone();
        variant.description = format!("Planned experiment: {what}");
    }
    all
}
