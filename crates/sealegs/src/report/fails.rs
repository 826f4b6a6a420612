//! Where a model fails: errors by channel and run as one map, and the channels that changed most as small multiples.

use super::units::{capital, error};
use crate::comparison::Part;
use crate::comparison::overlay::{Look, shown};
use sealegs_model::Unit;
use sealegs_recorder::chart::{Axis, Chart, Dash, HeatMap, Hue, Picture};
use sealegs_recorder::report::Report;
use sealegs_sysid::data::Block;
use sealegs_sysid::{Evaluation, Role, residual};

/// Small multiples that are open.
const OPEN: usize = 12;

/// Fewest of them, where there are so many channels.
const FEWEST: usize = 3;

/// Share of the greatest improvement below which a channel is not among them.
const WORTH: f64 = 0.01;

/// Rows of a run that one of them shows: what its width resolves.
const ROWS: usize = 600;

/// Share of a channel's range below which a residual is drawn by itself: a small picture is some 150 dots high, and within five
/// of them its lines lie on each other.
const COINCIDE: f64 = 0.03;

/// The two models: what they are called and how they are drawn.
pub(crate) struct Models {
    /// The first: before, or as given.
    pub before: Look,
    /// The second: after, or refitted.
    pub after: Look,
}

/// A run's name without the ending of its file.
fn short(run: &str) -> &str {
    run.rsplit_once('.').map_or(run, |(name, _)| name)
}

/// The map of errors by channel and run, before and after.
pub(crate) fn map(page: &mut Report, parts: &[Part], models: &Models) {
    let mut channels: Vec<String> = Vec::new();
    let mut runs: Vec<String> = Vec::new();
    for part in parts {
        for line in residual::table(&part.data, &part.before) {
            if !channels.contains(&line.channel) {
                channels.push(line.channel);
            }
        }
        let held_out = |role| if role == Role::Holdout { "h: " } else { "" };
        runs.extend(part.data.runs.iter().map(|r| format!("{}{}", held_out(r.role), short(&r.record.name))));
    }
    channels.reverse();
    let errors = |of: &dyn Fn(&Part) -> Option<Evaluation>| -> Vec<f64> {
        let mut values = vec![f64::NAN; channels.len() * runs.len()];
        let mut first = 0;
        for part in parts {
            if let Some(at) = of(part) {
                for (block, line) in at.blocks.iter().zip(residual::table(&part.data, &at)) {
                    let row = channels.iter().position(|c| *c == line.channel).unwrap_or(0);
                    values[row * runs.len() + first + block.run] = line.error;
                }
            }
            first += part.data.runs.len();
        }
        values
    };
    let before = errors(&|p| Some(p.before.clone()));
    let after = errors(&|p| p.after.clone());
    let most = before.iter().chain(&after).copied().filter(|v| v.is_finite()).fold(1.05, f64::max);
    let map = |title: &str, values: Vec<f64>| HeatMap {
        title: capital(title),
        x: Axis::new("run (h: held out)", ""),
        y: Axis::new("", ""),
        columns: runs.clone(),
        rows: channels.clone(),
        values,
        value_label: "error, noise units".to_owned(),
        shades: Some((1.0, most)),
        logarithmic: true,
        significant: true,
        names: true,
        row_height: Some(if channels.len() > 8 { 22.0 } else { 28.0 }),
        ..HeatMap::default()
    };
    let has_after = after.iter().any(|v| v.is_finite());
    let mut maps = vec![map(models.before.0, before)];
    if has_after {
        maps.push(map(models.after.0, after));
    }
    let pictures: Vec<&dyn Picture> = maps.iter().map(|m| m as &dyn Picture).collect();
    page.figure_beside(
        &pictures,
        "Root mean square residual of every channel and run over the channel's noise: 1 is the noise floor. One scale of \
         shades, by the logarithm, for both maps.",
    );
}

/// A run and channel with its errors.
struct Shown<'p, 'd> {
    part: &'p Part<'d>,
    run: usize,
    slot: usize,
    channel: String,
    before: f64,
    after: Option<f64>,
}

impl Shown<'_, '_> {
    /// What of the mean square the second model takes; all of it where there is none.
    fn gain(&self) -> f64 {
        self.before.powi(2) - self.after.map_or(1.0, |a| a.powi(2))
    }
}

