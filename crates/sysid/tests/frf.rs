//! Frequency-response estimates against scipy's numbers and against closed forms.

use std::f64::consts::TAU;

use num_complex::Complex64;
use sealegs_sysid::frf::{
    Detrend, Estimator, FitWeight, FrequencyResponse, FrfError, Hold, Welch, Window, falls_through,
    fit_rational, fit_second_order, peak_near, peaks, trough_near,
};

/// The generator of `data/welch_reference.py`: numbers in [-0.5, 0.5).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = (1_103_515_245 * self.0 + 12_345) % (1 << 31);
        self.0 as f64 / f64::from(1u32 << 31) - 0.5
    }
}

/// Splitmix64, whose streams from neighbouring seeds are independent as those of [`Uniform`] are not.
struct Normal(u64);

impl Normal {
    /// Roughly normal with standard deviation 1: the sum of twelve uniform numbers.
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        (0..12).map(|_| uniform()).sum()
    }
}

fn reference_signals() -> (Vec<f64>, Vec<f64>) {
    let (mut first, mut second) = (Uniform(1), Uniform(2));
    let (mut y1, mut y2) = (0.0, 0.0);
    (0..2000)
        .map(|n| {
            let u = first.next();
            let y0 = 1.5 * y1 - 0.8 * y2 + 0.3 * u;
            let x = u + 0.2 + 0.0005 * f64::from(n);
            let y = y0 + 0.1 * second.next() - 0.4;
            (y1, y2) = (y0, y1);
            (x, y)
        })
        .unzip()
}

#[test]
fn reference_scipy_welch_csd_and_coherence() {
    let (x, y) = reference_signals();
    let configurations = [
        ("hann", Welch::hann(128)),
        ("hamming", Welch { segment: 128, overlap: 32, window: Window::Hamming, detrend: Detrend::Line }),
        ("flat-top", Welch { segment: 100, overlap: 75, window: Window::FlatTop, detrend: Detrend::Mean }),
        (
            "rectangular",
            Welch { segment: 125, overlap: 0, window: Window::Rectangular, detrend: Detrend::None },
        ),
    ];
    let mut compared = 0;
    for (name, welch) in configurations {
        let spectra = welch.spectra(1.0 / 400.0, &[(&x, &y)]).unwrap();
        let h1 = spectra.response(Estimator::H1);
        let rows = include_str!("data/welch_reference.csv")
            .lines()
            .filter_map(|l| l.strip_prefix(name).and_then(|l| l.strip_prefix(',')))
            .map(|l| l.split(',').map(|v| v.parse().unwrap()).collect::<Vec<f64>>());
        // The file holds 13 digits; what a mean leaves behind at zero frequency is rounding in both programs.
        let scale = spectra.input.iter().copied().fold(0.0, f64::max);
        let close = |a: f64, b: f64, s: f64| (a - b).abs() <= 1e-10 * b.abs() + 1e-13 * s;
        for (i, row) in rows.enumerate() {
            assert!(close(spectra.frequency_hz[i], row[0], 1.0), "{name} {i}");
            assert!(close(spectra.input[i], row[1], scale), "{name} {i}: S_xx");
            assert!(close(spectra.output[i], row[2], scale), "{name} {i}: S_yy");
            assert!(close(spectra.cross[i].re, row[3], scale), "{name} {i}: Re S_xy");
            assert!(close(spectra.cross[i].im, row[4], scale), "{name} {i}: Im S_xy");
            if spectra.input[i] > 1e-12 * scale {
                assert!(close(h1.coherence[i], row[5], 1.0), "{name} {i}: coherence");
            }
            compared += 1;
        }
    }
    assert_eq!(compared, 65 + 65 + 51 + 63);
}

