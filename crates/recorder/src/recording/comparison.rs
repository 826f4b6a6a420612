//! Measured and predicted channels side by side in one recording.
//!
//! Paths are `<run>/<channel>/measured`, `before`, `after`, `residual_before` and `residual_after`, the models' before the
//! measured one in the alphabet, by which the viewer draws them one over the other: one recording, because two do not share a time cursor.

use super::Color;
use super::entities::{refused, time_column};
use super::layout::{self, Part, View};
use super::paths::{self, COMPLETE, DOCUMENTS, TIMELINE};
use super::rerun::{self, EntityPath};
use super::scene_view::plot;
use super::stream::Stream;
use super::writer::{Output, close, open};
use crate::RecorderError;
use crate::chart::{decimate, straightened};
use std::collections::BTreeSet;

/// Values that are sent at once.
const CHUNK: usize = 4096;
/// Straight lines between the kept values of a model stay within this share of the noise.
const STRAIGHT: f64 = 1.0 / 2.0;
/// Residuals are thinned to an eighth: of thirty-two neighbours the ends, the least and the greatest stay.
const THINNED: usize = 8;
/// Computed values are rounded to a power of two below this share of the noise.
const ROUNDED: f64 = 1.0 / 64.0;
/// Channels whose plots fit one below the other.
const IN_ONE_COLUMN: usize = 6;
/// The tab of channels of no place, beside those of a leg.
const ELSEWHERE: &str = "other";
/// What stands beside `measured`, with its colour and width: the same as in the reports.
const MEASURED: (&str, Color, f32) = ("measured", Color::new(0xE8, 0xEA, 0xED), 1.2);
const BEFORE: (&str, Color, f32) = ("before", Color::ORANGE, 2.5);
const AFTER: (&str, Color, f32) = ("after", Color::SKY_BLUE, 2.5);
const RESIDUAL_BEFORE: (&str, Color, f32) = ("residual_before", Color::ORANGE, 1.2);
const RESIDUAL_AFTER: (&str, Color, f32) = ("residual_after", Color::SKY_BLUE, 1.2);

/// Runs with what was measured, what the model said before and what it says after.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// The recording's name, for example the campaign's.
    pub name: String,
    /// The runs.
    pub runs: Vec<ComparedRun>,
    /// The verdict and what led to it, Markdown.
    pub summary_markdown: String,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparedRun {
    /// Unique name, for example `run-03 (holdout)`.
    pub name: String,
    /// Time stamps, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// The channels, each with one value per time stamp.
    pub channels: Vec<ComparedChannel>,
}

/// One channel of a run. A value that is missing is NaN and leaves a gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparedChannel {
    /// The channel with its unit as suffix, for example `force_1_n`; unique in its run.
    pub name: String,
    /// Unit as printed, for example `N`.
    pub unit: String,
    /// Measured values; empty for a channel that was not measured.
    pub measured: Vec<f64>,
    /// The model before, if it predicts this channel. Its residual, measured minus this, is added.
    pub before: Option<Vec<f64>>,
    /// The model after, if there is one. Its residual is added.
    pub after: Option<Vec<f64>>,
    /// One standard deviation of the sensor's noise. What is computed is then written as finely as that allows to see and no
    /// finer, which makes the file a fraction; 0 writes every value.
    pub noise: f64,
}

impl Comparison {
    /// Writes the recording, or shows it live.
    ///
    /// # Errors
    ///
    /// [`RecorderError::Mismatch`] if a channel is not as long as its run, [`RecorderError::Duplicate`] if
    /// two runs or channels have one name, otherwise as for a run's recording.
    pub fn write(&self, output: &Output) -> Result<(), RecorderError> {
        self.check()?;
        let (mut stream, file) = open(output, "sealegs", &self.name)?;
        layout::send(&mut stream, TIMELINE, &self.layout())?;
        let summary = rerun::TextDocument::from_markdown(self.summary_markdown.as_str());
        stream.log_static(summary_path(), &summary)?;
        for run in &self.runs {
            for channel in &run.channels {
                for (what, values) in channel.curves() {
                    let points: Vec<(f64, f64)> = run.time_s.iter().copied().zip(values).collect();
                    send(&mut stream, run, channel, what, &channel.as_fine_as_seen(what, points))?;
                }
            }
        }
        close(stream, file.as_deref(), COMPLETE)
    }

    fn check(&self) -> Result<(), RecorderError> {
        let mut seen = BTreeSet::from([paths::path([DOCUMENTS, "x"]).to_string()]);
        for run in &self.runs {
            for channel in &run.channels {
                let path = paths::path([run.name.as_str(), &channel.name]).to_string();
                let expected = run.time_s.len();
                let curves = [
                    Some(&channel.measured).filter(|m| !m.is_empty()),
                    channel.before.as_ref(),
                    channel.after.as_ref(),
                ];
                if let Some(found) = curves.iter().flatten().map(|c| c.len()).find(|n| *n != expected) {
                    return Err(RecorderError::Mismatch {
                        what: format!("values of {path}"),
                        expected,
                        found,
                    });
                }
                if !seen.insert(path.clone()) {
                    return Err(RecorderError::Duplicate { path });
                }
            }
            if let Some(pair) = run.time_s.windows(2).find(|w| w[0] >= w[1] || w[0].is_nan() || w[1].is_nan())
            {
                return Err(RecorderError::TimeOrder { time_s: pair[1], previous_s: pair[0] });
            }
        }
        Ok(())
    }

    /// The summary first, then a tab for each run.
    fn layout(&self) -> Part {
        let summary = View::new("TextDocument", "Summary", summary_path()).showing([summary_path()]);
        let mut pages = vec![("Summary".to_owned(), Part::View(summary))];
        for run in &self.runs {
            pages.push((run.name.clone(), run.page()));
        }
        if self.runs.is_empty() {
            return Part::Tabs(pages);
        }
        let summary = pages.remove(0).1;
        Part::Row(vec![(0.3, summary), (0.7, Part::Tabs(pages))])
    }
}

