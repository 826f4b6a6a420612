//! The reproduction as a table for a terminal and as JSON.

use serde_json::{Value, json};

use crate::{Reproduction, Row, Verdict, findings};

/// A number with four significant digits, or five where a fifth is needed to tell it from the print.
#[must_use]
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e6).contains(&magnitude) {
        format!("{value:.4e}")
    } else {
        let decimals = (4 - magnitude.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }
}

/// A deviation in per cent; a factor where per cent make no sense.
#[must_use]
pub fn deviation(row: &Row) -> String {
    match row.deviation {
        None => String::new(),
        Some(d) if d.abs() < 5e-6 => "0 %".to_owned(),
        Some(d) if d > 9.0 => format!("x {:.1e}", 1.0 + d),
        Some(d) if d.abs() < 1e-3 => format!("{:+.3} %", 100.0 * d),
        Some(d) => format!("{:+.2} %", 100.0 * d),
    }
}

/// The table, its summary and what it points to. Without `all`, only rows that were recomputed and miss.
#[must_use]
pub fn table(r: &Reproduction, all: bool) -> String {
    let mut out = String::new();
    let cells = |row: &Row| {
        [
            row.id.clone(),
            row.reference.clone(),
            shortened(&row.quantity, 58),
            row.published.clone(),
            row.ours.map(number).unwrap_or_default(),
            row.unit.clone(),
            deviation(row),
            row.verdict.label().to_owned(),
        ]
    };
    let head = ["row", "where", "quantity", "published", "ours", "unit", "deviation", "verdict"];
    let rows: Vec<[String; 8]> =
        r.rows.iter().filter(|row| all || row.verdict == Verdict::Miss).map(cells).collect();
    let width =
        |i: usize| rows.iter().map(|c| c[i].chars().count()).chain([head[i].len()]).max().unwrap_or(0);
    let widths: Vec<usize> = (0..8).map(width).collect();
    let mut line = |cells: &[String]| {
        let padded: Vec<String> =
            cells
                .iter()
                .enumerate()
                .map(|(i, c)| {
                    if i == 4 { format!("{c:>w$}", w = widths[i]) } else { format!("{c:<w$}", w = widths[i]) }
                })
                .collect();
        out.push_str(padded.join("  ").trim_end());
        out.push('\n');
    };
    line(&head.map(str::to_owned));
    for (cells, row) in rows.iter().zip(r.rows.iter().filter(|row| all || row.verdict == Verdict::Miss)) {
        line(cells);
        if !row.why.is_empty() {
            line(&[String::new(), format!("  {}", row.why)]);
        }
    }
    out.push('\n');
    out.push_str(&summary(r));
    out.push('\n');
    for finding in findings(r) {
        out.push_str(&format!("\n{}\n", finding.title));
        for sentence in &finding.sentences {
            out.push_str(&format!("  {sentence}\n"));
        }
    }
    out
}

/// One sentence with the counts.
#[must_use]
pub fn summary(r: &Reproduction) -> String {
    format!(
        "{} rows: {} agree, {} differ by rounding or loose wording, {} are missed by what the dissertation itself states, {} are derived, {} are statements that nothing recomputes.",
        r.rows.len(),
        r.count(Verdict::Agrees),
        r.count(Verdict::Rounding),
        r.count(Verdict::Miss),
        r.count(Verdict::Derived),
        r.count(Verdict::Statement)
    )
}

fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let cut: String = text.chars().take(most - 1).collect();
    format!("{}…", cut.trim_end())
}

/// Everything as one JSON value.
#[must_use]
pub fn json(r: &Reproduction) -> Value {
    json!({
        "rows": r.rows,
        "counts": {
            "agrees": r.count(Verdict::Agrees),
            "rounding": r.count(Verdict::Rounding),
            "miss": r.count(Verdict::Miss),
            "derived": r.count(Verdict::Derived),
            "statement": r.count(Verdict::Statement),
        },
        "table_8": r.table_8,
        "softer_than_designed": r.softer,
        "moving_output_explanations": r.explanations,
        "findings": findings(r),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_five_digits() {
        assert_eq!(number(17.021_653), "17.022");
        assert_eq!(number(655_399.0), "655399");
        assert_eq!(number(1.061_033e-4), "1.0610e-4");
        assert_eq!(number(12.0), "12");
        assert_eq!(number(-0.081_542), "-0.081542");
        assert_eq!(number(0.0), "0");
    }
}
