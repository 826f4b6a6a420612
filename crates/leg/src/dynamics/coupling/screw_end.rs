//! The screw's end on a series compliance: a coordinate between screw and link 2.
//!
//! With `s` the compression of the compliance, `m_p` the sprung and `m_u` the unsprung mass (which a leg has in its
//! link 2), and `a` the acceleration less gravity of what carries them along the axis, a sprung motor housing has
//!
//! ```text
//! spring       F_k = k (y - s - (x - x_rest))
//! rotor        (J/r^2 + m_p) y'' - m_p s'' = F_m - b y' - F_k + m_p a
//! screw's end  (m_p + m_u) s'' - m_p y''   = F_k - k_j s - (m_p + m_u) a
//! load cell    F_2 = k_j s
//! ```
//!
//! The compliance may be far stiffer than a step of the engine can follow. Its force is the average acceleration's
//! (Newmark, beta = 1/4, gamma = 1/2), `F_2 = k_j (s + h^2 s''/4)`, which takes no energy and is stable at any
//! stiffness; as `k_j` grows, the rotor's equation becomes the one without the compliance.
//!
//! The engine carries both masses at the end of a rod as a part of link 2, which is relieved of them along the axis by
//! `(m_p + m_u) a`. A foot may be lighter than they are, and one step late this would feed its mode on the compliance. So `a`
//! is taken as what it would be without `F_2` (one step late) and what `F_2` adds to it at this instant.

use super::actuator::Actuator;
use super::links::Links;
use super::path::Path;
use super::rotor::RotorStep;
use sealegs_actuator::Configuration;
use sealegs_actuator::plant::SeriesCompliance;

/// Mass along the axis that link 2 has at least without the moving masses, as a share of it with them: the unsprung
/// mass is an estimate, and a foot may weigh less.
const LEAST_LINK: f64 = 0.02;

/// The screw's end as it moves against link 2.
#[derive(Debug)]
pub(super) struct ScrewEnd {
    pub compliance: SeriesCompliance,
    /// Compression of the compliance `s`, m, at the time of the poses.
    pub compressed_m: f64,
    /// Its speed half a step before the poses, m/s.
    speed_m_s: f64,
    /// Its speed half a step earlier still.
    previous_m_s: f64,
    /// What the last step was.
    pub step: ScrewEndStep,
}

/// What a step of the screw's end was.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ScrewEndStep {
    /// Force of the compliance on link 2, N, positive in compression.
    pub force_n: f64,
    /// The force at which the end would not be accelerated, N.
    pub at_rest_n: f64,
    /// What carries the end accelerates along the axis by this, less gravity, m/s^2.
    pub carrier: f64,
    /// `s'` at the time of the poses, m/s.
    pub speed: f64,
    /// What was put on the engine's link 2, which carries the masses, N.
    pub on_2_n: f64,
}

/// What carries the screw's end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Carrier {
    /// Its acceleration along the axis, less gravity, without the force of the compliance, m/s^2.
    pub free: f64,
    /// What that force adds, m/s^2 per N.
    pub mobility: f64,
}

/// What acts on the screw's end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside {
    /// Force of the spring, N.
    pub spring_n: f64,
    /// Sprung mass, kg.
    pub sprung_mass: f64,
    pub carrier: Carrier,
}

/// The end's equation in a step: `mass s'' = force + sprung_mass y''`, its carrier at `carrier + yielding s''`.
pub(super) struct Equation {
    beside: Beside,
    mass: f64,
    force: f64,
    carrier: f64,
    yielding: f64,
}

impl Equation {
    /// The rotor's mass (kg) and the force on it (N) beside its own, once `s''` is eliminated.
    pub fn on_rotor(&self) -> (f64, f64) {
        let m = self.beside.sprung_mass;
        let share = m * (1.0 + self.yielding) / self.mass;
        (m - share * m, m * self.carrier - self.beside.spring_n + share * self.force)
    }
}

