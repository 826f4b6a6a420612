//! Small pictures in SVG for a self-contained page: lines, bands, contours, scatter, bars and maps.
//!
//! A picture is a value that draws itself at a given [`Size`]; [`figure_html`] draws it twice, for a wide
//! window and for a phone, and the page's style shows the one that fits. Colours are CSS variables (the
//! Okabe-Ito palette) that follow light, dark and print; series differ in dash and marker too, so that no
//! meaning hangs on colour alone.

mod axis;
mod bars;
mod contour;
mod decimate;
mod draw;
mod heat;
mod plot;
mod style;
mod svg;

pub use axis::{Axis, AxisScale, Ticks};
pub use bars::{Bar, BarChart};
pub use decimate::decimate;
pub use heat::HeatMap;
pub use plot::{Band, Chart, Contours, Line, Marker, Note};
pub use style::{Dash, Hue, SCRIPT, STYLE};
pub use svg::escape;

/// The size of a picture in its own units, which are CSS pixels at natural size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Size {
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
    /// Greatest number of points kept of a series.
    pub points: usize,
}

impl Size {
    /// For a wide window and print.
    pub const WIDE: Self = Self { width: 760.0, height: 340.0, points: 2000 };
    /// For a phone.
    pub const NARROW: Self = Self { width: 370.0, height: 300.0, points: 700 };

    /// The same with another height.
    #[must_use]
    pub fn with_height(self, height: f64) -> Self {
        Self { height, ..self }
    }
}

/// Anything that draws itself.
pub trait Picture {
    /// The picture as one `<svg>` element.
    fn svg(&self, size: Size) -> String;

    /// The height that suits it at this size's width.
    fn height(&self, size: Size) -> f64 {
        size.height
    }
}

/// A picture for a wide window and for a phone; the page's style shows one of them.
#[must_use]
pub fn figure_html(picture: &dyn Picture) -> String {
    let draw = |size: Size| picture.svg(size.with_height(picture.height(size)));
    format!(
        "<div class=\"wide\">{}</div><div class=\"narrow\">{}</div>",
        draw(Size::WIDE),
        draw(Size::NARROW)
    )
}
