//! Truth for a test of one's own: the independent simulator runs the locked bench with play in the drive and without.
//!
//! `cargo run --release -p sealegs-reference --example hidden_backlash -- [PLAY_MM]`

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::Bench;
use sealegs_actuator::excitation::Profile;
use sealegs_reference::Reference;

const PERIOD_S: f64 = 1e-3;
/// Steps of the simulator for each sample.
const SUBSTEPS: usize = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let play_mm: f64 = std::env::args().nth(1).map_or(Ok(0.1), |text| text.parse())?;
    let spec = ActuatorSpec::preset("thor-linear")?;
    let time_s: Vec<f64> = (0..5000).map(|i| PERIOD_S * f64::from(i)).collect();
    let command_a = Profile::Sine { amplitude: 2.0, frequency_hz: 2.0, phase_rad: 0.0 }.sample(&time_s);
    let ideal = Reference::of(&spec, Bench::Locked, "current_a");
    let played = ideal.clone().with("backlash", &[1e-3 * play_mm]);
    let (without, with) =
        (ideal.run(PERIOD_S, &command_a, SUBSTEPS), played.run(PERIOD_S, &command_a, SUBSTEPS));
    let square: f64 = without.force_1.iter().zip(&with.force_1).map(|(a, b)| (a - b).powi(2)).sum();
    let rms_n = (square / time_s.len() as f64).sqrt();
    println!("{play_mm} mm of play change the force by {rms_n:.1} N (root mean square)");
    Ok(())
}
