//! The reproduction as one self-contained page.

use sealegs_recorder::chart::Picture;
use sealegs_recorder::report::{Provenance, Report, Table, Tone};

use crate::figures::figures;
use crate::findings::findings;
use crate::text::{deviation, number, summary};
use crate::{ReproduceError, Reproduction, Row, Verdict};
use sealegs_actuator::design::{PERFORMANCE_HEADS, performance_cells};

/// The page: summary, findings, misses, figures, Table 8, every row.
///
/// # Errors
///
/// If a preset is missing.
pub fn html(r: &Reproduction, command: &str) -> Result<String, ReproduceError> {
    let mut page = Report::new("The dissertation, recomputed");
    page.subtitle(
        "Series Elasticity in Linearly Actuated Humanoids: what its numbers are when its own models compute them",
    );
    page.verdict(Tone::Neutral, &summary(r), "Verdicts follow from the distance to the printed digits. Nothing is tuned to the print; a miss stays a miss.");
    let hz = |id: &str| r.ours(id).map(|v| format!("{v:.2} Hz")).unwrap_or_default();
    page.numbers(&[
        ("Locked bench", &hz("S3-04"), "natural frequency, as published"),
        ("Moving output, unlumped", &hz("R3-11"), "printed 15.76 Hz: a miss of 8 %"),
        ("Moving output, lumped", &hz("R3-12"), "printed 6.35 Hz: a miss of 7 %"),
        ("Controlled, 200 N, 10 A, stiff", &hz("F4-bw-655-200N-10A"), "bound of eq 4-52: 42.0 Hz"),
    ]);

    page.section("What the numbers point to");
    for finding in findings(r) {
        page.subsection(&finding.title);
        page.list(&finding.sentences);
    }
    page.table(
        &explanations(r),
        "One cause at a time, chosen to fit both printed peaks (15.76 and 6.35 Hz) as well as it can.",
    );

    page.section("Misses");
    page.table(
        &rows(r.rows.iter().filter(|row| row.verdict == Verdict::Miss)),
        "What the dissertation prints and its own inputs contradict.",
    );

    page.section("Figures");
    for figure in figures(r)? {
        let pictures: Vec<&dyn Picture> = figure.charts.iter().map(|c| c as &dyn Picture).collect();
        page.subsection(&format!("Dissertation figure {}: {}", figure.number, figure.title));
        page.figure_of(&pictures, &figure.caption);
    }

    page.section("Table 8 as it should be");
    page.table(&table_8(r), "At 10 A and 200 N. Printed omega_max by column: 65.3, 86.6, 135.4, 179.7 Hz (sorted by size); printed natural frequencies 6.84 and 10.19 Hz are -3 dB frequencies.");

    page.section("Every value");
    let recomputed = |chapter: fn(&str) -> bool| {
        rows(r.rows.iter().filter(move |row| row.verdict != Verdict::Statement && chapter(&row.id)))
    };
    page.table(&recomputed(|id| chapter(id) == 2), "Chapters 1 and 2.");
    page.table(&recomputed(|id| chapter(id) == 3), "Chapter 3.");
    page.table(&recomputed(|id| chapter(id) == 4), "Chapter 4.");
    page.details("Statements, not recomputed", |page| {
        page.table(&statements(r), "Printed values that nothing in the text determines.");
    });
    page.provenance(&Provenance {
        command: command.to_owned(),
        versions: vec![("sealegs".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        inputs: Vec::new(),
        seed: None,
        notes: vec![
            (
                "Noise".to_owned(),
                "fixed seeds: 1 for the identification rehearsal, 100 to 111 for the moving output"
                    .to_owned(),
            ),
            ("Units".to_owned(), "SI; deviation = ours/published - 1".to_owned()),
        ],
    });
    Ok(page.to_html())
}

/// The chapter of a row; chapter 1 is shown with chapter 2.
fn chapter(id: &str) -> u32 {
    match id.get(..2).unwrap_or_default() {
        "E3" | "T5" | "R3" | "S3" => 3,
        "E4" | "T8" | "R4" | "F4" | "S4" => 4,
        _ => 2,
    }
}

fn rows<'a>(of: impl Iterator<Item = &'a Row>) -> Table {
    let mut table = Table::new()
        .words("Row")
        .words("Quantity, and why")
        .words("Published")
        .numbers("Ours", "")
        .numbers("Deviation", "")
        .words("Verdict");
    for row in of {
        let why = if row.why.is_empty() { String::new() } else { format!(" — {}", row.why) };
        table.row([
            format!("{} ({})", row.id, row.reference),
            format!("{}{why}", row.quantity),
            row.published.clone(),
            row.ours.map(|v| with_unit(v, &row.unit)).unwrap_or_default(),
            deviation(row),
            row.verdict.label().to_owned(),
        ]);
    }
    table
}

/// A number with its unit, none for a ratio.
fn with_unit(value: f64, unit: &str) -> String {
    if unit == "-" { number(value) } else { format!("{} {unit}", number(value)) }
}

fn statements(r: &Reproduction) -> Table {
    let mut table = Table::new()
        .words("Row")
        .words("Where")
        .words("Quantity")
        .words("Published")
        .words("Unit")
        .words("Remark");
    for row in r.rows.iter().filter(|row| row.verdict == Verdict::Statement) {
        let remark = match row.ours {
            Some(ours) => format!("{} {}: {}", number(ours), row.unit, row.why),
            None => row.why.clone(),
        };
        table.row([
            row.id.clone(),
            row.reference.clone(),
            row.quantity.clone(),
            row.published.clone(),
            if row.unit == "-" { String::new() } else { row.unit.clone() },
            remark,
        ]);
    }
    table
}

fn explanations(r: &Reproduction) -> Table {
    let mut table = Table::new()
        .words("Changed")
        .words("To")
        .numbers("Unlumped peak", "Hz")
        .numbers("Lumped peak", "Hz")
        .numbers("Dip", "Hz")
        .numbers("Off, root mean square", "%");
    for e in &r.explanations {
        table.row([
            e.change.clone(),
            e.value.clone(),
            format!("{:.2}", e.unlumped_hz),
            format!("{:.2}", e.lumped_hz),
            format!("{:.3}", e.dip_hz),
            format!("{:.1}", 100.0 * e.misfit),
        ]);
    }
    table
}

fn table_8(r: &Reproduction) -> Table {
    let mut table = Table::new().words(PERFORMANCE_HEADS[0].0);
    for (name, unit) in &PERFORMANCE_HEADS[1..] {
        table = table.numbers(name, unit);
    }
    for (name, p) in ["soft SBN", "soft SMH", "stiff SBN", "stiff SMH"].into_iter().zip(&r.table_8) {
        table.row(performance_cells(name, p));
    }
    table
}