impl ScrewEnd {
    pub fn new(compliance: SeriesCompliance) -> Self {
        let step = ScrewEndStep::default();
        Self { compliance, compressed_m: 0.0, speed_m_s: 0.0, previous_m_s: 0.0, step }
    }

    /// At rest, as far as a trial step has told.
    pub fn start(&mut self, trial: &ScrewEndStep) {
        let compressed_m = trial.at_rest_n / self.compliance.stiffness;
        *self = Self { compressed_m, step: *trial, ..Self::new(self.compliance) };
    }

    /// Speed extrapolated to the time of the poses, m/s.
    pub fn speed_now(&self) -> f64 {
        1.5 * self.speed_m_s - 0.5 * self.previous_m_s
    }

    /// Force of the compliance per `s''` that the average acceleration adds, kg.
    fn implicit_mass(&self, step_s: f64) -> f64 {
        0.25 * step_s * step_s * self.compliance.stiffness
    }

    /// The moving masses, sprung and unsprung, kg.
    fn moving(&self, beside: &Beside) -> f64 {
        beside.sprung_mass + self.compliance.mass
    }

    pub fn equation(&self, beside: Beside, step_s: f64) -> Equation {
        let (pull, moving) = (self.compliance.stiffness * self.compressed_m, self.moving(&beside));
        let implicit = self.implicit_mass(step_s);
        let carrier = beside.carrier.free + beside.carrier.mobility * pull;
        let yielding = beside.carrier.mobility * implicit;
        Equation {
            mass: moving * (1.0 + yielding) + implicit,
            force: beside.spring_n - pull - moving * carrier,
            carrier,
            yielding,
            beside,
        }
    }

    /// Advances the end by a step in which the rotor has the acceleration `y''`.
    pub fn advance(&mut self, of: &Equation, rotor_acceleration: f64, step_s: f64) {
        let pull = self.compliance.stiffness * self.compressed_m;
        let push = of.force + of.beside.sprung_mass * rotor_acceleration;
        let acceleration = push / of.mass;
        let (before, after) = (self.speed_m_s, self.speed_m_s + step_s * acceleration);
        self.step = ScrewEndStep {
            force_n: pull + self.implicit_mass(step_s) * acceleration,
            // A pull that is greater by this takes more from the end, and its carrier away from it.
            at_rest_n: pull + push / (1.0 + self.moving(&of.beside) * of.beside.carrier.mobility),
            carrier: of.carrier + of.yielding * acceleration,
            speed: 0.5 * (before + after),
            ..self.step
        };
        (self.previous_m_s, self.speed_m_s) = (before, after);
        self.compressed_m += step_s * after;
    }

    /// Moves the end to where it is in balance with a spring of a stiffness, in which the rotor has the acceleration `y''`.
    /// Along links and a rotor whose motion was measured its own vibration is left out: it has no damping, and the encoders'
    /// counts would make it ring.
    fn settle(&mut self, of: &Equation, (stiffness, rotor_acceleration): (f64, f64), step_s: f64) {
        let pull = self.compliance.stiffness * self.compressed_m;
        let push = of.force + of.beside.sprung_mass * rotor_acceleration;
        let moved = push / (self.compliance.stiffness + stiffness);
        let after = moved / step_s;
        self.step = ScrewEndStep {
            force_n: pull + self.compliance.stiffness * moved,
            at_rest_n: pull + push,
            carrier: of.carrier,
            speed: 0.5 * (self.speed_m_s + after),
            ..self.step
        };
        (self.previous_m_s, self.speed_m_s) = (self.speed_m_s, after);
        self.compressed_m += moved;
    }
}

impl Actuator {
    /// Puts a compliance between screw and link 2, where the actuator has a place for it (see [`carries_series`]).
    pub fn set_series(&mut self, series: Option<SeriesCompliance>) {
        self.screw_end =
            series.filter(|_| carries_series(self.coefficients.configuration)).map(ScrewEnd::new);
    }