/// Excites a recursion `y[n] = b u[n] + a1 y[n-1] + a2 y[n-2]` and adds output noise of a given size.
fn noisy_recursion(samples: usize, noise: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let (mut first, mut second) = (Normal(seed), Normal(seed + 77));
    let (mut y1, mut y2) = (0.0, 0.0);
    (0..samples)
        .map(|_| {
            let u = first.next();
            let y0 = 0.3 * u + 1.5 * y1 - 0.8 * y2;
            (y1, y2) = (y0, y1);
            (u, y0 + noise * second.next())
        })
        .unzip()
}

fn recursion_at(f: f64, period: f64) -> Complex64 {
    let z = Complex64::from_polar(1.0, -TAU * f * period);
    0.3 / (1.0 - 1.5 * z + 0.8 * z * z)
}

#[test]
fn analytic_h1_and_its_error_bars_cover_the_true_response() {
    let runs: Vec<_> = (0..4).map(|k| noisy_recursion(16_384, 0.1, 11 + k)).collect();
    let views: Vec<(&[f64], &[f64])> = runs.iter().map(|(u, y)| (u.as_slice(), y.as_slice())).collect();
    let spectra = Welch::hann(512).spectra(0.0025, &views).unwrap();
    // Hann at half overlap: the periodograms of neighbours correlate by (1/6)^2, so 18/19 of the segments count.
    assert_eq!(spectra.averages, 4 * 63);
    assert!((spectra.effective_averages / 252.0 - 18.0 / 19.0).abs() < 0.002);
    let h1 = spectra.response(Estimator::H1);
    let errors = h1.relative_error();
    let mut covered = 0;
    let lines = 3..254;
    for i in lines.clone() {
        let truth = recursion_at(h1.frequency_hz[i], 0.0025);
        let off = (h1.value[i].norm() / truth.norm() - 1.0).abs();
        covered += usize::from(off <= 1.96 * errors[i]);
        // True coherence of the recursion's output in white noise of a hundredth of the input's density.
        let power = truth.norm_sqr();
        assert!((h1.coherence[i] - power / (power + 0.01)).abs() < 0.2, "line {i}");
    }
    // 95 % nominal of 251 nearly independent lines: 92 to 98 % is within 2.2 standard deviations.
    let share = covered as f64 / lines.len() as f64;
    assert!((0.92..=0.98).contains(&share), "{share}");
    let (low, high) = h1.bounds_db(1.96)[50];
    assert!(low < h1.magnitude_db()[50] && high > h1.magnitude_db()[50]);
}

#[test]
fn analytic_h1_h2_and_hv_differ_by_the_coherence() {
    let (u, y) = noisy_recursion(8192, 0.5, 5);
    let spectra = Welch::hann(256).spectra(0.0025, &[(&u, &y)]).unwrap();
    let [h1, h2, hv] = [Estimator::H1, Estimator::H2, Estimator::Hv].map(|e| spectra.response(e));
    for i in 1..128 {
        assert!((h2.value[i] * h1.coherence[i] - h1.value[i]).norm() < 1e-12);
        assert!((h1.value[i] * h2.value[i] - hv.value[i] * hv.value[i]).norm() < 1e-12);
        assert!((h2.value[i].norm() - (spectra.output[i] / spectra.cross[i].norm())).abs() < 1e-12);
    }
}

