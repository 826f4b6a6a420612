//! What the dissertation prints and its own inputs contradict, with the formula of each row.
//!
//! `cargo run --release -p sealegs-reproduce --example misses`

use sealegs_reproduce::{Verdict, reproduce, text};

fn main() -> Result<(), sealegs_reproduce::ReproduceError> {
    let reproduction = reproduce()?;
    for row in reproduction.rows.iter().filter(|row| row.verdict == Verdict::Miss) {
        let ours = row.ours.map(text::number).unwrap_or_default();
        println!("{} ({}): {}", row.id, row.reference, row.quantity);
        println!("  printed {}, here {ours} {} by {}", row.published, row.unit, row.formula);
    }
    println!("{}", text::summary(&reproduction));
    Ok(())
}
