//! A chart: two axes and what is drawn between them.

use super::{Axis, Dash, Hue};

/// A chart of numbers against numbers.
///
/// Points whose value is not a number, or not positive on a logarithmic axis, are left out and leave a gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chart {
    /// What is shown, in a few words.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Bands, behind everything else.
    pub bands: Vec<Band>,
    /// Contour lines.
    pub contours: Vec<Contours>,
    /// Bars of a histogram: edges, one more than heights; label; hue.
    pub histogram: Option<(Vec<f64>, Vec<f64>, String, Hue)>,
    /// Lines and scattered points.
    pub lines: Vec<Line>,
    /// Vertical reference lines: position and label.
    pub verticals: Vec<(f64, String)>,
    /// Horizontal reference lines: position and label.
    pub horizontals: Vec<(f64, String)>,
    /// Marked points.
    pub notes: Vec<Note>,
    /// Whether a reader can zoom along x; charts with the same text here zoom together.
    pub zoom: Option<String>,
    /// Height for wide windows, if not the usual one.
    pub height: Option<f64>,
}

/// A line, or scattered points if it has no line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Line {
    /// Its name in the legend; empty to leave it out.
    pub label: String,
    /// The points in drawing order: a loop is a line that comes back.
    pub points: Vec<(f64, f64)>,
    /// Colour.
    pub hue: Hue,
    /// How the line is broken; `None` draws no line.
    pub dash: Option<Dash>,
    /// The mark at the points, if any; on long lines only at some of them.
    pub marker: Option<Marker>,
}

/// The shape of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// Circle.
    Circle,
    /// Square.
    Square,
    /// Triangle.
    Triangle,
    /// Diamond.
    Diamond,
    /// A small filled dot, for many points.
    Dot,
}

/// An area between two curves: a confidence band.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// Its name in the legend; empty to leave it out.
    pub label: String,
    /// Position, lower and upper bound.
    pub points: Vec<(f64, f64, f64)>,
    /// Colour.
    pub hue: Hue,
}

/// Lines of equal value over a grid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contours {
    /// Horizontal grid positions, ascending.
    pub x: Vec<f64>,
    /// Vertical grid positions, ascending.
    pub y: Vec<f64>,
    /// Values, row after row: the value at `x[i]`, `y[j]` is at `j * x.len() + i`.
    pub values: Vec<f64>,
    /// The values whose lines are drawn, each with its label.
    pub levels: Vec<(f64, String)>,
    /// Colour.
    pub hue: Hue,
    /// How the lines are broken.
    pub dash: Dash,
    /// Name in the legend; empty to leave it out.
    pub label: String,
}

/// A marked point with a few words.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// Where.
    pub at: (f64, f64),
    /// What.
    pub text: String,
    /// Its mark.
    pub marker: Marker,
    /// Its colour.
    pub hue: Hue,
}

