//! Tables with numbers aligned to the right and units in the head.

use super::Text;
use maud::{Markup, html};

/// Bytes of a cell beyond which it is a sentence, and its column does not get narrower than some words.
const SENTENCE: usize = 40;

/// How a column stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Align {
    /// Words.
    #[default]
    Left,
    /// Numbers.
    Right,
}

/// A column's head.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The unit of its numbers; empty for none.
    pub unit: String,
    /// How it stands.
    pub align: Align,
}

/// A table of texts; numbers are formatted by whoever knows their precision.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows, and whether each is emphasised.
    pub rows: Vec<(Vec<String>, bool)>,
}

impl Table {
    /// A table without columns.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a column of words.
    #[must_use]
    pub fn words(mut self, name: &str) -> Self {
        self.columns.push(Column { name: name.into(), ..Column::default() });
        self
    }

    /// Adds a column of numbers with their unit.
    #[must_use]
    pub fn numbers(mut self, name: &str, unit: &str) -> Self {
        self.columns.push(Column { name: name.into(), unit: unit.into(), align: Align::Right });
        self
    }

    /// Adds a row. Missing cells stay empty, surplus ones are shown below the last head.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) -> &mut Self {
        self.rows.push((cells.into_iter().map(Into::into).collect(), false));
        self
    }

    /// Adds a row that stands out.
    pub fn strong_row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) -> &mut Self {
        self.rows.push((cells.into_iter().map(Into::into).collect(), true));
        self
    }

    /// The table as HTML, in a box that scrolls where the window is too narrow; its caption does not scroll with it.
    pub(super) fn html(&self, caption: &Markup) -> Markup {
        let longest =
            |i: usize| self.rows.iter().filter_map(|(cells, _)| cells.get(i)).map(String::len).max();
        let classes: Vec<Option<&str>> = (0..self.columns.len())
            .map(|i| match self.columns[i].align {
                Align::Right => Some("num"),
                _ => longest(i).filter(|&longest| longest > SENTENCE).map(|_| "text"),
            })
            .collect();
        let class = |i: usize| classes.get(i).copied().flatten();
        html! {
            figure.tabled {
                figcaption { (caption) }
                div.table { table {
                    thead {
                        tr {
                            @for (i, column) in self.columns.iter().enumerate() {
                                th scope="col" class=[class(i)] {
                                    (Text(&column.name))
                                    @if !column.unit.is_empty() { span.unit { (Text(&column.unit)) } }
                                }
                            }
                        }
                    }
                    tbody {
                        @for (cells, strong) in &self.rows {
                            tr class=[strong.then_some("strong")] {
                                @for i in 0..cells.len().max(self.columns.len()) {
                                    td class=[class(i)] { (Text(cells.get(i).map_or("", String::as_str))) }
                                }
                            }
                        }
                    }
                } }
            }
        }
    }
}
