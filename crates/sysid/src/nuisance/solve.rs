//! The linear least-squares problem of one channel's gain and biases, in closed form.

use super::SensorPrior;
use nalgebra::{DMatrix, DVector};

/// Sums over the scored rows of one run and channel, in the channel's unit: all that the solution needs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RunSums {
    /// Number of rows.
    pub n: f64,
    /// Sum of predictions.
    pub p: f64,
    /// Sum of measurements.
    pub y: f64,
    /// Sum of squared predictions.
    pub pp: f64,
    /// Sum of products of prediction and measurement.
    pub py: f64,
    /// Sum of squared measurements.
    pub yy: f64,
}

impl RunSums {
    /// Adds one row.
    pub fn add(&mut self, predicted: f64, measured: f64) {
        self.n += 1.0;
        self.p += predicted;
        self.y += measured;
        self.pp += predicted * predicted;
        self.py += predicted * measured;
        self.yy += measured * measured;
    }

    /// Sum of squared residuals through a sensor.
    fn squares(&self, gain: f64, bias: f64) -> f64 {
        self.yy + gain * gain * self.pp + self.n * bias * bias
            - 2.0 * (gain * self.py + bias * self.y - gain * bias * self.p)
    }
}

/// A sensor's gain and bias with the best values for some model parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// The channel.
    pub channel: String,
    /// The unit whose sensor it is, where a campaign has several.
    pub unit: Option<String>,
    /// Measured per true.
    pub gain: f64,
    /// Standard error of the gain for given model parameters and white noise; 0 if it is fixed.
    pub gain_std: f64,
    /// The gain is held at its limit of [`SensorPrior::GAIN_LIMIT`] standard deviations, and beyond it the cost
    /// would be clearly less: by more than the mean squared residual. (Where it would hardly be less, a search
    /// must know that the gain can move back together with the model's own scale, which the data do not feel.)
    pub gain_at_limit: bool,
    /// Common bias, in the channel's unit.
    pub bias: f64,
    /// Standard deviation with which the biases of runs scatter about the common one, as far as the fitted
    /// runs show it; the prior's if there is only one.
    pub bias_spread: f64,
    /// The bias of each fitted run that has the channel, with the run's index in its data.
    pub run_bias: Vec<(usize, f64)>,
    /// Runs whose bias is held at its limit of [`SensorPrior::RUN_BIAS_LIMIT`] standard deviations beside the common one.
    pub at_limit: Vec<usize>,
    /// Cost of the priors: half the sum of their squared rows.
    pub prior_cost: f64,
}

impl Sensor {
    /// The bias of a run, the common one for a run that was not fitted.
    #[must_use]
    pub fn bias_of(&self, run: usize) -> f64 {
        self.run_bias.iter().find(|(r, _)| *r == run).map_or(self.bias, |(_, b)| *b)
    }
}

