//! The frequency response from the first command to the first measured channel of a campaign, with coherence, and its
//! peak.
//!
//! `cargo run --release -p sealegs-sysid --example frequency_response -- CAMPAIGN`

use sealegs_sysid::frf::{Estimator, Hold, Welch, peak_near};
use sealegs_sysid::{Campaign, Role};
use std::path::PathBuf;

/// Samples of a segment: lines 0.24 Hz apart at 500 Hz.
const SEGMENT: usize = 2048;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/campaigns/bench-knee");
    let folder = std::env::args_os().nth(1).map_or_else(|| shipped.into(), PathBuf::from);
    let campaign = Campaign::read(&folder)?;
    let mut pairs = Vec::new();
    let mut channels = None;
    for run in campaign.runs_of(Role::Fit) {
        let (Some(input), Some(output)) = (run.record.inputs.first(), run.record.outputs.first()) else {
            continue;
        };
        channels = Some((input.channel.as_str(), output.channel.as_str(), run.record.mean_period_s()));
        pairs.push((input.values.as_slice(), output.values.as_slice()));
    }
    let (input, output, period_s) = channels.ok_or("no fit run has a command and a measurement")?;
    let spectra = Welch::hann(SEGMENT).spectra(period_s, &pairs)?;
    let response = spectra.response(Estimator::H1).without_hold(Hold::ZeroOrder);
    println!("{output} per {input}");
    let magnitudes_db = response.magnitude_db();
    for wanted_hz in [1.0, 2.0, 5.0, 10.0, 20.0, 50.0] {
        let i = response.frequency_hz.partition_point(|f| *f < wanted_hz);
        if let (Some(hz), Some(db)) = (response.frequency_hz.get(i), magnitudes_db.get(i)) {
            println!("{hz:8.2} Hz {db:8.2} dB   coherence {:.3}", response.coherence[i]);
        }
    }
    if let Some(peak) = peak_near(&response.frequency_hz, &magnitudes_db, 5.0, 60.0, 0.5) {
        println!("peak: {:.2} dB at {:.2} Hz", peak.magnitude_db, peak.frequency_hz);
    }
    Ok(())
}
