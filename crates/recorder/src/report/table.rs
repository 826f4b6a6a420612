//! Tables with numbers aligned to the right and units in the head.

use crate::chart::escape;

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

    /// The table as HTML, in a box that scrolls where the window is too narrow.
    pub(super) fn html(&self, caption: &str) -> String {
        let class = |i: usize| match self.columns.get(i).map(|c| c.align) {
            Some(Align::Right) => " class=\"num\"",
            _ => "",
        };
        let head: String = self
            .columns
            .iter()
            .enumerate()
            .map(|(i, c)| {
                let unit = if c.unit.is_empty() {
                    String::new()
                } else {
                    format!("<span class=\"unit\">{}</span>", escape(&c.unit))
                };
                format!("<th scope=\"col\"{}>{}{unit}</th>", class(i), escape(&c.name))
            })
            .collect();
        let rows: String = self
            .rows
            .iter()
            .map(|(cells, strong)| {
                let width = cells.len().max(self.columns.len());
                let cells: String = (0..width)
                    .map(|i| {
                        let text = cells.get(i).map_or("", String::as_str);
                        format!("<td{}>{}</td>", class(i), escape(text))
                    })
                    .collect();
                format!("<tr{}>{cells}</tr>", if *strong { " class=\"strong\"" } else { "" })
            })
            .collect();
        format!(
            "<div class=\"table\"><table><caption>{}</caption><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>\n",
            escape(caption)
        )
    }
}
