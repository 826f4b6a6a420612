//! Linear regression of missing signals: hat functions, what is known of nuisances, and prediction of left-out blocks.

use crate::stats;
use nalgebra::{DMatrix, DVector};

/// What a wrong base parameter would show in a missing signal.
#[derive(Debug, Clone)]
pub(crate) struct Nuisance {
    /// Its change, run by run at the scored rows: by one standard deviation of what is known of the parameter, or by any
    /// amount where nothing is known.
    pub runs: Vec<Vec<f64>>,
    /// Whether anything is known.
    pub known: bool,
}

/// The weight of what is known of nuisances in normal equations, one for each that counts: the squares of a signal over its
/// independent samples. Without it links without mass would explain every torque: the command alone is left then.
pub(crate) fn known_weights(nuisances: &[Nuisance], signal: &[f64]) -> Vec<f64> {
    let mean = stats::mean(signal);
    let signal: Vec<f64> = signal.iter().map(|v| v - mean).collect();
    let squares: f64 = signal.iter().map(|v| v * v).sum();
    let weight = squares / stats::independent(&signal).max(1.0);
    nuisances.iter().map(|n| if n.known { weight } else { 0.0 }).collect()
}

/// Adds weights to the diagonal of normal equations, to their first columns.
fn add_known(weights: &[f64], a: &mut DMatrix<f64>) {
    weights.iter().enumerate().for_each(|(k, weight)| a[(k, k)] += weight);
}

/// Hats whose ordinates are held near straight lines (Eilers and Marx 1996): where a left-out stretch alone has reached, a
/// curve goes on as it was and does not fall to zero.
pub(crate) struct Smooth<'a> {
    pub first: usize,
    pub knots: &'a [f64],
}

/// Weight of a departure from a straight line over the mean weight of an ordinate in the data.
const STRAIGHT: f64 = 1e-3;

impl Smooth<'_> {
    /// Adds the weight to the normal equations.
    pub(crate) fn add_to(&self, a: &mut DMatrix<f64>) {
        let n = self.knots.len();
        let weight = STRAIGHT * (0..n).map(|k| a[(self.first + k, self.first + k)]).sum::<f64>() / n as f64;
        for k in 1..n.saturating_sub(1) {
            let (before, after) = (self.knots[k] - self.knots[k - 1], self.knots[k + 1] - self.knots[k]);
            let bend = [after / (before + after), -1.0, before / (before + after)];
            for i in 0..3 {
                for j in 0..3 {
                    a[(self.first + k - 1 + i, self.first + k - 1 + j)] += weight * bend[i] * bend[j];
                }
            }
        }
    }
}

/// Knots, each once: half of them at quantiles, where the samples are, half of them even, as what bends only far out (a sensor
/// at its range, a spring beyond a stop) has few samples there.
pub(crate) fn quantiles(x: &[f64], knots: usize) -> Vec<f64> {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    // The ends are in both halves.
    let dense = knots / 2 + 1;
    let even = knots - dense + 2;
    let along = |k: usize| k as f64 / (even - 1) as f64;
    let mut at: Vec<f64> = (0..dense).map(|k| sorted[k * last / (dense - 1)]).collect();
    at.extend((0..even).map(|k| sorted[0] + along(k) * (sorted[last] - sorted[0])));
    at.sort_by(f64::total_cmp);
    // A knot near an end has few samples of its own, and a fit would let its ordinate run away.
    let apart = 3e-2 * (sorted[last] - sorted[0]);
    at.dedup_by(|b, a| *b - *a <= apart);
    at
}

/// Hat functions at knots, one column each.
pub(crate) fn hats(x: &[f64], knots: &[f64]) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; x.len()]; knots.len()];
    for (i, &v) in x.iter().enumerate() {
        let k = knots.partition_point(|&knot| knot <= v).clamp(1, knots.len().max(2) - 1);
        if knots.len() < 2 {
            columns[0][i] = 1.0;
            continue;
        }
        let along = ((v - knots[k - 1]) / (knots[k] - knots[k - 1])).clamp(0.0, 1.0);
        columns[k - 1][i] = 1.0 - along;
        columns[k][i] = along;
    }
    columns
}

/// `A` and `b` of the normal equations over some rows, columns in their own size.
fn normal(
    columns: &[Vec<f64>],
    target: &[f64],
    rows: impl Iterator<Item = usize>,
) -> (DMatrix<f64>, DVector<f64>) {
    let n = columns.len();
    let (mut a, mut b) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for i in rows {
        for k in 0..n {
            let c = columns[k][i];
            if c == 0.0 {
                continue;
            }
            b[k] += c * target[i];
            for l in k..n {
                a[(k, l)] += c * columns[l][i];
            }
        }
    }
    for k in 0..n {
        for l in 0..k {
            a[(k, l)] = a[(l, k)];
        }
    }
    (a, b)
}

/// Solves the normal equations; directions about which nothing is known stay at zero.
fn solve(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = b.len();
    let scale: Vec<f64> = (0..n).map(|k| 1.0 / a[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let mut scaled = DMatrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]);
    (0..n).for_each(|k| scaled[(k, k)] += 1e-6);
    let right = DVector::from_fn(n, |i, _| b[i] * scale[i]);
    let solution = scaled.cholesky().map_or_else(|| DVector::zeros(n), |c| c.solve(&right));
    DVector::from_fn(n, |i, _| solution[i] * scale[i])
}

