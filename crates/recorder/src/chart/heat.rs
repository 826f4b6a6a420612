//! A map: one value for each cell of a grid, as shade and as number.

use super::axis::axis_label;
use super::bars::shortened;
use super::svg::{open, px, text, text_width, wrap};
use super::{Axis, Picture, Size};

/// A grid of values, for example the residual by speed and load.
///
/// The shade goes from the page's own colour at the least value to vermillion at the greatest; each cell
/// says its number too, so that nothing hangs on the shade. Cells that are not a number are empty: no data.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HeatMap {
    /// What is shown.
    pub title: String,
    /// The horizontal quantity; only its label and unit are used.
    pub x: Axis,
    /// The vertical quantity; only its label and unit are used.
    pub y: Axis,
    /// Names of the columns from left to right, for example `0 to 0.1`.
    pub columns: Vec<String>,
    /// Names of the rows from bottom to top.
    pub rows: Vec<String>,
    /// Values, row after row from the bottom.
    pub values: Vec<f64>,
    /// What the values are, with unit, for example `residual RMS [noise units]`.
    pub value_label: String,
    /// Decimals of the numbers.
    pub decimals: usize,
    /// Values at the lightest and the darkest shade, so that maps compare; else the least and the greatest value.
    pub shades: Option<(f64, f64)>,
    /// Shades follow the values' logarithms.
    pub logarithmic: bool,
    /// Numbers have three significant digits, whatever `decimals` says.
    pub significant: bool,
    /// Columns are names, which are shortened where they are crowded; other labels are then left out.
    pub names: bool,
    /// Height of a row, if not the usual one.
    pub row_height: Option<f64>,
}

impl Picture for HeatMap {
    fn height(&self, size: Size) -> f64 {
        self.head(size) + self.cell_height() * self.rows.len() as f64 + 58.0
    }

    fn svg(&self, size: Size) -> String {
        let height = self.height(size);
        let widest = self.rows.iter().map(|r| text_width(r, 12.0)).fold(0.0, f64::max);
        let (left, right) = (30.0 + widest + 8.0, size.width - 10.0);
        let (top, cell_height) = (self.head(size), self.cell_height());
        let baseline = 0.5 * cell_height + 4.5;
        let cell_width = (right - left) / self.columns.len().max(1) as f64;
        let finite = || self.values.iter().copied().filter(|v| v.is_finite());
        let own = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        let (low, high) = self.shades.unwrap_or(own);

        let mut svg = open(size.width, height, &self.title, "");
        let mut y = 6.0;
        for (part, class) in self.lines(size) {
            y += 17.0;
            svg.push_str(&text(8.0, y, "start", class, &part));
        }
        let bottom = top + cell_height * self.rows.len() as f64;
        for (j, row) in self.rows.iter().enumerate() {
            let y = bottom - cell_height * (j + 1) as f64;
            svg.push_str(&text(left - 7.0, y + baseline, "end", "tick", row));
            for i in 0..self.columns.len() {
                let x = left + cell_width * i as f64;
                let value = self.values.get(j * self.columns.len() + i).copied().unwrap_or(f64::NAN);
                if !value.is_finite() {
                    continue;
                }
                let share = self.share(value, (low, high));
                svg.push_str(&format!(
                    "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" style=\"fill:color-mix(in srgb,var(--m1) {}%,var(--m0))\"/>",
                    px(x + 1.0), px(y + 1.0), px(cell_width - 2.0), px(cell_height - 2.0), (75.0 * share).round()
                ));
                let number = self.number(value);
                if text_width(&number, 12.0) <= cell_width {
                    svg.push_str(&text(x + 0.5 * cell_width, y + baseline, "middle", "lab", &number));
                }
            }
        }
        // Crowded column names are left out one after another.
        let widest = self.columns.iter().map(|c| text_width(c, 12.0)).fold(0.0, f64::max) + 6.0;
        let every = if self.names { 1 } else { (widest / cell_width).ceil().max(1.0) as usize };
        let shown = match self.names {
            true => told_apart(&self.columns, cell_width - 2.0),
            false => self.columns.clone(),
        };
        for (i, column) in shown.iter().enumerate().step_by(every) {
            svg.push_str(&text(
                left + cell_width * (i as f64 + 0.5),
                bottom + 17.0,
                "middle",
                "tick",
                column,
            ));
        }
        svg.push_str(&text(0.5 * (left + right), bottom + 37.0, "middle", "lab", &axis_label(&self.x, 0)));
        svg.push_str(&format!(
            "<text transform=\"translate(17 {}) rotate(-90)\" text-anchor=\"middle\" class=\"lab\">{}</text>",
            px(0.5 * (top + bottom)),
            super::escape(&axis_label(&self.y, 0))
        ));
        svg.push_str("</svg>");
        svg
    }
}

