//! The four runs of a campaign: two to fit on, two of other kinds and amplitudes to judge on.

use super::Rig;
use super::draws::Draws;
use sealegs_actuator::excitation::Profile;

/// A run's file and whether it judges.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Its file's name.
    pub file: &'static str,
    /// Held out rather than fitted.
    pub holdout: bool,
    /// Commanded current at each row, A.
    pub command: Vec<f64>,
}

/// A staircase's step, s, in the fit and in the holdout run.
const STEP_S: [f64; 2] = [0.6, 0.9];

/// Smallest change that a logger of the command shows, A.
const COMMAND_DIGIT_A: f64 = 1e-5;

/// The file of the second run to fit on.
pub(super) const SECOND_FIT: &str = "fit_steps.csv";

/// A weak command as a ratio of the usual one.
const WEAK: f64 = 0.15;

/// Makes a command weak, in digits that the logger shows.
pub(super) fn weaken(command: &mut [f64]) {
    command.iter_mut().for_each(|c| *c = (WEAK * *c / COMMAND_DIGIT_A).round() * COMMAND_DIGIT_A);
}

/// The commands of a seed. Amplitudes are for THOR's actuator: forces of some hundred N locked, a swing of less
/// than a radian on the pendulum.
#[must_use]
pub fn plan(rig: Rig, seed: u64, duration_s: f64, rate_hz: f64) -> [Planned; 4] {
    let mut d = Draws::of(seed, "commands");
    // The pendulum tips over where the locked bench bears its load.
    let size = d.between(0.85, 1.15) * if rig == Rig::Pendulum { 0.75 } else { 1.0 };
    let chirp = |amplitude: f64, from_hz: f64, to_hz: f64| Profile::Chirp {
        amplitude,
        from_hz,
        to_hz,
        duration_s,
        logarithmic: false,
    };
    let noise = |rms: f64, bandwidth_hz: f64, d: &mut Draws| Profile::Noise {
        rms: rms * size,
        bandwidth_hz: bandwidth_hz * d.between(0.85, 1.15),
        seed: d.seed(),
    };
    let stairs = |highest: f64, step_s: f64, d: &mut Draws| {
        let time_s: Vec<f64> = (0..).map(|i| f64::from(i) * step_s).take_while(|t| *t < duration_s).collect();
        let mut level = 0.0;
        let mut values = vec![0.0; time_s.len()];
        for value in values.iter_mut().skip(1) {
            // A step that is hardly one tells nothing.
            let before = level;
            while f64::abs(level - before) < 0.2 * highest {
                level = d.between(-highest, highest);
            }
            *value = level;
        }
        Profile::Table { time_s, values, linear: false }
    };
    let swept = [chirp(1.6 * size, 0.3, d.between(38.0, 50.0)), noise(1.1, 70.0, &mut d)];
    let stepped = [stairs(2.3 * size, STEP_S[0], &mut d), noise(0.15, 15.0, &mut d)];
    let random = [noise(2.2, 40.0, &mut d)];
    let slow = [
        chirp(0.7 * size, 0.1, d.between(3.0, 5.0)),
        stairs(0.6 * size, STEP_S[1], &mut d),
        noise(0.05, 15.0, &mut d),
    ];
    let rows = (duration_s * rate_hz).round() as usize;
    let command = |parts: &[Profile]| -> Vec<f64> {
        (0..rows)
            .map(|n| {
                let t = n as f64 / rate_hz;
                // It swells during the first twentieth: a bench is not kicked into motion.
                let swell = (20.0 * t / duration_s).min(1.0);
                let sum: f64 = parts.iter().map(|p| p.at(t)).sum();
                // The bench receives what the logger writes.
                (swell * sum / COMMAND_DIGIT_A).round() * COMMAND_DIGIT_A
            })
            .collect()
    };
    let planned = |file, holdout, parts: &[Profile]| Planned { file, holdout, command: command(parts) };
    [
        planned("fit_chirp.csv", false, &swept),
        planned(SECOND_FIT, false, &stepped),
        planned("check_noise.csv", true, &random),
        planned("check_low.csv", true, &slow),
    ]
}
