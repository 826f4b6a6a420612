//! How a fitted candidate predicts what was left out of the fit, from the fit to everything.

use super::symbol;
use crate::data::{Data, Evaluation};
use crate::diagnose::policy::AT_FLOOR;
use crate::fit::{Fit, dot};
use nalgebra::{DMatrix, DVector};
use sealegs_model::Model;

/// Stretches of each run that are left out one at a time, where the runs are few; else whole runs are: what
/// holds only at one amplitude must not hold up.
const STRETCHES: usize = 6;

/// From so many runs on whole runs are left out.
const ENOUGH_RUNS: usize = 3;

/// Squares of a left-out stretch, as a ratio of what the fit to everything leaves there, beyond which the linear step is
/// not believed: where a light foot rattles, a derivative says nothing of the next millimetre.
const ROUGH: f64 = 4.0;

/// Times that a step which does the rest no good is halved.
const HALVINGS: i32 = 6;

/// Sum of squares, in squared noise units, of what an effect changes where it has been felt.
const FELT: f64 = 10.0;

/// Prediction errors on left-out stretches of the fit runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Sum of squared residuals in noise units of each left-out stretch.
    pub stretches: Vec<f64>,
    /// Number of residuals in all of them.
    pub residuals: usize,
}

impl Validation {
    /// Mean squared residual, in squared noise units.
    #[must_use]
    pub fn mean_square(&self) -> f64 {
        self.stretches.iter().sum::<f64>() / self.residuals.max(1) as f64
    }
}

/// Leaves out one stretch of one run at a time, or one run, and predicts it with the parameters that the rest would have
/// given: one Gauss-Newton step from the fit to everything, which is exact where the residual is linear in
/// the parameters. Where it predicts far worse than the fit itself, the step is taken in simulations, as far as it
/// lowers the cost of the rest.
///
/// An effect that only what is left out has felt (a limit that one run alone reached) cannot be known without it: there
/// the model predicts without that effect, unless nothing but the stated noise is left of all runs with it. So many samples
/// cannot be met by chance (where repeats differ by more than the noise they can: what they leave is no white noise), and
/// what it says of other amplitudes is for the holdout runs to judge.
pub(crate) fn validate(data: &Data, model: &dyn Model, effects: &[String], fit: &Fit) -> Validation {
    let p = fit.free.len();
    let all_explained = fit.error() <= AT_FLOOR;
    let traced: &[String] = if all_explained { &[] } else { effects };
    let traces: Vec<Option<Trace>> = traced.iter().map(|e| Trace::of(data, model, fit, e)).collect();
    let mut stretches = Vec::new();
    let mut residuals = 0;
    let runs = fit.evaluation.blocks.iter().map(|b| b.run).max().map_or(0, |r| r + 1);
    for run in 0..runs {
        let blocks: Vec<usize> =
            (0..fit.evaluation.blocks.len()).filter(|&b| fit.evaluation.blocks[b].run == run).collect();
        let rows = blocks.iter().map(|&b| fit.evaluation.blocks[b].residual.len()).max().unwrap_or(0);
        let parts = if runs >= ENOUGH_RUNS { 1 } else { STRETCHES };
        for stretch in 0..parts {
            let from = rows * stretch / parts;
            let to = rows * (stretch + 1) / parts;
            let mut left = fit.normal.clone();
            let mut gradient = DVector::<f64>::zeros(p);
            for &b in &blocks {
                let columns = &fit.jacobian[b].columns;
                let residual = &fit.evaluation.blocks[b].residual[from..to];
                for i in 0..p {
                    let ci = &columns[i][from..to];
                    gradient[i] += dot(ci, residual);
                    for j in 0..=i {
                        let product = dot(ci, &columns[j][from..to]);
                        left[(i, j)] -= product;
                        if i != j {
                            left[(j, i)] -= product;
                        }
                    }
                }
            }
            let unknown: Vec<&str> = traced
                .iter()
                .zip(&traces)
                .filter(|(_, trace)| trace.as_ref().is_some_and(|t| t.outside(run, from, to) < FELT))
                .map(|(effect, _)| effect.as_str())
                .collect();
            let without = if unknown.is_empty() { None } else { without(data, model, fit, run, &unknown) };
            // What is at a bound stays there.
            for k in 0..p {
                if fit.parameters[fit.free[k]].at_bound.is_some() {
                    left.row_mut(k).fill(0.0);
                    left.column_mut(k).fill(0.0);
                    left[(k, k)] = 1.0;
                    gradient[k] = 0.0;
                }
            }
            let mut shift = solve(left, &gradient);
            // What has been taken away has no parameters to move.
            for k in (0..p).filter(|_| without.is_some()) {
                let name = &fit.parameters[fit.free[k]].name;
                if unknown.iter().any(|e| symbol(name, e).is_some()) {
                    shift[k] = 0.0;
                }
            }
            let (mut squares, mut fitted) = (0.0, 0.0);
            for &b in &blocks {
                let residual =
                    without.as_ref().map_or(&fit.evaluation.blocks[b].residual, |e| &e.blocks[b].residual);
                let residual = &residual[from..to];
                let columns = &fit.jacobian[b].columns;
                for (n, r) in residual.iter().enumerate() {
                    let moved: f64 = (0..p).map(|k| columns[k][from + n] * shift[k]).sum();
                    squares += (r + moved).powi(2);
                    fitted += r * r;
                }
                residuals += residual.len();
            }
            if without.is_none() && squares > ROUGH * fitted {
                let left_out = LeftOut { data, model, fit, blocks: &blocks, from, to };
                squares = left_out.stepped(shift.as_slice());
            }
            stretches.push(squares);
        }
    }
    Validation { stretches, residuals }
}

