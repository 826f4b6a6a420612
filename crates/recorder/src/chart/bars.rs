//! Horizontal bars with names and numbers: ranking of effects, shares of an error against shares of samples.
//!
//! Bars are proportional to their values. On a logarithmic axis, which the axis says, they begin at its lower end.

use super::svg::{line, open, px, text, text_width, wrap};
use super::{Axis, AxisScale, Hue, Picture, Size, Ticks};

/// One row.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// What it is.
    pub label: String,
    /// Values, one for each of the chart's series; drawn one below the other. NaN draws none.
    pub values: Vec<f64>,
    /// What is written at the end of the first bar, for example `12 %`.
    pub text: String,
}

/// A chart of horizontal bars, all starting at zero; at the lower end of a logarithmic axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BarChart {
    /// What is shown.
    pub title: String,
    /// The axis of the values.
    pub axis: Axis,
    /// Names of the series and their colours: one or two.
    pub series: Vec<(String, Hue)>,
    /// The rows from top to bottom.
    pub bars: Vec<Bar>,
    /// Reference lines: value and label.
    pub marks: Vec<(f64, String)>,
    /// Height of a row, if not the usual one.
    pub row_height: Option<f64>,
}

impl BarChart {
    fn thickness(&self) -> f64 {
        match self.row_height {
            Some(row) => ((row - 9.0) / self.series.len().max(1) as f64).max(4.0),
            None if self.series.len() > 1 => 9.0,
            None => 14.0,
        }
    }

    /// The range of the axis: from zero, or from the least value where it is logarithmic.
    fn range(&self) -> (f64, f64) {
        let values = self.bars.iter().flat_map(|b| &b.values).chain(self.marks.iter().map(|(v, _)| v));
        let shown = values.copied().filter(|v| self.axis.admits(*v));
        match self.axis.scale {
            AxisScale::Linear => {
                let (low, high) = shown.fold((0.0, 0.0), |(l, h): (f64, f64), v| (l.min(v), h.max(v)));
                self.axis.fit(low, high, 0.0)
            }
            AxisScale::Logarithmic => {
                let ends = (f64::INFINITY, f64::NEG_INFINITY);
                let (low, high) = shown.fold(ends, |(l, h): (f64, f64), v| (l.min(v), h.max(v)));
                self.axis.fit(low, high, 0.02)
            }
        }
    }

    fn row(&self) -> f64 {
        self.thickness() * self.series.len().max(1) as f64 + 9.0
    }

    /// On a phone the name stands above its bars.
    fn label_above(size: Size) -> bool {
        size.width < 500.0
    }

    fn head(&self, width: f64) -> f64 {
        let titles = wrap(&self.title, 16.0, width - 16.0).len() as f64;
        let marks = if self.marks.is_empty() { 0.0 } else { 16.0 };
        17.0 * titles
            + 12.0
            + marks
            + if self.series.len() > 1 { 19.0 * self.legend_rows(width) } else { 0.0 }
    }

    fn legend_rows(&self, width: f64) -> f64 {
        let total: f64 = self.series.iter().map(|(label, _)| 36.0 + text_width(label, 13.0)).sum();
        if total > width - 16.0 { self.series.len() as f64 } else { 1.0 }
    }
}

impl Picture for BarChart {
    fn height(&self, size: Size) -> f64 {
        let extra = if Self::label_above(size) { 16.0 } else { 0.0 };
        self.head(size.width) + (self.row() + extra) * self.bars.len() as f64 + 48.0
    }

