//! The page of a sweep: which spring survives which drop, and the peaks over the height beside their limits.

use super::{Survival, Survived};
use crate::diagnosis::text::figures;
use crate::report::units::capital;
use sealegs_leg::impact::{ImpactActuator, ImpactRow, ImpactTable};
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker, Picture};
use sealegs_recorder::report::{Answer, Provenance, Report, Table, Tone};

/// How the springs' lines are drawn, in the order of the table; beyond the fourth dashes and marks repeat.
const DASHES: [Dash; 4] = [Dash::Solid, Dash::Dashed, Dash::DashDot, Dash::Dotted];
const MARKERS: [Marker; 4] = [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond];

/// Change of a peak at half the step up to which a sweep is called converged, as a ratio.
const CONVERGED: f64 = 0.01;

/// The page of a sweep, with a limit of all actuators' forces, N; `command` is what made it.
#[must_use]
pub fn page(table: &ImpactTable, max_force_n: Option<f64>, command: &str) -> String {
    let sweep = Sweep { table, survival: Survival::of(table, max_force_n), max_force_n };
    let mut page = Report::new(&format!("{}: which spring survives which drop", table.scenario));
    page.wide().subtitle(&format!("{} drops at a step of {:.0} µs", table.rows.len(), 1e6 * table.step_s));
    sweep.screen(&mut page);
    page.section("Every actuator");
    sweep.actuators(&mut page);
    page.section("Details");
    page.details("Peaks of every drop", |page| sweep.rows(page));
    page.details("Provenance", |page| {
        page.provenance_list(&Provenance {
            command: command.to_owned(),
            versions: vec![("sealegs".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
            ..Provenance::default()
        });
    });
    page.to_html()
}

/// A quantity of an actuator with its limit.
struct Quantity {
    /// In words.
    name: &'static str,
    /// In one word, for a small picture's axis.
    axis: &'static str,
    /// The unit as drawn, and what a value is multiplied by for it.
    unit: (&'static str, f64),
    /// The peak, SI.
    peak: fn(&ImpactActuator) -> Option<f64>,
    /// What its limit is called, and the margin to it.
    limit: (&'static str, fn(&ImpactActuator) -> Option<f64>),
}

const FORCE: Quantity = Quantity {
    name: "Peak force",
    axis: "Force",
    unit: ("kN", 1e-3),
    peak: |a| Some(a.force_1_n.abs().max(a.force_2_n.abs())),
    limit: ("rated force", |a| a.force_margin),
};
const STRESS: Quantity = Quantity {
    name: "Peak bending stress",
    axis: "Stress",
    unit: ("MPa", 1e-6),
    peak: |a| a.stress_pa,
    limit: ("yield strength", |a| a.stress_margin),
};
const DEFLECTION: Quantity = Quantity {
    name: "Peak spring deflection",
    axis: "Deflection",
    unit: ("mm", 1e3),
    peak: |a| Some(a.deflection_m.abs()),
    limit: ("", |_| None),
};

struct Sweep<'a> {
    table: &'a ImpactTable,
    survival: Survival,
    max_force_n: Option<f64>,
}

impl Sweep<'_> {
    /// The answer, the ground's force and the actuator nearest to its limit, and the table of springs over heights.
    fn screen(&self, page: &mut Report) {
        let cells = || self.survival.cells.iter().flatten();
        let kept = cells().filter(|c| c.survives()).count();
        let tone = match kept {
            n if n == cells().count() => Tone::Good,
            0 => Tone::Bad,
            _ => Tone::Caution,
        };
        let headline = match tone {
            Tone::Good => "Every spring survives every drop.".to_owned(),
            Tone::Bad => "No spring survives any drop.".to_owned(),
            _ => self.survival.sentences().iter().map(|s| capital(s)).collect::<Vec<_>>().join(" "),
        };
        let values: Vec<(String, String, String)> = self
            .survival
            .springs
            .iter()
            .zip(&self.survival.cells)
            .filter_map(|(s, c)| self.least(s, c))
            .collect();
        let (certainty, reasons) = self.certainty();
        let answer = Answer { headline: &headline, values: &values, certainty, reasons: &reasons };
        let ground = self.chart("Peak force of the ground", "Force", ("kN", 1e-3), |r| {
            Some(r.ground_force_n).filter(|f| *f > 0.0)
        });
        let nearest = self.nearest();
        let actuator = nearest.map(|name| self.of_actuator(name, &FORCE));
        page.first_screen(|page| {
            page.answer(tone, &answer);
            let mut figures: Vec<(&dyn Picture, &str)> =
                vec![(&ground, "Greatest normal force between foot and ground in each drop.")];
            if let Some(chart) = &actuator {
                figures.push((
                    chart,
                    "The actuator with the least margin: the greater of the forces on its two links, and what it may bear.",
                ));
            }
            page.side_by_side(&figures);
            page.table(
                &self.margins(),
                "Least margin of any actuator, limit over peak; where it is below 1, what is exceeded.",
            );
        });
    }

    /// A spring's least margin, where it is, and whose it is.
    fn least(&self, spring: &str, cells: &[Survived]) -> Option<(String, String, String)> {
        let margins = self.survival.heights_m.iter().zip(cells).filter_map(|(height, cell)| match cell {
            Survived::Margin { margin, what } => Some((*margin, *height, what)),
            _ => None,
        });
        let (margin, height, what) = margins.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((
            format!("{spring}, least margin"),
            format!("{margin:.2}"),
            format!("{what}, drop from {height} m"),
        ))
    }

    /// How far the numbers can be relied on.
    fn certainty(&self) -> (&'static str, Vec<String>) {
        let rows = &self.table.rows;
        let mut reasons = Vec::new();
        let changes: Option<Vec<f64>> = rows.iter().map(|r| r.change_at_half_step).collect();
        let word = match changes.map(|c| c.into_iter().fold(0.0, f64::max)) {
            Some(change) => {
                reasons
                    .push(format!("At half the step peak forces change by at most {:.2} %.", 100.0 * change));
                if change <= CONVERGED { "Converged" } else { "Not converged" }
            }
            None => {
                reasons.push(
                    "--check repeats every drop at half the step and says how much peaks change.".to_owned(),
                );
                "Step not checked"
            }
        };
        let energy = rows.iter().map(|r| r.energy_residual).fold(0.0, f64::max);
        reasons
            .push(format!("Energy that is not accounted for: at most {energy:.1e} of the energy in motion."));
        reasons
            .push("Limits are the rated forces and the yield strengths of the actuators' files.".to_owned());
        reasons.extend(self.max_force_n.map(|max| format!("--max-force adds {max} N for every actuator.")));
        for row in rows.iter().filter(|r| r.stopped.is_some()) {
            let why = row.stopped.as_deref().unwrap_or_default();
            reasons.push(format!(
                "The drop from {} m with {} springs stopped: {why}.",
                row.height_m, row.spring
            ));
        }
        (word, reasons)
    }

    /// The actuator of the least margin of force; without limits that of the greatest force.
    fn nearest(&self) -> Option<&str> {
        let all = || self.table.rows.iter().flat_map(|r| &r.actuators);
        let by_margin = all().filter_map(|a| Some((a.force_margin?, a)));
        let nearest = by_margin.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, a)| a);
        let force = |a: &&ImpactActuator| a.force_1_n.abs().max(a.force_2_n.abs());
        nearest.or_else(|| all().max_by(|a, b| force(a).total_cmp(&force(b)))).map(|a| a.name.as_str())
    }

    /// Peaks over the height, one line for each spring.
    fn chart(
        &self,
        title: &str,
        what: &str,
        unit: (&str, f64),
        peak: impl Fn(&ImpactRow) -> Option<f64>,
    ) -> Chart {
        let mut chart = Chart::new(title, Axis::new("Drop height", "m"), Axis::new(what, unit.0));
        for (i, spring) in self.survival.springs.iter().enumerate() {
            let rows = self.table.rows.iter().filter(|r| r.spring == *spring && r.stopped.is_none());
            let mut points: Vec<(f64, f64)> =
                rows.filter_map(|r| Some((r.height_m, unit.1 * peak(r)?))).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            if !points.is_empty() {
                let (hue, dash, marker) = look(i);
                chart = chart.marked(spring, hue, dash, marker, points);
            }
        }
        chart
    }

    /// A quantity of an actuator with its limit, where one is known.
    fn of_actuator(&self, name: &str, quantity: &Quantity) -> Chart {
        let own = |r: &ImpactRow| r.actuators.iter().find(|a| a.name == name).cloned();
        let title = format!("{}: {}", name, quantity.name.to_lowercase());
        let chart = self.chart(&title, quantity.axis, quantity.unit, |r| (quantity.peak)(&own(r)?));
        let limit = self
            .table
            .rows
            .iter()
            .filter_map(own)
            .find_map(|a| Some((quantity.limit.1)(&a)? * (quantity.peak)(&a)?));
        let chart = match limit {
            Some(limit) => {
                let (symbol, scale) = quantity.unit;
                let label = format!("{} {} {symbol}", quantity.limit.0, figures(scale * limit, 3));
                chart.horizontal(scale * limit, &label)
            }
            None => chart,
        };
        match self.max_force_n.filter(|_| quantity.name == FORCE.name) {
            Some(max) => {
                let (symbol, scale) = quantity.unit;
                chart.horizontal(scale * max, &format!("--max-force {} {symbol}", figures(scale * max, 3)))
            }
            None => chart,
        }
    }

    /// Springs over heights.
    fn margins(&self) -> Table {
        let mut table = Table::new().words("spring");
        for height in &self.survival.heights_m {
            table = table.words(&format!("{height} m"));
        }
        for (spring, cells) in self.survival.springs.iter().zip(&self.survival.cells) {
            table.row(std::iter::once(spring.clone()).chain(cells.iter().map(Survived::text)));
        }
        table
    }

    /// Small pictures of every actuator: force, stress where there is a beam, deflection.
    fn actuators(&self, page: &mut Report) {
        let names: Vec<&str> = self
            .table
            .rows
            .first()
            .map_or_else(Vec::new, |r| r.actuators.iter().map(|a| a.name.as_str()).collect());
        let keys: Vec<(&str, Hue, Dash)> = (self.survival.springs.iter().enumerate())
            .map(|(i, spring)| (spring.as_str(), look(i).0, look(i).1))
            .collect();
        for (quantity, caption) in [
            (
                &FORCE,
                "Peak force of each actuator over the drop height: the greater of the forces on its two links.",
            ),
            (&STRESS, "Peak bending stress of each beam in the load path over the drop height."),
            (&DEFLECTION, "Peak deflection of each spring over the drop height."),
        ] {
            let charts: Vec<Chart> = names.iter().map(|name| self.of_actuator(name, quantity)).collect();
            // The key stands once above all of them.
            let quiet = charts.into_iter().filter(|c| !c.lines.is_empty()).map(|mut chart| {
                chart.lines.iter_mut().for_each(|line| line.label.clear());
                chart
            });
            let quiet: Vec<Chart> = quiet.collect();
            if !quiet.is_empty() {
                let pictures: Vec<&dyn Picture> = quiet.iter().map(|c| c as &dyn Picture).collect();
                page.multiples(&pictures, &keys, caption);
            }
        }
    }

    /// Every drop and actuator.
    fn rows(&self, page: &mut Report) {
        let mut table = Table::new()
            .numbers("height", "m")
            .words("spring")
            .words("actuator")
            .numbers("F1", "N")
            .numbers("F2", "N")
            .numbers("spring", "mm")
            .numbers("beam", "MPa")
            .numbers("force margin", "")
            .numbers("stress margin", "");
        let or_dash = |v: Option<f64>, digits: usize| v.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
        for row in &self.table.rows {
            for a in &row.actuators {
                let cells = [
                    row.height_m.to_string(),
                    row.spring.clone(),
                    a.name.clone(),
                    format!("{:.0}", a.force_1_n),
                    format!("{:.0}", a.force_2_n),
                    format!("{:.3}", 1e3 * a.deflection_m),
                    or_dash(a.stress_pa.map(|s| 1e-6 * s), 1),
                    or_dash(a.force_margin, 2),
                    or_dash(a.stress_margin, 2),
                ];
                let exceeded = [a.force_margin, a.stress_margin].into_iter().flatten().any(|m| m < 1.0);
                if exceeded {
                    table.strong_row(cells)
                } else {
                    table.row(cells)
                };
            }
        }
        page.table(
            &table,
            "Peaks with their signs, compression positive: force on the spring side (F1) and on the screw side (F2), deflection \
             of the spring, stress of its beam. A margin is limit over peak; lines with one below 1 stand out.",
        );
    }
}

