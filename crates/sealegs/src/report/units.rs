//! Values with their intervals in units that a person uses, with as many digits as the interval allows.

use sealegs_model::Unit;

/// Standard errors in half a 95 % interval of a normal distribution.
pub(crate) const HALF_95: f64 = 1.96;

/// Multiples of an SI unit that are in use, the largest first, and the least size at which each is used, in itself.
fn multiples(unit: &str) -> &'static [(f64, &'static str, f64)] {
    match unit {
        "m" => &[(1.0, "m", 1.0), (1e-3, "mm", 1.0), (1e-6, "µm", 0.0)],
        "s" => &[(1.0, "s", 1.0), (1e-3, "ms", 1.0), (1e-6, "µs", 0.0)],
        "m/s" => &[(1.0, "m/s", 1.0), (1e-3, "mm/s", 0.0)],
        "N" => &[(1e3, "kN", 10.0), (1.0, "N", 0.0)],
        "N/m" => &[(1e6, "MN/m", 1.0), (1e3, "kN/m", 1.0), (1.0, "N/m", 0.0)],
        "N s/m" => &[(1e3, "kN s/m", 1.0), (1.0, "N s/m", 0.0)],
        "kg" => &[(1.0, "kg", 1.0), (1e-3, "g", 0.0)],
        "rad" => &[(1.0, "rad", 1.0), (1e-3, "mrad", 0.0)],
        "A" => &[(1.0, "A", 1.0), (1e-3, "mA", 0.0)],
        "N m" => &[(1.0, "N m", 0.1), (1e-3, "mN m", 0.0)],
        "Hz" => &[(1e3, "kHz", 1.0), (1.0, "Hz", 0.0)],
        _ => &[],
    }
}

/// The multiple of a unit in which a value of this size is said: SI units in one of it, and its symbol.
pub(crate) fn multiple(size: f64, unit: &str) -> (f64, &str) {
    let of = multiples(unit);
    let fits = of.iter().find(|(scale, _, least)| size.abs() >= scale * least * (1.0 - 1e-9));
    match fits.filter(|_| size != 0.0) {
        Some((scale, symbol, _)) => (*scale, symbol),
        None => (1.0, unit),
    }
}

/// A value with half its 95 % interval, from its standard error: `80.0 ± 0.4 µm`. The interval has two digits where its
/// first is a one or a two, and one otherwise. Without a standard error three digits of the value are said.
pub(crate) fn with_interval(value: f64, std: Option<f64>, unit: &str) -> String {
    let (scale, symbol) = multiple(value, unit);
    let half = std.map(|s| HALF_95 * s / scale).filter(|h| *h > 0.0 && h.is_finite());
    let text = match half {
        Some(half) => {
            let (half, decimals) = rounded(half);
            format!("{} ± {}", fixed(value / scale, decimals), fixed(half, decimals))
        }
        None => crate::diagnosis::text::figures(value / scale, 3),
    };
    format!("{text} {symbol}").trim_end().replace('-', "−")
}

/// An interval's half in its one or two digits, and the power of ten of the last one (negative: decimals).
fn rounded(half: f64) -> (f64, i32) {
    let power = half.log10().floor() as i32;
    let last = if half / 10_f64.powi(power) < 2.95 { power - 1 } else { power };
    let unit = 10_f64.powi(last);
    ((half / unit).round() * unit, last)
}

/// A number rounded to a power of ten; in powers of ten where it is very large or small.
fn fixed(value: f64, last: i32) -> String {
    let unit = 10_f64.powi(last);
    let value = (value / unit).round() * unit;
    if value != 0.0 && !(1e-4..1e7).contains(&value.abs()) {
        let digits = (value.abs().log10().floor() as i32 - last).max(0) as usize;
        return format!("{value:.digits$e}");
    }
    format!("{value:.*}", (-last).max(0) as usize)
}

/// What a parameter is called without its effect, its place and its unit: `force` of `knee/coulomb-friction.force_n`.
pub(crate) fn symbol(parameter: &str) -> String {
    let name = parameter.rsplit_once('.').map_or(parameter, |(_, name)| name);
    // Whole before their own ends: `stiffness_n_m` is a stiffness, not a `stiffness n`.
    let known = [
        "_nm_s2_rad2",
        "_nm_s_rad",
        "_nm_rad3",
        "_kg_m2",
        "_n_s2_m2",
        "_n_s_m",
        "_n_per_m",
        "_nm_rad",
        "_nm_s",
        "_n_m3",
        "_n_m",
        "_rad_s",
        "_m_s",
        "_s_m",
        "_per_k",
        "_nm",
        "_kg",
        "_hz",
        "_ohm",
        "_rad",
        "_n",
        "_m",
        "_s",
        "_a",
        "_v",
        "_j",
    ];
    let suffix = known.iter().find(|s| name.len() > s.len() && name.ends_with(**s));
    let unit = suffix.filter(|_| Unit::of_channel(name).is_ok() || !name.ends_with("_a"));
    unit.map_or(name, |s| &name[..name.len() - s.len()]).replace('_', " ")
}

/// An error in noise units with three digits.
pub(crate) fn error(value: f64) -> String {
    match value {
        v if v >= 99.95 => format!("{v:.0}"),
        v if v >= 9.995 => format!("{v:.1}"),
        v => format!("{v:.2}"),
    }
}

/// A text with a capital letter first.
pub(crate) fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().collect::<String>() + chars.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_said_as_a_person_would_and_with_the_digits_of_their_interval() {
        assert_eq!(with_interval(79.96e-6, Some(0.2e-6), "m"), "80.0 ± 0.4 µm");
        assert_eq!(with_interval(427_101.0, Some(286.0), "N/m"), "427.1 ± 0.6 kN/m");
        assert_eq!(with_interval(44.774_66, Some(0.0761), "N"), "44.77 ± 0.15 N");
        assert_eq!(with_interval(-0.012_345, Some(0.0021), "m"), "−12 ± 4 mm");
        assert_eq!(with_interval(0.3, Some(0.01), ""), "0.300 ± 0.020");
        assert_eq!(with_interval(1234.0, Some(100.0), "N"), "1230 ± 200 N");
        assert_eq!(with_interval(0.05, None, "s"), "50.0 ms");
        assert_eq!(with_interval(2.0e-7, Some(1e-8), "1/N^2"), "2.00e−7 ± 2.0e−8 1/N^2");
        assert_eq!(with_interval(0.0, None, "N"), "0 N");
    }

    #[test]
    fn parameters_lose_what_stands_beside_them() {
        assert_eq!(symbol("knee/coulomb-friction.force_n"), "force");
        assert_eq!(symbol("backlash.gap_m"), "gap");
        assert_eq!(symbol("stribeck-friction.speed_m_s"), "speed");
        assert_eq!(symbol("spring-hysteresis.stiffness_n_m"), "stiffness");
        assert_eq!(symbol("quadratic-drag.coefficient_n_s2_m2"), "coefficient");
        assert_eq!(symbol("hardening-spring.cubic_nm_rad3"), "cubic");
        assert_eq!(symbol("quadratic-drag.coefficient_nm_s2_rad2"), "coefficient");
        assert_eq!(symbol("torque-ripple.cycles_per_rev"), "cycles per rev");
    }
}
