//! One HTML file made of sections, tables and figures that needs no network.
//!
//! A [`Report`] is filled from top to bottom with blocks and written as one string. It is legible on a phone and in print,
//! in light and dark, and every text is escaped. Figures and tables are numbered in the order in which they are seen: those
//! in [`Report::details`], which open on demand, after all others.

mod number;
mod page;
mod table;

pub use table::{Align, Column, Table};

use crate::chart::{Picture, Size, escape, figure_at, figure_html};
use maud::{Markup, PreEscaped, Render, html};
use number::Kind;

/// Most pictures of details that are printed.
const PRINTED_FIGURES: usize = 8;

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

impl Tone {
    /// Its class and its mark.
    fn looks(self) -> (&'static str, &'static str) {
        match self {
            Self::Good => ("good", "✓"),
            Self::Caution => ("caution", "!"),
            Self::Bad => ("bad", "✗"),
            Self::Neutral => ("neutral", "i"),
        }
    }
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

/// The answer of a page: what a reader must see without scrolling.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Answer<'a> {
    /// What was found, in a few words.
    pub headline: &'a str,
    /// Values with their intervals: name, value, remark.
    pub values: &'a [(String, String, String)],
    /// How sure it is, in a word or two.
    pub certainty: &'a str,
    /// Why it is that sure.
    pub reasons: &'a [String],
}

/// A text that is escaped as [`escape`] does it, control characters dropped.
struct Text<'a>(&'a str);

impl Render for Text<'_> {
    fn render_to(&self, buffer: &mut String) {
        buffer.push_str(&escape(self.0));
    }
}

