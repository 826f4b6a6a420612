//! A small library of excitations, from slow ramps to chirps, that each bring out another kind of effect.

use std::f64::consts::{PI, TAU};

/// What an excitation has to keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Excite {
    /// Greatest distance from the centre, in the input's unit.
    pub amplitude: f64,
    /// About what it swings.
    pub centre: f64,
    /// Its duration, s.
    pub duration_s: f64,
    /// The sampling period, s.
    pub period_s: f64,
}

/// Rest at the beginning, s: zeros of the sensors are seen there.
const REST_S: f64 = 0.5;

impl Excite {
    /// Samples of a shape between -1 and 1 that is a function of the time since the rest and of the time
    /// that is left for it.
    fn sampled(&self, shape: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let count = (self.duration_s / self.period_s).round() as usize + 1;
        let busy = self.duration_s - REST_S;
        (0..count)
            .map(|i| {
                let t = i as f64 * self.period_s - REST_S;
                let x = if t < 0.0 { 0.0 } else { shape(t, busy).clamp(-1.0, 1.0) };
                self.centre + self.amplitude * x
            })
            .collect()
    }

    /// The amplitude's share as printed.
    fn about(&self, share: f64) -> String {
        let swing = format!("±{}", short(share * self.amplitude));
        if self.centre == 0.0 { swing } else { format!("{} {swing}", short(self.centre)) }
    }

    fn nyquist_hz(&self) -> f64 {
        0.5 / self.period_s
    }
}

/// Every excitation with its description, always in the same order.
pub(super) fn library(rig: &Excite) -> Vec<(String, Vec<f64>)> {
    let busy = rig.duration_s - REST_S;
    let top = 0.25 * rig.nyquist_hz();
    let mut all: Vec<(String, Vec<f64>)> = Vec::new();
    for share in [1.0, 0.3] {
        all.push((
            format!("slow ramps of {} with reversals, {} s a cycle", rig.about(share), short(busy / 3.0)),
            rig.sampled(|t, busy| share * triangle(3.0 * t / busy)),
        ));
    }
    all.push((
        format!("slow ramps with reversals inside reversals, shrinking from {}", rig.about(1.0)),
        rig.sampled(|t, busy| (1.0 - 0.8 * t / busy) * triangle(5.0 * t / busy)),
    ));
    all.push((
        format!("a staircase of 16 levels up and down within {}", rig.about(1.0)),
        rig.sampled(|t, busy| triangle(((32.0 * t / busy).floor() + 0.5) / 32.0)),
    ));
    for share in [1.0, 0.4] {
        all.push((
            format!("single steps of {} with {} s between them", rig.about(share), short(busy / 8.0)),
            rig.sampled(|t, busy| {
                share * [1.0, 0.0, -1.0, 0.0, 0.5, -0.5, 1.0, 0.0][((8.0 * t / busy) as usize).min(7)]
            }),
        ));
    }
    for frequency in spread(2.0 / busy, top, 5) {
        all.push((
            format!("sine bursts of {} at {} Hz with pauses", rig.about(1.0), short(frequency)),
            rig.sampled(|t, busy| {
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
            rig.sampled(|t, busy| share * chirp(t, busy, 1.0 / busy, top)),
        ));
    }
    for (share, band) in [(1.0, top), (1.0, 0.1 * top), (0.3, top)] {
        let lines = multisine(busy, band);
        all.push((
            format!("noise within {} up to {} Hz", rig.about(share), short(band)),
            rig.sampled(|t, _| {
                share * lines.iter().map(|(a, f, phase)| a * (TAU * f * t + phase).cos()).sum::<f64>()
            }),
        ));
    }
    all.push((
        format!(
            "a dither of {} at {} Hz on slow ramps of {}",
            rig.about(0.1),
            short(0.2 * top),
            rig.about(0.9)
        ),
        rig.sampled(|t, busy| 0.9 * triangle(2.0 * t / busy) + 0.1 * (TAU * 0.2 * top * t).sin()),
    ));
    all.push((
        format!("slow sines growing from {} to {}", rig.about(0.02), rig.about(1.0)),
        rig.sampled(|t, busy| 50f64.powf(t / busy - 1.0) * (TAU * 12.0 * t / busy).sin()),
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

/// Equal lines up to a band with quadratic (Schroeder) phases, which keep the crest low; amplitude,
/// frequency and phase of each, scaled so that the sum stays within one.
fn multisine(busy: f64, band_hz: f64) -> Vec<(f64, f64, f64)> {
    const LINES: usize = 48;
    let lines: Vec<(f64, f64)> = (0..LINES)
        .map(|k| {
            // Not quite evenly: equal distances would repeat themselves.
            let f = band_hz * ((k as f64 + 0.5 + 0.31 * (2.4 * k as f64).sin()) / LINES as f64);
            (f.max(1.0 / busy), -PI * (k * (k + 1)) as f64 / LINES as f64)
        })
        .collect();
    let root = (LINES as f64).sqrt();
    // A crest of 3 is cut off rarely.
    lines.into_iter().map(|(f, phase)| (2f64.sqrt() / (3.0 * root), f, phase)).collect()
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

    #[test]
    fn every_excitation_keeps_to_the_limits_and_begins_at_rest() {
        let rig = Excite { amplitude: 3.0, centre: 1.0, duration_s: 5.0, period_s: 1e-3 };
        let all = library(&rig);
        assert!(all.len() > 12);
        for (description, values) in all {
            assert_eq!(values.len(), 5001, "{description}");
            assert!(values[..400].iter().all(|v| *v == 1.0), "{description}");
            assert!(values.iter().all(|v| (-2.0 - 1e-12..=4.0 + 1e-12).contains(v)), "{description}");
            let swing = values.iter().fold(0.0f64, |m, v| m.max((v - 1.0).abs()));
            assert!(swing > 0.1, "{description}: {swing}");
        }
    }

    #[test]
    fn analytic_shapes() {
        assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(triangle), [0.0, 1.0, 0.0, -1.0, 0.0]);
        assert_eq!((short(0.01234), short(250.0), short(2.5)), ("0.0123".into(), "250".into(), "2.5".into()));
    }
}
