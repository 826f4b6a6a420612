//! Which spring survives which drop: the least margin over everything that has a limit.

use sealegs_leg::impact::{ImpactRow, ImpactTable};
use std::fmt::Write as _;

/// A drop beside its limits.
#[derive(Debug, Clone, PartialEq)]
pub enum Survived {
    /// There is no such drop in the table.
    NotDropped,
    /// The run did not reach its end.
    Stopped,
    /// Nothing has a limit that is known.
    NoLimit,
    /// The least margin, limit over peak, and whose it is.
    Margin {
        /// Below 1 the limit is exceeded.
        margin: f64,
        /// Actuator and limit: `knee rated force`.
        what: String,
    },
}

impl Survived {
    /// That of a drop, over the rated forces, the yield strengths and a limit of all actuators' forces, N.
    #[must_use]
    pub fn of(row: &ImpactRow, max_force_n: Option<f64>) -> Self {
        if row.stopped.is_some() {
            return Self::Stopped;
        }
        let of_actuators = row.actuators.iter().flat_map(|a| {
            let rated = a.force_margin.map(|m| (m, format!("{} rated force", a.name)));
            let yielding = a.stress_margin.map(|m| (m, format!("{} yield strength", a.name)));
            rated.into_iter().chain(yielding)
        });
        let (force, name) = row.greatest_force();
        let stated =
            max_force_n.filter(|_| force > 0.0).map(|max| (max / force, format!("{name} --max-force")));
        of_actuators
            .chain(stated)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(Self::NoLimit, |(margin, what)| Self::Margin { margin, what })
    }

    /// Whether no limit is exceeded in a drop that reached its end.
    #[must_use]
    pub fn survives(&self) -> bool {
        match self {
            Self::NotDropped | Self::Stopped => false,
            Self::NoLimit => true,
            Self::Margin { margin, .. } => *margin >= 1.0,
        }
    }

    /// A cell of the table: the margin, and what is exceeded where it is below 1.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::NotDropped => "-".to_owned(),
            Self::Stopped => "stopped".to_owned(),
            Self::NoLimit => "no limit known".to_owned(),
            Self::Margin { margin, what } if *margin < 1.0 => format!("{margin:.2} {what}"),
            Self::Margin { margin, .. } => format!("{margin:.2}"),
        }
    }
}

/// Springs over heights.
#[derive(Debug, Clone, PartialEq)]
pub struct Survival {
    /// Drop heights in the table's order, m.
    pub heights_m: Vec<f64>,
    /// Spring settings in the table's order.
    pub springs: Vec<String>,
    /// One row for each spring, one cell for each height.
    pub cells: Vec<Vec<Survived>>,
}

impl Survival {
    /// That of a table, with a limit of all actuators' forces, N.
    #[must_use]
    pub fn of(table: &ImpactTable, max_force_n: Option<f64>) -> Self {
        let mut heights_m: Vec<f64> = Vec::new();
        let mut springs: Vec<String> = Vec::new();
        for row in &table.rows {
            if !heights_m.contains(&row.height_m) {
                heights_m.push(row.height_m);
            }
            if !springs.contains(&row.spring) {
                springs.push(row.spring.clone());
            }
        }
        let cell = |spring: &String, height_m: f64| {
            let row = table.rows.iter().find(|r| r.spring == *spring && r.height_m == height_m);
            row.map_or(Survived::NotDropped, |row| Survived::of(row, max_force_n))
        };
        let cells = springs.iter().map(|s| heights_m.iter().map(|h| cell(s, *h)).collect()).collect();
        Self { heights_m, springs, cells }
    }

    /// Which drops the springs survive, one sentence each.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let said = |(spring, row): (&String, &Vec<Survived>)| {
            let kept = self.heights_m.iter().zip(row).filter(|(_, cell)| cell.survives());
            let kept: Vec<String> = kept.map(|(h, _)| format!("{h} m")).collect();
            let drops = match kept.len() {
                0 => "no drop".to_owned(),
                n if n == self.heights_m.len() => "every drop".to_owned(),
                _ => kept.join(", "),
            };
            format!("{spring} springs survive {drops}.")
        };
        self.springs.iter().zip(&self.cells).map(said).collect()
    }

    /// The table for a terminal, and the sentences below it.
    #[must_use]
    pub fn text(&self) -> String {
        let name = self.springs.iter().map(|s| s.chars().count()).max().unwrap_or(0).max(6);
        let texts: Vec<Vec<String>> =
            self.cells.iter().map(|row| row.iter().map(Survived::text).collect()).collect();
        let width = texts.iter().flatten().map(|text| text.chars().count()).max().unwrap_or(0).max(8);
        let mut out =
            String::from("\nLeast margin of any actuator, and what is exceeded where it is below 1:\n");
        let mut line = |first: &str, cells: &[String]| {
            let mut text = format!("  {first:<name$}");
            for cell in cells {
                let _ = write!(text, "  {cell:<width$}");
            }
            let _ = writeln!(out, "{}", text.trim_end());
        };
        line("spring", &self.heights_m.iter().map(|h| format!("{h} m")).collect::<Vec<_>>());
        for (spring, row) in self.springs.iter().zip(&texts) {
            line(spring, row);
        }
        out + &self.sentences().join("\n") + "\n"
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use sealegs_leg::impact::ImpactActuator;

    pub(in super::super) fn row(
        height_m: f64,
        spring: &str,
        force_margin: f64,
        stress_margin: Option<f64>,
    ) -> ImpactRow {
        let knee = ImpactActuator {
            name: "knee".to_owned(),
            force_1_n: 900.0,
            force_2_n: -1000.0,
            deflection_m: 1e-3,
            stress_pa: stress_margin.map(|_| 400e6),
            force_margin: Some(force_margin),
            stress_margin,
        };
        ImpactRow {
            height_m,
            spring: spring.to_owned(),
            ground_force_n: 2000.0,
            ground_force_time_s: 0.1,
            actuators: vec![knee],
            energy_residual: 0.0,
            stopped: None,
            change_at_half_step: None,
            changes_most: None,
        }
    }

    pub(in super::super) fn table() -> ImpactTable {
        let rows = vec![
            row(0.05, "compliant", 2.0, Some(1.5)),
            row(0.05, "stiff", 1.2, None),
            row(0.1, "compliant", 1.1, Some(0.8)),
            row(0.1, "stiff", 0.5, None),
        ];
        ImpactTable { scenario: "drop".to_owned(), step_s: 1e-4, rows }
    }

    #[test]
    fn the_last_table_says_which_spring_survives_which_drop() {
        let text = Survival::of(&table(), None).text();
        assert!(
            text.contains("0.80 knee yield strength") && text.contains("0.50 knee rated force"),
            "{text}"
        );
        assert!(text.contains("compliant springs survive 0.05 m.\nstiff springs survive 0.05 m."), "{text}");
        // 1000 N against 400 N: everything fails, and the reason is the stated limit.
        let text = Survival::of(&table(), Some(400.0)).text();
        assert!(text.contains("0.40 knee --max-force") && text.contains("survive no drop"), "{text}");
    }

    #[test]
    fn a_drop_that_stopped_or_is_not_there_survives_nothing() {
        let mut table = table();
        table.rows[2].stopped = Some("not finite".to_owned());
        table.rows.pop();
        let survival = Survival::of(&table, None);
        assert_eq!(survival.cells[0][1], Survived::Stopped);
        assert_eq!(survival.cells[1][1], Survived::NotDropped);
        assert_eq!(
            survival.sentences(),
            ["compliant springs survive 0.05 m.", "stiff springs survive 0.05 m."]
        );
    }
}
