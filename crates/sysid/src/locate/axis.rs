//! The axes along which samples are cut into regions.

use super::Region;
use crate::data::{Data, Evaluation};
use crate::stats;
use sealegs_model::internal;
use std::f64::consts::TAU;

/// An axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    Channel,
    Run,
    Speed,
    Direction,
    Load,
    Deflection,
    RotorAngle,
    Amplitude,
    SinceReversal,
    Time,
}

/// Names and limits of an axis' regions, and the sums in them.
pub(super) struct Cells {
    pub labels: Vec<String>,
    /// Inner limits between regions of a continuous axis.
    pub edges: Vec<f64>,
    count: Vec<f64>,
    squares: Vec<f64>,
}

impl Cells {
    pub fn new((labels, edges): (Vec<String>, Vec<f64>)) -> Self {
        let n = labels.len();
        Self { labels, edges, count: vec![0.0; n], squares: vec![0.0; n] }
    }

    pub fn add(&mut self, cell: usize, square: f64) {
        if let (Some(count), Some(squares)) = (self.count.get_mut(cell), self.squares.get_mut(cell)) {
            *count += 1.0;
            *squares += square;
        }
    }

    pub fn regions(self, axis: &'static str, place: &str) -> Vec<Region> {
        let (rows, total): (f64, f64) = (self.count.iter().sum(), self.squares.iter().sum());
        let mean =
            |squares: f64, count: f64| if count > 0.0 { (squares.max(0.0) / count).sqrt() } else { 0.0 };
        (0..self.labels.len())
            .filter(|&i| self.count[i] > 0.0 && self.labels.len() > 1 && total > 0.0)
            .map(|i| Region {
                axis,
                place: place.to_owned(),
                label: self.labels[i].clone(),
                sample_share: self.count[i] / rows,
                error_share: self.squares[i] / total,
                error: mean(self.squares[i], self.count[i]),
                error_elsewhere: mean(total - self.squares[i], rows - self.count[i]),
            })
            .collect()
    }
}

/// In which region a row of a run lies, given the channel, too.
type Place<'a> = Box<dyn Fn(usize, usize) -> usize + 'a>;

/// Whether forces at a place are torques, and nothing there has a screw.
pub fn is_rotary(parts: &[(&Data, &Evaluation)], at: &str) -> bool {
    parts.iter().any(|(data, _)| data.is_rotary(at))
}

impl Axis {
    pub const ALL: [Self; 10] = [
        Self::Channel,
        Self::Run,
        Self::Speed,
        Self::Direction,
        Self::Load,
        Self::Deflection,
        Self::RotorAngle,
        Self::Amplitude,
        Self::SinceReversal,
        Self::Time,
    ];

    /// Whether it is cut by signals inside an actuator; a leg has several.
    pub fn is_inside(self) -> bool {
        !matches!(self, Self::Channel | Self::Run | Self::Amplitude | Self::Time)
    }

