//! Colours that people with any colour vision can tell apart.

/// An opaque colour, sRGB.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color {
    /// Red, 0 to 255.
    pub red: u8,
    /// Green, 0 to 255.
    pub green: u8,
    /// Blue, 0 to 255.
    pub blue: u8,
}

impl Color {
    /// Okabe-Ito orange.
    pub const ORANGE: Self = Self::new(0xE6, 0x9F, 0x00);
    /// Okabe-Ito sky blue.
    pub const SKY_BLUE: Self = Self::new(0x56, 0xB4, 0xE9);
    /// Okabe-Ito bluish green.
    pub const GREEN: Self = Self::new(0x00, 0x9E, 0x73);
    /// Okabe-Ito yellow.
    pub const YELLOW: Self = Self::new(0xF0, 0xE4, 0x42);
    /// Okabe-Ito blue.
    pub const BLUE: Self = Self::new(0x00, 0x72, 0xB2);
    /// Okabe-Ito vermillion.
    pub const VERMILLION: Self = Self::new(0xD5, 0x5E, 0x00);
    /// Okabe-Ito reddish purple.
    pub const PURPLE: Self = Self::new(0xCC, 0x79, 0xA7);
    /// A neutral grey for structure that carries no meaning of its own.
    pub const GREY: Self = Self::new(0x8A, 0x8F, 0x98);
    /// A light grey for links.
    pub const LIGHT_GREY: Self = Self::new(0xC4, 0xC8, 0xCE);

    /// A colour from its sRGB components.
    #[must_use]
    pub const fn new(red: u8, green: u8, blue: u8) -> Self {
        Self { red, green, blue }
    }

    /// The mixture of two colours: `self` at 0, `other` at 1, straight in sRGB; `t` is clamped.
    #[must_use]
    pub fn mix(self, other: Self, t: f64) -> Self {
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        let channel = |a: u8, b: u8| (f64::from(a) + t * (f64::from(b) - f64::from(a))).round() as u8;
        Self::new(
            channel(self.red, other.red),
            channel(self.green, other.green),
            channel(self.blue, other.blue),
        )
    }
}

/// The scale of [`force_color`]: full tension, none, full compression.
///
/// Blue to vermillion through light grey: the two ends differ for every kind of colour vision, and in
/// lightness from the middle, so that the amount can be read in grey print too.
pub const FORCE_SCALE: [Color; 3] =
    [Color::new(0x00, 0x4E, 0x9E), Color::new(0xD9, 0xD9, 0xD9), Color::new(0xC8, 0x3C, 0x00)];

/// The colour of a rod under `force_n` (compression positive) whose rated force is `full_scale_n`.
///
/// Beyond the rated force the colour saturates; a force that is not a number is drawn as none.
#[must_use]
pub fn force_color(force_n: f64, full_scale_n: f64) -> Color {
    let share = if full_scale_n > 0.0 && !force_n.is_nan() { force_n / full_scale_n } else { 0.0 };
    let end = if share < 0.0 { FORCE_SCALE[0] } else { FORCE_SCALE[2] };
    FORCE_SCALE[1].mix(end, share.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_reached_and_saturates() {
        assert_eq!(force_color(0.0, 2225.0), FORCE_SCALE[1]);
        assert_eq!(force_color(2225.0, 2225.0), FORCE_SCALE[2]);
        assert_eq!(force_color(9000.0, 2225.0), FORCE_SCALE[2]);
        assert_eq!(force_color(-2225.0, 2225.0), FORCE_SCALE[0]);
        assert_eq!(force_color(f64::NAN, 2225.0), FORCE_SCALE[1]);
        assert_eq!(force_color(1.0, 0.0), FORCE_SCALE[1]);
    }
}
