//! What a file calls a column, what the data contract calls it, and how the one becomes the other.

use crate::units;
use sealegs_model::Unit;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use std::fmt;

/// One line of a campaign's `[columns]`.
///
/// A number `x` of the file becomes `sign * scale * u(x) + offset`, where `u` converts from `unit` to SI and unwraps
/// before, if that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMap {
    /// The column in the file: its name, with the table's name before it (`/joint_states.position[knee]`) or the file's
    /// (`b.csv:force`) where the name alone is not enough.
    pub source: String,
    /// The channel that it becomes; its ending is the SI unit.
    pub target: String,
    /// By what the file's numbers are multiplied, units and sign included.
    pub scale: f64,
    /// What is then added, in the channel's unit.
    pub offset: f64,
    /// After how much the file's numbers begin again, in the file's unit.
    pub wrap: Option<f64>,
    /// Whether a run may be without it.
    pub optional: bool,
    /// No column of the file: every row has this value, in the channel's unit. `source` is then a name that nothing looks for.
    pub constant: Option<f64>,
}

/// What the campaign file says of a column: `"name"`, or a table of these keys.
#[derive(Debug, Clone, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Described {
    /// The channel.
    #[serde(rename = "as")]
    name: String,
    scale: Option<f64>,
    offset: Option<f64>,
    sign: Option<f64>,
    unit: Option<String>,
    wrap: Option<Wrap>,
    #[serde(default)]
    optional: bool,
    constant: Option<f64>,
}

/// `true`: a whole turn; a number: so much.
#[derive(Debug, Clone, Copy, serde::Deserialize)]
#[serde(untagged, expecting = "wrap must be true, or after how much the numbers begin again")]
enum Wrap {
    Turn(bool),
    Period(f64),
}

/// [`Described`], of which the name alone may stand there.
#[derive(Debug, Clone)]
pub struct Said(pub Described);