#[test]
fn analytic_hold_of_a_sampled_second_order_system() {
    // Exact step-invariant discretisation of w0^2 / (s^2 + 2 z w0 s + w0^2) at 400 Hz against its own continuous form.
    let (w0, z, period): (f64, f64, f64) = (TAU * 7.5, 0.42, 0.0025);
    let continuous = |f: f64| {
        let s = Complex64::new(0.0, TAU * f);
        w0 * w0 / (s * s + 2.0 * z * w0 * s + w0 * w0)
    };
    let wd = w0 * (1.0 - z * z).sqrt();
    let (decay, c, sn) = ((-z * w0 * period).exp(), (wd * period).cos(), (wd * period).sin());
    let r = z * w0 / wd;
    let (b1, b0) = (1.0 - decay * (c + r * sn), decay * decay + decay * (r * sn - c));
    let frequency_hz: Vec<f64> = (1..=200).map(|i| 0.2 * f64::from(i)).collect();
    let value = frequency_hz
        .iter()
        .map(|f| {
            let zz = Complex64::from_polar(1.0, TAU * f * period);
            (b1 * zz + b0) / (zz * zz - 2.0 * decay * c * zz + decay * decay)
        })
        .collect();
    let mut sampled = FrequencyResponse::exact(frequency_hz, value);
    sampled.sample_period_s = period;
    let clean = sampled.clone().without_hold(Hold::ZeroOrder);
    for (f, h) in clean.frequency_hz.iter().zip(&clean.value) {
        // What is left is the alias from 400 Hz - f, which is (f / (400 - f))^3 small relative to the response.
        assert!((h / continuous(*f) - 1.0).norm() < 1.5 * (f / (400.0 - f)).powi(3) + 1e-4, "{f} Hz");
    }
    let half = fit_second_order(&clean.band(0.0, 20.0, 0.0), FitWeight::Relative).unwrap();
    assert!((half.zeroth / (w0 * w0) - 1.0).abs() < 5e-4, "{half:?}");
    assert!((half.first / (2.0 * z * w0) - 1.0).abs() < 5e-4, "{half:?}");
    // Ignored, the half-sample delay is taken for damping: too little of it by much more than that.
    let raw = fit_second_order(&sampled.band(0.0, 20.0, 0.0), FitWeight::Relative).unwrap();
    assert!((raw.first / (2.0 * z * w0) - 1.0).abs() > 0.02, "{raw:?}");
}

#[test]
fn analytic_rational_fit_returns_the_coefficients_of_a_fourth_order_system() {
    let (numerator, denominator) = ([8.0e8, 2.0e4, 655e3], [9.0e12, 2.1e10, 6.0e8, 4.0e4, 1.0]);
    let value_at = |f: f64| {
        let s = Complex64::new(0.0, TAU * f);
        let p = |c: &[f64]| c.iter().rev().fold(Complex64::ZERO, |a, k| a * s + k);
        p(&numerator) / p(&denominator)
    };
    let frequency_hz: Vec<f64> = (1..400).map(|i| 0.5 * f64::from(i)).collect();
    let value = frequency_hz.iter().map(|f| value_at(*f)).collect();
    let response = FrequencyResponse::exact(frequency_hz, value);
    for weight in [FitWeight::Coherence, FitWeight::Relative] {
        let fit = fit_rational(&response, 2, 4, weight).unwrap();
        assert!(fit.converged && fit.relative_rms < 1e-8, "{fit:?}");
        for (found, truth) in fit.function.numerator.iter().zip(&numerator) {
            assert!((found / truth - 1.0).abs() < 1e-6, "{fit:?}");
        }
        for (found, truth) in fit.function.denominator.iter().zip(&denominator) {
            assert!((found / truth - 1.0).abs() < 1e-6, "{fit:?}");
        }
        assert!((fit.function.at_hz(3.0) / value_at(3.0) - 1.0).norm() < 1e-7);
    }
}

#[test]
fn analytic_standard_errors_of_a_second_order_fit_match_the_scatter() {
    // c = 1, a = 2, b = 100 with 1 % complex noise on every line, 40 times over.
    let frequency_hz: Vec<f64> = (1..=100).map(|i| 0.05 * f64::from(i)).collect();
    let mut random = Normal(3);
    let mut scatter = Vec::new();
    let mut stated = 0.0;
    for _ in 0..40 {
        let value = frequency_hz
            .iter()
            .map(|f| {
                let s = Complex64::new(0.0, TAU * f);
                let e = Complex64::new(random.next(), random.next()) * 0.01;
                (1.0 + e) / (s * s + 2.0 * s + 100.0)
            })
            .collect();
        let fit =
            fit_second_order(&FrequencyResponse::exact(frequency_hz.clone(), value), FitWeight::Relative)
                .unwrap();
        scatter.push(fit.first - 2.0);
        stated += fit.standard_error[1] / 40.0;
        assert!((fit.natural_frequency_hz() - 10.0 / TAU).abs() < 0.01);
        assert!((fit.damping_ratio() - 0.1).abs() < 0.01 && (fit.static_gain() - 0.01).abs() < 2e-4);
    }
    let found = (scatter.iter().map(|v| v * v).sum::<f64>() / 40.0).sqrt();
    // 40 draws give the standard deviation within 11 %.
    assert!((found / stated - 1.0).abs() < 0.35, "scatter {found}, stated {stated}");
}

