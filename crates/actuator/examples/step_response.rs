//! What dry friction in the drive does to the force of a locked actuator after a step of current.
//!
//! `cargo run --release -p sealegs-actuator --example step_response -- [ACTUATOR] [AMPERES]`

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel};
use sealegs_actuator::response::{ForceResponse, plant_bandwidth_hz};
use sealegs_model::{Excitation, InputHold, Model, Parameter, Record, Signal};

/// Dry friction in the drive, N.
const FRICTION_N: f64 = 100.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let actuator = arguments.next().unwrap_or_else(|| "thor-linear".to_owned());
    let current_a: f64 = arguments.next().map_or(Ok(2.0), |text| text.parse())?;
    let spec = ActuatorSpec::load(&actuator, None)?;

    let c = spec.coefficients();
    let modes = ForceResponse::locked(&c).sprung.resonances();
    for mode in &modes {
        println!("natural frequency {:.2} Hz, damping ratio {:.2}", mode.frequency_hz, mode.damping_ratio);
    }
    println!("-3 dB at {:.2} Hz; {:.1} N/A", plant_bandwidth_hz(&c), c.force_constant);

    let time_s: Vec<f64> = (0..1000).map(|i| 1e-3 * f64::from(i)).collect();
    let record = Record {
        cut: false,
        name: "step".to_owned(),
        inputs: vec![Signal { channel: "current_a".to_owned(), values: vec![current_a; time_s.len()] }],
        outputs: Vec::new(),
        hold: InputHold::ZeroOrder,
        time_s,
    };
    let ideal = BenchModel::new(spec, Bench::Locked)?;
    let rubbing = ideal.including("coulomb-friction", &Excitation::default())?;
    for (name, model) in [("ideal", ideal), ("with dry friction", rubbing)] {
        let value = |p: &Parameter| if p.name == "coulomb-friction.force_n" { FRICTION_N } else { p.value };
        let values: Vec<f64> = model.parameters().iter().map(value).collect();
        let prediction = model.predict(&values, &record, &["force_1_n".to_owned()])?;
        let force_n = prediction.output("force_1_n").expect("a locked bench has it");
        let most_n = force_n.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        println!("{name}: peaks at {most_n:.0} N, ends at {:.0} N", force_n[force_n.len() - 1]);
    }
    Ok(())
}
