//! A small campaign for tests of the program, whose truth comes from another integrator: semi-implicit Euler
//! with a stick test at a hundredth of the program's step.

use crate::program::normal;
use std::path::{Path, PathBuf};

/// Mass, damping, stiffness of the truth; the model file starts elsewhere.
const TRUTH: [f64; 3] = [1.2, 30.0, 4000.0];
const NOISE_M: f64 = 2e-5;
const NOISE_N: f64 = 0.05;
const STEP_S: f64 = 1e-6;
const SAMPLE_S: f64 = 2e-3;

/// One run as CSV: force in, deflection and spring force out, with Coulomb friction `friction` in N.
fn run(friction: f64, seconds: f64, seed: u64, input: impl Fn(f64) -> f64) -> String {
    let [m, b, k] = TRUTH;
    let (mut x, mut v) = (0.0f64, 0.0f64);
    let mut state = seed;
    let mut text = "time_s,motor_force_n,spring_deflection_m,force_1_n\n".to_owned();
    let per_sample = (SAMPLE_S / STEP_S).round() as usize;
    for i in 0..(seconds / SAMPLE_S) as usize {
        let u = input(i as f64 * SAMPLE_S);
        let (nx, nf) = (NOISE_M * normal(&mut state), NOISE_N * normal(&mut state));
        text.push_str(&format!("{:.3},{u},{},{}\n", i as f64 * SAMPLE_S, x + nx, k * x + nf));
        for _ in 0..per_sample {
            // Friction takes the speed to zero at most; what is over moves the mass.
            let free = v + STEP_S * (u - b * v - k * x) / m;
            let most = STEP_S * friction / m;
            v = if free.abs() <= most { 0.0 } else { free - most.copysign(free) };
            x += STEP_S * v;
        }
    }
    text
}

const MODEL: &str = r#"
id = "bench-truck"
kind = "linear"
[motor]
torque_constant_nm_a = 1.0
rotor_inertia_kg_m2 = 1.0
rotor_damping_nm_s = 25.0
[transmission]
type = "direct"
[spring]
type = "constant"
stiffness_n_m = 3600.0
[parameters.force_constant]
fixed = true
[sensors.spring_deflection_m]
gain_std = 0.0
"#;

/// Writes a campaign with this friction and returns its folder.
pub fn campaign(folder: &Path, friction: f64) -> PathBuf {
    let folder = folder.join(format!("friction-{friction}"));
    std::fs::create_dir_all(&folder).unwrap();
    let chirp = |t: f64| if t < 0.3 { 0.0 } else { 40.0 * ((4.0 + 6.0 * (t - 0.3)) * (t - 0.3)).sin() };
    let stairs = |t: f64| [0.0, 25.0, 45.0, -10.0, -40.0, -15.0, 30.0, 5.0][((t / 0.5) as usize).min(7)];
    let mixed = |t: f64| if t < 0.3 { 0.0 } else { 22.0 * (9.0 * t).sin() + 15.0 * (31.0 * t + 1.0).sin() };
    let slow = |t: f64| if t < 0.3 { 0.0 } else { 35.0 * (3.0 * (t - 0.3)).sin() };
    std::fs::write(folder.join("chirp.csv"), run(friction, 3.0, 1, chirp)).unwrap();
    std::fs::write(folder.join("stairs.csv"), run(friction, 3.0, 2, stairs)).unwrap();
    std::fs::write(folder.join("mixed.csv"), run(friction, 3.0, 3, mixed)).unwrap();
    std::fs::write(folder.join("slow.csv"), run(friction, 3.0, 4, slow)).unwrap();
    std::fs::write(folder.join("model.toml"), MODEL).unwrap();
    let text = format!(
        "name = \"truck\"\nbench = \"locked\"\nactuator = \"model.toml\"\nsample_rate_hz = 500.0\n\
         [noise_std]\nspring_deflection_m = {NOISE_M}\nforce_1_n = {NOISE_N}\n\
         [[run]]\nfile = \"chirp.csv\"\nrole = \"fit\"\n[[run]]\nfile = \"stairs.csv\"\nrole = \"fit\"\n\
         [[run]]\nfile = \"mixed.csv\"\nrole = \"holdout\"\n[[run]]\nfile = \"slow.csv\"\nrole = \"holdout\"\n"
    );
    std::fs::write(folder.join("campaign.toml"), text).unwrap();
    folder
}
