//! A small library of excitations, from slow ramps to chirps, that each bring out another kind of effect.
//!
//! Every sample of every one of them is inside the bounds that its description states: a rig is driven with it.

use std::f64::consts::{PI, TAU};

/// What an excitation has to keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Excite {
    /// Greatest distance from the centre, in the input's unit.
    pub amplitude: f64,
    /// About what it swings.
    pub centre: f64,
    /// Its duration, s.
    pub duration_s: f64,
    /// The sampling period, s.
    pub period_s: f64,
    /// The input's unit as printed.
    pub unit: &'static str,
}

/// Rest at the beginning, s: zeros of the sensors are seen there.
const REST_S: f64 = 0.5;

impl Excite {
    /// The same with a centre of three digits, as it is printed, and no greater reach on either side.
    fn printed(&self) -> Self {
        let centre = rounded(self.centre, f64::round);
        Self { centre, amplitude: (self.amplitude - (centre - self.centre).abs()).max(0.0), ..*self }
    }

    /// The share of the amplitude that is printed, and kept: three digits, never more than the amplitude has.
    fn bound(&self, share: f64) -> f64 {
        rounded(share * self.amplitude, f64::floor)
    }

    /// Samples within a share of the amplitude, of a shape between -1 and 1 that is a function of the time since the rest
    /// and of the time that is left for it.
    fn sampled(&self, share: f64, shape: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let busy = self.duration_s - REST_S;
        let bound = self.bound(share);
        self.played(|t| bound * shape(t, busy).clamp(-1.0, 1.0))
    }

    /// Samples of a swing about the centre, a function of the time since the rest.
    fn played(&self, swing: impl Fn(f64) -> f64) -> Vec<f64> {
        self.times().map(|t| self.centre + if t < 0.0 { 0.0 } else { swing(t) }).collect()
    }

    /// Samples within a share of the amplitude, of a shape that has its own crest: the greatest sample touches the bound.
    fn scaled(&self, share: f64, shape: impl Fn(f64) -> f64) -> Vec<f64> {
        let values: Vec<f64> = self.times().map(|t| if t < 0.0 { 0.0 } else { shape(t) }).collect();
        let crest = values.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
        let bound = self.bound(share);
        values.into_iter().map(|v| self.centre + bound * (v / crest).clamp(-1.0, 1.0)).collect()
    }

    /// The time of each sample since the end of the rest, s.
    fn times(&self) -> impl Iterator<Item = f64> {
        let count = (self.duration_s / self.period_s).round() as usize + 1;
        let period_s = self.period_s;
        (0..count).map(move |i| i as f64 * period_s - REST_S)
    }

    /// The amplitude's share as printed, with the input's unit.
    fn about(&self, share: f64) -> String {
        let swing = format!("±{} {}", short(self.bound(share)), self.unit);
        let swing = swing.trim_end();
        if self.centre == 0.0 { swing.to_owned() } else { format!("{} {swing}", short(self.centre)) }
    }

    fn nyquist_hz(&self) -> f64 {
        0.5 / self.period_s
    }
}

/// Every excitation with its description, always in the same order.
pub(crate) fn library(rig: &Excite) -> Vec<(String, Vec<f64>)> {
    let rig = rig.printed();
    let busy = rig.duration_s - REST_S;
    let top = 0.25 * rig.nyquist_hz();
    let mut all: Vec<(String, Vec<f64>)> = Vec::new();
    for share in [1.0, 0.3] {
        all.push((
            format!("slow ramps of {} with reversals, {} s a cycle", rig.about(share), short(busy / 3.0)),
            rig.sampled(share, |t, busy| triangle(3.0 * t / busy)),
        ));
    }
    all.push((
        format!("slow ramps with reversals inside reversals, shrinking from {}", rig.about(1.0)),
        rig.sampled(1.0, |t, busy| (1.0 - 0.8 * t / busy) * triangle(5.0 * t / busy)),
    ));
    all.push((
        format!("a staircase of 16 levels up and down within {}", rig.about(1.0)),
        rig.sampled(1.0, |t, busy| triangle(((32.0 * t / busy).floor() + 0.5) / 32.0)),
    ));
    for share in [1.0, 0.4] {
        all.push((
            format!("single steps of {} with {} s between them", rig.about(share), short(busy / 8.0)),
            rig.sampled(share, |t, busy| {
                [1.0, 0.0, -1.0, 0.0, 0.5, -0.5, 1.0, 0.0][((8.0 * t / busy) as usize).min(7)]
            }),
        ));
    }
    for frequency in spread(2.0 / busy, top, 5) {
        all.push((
            format!("sine bursts of {} at {} Hz with pauses", rig.about(1.0), short(frequency)),
            rig.sampled(1.0, |t, busy| {
                // Each burst has whole periods, so that it ends where it began.
                let cycles = (frequency * busy / 6.0).floor().max(1.0);
                let within = t % (busy / 3.0);
                if within < cycles / frequency { (TAU * frequency * within).sin() } else { 0.0 }
            }),
        ));
    }
    for share in [1.0, 0.3, 0.05] {
        all.push((
            format!(
                "a logarithmic chirp of {} from {} to {} Hz",
                rig.about(share),
                short(1.0 / busy),
                short(top)
            ),
            rig.sampled(share, |t, busy| chirp(t, busy, 1.0 / busy, top)),
        ));
    }
    for (share, band) in [(1.0, top), (1.0, 0.1 * top), (0.3, top)] {
        let lines = multisine(busy, band);
        all.push((
            format!("noise within {} up to {} Hz", rig.about(share), short(band)),
            rig.scaled(share, |t| lines.iter().map(|(f, phase)| (TAU * f * t + phase).cos()).sum::<f64>()),
        ));
    }
    all.push((
        format!(
            "a dither of {} at {} Hz on slow ramps of {}",
            rig.about(0.1),
            short(0.2 * top),
            rig.about(0.9)
        ),
        {
            let (slow, quick) = (rig.bound(0.9), rig.bound(0.1));
            rig.played(|t| slow * triangle(2.0 * t / busy) + quick * (TAU * 0.2 * top * t).sin())
        },
    ));
    all.push((
        format!("slow sines growing from {} to {}", rig.about(0.02), rig.about(1.0)),
        rig.sampled(1.0, |t, busy| 50f64.powf(t / busy - 1.0) * (TAU * 12.0 * t / busy).sin()),
    ));
    all
}