    /// What it measures; `rotary` where nothing has a screw.
    pub fn name(self, rotary: bool) -> &'static str {
        match self {
            Self::Channel => "channel",
            Self::Run => "run",
            Self::Speed if rotary => "speed",
            Self::Speed => "screw speed",
            Self::Direction => "direction",
            Self::Load => "load",
            Self::Deflection => "spring deflection",
            Self::RotorAngle => "rotor angle",
            Self::Amplitude => "amplitude",
            Self::SinceReversal => "time since the last reversal",
            Self::Time => "time in the run",
        }
    }

    /// Labels and limits of the regions, from what the parts contain; of signals at a place.
    pub fn cells(self, at: &str, parts: &[(&Data, &Evaluation)]) -> (Vec<String>, Vec<f64>) {
        let rotary = is_rotary(parts, at);
        let unit = |linear: &str, angular: &str| if rotary { angular.to_owned() } else { linear.to_owned() };
        let peak = |name: &str| {
            let all: Vec<f64> = internals(parts, at, name).map(f64::abs).collect();
            stats::quantile(&all, 0.999)
        };
        match self {
            Self::Channel => {
                let mut names: Vec<String> = Vec::new();
                for channel in parts.iter().flat_map(|(d, _)| &d.channels) {
                    if !names.contains(&channel.name) {
                        names.push(channel.name.clone());
                    }
                }
                (names, Vec::new())
            }
            Self::Run => {
                let runs = parts.iter().flat_map(|(d, _)| &d.runs);
                (runs.map(|r| format!("{} ({})", r.record.name, r.role.as_str())).collect(), Vec::new())
            }
            Self::Speed => {
                let edges = [0.01, 0.05, 0.2, 0.5].map(|f| f * peak(internal::SCREW_SPEED)).to_vec();
                (between(&edges, &unit("m/s", "rad/s"), false), edges)
            }
            Self::Direction => {
                let standing = "standing (below 1 % of top speed)";
                let words = match rotary {
                    true => ["backward (speed negative)", standing, "forward (speed positive)"],
                    false => ["shortening (speed negative)", standing, "lengthening (speed positive)"],
                };
                let edge = 0.01 * peak(internal::SCREW_SPEED);
                (words.map(str::to_owned).to_vec(), vec![-edge, edge])
            }
            Self::Load => {
                let edges = signed(peak(internal::SCREW_FORCE).max(peak(internal::SPRING_FORCE)));
                (between(&edges, &unit("N", "N m"), true), edges)
            }
            Self::Deflection => {
                let edges = signed(peak(internal::SPRING_DEFLECTION));
                (between(&edges, &unit("m", "rad"), true), edges)
            }
            Self::RotorAngle => {
                let edges: Vec<f64> = (1..8).map(|i| f64::from(i) * TAU / 8.0).collect();
                let labels = (0..8).map(|i| format!("{} to {} degrees in the turn", 45 * i, 45 * (i + 1)));
                // Less than a turn in all says nothing about the angle in the turn.
                let turns = peak(internal::ROTOR_ANGLE) > TAU;
                (if turns { labels.collect() } else { Vec::new() }, edges)
            }
            Self::Amplitude => {
                let all: Vec<f64> =
                    parts.iter().flat_map(|(d, _)| d.runs.iter().flat_map(envelope)).collect();
                let edges: Vec<f64> = [0.1, 0.25, 0.5].map(|f| f * stats::quantile(&all, 0.999)).to_vec();
                let input = parts.iter().flat_map(|(d, _)| &d.runs).find_map(|r| r.record.inputs.first());
                let unit = input.and_then(|s| sealegs_model::Unit::of_channel(&s.channel).ok());
                (
                    between(
                        &edges,
                        &format!("{} of command (rms over half a second)", unit.map_or("", |u| u.symbol())),
                        false,
                    ),
                    edges,
                )
            }
            Self::SinceReversal => {
                let edges = vec![0.01, 0.03, 0.1, 0.3];
                (between(&edges, "s", false), edges)
            }
            Self::Time => {
                let longest = parts
                    .iter()
                    .flat_map(|(d, _)| &d.runs)
                    .filter_map(|r| r.record.time_s.last().copied())
                    .fold(0.0, f64::max);
                let edges: Vec<f64> = (1..8).map(|i| f64::from(i) * longest / 8.0).collect();
                (between(&edges, "s", true), edges)
            }
        }
    }

    /// How to place the rows of one run by signals at a place; `None` if the model has no such signal.
    pub fn place<'a>(
        self,
        site: &str,
        cells: &Cells,
        part: usize,
        data: &'a Data,
        at: &'a Evaluation,
        run: usize,
    ) -> Option<Place<'a>> {
        let inside = |name: &str| at.predictions[run].internal_at(site, name);
        let edges = cells.edges.clone();
        let find = move |v: f64| edges.partition_point(|&e| e <= v);
        let record = data.runs[run].record;
        let place: Place<'a> = match self {
            Self::Channel => {
                let names = cells.labels.clone();
                Box::new(move |_, c| {
                    names.iter().position(|n| *n == data.channels[c].name).unwrap_or(usize::MAX)
                })
            }
            Self::Run => {
                // The runs of the part before come first.
                let label = format!("{} ({})", record.name, data.runs[run].role.as_str());
                let nth = cells.labels.iter().position(|l| *l == label).unwrap_or(part);
                Box::new(move |_, _| nth)
            }
            Self::Speed => {
                let v = inside(internal::SCREW_SPEED)?;
                Box::new(move |i, _| find(v[i].abs()))
            }
            Self::Direction => {
                let v = inside(internal::SCREW_SPEED)?;
                Box::new(move |i, _| find(v[i]))
            }
            Self::Load => {
                let v = inside(internal::SCREW_FORCE).or_else(|| inside(internal::SPRING_FORCE))?;
                Box::new(move |i, _| find(v[i]))
            }
            Self::Deflection => {
                let v = inside(internal::SPRING_DEFLECTION)?;
                Box::new(move |i, _| find(v[i]))
            }
            Self::RotorAngle => {
                let v = inside(internal::ROTOR_ANGLE)?;
                Box::new(move |i, _| find(v[i].rem_euclid(TAU)))
            }
            Self::Amplitude => {
                let v = envelope(&data.runs[run]);
                if v.is_empty() {
                    return None;
                }
                Box::new(move |i, _| find(v[i]))
            }
            Self::SinceReversal => {
                let v = since_reversal(&record.time_s, inside(internal::SCREW_SPEED)?);
                Box::new(move |i, _| find(v[i]))
            }
            Self::Time => Box::new(move |i, _| find(record.time_s[i])),
        };
        Some(place)
    }
}

