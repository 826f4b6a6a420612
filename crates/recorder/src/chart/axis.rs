//! Axes: range, scale, round ticks and their labels.

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AxisScale {
    /// Equal distances for equal differences.
    #[default]
    Linear,
    /// Equal distances for equal ratios; values that are not positive are left out.
    Logarithmic,
}

/// An axis with what is on it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axis {
    /// What is on it, for example `Spring force`.
    pub label: String,
    /// Its unit as printed, for example `N`; empty for a ratio.
    pub unit: String,
    /// Its scale.
    pub scale: AxisScale,
    /// The range shown; found from the data where it is `None`.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis with a range that suits the data.
    #[must_use]
    pub fn new(label: &str, unit: &str) -> Self {
        Self { label: label.into(), unit: unit.into(), ..Self::default() }
    }

    /// The same on a logarithmic scale.
    #[must_use]
    pub fn log(mut self) -> Self {
        self.scale = AxisScale::Logarithmic;
        self
    }

    /// The same with a fixed range.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// Whether the axis can show this value at all.
    pub(super) fn admits(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == AxisScale::Linear || value > 0.0)
    }

    /// The range for data between `low` and `high`, with `margin` as a share of it on both sides.
    pub(super) fn fit(&self, low: f64, high: f64, margin: f64) -> (f64, f64) {
        if let Some((a, b)) = self.range.filter(|(a, b)| a < b && self.admits(*a) && self.admits(*b)) {
            return (a, b);
        }
        if low > high || low.is_nan() || high.is_nan() {
            return match self.scale {
                AxisScale::Linear => (0.0, 1.0),
                AxisScale::Logarithmic => (1.0, 10.0),
            };
        }
        match self.scale {
            AxisScale::Linear if low == high => {
                let around = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
                (low - around, high + around)
            }
            AxisScale::Linear => (low - margin * (high - low), high + margin * (high - low)),
            AxisScale::Logarithmic if low == high => (low / 2.0, high * 2.0),
            AxisScale::Logarithmic => {
                let factor = (high / low).powf(margin);
                (low / factor, high * factor)
            }
        }
    }
}

/// Where an axis is marked and how the marks are called.
#[derive(Debug, Clone, PartialEq)]
pub struct Ticks {
    /// Labelled positions, ascending.
    pub major: Vec<(f64, String)>,
    /// Positions with a faint line only.
    pub minor: Vec<f64>,
    /// Labels are values divided by ten to this power; it belongs beside the unit.
    pub exponent: i32,
}

impl Ticks {
    /// Round ticks for a range, about `count` of them.
    #[must_use]
    pub fn new(scale: AxisScale, (low, high): (f64, f64), count: usize) -> Self {
        match scale {
            AxisScale::Logarithmic if low > 0.0 && (high / low).log10() > 0.7 => {
                Self::decades(low, high, count)
            }
            _ => Self::linear(low, high, count),
        }
    }

    fn linear(low: f64, high: f64, count: usize) -> Self {
        let step = nice_step((high - low) / count.max(1) as f64);
        let largest = low.abs().max(high.abs());
        let exponent = match largest {
            l if l >= 1e5 || (l < 1e-2 && l > 0.0) => 3 * (l.log10() / 3.0).floor() as i32,
            _ => 0,
        };
        let unit = 10_f64.powi(exponent);
        let decimals = (-(step / unit * 1.000_001).log10().floor()).max(0.0) as usize;
        let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        let major = (first..=last)
            .map(|i| {
                let value = i as f64 * step;
                (value, minus(&format!("{:.decimals$}", value / unit)))
            })
            .collect();
        Self { major, minor: Vec::new(), exponent }
    }

    fn decades(low: f64, high: f64, count: usize) -> Self {
        let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let decades = (high / low).log10();
        // Many decades: not every one has a label; few: 2 and 5 have one too.
        let every = (decades / count.max(1) as f64).ceil().max(1.0) as i32;
        let between = decades * 3.0 <= count as f64 + 1.0;
        let (mut major, mut minor) = (Vec::new(), Vec::new());
        let inside = |v: f64| v >= low * (1.0 - 1e-9) && v <= high * (1.0 + 1e-9);
        for decade in first..=last {
            for digit in 1..10 {
                let value = f64::from(digit) * 10_f64.powi(decade);
                if !inside(value) {
                    continue;
                }
                let labelled =
                    digit == 1 && decade.rem_euclid(every) == 0 || between && matches!(digit, 2 | 5);
                if labelled {
                    major.push((value, power_label(digit, decade)));
                } else if every == 1 || digit == 1 {
                    minor.push(value);
                }
            }
        }
        Self { major, minor, exponent: 0 }
    }
}