/// Names that fit; where cutting their ends makes them alike, as of files that are named by their date, their beginnings are cut
/// instead. What stands before a colon stays.
fn told_apart(names: &[String], width: f64) -> Vec<String> {
    let cut: Vec<String> = names.iter().map(|name| shortened(name, width)).collect();
    let parts = |name: &str| name.find(": ").map_or(0, |at| at + 2);
    // What is left of a name whose end was cut.
    let stems = || cut.iter().map(|label| label[parts(label)..].strip_suffix('…'));
    let alike = |(i, stem): (usize, Option<&str>)| {
        let stem = stem.filter(|s| !s.is_empty());
        stem.is_some_and(|s| names.iter().enumerate().any(|(j, n)| j != i && n[parts(n)..].starts_with(s)))
    };
    if !stems().enumerate().any(alike) {
        return cut;
    }
    let of = |name: &String| {
        let (mark, rest) = name.split_at(parts(name));
        let ends = rest
            .char_indices()
            .map(|(at, _)| if at == 0 { rest.to_owned() } else { format!("…{}", &rest[at..]) });
        let fits = ends.map(|end| format!("{mark}{end}")).find(|label| text_width(label, 12.5) <= width);
        fits.unwrap_or_else(|| shortened(name, width))
    };
    names.iter().map(of).collect()
}

impl HeatMap {
    fn cell_height(&self) -> f64 {
        self.row_height.unwrap_or(30.0)
    }

    /// How dark a value is, 0 to 1.
    fn share(&self, value: f64, (low, high): (f64, f64)) -> f64 {
        let share = if self.logarithmic && low > 0.0 && value > 0.0 {
            (value / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        };
        if high > low { share.clamp(0.0, 1.0) } else { 0.0 }
    }

    fn number(&self, value: f64) -> String {
        let decimals = match value.abs() {
            _ if !self.significant => self.decimals,
            v if v >= 99.95 => 0,
            v if v >= 9.995 => 1,
            _ => 2,
        };
        format!("{value:.decimals$}")
    }

    fn lines(&self, size: Size) -> Vec<(String, &'static str)> {
        let wrapped = |t: &str, px: f64| wrap(t, px, size.width - 16.0);
        let title = wrapped(&self.title, 16.0).into_iter().map(|t| (t, "ttl"));
        title.chain(wrapped(&self.value_label, 13.0).into_iter().map(|t| (t, "lab"))).collect()
    }

    fn head(&self, size: Size) -> f64 {
        14.0 + 17.0 * self.lines(size).len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_begin_alike_show_their_ends() {
        let names = |all: &[&str]| all.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        let dated = names(&["2026-03-01_11h10m05", "h: 2026-03-01_11h11m05"]);
        let shown = told_apart(&dated, 70.0);
        assert!(shown[0].starts_with('…') && shown[0].ends_with("10m05"), "{shown:?}");
        assert!(shown[1].starts_with("h: …") && shown[1].ends_with("m05"), "{shown:?}");
        assert!(shown.iter().all(|label| text_width(label, 12.5) <= 70.0), "{shown:?}");
        // What fits stays, and what its beginning tells apart is cut at its end.
        assert_eq!(told_apart(&names(&["steps", "chirp"]), 70.0), names(&["steps", "chirp"]));
        let words = told_apart(&names(&["a_very_long_name_of_a_run", "b_very_long_name_of_a_run"]), 70.0);
        assert!(words.iter().all(|label| label.ends_with('…')), "{words:?}");
    }
}