/// Values of an internal signal of a place at the rows that count, over all parts.
fn internals<'a>(
    parts: &'a [(&'a Data<'a>, &'a Evaluation)],
    place: &'a str,
    name: &'a str,
) -> impl Iterator<Item = f64> + 'a {
    parts.iter().flat_map(move |(data, at)| {
        data.runs.iter().zip(&at.predictions).flat_map(move |(run, prediction)| {
            prediction.internal_at(place, name).into_iter().flat_map(move |v| run.rows().map(move |i| v[i]))
        })
    })
}

fn signed(peak: f64) -> Vec<f64> {
    [-0.5, -0.1, 0.1, 0.5].map(|f| f * peak).to_vec()
}

/// `below a`, `a to b`, `above b`.
fn between(edges: &[f64], unit: &str, open_below: bool) -> Vec<String> {
    if edges.windows(2).any(|w| w[0] >= w[1]) {
        return Vec::new();
    }
    let mut labels = Vec::with_capacity(edges.len() + 1);
    for i in 0..=edges.len() {
        labels.push(match (i.checked_sub(1).map(|j| edges[j]), edges.get(i)) {
            (None, Some(b)) if open_below => format!("up to {} {unit}", digits(*b)),
            (None, Some(b)) => format!("below {} {unit}", digits(*b)),
            (Some(a), Some(b)) => format!("{} to {} {unit}", digits(a), digits(*b)),
            (Some(a), None) => format!("above {} {unit}", digits(a)),
            (None, None) => "all".to_owned(),
        });
    }
    labels
}

/// Three significant digits without a needless exponent.
fn digits(v: f64) -> String {
    let decimals = if v == 0.0 { 0 } else { (2 - v.abs().log10().floor() as i32).clamp(0, 8) };
    let text = format!("{v:.*}", decimals as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Root mean square of the input over the half second around each row.
fn envelope(run: &crate::data::DataRun) -> Vec<f64> {
    let Some(input) = run.record.inputs.first() else { return Vec::new() };
    let time = &run.record.time_s;
    let mut sums = vec![0.0];
    for v in &input.values {
        sums.push(sums[sums.len() - 1] + v * v);
    }
    let (mut from, mut to) = (0, 0);
    (0..time.len())
        .map(|i| {
            while time[from] < time[i] - 0.25 {
                from += 1;
            }
            while to < time.len() && time[to] <= time[i] + 0.25 {
                to += 1;
            }
            ((sums[to] - sums[from]).max(0.0) / (to - from) as f64).sqrt()
        })
        .collect()
}

/// Time since the speed last changed sign, s; a change counts once the speed passes a hundredth of its peak.
fn since_reversal(time_s: &[f64], speed: &[f64]) -> Vec<f64> {
    let threshold = 0.01 * speed.iter().fold(0.0f64, |p, v| p.max(v.abs()));
    let mut sign = 0.0;
    let mut since = f64::NEG_INFINITY;
    let mut crossed = 0.0;
    (0..speed.len())
        .map(|i| {
            if i > 0 && speed[i] * speed[i - 1] <= 0.0 {
                crossed = time_s[i];
            }
            if speed[i].abs() > threshold && speed[i].signum() != sign {
                if sign != 0.0 {
                    since = crossed;
                }
                sign = speed[i].signum();
            }
            time_s[i] - since
        })
        .collect()
}
