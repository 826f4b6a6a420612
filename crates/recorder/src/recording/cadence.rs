//! How often a recording wants what: scalars at 1 kHz, poses at 100 Hz.

/// Scalars are wanted this often, s.
const SCALAR_PERIOD_S: f64 = 1e-3;
/// Poses are wanted this often, s.
const POSE_PERIOD_S: f64 = 1e-2;

/// What a frame at some time should bring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Due {
    /// The scalars.
    pub scalars: bool,
    /// The poses.
    pub poses: bool,
}

impl Due {
    /// Whether nothing is wanted.
    #[must_use]
    pub fn nothing(self) -> bool {
        !self.scalars && !self.poses
    }
}

/// When scalars and poses are due next, whatever the step of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cadence {
    next_scalars_s: f64,
    next_poses_s: f64,
}

impl Default for Cadence {
    fn default() -> Self {
        Self { next_scalars_s: f64::NEG_INFINITY, next_poses_s: f64::NEG_INFINITY }
    }
}

impl Cadence {
    /// What a frame at `time_s` should bring.
    #[must_use]
    pub fn due(&self, time_s: f64) -> Due {
        // Half a nanosecond of slack: the recording counts in nanoseconds.
        let slack = 5e-10;
        Due { scalars: time_s + slack >= self.next_scalars_s, poses: time_s + slack >= self.next_poses_s }
    }

    /// Goes on after a frame at `time_s` that brought this.
    pub fn took(&mut self, time_s: f64, brought: Due) {
        if brought.scalars {
            advance(&mut self.next_scalars_s, time_s, SCALAR_PERIOD_S);
        }
        if brought.poses {
            advance(&mut self.next_poses_s, time_s, POSE_PERIOD_S);
        }
    }
}

/// Moves the next due time on by whole periods, so that it keeps its beat and never lies in the past.
fn advance(next_s: &mut f64, time_s: f64, period_s: f64) {
    let from = if next_s.is_finite() { *next_s } else { time_s };
    let periods = ((time_s - from) / period_s + 1e-6).floor().max(0.0) + 1.0;
    *next_s = from + periods * period_s;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn due_times_keep_their_beat_at_any_step() {
        for step_s in [1e-4_f64, 1e-3 / 3.0, 2.5e-4, 7e-4] {
            let mut next = f64::NEG_INFINITY;
            let mut count = 0;
            for i in 0..=(1.0 / step_s).round() as usize {
                let time_s = i as f64 * step_s;
                if time_s + 5e-10 >= next {
                    count += 1;
                    advance(&mut next, time_s, SCALAR_PERIOD_S);
                }
            }
            assert!((1000..=1001).contains(&count), "step {step_s}: {count}");
        }
        // Steps longer than the period: every one.
        let mut next = f64::NEG_INFINITY;
        for i in 0..10 {
            let time_s = 0.005 * f64::from(i);
            assert!(time_s + 5e-10 >= next);
            advance(&mut next, time_s, SCALAR_PERIOD_S);
        }
    }
}
