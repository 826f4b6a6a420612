//! How regular a run's time stamps are.

/// A step of the clock that is much longer than the usual one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Time stamp before it, s.
    pub from_s: f64,
    /// Its length, s.
    pub length_s: f64,
}

/// Regularity of time stamps.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// Time from the first to the last sample, s.
    pub duration_s: f64,
    /// Median step, s: the sampling period.
    pub period_s: f64,
    /// Root mean square deviation of a step from the median, gaps left out, s.
    pub jitter_s: f64,
    /// Greatest step, s.
    pub longest_s: f64,
    /// Steps longer than [`Clock::GAP`] periods.
    pub gaps: Vec<Gap>,
    /// Relative deviation of the median step's rate from the stated sample rate, if one is stated.
    pub rate_deviation: Option<f64>,
}

impl Clock {
    /// A step of more periods than this is a gap.
    pub const GAP: f64 = 5.0;
    /// A deviation from the stated rate, relative, below this is not worth a remark.
    const RATE_TOLERANCE: f64 = 0.005;

    /// Looks at strictly increasing time stamps, at least two.
    #[must_use]
    pub fn of(time_s: &[f64], nominal_rate_hz: Option<f64>) -> Self {
        let steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
        let period_s = crate::stats::median(&steps);
        let deviations: Vec<f64> =
            steps.iter().filter(|&&s| s <= Self::GAP * period_s).map(|s| s - period_s).collect();
        let gaps = (0..steps.len())
            .filter(|&i| steps[i] > Self::GAP * period_s)
            .map(|i| Gap { from_s: time_s[i], length_s: steps[i] })
            .collect();
        Self {
            duration_s: time_s.last().zip(time_s.first()).map_or(0.0, |(b, a)| b - a),
            period_s,
            jitter_s: crate::stats::rms(&deviations),
            longest_s: steps.iter().copied().fold(0.0, f64::max),
            gaps,
            rate_deviation: nominal_rate_hz.map(|rate| 1.0 / (period_s * rate) - 1.0),
        }
    }

    /// The sampling rate by the median step, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        1.0 / self.period_s
    }

    /// Whether every step is the median step to a thousandth (or to the digits of the file).
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.jitter_s < 2e-3 * self.period_s && self.longest_s < 1.01 * self.period_s
    }

    /// What is odd about the clock, one line each.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if let Some(deviation) = self.rate_deviation.filter(|d| d.abs() > Self::RATE_TOLERANCE) {
            remarks.push(format!(
                "sampled at {:.1} Hz by its time column, {:+.1} % off the stated rate; the time column decides",
                self.rate_hz(),
                100.0 * deviation
            ));
        }
        if self.jitter_s > 0.01 * self.period_s {
            remarks.push(format!(
                "steps of time vary by {:.3} ms about {:.3} ms; kept as they are",
                1e3 * self.jitter_s,
                1e3 * self.period_s
            ));
        }
        if let Some(longest) = self.gaps.iter().max_by(|a, b| a.length_s.total_cmp(&b.length_s)) {
            remarks.push(format!(
                "{} gap(s) of more than {} periods, the longest {:.3} s at {:.3} s",
                self.gaps.len(),
                Self::GAP,
                longest.length_s,
                longest.from_s
            ));
        }
        remarks
    }
}

/// Longest run, s, and most sampling periods in one: a clock that jumps (from zero to the seconds since 1970,
/// say) would otherwise ask for a simulation, and a spectrum, of years.
const LONGEST_S: f64 = 10_000.0;
const MOST_PERIODS: f64 = 2e7;

/// What is wrong with time stamps that cover more than a run can be.
pub(super) fn too_long(time_s: &[f64]) -> Option<String> {
    let (first, last) = time_s.first().zip(time_s.last())?;
    let (longest, at) = time_s.windows(2).map(|w| (w[1] - w[0], w[0])).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let jump = || format!("its longest step is {longest:.6e} s, after {at:.6e} s");
    let span = last - first;
    if span > LONGEST_S {
        return Some(format!(
            "covers {span:.6e} s, and a run is at most {LONGEST_S} s; {}: a clock that jumps, or a run to be cut into several",
            jump()
        ));
    }
    let steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    let period = crate::stats::median(&steps);
    (span / period > MOST_PERIODS).then(|| {
        format!(
            "covers {span:.6e} s with a usual step of {period:.6e} s, more than {MOST_PERIODS:e} of them; {}",
            jump()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_jumps_is_refused() {
        let even: Vec<f64> = (0..200).map(|i| 1.7e9 + 0.001 * f64::from(i)).collect();
        assert_eq!(too_long(&even), None);
        let mut jumps = even.clone();
        jumps[0] = 0.0;
        assert!(too_long(&jumps).unwrap().contains("after 0"));
        let mut tiny: Vec<f64> = (0..200).map(|i| 1e-300 * f64::from(i)).collect();
        assert_eq!(too_long(&tiny), None);
        tiny.push(1.0);
        assert!(too_long(&tiny).unwrap().contains("usual step"));
    }

    #[test]
    fn a_gap_jitter_and_a_wrong_rate_are_reported() {
        let mut time: Vec<f64> =
            (0..200).map(|i| 0.001 * f64::from(i) + if i % 2 == 0 { 0.0 } else { 1e-4 }).collect();
        for t in time.iter_mut().skip(100) {
            *t += 0.3;
        }
        let clock = Clock::of(&time, Some(900.0));
        assert_eq!(clock.gaps.len(), 1);
        assert!((clock.gaps[0].length_s - 0.3009).abs() < 1e-9, "{:?}", clock.gaps);
        assert!(clock.jitter_s > 5e-5 && !clock.is_uniform());
        assert_eq!(clock.remarks().len(), 3);
        let even: Vec<f64> = (0..200).map(|i| 0.001 * f64::from(i)).collect();
        assert!(Clock::of(&even, Some(1000.0)).remarks().is_empty());
    }
}
