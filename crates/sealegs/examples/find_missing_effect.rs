//! Finds the effect that a campaign's model lacks, and how far the error falls with it: `... -- FOLDER`.

use sealegs::{Campaign, add, diagnose};
use std::path::PathBuf;

fn main() -> sealegs::Result<()> {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/campaigns/bench-knee");
    let folder = std::env::args_os().nth(1).map_or_else(|| shipped.into(), PathBuf::from);
    let campaign = Campaign::read(&folder)?;
    let verdict = diagnose(&campaign, sealegs::Options::new())?;
    println!("{}", verdict.sentence());
    let effects = &verdict.outcome().effects;
    if !effects.is_empty() {
        println!("{}", add(effects, &campaign, sealegs::Options::new())?.sentence());
    }
    Ok(())
}
