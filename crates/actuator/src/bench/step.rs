//! How long the integrator's steps may be.

use sealegs_model::{InputHold, Record};

/// Steps per sampling period under a band-limited command.
const SMOOTH_STEPS_PER_PERIOD: f64 = 4.0;

/// Steps per sample that a search takes of a drive without a spring over those that it takes of one with it: without one nothing
/// moves faster than the samples show, and the integrator is of second order.
const WITHOUT_SPRINGS: f64 = 0.25;

/// A search takes no longer steps than that, s, or than a sample: 12 rad/s go 0.05 rad in it, and it is a quarter of a radian
/// of what the loop of a stiff hobby servo oscillates at, 60 rad/s.
const LONGEST_SEARCH_STEP_S: f64 = 4e-3;

/// The step, s, of drives without springs in a search that takes so many steps per sample of one with a spring.
#[must_use]
pub fn search_step_without_springs(period_s: f64, steps_per_sample: f64) -> f64 {
    let sampled_s = period_s / (steps_per_sample * WITHOUT_SPRINGS).max(1.0);
    sampled_s.max(LONGEST_SEARCH_STEP_S.min(2.0 * period_s))
}

/// The step, s, of a record's simulation whose own step is `step_s`: a longer one where that is enough, or where a search takes
/// so many steps per sample.
pub(super) fn of_record(record: &Record, step_s: f64, steps_per_sample: Option<f64>, rigid: bool) -> f64 {
    let period_s = record.mean_period_s();
    // A smooth command needs no finer steps than its own band, for the linear part is exact.
    let enough = (record.hold == InputHold::BandLimited).then_some(period_s / SMOOTH_STEPS_PER_PERIOD);
    let searched =
        steps_per_sample.map(|n| if rigid { search_step_without_springs(period_s, n) } else { period_s / n });
    [enough, searched].into_iter().flatten().fold(step_s, f64::max)
}
