//! The published side: every value that the dissertation prints, with how far its print can be trusted, and the
//! verdict on a value of ours against it.

use serde::Serialize;

/// One value as printed. The facts are data (`assets/published-values.csv`); nothing of ours is in it but
/// `independent`, which tests compare with and no verdict reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Row id: chapter or equation, and a number.
    pub id: String,
    /// Section, table, figure or equation of the dissertation.
    pub reference: String,
    /// What the value is of.
    pub quantity: String,
    /// Its unit; `-` for a ratio.
    pub unit: String,
    /// As printed; empty where nothing is.
    pub printed: String,
    /// The printed value as a number, where it is one.
    pub value: Option<f64>,
    /// Half a unit of the last printed digit: within it, both agree.
    pub half_unit: f64,
    /// How far printing, reading off a figure or loose wording may reach. Zero where the text computes.
    pub loose: f64,
    /// Whether the printed value is an upper bound rather than the value.
    pub is_bound: bool,
    /// The fact sheet's verdict, by which tests check ours.
    pub sheet_verdict: String,
    /// The value as recomputed independently of this program, for tests.
    pub independent: Option<f64>,
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

impl Published {
    /// The verdict on a value of ours, in the row's unit.
    #[must_use]
    pub fn judge(&self, ours: f64) -> Verdict {
        let Some(value) = self.value else { return Verdict::Derived };
        if self.is_bound {
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
        self.value.filter(|v| *v != 0.0 && !self.is_bound).map(|v| ours / v - 1.0)
    }
}

/// All rows, in the order of the text.
///
/// # Errors
///
/// If the embedded file is damaged, with its line.
pub fn published() -> anyhow::Result<Vec<Published>> {
    let text = include_str!("../../../../assets/published-values.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let field = |i: usize| record.get(i).unwrap_or_default();
        let number = |i: usize| -> anyhow::Result<Option<f64>> {
            let text = field(i);
            if text.is_empty() { Ok(None) } else { Ok(Some(text.parse::<f64>()?)) }
        };
        rows.push(Published {
            id: field(0).to_owned(),
            reference: field(1).to_owned(),
            quantity: field(2).to_owned(),
            unit: field(3).to_owned(),
            printed: field(4).to_owned(),
            value: number(5)?,
            half_unit: number(6)?.unwrap_or(0.0),
            loose: number(7)?.unwrap_or(0.0),
            is_bound: field(8) == "<=",
            sheet_verdict: field(9).to_owned(),
            independent: number(10)?,
        });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(value: Option<f64>, half_unit: f64, loose: f64) -> Published {
        Published {
            id: "x".into(),
            reference: String::new(),
            quantity: String::new(),
            unit: "Hz".into(),
            printed: String::new(),
            value,
            half_unit,
            loose,
            is_bound: false,
            sheet_verdict: String::new(),
            independent: None,
        }
    }

    #[test]
    fn verdicts_follow_from_the_distance() {
        let r = row(Some(10.19), 0.005, 0.05);
        assert_eq!(r.judge(10.194), Verdict::Agrees);
        assert_eq!(r.judge(10.174), Verdict::Rounding);
        assert_eq!(r.judge(7.5), Verdict::Miss);
        assert_eq!(r.judge(10.195), Verdict::Agrees, "exactly half a unit");
        assert_eq!(row(None, 0.0, 0.0).judge(1.0), Verdict::Derived);
        let bound = Published { is_bound: true, ..row(Some(42.0), 0.05, 0.0) };
        assert_eq!(bound.judge(34.3), Verdict::Agrees);
        assert_eq!(bound.judge(43.0), Verdict::Miss);
        assert_eq!(bound.deviation(34.3), None);
        assert!((r.deviation(20.38).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_embedded_file_is_whole() {
        let rows = published().unwrap();
        assert!(rows.len() > 163);
        let mut ids: Vec<&str> = rows.iter().map(|r| r.id.as_str()).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), rows.len(), "ids are unique");
        for r in &rows {
            assert!(r.value.is_none() || r.half_unit > 0.0, "{}: a print has a last digit", r.id);
        }
    }
}
