//! What acts in an actuator beside its linear spring, viscous damping and ideal drive: one list for each place.

use super::ports::{
    CommandStage, DriveLimit, DryFriction, ElastoSlip, RotorForce, SensorStage, Slip, SpringForce, SpringPath,
};

/// The laws of one actuator, all places empty by default. A bench's [`super::Plant`] and an actuator of a leg hold
/// the same, so that what is written for the one acts in the other unchanged.
#[derive(Debug, Default)]
pub struct Laws {
    /// On the way of the command, in order.
    pub command_stages: Vec<Box<dyn CommandStage>>,
    /// Limits of the drive that depend on speed.
    pub drive_limits: Vec<Box<dyn DriveLimit>>,
    /// Dry friction of the rotor; the bounds add up. At rest it holds exactly, without creep.
    pub rotor_friction: Vec<Box<dyn DryFriction>>,
    /// Elastic presliding frictions of the rotor, at most [`MOST_PRESLIDING`]; their forces add up.
    pub rotor_presliding: Vec<ElastoSlip>,
    /// Smooth forces on the rotor.
    pub rotor_forces: Vec<Box<dyn RotorForce>>,
    /// In line with the spring.
    pub spring_path: Vec<Box<dyn SpringPath>>,
    /// Beside the linear spring.
    pub spring_forces: Vec<Box<dyn SpringForce>>,
    /// A slipping element beside the spring.
    pub spring_slip: Option<ElastoSlip>,
    /// Damping parallel to the spring, N s/m.
    pub spring_damping: f64,
    /// In front of or inside the sensors.
    pub sensor_stages: Vec<Box<dyn SensorStage>>,
}

/// A spring's motion over a step.
#[derive(Debug, Clone, Copy)]
pub struct SpringStep {
    /// Deflection at its start, m.
    pub start: f64,
    /// Mean deflection, m.
    pub mean: f64,
    /// Mean rate, m/s.
    pub rate: f64,
    /// Duration, s.
    pub step_s: f64,
    /// One over it, 1/s.
    pub per_step: f64,
}

/// Most elastic presliding frictions of one rotor: of a sudden onset and of a gradual one.
pub const MOST_PRESLIDING: usize = 2;

/// Points over a step at which play is looked at.
const OVER_A_STEP: u32 = 16;

impl Laws {
    /// The bound of the rotor's dry friction in N; see [`DryFriction::bound`].
    #[must_use]
    #[inline]
    pub fn rotor_friction_bound(&self, slip: &Slip) -> f64 {
        self.rotor_friction.iter().map(|f| f.bound(slip)).sum()
    }

    /// Whether any dry friction acts on the rotor.
    #[must_use]
    pub fn rubs_at_rotor(&self) -> bool {
        !self.rotor_friction.is_empty() || !self.rotor_presliding.is_empty()
    }

    /// The sum of the smooth forces on the rotor in N; see [`RotorForce::force`].
    #[must_use]
    #[inline]
    pub fn rotor_force(&self, y: f64, y_dot: f64, load: f64, t: f64) -> f64 {
        self.rotor_forces.iter().map(|f| f.force(y, y_dot, load, t)).sum()
    }

    /// What the drive leaves of a motor force in N at screw speed `y_dot` (m/s).
    #[must_use]
    #[inline]
    pub fn limited_force(&self, force: f64, y_dot: f64) -> f64 {
        self.drive_limits.iter().fold(force, |force, limit| limit.limit(force, y_dot))
    }

    /// The force of a spring of `stiffness` (N/m) without its slipping element, N, at deflection `delta` (m) and
    /// its rate (m/s) and time `t` (s), positive in compression. Within play there is none, damping included: the damper works
    /// where the spring does.
    #[must_use]
    #[inline]
    pub fn spring_force(&self, stiffness: f64, delta: f64, delta_dot: f64, t: f64) -> f64 {
        let left = self.spring_left(delta);
        if left == 0.0 && !self.spring_path.is_empty() {
            return 0.0;
        }
        let beside: f64 = self.spring_forces.iter().map(|f| f.force(left, delta_dot, t)).sum();
        stiffness * left + self.spring_damping * delta_dot + beside
    }

