//! What is in a log file, whatever wrote it: its tables, their clocks, and what each column probably is.
//!
//! `cargo run --release -p sealegs-logs --example what_is_in_it -- FILE`

use sealegs_logs::{read, survey::survey};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/campaigns/bench-knee/fit-chirp.csv");
    let file = std::env::args_os().nth(1).map_or_else(|| shipped.into(), PathBuf::from);
    for table in survey(&read(&file)?).tables {
        println!("{} {} rows", table.name, table.rows);
        if let Some(clock) = table.clock {
            let name = &table.columns[clock.column].name;
            println!(
                "  clock {name}: {:.1} Hz over {:.2} s, {} gaps",
                clock.rate_hz, clock.duration_s, clock.gaps
            );
        }
        for column in table.columns {
            let range = column.range.map_or("no number".to_owned(), |(low, high)| format!("{low} to {high}"));
            let role = column.role.map_or(String::new(), |r| format!(", probably {}", r.target));
            println!("  {}: {range}{role}", column.name);
        }
    }
    Ok(())
}