/// A stretch of a run that is left out of a fit.
struct LeftOut<'a> {
    data: &'a Data<'a>,
    model: &'a dyn Model,
    fit: &'a Fit,
    /// The run's blocks, and the rows of each.
    blocks: &'a [usize],
    from: usize,
    to: usize,
}

impl LeftOut<'_> {
    /// Sum of squares of the stretch at an evaluation.
    fn squares(&self, at: &Evaluation) -> f64 {
        self.blocks.iter().flat_map(|&b| &at.blocks[b].residual[self.from..self.to]).map(|r| r * r).sum()
    }

    /// The same after the step, halved until it lowers the cost of the rest; without a step where none does.
    fn stepped(&self, shift: &[f64]) -> f64 {
        let rest = |at: &Evaluation| 2.0 * at.cost - self.squares(at);
        let before = rest(&self.fit.evaluation);
        (0..HALVINGS)
            .map(|halving| shift.iter().map(|s| s * 0.5_f64.powi(halving)).collect::<Vec<f64>>())
            .filter_map(|shift| self.data.evaluate(self.model, &self.fit.shifted(self.model, &shift)).ok())
            .find(|at| rest(at) <= before)
            .map_or_else(|| self.squares(&self.fit.evaluation), |at| self.squares(&at))
    }
}

/// What an effect changes in the predictions of a fit, squared, in squared noise units.
struct Trace {
    /// For each run, at its scored rows, summed over the channels.
    runs: Vec<Vec<f64>>,
}

impl Trace {
    /// `None` if the effect cannot be taken away.
    fn of(data: &Data, model: &dyn Model, fit: &Fit, effect: &str) -> Option<Self> {
        let predictions = data.predict(model, &neutral(model, fit, &[effect])?).ok()?;
        let mut runs: Vec<Vec<f64>> = vec![Vec::new(); data.runs.len()];
        for block in &fit.evaluation.blocks {
            let (run, name) = (&data.runs[block.run], &data.runs[block.run].names[block.slot]);
            let with = fit.evaluation.predictions[block.run].output(name)?;
            let without = predictions[block.run].output(name)?;
            let noise = data.channels[block.channel].noise_std;
            let squares = run.rows().map(|i| ((with[i] - without[i]) / noise).powi(2));
            let sum = &mut runs[block.run];
            sum.resize(block.residual.len().max(sum.len()), 0.0);
            sum.iter_mut().zip(squares).for_each(|(s, v)| *s += v);
        }
        Some(Self { runs })
    }

    /// The sum outside a stretch of a run.
    fn outside(&self, run: usize, from: usize, to: usize) -> f64 {
        let sum = |rows: &[f64]| rows.iter().sum::<f64>();
        let inside: f64 = self.runs[run].get(from..to).map_or(0.0, sum);
        self.runs.iter().map(|rows| sum(rows)).sum::<f64>() - inside
    }
}

/// A fit's values with some effects at rest; `None` if they have no such value.
fn neutral(model: &dyn Model, fit: &Fit, effects: &[&str]) -> Option<Vec<f64>> {
    let mut values = fit.values.clone();
    for effect in effects {
        let mut any = false;
        for (value, p) in
            values.iter_mut().zip(model.parameters()).filter(|(_, p)| symbol(&p.name, effect).is_some())
        {
            any |= p.neutral.is_some();
            *value = p.neutral.unwrap_or(*value);
        }
        any.then_some(())?;
    }
    Some(values)
}

/// The fit's evaluation with one run predicted without some effects; `None` if that cannot be simulated.
fn without(data: &Data, model: &dyn Model, fit: &Fit, run: usize, effects: &[&str]) -> Option<Evaluation> {
    let values = neutral(model, fit, effects)?;
    let mut predictions = fit.evaluation.predictions.clone();
    predictions[run] = data.predict_run(run, model, &values).ok()?;
    Some(data.evaluate_prediction(&values, predictions))
}

