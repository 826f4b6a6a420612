//! Colours, dashes and the page's style and script for pictures.

/// A colour by its role on the page; its value follows light and dark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hue {
    /// The text's colour: what was measured.
    #[default]
    Ink,
    /// Blue: the model after, or the first series.
    Blue,
    /// Vermillion: the model before, or the second series.
    Vermillion,
    /// Bluish green.
    Green,
    /// Orange.
    Orange,
    /// Reddish purple.
    Purple,
    /// Sky blue.
    SkyBlue,
    /// Grey: reference, background.
    Grey,
}

impl Hue {
    /// The hues in the order in which series take them.
    pub const SERIES: [Self; 7] =
        [Self::Blue, Self::Vermillion, Self::Green, Self::Orange, Self::Purple, Self::SkyBlue, Self::Ink];

    /// The class that gives an element this colour.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Ink => "h0",
            Self::Blue => "h1",
            Self::Vermillion => "h2",
            Self::Green => "h3",
            Self::Orange => "h4",
            Self::Purple => "h5",
            Self::SkyBlue => "h6",
            Self::Grey => "h7",
        }
    }
}

/// How a line is broken, so that lines differ without colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Unbroken.
    #[default]
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dash and dot.
    DashDot,
}

impl Dash {
    pub(super) fn attribute(self) -> &'static str {
        match self {
            Self::Solid => "",
            Self::Dashed => " stroke-dasharray=\"7 4\"",
            Self::Dotted => " stroke-dasharray=\"1.5 4\"",
            Self::DashDot => " stroke-dasharray=\"9 4 1.5 4\"",
        }
    }
}

/// The style sheet of pictures: light, dark and print.
pub const STYLE: &str = include_str!("chart.css");

/// The script that lets time series be zoomed; pictures are complete without it.
pub const SCRIPT: &str = include_str!("zoom.js");