/// The gain and the biases that minimise the squared residual over the runs, plus the squared prior rows.
///
/// `sums` holds `(run, sums)` for the runs that have this channel.
#[must_use]
pub fn solve(channel: &str, noise_std: f64, prior: SensorPrior, sums: &[(usize, RunSums)]) -> Sensor {
    let weight = noise_std.powi(-2);
    let (common, spread) = (prior.bias_std.powi(-2), prior.run_bias_std.powi(-2));
    let fixed = prior.gain_std == 0.0;
    let furthest = SensorPrior::RUN_BIAS_LIMIT * prior.run_bias_std;
    // Runs whose bias is held at its limit beside the common one, with that distance.
    let mut held: Vec<Option<f64>> = vec![None; sums.len()];
    // The common bias, where it is held at its own limit.
    let mut common_held: Option<f64> = None;
    // The priors make the matrix positive definite; rounding alone could break it, and then the neutral sensor is the answer.
    let (mut a, mut rhs, solved) = loop {
        let (a, rhs) = normal_equations(weight, prior, sums, &held, common_held);
        let Some(cholesky) = a.clone().cholesky() else { break (a, rhs, None) };
        let solution = cholesky.solve(&rhs);
        if common_held.is_none() && solution[1].abs() > prior.bias_limit {
            common_held = Some(prior.bias_limit.copysign(solution[1]));
            continue;
        }
        let before = held.clone();
        for (i, held) in held.iter_mut().enumerate().filter(|(_, h)| h.is_none()) {
            let apart = solution[2 + i] - solution[1];
            *held = (apart.abs() > furthest).then(|| furthest.copysign(apart));
        }
        if held == before {
            break (a, rhs, Some((cholesky, solution)));
        }
    };
    let size = 2 + sums.len();
    let bias_of = |solution: &DVector<f64>, i: usize| held[i].map_or(solution[2 + i], |h| solution[1] + h);
    let mut at_limit = false;
    let limit = SensorPrior::GAIN_LIMIT * prior.gain_std;
    let mut solution = DVector::zeros(size);
    let mut gain_std = 0.0;
    if let Some((cholesky, found)) = solved {
        solution = found;
        if !fixed {
            let mut unit = DVector::zeros(size);
            unit[0] = 1.0;
            gain_std = cholesky.solve(&unit)[0].max(0.0).sqrt();
        }
        if solution[0].abs() > limit && !fixed {
            let beyond = (solution[0].abs() - limit) / gain_std;
            let held = limit.copysign(solution[0]);
            for k in 1..size {
                rhs[k] -= a[(k, 0)] * held;
                a[(k, 0)] = 0.0;
                a[(0, k)] = 0.0;
            }
            a[(0, 0)] = 1.0;
            rhs[0] = held;
            if let Some(cholesky) = a.cholesky() {
                solution = cholesky.solve(&rhs);
            }
            let (mut squares, mut rows) = (0.0, 0.0);
            for (i, (_, s)) in sums.iter().enumerate() {
                squares += weight * s.squares(1.0 + solution[0], bias_of(&solution, i));
                rows += s.n;
            }
            at_limit = 0.5 * beyond * beyond > (squares / f64::max(rows, 1.0)).max(1.0);
        }
    }
    let run_bias: Vec<(usize, f64)> =
        sums.iter().enumerate().map(|(i, (run, _))| (*run, bias_of(&solution, i))).collect();
    let deviations: f64 = run_bias.iter().map(|(_, b)| (b - solution[1]).powi(2)).sum();
    let gain_row = if fixed { 0.0 } else { solution[0] / prior.gain_std };
    let prior_cost = 0.5 * (gain_row.powi(2) + solution[1].powi(2) * common + deviations * spread);
    let runs = run_bias.len() as f64;
    let bias_spread = if run_bias.len() < 2 {
        prior.run_bias_std
    } else {
        let mean = run_bias.iter().map(|(_, b)| b).sum::<f64>() / runs;
        let scatter: f64 = run_bias.iter().map(|(_, b)| (b - mean).powi(2)).sum();
        // The spread of two or three runs is itself known badly: err on the wide side (half a degree of
        // freedom less), with the standard error that the noise alone leaves as the least.
        let least = sums.iter().map(|(_, s)| noise_std.powi(2) / s.n.max(1.0)).sum::<f64>() / runs;
        ((scatter + least) / (runs - 1.5)).sqrt()
    };
    Sensor {
        channel: channel.to_owned(),
        unit: None,
        gain: 1.0 + solution[0],
        gain_std,
        gain_at_limit: at_limit,
        bias: solution[1],
        bias_spread,
        run_bias,
        at_limit: sums.iter().zip(&held).filter(|(_, h)| h.is_some()).map(|((run, _), _)| *run).collect(),
        prior_cost,
    }
}