/// Every run and channel of some runs with its errors.
fn every<'p, 'd>(part: &'p Part<'d>) -> Vec<Shown<'p, 'd>> {
    let before = residual::table(&part.data, &part.before);
    let after = part.after.as_ref().map(|at| residual::table(&part.data, at));
    let shown = |(i, (block, line)): (usize, (&Block, residual::ChannelError))| Shown {
        part,
        run: block.run,
        slot: block.slot,
        channel: line.channel,
        before: line.error,
        after: after.as_ref().and_then(|a| a.get(i)).map(|a| a.error),
    };
    part.before.blocks.iter().zip(before).enumerate().map(shown).collect()
}

/// The run of each channel in which it improved most, the most improved channel first.
fn improved<'p, 'd>(parts: &'p [Part<'d>]) -> Vec<Shown<'p, 'd>> {
    let mut best: Vec<Shown> = Vec::new();
    for part in parts {
        for shown in every(part) {
            match best.iter_mut().find(|b| b.channel == shown.channel) {
                Some(other) if shown.gain() > other.gain() => *other = shown,
                Some(_) => {}
                None => best.push(shown),
            }
        }
    }
    best.sort_by(|a, b| b.gain().total_cmp(&a.gain()));
    let least = best.first().map_or(0.0, |b| WORTH * b.gain());
    let worth = best.iter().take_while(|b| b.gain() > least).count();
    best.truncate(worth.clamp(FEWEST, OPEN));
    best
}

/// The rows of a run with the greatest residual, as many as a picture resolves.
fn window(residual: &[f64]) -> std::ops::Range<usize> {
    if residual.len() <= ROWS {
        return 0..residual.len();
    }
    let square = |i: usize| if residual[i].is_finite() { residual[i] * residual[i] } else { 0.0 };
    let mut sum: f64 = (0..ROWS).map(square).sum();
    let (mut best, mut at) = (sum, 0);
    for i in ROWS..residual.len() {
        sum += square(i) - square(i - ROWS);
        if sum > best {
            (best, at) = (sum, i + 1 - ROWS);
        }
    }
    at..at + ROWS
}

/// Measured and predicted values of a channel in the rows of a run around its largest residual.
struct Excerpt<'a> {
    time_s: &'a [f64],
    measured: &'a [f64],
    before: Vec<f64>,
    after: Option<Vec<f64>>,
}

impl<'a> Excerpt<'a> {
    fn of(s: &Shown<'a, '_>) -> Self {
        let run = &s.part.data.runs[s.run];
        let measured = run.measured[s.slot];
        let before = shown(s.part, &s.part.before, s.run, s.slot).unwrap_or_default();
        let after = s.part.after.as_ref().and_then(|at| shown(s.part, at, s.run, s.slot));
        let residual: Vec<f64> = measured.iter().zip(&before).map(|(m, p)| m - p).collect();
        let rows = window(&residual);
        let cut = |v: Vec<f64>| v[rows.start.min(v.len())..rows.end.min(v.len())].to_vec();
        Self {
            time_s: &run.record.time_s[rows.clone()],
            measured: &measured[rows.clone()],
            before: cut(before),
            after: after.map(cut),
        }
    }

    /// Measured minus predicted in the place of what was predicted.
    fn residual(&self) -> (Vec<f64>, Option<Vec<f64>>) {
        let of = |v: &Vec<f64>| self.measured.iter().zip(v).map(|(m, p)| m - p).collect::<Vec<f64>>();
        (of(&self.before), self.after.as_ref().map(of))
    }

    fn points(&self, values: &[f64]) -> Vec<(f64, f64)> {
        self.time_s.iter().copied().zip(values.iter().copied()).collect()
    }

    /// A chart with the curves of both models, or of the only one; `named` puts them into the legend.
    fn with_models(
        &self,
        chart: Chart,
        (before, after): (&[f64], Option<&[f64]>),
        models: &Models,
        named: bool,
    ) -> Chart {
        let name = |look: Look| if named { look.0 } else { "" };
        let line =
            |chart: Chart, look: Look, v: &[f64]| chart.line(name(look), look.1, look.2, self.points(v));
        let chart = line(chart, models.before, before);
        match after {
            Some(after) => line(chart, models.after, after),
            None => chart,
        }
    }
}

fn chart_over_time(s: &Shown, title: &str) -> Chart {
    Chart::new(title, Axis::new("time", "s"), Axis::new("", Unit::symbol_of(&s.channel)))
}

/// Measured and both models of a channel around its largest residual; `named` puts a legend into the picture.
fn picture(s: &Shown, excerpt: &Excerpt, models: &Models, named: bool) -> Chart {
    let run = &s.part.data.runs[s.run];
    let errors = match s.after {
        Some(after) => format!("{} → {}", error(s.before), error(after)),
        None => error(s.before),
    };
    let role = if run.role == Role::Holdout { "h: " } else { "" };
    let title = format!("{}, {role}{}: {errors}", s.channel, short(&run.record.name));
    let measured = if named { "measured" } else { "" };
    let chart =
        chart_over_time(s, &title).line(measured, Hue::Ink, Dash::Solid, excerpt.points(excerpt.measured));
    excerpt.with_models(chart, (&excerpt.before, excerpt.after.as_deref()), models, named)
}

