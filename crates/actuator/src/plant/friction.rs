//! Dry friction on one coordinate over one step, event by event: slip, reversal within the step, stick.
//!
//! Within a step the velocity is taken as piecewise linear in time. A coordinate that comes to rest while
//! the applied force is within the bound stays there exactly: there is no regularising speed and no creep.

/// One coordinate over one step, without the friction that is to be found.
#[derive(Debug, Clone, Copy)]
pub struct Sliding {
    /// Velocity at the start of the step, m/s.
    pub before: f64,
    /// Velocity at the end of the step if there were no friction, m/s.
    pub after_free: f64,
    /// Change of the velocity at the end per newton of mean friction force over the step, m/s/N.
    pub mobility: f64,
}

impl Sliding {
    /// The mean friction force over the step in N.
    ///
    /// `bound(speed, direction)` is the bound in N while slipping at that speed in that direction (+1 or
    /// -1); speed 0 asks for the bound at rest. The force opposes the motion, or holds the coordinate.
    #[must_use]
    pub fn mean_force(&self, bound: impl Fn(f64, f64) -> f64) -> f64 {
        let Self { before, after_free, mobility } = *self;
        let holding = -after_free / mobility;
        if before == 0.0 {
            let direction = after_free.signum();
            if holding.abs() <= bound(0.0, direction) {
                return holding;
            }
            return -direction * self.slipping_bound(direction, &bound);
        }
        let direction = before.signum();
        let slipping = -direction * self.slipping_bound(direction, &bound);
        let after = after_free + mobility * slipping;
        if after * direction >= 0.0 {
            return slipping;
        }
        // The velocity passes zero within the step: afterwards the coordinate sticks or slips back.
        let rest = -after / (before - after);
        let free_change = after_free - before;
        let back = -direction;
        if free_change.abs() <= mobility * bound(0.0, back) {
            return holding;
        }
        let after = (free_change - back * mobility * bound(0.0, back).min(bound(after_free, back))) * rest;
        (after - after_free) / mobility
    }

    /// The bound at the mean speed of the step, by one fixed-point correction of the frictionless guess.
    fn slipping_bound(&self, direction: f64, bound: &impl Fn(f64, f64) -> f64) -> f64 {
        let mean = |f: f64| {
            let after = self.after_free - direction * self.mobility * f;
            // Past a reversal only the part before it counts as slip in this direction.
            0.5 * (self.before + after * f64::from(u8::from(after * direction > 0.0)))
        };
        let first = bound(mean(0.0), direction);
        bound(mean(first), direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_sticks_within_the_bound() {
        let s = Sliding { before: 0.0, after_free: 3e-3, mobility: 1e-3 };
        let f = s.mean_force(|_, _| 5.0);
        assert_eq!(s.after_free + s.mobility * f, 0.0);
        assert!((s.mean_force(|_, _| 2.0) + 2.0).abs() < 1e-15);
    }

    #[test]
    fn analytic_reversal_within_a_step() {
        // Constant force -10 N on 1 kg with 4 N friction from +0.7 m/s over 0.1 s: decelerates at 14 m/s^2
        // for 0.05 s, then accelerates back at 6 m/s^2 for 0.05 s.
        let s = Sliding { before: 0.7, after_free: 0.7 - 1.0, mobility: 0.1 };
        let after = s.after_free + s.mobility * s.mean_force(|_, _| 4.0);
        assert!((after + 0.3).abs() < 1e-12, "{after}");
    }

    #[test]
    fn analytic_comes_to_rest_and_stays() {
        let s = Sliding { before: 0.2, after_free: 0.1, mobility: 0.1 };
        let after = s.after_free + s.mobility * s.mean_force(|_, _| 4.0);
        assert_eq!(after, 0.0);
    }
}