/// Solves a positive definite system; directions about which nothing is known stay where they are.
fn solve(mut a: DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = b.len();
    for k in 0..n {
        // A thousandth of a typical change is never reason to move.
        a[(k, k)] += 1e-3 + 1e-9 * a[(k, k)].abs();
    }
    a.cholesky().map_or_else(|| DVector::zeros(n), |c| c.solve(b))
}

#[cfg(test)]
mod tests {
    use super::super::{Candidate, with_effects};
    use crate::campaign::Role;
    use crate::data::Data;
    use crate::fit::FitOptions;
    use crate::toy::{Noise, Toy, campaign, run};

    const TRUTH: [f64; 3] = [1.1, 5.0, 380.0];
    const NOISE: (f64, f64) = (0.2, 0.001);

    /// A run at a share of the usual amplitude, with a sensor that stiffens and so many times the stated noise.
    fn at(share: f64, times: f64, seed: u64) -> sealegs_model::Record {
        let mut record = run(&TRUTH, 800, seed, (0.0, 0.0), (1.0, 0.0), 1.0);
        let mut noise = Noise::new(1000 + seed);
        record.inputs[0].values.iter_mut().for_each(|v| *v *= share);
        for v in &mut record.outputs[0].values {
            let force = share * *v;
            *v = force + 1e-3 * force.powi(3) + times * NOISE.0 * noise.normal();
        }
        for v in &mut record.outputs[1].values {
            *v = share * *v + times * NOISE.1 * noise.normal();
        }
        record
    }

    fn fitted(data: &Data, toy: &Toy, effects: Vec<String>) -> Candidate {
        let model = with_effects(toy, &effects, &sealegs_model::Excitation::default()).unwrap();
        let options = FitOptions { starts: 1, max_steps: 20, ..FitOptions::default() };
        Candidate::fitted(data, effects, model, &options).unwrap()
    }

    /// Greatest mean square over the runs, each left out, without and with the effect.
    fn left_out(shares: [f64; 3], times: f64) -> [f64; 2] {
        let runs = shares.iter().zip(0..).map(|(&share, seed)| (Role::Fit, at(share, times, seed))).collect();
        let campaign = campaign(runs, NOISE);
        let toy = Toy::new();
        let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
        [vec![], vec!["cubic-sensor".to_owned()]].map(|effects| {
            let alone = effects.is_empty();
            let fitted = fitted(&data, &toy, effects);
            assert!(alone || fitted.fit.error() < 1.05 * times, "{}", fitted.fit.error());
            let each = fitted.validation.residuals as f64 / 3.0;
            fitted.validation.stretches.iter().map(|s| s / each).fold(0.0, f64::max)
        })
    }

    #[test]
    fn what_one_run_alone_has_felt_does_not_foresee_that_run() {
        let [without, with] = left_out([1.0, 1.0, 1.0], 1.2);
        assert!(without > 3.0 && with < 1.5, "felt in all: {without} {with}");
        let [without, with] = left_out([1.0, 0.05, 0.05], 1.2);
        assert!(without > 3.0 && with > 0.8 * without, "felt in one: {without} {with}");
    }

    #[test]
    fn what_leaves_nothing_but_noise_is_believed_where_one_run_alone_has_felt_it() {
        let [without, with] = left_out([1.0, 0.05, 0.05], 0.98);
        assert!(without > 2.0 && with < 0.1 * without, "{without} {with}");
    }

    #[test]
    fn a_derivative_that_says_nothing_does_not_spoil_what_a_fit_foresees() {
        let campaign = campaign((0..2).map(|seed| (Role::Fit, at(1.0, 1.0, seed))).collect(), NOISE);
        let toy = Toy::new();
        let data = Data::new(&campaign, Some(Role::Fit), &toy).unwrap();
        let effects = vec!["cubic-sensor".to_owned()];
        let fitted = fitted(&data, &toy, effects.clone());
        let smooth = fitted.validation.mean_square();
        let mut fit = fitted.fit.clone();
        // As after an impact: within one stretch the derivatives are large and of any sign.
        for (at, block) in fit.evaluation.blocks.iter().zip(&mut fit.jacobian) {
            for column in block.columns.iter_mut().filter(|_| at.run == 0) {
                column[..60].iter_mut().enumerate().for_each(|(i, d)| *d = 3000.0 * f64::cos(i as f64 * 7.0));
            }
        }
        let product = |i: usize, j: usize| -> f64 {
            fit.jacobian.iter().map(|b| super::dot(&b.columns[i], &b.columns[j])).sum()
        };
        fit.normal = nalgebra::DMatrix::from_fn(fit.free.len(), fit.free.len(), product);
        let rough = super::validate(&data, fitted.model.as_ref(), &effects, &fit).mean_square();
        assert!((smooth - 1.0).abs() < 0.1 && rough < 1.2 * smooth, "{smooth} {rough}");
    }
}
