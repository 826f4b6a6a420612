//! Units of channels and parameters, read from the suffix of their names.

use std::fmt;

/// An SI unit as a channel's suffix names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unit {
    /// `_s`, seconds.
    Second,
    /// `_a`, ampere.
    Ampere,
    /// `_n`, newton.
    Newton,
    /// `_nm`, newton metre.
    NewtonMetre,
    /// `_rad`, radian.
    Radian,
    /// `_m`, metre.
    Metre,
    /// `_m_s`, metre per second.
    MetrePerSecond,
    /// `_rad_s`, radian per second.
    RadianPerSecond,
    /// `_v`, volt.
    Volt,
    /// `_c`, degree Celsius.
    Celsius,
    /// `_w`, watt.
    Watt,
}

/// The suffix of a channel is not one of the known units.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownUnit {
    /// The channel's name.
    pub channel: String,
}

impl fmt::Display for UnknownUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let channel = &self.channel;
        write!(
            f,
            "'{channel}' does not end in a known unit (_s, _a, _n, _nm, _rad, _m, _m_s, _rad_s, _v, _c, _w)"
        )
    }
}

impl std::error::Error for UnknownUnit {}

impl Unit {
    /// Longer suffixes first, so that `_rad_s` is not taken for `_s`.
    const SUFFIXES: [(&'static str, Self); 11] = [
        ("_rad_s", Self::RadianPerSecond),
        ("_m_s", Self::MetrePerSecond),
        ("_nm", Self::NewtonMetre),
        ("_rad", Self::Radian),
        ("_s", Self::Second),
        ("_a", Self::Ampere),
        ("_n", Self::Newton),
        ("_m", Self::Metre),
        ("_v", Self::Volt),
        ("_c", Self::Celsius),
        ("_w", Self::Watt),
    ];

    /// The unit that a channel's name ends in.
    ///
    /// # Errors
    ///
    /// [`UnknownUnit`] if it ends in none of the known suffixes.
    pub fn of_channel(channel: &str) -> Result<Self, UnknownUnit> {
        Self::SUFFIXES
            .iter()
            .find(|(suffix, _)| channel.len() > suffix.len() && channel.ends_with(suffix))
            .map(|&(_, unit)| unit)
            .ok_or_else(|| UnknownUnit { channel: channel.to_owned() })
    }

    /// The symbol of the unit that a channel's name ends in; empty where it ends in none.
    #[must_use]
    pub fn symbol_of(channel: &str) -> &'static str {
        Self::of_channel(channel).map_or("", Self::symbol)
    }

    /// The symbol as printed on an axis.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Ampere => "A",
            Self::Newton => "N",
            Self::NewtonMetre => "N m",
            Self::Radian => "rad",
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::RadianPerSecond => "rad/s",
            Self::Volt => "V",
            Self::Celsius => "deg C",
            Self::Watt => "W",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffixes_are_told_apart() {
        assert_eq!(Unit::of_channel("motor_speed_rad_s"), Ok(Unit::RadianPerSecond));
        assert_eq!(Unit::of_channel("time_s"), Ok(Unit::Second));
        assert_eq!(Unit::of_channel("output_torque_nm"), Ok(Unit::NewtonMetre));
        assert_eq!(Unit::of_channel("force_1_n"), Ok(Unit::Newton));
        assert_eq!(Unit::of_channel("knee.angle_rad"), Ok(Unit::Radian));
        assert_eq!(Unit::of_channel("supply_v"), Ok(Unit::Volt));
        assert_eq!(Unit::of_channel("temperature_c"), Ok(Unit::Celsius));
        assert!(Unit::of_channel("force_lbf").is_err());
        assert!(Unit::of_channel("_n").is_err());
    }
}
