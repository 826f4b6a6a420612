//! One HTML file made of sections, tables and figures that needs no network.
//!
//! A [`Report`] is filled from top to bottom with blocks and written as one string. It is legible on a
//! phone and in print, in light and dark, and every text is escaped.

mod page;
mod table;

pub use table::{Align, Column, Table};

use crate::chart::{Picture, escape, figure_html};

/// How a verdict feels, shown by a word and a mark as well as by a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// As it should be.
    Good,
    /// Read on: ambiguous, or at a limit.
    Caution,
    /// Not as it should be.
    Bad,
    /// A statement.
    Neutral,
}

/// What a report was made from, so that it can be made again.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// The command as it was given.
    pub command: String,
    /// Programs and their versions.
    pub versions: Vec<(String, String)>,
    /// Input files and the hash of their bytes, with the hash's name: `sha256:...`.
    pub inputs: Vec<(String, String)>,
    /// The seed of what is random, if anything is.
    pub seed: Option<u64>,
    /// Anything else worth stating: thread count, duration, date.
    pub notes: Vec<(String, String)>,
}

/// A page that is being written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    title: String,
    subtitle: String,
    body: String,
    contents: Vec<(String, String)>,
    figures: usize,
    tables: usize,
}

impl Report {
    /// An empty report.
    #[must_use]
    pub fn new(title: &str) -> Self {
        Self {
            title: title.into(),
            subtitle: String::new(),
            body: String::new(),
            contents: Vec::new(),
            figures: 0,
            tables: 0,
        }
    }

    /// A line below the title.
    pub fn subtitle(&mut self, text: &str) -> &mut Self {
        self.subtitle = text.into();
        self
    }

    /// Begins a section; it appears in the list of contents.
    pub fn section(&mut self, heading: &str) -> &mut Self {
        let id = format!("s{}", self.contents.len() + 1);
        self.body.push_str(&format!("<h2 id=\"{id}\">{}</h2>\n", escape(heading)));
        self.contents.push((id, heading.into()));
        self
    }

    /// A smaller heading.
    pub fn subsection(&mut self, heading: &str) -> &mut Self {
        self.element("h3", heading)
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.element("p", text)
    }

    /// A remark in small print.
    pub fn remark(&mut self, text: &str) -> &mut Self {
        self.body.push_str(&format!("<p class=\"small\">{}</p>\n", escape(text)));
        self
    }

    /// A list of sentences.
    pub fn list<S: AsRef<str>>(&mut self, items: &[S]) -> &mut Self {
        let items: String = items.iter().map(|i| format!("<li>{}</li>", escape(i.as_ref()))).collect();
        self.body.push_str(&format!("<ul>{items}</ul>\n"));
        self
    }

    /// Text shown as it is, for example a file or an equation.
    pub fn preformatted(&mut self, text: &str) -> &mut Self {
        self.element("pre", text)
    }

    /// The verdict: one sentence in a box, with what supports it below.
    pub fn verdict(&mut self, tone: Tone, sentence: &str, support: &str) -> &mut Self {
        let (class, mark) = match tone {
            Tone::Good => ("good", "✓"),
            Tone::Caution => ("caution", "!"),
            Tone::Bad => ("bad", "✗"),
            Tone::Neutral => ("neutral", "i"),
        };
        let support = if support.is_empty() { String::new() } else { format!("<p>{}</p>", escape(support)) };
        self.body.push_str(&format!(
            "<div class=\"verdict {class}\"><span class=\"mark\" aria-hidden=\"true\">{mark}</span><div><strong>{}</strong>{support}</div></div>\n",
            escape(sentence)
        ));
        self
    }

    /// A few headline numbers side by side: name, value with unit, remark.
    pub fn numbers(&mut self, numbers: &[(&str, &str, &str)]) -> &mut Self {
        let cells: String = numbers
            .iter()
            .map(|(name, value, remark)| {
                format!(
                    "<div><span class=\"name\">{}</span><span class=\"value\">{}</span><span class=\"name\">{}</span></div>",
                    escape(name), escape(value), escape(remark)
                )
            })
            .collect();
        self.body.push_str(&format!("<div class=\"numbers\">{cells}</div>\n"));
        self
    }

    /// A table with its caption.
    pub fn table(&mut self, table: &Table, caption: &str) -> &mut Self {
        self.tables += 1;
        let caption = format!("Table {}. {}", self.tables, caption);
        self.body.push_str(&table.html(&caption));
        self
    }

    /// A figure with its caption.
    pub fn figure(&mut self, picture: &dyn Picture, caption: &str) -> &mut Self {
        self.figure_of(&[picture], caption)
    }

    /// Several pictures, one below the other, with one caption: magnitude and phase, measured and residual.
    pub fn figure_of(&mut self, pictures: &[&dyn Picture], caption: &str) -> &mut Self {
        self.figures += 1;
        let drawn: String = pictures.iter().map(|p| figure_html(*p)).collect();
        let hint = if drawn.contains("class=\"zoom\"") {
            " <span class=\"hint\">Drag to zoom, double-click to see all, Ctrl + wheel for steps.</span>"
        } else {
            ""
        };
        self.body.push_str(&format!(
            "<figure id=\"f{0}\">{drawn}<figcaption>Figure {0}. {1}{hint}</figcaption></figure>\n",
            self.figures,
            escape(caption)
        ));
        self
    }

    /// Details that open on demand (and in print).
    pub fn details(&mut self, summary: &str, inside: impl FnOnce(&mut Self)) -> &mut Self {
        self.body.push_str(&format!("<details><summary>{}</summary>\n", escape(summary)));
        inside(self);
        self.body.push_str("</details>\n");
        self
    }

    /// Where everything came from.
    pub fn provenance(&mut self, provenance: &Provenance) -> &mut Self {
        self.section("Provenance");
        let mut rows = vec![("Command".to_owned(), provenance.command.clone())];
        rows.extend(provenance.versions.iter().cloned());
        rows.extend(provenance.inputs.iter().cloned());
        rows.extend(provenance.seed.map(|seed| ("Seed".to_owned(), seed.to_string())));
        rows.extend(provenance.notes.iter().cloned());
        let rows: String = rows
            .iter()
            .filter(|(_, value)| !value.is_empty())
            .map(|(name, value)| format!("<dt>{}</dt><dd>{}</dd>", escape(name), escape(value)))
            .collect();
        self.body.push_str(&format!("<dl class=\"provenance\">{rows}</dl>\n"));
        self
    }

    /// The whole page.
    #[must_use]
    pub fn to_html(&self) -> String {
        page::page(&self.title, &self.subtitle, &self.contents, &self.body)
    }

    fn element(&mut self, tag: &str, text: &str) -> &mut Self {
        self.body.push_str(&format!("<{tag}>{}</{tag}>\n", escape(text)));
        self
    }
}
