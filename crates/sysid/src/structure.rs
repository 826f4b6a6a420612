//! Tests of what a residual depends on, and what each dependence suggests.
//!
//! A residual that is noise is white, and independent of past input, of the direction of motion, of the
//! rotor's angle and of everything else. Each test is a small regression of every run and channel's
//! residual on a few signals of the prediction; its outcome is the share of the squared residual that they
//! explain, beside the share that chance would explain. These are hints for a reader: the effect itself is
//! found by simulating it (screening), because friction inside a resonant loop does not leave a residual
//! in the shape of friction.

use crate::data::{Data, Evaluation};
use crate::{locate, resample, stats};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sealegs_model::internal;

/// The outcome of one test.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureTest {
    /// What the residual should not depend on.
    pub on: &'static str,
    /// Share of the squared residual that it explains.
    pub explained: f64,
    /// Share that the same number of meaningless signals would explain, with a margin of two.
    pub by_chance: f64,
    /// A number that goes with it: the strongest harmonic, a correlation time.
    pub detail: Option<String>,
    /// What a dependence suggests.
    pub suggests: &'static str,
}

impl StructureTest {
    /// Whether the dependence is there, and large enough to matter (1 % of the squared residual).
    #[must_use]
    pub fn depends(&self) -> bool {
        self.explained > self.by_chance.max(0.01)
    }
}

/// What white noise does not depend on.
pub(crate) const OWN_PAST: &str = "its own past";

/// Harmonics of the rotor's turn that are tried.
const HARMONICS: usize = 24;
/// Lags of the input, in samples.
const LAGS: [usize; 10] = [0, 1, 2, 3, 5, 8, 13, 21, 34, 55];

/// Time constants with which what a run begins with fades, s: a drive settles in a tenth of a second, a joint in half of one.
const SETTLING_S: [f64; 2] = [0.1, 0.5];

