//! How a run was driven: band, amplitude, speed, load, reversals.

use crate::{resample, stats};
use realfft::RealFftPlanner;
use sealegs_model::{InputHold, Prediction, Record, internal};
use std::ops::Range;

/// What a run excites. Speed and load are the nominal model's, in m/s and N or, for a rotary actuator,
/// rad/s and N m.
#[derive(Debug, Clone, PartialEq)]
pub struct Excited {
    /// The run's name.
    pub run: String,
    /// The input column; empty if there is none.
    pub input: String,
    /// Greatest magnitude of the input.
    pub input_peak: f64,
    /// Root mean square of the input.
    pub input_rms: f64,
    /// Band that holds the middle 90 % of the input's power about its mean, Hz.
    pub band_hz: Option<(f64, f64)>,
    /// Greatest speed of the screw.
    pub speed_peak: Option<f64>,
    /// Share of samples below 1 % of that speed.
    pub standing_share: Option<f64>,
    /// Greatest force in the screw.
    pub load_peak: Option<f64>,
    /// Reversals of the screw's motion.
    pub reversals: usize,
    /// Turns of the rotor from end to end.
    pub rotor_turns: Option<f64>,
    /// Rows at the start during which the command does not change.
    pub quiet_rows: usize,
}

/// Looks at the rows that count of one run, with its prediction.
#[must_use]
pub fn of_run(record: &Record, scored: Range<usize>, prediction: &Prediction) -> Excited {
    let input = record.inputs.first();
    let part: &[f64] = input.map_or(&[], |s| &s.values[scored.clone()]);
    let internal = |name: &str| prediction.internal(name).map(|v| &v[scored.clone()]);
    let peak = |v: &[f64]| v.iter().fold(0.0f64, |p, x| p.max(x.abs()));
    let speed = internal(internal::SCREW_SPEED);
    let top = speed.map(peak);
    let turns = internal(internal::ROTOR_ANGLE).map(|v| {
        let (a, b) = v.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        (b - a) / std::f64::consts::TAU
    });
    Excited {
        run: record.name.clone(),
        input: input.map_or_else(String::new, |s| s.channel.clone()),
        input_peak: peak(part),
        input_rms: stats::rms(part),
        band_hz: input
            .and_then(|_| band(&record.time_s[scored.clone()], part, record.hold == InputHold::ZeroOrder)),
        speed_peak: top,
        standing_share: speed
            .zip(top)
            .map(|(v, top)| v.iter().filter(|x| x.abs() < 0.01 * top).count() as f64 / v.len().max(1) as f64),
        load_peak: internal(internal::SCREW_FORCE).map(peak),
        reversals: speed.zip(top).map_or(0, |(v, top)| reversals(v, 0.01 * top)),
        rotor_turns: turns,
        quiet_rows: input.map_or(0, |s| {
            let first = s.values.first().copied().unwrap_or(0.0);
            s.values.iter().take_while(|&&u| u == first).count()
        }),
    }
}

/// Sign changes of the speed that pass a threshold on both sides.
fn reversals(speed: &[f64], threshold: f64) -> usize {
    let mut sign = 0.0;
    let mut count = 0;
    for v in speed.iter().filter(|v| v.abs() > threshold) {
        if sign != 0.0 && v.signum() != sign {
            count += 1;
        }
        sign = v.signum();
    }
    count
}

/// Frequencies below which 5 % and 95 % of the power lie.
pub(crate) fn band(time_s: &[f64], values: &[f64], hold: bool) -> Option<(f64, f64)> {
    let period = stats::median_period(time_s);
    let mut even = resample::uniform(time_s, values, period, hold);
    let mean = stats::mean(&even);
    even.iter_mut().for_each(|v| *v -= mean);
    let n = even.len();
    let fft = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = fft.make_output_vec();
    fft.process(&mut even, &mut spectrum).ok()?;
    let total: f64 = spectrum.iter().map(|c| c.norm_sqr()).sum();
    if total <= 0.0 {
        return None;
    }
    let below = |share: f64| {
        let mut sum = 0.0;
        let line = spectrum.iter().position(|c| {
            sum += c.norm_sqr();
            sum >= share * total
        });
        line.unwrap_or(0) as f64 / (n as f64 * period)
    };
    Some((below(0.05), below(0.95)))
}