impl Chart {
    /// An empty chart.
    #[must_use]
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        Self { title: title.into(), x, y, ..Self::default() }
    }

    /// Adds a line.
    #[must_use]
    pub fn line(mut self, label: &str, hue: Hue, dash: Dash, points: Vec<(f64, f64)>) -> Self {
        self.lines.push(Line { label: label.into(), points, hue, dash: Some(dash), marker: None });
        self
    }

    /// Adds scattered points without a line.
    #[must_use]
    pub fn scatter(mut self, label: &str, hue: Hue, marker: Marker, points: Vec<(f64, f64)>) -> Self {
        self.lines.push(Line { label: label.into(), points, hue, dash: None, marker: Some(marker) });
        self
    }

    /// Adds a line with marks at its points.
    #[must_use]
    pub fn marked(
        mut self,
        label: &str,
        hue: Hue,
        dash: Dash,
        marker: Marker,
        points: Vec<(f64, f64)>,
    ) -> Self {
        self.lines.push(Line { label: label.into(), points, hue, dash: Some(dash), marker: Some(marker) });
        self
    }

    /// Adds a band of `(x, low, high)`.
    #[must_use]
    pub fn band(mut self, label: &str, hue: Hue, points: Vec<(f64, f64, f64)>) -> Self {
        self.bands.push(Band { label: label.into(), points, hue });
        self
    }

    /// Adds contour lines.
    #[must_use]
    pub fn contours(mut self, contours: Contours) -> Self {
        self.contours.push(contours);
        self
    }

    /// Shows a histogram with `edges.len() - 1` bars.
    #[must_use]
    pub fn histogram(mut self, label: &str, hue: Hue, edges: Vec<f64>, heights: Vec<f64>) -> Self {
        self.histogram = Some((edges, heights, label.into(), hue));
        self
    }

    /// Adds a vertical reference line.
    #[must_use]
    pub fn vertical(mut self, at: f64, label: &str) -> Self {
        self.verticals.push((at, label.into()));
        self
    }

    /// Adds a horizontal reference line.
    #[must_use]
    pub fn horizontal(mut self, at: f64, label: &str) -> Self {
        self.horizontals.push((at, label.into()));
        self
    }

    /// Marks a point.
    #[must_use]
    pub fn note(mut self, at: (f64, f64), text: &str, marker: Marker, hue: Hue) -> Self {
        self.notes.push(Note { at, text: text.into(), marker, hue });
        self
    }

    /// Lets the reader zoom along x, together with all charts of the same group.
    #[must_use]
    pub fn zoomable(mut self, group: &str) -> Self {
        self.zoom = Some(group.into());
        self
    }

    /// Sets the height for wide windows.
    #[must_use]
    pub fn tall(mut self, height: f64) -> Self {
        self.height = Some(height);
        self
    }

    /// The ranges of both axes.
    pub(super) fn ranges(&self) -> ((f64, f64), (f64, f64)) {
        let (mut x, mut y) = (Extent::default(), Extent::default());
        let mut include = |a: f64, b: f64| {
            if self.x.admits(a) && self.y.admits(b) {
                x.include(a);
                y.include(b);
            }
        };
        for (a, b) in self.lines.iter().flat_map(|l| &l.points) {
            include(*a, *b);
        }
        for (a, low, high) in self.bands.iter().flat_map(|b| &b.points) {
            include(*a, *low);
            include(*a, *high);
        }
        for c in &self.contours {
            for (a, b) in [(c.x.first(), c.y.first()), (c.x.last(), c.y.last())] {
                if let (Some(a), Some(b)) = (a, b) {
                    include(*a, *b);
                }
            }
        }
        if let Some((edges, heights, ..)) = &self.histogram {
            for (edge, height) in edges.iter().zip(heights.iter().chain(heights.last())) {
                include(*edge, *height);
                include(*edge, 0.0);
            }
        }
        for note in &self.notes {
            include(note.at.0, note.at.1);
        }
        for (at, _) in self.horizontals.iter().filter(|(at, _)| self.y.admits(*at)) {
            y.include(*at);
        }
        for (at, _) in self.verticals.iter().filter(|(at, _)| self.x.admits(*at)) {
            x.include(*at);
        }
        // Contours fill their frame; everything else keeps clear of it.
        let margin = if self.contours.is_empty() { 0.05 } else { 0.0 };
        let margin_x = if self.lines.iter().any(|l| l.marker.is_some()) && self.contours.is_empty() {
            0.03
        } else {
            0.0
        };
        let y_range = self.y.fit(y.low, y.high, margin);
        // Bars stand on zero.
        let on_zero = self.histogram.is_some() && self.y.range.is_none() && y.low >= 0.0;
        (self.x.fit(x.low, x.high, margin_x), if on_zero { (0.0, y_range.1) } else { y_range })
    }
}

struct Extent {
    low: f64,
    high: f64,
}

impl Default for Extent {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
}

impl Extent {
    fn include(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }
}
