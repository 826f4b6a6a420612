//! Prints, as JSON, the joints, the moving bodies, and at three postures the mass matrix and the gravity torques of a
//! URDF as they are simulated: for comparisons with other programs (`assets/robots/check/compare.py`).
//!
//! ```text
//! cargo run --release -p sealegs-leg --example mass_matrix -- ROBOT.urdf
//! ```

use sealegs_leg::LegError;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::Simulation;
use serde_json::{Value, json};
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(urdf) = std::env::args().nth(1) else {
        eprintln!("usage: mass_matrix ROBOT.urdf");
        return ExitCode::from(2);
    };
    match describe(&urdf) {
        Ok(value) => {
            println!("{value}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

/// Three postures without a pattern that a mistake could hide in: all joints at zero, and two waves.
fn position(posture: usize, joint: usize) -> f64 {
    let j = joint as f64;
    [0.0, 0.6 * (1.0 + j).sin(), -0.9 * (2.3 * j).cos()][posture]
}

fn describe(urdf: &str) -> Result<Value, LegError> {
    let (mut scenario, robot) = Scenario::for_robot(urdf, &[])?;
    let joints: Vec<String> = robot.moving_joints().map(|j| j.name.clone()).collect();
    let mut postures = Vec::new();
    let mut bodies = Vec::new();
    for posture in 0..3 {
        let q: Vec<f64> = (0..joints.len()).map(|j| position(posture, j)).collect();
        scenario.start.posture_rad = joints.iter().cloned().zip(q.iter().copied()).collect();
        let simulation = Simulation::with_robot(&scenario, robot.clone())?;
        let mass = simulation.mass_matrix();
        let rows: Vec<Vec<f64>> = mass.row_iter().map(|r| r.iter().copied().collect()).collect();
        let gravity: Vec<f64> = simulation.gravity_torques().iter().copied().collect();
        postures.push(json!({ "q": q, "mass_matrix": rows, "gravity_torques": gravity }));
        if posture == 0 {
            bodies.extend(simulation.moving_bodies().map(|(link, inertial)| {
                let i = &inertial.inertia;
                let moments = [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]];
                let com: [f64; 3] = inertial.com.into();
                json!({ "link": link, "mass_kg": inertial.mass_kg, "com_m": com, "inertia_kg_m2": moments })
            }));
        }
    }
    Ok(json!({
        "robot": robot.name,
        "joints": joints,
        "bodies": bodies,
        "postures": postures,
        "remarks": robot.warnings,
    }))
}