/// Coefficients of a regression on all rows, `known` as in [`left_out`], with the normal equations that gave them.
pub(crate) fn regressed(
    columns: &[Vec<f64>],
    target: &[f64],
    (known, smooth): (&[f64], Option<Smooth>),
) -> (DMatrix<f64>, DVector<f64>) {
    let (mut a, b) = normal(columns, target, 0..target.len());
    add_known(known, &mut a);
    if let Some(smooth) = smooth {
        smooth.add_to(&mut a);
    }
    let x = solve(&a, &b);
    (a, x)
}

/// Sum of squares that is left of blocks, each predicted by the others; `known` are the weights of what is known of the first
/// columns.
pub(crate) fn left_out(
    columns: &[Vec<f64>],
    target: &[f64],
    block: &[usize],
    (known, smooth): (&[f64], Option<Smooth>),
) -> f64 {
    let n = columns.len();
    let blocks = block.iter().max().map_or(0, |b| b + 1);
    let of = |k: usize| (0..target.len()).filter(move |&i| block[i] == k);
    let parts: Vec<_> = (0..blocks).map(|k| normal(columns, target, of(k))).collect();
    let zero = (DMatrix::zeros(n, n), DVector::zeros(n));
    let (a, b) = parts.iter().fold(zero, |(a, b), part| (a + &part.0, b + &part.1));
    let mut squares = 0.0;
    for (k, part) in parts.iter().enumerate() {
        let mut rest = &a - &part.0;
        add_known(known, &mut rest);
        if let Some(smooth) = &smooth {
            smooth.add_to(&mut rest);
        }
        let x = solve(&rest, &(&b - &part.1));
        for i in of(k) {
            let said: f64 = (0..n).map(|c| x[c] * columns[c][i]).sum();
            squares += (target[i] - said).powi(2);
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Noise;

    const KNOTS: usize = 12;

    #[test]
    fn analytic_hats_reproduce_a_line_and_sum_to_one() {
        let x: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01 - 1.0).collect();
        let knots = quantiles(&x, KNOTS);
        let columns = hats(&x, &knots);
        for i in 0..x.len() {
            let line: f64 = (0..knots.len()).map(|k| columns[k][i] * knots[k]).sum();
            let one: f64 = (0..knots.len()).map(|k| columns[k][i]).sum();
            assert!((line - x[i]).abs() < 1e-12 && (one - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_curve_foresees_left_out_blocks_and_noise_does_not() {
        let mut noise = Noise::new(1);
        let x: Vec<f64> = (0..4000).map(|_| 2.0 * noise.uniform() - 1.0).collect();
        let target: Vec<f64> = x.iter().map(|v| v.abs() + 0.1 * noise.normal()).collect();
        let block: Vec<usize> = (0..4000).map(|i| i / 400).collect();
        let one = vec![vec![1.0; 4000]];
        let knots = quantiles(&x, KNOTS);
        let with: Vec<Vec<f64>> = one.iter().cloned().chain(hats(&x, &knots)).collect();
        let (alone, left) =
            (left_out(&one, &target, &block, (&[], None)), left_out(&with, &target, &block, (&[], None)));
        // |x| has the variance 1/12; the noise 0.01, and the hats cost 12 of 4000 degrees of freedom.
        assert!((left / 4000.0 - 0.01).abs() < 0.001 && alone / 4000.0 > 0.08, "{left} {alone}");
        let pure: Vec<f64> = (0..4000).map(|_| noise.normal()).collect();
        assert!(
            left_out(&with, &pure, &block, (&[], None)) >= 0.999 * left_out(&one, &pure, &block, (&[], None))
        );
    }

    #[test]
    fn analytic_a_curve_goes_on_straight_where_a_left_out_block_alone_has_reached() {
        // y = 3 x with a column of x beside the hats; the last block alone goes beyond 1.
        let x: Vec<f64> =
            (0..1000).map(|i| f64::from(i % 100) * if i < 900 { 0.01 } else { 0.02 } - 0.5).collect();
        let target: Vec<f64> = x.iter().map(|v| 3.0 * v).collect();
        let block: Vec<usize> = (0..1000).map(|i| i / 100).collect();
        let knots = quantiles(&x, KNOTS);
        let columns: Vec<Vec<f64>> = [x.clone()].into_iter().chain(hats(&x, &knots)).collect();
        let left = left_out(&columns, &target, &block, (&[], Some(Smooth { first: 1, knots: &knots })));
        assert!((left / 1000.0).sqrt() < 1e-3, "{left}");
    }

    #[test]
    fn links_of_known_mass_do_not_take_the_command_away() {
        // A command moves a mass of 20 standard deviations against friction: u = 20 n + s. What is missing is the friction s.
        // With the mass free it is u - 20 n as well: no mass, no command.
        let mass: Vec<f64> = (0..2000).map(|i| (f64::from(i) * 0.031).sin()).collect();
        let friction: Vec<f64> = (0..2000).map(|i| (f64::from(i) * 0.031).cos().signum()).collect();
        let command: Vec<f64> = mass.iter().zip(&friction).map(|(n, s)| 20.0 * n + s).collect();
        let block: Vec<usize> = (0..2000).map(|i| i / 200).collect();
        let known = [Nuisance { runs: vec![mass.clone()], known: true }];
        let base = vec![mass];
        let with: Vec<Vec<f64>> = base.iter().cloned().chain([command]).collect();
        let alone = left_out(&base, &friction, &block, (&known_weights(&known, &friction), None));
        let free = left_out(&with, &friction, &block, (&[], None));
        let held = left_out(&with, &friction, &block, (&known_weights(&known, &friction), None));
        assert!(free < 0.01 * alone && held > 0.5 * alone, "{alone}: {free}, {held}");
    }
}