    fn svg(&self, size: Size) -> String {
        let above = Self::label_above(size);
        let widest = self.bars.iter().map(|b| text_width(&b.label, 13.0)).fold(0.0, f64::max);
        let left = if above { 10.0 } else { (widest + 16.0).min(0.42 * size.width) };
        let ends = self.bars.iter().map(|b| text_width(&b.text, 12.0)).fold(0.0, f64::max);
        let right = size.width - ends - 16.0;
        let range = self.range();
        let ticks = Ticks::new(self.axis.scale, range, ((right - left) / 85.0).max(2.0) as usize);
        let logarithmic = self.axis.scale == AxisScale::Logarithmic;
        let share = |v: f64| {
            if logarithmic {
                (v / range.0).ln() / (range.1 / range.0).ln()
            } else {
                (v - range.0) / (range.1 - range.0)
            }
        };
        let at = |v: f64| left + (right - left) * share(v).clamp(0.0, 1.0);
        let ground = if logarithmic { range.0 } else { 0.0 };
        let height = self.height(size);
        let (top, bottom) = (self.head(size.width), height - 44.0);

        let mut svg = open(size.width, height, &self.title, "");
        let mut y = 6.0;
        for part in wrap(&self.title, 16.0, size.width - 16.0) {
            y += 17.0;
            svg.push_str(&text(8.0, y, "start", "ttl", &part));
        }
        if self.series.len() > 1 {
            let (mut x, stacked) = (8.0, self.legend_rows(size.width) > 1.0);
            y += 19.0;
            for (label, hue) in &self.series {
                svg.push_str(&rect(x, y - 9.0, 14.0, 10.0, *hue));
                svg.push_str(&text(x + 20.0, y, "start", "leg", label));
                if stacked {
                    y += 19.0;
                } else {
                    x += 36.0 + text_width(label, 13.0);
                }
            }
        }
        for (v, label) in &ticks.major {
            svg.push_str(&line((at(*v), top), (at(*v), bottom), "gr"));
            svg.push_str(&text(at(*v), bottom + 16.0, "middle", "tick", label));
        }
        let mut y = top + 4.0;
        // Names above their bars lie where reference lines run: they are drawn last.
        let mut names = String::new();
        for bar in &self.bars {
            if above {
                names.push_str(&text(
                    left + 3.0,
                    y + 11.0,
                    "start",
                    "halo",
                    &shortened(&bar.label, size.width - 14.0),
                ));
                y += 16.0;
            } else {
                let middle = y + 0.5 * (self.row() - 9.0) + 4.5;
                svg.push_str(&text(left - 8.0, middle, "end", "lab", &shortened(&bar.label, left - 12.0)));
            }
            for (i, (value, (_, hue))) in bar.values.iter().zip(&self.series).enumerate() {
                if self.axis.admits(*value) {
                    let (a, b) = (at(ground).min(at(*value)), at(ground).max(at(*value)));
                    svg.push_str(&rect(a, y, (b - a).max(0.8), self.thickness() - 1.0, *hue));
                    if i == 0 {
                        svg.push_str(&text(
                            b + 6.0,
                            y + 0.5 * self.thickness() + 4.0,
                            "start",
                            "halo",
                            &bar.text,
                        ));
                    }
                }
                y += self.thickness();
            }
            y += 9.0;
        }
        svg.push_str(&line((at(ground), top), (at(ground), bottom), "fr"));
        for (v, label) in self.marks.iter().filter(|(v, _)| self.axis.admits(*v)) {
            svg.push_str(&line((at(*v), top - 4.0), (at(*v), bottom), "rf h0"));
            let half = 0.5 * text_width(label, 12.0);
            let middle = at(*v).clamp(half + 4.0, (size.width - half - 4.0).max(half + 4.0));
            svg.push_str(&text(middle, top - 8.0, "middle", "halo", label));
        }
        svg.push_str(&names);
        let label = super::axis::axis_label(&self.axis, ticks.exponent);
        svg.push_str(&text(0.5 * (left + right), bottom + 36.0, "middle", "lab", &label));
        svg.push_str("</svg>");
        svg
    }
}

/// A text that fits, with an ellipsis where it had to be cut.
pub(super) fn shortened(label: &str, width: f64) -> String {
    let mut out = label.to_owned();
    while text_width(&out, 12.5) > width && out.chars().count() > 2 {
        out = out.chars().take(out.chars().count() - 2).collect::<String>() + "…";
    }
    out
}

fn rect(x: f64, y: f64, width: f64, height: f64, hue: Hue) -> String {
    format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" class=\"br {}\"/>",
        px(x),
        px(y),
        px(width),
        px(height),
        hue.class()
    )
}
