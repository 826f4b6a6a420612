//! Why THOR's beam measured softer than designed: what each explanation of eq 2-9 and 2-10 would need.

use serde::Serialize;

use super::{ClampSetting, MomentLoadedBeam};

/// Two unknowns from two measured stiffnesses: a series stiffness and a scale of the beam.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SeriesAndScale {
    /// Series stiffness of joints and clamp, N/m.
    pub series_stiffness_n_m: f64,
    /// Its 5 and 95 % quantiles for slopes with a normal error of 1 % each, N/m.
    pub series_quantiles_n_m: [f64; 2],
    /// Factor on the ideal beam's stiffness.
    pub beam_scale: f64,
    /// The same beam scale with a longer beam in place of the series stiffness: extra length, m. It predicts an
    /// infinite stiffness when locked out, which section 5-2 excludes.
    pub equivalent_extra_length_m: f64,
    /// Stiffness locked out over stiffness at the stiff setting; section 5-2 says four.
    pub lock_out_factor: f64,
    /// Quantiles of that factor.
    pub lock_out_quantiles: [f64; 2],
}

/// An explanation with one unknown, which two measurements determine twice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hypothesis {
    /// What is unknown, with its unit.
    pub unknown: &'static str,
    /// What the compliant setting demands of it.
    pub from_compliant: f64,
    /// What the stiff setting demands of it.
    pub from_stiff: f64,
}

impl Hypothesis {
    /// How much the two demands differ, as a ratio of the smaller: zero for an explanation that fits.
    #[must_use]
    pub fn contradiction(&self) -> f64 {
        let (a, b) = (self.from_compliant, self.from_stiff);
        (a - b).abs() / a.abs().min(b.abs())
    }
}

/// All explanations for one pair of measured stiffnesses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SofterThanDesigned {
    /// Both unknowns together; exact, and tested by the lock-out.
    pub series_and_scale: SeriesAndScale,
    /// One unknown each: series stiffness, extra length, scale of Young's modulus.
    pub single: [Hypothesis; 3],
}

/// Normal quantile at 95 %.
const QUANTILE_95: f64 = 1.644_853_626_951_472;
/// Assumed error of a measured slope, one standard deviation as a ratio.
const SLOPE_ERROR: f64 = 0.01;

impl SofterThanDesigned {
    /// Explanations for the stiffnesses measured at the two settings, N/m, against the ideal `beam`, whose own
    /// scale and series stiffness are not used.
    #[must_use]
    pub fn new(beam: &MomentLoadedBeam, compliant_n_m: f64, stiff_n_m: f64) -> Self {
        let (long, short) = (beam.compliant_length_m, beam.stiff_length_m);
        let (soft, hard) = (1.0 / compliant_n_m, 1.0 / stiff_n_m);
        // Compliance of the ideal beam per length.
        let ideal = 1.0 / beam.ideal_stiffness_n_m(1.0);

        // Compliance = l * ideal/scale + series: a straight line through both measurements.
        let slope = (soft - hard) / (long - short);
        let beam_scale = ideal / slope;
        let series = (hard * long - soft * short) / (long - short);
        let spread = SLOPE_ERROR * (hard * long).hypot(soft * short) / (long - short);
        let series_at = |sigmas: f64| 1.0 / (series + sigmas * spread);
        let series_quantiles_n_m = [series_at(QUANTILE_95), series_at(-QUANTILE_95)];
        Self {
            series_and_scale: SeriesAndScale {
                series_stiffness_n_m: 1.0 / series,
                series_quantiles_n_m,
                beam_scale,
                equivalent_extra_length_m: series / slope,
                lock_out_factor: 1.0 / (series * stiff_n_m),
                lock_out_quantiles: series_quantiles_n_m.map(|k| k / stiff_n_m),
            },
            single: [
                Hypothesis {
                    unknown: "series stiffness, N/m",
                    from_compliant: 1.0 / (soft - long * ideal),
                    from_stiff: 1.0 / (hard - short * ideal),
                },
                Hypothesis {
                    unknown: "extra length, m",
                    from_compliant: soft / ideal - long,
                    from_stiff: hard / ideal - short,
                },
                Hypothesis {
                    unknown: "scale of Young's modulus",
                    from_compliant: long * ideal / soft,
                    from_stiff: short * ideal / hard,
                },
            ],
        }
    }

    /// The explanations for THOR's beam as measured (eq 2-9, 2-10).
    #[must_use]
    pub fn thor() -> Self {
        Self::new(
            &MomentLoadedBeam::thor(ClampSetting::Compliant),
            MomentLoadedBeam::MEASURED_COMPLIANT_N_M,
            MomentLoadedBeam::MEASURED_STIFF_N_M,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value} against {expected}");
    }

    #[test]
    fn published_series_stiffness_scale_and_lock_out() {
        let exact = SofterThanDesigned::thor().series_and_scale;
        near(exact.series_stiffness_n_m, 2771.5e3, 1e-3);
        near(exact.beam_scale, 1.1295, 1e-3);
        near(exact.equivalent_extra_length_m, 0.01704, 1e-3);
        near(exact.lock_out_factor, 4.229, 1e-3);
        near(exact.series_quantiles_n_m[0], 2336e3, 5e-3);
        near(exact.series_quantiles_n_m[1], 3403e3, 5e-3);
        near(exact.lock_out_quantiles[0], 3.6, 0.02);
        near(exact.lock_out_quantiles[1], 5.1, 0.02);
    }

    #[test]
    fn published_single_explanations_contradict_themselves() {
        let [series, length, modulus] = SofterThanDesigned::thor().single;
        near(series.from_compliant, 16.9e6, 5e-3);
        near(series.from_stiff, 4.76e6, 5e-3);
        near(length.from_compliant, 2.5e-3, 0.02);
        near(length.from_stiff, 8.8e-3, 0.01);
        near(modulus.from_compliant, 0.978, 1e-3);
        near(modulus.from_stiff, 0.862, 1e-3);
        assert!([series, length, modulus].iter().all(|h| h.contradiction() > 0.1));
    }
}