/// What the models leave of the same rows, where it is so small that their curves lie on the measured one.
fn left(s: &Shown, excerpt: &Excerpt, models: &Models) -> Option<Chart> {
    let (before, after) = excerpt.residual();
    if !coincide(excerpt.measured, &before) {
        return None;
    }
    let run = short(&s.part.data.runs[s.run].record.name);
    let chart = chart_over_time(s, &format!("{}, {run}: measured minus predicted", s.channel));
    Some(excerpt.with_models(chart, (&before, after.as_deref()), models, false))
}

/// Whether a residual is too small to be seen beside what was measured.
fn coincide(measured: &[f64], residual: &[f64]) -> bool {
    let finite = || measured.iter().copied().filter(|v| v.is_finite());
    let range = finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
    let most = residual.iter().copied().filter(|v| v.is_finite()).fold(0.0, |p: f64, v| p.max(v.abs()));
    range > 0.0 && most < COINCIDE * range
}

/// The picture of the channel that improved most, of those at the places of effects if one of these improved; `None` where
/// nothing was compared.
pub(crate) fn foremost(parts: &[Part], models: &Models, effects: &[String]) -> Option<Chart> {
    let improved = improved(parts);
    let places: Vec<&str> =
        effects.iter().filter_map(|e| e.split_once('/')).map(|(place, _)| place).collect();
    let is_there = |s: &&Shown| s.channel.split_once('.').is_some_and(|(place, _)| places.contains(&place));
    let first = improved.iter().find(is_there).or_else(|| improved.first())?;
    Some(picture(first, &Excerpt::of(first), models, true))
}

/// The picture of the channel and run in which the second model, or the only one, is furthest off; `None` where nothing was
/// compared.
pub(crate) fn worst(part: &Part, models: &Models) -> Option<Chart> {
    let left = |s: &Shown| s.after.unwrap_or(s.before);
    let every = every(part);
    let worst = every.iter().max_by(|a, b| left(a).total_cmp(&left(b)))?;
    Some(picture(worst, &Excerpt::of(worst), models, true))
}

/// Measured and both models, a small picture for each of the channels that improved most.
pub(crate) fn multiples(page: &mut Report, parts: &[Part], models: &Models) {
    let improved = improved(parts);
    let of = |s: &Shown| {
        let excerpt = Excerpt::of(s);
        [Some(picture(s, &excerpt, models, false)), left(s, &excerpt, models)]
    };
    let charts: Vec<Chart> = improved.iter().flat_map(of).flatten().collect();
    let pictures: Vec<&dyn Picture> = charts.iter().map(|c| c as &dyn Picture).collect();
    let key = |look: Look| (look.0, look.1, look.2);
    let mut keys = vec![("measured", Hue::Ink, Dash::Solid), key(models.before)];
    let has_after = parts.iter().any(|p| p.after.is_some());
    if has_after {
        keys.push(key(models.after));
    }
    let order = if has_after { "The channels that improved most first" } else { "The worst channels first" };
    page.multiples(
        &pictures,
        &keys,
        &format!(
            "{order}, each in the run where it did, around its largest residual; above each its error in noise units{}.",
            if has_after { ", before and after" } else { "" }
        ),
    );
}

#[cfg(test)]
mod tests {
    use super::{ROWS, coincide, window};

    #[test]
    fn a_residual_that_no_eye_sees_beside_its_channel_has_a_picture_of_its_own() {
        let measured: Vec<f64> = (0..600).map(|i| (0.05 * f64::from(i)).sin()).collect();
        let of = |share: f64| measured.iter().map(|v| 2.0 * share * v).collect::<Vec<f64>>();
        // Of a range of 2.
        assert!(coincide(&measured, &of(0.02)) && !coincide(&measured, &of(0.05)));
        assert!(!coincide(&[1.0; 5], &[0.0; 5]));
    }

    #[test]
    fn a_picture_shows_the_largest_residual() {
        let mut residual = vec![0.1; 10 * ROWS];
        residual[7 * ROWS] = 5.0;
        assert!(window(&residual).contains(&(7 * ROWS)) && window(&residual).len() == ROWS);
        assert_eq!(window(&[1.0, f64::NAN]), 0..2);
    }
}
