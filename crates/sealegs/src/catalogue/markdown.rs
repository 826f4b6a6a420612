//! The catalogue as pages of the documentation's book.

use super::text::{at, value};
use super::{Entry, Signature, entries, svg};
use crate::Result;
use sealegs_actuator::effect::Graph;
use std::fmt::Write as _;

/// One page of the book.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// File name, for example `backlash.md`.
    pub file: String,
    /// Its text.
    pub text: String,
}

/// Said at the head of every page that is made.
const MADE: &str =
    "<!-- Made by `sealegs effects --book docs/src/effects` from the effect's card: do not edit. -->\n\n";

/// All pages: one for each effect, and `index.md` with the table.
///
/// # Errors
///
/// If a signature cannot be computed.
pub fn book() -> Result<Vec<Page>> {
    let all = entries()?;
    let mut pages = vec![Page { file: "index.md".to_owned(), text: index(&all) }];
    for entry in &all {
        let text = page(entry, &entry.signature()?);
        pages.push(Page { file: format!("{}.md", entry.page_name()), text });
    }
    Ok(pages)
}

/// A picture as a block of its own, whose text is no Markdown.
fn figure(graph: &Graph) -> String {
    format!("<div>\n{}\n</div>", svg(graph))
}

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn index(all: &[Entry]) -> String {
    let mut out = format!(
        "{MADE}# The catalogue of effects\n\nOn a leg an id carries its place: `knee/coulomb-friction`. Units are a \
         linear actuator's; for a rotary one N m and rad stand for N and m.\n\n\
         | effect | acts on | found on | what it is |\n|---|---|---|---|\n"
    );
    for entry in all {
        let card = entry.card();
        let _ = writeln!(
            out,
            "| [`{}`]({}.md) | {} | {} | {} |",
            card.id,
            entry.page_name(),
            card.acts_on,
            entry.found_on().join(", "),
            cell(&card.summary)
        );
    }
    out
}

fn page(entry: &Entry, signature: &Signature) -> String {
    let c = entry.card();
    let title = if entry.page_name() == c.id { c.id.clone() } else { format!("{} (leg)", c.id) };
    let mut out = format!("{MADE}# {title}\n\n{}\n\n```text\n{}\n```\n\n", c.summary, c.equation);
    let _ = writeln!(out, "{}.\n", c.symbols);
    let _ = writeln!(out, "- **Acts on**: {} ({}).", c.acts_on, entry.found_on().join(", "));
    let _ = writeln!(out, "- **Sign and validity**: {}", c.validity);
    let _ = writeln!(out, "- **Told apart**: {}", c.told_apart);
    let _ = writeln!(out, "- **Usual cure**: {}", c.cure);
    let _ = writeln!(out, "- **Reference**: {}", c.reference);
    let energy = if c.passive { "It takes energy out or stores it." } else { "It can put energy in." };
    let _ = writeln!(out, "- **Energy**: {energy}");
    if let Some(law) = &c.becomes {
        let _ = writeln!(out, "- **Contains**: [`{0}`]({0}.md)", law.id);
    }
    out.push_str("\n| parameter | unit | guess | least | greatest | off at |\n|---|---|---|---|---|---|\n");
    for p in &c.parameters {
        let off = p.neutral.map_or_else(|| "-".to_owned(), value);
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} | {} | {off} |",
            p.name,
            p.unit,
            value(p.value),
            value(p.min),
            value(p.max)
        );
    }
    let _ = writeln!(
        out,
        "\nGuess and range follow what was seen: here {}.\n\n## Signature\n\nAt {}.\n",
        signature.run,
        at(entry, signature)
    );
    if let Some(law) = &signature.law {
        let _ = writeln!(out, "{}:\n\n{}\n", law.title, figure(law));
    }
    let _ = writeln!(
        out,
        "What a log shows where the model lacks it, measured minus predicted, in the channel that shows it best:\n\n{}",
        figure(&signature.residual)
    );
    out
}
