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
pub use decimate::{decimate, straightened};
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
    /// One of two side by side.
    pub const HALF: Self = Self { width: 640.0, height: 350.0, points: 1200 };
    /// One of many in a grid.
    pub const SMALL: Self = Self { width: 430.0, height: 215.0, points: 600 };
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
    figure_at(picture, Size::WIDE)
}

/// The same with another size for a wide window.
#[must_use]
pub fn figure_at(picture: &dyn Picture, wide: Size) -> String {
    let draw = |size: Size| picture.svg(size.with_height(picture.height(size)));
    let narrow = Size { points: wide.points.min(Size::NARROW.points), ..Size::NARROW };
    format!("<div class=\"wide\">{}</div><div class=\"narrow\">{}</div>", draw(wide), draw(narrow))
}

/// A piece of a line as it stands in a legend outside a picture.
#[must_use]
pub fn key(hue: Hue, dash: Dash) -> String {
    format!(
        "<svg viewBox=\"0 0 34 12\" aria-hidden=\"true\"><path d=\"M1 6H33\" class=\"ln {}\"{}/></svg>",
        hue.class(),
        dash.attribute()
    )
}