impl ComparedRun {
    /// All channels in one column; of a leg, whose many would be a line high each, a tab for each place.
    fn page(&self) -> Part {
        if self.channels.len() <= IN_ONE_COLUMN {
            return self.column(&self.channels.iter().collect::<Vec<_>>());
        }
        let mut places: Vec<(&str, Vec<&ComparedChannel>)> = Vec::new();
        for channel in &self.channels {
            let place = channel.name.split_once('.').map_or(ELSEWHERE, |(place, _)| place);
            match places.iter_mut().find(|(name, _)| *name == place) {
                Some((_, channels)) => channels.push(channel),
                None => places.push((place, vec![channel])),
            }
        }
        Part::Tabs(
            places.iter().map(|(name, channels)| ((*name).to_owned(), self.column(channels))).collect(),
        )
    }

    /// Each channel overlaid, its residuals below.
    fn column(&self, channels: &[&ComparedChannel]) -> Part {
        let mut plots = Vec::new();
        for channel in channels {
            let of = |names: &[&str]| {
                names
                    .iter()
                    .filter(|n| channel.curves().iter().any(|(what, _)| what.0 == **n))
                    .map(|n| paths::path([self.name.as_str(), &channel.name, n]))
                    .collect::<Vec<_>>()
            };
            let title = format!("{} [{}]", channel.name, channel.unit);
            let overlay = of(&[MEASURED.0, BEFORE.0, AFTER.0]);
            plots.push((2.0, Part::View(plot(title.clone(), overlay))));
            let residuals = of(&[RESIDUAL_BEFORE.0, RESIDUAL_AFTER.0]);
            if !residuals.is_empty() {
                let title = format!("residual (measured - model) of {title}");
                plots.push((1.0, Part::View(plot(title, residuals))));
            }
        }
        Part::Column(plots)
    }
}

type Curve = (&'static str, Color, f32);

impl ComparedChannel {
    /// Everything that is drawn of the channel.
    fn curves(&self) -> Vec<(Curve, Vec<f64>)> {
        let mut curves = Vec::new();
        if !self.measured.is_empty() {
            curves.push((MEASURED, self.measured.clone()));
        }
        for (model, curve, residual) in
            [(&self.before, BEFORE, RESIDUAL_BEFORE), (&self.after, AFTER, RESIDUAL_AFTER)]
        {
            if let Some(model) = model {
                curves.push((curve, model.clone()));
                if !self.measured.is_empty() {
                    let difference = self.measured.iter().zip(model).map(|(m, p)| m - p).collect();
                    curves.push((residual, difference));
                }
            }
        }
        curves
    }
}

impl ComparedChannel {
    /// The points of a curve that its noise allows to see: all that were measured, a model between straight lines, the
    /// extremes of a residual.
    fn as_fine_as_seen(&self, (what, ..): Curve, points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
        if what == MEASURED.0 || self.noise.is_nan() || self.noise <= 0.0 {
            return points;
        }
        let kept = if [BEFORE.0, AFTER.0].contains(&what) {
            straightened(&points, STRAIGHT * self.noise)
        } else {
            decimate(&points, points.len() / THINNED)
        };
        let step = (ROUNDED * self.noise).log2().floor().exp2();
        kept.into_iter().map(|(t, v)| (t, (v / step).round() * step)).collect()
    }
}

fn summary_path() -> EntityPath {
    paths::path([DOCUMENTS, "Summary"])
}

fn send(
    stream: &mut Stream,
    run: &ComparedRun,
    channel: &ComparedChannel,
    (what, color, width): Curve,
    points: &[(f64, f64)],
) -> Result<(), RecorderError> {
    let path = paths::path([run.name.as_str(), &channel.name, what]);
    let style = rerun::SeriesLines::new()
        .with_names([format!("{what} [{}]", channel.unit)])
        .with_colors([rerun::Color::from(color)])
        .with_widths([width]);
    stream.log_static(path.clone(), &style)?;
    for points in points.chunks(CHUNK) {
        let time_s: Vec<f64> = points.iter().map(|(t, _)| *t).collect();
        let columns =
            rerun::Scalars::new(points.iter().map(|(_, v)| *v)).columns_of_unit_batches().map_err(refused)?;
        stream.send_columns(path.clone(), time_column(&time_s), columns)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(names: &[&str]) -> ComparedRun {
        let channel = |name: &&str| ComparedChannel {
            name: (*name).to_owned(),
            measured: vec![0.0],
            ..ComparedChannel::default()
        };
        ComparedRun { name: "run".into(), time_s: vec![0.0], channels: names.iter().map(channel).collect() }
    }

    #[test]
    fn a_legs_many_channels_have_a_tab_for_each_place() {
        let few = run(&["force_1_n", "force_2_n", "motor_angle_rad"]).page();
        assert!(matches!(&few, Part::Column(plots) if plots.len() == 3), "{few:?}");
        let many = ["knee.angle_rad", "base.height_m", "foot.normal_force_n", "current_a"];
        let knee = ["knee.force_1_n", "knee.force_2_n", "knee.current_a"];
        let Part::Tabs(tabs) = run(&[&many[..], &knee].concat()).page() else { panic!("no tabs") };
        let shown: Vec<(&str, usize)> = tabs
            .iter()
            .map(|(name, part)| (name.as_str(), if let Part::Column(plots) = part { plots.len() } else { 0 }))
            .collect();
        assert_eq!(shown, [("knee", 4), ("base", 1), ("foot", 1), (ELSEWHERE, 1)]);
    }
}