impl<'de> Deserialize<'de> for Said {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Said;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a channel's name, or { as = \"name\", scale = …, offset = …, sign = …, unit = …, wrap = … }, or { as = \"name\", constant = … }")
            }

            fn visit_str<E>(self, name: &str) -> Result<Said, E> {
                Ok(Said(Described { name: name.to_owned(), ..Described::default() }))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Said, A::Error> {
                Described::deserialize(MapAccessDeserializer::new(map)).map(Said)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl ColumnMap {
    /// The column under its own name, as it is.
    #[must_use]
    pub fn plain(name: &str) -> Self {
        Self {
            source: name.to_owned(),
            target: name.to_owned(),
            scale: 1.0,
            offset: 0.0,
            wrap: None,
            optional: false,
            constant: None,
        }
    }

    /// Checks what a campaign file says of the column `source`.
    ///
    /// # Errors
    ///
    /// What is wrong, in words.
    pub fn new(source: &str, said: &Described) -> Result<Self, String> {
        let target = said.name.trim();
        if target.is_empty() {
            return Err("'as' is empty; it says which channel the column becomes".to_owned());
        }
        // A name without an underscore (`enable`) has no unit.
        let channel = match Unit::of_channel(target) {
            Ok(unit) => Some(unit),
            Err(_) if !target.contains('_') => None,
            Err(error) => return Err(error.to_string()),
        };
        let finite = |value: Option<f64>, key: &str, default: f64| match value {
            Some(v) if !v.is_finite() => Err(format!("'{key}' is {v}; must be finite")),
            other => Ok(other.unwrap_or(default)),
        };
        let scale = finite(said.scale, "scale", 1.0)?;
        let sign = said.sign.unwrap_or(1.0);
        if sign.abs() != 1.0 {
            return Err(format!("'sign' is {sign}; it is 1 or -1"));
        }
        let (factor, add) = match (&said.unit, channel) {
            (None, _) => (1.0, 0.0),
            (Some(unit), Some(channel)) => units::of(unit, channel)?,
            (Some(_), None) => return Err(format!("'{target}' has no unit")),
        };
        let wrap = match said.wrap {
            None | Some(Wrap::Turn(false)) => None,
            Some(Wrap::Turn(true)) => Some(units::turn(said.unit.as_deref().unwrap_or("rad"))),
            Some(Wrap::Period(period)) if period.is_finite() && period > 0.0 => Some(period),
            Some(Wrap::Period(period)) => return Err(format!("'wrap' is {period}; must be positive")),
        };
        let offset = finite(said.offset, "offset", 0.0)?;
        let whole = scale * sign * factor;
        if whole == 0.0 || !whole.is_finite() {
            return Err(format!(
                "'scale' is {scale}; all values would be the same; a constant is {{ as = \"{target}\", constant = … }}"
            ));
        }
        let offset = scale * sign * add + offset;
        let constant = match said.constant {
            None => None,
            Some(_) if target == "time_s" => return Err("'constant' makes no time".to_owned()),
            Some(_) if wrap.is_some() => return Err("'wrap' says nothing of a constant".to_owned()),
            Some(value) if !(whole * value + offset).is_finite() => {
                return Err(format!("'constant' is {value}; must be finite"));
            }
            Some(value) => Some(whole * value + offset),
        };
        Ok(Self {
            source: source.to_owned(),
            target: target.to_owned(),
            scale: whole,
            offset,
            constant,
            wrap,
            optional: said.optional,
        })
    }

    /// The channel's values.
    #[must_use]
    pub fn apply(&self, numbers: &[f64]) -> Vec<f64> {
        let map = |x: f64| self.scale * x + self.offset;
        if self.scale == 1.0 && self.offset == 0.0 && self.wrap.is_none() {
            return numbers.to_vec();
        }
        match self.wrap {
            None => numbers.iter().map(|&x| map(x)).collect(),
            Some(period) => unwrapped(numbers, period).into_iter().map(map).collect(),
        }
    }
}

/// Numbers that begin again after a period, made to go on: no step is longer than half of it.
pub(crate) fn unwrapped(numbers: &[f64], period: f64) -> Vec<f64> {
    let mut turns = 0.0;
    let mut before = numbers.first().copied().unwrap_or(0.0);
    numbers
        .iter()
        .map(|&x| {
            turns -= ((x - before) / period).round();
            before = x;
            x + turns * period
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(name: &str) -> Described {
        Described { name: name.to_owned(), ..Described::default() }
    }

    #[test]
    fn units_signs_and_offsets_come_together() {
        let said = Described {
            scale: Some(2.0),
            sign: Some(-1.0),
            unit: Some("deg".into()),
            offset: Some(0.5),
            ..described("joint_angle_rad")
        };
        let map = ColumnMap::new("q", &said).unwrap();
        let value = map.apply(&[90.0])[0];
        assert!((value - (0.5 - std::f64::consts::PI)).abs() < 1e-12, "{value}");
        let kelvin = Described { unit: Some("K".into()), ..described("temperature_c") };
        assert!((ColumnMap::new("T", &kelvin).unwrap().apply(&[300.0])[0] - 26.85).abs() < 1e-9);
    }

    #[test]
    fn angles_are_unwrapped_in_the_files_own_unit() {
        let said = Described {
            unit: Some("deg".into()),
            wrap: Some(Wrap::Turn(true)),
            ..described("joint_angle_rad")
        };
        let values = ColumnMap::new("q", &said).unwrap().apply(&[350.0, 10.0, 30.0, 350.0, 330.0]);
        let degrees: Vec<f64> = values.iter().map(|v| v.to_degrees().round()).collect();
        assert_eq!(degrees, [350.0, 370.0, 390.0, 350.0, 330.0]);
        assert_eq!(unwrapped(&[4000.0, 90.0, 4000.0], 4096.0), [4000.0, 4186.0, 4000.0]);
    }

    #[test]
    fn a_constant_is_in_the_channels_unit_whatever_it_is_said_in() {
        let said = Described { constant: Some(12_000.0), unit: Some("mV".into()), ..described("voltage_v") };
        let map = ColumnMap::new("supply", &said).unwrap();
        assert!((map.constant.unwrap() - 12.0).abs() < 1e-12, "{map:?}");
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let with = |change: fn(&mut Described)| {
            let mut said = described("current_a");
            change(&mut said);
            ColumnMap::new("i", &said).unwrap_err()
        };
        assert!(with(|s| s.name = "current_x".into()).contains("known unit"));
        assert!(with(|s| s.unit = Some("deg".into())).contains("something else"));
        assert!(with(|s| s.scale = Some(0.0)).contains("the same"));
        assert!(with(|s| s.sign = Some(2.0)).contains("1 or -1"));
        assert!(with(|s| s.wrap = Some(Wrap::Period(-1.0))).contains("positive"));
        assert!(with(|s| s.offset = Some(f64::NAN)).contains("finite"));
        assert!(with(|s| s.constant = Some(f64::INFINITY)).contains("finite"));
        let timeless = Described { constant: Some(1.0), ..described("time_s") };
        assert!(ColumnMap::new("t", &timeless).unwrap_err().contains("time"));
    }
}
