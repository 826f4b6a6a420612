//! The pictures of a diagnosis: measured, before and after in time and in frequency, maps and loops.

use super::story::{Across, Story};
use crate::comparison::Part;
use crate::comparison::overlay::{self, Look, worst_run};
use sealegs_model::Unit;
use sealegs_model::internal;
use sealegs_recorder::chart::{Axis, Chart, Dash, HeatMap, Hue, Picture};
use sealegs_recorder::report::Report;
use sealegs_sysid::{Evaluation, stats};

/// How the two models are drawn.
pub(super) const BEFORE: Look = ("before", Hue::Vermillion, Dash::Dashed);
pub(super) const AFTER: Look = ("after", Hue::Blue, Dash::Solid);

/// Measured, before and after in time, with the residuals below, of the worst run of each role.
pub fn motion(page: &mut Report, story: &Story) {
    page.details("All channels in time, in the worst run of each role", |page| {
        for part in story.compared.parts.iter().rev() {
            let mut models = vec![(BEFORE, &part.before)];
            models.extend(part.after.as_ref().map(|after| (AFTER, after)));
            overlay::in_time(page, part, worst_run(part, &part.before), &models);
        }
    });
}

/// Frequency responses, measured, before and after.
pub fn responses(page: &mut Report, story: &Story) {
    let drawn: Vec<_> = story.compared.responses.iter().filter(|r| overlay::is_drawn(r)).collect();
    if drawn.is_empty() {
        return;
    }
    page.details("Frequency responses", |page| {
        for r in drawn {
            let after = story.after_responses.iter().find(|a| a.channel == r.channel);
            let mut models = vec![(BEFORE, &r.predicted)];
            models.extend(after.map(|a| (AFTER, &a.predicted)));
            overlay::in_frequency(page, r, &models);
        }
    });
}

/// Rows and columns of a map.
const CELLS: usize = 7;

/// Root mean square residual by speed and load, before and after.
pub fn maps(page: &mut Report, story: &Story) {
    let parts = &story.compared.parts;
    let axis = |name: &str| -> Option<f64> {
        let values =
            parts.iter().flat_map(|p| &p.before.predictions).filter_map(|p| p.internal(name)).flatten();
        let sizes: Vec<f64> = values.map(|v| v.abs()).filter(|v| v.is_finite()).collect();
        Some(stats::quantile(&sizes, 0.99)).filter(|s| *s > 0.0)
    };
    let (Some(speed), Some(load)) = (axis(internal::SCREW_SPEED), axis(internal::SCREW_FORCE)) else {
        return;
    };
    let names = |range: f64| -> Vec<String> {
        (0..CELLS)
            .map(|i| {
                crate::diagnosis::text::figures(range * (2.0 * (i as f64 + 0.5) / CELLS as f64 - 1.0), 2)
            })
            .map(|t| t.replace('-', "−"))
            .collect()
    };
    let cell = |v: f64, range: f64| {
        (((v / range + 1.0) * 0.5 * CELLS as f64) as isize).clamp(0, CELLS as isize - 1) as usize
    };
    let rotary = parts.iter().any(|p| p.data.is_rotary(""));
    let (speed_axis, load_axis) = match rotary {
        true => (Axis::new("speed", "rad/s"), Axis::new("torque", "N m")),
        false => (Axis::new("screw speed", "m/s"), Axis::new("screw force", "N")),
    };
    let map = |title: &str, of: &dyn Fn(&Part) -> Option<Evaluation>| -> HeatMap {
        let mut sums = vec![(0.0, 0usize); CELLS * CELLS];
        for part in parts {
            let Some(at) = of(part) else { continue };
            for block in &at.blocks {
                let p = &part.before.predictions[block.run];
                let (Some(v), Some(f)) =
                    (p.internal(internal::SCREW_SPEED), p.internal(internal::SCREW_FORCE))
                else {
                    continue;
                };
                for (r, i) in block.residual.iter().zip(part.data.runs[block.run].rows()) {
                    let c = &mut sums[cell(f[i], load) * CELLS + cell(v[i], speed)];
                    *c = (c.0 + r * r, c.1 + 1);
                }
            }
        }
        HeatMap {
            title: title.to_owned(),
            x: speed_axis.clone(),
            y: load_axis.clone(),
            columns: names(speed),
            rows: names(load),
            values: sums
                .iter()
                .map(|(s, n)| if *n >= 20 { (s / *n as f64).sqrt() } else { f64::NAN })
                .collect(),
            value_label: "root mean square residual, noise units".to_owned(),
            decimals: 1,
            shades: None,
            ..HeatMap::default()
        }
    };
    let mut before = map("Before, by speed and load", &|p| Some(p.before.clone()));
    // One scale of shades for both, from the noise floor: what is gone is seen to be gone.
    let most = before.values.iter().copied().filter(|v| v.is_finite()).fold(1.0, f64::max);
    before.shades = Some((1.0, most));
    let mut maps = vec![before];
    if parts.iter().any(|p| p.after.is_some()) {
        let after = map("After, by speed and load", &|p| p.after.clone());
        maps.push(HeatMap { shades: Some((1.0, most)), ..after });
    }
    let pictures: Vec<&dyn Picture> = maps.iter().map(|m| m as &dyn Picture).collect();
    page.details("Residual by speed and load", |page| {
        page.figure_of(
            &pictures,
            "Residual of all runs and channels by predicted speed and load, shaded from the noise up; empty: no data.",
        );
    });
}

/// One slow cycle of both models, in which friction, play, slip and a spring's curve show as a loop, where an
/// effect is one of them.
pub fn law(page: &mut Report, story: &Story) {
    let Some(cycle) = &story.cycle else { return };
    let (of_spring, with_friction) = (["hysteresis", "backlash", "spring", "compliance"], ["friction"]);
    let (label, unit_across, words, tells) = match &cycle.across {
        Across::Command(input) => {
            let tells =
                "the width of the loop is what friction, play or slip take, its curvature is the spring's";
            (input.as_str(), Unit::symbol_of(input), [of_spring.as_slice(), &with_friction].concat(), tells)
        }
        Across::Deflection => {
            let metric = if cycle.output.ends_with("_nm") { "rad" } else { "m" };
            let tells =
                "a flat piece is play, the width what slip and damping take, the curvature the spring's";
            ("spring deflection", metric, of_spring.to_vec(), tells)
        }
    };
    if !story.outcome.effects.iter().any(|e| words.iter().any(|w| e.contains(w))) {
        return;
    }
    let chart = Chart::new(
        &format!("{} over {label} in one slow cycle", cycle.output),
        Axis::new(label, unit_across),
        Axis::new(&cycle.output, Unit::symbol_of(&cycle.output)),
    )
    .line(BEFORE.0, BEFORE.1, BEFORE.2, cycle.before.clone())
    .line(AFTER.0, AFTER.1, AFTER.2, cycle.after.clone());
    let caption = format!("Both models under one slow cycle of {:.0} s, simulated: {tells}.", cycle.seconds);
    page.details("One slow cycle", |page| {
        page.figure(&chart, &caption);
    });
}