/// The normal equations of a sensor; its unknowns are the gain less one, the common bias and one bias a run. A run that is
/// held so far from the common bias has none of its own.
fn normal_equations(
    weight: f64,
    prior: SensorPrior,
    sums: &[(usize, RunSums)],
    held: &[Option<f64>],
    common_held: Option<f64>,
) -> (DMatrix<f64>, DVector<f64>) {
    let (common, spread) = (prior.bias_std.powi(-2), prior.run_bias_std.powi(-2));
    let fixed = prior.gain_std == 0.0;
    let size = 2 + sums.len();
    let mut a = DMatrix::<f64>::zeros(size, size);
    let mut rhs = DVector::<f64>::zeros(size);
    a[(1, 1)] = common;
    a[(0, 0)] = if fixed { 1.0 } else { prior.gain_std.powi(-2) };
    for (i, ((_, s), held)) in sums.iter().zip(held).enumerate() {
        let (own, apart) = (2 + i, held.unwrap_or(0.0));
        let k = if held.is_some() { 1 } else { own };
        if !fixed {
            a[(0, 0)] += weight * s.pp;
            a[(0, k)] += weight * s.p;
            a[(k, 0)] = a[(0, k)];
            rhs[0] += weight * (s.py - s.pp - apart * s.p);
        }
        a[(k, k)] += weight * s.n;
        rhs[k] += weight * (s.y - s.p - apart * s.n);
        if held.is_some() {
            a[(own, own)] = 1.0;
        } else {
            a[(k, k)] += spread;
            a[(1, 1)] += spread;
            a[(1, k)] = -spread;
            a[(k, 1)] = -spread;
        }
    }
    if let Some(bias) = common_held {
        for k in (0..size).filter(|&k| k != 1) {
            rhs[k] -= a[(k, 1)] * bias;
            a[(k, 1)] = 0.0;
            a[(1, k)] = 0.0;
        }
        a[(1, 1)] = 1.0;
        rhs[1] = bias;
    }
    (a, rhs)
}

/// Fewest rows that make a quiet start: a command that is excited from the beginning keeps its first value for
/// a row or two, and the rig may be in full motion.
const QUIET_ROWS: usize = 10;

/// Number of rows at the very beginning of a run during which the command keeps its first value and the
/// prediction of a channel stays within a tenth of its noise; 0 if they are too few to show rest.
///
/// The row at which the command first differs still belongs to it: the command has only just gone out.
#[must_use]
pub fn quiet_start(input: &[f64], predicted: &[f64], noise_std: f64) -> usize {
    let (Some(&first), Some(&rest)) = (input.first(), predicted.first()) else { return 0 };
    let changed = input.iter().position(|&u| u != first).map_or(0, |i| i + 1);
    let quiet = predicted.iter().take(changed).take_while(|&&p| (p - rest).abs() <= 0.1 * noise_std).count();
    if quiet < QUIET_ROWS { 0 } else { quiet }
}

/// Robust standard deviations beyond which a row of a quiet start is a spike and says nothing of the zero.
const SPIKE: f64 = 10.0;

/// The bias with which a held-out run is judged: its quiet start weighed against the common bias.
///
/// `measured` and `predicted` are the whole run, `quiet` the number of its rows in the quiet start.
#[must_use]
pub fn judge_zero(sensor: &Sensor, noise_std: f64, measured: &[f64], predicted: &[f64], quiet: usize) -> f64 {
    if quiet == 0 {
        return sensor.bias;
    }
    let mut offsets: Vec<f64> = (0..quiet).map(|i| measured[i] - sensor.gain * predicted[i]).collect();
    let middle = crate::stats::median(&offsets);
    let apart: Vec<f64> = offsets.iter().map(|o| (o - middle).abs()).collect();
    let scale = noise_std.max(1.4826 * crate::stats::median(&apart));
    offsets.retain(|o| (o - middle).abs() <= SPIKE * scale);
    let mean = crate::stats::mean(&offsets);
    // Neighbouring samples of a slow sensor are alike: at most one in ten is taken as independent, and at
    // least one is.
    let scatter = crate::stats::std(&offsets).max(noise_std);
    let independent = (quiet as f64 / 10.0).max(f64::min(quiet as f64, 2.0));
    let own = scatter * scatter / independent;
    let common = sensor.bias_spread * sensor.bias_spread;
    (mean * common + sensor.bias * own) / (common + own)
}

