//! Units that files use, and what one of them is in SI.

use sealegs_model::Unit;

/// A unit of files: its name, how many SI units it is, what is then added, and the SI unit.
type Entry = (&'static str, f64, f64, Unit);

const TURN: f64 = std::f64::consts::TAU;

/// Every unit but those of SI itself.
const UNITS: [Entry; 37] = [
    ("deg", TURN / 360.0, 0.0, Unit::Radian),
    ("turn", TURN, 0.0, Unit::Radian),
    ("rev", TURN, 0.0, Unit::Radian),
    ("mrad", 1e-3, 0.0, Unit::Radian),
    ("deg/s", TURN / 360.0, 0.0, Unit::RadianPerSecond),
    ("rpm", TURN / 60.0, 0.0, Unit::RadianPerSecond),
    ("rev/s", TURN, 0.0, Unit::RadianPerSecond),
    ("turn/s", TURN, 0.0, Unit::RadianPerSecond),
    ("mrad/s", 1e-3, 0.0, Unit::RadianPerSecond),
    ("mm", 1e-3, 0.0, Unit::Metre),
    ("cm", 1e-2, 0.0, Unit::Metre),
    ("um", 1e-6, 0.0, Unit::Metre),
    ("in", 0.0254, 0.0, Unit::Metre),
    ("mm/s", 1e-3, 0.0, Unit::MetrePerSecond),
    ("cm/s", 1e-2, 0.0, Unit::MetrePerSecond),
    ("kN", 1e3, 0.0, Unit::Newton),
    ("mN", 1e-3, 0.0, Unit::Newton),
    // The international pound and the standard acceleration of gravity are exact by definition.
    ("lbf", 4.448_221_615_260_5, 0.0, Unit::Newton),
    ("kgf", 9.806_65, 0.0, Unit::Newton),
    ("Nmm", 1e-3, 0.0, Unit::NewtonMetre),
    ("mNm", 1e-3, 0.0, Unit::NewtonMetre),
    ("Ncm", 1e-2, 0.0, Unit::NewtonMetre),
    ("kNm", 1e3, 0.0, Unit::NewtonMetre),
    ("mA", 1e-3, 0.0, Unit::Ampere),
    ("mV", 1e-3, 0.0, Unit::Volt),
    ("kV", 1e3, 0.0, Unit::Volt),
    ("mW", 1e-3, 0.0, Unit::Watt),
    ("kW", 1e3, 0.0, Unit::Watt),
    ("K", 1.0, -273.15, Unit::Celsius),
    ("degF", 5.0 / 9.0, -160.0 / 9.0, Unit::Celsius),
    ("ms", 1e-3, 0.0, Unit::Second),
    ("us", 1e-6, 0.0, Unit::Second),
    ("ns", 1e-9, 0.0, Unit::Second),
    ("min", 60.0, 0.0, Unit::Second),
    ("Nm", 1.0, 0.0, Unit::NewtonMetre),
    ("degC", 1.0, 0.0, Unit::Celsius),
    ("C", 1.0, 0.0, Unit::Celsius),
];

/// What one of the named unit is in the SI unit of a channel: a factor, and what is then added.
///
/// `Err` names the units that there are for the channel.
pub(crate) fn of(name: &str, channel: Unit) -> Result<(f64, f64), String> {
    if name == channel.symbol() {
        return Ok((1.0, 0.0));
    }
    let known = UNITS.iter().find(|(n, ..)| *n == name);
    match known {
        Some(&(_, factor, add, unit)) if unit == channel => Ok((factor, add)),
        _ => {
            let fitting: Vec<&str> = std::iter::once(channel.symbol())
                .chain(UNITS.iter().filter(|u| u.3 == channel).map(|u| u.0))
                .collect();
            let problem = if known.is_some() { "is a unit of something else" } else { "is no known unit" };
            Err(format!("'{name}' {problem}; for {} there are {}", channel.symbol(), fitting.join(", ")))
        }
    }
}

/// The whole turn of an angle in this unit.
pub(crate) fn turn(name: &str) -> f64 {
    let angle = UNITS.iter().find(|(n, _, _, unit)| *n == name && *unit == Unit::Radian);
    angle.map_or(TURN, |(_, factor, ..)| TURN / factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_has_one_name_and_another_factor_than_its_si_unit() {
        for (i, (name, ..)) in UNITS.iter().enumerate() {
            assert!(UNITS[..i].iter().all(|(n, ..)| n != name), "{name}");
        }
        assert_eq!(of("degF", Unit::Celsius).map(|(f, add)| (212.0 * f + add).round()), Ok(100.0));
        assert!((60.0 * of("rpm", Unit::RadianPerSecond).unwrap().0 / TURN - 1.0).abs() < 1e-15);
        assert!(of("rpm", Unit::Metre).unwrap_err().contains("something else"));
        assert!((turn("deg") - 360.0).abs() < 1e-12);
        assert_eq!(turn("turn"), 1.0);
    }
}
