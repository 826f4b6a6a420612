//! The four runs of a leg's campaign: three to fit on, one of other motions to judge on.

use super::Scene;
use crate::campaign::Draws;
use std::fmt::Write;

/// A run's name, its role and the text of its scenario.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Planned {
    pub name: &'static str,
    pub holdout: bool,
    pub scenario: String,
}

/// Joints that move along a sine while a leg swings.
const MOVING: [&str; 5] = ["knee", "hip_roll", "hip_yaw", "ankle_pitch", "ankle_roll"];

/// Amplitude (rad), frequency (Hz) and phase (rad) of each of [`MOVING`], run by run. Rotor damping takes most of the
/// current: amplitude times frequency stays below what the drives' 10 A can move.
const SINES: [[[f64; 3]; 5]; 4] = [
    [[0.20, 0.9, 0.0], [0.08, 1.2, 0.0], [0.08, 1.5, 0.8], [0.07, 3.0, 0.0], [0.06, 2.3, 0.4]],
    [[0.12, 1.6, 0.5], [0.09, 1.1, 1.0], [0.10, 1.0, 0.0], [0.10, 1.8, 1.0], [0.04, 3.4, 0.0]],
    [[0.14, 1.4, 0.9], [0.07, 1.3, 0.5], [0.09, 1.2, 1.4], [0.09, 2.1, 0.3], [0.045, 3.1, 1.0]],
    [[0.16, 1.2, 1.2], [0.06, 1.5, 0.0], [0.08, 1.3, 2.0], [0.08, 2.4, 0.7], [0.05, 2.8, 1.5]],
];

/// Where the hip's flexion ends and where the knee begins, rad, run by run.
const SWINGS: [[f64; 2]; 4] = [[-1.3, 0.40], [-1.2, 0.30], [-1.35, 0.38], [-1.4, 0.35]];

/// Drop height (m) and the knee's flexion (rad), the foot level, run by run.
const DROPS: [[f64; 2]; 4] = [[0.05, 0.90], [0.08, 1.30], [0.10, 0.90], [0.07, 0.60]];

/// Names of the runs.
const NAMES: [[&str; 4]; 2] =
    [["fit-a", "fit-b", "fit-c", "check-d"], ["fit-low", "fit-crouched", "fit-high", "check-upright"]];

/// The runs of a seed: every amplitude, frequency, phase, height and posture is a little different from one seed to the
/// next.
pub(super) fn plan(scene: Scene, seed: u64) -> [Planned; 4] {
    let mut d = Draws::of(seed, "leg runs");
    std::array::from_fn(|run| {
        let scenario = match scene {
            Scene::Swing => swing(&mut d, run),
            Scene::Drop => drop(&mut d, run),
        };
        Planned { name: NAMES[scene as usize][run], holdout: run == 3, scenario }
    })
}

fn swing(d: &mut Draws, run: usize) -> String {
    let [hip, knee] = SWINGS[run];
    let (hip, knee) = (hip + d.between(-0.05, 0.05), knee + d.between(-0.03, 0.03));
    let mut text = format!(
        "description = \"THOR's leg swings on a stand, all its joints moving\"\nrobot = \"thor-leg\"\n\
         duration_s = 1.1\n\n[base]\nkind = \"fixed\"\nheight_m = 1.2\n\n[start]\nsprings = \"balanced\"\n\
         posture_rad = {{ hip_pitch = -0.6, knee = {knee:.3} }}\n\n[controller]\nkind = \"pd\"\n\
         stiffness_nm_rad = 500.0\ndamping_nm_s_rad = 10.0\ngravity_compensation = true\nfeed_forward = true\n\
         current_limit_a = 10.0\n\n[motion]\n\
         hip_pitch = {{ shape = \"half-cosine\", to_rad = {hip:.3}, start_s = 0.1, duration_s = 0.8 }}\n"
    );
    for (joint, [amplitude, frequency, phase]) in MOVING.iter().zip(SINES[run]) {
        let (amplitude, frequency) = (amplitude * d.between(0.9, 1.1), frequency * d.between(0.92, 1.08));
        let phase = phase + d.between(0.0, 0.4);
        let _ = writeln!(
            text,
            "{joint} = {{ shape = \"sine\", amplitude_rad = {amplitude:.4}, frequency_hz = {frequency:.3}, \
             phase_rad = {phase:.3} }}"
        );
    }
    text
}

fn drop(d: &mut Draws, run: usize) -> String {
    let [height, knee] = DROPS[run];
    let (height, knee) = (height * d.between(0.9, 1.1), knee + d.between(-0.05, 0.05));
    let half = -0.5 * knee;
    format!(
        "description = \"THOR's leg lands, holding its posture\"\nrobot = \"thor-leg\"\nduration_s = 0.5\n\n[base]\n\
         kind = \"rail\"\ncarriage_mass_kg = 20.0\n\n[start]\ndrop_height_m = {height:.4}\nsprings = \"unloaded\"\n\
         posture_rad = {{ hip_pitch = {half:.3}, knee = {knee:.3}, ankle_pitch = {half:.3} }}\n\n[ground]\n\n\
         [controller]\nkind = \"pd\"\nstiffness_nm_rad = 500.0\ndamping_nm_s_rad = 20.0\n\
         gravity_compensation = false\nfeed_forward = false\ncurrent_limit_a = 10.0\n"
    )
}