#[test]
fn analytic_peaks_lie_between_the_lines() {
    // |1 / (1 - r^2 + 2 i z r)| peaks at f0 sqrt(1 - 2 z^2) with 1 / (2 z sqrt(1 - z^2)).
    let (f0, z): (f64, f64) = (17.02, 0.0315);
    let frequency_hz: Vec<f64> = (1..2000).map(|i| 0.0488 * f64::from(i)).collect();
    let db: Vec<f64> = frequency_hz
        .iter()
        .map(|f| -20.0 * Complex64::new(1.0 - (f / f0).powi(2), 2.0 * z * f / f0).norm().log10())
        .collect();
    let (at, high) = (f0 * (1.0 - 2.0 * z * z).sqrt(), -20.0 * (2.0 * z * (1.0 - z * z).sqrt()).log10());
    let all = peaks(&frequency_hz, &db, 3.0);
    assert_eq!(all.len(), 1);
    assert!((all[0].frequency_hz - at).abs() < 0.003, "{all:?}");
    assert!((all[0].magnitude_db - high).abs() < 0.01, "{all:?}");
    assert!(all[0].prominence_db > 20.0);
    let near = peak_near(&frequency_hz, &db, 10.0, 25.0, 0.2).unwrap();
    assert!((near.frequency_hz - at).abs() < 0.01, "{near:?}");
    let notch: Vec<f64> = db.iter().map(|v| -v).collect();
    let trough = trough_near(&frequency_hz, &notch, 10.0, 25.0, 0.2).unwrap();
    assert!((trough.frequency_hz - at).abs() < 0.01 && trough.magnitude_db < -20.0);
    assert_eq!(peak_near(&frequency_hz, &db, 30.0, 60.0, 0.2), None, "a slope is no peak");
    // Past the peak the magnitude is back at one at f0 sqrt(2 - 4 z^2).
    let back = falls_through(&frequency_hz, &db, 0.0, f0).unwrap();
    assert!((back - f0 * (2.0 - 4.0 * z * z).sqrt()).abs() < 0.01, "{back}");
}

#[test]
fn bad_input_is_an_error() {
    let x = vec![0.0; 100];
    assert_eq!(
        Welch::hann(256).spectra(0.01, &[(&x, &x)]),
        Err(FrfError::TooShort { longest: 100, segment: 256 })
    );
    assert!(matches!(
        Welch::hann(64).spectra(0.01, &[(&x, &x[1..])]),
        Err(FrfError::LengthMismatch { run: 0, .. })
    ));
    assert!(matches!(Welch::hann(64).spectra(0.0, &[]), Err(FrfError::BadSetting { .. })));
    let overlapping = Welch { overlap: 64, ..Welch::hann(64) };
    assert!(matches!(overlapping.spectra(0.01, &[(&x, &x)]), Err(FrfError::BadSetting { .. })));
    // Nothing excited: coherence zero, no line to fit, no panic.
    let silent = Welch::hann(64).spectra(0.01, &[(&x, &x)]).unwrap().response(Estimator::H1);
    assert!(silent.coherence.iter().all(|g| *g == 0.0));
    assert!(matches!(
        fit_second_order(&silent, FitWeight::Coherence),
        Err(FrfError::TooFewPoints { points: 0, .. })
    ));
}