/// All tests over one or several evaluations.
#[must_use]
pub fn tests(parts: &[(&Data, &Evaluation)]) -> Vec<StructureTest> {
    let places = locate::places(parts);
    // Of the actuators of a leg the one that explains most; the best of many is larger by chance than any one of them.
    let columns = |build: &Columns| {
        let each = places.iter().map(|place| regress(parts, place, build));
        let best = each.max_by(|a, b| a.explained.total_cmp(&b.explained));
        best.map_or(Outcome::NOTHING, |o| Outcome { by_chance: places.len() as f64 * o.by_chance, ..o })
    };
    let mut tests = vec![whiteness(parts)];
    let mut push = |on, suggests, outcome: Outcome, detail: Option<String>| {
        let Outcome { explained, by_chance, place } = outcome;
        let place = (!place.is_empty()).then(|| format!("at {place}"));
        let detail = detail.into_iter().chain(place).reduce(|a, b| format!("{a} {b}"));
        tests.push(StructureTest { on, explained, by_chance, detail, suggests });
    };
    push(
        "past input",
        "linear dynamics that the model lacks or has wrong: a delay or lag in drive or sensor, a resonance, a parameter at its bound",
        regress(parts, "", &|s| {
            let u = s.input.as_ref()?;
            Some(LAGS.iter().map(|&lag| (0..u.len()).map(|i| u[i.saturating_sub(lag)]).collect()).collect())
        }),
        None,
    );
    push(
        "sign of the speed",
        "dry friction: coulomb-friction, stribeck-friction, presliding-friction, or with offset direction-dependent-friction",
        columns(&|s| {
            let v = s.signal(internal::SCREW_SPEED)?;
            let still = 0.01 * v.iter().fold(0.0f64, |p, x| p.max(x.abs()));
            Some(vec![v.iter().map(|x| if x.abs() > still { x.signum() } else { 0.0 }).collect()])
        }),
        None,
    );
    push(
        "speed squared",
        "quadratic-drag, or voltage-saturation at the highest speeds",
        columns(&|s| {
            let v = s.signal(internal::SCREW_SPEED)?;
            Some(vec![v.iter().map(|x| x * x.abs()).collect()])
        }),
        None,
    );
    push(
        "load in the direction of motion",
        "load-dependent-friction",
        columns(&|s| {
            let (v, f) = (s.signal(internal::SCREW_SPEED)?, s.signal(internal::SCREW_FORCE)?);
            Some(vec![v.iter().zip(&f).map(|(v, f)| f.abs() * v.signum()).collect()])
        }),
        None,
    );
    push(
        "cube of the deflection",
        "hardening-spring, or backlash where the deflection is small",
        columns(&|s| {
            let d = s.signal(internal::SPRING_DEFLECTION)?;
            Some(vec![d.iter().map(|x| x.powi(3)).collect()])
        }),
        None,
    );
    let harmonics: Vec<Outcome> = (1..=HARMONICS)
        .map(|n| {
            columns(&|s| {
                let angle = s.signal(internal::ROTOR_ANGLE)?;
                let wave = |f: fn(f64) -> f64| angle.iter().map(|a| f(n as f64 * a)).collect();
                Some(vec![wave(f64::sin), wave(f64::cos)])
            })
        })
        .collect();
    if let Some((n, best)) =
        harmonics.iter().enumerate().max_by(|a, b| a.1.explained.total_cmp(&b.1.explained))
    {
        // The best of many is larger by chance than any one of them.
        let outcome = Outcome { by_chance: 2.0 * best.by_chance, ..*best };
        push("rotor angle", "torque-ripple", outcome, Some(format!("{} cycles a turn", n + 1)));
    }
    push(
        "start of the run",
        "the state that a run begins in, taken from its first rows; or a drive or a sensor that was still settling",
        regress(parts, "", &|s| {
            let first = s.time.first()?;
            let fading = |over: &f64| s.time.iter().map(|t| (-(t - first) / over).exp()).collect();
            Some(SETTLING_S.iter().map(fading).collect())
        }),
        None,
    );
    push(
        "time in the run",
        "drift: warming up, a creeping zero; or an excitation whose amplitude changes with time",
        regress(parts, "", &|s| Some(vec![s.time.clone()])),
        None,
    );
    tests
}

/// One block's residual with the signals of its run, at the scored rows.
struct Series<'a> {
    data: &'a Data<'a>,
    at: &'a Evaluation,
    place: &'a str,
    run: usize,
    time: Vec<f64>,
    input: Option<Vec<f64>>,
}

impl Series<'_> {
    fn signal(&self, name: &str) -> Option<Vec<f64>> {
        let values = self.at.predictions[self.run].internal_at(self.place, name)?;
        Some(self.data.runs[self.run].rows().map(|i| values[i]).collect())
    }
}

/// What makes the columns of a regression out of a run; none where it has no such signal.
type Columns<'c> = dyn Fn(&Series) -> Option<Vec<Vec<f64>>> + Sync + 'c;

struct Outcome<'p> {
    explained: f64,
    by_chance: f64,
    place: &'p str,
}

impl Outcome<'_> {
    const NOTHING: Self = Self { explained: 0.0, by_chance: 1.0, place: "" };
}