/// 0, 1, 0, -1, 0 over one cycle, by straight lines.
fn triangle(cycles: f64) -> f64 {
    let x = cycles.rem_euclid(1.0);
    match x {
        x if x < 0.25 => 4.0 * x,
        x if x < 0.75 => 2.0 - 4.0 * x,
        x => 4.0 * x - 4.0,
    }
}

fn chirp(t: f64, busy: f64, from_hz: f64, to_hz: f64) -> f64 {
    let rate = (to_hz / from_hz).ln() / busy;
    (TAU * from_hz * (rate * t).exp_m1() / rate).sin()
}

/// Frequencies evenly in ratio.
fn spread(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| from * (to / from).powf((i as f64 + 0.5) / count as f64)).collect()
}

/// Equal lines up to a band with quadratic (Schroeder) phases, which keep the crest low: frequency and phase of each.
fn multisine(busy: f64, band_hz: f64) -> Vec<(f64, f64)> {
    const LINES: usize = 48;
    (0..LINES)
        .map(|k| {
            // Not quite evenly: equal distances would repeat themselves.
            let f = band_hz * ((k as f64 + 0.5 + 0.31 * (2.4 * k as f64).sin()) / LINES as f64);
            (f.max(1.0 / busy), -PI * (k * (k + 1)) as f64 / LINES as f64)
        })
        .collect()
}

/// A number with three significant digits, by a way of rounding.
fn rounded(value: f64, way: fn(f64) -> f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let unit = 10f64.powi(value.abs().log10().floor() as i32 - 2);
    // 2.4 is 239.999... hundredths.
    way(value / unit * (1.0 + 1e-12)) * unit
}

/// Three significant digits at most.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Centre and greatest swing as a description states them.
    fn stated(description: &str) -> (f64, f64) {
        let number = |text: &str| text.trim().parse::<f64>().unwrap_or_else(|_| panic!("{description}"));
        let swings = description.split('±').skip(1).map(|rest| rest.split_whitespace().next().unwrap());
        // A dither rides on ramps: their bounds add up.
        let dither = description.contains("dither");
        let swing = swings.map(number).fold(0.0, |a: f64, b| if dither { a + b } else { a.max(b) });
        let before = description.split('±').next().unwrap().split_whitespace().last().unwrap();
        (before.parse().unwrap_or(0.0), swing)
    }

    #[test]
    fn every_excitation_is_inside_its_stated_bounds_sample_by_sample_and_begins_at_rest() {
        for (amplitude, centre) in
            [(3.0, 1.0), (4.4449, 0.0), (1.335_49, 0.0), (0.0123, 0.987_654), (987.6, -2345.6)]
        {
            let rig = Excite { amplitude, centre, duration_s: 5.0, period_s: 1e-3, unit: "A" };
            let all = library(&rig);
            assert!(all.len() > 12);
            for (description, values) in all {
                assert!(description.contains(" A"), "{description}");
                assert_eq!(values.len(), 5001, "{description}");
                let (about, swing) = stated(&description);
                assert!(values[..400].iter().all(|v| *v == about), "{description}: {}", values[0]);
                let most = values.iter().fold(0.0f64, |m, v| m.max((v - about).abs()));
                assert!(most <= swing * (1.0 + 1e-9), "{description} reaches {most}");
                assert!(most > 0.85 * swing, "{description} uses {most} only");
                // And inside what the rig has borne, whatever is printed.
                let beyond = values.iter().fold(0.0f64, |m, v| m.max((v - centre).abs()));
                assert!(beyond <= amplitude * (1.0 + 1e-9), "{description} reaches {beyond} from {centre}");
            }
        }
    }

    #[test]
    fn analytic_shapes() {
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(triangle), [0.0, 1.0, 0.0, -1.0, 0.0]);
        assert_eq!([rounded(1.3359, f64::floor), rounded(-0.9876, f64::round)], [1.33, -0.988]);
        assert_eq!((short(0.01234), short(250.0), short(2.5)), ("0.0123".into(), "250".into(), "2.5".into()));
    }
}