/// The nearest of 1, 2, 5 times a power of ten.
fn nice_step(rough: f64) -> f64 {
    if !(rough > 0.0 && rough.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(rough.log10().floor());
    let factor = match rough / power {
        r if r <= 1.5 => 1.0,
        r if r <= 3.5 => 2.0,
        r if r <= 7.5 => 5.0,
        _ => 10.0,
    };
    factor * power
}

fn power_label(digit: i32, decade: i32) -> String {
    match decade {
        0..=4 => format!("{}", f64::from(digit) * 10_f64.powi(decade)),
        -3..=-1 => format!("{:.*}", decade.unsigned_abs() as usize, f64::from(digit) * 10_f64.powi(decade)),
        _ if digit == 1 => format!("10{}", superscript(decade)),
        _ => format!("{digit}·10{}", superscript(decade)),
    }
}

/// A number in superscript digits.
pub(super) fn superscript(number: i32) -> String {
    number
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            c => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
        })
        .collect()
}

/// A label with a real minus sign, and no sign on zero.
fn minus(label: &str) -> String {
    match label.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => label.to_owned(),
    }
}

/// A label and its unit, with the power of ten that the tick labels leave out.
pub(super) fn axis_label(axis: &Axis, exponent: i32) -> String {
    let unit = match (exponent, axis.unit.as_str()) {
        (0, unit) => unit.to_owned(),
        (e, "") => format!("10{}", superscript(e)),
        (e, unit) => format!("10{} {unit}", superscript(e)),
    };
    match (axis.label.as_str(), unit.as_str()) {
        (label, "") => label.to_owned(),
        ("", unit) => format!("[{unit}]"),
        (label, unit) => format!("{label} [{unit}]"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.major.iter().map(|(_, l)| l.as_str()).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_inside() {
        let ticks = Ticks::new(AxisScale::Linear, (-1.03, 1.03), 5);
        assert_eq!(labels(&ticks), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        let ticks = Ticks::new(AxisScale::Linear, (0.0, 20.0), 5);
        assert_eq!(labels(&ticks), ["0", "5", "10", "15", "20"]);
        let ticks = Ticks::new(AxisScale::Linear, (99.97, 100.04), 4);
        assert_eq!(labels(&ticks), ["99.98", "100.00", "100.02", "100.04"]);
    }

    #[test]
    fn small_and_large_values_share_one_power_of_ten() {
        let ticks = Ticks::new(AxisScale::Linear, (0.0, 0.0031), 3);
        assert_eq!((labels(&ticks), ticks.exponent), (vec!["0", "1", "2", "3"], -3));
        let ticks = Ticks::new(AxisScale::Linear, (0.0, 655e3), 3);
        assert_eq!((labels(&ticks), ticks.exponent), (vec!["0", "200", "400", "600"], 3));
        assert_eq!(axis_label(&Axis::new("Stiffness", "N/m"), 3), "Stiffness [10³ N/m]");
    }

    #[test]
    fn logarithmic_ticks_mark_decades() {
        let ticks = Ticks::new(AxisScale::Logarithmic, (0.5, 120.0), 4);
        assert_eq!(labels(&ticks), ["1", "10", "100"]);
        assert!(ticks.minor.contains(&0.5) && ticks.minor.contains(&20.0) && !ticks.minor.contains(&10.0));
        let ticks = Ticks::new(AxisScale::Logarithmic, (1.0, 30.0), 6);
        assert_eq!(labels(&ticks), ["1", "2", "5", "10", "20"]);
        let ticks = Ticks::new(AxisScale::Logarithmic, (1e-6, 1e6), 5);
        assert_eq!(labels(&ticks), ["10⁻⁶", "0.001", "1", "1000", "10⁶"]);
    }

    #[test]
    fn ranges_never_collapse() {
        assert_eq!(Axis::default().fit(2.0, 2.0, 0.05), (1.8, 2.2));
        assert_eq!(Axis::default().fit(0.0, 0.0, 0.05), (-1.0, 1.0));
        assert_eq!(Axis::default().fit(f64::INFINITY, f64::NEG_INFINITY, 0.05), (0.0, 1.0));
        assert_eq!(Axis::default().log().fit(8.0, 8.0, 0.05), (4.0, 16.0));
        assert_eq!(Axis::default().range(0.0, 3.0).fit(1.0, 2.0, 0.05), (0.0, 3.0));
    }
}