    /// [`Laws::spring_force`], its play taken as the mean over a deflection that moves evenly by `moving` (m) about
    /// `delta`: a step in which contact is made or broken then carries the impulse of the part in contact, and the
    /// instant of the contact is not rounded to the step.
    #[must_use]
    #[inline]
    pub fn spring_force_over(
        &self,
        stiffness: f64,
        delta: f64,
        (delta_dot, moving): (f64, f64),
        t: f64,
    ) -> f64 {
        if self.spring_path.is_empty() {
            return self.spring_force(stiffness, delta, delta_dot, t);
        }
        // As a departure from the whole deflection: without play it vanishes to the last bit.
        let (mut play, mut in_contact) = (0.0, 0.0);
        for i in 0..OVER_A_STEP {
            let here = delta + moving * ((f64::from(i) + 0.5) / f64::from(OVER_A_STEP) - 0.5);
            let left = self.spring_left(here);
            play += (here - left) / f64::from(OVER_A_STEP);
            in_contact += if left == 0.0 { 0.0 } else { 1.0 / f64::from(OVER_A_STEP) };
        }
        let left = delta - play;
        if in_contact == 0.0 {
            return 0.0;
        }
        let beside: f64 = self.spring_forces.iter().map(|f| f.force(left, delta_dot, t)).sum();
        stiffness * left + in_contact * self.spring_damping * delta_dot + beside
    }

    /// [`Laws::spring_force`] beyond the linear law, without the damper's share.
    #[inline]
    pub(super) fn spring_force_beside(&self, stiffness: f64, delta: f64, delta_dot: f64, t: f64) -> f64 {
        let left = self.spring_left(delta);
        if left == 0.0 && !self.spring_path.is_empty() {
            return -stiffness * delta;
        }
        let beside: f64 = self.spring_forces.iter().map(|f| f.force(left, delta_dot, t)).sum();
        stiffness * (left - delta) + beside
    }

    /// Mean force of the spring over a step beyond its linear law and damper, without its slipping element, N, from the time
    /// `t` (s) on.
    #[must_use]
    #[inline(always)]
    pub fn spring_departure(&self, stiffness: f64, over: &SpringStep, t: f64) -> f64 {
        let mut departure = self.spring_force_beside(stiffness, over.mean, over.rate, t + 0.5 * over.step_s);
        if self.spring_damping != 0.0 && !self.spring_path.is_empty() {
            // The damper works in contact only: over a step that makes or breaks it, in proportion.
            let in_contact =
                self.spring_left(over.start + over.step_s * over.rate) - self.spring_left(over.start);
            departure += self.spring_damping * (in_contact * over.per_step - over.rate);
        }
        departure
    }

    /// The deflection that is left for the spring out of the total one, m.
    #[inline]
    pub(super) fn spring_left(&self, delta: f64) -> f64 {
        self.spring_path.iter().fold(delta, |d, path| path.left(d))
    }

    /// Whether the spring is a linear spring and damper and nothing else.
    #[must_use]
    pub fn spring_is_linear(&self) -> bool {
        self.spring_path.is_empty() && self.spring_forces.is_empty() && self.spring_slip.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Play of 2 mm.
    #[derive(Debug)]
    struct Play;

    impl SpringPath for Play {
        fn left(&self, deflection: f64) -> f64 {
            deflection - deflection.clamp(-1e-3, 1e-3)
        }
    }

    #[test]
    fn a_step_that_makes_contact_carries_the_impulse_of_its_part_in_contact() {
        let laws = Laws { spring_path: vec![Box::new(Play)], ..Laws::default() };
        let (k, v, h) = (1e5, 0.5, 2e-3);
        // From 0.8 to 1.8 mm: the mean of k (d - 1 mm) over the part beyond 1 mm, k 0.8^2 / (2 * 1) N.
        let mean = laws.spring_force_over(k, 1.3e-3, (v, v * h), 0.0);
        assert!((mean - k * 1e-3 * 0.32).abs() < 0.005 * mean, "{mean}");
        // Within the play there is none, and far from its ends the mean is the law itself.
        assert_eq!(laws.spring_force_over(k, 0.0, (v, v * h), 0.0), 0.0);
        let beyond = laws.spring_force_over(k, 4e-3, (v, v * h), 0.0);
        assert!((beyond - k * 3e-3).abs() < 1e-9 * beyond, "{beyond}");
    }
}
