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

/// Whether friction leaves a coordinate at rest at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Held {
    /// It moves.
    #[default]
    No,
    /// It is at rest.
    Yes,
}

impl Sliding {
    /// The mean friction force over the step in N.
    ///
    /// `bound(speed, direction)` is the bound in N while slipping at that speed in that direction (+1 or
    /// -1); speed 0 asks for the bound at rest. The force opposes the motion, or holds the coordinate.
    #[must_use]
    #[inline]
    pub fn mean_force(&self, bound: impl Fn(f64, f64) -> f64) -> f64 {
        let direction = if self.before == 0.0 { self.after_free } else { self.before }.signum();
        // The bound without friction is as good a guess as the one that follows from it is accurate.
        let guess = bound(self.mean_speed(0.0, direction), direction);
        self.resolve(guess, bound).0
    }

    /// As [`Sliding::mean_force`] from a guess of the bound, N, that is wrong by the order of the step, such
    /// as the bound in the step before; and whether the coordinate is at rest at the end.
    #[inline(always)]
    pub(super) fn resolve(&self, guess: f64, bound: impl Fn(f64, f64) -> f64) -> (f64, Held) {
        let Self { before, after_free, mobility } = *self;
        if before == 0.0 {
            let direction = after_free.signum();
            let at_rest = bound(0.0, direction);
            if after_free.abs() <= at_rest * mobility {
                return (-after_free / mobility, Held::Yes);
            }
            return (-direction * bound(self.mean_speed(at_rest, direction), direction), Held::No);
        }
        let direction = before.signum();
        let slipping = -direction * bound(self.mean_speed(guess, direction), direction);
        self.unless_reversed(slipping, &bound)
    }

    /// As [`Sliding::resolve`] for a bound that does not depend on speed.
    #[inline(always)]
    pub(super) fn resolve_constant(&self, bound: impl Fn(f64, f64) -> f64) -> (f64, Held) {
        let Self { before, after_free, mobility } = *self;
        if before == 0.0 {
            let direction = after_free.signum();
            let slipping = bound(0.0, direction);
            if after_free.abs() <= slipping * mobility {
                return (-after_free / mobility, Held::Yes);
            }
            return (-direction * slipping, Held::No);
        }
        let direction = before.signum();
        self.unless_reversed(-direction * bound(before, direction), &bound)
    }

    /// The force over a step that begins with the mean friction force `slipping`.
    #[inline(always)]
    fn unless_reversed(&self, slipping: f64, bound: &impl Fn(f64, f64) -> f64) -> (f64, Held) {
        let Self { before, after_free, mobility } = *self;
        let after = after_free + mobility * slipping;
        if after * before > 0.0 {
            return (slipping, Held::No);
        }
        // The velocity passes zero within the step: afterwards the coordinate sticks or slips back.
        let rest = -after / (before - after);
        let free_change = after_free - before;
        let back = -before.signum();
        let at_rest = mobility * bound(0.0, back);
        if slipping == 0.0 && at_rest == 0.0 {
            // No friction leaves the motion as it is, to the last bit.
            return (0.0, Held::No);
        }
        if free_change.abs() <= at_rest {
            return (-after_free / mobility, Held::Yes);
        }
        let after = (free_change - back * at_rest.min(mobility * bound(after_free, back))) * rest;
        ((after - after_free) / mobility, Held::No)
    }

    /// Mean speed of the step against a friction force; past a reversal only what comes before it counts.
    #[inline(always)]
    fn mean_speed(&self, force: f64, direction: f64) -> f64 {
        let after = self.after_free - direction * self.mobility * force;
        0.5 * (self.before + if after * direction > 0.0 { after } else { 0.0 })
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
