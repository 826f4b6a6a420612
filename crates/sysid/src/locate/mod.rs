//! Where the residual is: by channel, run, speed, direction, load, deflection, rotor angle, amplitude,
//! time since the last reversal, time in the run, and frequency band; on a leg, by each actuator's.
//!
//! Each axis cuts the samples into regions. A region with a share of the squared error that is much larger
//! than its share of the samples is where the model fails; the worst few become plain sentences.

mod axis;
mod band;
mod remainder;

pub use remainder::remainder;

use crate::data::{Data, Evaluation};
use axis::{Axis, Cells, is_rotary};

/// A part of the samples (or of the spectrum) and how much of the error lies in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// What the axis measures, for example `screw speed`.
    pub axis: &'static str,
    /// At which actuator of a leg; empty on a bench, and for what is no actuator's.
    pub place: String,
    /// Which part, for example `below 0.8 mm/s`.
    pub label: String,
    /// Share of the samples; of the bandwidth for a frequency band.
    pub sample_share: f64,
    /// Share of the squared residual.
    pub error_share: f64,
    /// Root mean square residual inside, in noise units.
    pub error: f64,
    /// The same outside.
    pub error_elsewhere: f64,
}

impl Region {
    /// Error share beyond what a residual that is everywhere alike would have.
    #[must_use]
    pub fn excess(&self) -> f64 {
        self.error_share - self.sample_share
    }

    /// What the axis measures, and where: `screw speed`, `screw speed of knee`.
    #[must_use]
    pub fn subject(&self) -> String {
        if self.place.is_empty() { self.axis.to_owned() } else { format!("{} of {}", self.axis, self.place) }
    }

    /// The region as a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let of = if self.axis == "frequency" { "bandwidth" } else { "samples" };
        let share = match 100.0 * self.sample_share {
            percent if percent < 0.5 => "less than 1".to_owned(),
            percent => format!("{percent:.0}"),
        };
        format!(
            "{:.0} % of the squared error is in {share} % of the {of}: {} {} (error {} noise units there, {} elsewhere).",
            100.0 * self.error_share,
            self.subject(),
            self.label,
            short(self.error),
            short(self.error_elsewhere),
        )
    }
}

/// The residual's place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Location {
    /// All regions of all axes, in the order of the axes.
    pub regions: Vec<Region>,
    /// Root mean square residual, noise units.
    pub error: f64,
}

impl Location {
    /// A region must have at least this much more of the error than of the samples to be worth a sentence.
    const LEAST_EXCESS: f64 = 0.08;

    /// Root mean square residual, in noise units, below which there is nothing to locate.
    const NOTHING_LEFT: f64 = 1.05;

    /// The worst regions, at most one of each axis and `most` in all, the worst first; none where the
    /// residual is at the noise floor.
    #[must_use]
    pub fn worst(&self, most: usize) -> Vec<&Region> {
        if self.error < Self::NOTHING_LEFT {
            return Vec::new();
        }
        let mut found: Vec<&Region> =
            self.regions.iter().filter(|r| r.excess() > Self::LEAST_EXCESS && r.sample_share > 0.0).collect();
        // How surprising: the information between the two shares, in favour of small regions with much error.
        let weight = |r: &Region| r.error_share * (r.error_share / r.sample_share).ln();
        found.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
        let mut worst: Vec<&Region> = Vec::new();
        for region in found {
            if worst.len() < most && worst.iter().all(|w| w.axis != region.axis) {
                worst.push(region);
            }
        }
        worst
    }
}

/// Locates the residual of one or several evaluations (fitted runs, held-out runs) together.
#[must_use]
pub fn locate(parts: &[(&Data, &Evaluation)]) -> Location {
    let mut regions = Vec::new();
    let sites = places(parts);
    for axis in Axis::ALL {
        for site in if axis.is_inside() { &sites[..] } else { &[""] } {
            let mut cells = Cells::new(axis.cells(site, parts));
            for (part, (data, at)) in parts.iter().enumerate() {
                for run in 0..data.runs.len() {
                    let Some(place) = axis.place(site, &cells, part, data, at, run) else { continue };
                    for block in at.blocks.iter().filter(|b| b.run == run) {
                        for (r, i) in block.residual.iter().zip(data.runs[run].rows()) {
                            cells.add(place(i, block.channel), r * r);
                        }
                    }
                }
            }
            regions.extend(cells.regions(axis.name(is_rotary(parts, site)), site));
        }
    }
    regions.extend(band::regions(parts));
    let evaluations: Vec<&Evaluation> = parts.iter().map(|(_, e)| *e).collect();
    Location { regions, error: crate::residual::pooled(&evaluations) }
}

/// The places of the predictions' internal signals: one without a name on a bench, the actuators of a leg.
pub(crate) fn places<'a>(parts: &[(&Data, &'a Evaluation)]) -> Vec<&'a str> {
    parts.iter().find_map(|(_, at)| at.predictions.first()).map_or_else(Vec::new, |p| p.places())
}

/// Three significant digits.
pub(crate) fn short(value: f64) -> String {
    match value.abs() {
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

#[cfg(test)]
mod tests;
