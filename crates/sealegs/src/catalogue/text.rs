//! The catalogue and a card for a terminal.

use super::{Entry, Signature, braille};
use sealegs_model::Parameter;
use std::fmt::Write as _;

/// Width of a card's text, characters.
const WIDTH: usize = 96;

/// Words in lines of at most this width, behind an indent.
fn wrapped(text: &str, indent: usize) -> String {
    let (mut out, mut column) = (String::new(), indent);
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if column > indent && column + 1 + length > WIDTH {
            let _ = write!(out, "\n{:indent$}", "");
            column = indent;
        }
        if column > indent {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += length;
    }
    out
}

/// A number for a reader: three or four digits, powers of ten where it is large or small.
pub(super) fn value(v: f64) -> String {
    let size = v.abs();
    if v == 0.0 || v.is_infinite() || (1e-3..1e5).contains(&size) {
        let digits = if size >= 100.0 {
            0
        } else if size >= 1.0 {
            2
        } else {
            4
        };
        let text = format!("{v:.digits$}");
        return if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        };
    }
    format!("{v:.2e}")
}

/// A parameter's name with its unit.
fn named(p: &Parameter) -> String {
    if p.unit.is_empty() { p.name.clone() } else { format!("{} ({})", p.name, p.unit) }
}

/// The table of all effects.
#[must_use]
pub fn table(entries: &[Entry]) -> String {
    let id = entries.iter().map(|e| e.card().id.len()).max().unwrap_or(0);
    let acts = entries.iter().map(|e| e.card().acts_on.len()).max().unwrap_or(0);
    let mut out = format!(
        "{:<id$}  {:<acts$}  {:<10}  what it is, and its parameters\n",
        "effect", "acts on", "found on"
    );
    for entry in entries {
        let card = entry.card();
        let found = entry.found_on().join(", ");
        let _ = writeln!(out, "{:<id$}  {:<acts$}  {found:<10}  {}", card.id, card.acts_on, card.summary);
        let parameters: Vec<String> = card.parameters.iter().map(named).collect();
        let _ = writeln!(out, "{:id$}  {:acts$}  {:<10}  {}", "", "", "", parameters.join(", "));
    }
    let _ = writeln!(
        out,
        "\n{} effects. `sealegs effects ID` shows one with its law and its signature. On a leg an id carries its place: \
         knee/coulomb-friction. Units are a linear actuator's; a rotary one has N m and rad.",
        entries.len()
    );
    out
}

/// The card of one effect with its signature.
#[must_use]
pub fn card(entry: &Entry, signature: &Signature) -> String {
    let c = entry.card();
    let mut out = format!("{}\n{}\n\n", c.id, wrapped(&c.summary, 0));
    let mut line = |name: &str, text: &str| {
        let _ = writeln!(out, "{name:<14}{}", wrapped(text, 14));
    };
    line("acts on", &format!("{} ({})", c.acts_on, entry.found_on().join(", ")));
    line("law", &c.equation);
    line("symbols", &c.symbols);
    line("validity", &c.validity);
    line("told apart", &c.told_apart);
    line("usual cure", &c.cure);
    line("reference", &c.reference);
    line("energy", if c.passive { "takes it out or stores it" } else { "can put it in" });
    if let Some(law) = &c.becomes {
        line("contains", law.id);
    }
    let width = c.parameters.iter().map(|p| named(p).chars().count()).max().unwrap_or(0).max(9);
    let _ = writeln!(
        out,
        "\n{:<width$}  {:>12}{:>12}{:>12}{:>12}",
        "parameter", "guess", "least", "greatest", "off at"
    );
    for p in &c.parameters {
        let off = p.neutral.map_or_else(|| "-".to_owned(), value);
        let _ = writeln!(
            out,
            "{:<width$}  {:>12}{:>12}{:>12}{off:>12}",
            named(p),
            value(p.value),
            value(p.min),
            value(p.max)
        );
    }
    let _ = writeln!(out, "\nSignature on {}, at {}.", signature.run, at(entry, signature));
    if let Some(law) = &signature.law {
        let _ = write!(out, "\n{}", braille(law));
    }
    let _ = write!(out, "\n{}", braille(&signature.residual));
    out
}

/// The values that a signature was computed at.
pub(super) fn at(entry: &Entry, signature: &Signature) -> String {
    let pair = |(p, v): (&Parameter, &f64)| {
        let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
        format!("{} = {}{unit}", p.name, value(*v))
    };
    entry.card().parameters.iter().zip(&signature.values).map(pair).collect::<Vec<_>>().join(", ")
}