/// How the line of a spring is drawn.
fn look(spring: usize) -> (Hue, Dash, Marker) {
    let (n, hues) = (DASHES.len(), Hue::SERIES);
    (hues[spring % hues.len()], DASHES[spring % n], MARKERS[spring % n])
}

#[cfg(test)]
mod tests {
    use super::super::survival::tests::table;
    use super::*;

    #[test]
    fn the_page_answers_first_and_draws_every_limit() {
        let page = page(&table(), Some(1500.0), "sealegs impact drop --max-force 1500");
        let screen = &page[page.find("<section id=\"answer\">").unwrap()..page.find("</section>").unwrap()];
        for said in [
            "Compliant springs survive 0.05 m. Stiff springs survive 0.05 m.",
            "class=\"verdict answer caution\"",
            "knee yield strength, drop from 0.1 m",
            "Step not checked",
            "Peak force of the ground",
            "knee: peak force",
            "rated force 2.00 kN",
            "--max-force 1.50 kN",
            "0.50 knee rated force",
        ] {
            assert!(screen.contains(said), "'{said}' in {screen}");
        }
        assert!(page.contains("knee: peak bending stress") && page.contains("yield strength"));
        assert!(page.contains("Drop height [m]") && page.contains("Stress [MPa]"), "{page}");
        let all = |max_force_n| super::page(&table(), Some(max_force_n), "");
        assert!(all(100.0).contains("No spring survives any drop."));
    }

    #[test]
    fn a_checked_sweep_says_how_far_it_is_converged() {
        let mut table = table();
        table.rows.iter_mut().for_each(|r| r.change_at_half_step = Some(0.004));
        assert!(page(&table, None, "").contains("change by at most 0.40 %"));
        assert!(page(&table, None, "").contains(">Converged<"));
        table.rows[1].change_at_half_step = Some(0.02);
        assert!(page(&table, None, "").contains(">Not converged<"));
    }
}
