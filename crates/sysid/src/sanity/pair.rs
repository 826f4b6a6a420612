//! One column of one run beside its prediction: straight lines between them, also with one moved along the other.

use std::ops::Range;

/// A measured column and what the nominal model says of it.
pub(super) struct Pair<'a> {
    /// The run's index in the campaign.
    pub run: usize,
    /// The column.
    pub channel: &'a str,
    /// Its noise, one standard deviation.
    pub noise: f64,
    /// All rows.
    pub measured: &'a [f64],
    /// All rows.
    pub predicted: &'a [f64],
    /// Those that count.
    pub rows: Vec<Range<usize>>,
}

/// The straight line of measured on predicted values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Measured per predicted.
    pub slope: f64,
    /// Measured at a prediction of zero.
    pub bias: f64,
    /// Pearson's; 0 where one of them is constant.
    pub correlation: f64,
    /// Standard deviation of the measured values.
    pub measured: f64,
    /// Standard deviation of the predicted values.
    pub predicted: f64,
}

impl Line {
    /// Through pairs of predicted and measured values.
    pub fn through(pairs: impl Iterator<Item = (f64, f64)>) -> Self {
        // About the first pair, so that a great mean takes no digits.
        let mut pairs = pairs.peekable();
        let (p0, m0) = pairs.peek().copied().unwrap_or((0.0, 0.0));
        let (mut n, mut sp, mut sm, mut pp, mut mm, mut pm) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (p, m) in pairs {
            let (p, m) = (p - p0, m - m0);
            n += 1.0;
            sp += p;
            sm += m;
            pp += p * p;
            mm += m * m;
            pm += p * m;
        }
        let n = f64::max(n, 1.0);
        let (vp, vm) = (f64::max(pp / n - (sp / n).powi(2), 0.0), f64::max(mm / n - (sm / n).powi(2), 0.0));
        let covariance = pm / n - sp * sm / n / n;
        let slope = if vp > 0.0 { covariance / vp } else { 0.0 };
        let correlation = if vp > 0.0 && vm > 0.0 { covariance / (vp * vm).sqrt() } else { 0.0 };
        let bias = m0 + sm / n - slope * (p0 + sp / n);
        Self {
            slope,
            bias,
            correlation: correlation.clamp(-1.0, 1.0),
            measured: vm.sqrt(),
            predicted: vp.sqrt(),
        }
    }

    /// Share of the measured variance that the line does not explain.
    pub fn unexplained(&self) -> f64 {
        1.0 - self.correlation * self.correlation
    }
}

impl Pair<'_> {
    /// Number of rows that count.
    pub fn count(&self) -> usize {
        self.rows.iter().map(Range::len).sum()
    }

    /// The line, measured values `lag` rows after the predicted ones, every `stride`-th row.
    pub fn line(&self, lag: isize, stride: usize) -> Line {
        line(self.measured, self.predicted, &self.rows, lag, stride)
    }

    /// The prediction's correlation with itself so many rows later.
    pub fn own_correlation(&self, lag: isize) -> f64 {
        line(self.predicted, self.predicted, &self.rows, lag, 1).correlation
    }
}

fn line(measured: &[f64], predicted: &[f64], rows: &[Range<usize>], lag: isize, stride: usize) -> Line {
    let rows = rows.iter().cloned().flatten().step_by(stride);
    Line::through(rows.filter_map(|i| {
        let from = i.checked_add_signed(-lag)?;
        Some((*predicted.get(from)?, measured[i]))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_line_with_a_bias_and_a_shift() {
        let predicted: Vec<f64> =
            (0..500).map(|i| (0.03 * f64::from(i)).sin() + (0.17 * f64::from(i)).cos()).collect();
        let measured: Vec<f64> =
            (0..500).map(|i| 1e6 - 3.0 * predicted[(i as usize).saturating_sub(7)]).collect();
        let pair = Pair {
            run: 0,
            channel: "x",
            noise: 1.0,
            measured: &measured,
            predicted: &predicted,
            rows: vec![20..400, 410..480],
        };
        let line = pair.line(7, 1);
        assert!((line.slope + 3.0).abs() < 1e-6 && (line.bias - 1e6).abs() < 1e-6, "{line:?}");
        assert!((line.correlation + 1.0).abs() < 1e-9, "{line:?}");
        assert!(pair.line(0, 1).unexplained() > 0.05);
        assert!(pair.own_correlation(0) > 0.999_999 && pair.own_correlation(18) < 0.5);
        assert_eq!(pair.count(), 450);
        let constant = Line::through([(1.0, 2.0), (1.0, 5.0)].into_iter());
        assert_eq!((constant.slope, constant.correlation), (0.0, 0.0));
    }
}
