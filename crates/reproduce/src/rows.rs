//! The table: every value that the dissertation prints with how far its print can be trusted, the formula that
//! recomputes it, and the verdict on a value of ours against it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::ReproduceError;

/// The files of the table, in the order of the text.
const FILES: [(&str, &str); 8] = [
    ("1-robots.toml", include_str!("../rows/1-robots.toml")),
    ("2-saffir-beam.toml", include_str!("../rows/2-saffir-beam.toml")),
    ("3-thor-beam.toml", include_str!("../rows/3-thor-beam.toml")),
    ("4-identification.toml", include_str!("../rows/4-identification.toml")),
    ("5-criteria.toml", include_str!("../rows/5-criteria.toml")),
    ("6-clipped.toml", include_str!("../rows/6-clipped.toml")),
    ("7-inventory.toml", include_str!("../rows/7-inventory.toml")),
    ("8-derived.toml", include_str!("../rows/8-derived.toml")),
];

/// A row of the table: a value as printed, and how it is recomputed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Row id: chapter or equation, and a number.
    pub id: String,
    /// Section, table, figure or equation of the dissertation. The text at hand has no page numbers.
    pub reference: String,
    /// What the value is of.
    pub quantity: String,
    /// Its unit; `-` for a ratio.
    pub unit: String,
    /// As printed; empty where nothing is.
    #[serde(default)]
    pub printed: String,
    /// The printed value as a number, where it is one.
    pub value: Option<f64>,
    /// Half a unit of the last printed digit: within it, both agree.
    #[serde(default)]
    pub half_unit: f64,
    /// How far printing, reading off a figure or loose wording may reach. Zero where the text computes.
    #[serde(default)]
    pub loose: f64,
    /// Whether the printed value is an upper bound rather than the value.
    #[serde(default)]
    pub bound: bool,
    /// What recomputes the value in its unit: arithmetic over the inputs, or one call of a function of this crate. A
    /// statement has none.
    pub formula: Option<String>,
    /// The inputs of formula and remark.
    #[serde(default)]
    pub inputs: BTreeMap<String, Input>,
    /// Whether the value can be held against the print; otherwise it is shown beside it.
    #[serde(default = "yes")]
    pub judged: bool,
    /// A line of why. `{expression:.1}` shows a number made of the inputs and of `ours`.
    #[serde(default)]
    pub why: String,
    /// The verdict of an independent reading of the text, by which tests check ours.
    pub verdict: String,
    /// The value as recomputed independently of this program, for tests; no verdict reads it.
    pub independent: Option<f64>,
}

/// An input of a formula.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Input {
    /// A number, as the text states it.
    Number(f64),
    /// A call of a function of this crate.
    Call(String),
}

fn yes() -> bool {
    true
}

/// What came of comparing a value with the print.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The same to the printed digits.
    Agrees,
    /// Apart by no more than printing, reading off or loose wording explains.
    Rounding,
    /// The print does not follow from the stated inputs.
    Miss,
    /// Not printed; computed from what is.
    Derived,
    /// Printed, and nothing to recompute it from.
    Statement,
}

impl Verdict {
    /// As shown to a reader.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Rounding => "rounding",
            Self::Miss => "MISS",
            Self::Derived => "derived",
            Self::Statement => "statement, not recomputed",
        }
    }
}

impl Entry {
    /// The verdict on a value of ours, in the row's unit.
    #[must_use]
    pub fn judge(&self, ours: f64) -> Verdict {
        let Some(value) = self.value else { return Verdict::Derived };
        if self.bound {
            return if ours <= value + self.half_unit { Verdict::Agrees } else { Verdict::Miss };
        }
        // A hair of slack, so that 0.005 against half a unit of 0.005 is not decided by binary digits.
        let apart = (ours - value).abs() * (1.0 - 1e-9);
        if apart <= self.half_unit {
            Verdict::Agrees
        } else if apart <= self.loose {
            Verdict::Rounding
        } else {
            Verdict::Miss
        }
    }

    /// Ours against the print as a ratio less one, where both are numbers and the print is not zero.
    #[must_use]
    pub fn deviation(&self, ours: f64) -> Option<f64> {
        self.value.filter(|v| *v != 0.0 && !self.bound).map(|v| ours / v - 1.0)
    }
}

/// All rows, in the order of the table.
///
/// # Errors
///
/// [`ReproduceError::Table`] if an embedded file is damaged, with its line.
pub fn entries() -> Result<Vec<Entry>, ReproduceError> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Rows {
        row: Vec<Entry>,
    }
    let mut all = Vec::new();
    for (file, text) in FILES {
        let rows: Rows =
            toml::from_str(text).map_err(|e| ReproduceError::Table { file, message: e.to_string() })?;
        all.extend(rows.row);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(value: Option<f64>, half_unit: f64, loose: f64) -> Entry {
        let text = "id = 'x'\nreference = ''\nquantity = ''\nunit = 'Hz'\nverdict = ''";
        Entry { value, half_unit, loose, ..toml::from_str(text).unwrap() }
    }

    #[test]
    fn verdicts_follow_from_the_distance() {
        let r = row(Some(10.19), 0.005, 0.05);
        assert_eq!(r.judge(10.194), Verdict::Agrees);
        assert_eq!(r.judge(10.174), Verdict::Rounding);
        assert_eq!(r.judge(7.5), Verdict::Miss);
        assert_eq!(r.judge(10.195), Verdict::Agrees, "exactly half a unit");
        assert_eq!(row(None, 0.0, 0.0).judge(1.0), Verdict::Derived);
        let bound = Entry { bound: true, ..row(Some(42.0), 0.05, 0.0) };
        assert_eq!(bound.judge(34.3), Verdict::Agrees);
        assert_eq!(bound.judge(43.0), Verdict::Miss);
        assert_eq!(bound.deviation(34.3), None);
        assert!((r.deviation(20.38).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_embedded_files_are_whole() {
        let rows = entries().unwrap();
        assert!(rows.len() > 163);
        let mut ids: Vec<&str> = rows.iter().map(|r| r.id.as_str()).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), rows.len(), "ids are unique");
        for r in &rows {
            assert!(r.value.is_none() || r.half_unit > 0.0, "{}: a print has a last digit", r.id);
            assert!(r.formula.is_none() || !r.why.is_empty(), "{}: a line of why", r.id);
            let used =
                |name: &str| r.why.contains(name) || r.formula.as_ref().is_some_and(|f| f.contains(name));
            for name in r.inputs.keys() {
                assert!(used(name), "{}: {name} is not used", r.id);
            }
        }
    }
}