/// A page that is being written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    title: String,
    subtitle: String,
    body: String,
    contents: Vec<(String, String)>,
    numbers: number::Numbers,
    wide: bool,
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
            numbers: number::Numbers::default(),
            wide: false,
        }
    }

    /// A line below the title.
    pub fn subtitle(&mut self, text: &str) -> &mut Self {
        self.subtitle = text.into();
        self
    }

    /// Lets the page be as wide as two figures side by side.
    pub fn wide(&mut self) -> &mut Self {
        self.wide = true;
        self
    }

    /// Begins a section; it appears in the list of contents.
    pub fn section(&mut self, heading: &str) -> &mut Self {
        let id = format!("s{}", self.contents.len() + 1);
        self.push(&html! { h2 id=(id) { (Text(heading)) } });
        self.contents.push((id, heading.into()));
        self
    }

    /// A smaller heading.
    pub fn subsection(&mut self, heading: &str) -> &mut Self {
        self.push(&html! { h3 { (Text(heading)) } })
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) -> &mut Self {
        self.push(&html! { p { (Text(text)) } })
    }

    /// A remark in small print.
    pub fn remark(&mut self, text: &str) -> &mut Self {
        self.push(&html! { p.small { (Text(text)) } })
    }

    /// A list of sentences.
    pub fn list<S: AsRef<str>>(&mut self, items: &[S]) -> &mut Self {
        self.push(&html! { ul { @for item in items { li { (Text(item.as_ref())) } } } })
    }

    /// Text shown as it is, for example a file or an equation.
    pub fn preformatted(&mut self, text: &str) -> &mut Self {
        self.push(&html! { pre { (Text(text)) } })
    }

    /// The verdict: one sentence in a box, with what supports it below.
    pub fn verdict(&mut self, tone: Tone, sentence: &str, support: &str) -> &mut Self {
        let (class, mark) = tone.looks();
        self.push(&html! {
            div class={ "verdict " (class) } {
                span.mark aria-hidden="true" { (mark) }
                div {
                    strong { (Text(sentence)) }
                    @if !support.is_empty() { p { (Text(support)) } }
                }
            }
        })
    }

    /// The answer in a box: headline, values with their intervals, and how sure it is with the reasons.
    pub fn answer(&mut self, tone: Tone, answer: &Answer) -> &mut Self {
        let (class, mark) = tone.looks();
        self.push(&html! {
            div class={ "verdict answer " (class) } {
                span.mark aria-hidden="true" { (mark) }
                div.said {
                    strong { (Text(answer.headline)) }
                    @if !answer.values.is_empty() {
                        div.values {
                            @for (name, value, remark) in answer.values {
                                div {
                                    span.name { (Text(name)) }
                                    span.value { (Text(value)) }
                                    span.name { (Text(remark)) }
                                }
                            }
                        }
                    }
                }
                div.sure {
                    span.word { (Text(answer.certainty)) }
                    @if let [reason] = answer.reasons {
                        p { (Text(reason)) }
                    } @else {
                        ul { @for reason in answer.reasons { li { (Text(reason)) } } }
                    }
                }
            }
        })
    }

    /// Cards side by side: a heading and sentences each; a sentence that begins with `$ ` is a command.
    pub fn cards(&mut self, cards: &[(&str, Vec<String>)]) -> &mut Self {
        self.push(&html! {
            div.cards {
                @for (heading, lines) in cards {
                    div {
                        h3 { (Text(heading)) }
                        @for line in lines {
                            @if let Some(command) = line.strip_prefix("$ ") {
                                pre { (Text(command)) }
                            } @else {
                                p { (Text(line)) }
                            }
                        }
                    }
                }
            }
        })
    }

    /// A few headline numbers side by side: name, value with unit, remark.
    pub fn numbers(&mut self, numbers: &[(&str, &str, &str)]) -> &mut Self {
        self.push(&html! {
            div.numbers {
                @for (name, value, remark) in numbers {
                    div {
                        span.name { (Text(name)) }
                        span.value { (Text(value)) }
                        span.name { (Text(remark)) }
                    }
                }
            }
        })
    }

    /// A table with its caption.
    pub fn table(&mut self, table: &Table, caption: &str) -> &mut Self {
        let number = self.numbers.next(Kind::Table);
        self.push(&table.html(&html! { "Table " (number) ". " (Text(caption)) }))
    }

    /// A figure with its caption.
    pub fn figure(&mut self, picture: &dyn Picture, caption: &str) -> &mut Self {
        self.figure_of(&[picture], caption)
    }

    /// Several pictures, one below the other, with one caption: magnitude and phase, measured and residual.
    pub fn figure_of(&mut self, pictures: &[&dyn Picture], caption: &str) -> &mut Self {
        let drawn: String = pictures.iter().map(|p| figure_html(*p)).collect();
        let figure = self.framed(&drawn, caption);
        self.push(&figure)
    }

    /// Figures side by side, each with its caption; one below the other on a phone.
    pub fn side_by_side(&mut self, figures: &[(&dyn Picture, &str)]) -> &mut Self {
        let drawn: Vec<Markup> =
            figures.iter().map(|(p, caption)| self.framed(&figure_at(*p, Size::HALF), caption)).collect();
        self.push(&html! { div.pair { @for figure in &drawn { (figure) } } })
    }

    /// Pictures side by side that are one figure, with one caption.
    pub fn figure_beside(&mut self, pictures: &[&dyn Picture], caption: &str) -> &mut Self {
        self.tiles("pair", pictures, Size::HALF, &[], caption)
    }

    /// Many small pictures in a grid with one caption; `keys` say what the lines in all of them are.
    pub fn multiples(
        &mut self,
        pictures: &[&dyn Picture],
        keys: &[(&str, crate::chart::Hue, crate::chart::Dash)],
        caption: &str,
    ) -> &mut Self {
        self.tiles("tiles", pictures, Size::SMALL, keys, caption)
    }

    fn tiles(
        &mut self,
        class: &str,
        pictures: &[&dyn Picture],
        size: Size,
        keys: &[(&str, crate::chart::Hue, crate::chart::Dash)],
        caption: &str,
    ) -> &mut Self {
        let drawn = html! {
            @if !keys.is_empty() {
                p.keys {
                    @for (name, hue, dash) in keys {
                        span { (PreEscaped(crate::chart::key(*hue, *dash))) (Text(name)) }
                    }
                }
            }
            div class=(class) {
                @for picture in pictures { div { (PreEscaped(figure_at(*picture, size))) } }
            }
        };
        let figure = self.framed(&drawn.into_string(), caption);
        self.push(&figure)
    }

    /// Drawn pictures with a number and a caption.
    fn framed(&mut self, drawn: &str, caption: &str) -> Markup {
        let number = self.numbers.next(Kind::Figure);
        let zooms = drawn.contains("class=\"zoom\"");
        html! {
            figure id={ "f" (number) } {
                (PreEscaped(drawn))
                figcaption {
                    "Figure " (number) ". " (Text(caption))
                    @if zooms {
                        span.hint { " Drag to zoom, double-click to see all, Ctrl + wheel for steps." }
                    }
                }
            }
        }
    }

    /// What a reader sees first, as one block.
    pub fn first_screen(&mut self, inside: impl FnOnce(&mut Self)) -> &mut Self {
        self.body.push_str("<section id=\"answer\">\n");
        inside(self);
        self.body.push_str("</section>\n");
        self
    }

    /// Details that open on demand, and in print; there not where they hold many pictures, which would be dozens of pages.
    pub fn details(&mut self, summary: &str, inside: impl FnOnce(&mut Self)) -> &mut Self {
        let start = self.body.len();
        self.push(&html! { (PreEscaped("<details>")) summary { (Text(summary)) } });
        self.numbers.folded += 1;
        inside(self);
        self.numbers.folded -= 1;
        if self.body[start..].matches("<figure").count() > PRINTED_FIGURES {
            self.body.insert_str(start + "<details".len(), " class=\"many\"");
        }
        self.body.push_str("</details>\n");
        self
    }

    /// Where everything came from.
    pub fn provenance(&mut self, provenance: &Provenance) -> &mut Self {
        self.section("Provenance");
        self.provenance_list(provenance)
    }

    /// The same without a heading.
    pub fn provenance_list(&mut self, provenance: &Provenance) -> &mut Self {
        let mut rows = vec![("Command".to_owned(), provenance.command.clone())];
        rows.extend(provenance.versions.iter().cloned());
        rows.extend(provenance.inputs.iter().cloned());
        rows.extend(provenance.seed.map(|seed| ("Seed".to_owned(), seed.to_string())));
        rows.extend(provenance.notes.iter().cloned());
        self.push(&html! {
            dl.provenance {
                @for (name, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
                    dt { (Text(name)) }
                    dd { (Text(value)) }
                }
            }
        })
    }

    /// The whole page.
    #[must_use]
    pub fn to_html(&self) -> String {
        let body = self.numbers.written_into(&self.body);
        page::page((&self.title, &self.subtitle), self.wide, &self.contents, &body).into_string()
    }

    fn push(&mut self, markup: &Markup) -> &mut Self {
        self.body.push_str(&markup.0);
        self.body.push('\n');
        self
    }
}
