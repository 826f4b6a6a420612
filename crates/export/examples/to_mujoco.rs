//! An actuator on the locked bench as a file of MuJoCo, and what that format holds of its effects.
//!
//! `cargo run --release -p sealegs-export --example to_mujoco -- [ACTUATOR] [FILE.xml]`

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, BenchModel};
use sealegs_export::{Format, bench};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let actuator = arguments.next().unwrap_or_else(|| "thor-linear".into());
    let file = arguments.next().map(PathBuf::from);
    let spec = ActuatorSpec::load(&actuator.to_string_lossy(), None)?;
    let stem = file.as_ref().and_then(|f| f.file_stem()).map_or("bench".into(), |s| s.to_string_lossy());
    let exported = bench(Format::Mjcf, &BenchModel::new(spec, Bench::Locked)?, "current_a", &stem)?;
    for note in &exported.notes {
        eprintln!("{note}");
    }
    match file {
        Some(file) => {
            for (name, text) in &exported.beside {
                std::fs::write(file.with_file_name(name), text)?;
            }
            std::fs::write(file, exported.text)?;
        }
        None => print!("{}", exported.text),
    }
    Ok(())
}