/// What a held-out run's zero is beside that: the median of how far its values lie off, within half a step of a sensor that counts.
#[must_use]
pub fn within_a_step(off: Vec<f64>, step: f64) -> f64 {
    if off.is_empty() { 0.0 } else { crate::stats::median(&off).clamp(-0.5 * step, 0.5 * step) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::Noise;

    fn sums_of(gain: f64, bias: f64, noise: &mut Noise, run: usize) -> (usize, RunSums) {
        let mut sums = RunSums::default();
        for i in 0..2000 {
            let p = 100.0 * (f64::from(i) * 0.01).sin();
            sums.add(p, gain * p + bias + 2.0 * noise.normal());
        }
        (run, sums)
    }

    const PRIOR: SensorPrior =
        SensorPrior { gain_std: 0.01, bias_std: 10.0, run_bias_std: 10.0, bias_limit: 100.0 };

    #[test]
    fn analytic_a_runs_bias_stays_near_the_common_one_where_a_model_is_wrong() {
        // Two runs of a model that is 50 apart from what was measured in each: forth in one, back in the other.
        let sums: Vec<(usize, RunSums)> = [50.0, -50.0]
            .into_iter()
            .enumerate()
            .map(|(run, off)| {
                let mut sums = RunSums::default();
                (0..2000)
                    .for_each(|i| sums.add((0.01 * f64::from(i)).sin(), off + (0.01 * f64::from(i)).sin()));
                (run, sums)
            })
            .collect();
        let prior = SensorPrior { gain_std: 0.0, bias_std: 10.0, run_bias_std: 2.0, bias_limit: 100.0 };
        let sensor = solve("joint_angle_rad", 0.1, prior, &sums);
        assert_eq!(sensor.at_limit, [0, 1]);
        assert!(sensor.bias.abs() < 1e-9);
        assert!((sensor.bias_of(0) - 6.0).abs() < 1e-9 && (sensor.bias_of(1) + 6.0).abs() < 1e-9);
        // Where the two agree the common bias takes it: no load cell's zero is held.
        let alike = [(0, sums[0].1), (1, sums[0].1)];
        let sensor = solve("joint_angle_rad", 0.1, prior, &alike);
        // Two runs of a spread of 2 about a common bias of 0 +- 10: 50 * 100 / (100 + 4 / 2).
        assert!(sensor.at_limit.is_empty() && (sensor.bias - 50.0 / 1.02).abs() < 1e-3, "{sensor:?}");
    }

    #[test]
    fn analytic_a_common_bias_stays_within_its_limit() {
        // Two runs that a wrong model leaves 20 rad beside it. Neighbouring rows of both signs keep the gain out of it.
        let beside = |off: f64| {
            let mut sums = RunSums::default();
            (0..2000).for_each(|i| sums.add(f64::from(i % 2) - 0.5, off + f64::from(i % 2) - 0.5));
            sums
        };
        let prior = SensorPrior::of_channel("arm_2_joint.angle_rad", 1e-5, 1.5);
        // Mounted within 0.02 rad; the limit is ten of those.
        assert_eq!(prior.bias_std, 0.02);
        assert!((prior.bias_limit - 0.2).abs() < 1e-12);
        let sensor = solve("arm_2_joint.angle_rad", 1e-5, prior, &[(0, beside(-20.0)), (1, beside(-20.0))]);
        assert!((sensor.bias + 0.2).abs() < 1e-12, "{sensor:?}");
        let most = 0.2 + SensorPrior::RUN_BIAS_LIMIT * prior.run_bias_std;
        assert_eq!(sensor.at_limit, [0, 1]);
        for run in [0, 1] {
            assert!((sensor.bias_of(run) + most).abs() < 1e-12, "{sensor:?}");
        }
        // A speed is at rest where the drive is; a drive's own position may have drifted by half of what it showed.
        let limit = |channel| SensorPrior::of_channel(channel, 1e-4, 0.25).bias_limit;
        assert!((limit("speed_rad_s") - 20e-4).abs() < 1e-12 && limit("position_m") == 0.125);
        // A zero that lies within the limit is found as before, with a gain beside it.
        let gained = SensorPrior { gain_std: 0.01, bias_std: 0.3, run_bias_std: 0.1, bias_limit: 3.0 };
        let sensor = solve("force_1_n", 1e-3, gained, &[(0, beside(0.2)), (1, beside(0.2))]);
        assert!((sensor.bias_of(0) - 0.2).abs() < 1e-6 && sensor.at_limit.is_empty(), "{sensor:?}");
        assert!((sensor.gain - 1.0).abs() < 1e-6, "{sensor:?}");
    }

    #[test]
    fn gain_and_the_biases_of_runs_are_recovered() {
        let mut noise = Noise::new(3);
        let sums = [sums_of(1.012, -3.0, &mut noise, 0), sums_of(1.012, 4.0, &mut noise, 2)];
        let sensor = solve("force_1_n", 2.0, PRIOR, &sums);
        // Standard errors: 2 / (71 sqrt(4000)) = 0.00045 of gain, 2 / sqrt(2000) = 0.045 N of bias.
        assert!((sensor.gain - 1.012).abs() < 0.0015, "{sensor:?}");
        assert!((sensor.gain_std / 0.00045 - 1.0).abs() < 0.05, "{sensor:?}");
        assert!((sensor.bias_of(0) + 3.0).abs() < 0.15 && (sensor.bias_of(2) - 4.0).abs() < 0.15);
        assert!(sensor.bias_spread > 4.0 && !sensor.gain_at_limit);
    }

    #[test]
    fn an_impossible_gain_stops_at_its_limit() {
        let sums = [sums_of(1.5, 2.0, &mut Noise::new(4), 0)];
        let sensor = solve("force_1_n", 2.0, PRIOR, &sums);
        assert!(sensor.gain_at_limit && (sensor.gain - 1.03).abs() < 1e-12);
        let fixed = solve("x_rad", 2.0, SensorPrior { gain_std: 0.0, ..PRIOR }, &sums);
        assert_eq!(fixed.gain, 1.0);
        assert!((fixed.bias_of(0) - 2.0).abs() < 3.0);
    }

    #[test]
    fn a_held_out_run_takes_its_zero_from_its_quiet_start_where_runs_were_tared_anew() {
        let mut noise = Noise::new(5);
        let tared = solve(
            "f_n",
            2.0,
            PRIOR,
            &[sums_of(1.0, -30.0, &mut noise, 0), sums_of(1.0, 30.0, &mut noise, 1)],
        );
        let agreed =
            solve("f_n", 2.0, PRIOR, &[sums_of(1.0, 1.0, &mut noise, 0), sums_of(1.0, 1.0, &mut noise, 1)]);
        let mut input = vec![0.0; 400];
        input[300] = 1.0;
        let predicted = vec![0.0; 400];
        let quiet = quiet_start(&input, &predicted, 2.0);
        assert_eq!(quiet, 301);
        let measured: Vec<f64> = (0..400).map(|_| 7.0 + 2.0 * noise.normal()).collect();
        let zero = judge_zero(&tared, 2.0, &measured, &predicted, quiet);
        assert!((zero - 7.0).abs() < 0.6, "{zero}");
        let mut glitch = measured.clone();
        glitch[40] += 400.0;
        let spiked = judge_zero(&tared, 2.0, &glitch, &predicted, quiet);
        assert!((spiked - zero).abs() < 0.05, "{spiked} {zero}");
        let common = judge_zero(&agreed, 2.0, &measured[..2], &predicted[..2], 2);
        assert!((common - 1.0).abs() < 0.3, "{common}");
        assert_eq!(judge_zero(&agreed, 2.0, &measured, &predicted, 0), agreed.bias);
        // A command that never changes excites nothing, and proves nothing about rest.
        assert_eq!(quiet_start(&predicted, &predicted, 2.0), 0);
    }

    #[test]
    fn a_zero_is_free_within_a_step_and_no_farther() {
        for (off, zero) in [(0.0, 0.0), (0.3, 0.3), (-0.5, -0.5), (4.0, 0.5), (-4.0, -0.5)] {
            let rows: Vec<f64> = (-10..=10).map(|i| off + 0.05 * f64::from(i)).collect();
            assert!((within_a_step(rows, 1.0) - zero).abs() < 1e-12, "{off}");
        }
        assert_eq!(within_a_step(Vec::new(), 1.0), 0.0);
    }
}
