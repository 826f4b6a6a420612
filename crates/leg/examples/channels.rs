//! Prints the channels of a scenario as CSV, to be compared with another simulator's.
//!
//! `cargo run --release -p sealegs-leg --example channels -- SCENARIO [key=value ...]`

use sealegs_leg::scenario::Scenario;
use sealegs_leg::{Channels, run};
use std::io::Write;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().ok_or("usage: channels SCENARIO [key=value ...]")?;
    let scenario = Scenario::load(&name, &arguments.collect::<Vec<_>>())?;
    let mut channels = Channels::default();
    run(&scenario, &mut channels)?;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let header: Vec<&str> = channels.signals.iter().map(|s| s.channel.as_str()).collect();
    writeln!(out, "time_s,{}", header.join(","))?;
    for (i, time) in channels.time_s.iter().enumerate() {
        write!(out, "{time}")?;
        for signal in &channels.signals {
            write!(out, ",{}", signal.values[i])?;
        }
        writeln!(out)?;
    }
    Ok(())
}