    /// A sprung motor housing whose screw ends on a compliance, which was taken out of it and comes back here; `felt` is
    /// what its attachment felt one step ago.
    pub(super) fn apply_with_screw_end<L: Links>(
        &mut self,
        mut end: ScrewEnd,
        links: &mut L,
        push: f64,
        spring_n: f64,
        felt: f64,
        step_s: f64,
    ) -> (f64, f64, RotorStep) {
        let (sprung_mass, inertia) = (self.coefficients.sprung_mass, self.coefficients.reflected_inertia);
        let moving = sprung_mass + end.compliance.mass;
        let carrier = match &self.path {
            Path::Rod { end_2, .. } => {
                let mobility = links.mobility(end_2.0, &self.reach.ends[1], &self.reach.direction);
                // What the engine carries of the moving masses is taken off.
                let relieved = (1.0 - moving * mobility).max(LEAST_LINK);
                Carrier {
                    free: (felt - mobility * end.step.on_2_n) / relieved,
                    mobility: mobility / relieved,
                }
            }
            // Carried by the mount and, in the armature, by the joint: links that weigh more than the sprung mass.
            Path::Crank { .. } => Carrier { free: felt + self.length_acceleration, mobility: 0.0 },
        };
        let equation = end.equation(Beside { spring_n, sprung_mass, carrier }, step_s);
        let rotor = if links.known_accelerations().is_some() {
            let force = push - spring_n + sprung_mass * equation.carrier;
            let rotor = self.advance_rotor_of(inertia + sprung_mass, force, step_s);
            end.settle(&equation, (self.coefficients.stiffness, rotor.acceleration), step_s);
            rotor
        } else {
            let (mass, force) = equation.on_rotor();
            let rotor = self.advance_rotor_of(inertia + mass, push + force, step_s);
            end.advance(&equation, rotor.acceleration, step_s);
            rotor
        };
        let force_n = end.step.force_n;
        let (on_1, on_2) = match &self.path {
            Path::Rod { .. } => (spring_n, force_n + moving * end.step.carrier),
            Path::Crank { dof, .. } => {
                links.set_armature(*dof, sprung_mass * self.reach.arm.arm_m.powi(2));
                let joint_speed = links.joint_velocity(*dof);
                let turning = self.reach.arm.arm_slope_m * joint_speed * joint_speed;
                let unsprung = end.compliance.mass * end.step.carrier;
                let on_2 = force_n + unsprung + sprung_mass * (self.length_acceleration - turning);
                (on_2 - (force_n + unsprung - spring_n + sprung_mass * felt), on_2)
            }
        };
        end.step.on_2_n = on_2;
        self.screw_end = Some(end);
        (on_1, on_2, rotor)
    }
}

/// Whether a configuration has a place between screw and link 2: the spring itself is there with a sprung ball nut, and
/// the lumped model has no screw.
pub(crate) fn carries_series(configuration: Configuration) -> bool {
    configuration == Configuration::SprungMotorHousing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_two_springs_in_series_share_a_known_length_at_once() {
        let (stiffness, mass, sprung_mass, free) = (4e5, 0.1, 0.6, 3.0);
        let compliance = SeriesCompliance { stiffness: 1.5e5, mass };
        let mut end = ScrewEnd::new(compliance);
        let length = 1e-3;
        for _ in 0..2 {
            let spring_n = stiffness * (length - end.compressed_m);
            let beside = Beside { spring_n, sprung_mass, carrier: Carrier { free, mobility: 0.0 } };
            let equation = end.equation(beside, 1e-4);
            end.settle(&equation, (stiffness, 0.0), 1e-4);
            // k (l - s) = k_j s + (m_p + m_u) a
            let balance =
                (stiffness * length - (mass + sprung_mass) * free) / (stiffness + compliance.stiffness);
            assert!((end.compressed_m / balance - 1.0).abs() < 1e-12);
            assert!((end.step.force_n / (compliance.stiffness * balance) - 1.0).abs() < 1e-12);
        }
        assert!(end.speed_m_s.abs() < 1e-12);
    }
}