/// Regresses every block's residual on a mean and the columns that `build` makes of its run's signals at a place.
fn regress<'p>(parts: &[(&Data, &Evaluation)], place: &'p str, build: &Columns) -> Outcome<'p> {
    let jobs: Vec<(&Data, &Evaluation, usize)> =
        parts.iter().flat_map(|(d, e)| (0..e.blocks.len()).map(move |b| (*d, *e, b))).collect();
    let sums: Vec<(f64, f64, f64)> = jobs
        .into_par_iter()
        .map(|(data, at, block)| {
            let block = &at.blocks[block];
            let run = &data.runs[block.run];
            let series = Series {
                data,
                at,
                place,
                run: block.run,
                time: run.rows().map(|i| run.record.time_s[i]).collect(),
                input: run.record.inputs.first().map(|s| run.rows().map(|i| s.values[i]).collect()),
            };
            let mean = stats::mean(&block.residual);
            let r: Vec<f64> = block.residual.iter().map(|v| v - mean).collect();
            let total: f64 = r.iter().map(|v| v * v).sum();
            let Some(columns) = build(&series) else { return (0.0, total, 0.0) };
            let alike = memory(&r);
            let chance = 2.0 * columns.len() as f64 * alike / r.len().max(1) as f64;
            (explained(&r, columns), total, chance.min(1.0) * total)
        })
        .collect();
    let (mut part, mut total, mut chance) = (0.0, 0.0, 0.0);
    for (a, b, c) in sums {
        part += a;
        total += b;
        chance += c;
    }
    if total > 0.0 {
        Outcome { explained: part / total, by_chance: chance / total, place }
    } else {
        Outcome::NOTHING
    }
}

/// Sum of squares of the best linear combination of the columns (their means removed).
fn explained(r: &[f64], mut columns: Vec<Vec<f64>>) -> f64 {
    for column in &mut columns {
        let mean = stats::mean(column);
        column.iter_mut().for_each(|v| *v -= mean);
        let size = stats::rms(column);
        if size > 0.0 {
            column.iter_mut().for_each(|v| *v /= size);
        }
    }
    let n = columns.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut a = DMatrix::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]));
    let g = DVector::from_fn(n, |i, _| dot(&columns[i], r));
    for i in 0..n {
        a[(i, i)] += 1e-9 * r.len() as f64 + f64::MIN_POSITIVE;
    }
    a.cholesky().map_or(0.0, |c| g.dot(&c.solve(&g)).max(0.0))
}

/// Samples that say the same thing: one plus twice the sum of the leading positive autocorrelations.
fn memory(r: &[f64]) -> f64 {
    let total: f64 = r.iter().map(|v| v * v).sum();
    if total <= 0.0 {
        return 1.0;
    }
    let mut sum = 1.0;
    let mut lag = 1;
    let mut width = 1;
    // Lags in growing strides: the sum, not its details, is wanted.
    while lag < r.len() / 4 {
        let rho = r.iter().zip(&r[lag..]).map(|(a, b)| a * b).sum::<f64>() / total;
        if rho < 0.05 {
            break;
        }
        sum += 2.0 * rho * width as f64;
        width = (lag / 8).max(1);
        lag += width;
    }
    sum
}

/// Is the residual white: share of its variance that its own past explains (one step ahead).
fn whiteness(parts: &[(&Data, &Evaluation)]) -> StructureTest {
    let (mut part, mut total, mut rows, mut time, mut weight) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (data, at) in parts {
        for block in &at.blocks {
            let run = &data.runs[block.run];
            let stamps: Vec<f64> = run.rows().map(|i| run.record.time_s[i]).collect();
            let period = stats::median_period(&stamps);
            let mut even = resample::uniform(&stamps, &block.residual, period, false);
            let mean = stats::mean(&even);
            even.iter_mut().for_each(|v| *v -= mean);
            let squares: f64 = even.iter().map(|v| v * v).sum();
            if squares <= 0.0 {
                continue;
            }
            let rho = even.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / squares;
            part += rho * rho * squares;
            total += squares;
            rows += even.len() as f64;
            time += memory(&even) * period * squares;
            weight += squares;
        }
    }
    StructureTest {
        on: OWN_PAST,
        explained: if total > 0.0 { part / total } else { 0.0 },
        by_chance: 8.0 / f64::max(rows, 1.0),
        detail: (weight > 0.0).then(|| format!("correlation time {:.1} ms", 1e3 * time / weight)),
        suggests: "the residual is not sensor noise: something that moves or drifts is missing from the model",
    }
}
