//! Factors by which a column is off whose unit is not the one of its name.

use super::policy::NEAR_FACTOR;
use sealegs_model::Unit;

/// A unit that people log, and how many of it are one SI unit.
struct Other {
    of: &'static [Unit],
    per_si: f64,
    name: &'static str,
}

const FORCES: &[Unit] = &[Unit::Newton, Unit::NewtonMetre];
const ANGLES: &[Unit] = &[Unit::Radian, Unit::RadianPerSecond];
const LENGTHS: &[Unit] = &[Unit::Metre, Unit::MetrePerSecond];

/// Every factor is tried both ways: degrees under a name in radians, and radians that somebody divided once more. What is
/// nearer to 1 than 4 (pounds per kilogram) is no plain unit error but a parameter.
const OTHERS: [Other; 12] = [
    Other { of: ANGLES, per_si: 180.0 / std::f64::consts::PI, name: "degrees" },
    Other { of: &[Unit::RadianPerSecond], per_si: 30.0 / std::f64::consts::PI, name: "revolutions a minute" },
    Other { of: ANGLES, per_si: 0.5 / std::f64::consts::PI, name: "turns" },
    Other { of: ANGLES, per_si: 1000.0, name: "milliradians" },
    Other { of: FORCES, per_si: 1.0 / 9.806_65, name: "kilograms-force" },
    Other { of: FORCES, per_si: 1.0 / 4.448_22, name: "pounds-force" },
    Other { of: FORCES, per_si: 1000.0, name: "thousandths" },
    Other { of: LENGTHS, per_si: 1000.0, name: "millimetres" },
    Other { of: LENGTHS, per_si: 100.0, name: "centimetres" },
    Other { of: LENGTHS, per_si: 1e6, name: "micrometres" },
    Other { of: LENGTHS, per_si: 1.0 / 0.0254, name: "inches" },
    Other { of: &[Unit::Ampere], per_si: 1000.0, name: "milliamperes" },
];

/// What a column is probably in, by the size of its slope against the prediction: a factor and its name.
#[must_use]
pub(super) fn probable(channel: &str, slope: f64) -> Option<(f64, String)> {
    let unit = Unit::of_channel(channel).ok()?;
    let near = |factor: f64| (slope.abs() / factor).ln().abs();
    let both = OTHERS.iter().filter(|o| o.of.contains(&unit)).flat_map(|o| {
        let inverse = format!(
            "divided by {}, as if converted from {} to {} twice",
            short(o.per_si),
            o.name,
            unit.symbol()
        );
        [(o.per_si, o.name.to_owned()), (1.0 / o.per_si, inverse)]
    });
    let best = both.min_by(|a, b| near(a.0).total_cmp(&near(b.0)))?;
    (near(best.0) < NEAR_FACTOR.ln()).then_some(best)
}

/// Whether every value is a whole number, and not just a few of them: raw counts.
#[must_use]
pub(super) fn are_counts(values: &[f64]) -> bool {
    let mut different: Vec<f64> = values.to_vec();
    different.sort_by(f64::total_cmp);
    different.dedup();
    different.len() > 8 && different.iter().all(|v| v.fract() == 0.0)
}

/// Three figures, without an exponent where none is needed.
#[must_use]
pub(super) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let power = value.abs().log10().floor() as i32;
    if (-3..6).contains(&power) {
        format!("{value:.*}", (2 - power).max(0) as usize)
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_near_a_units_factor_are_known_both_ways_and_others_are_not() {
        let name = |channel: &str, slope: f64| probable(channel, slope).map(|p| p.1);
        assert_eq!(name("motor_angle_rad", 57.0).unwrap(), "degrees");
        assert_eq!(name("motor_angle_rad", -60.0).unwrap(), "degrees");
        assert_eq!(name("motor_angle_rad", 0.165).unwrap(), "turns");
        assert!(name("motor_angle_rad", 0.0175).unwrap().contains("degrees"));
        assert_eq!(name("force_1_n", 0.1).unwrap(), "kilograms-force");
        assert!(name("force_1_n", 9.9).unwrap().contains("kilograms-force"));
        assert_eq!(name("spring_deflection_m", 1020.0).unwrap(), "millimetres");
        assert_eq!(name("current_a", 1000.0).unwrap(), "milliamperes");
        assert_eq!(name("force_1_n", 57.3), None);
        for slope in [1.0, 0.5, 2.0, 1.15, 20.0] {
            assert_eq!(name("force_1_n", slope), None, "{slope}");
        }
        assert!(are_counts(&(0..100).map(f64::from).collect::<Vec<_>>()));
        assert!(
            !are_counts(&(0..100).map(|i| 0.5 * f64::from(i)).collect::<Vec<_>>()) && !are_counts(&[0.0; 99])
        );
        assert_eq!(
            (short(57.2958), short(0.101_97), short(1e6)),
            ("57.3".into(), "0.102".into(), "1.00e6".into())
        );
    }
}
