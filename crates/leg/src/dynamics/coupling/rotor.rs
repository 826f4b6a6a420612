//! The rotor: one coordinate in lockstep with the engine, damped implicitly, stuck or slipping exactly.

use sealegs_actuator::plant::{Laws, MOST_PRESLIDING, Sliding, Slip};

/// The rotor's state, referred to the screw.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rotor {
    /// Extension of the screw `y`, m, at the time of the poses.
    pub y_m: f64,
    /// Speed half a step before the poses, m/s.
    pub speed_m_s: f64,
    /// Speed half a step earlier still.
    pub previous_m_s: f64,
    /// Forces of the presliding elements, N, opposing positive motion when negative.
    pub presliding_n: [f64; MOST_PRESLIDING],
    /// Heat that dry friction has made, J.
    pub heat_j: f64,
}

/// What a step of the rotor was.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RotorStep {
    /// `y''` at the time of the poses, m/s^2.
    pub acceleration: f64,
    /// Mean of the speeds before and after: that at the time of the poses, m/s.
    pub speed: f64,
    /// All friction, dry and elastic, N.
    pub friction_n: f64,
}

impl Rotor {
    /// Speed extrapolated to the time of the poses, m/s.
    pub fn speed_now(&self) -> f64 {
        1.5 * self.speed_m_s - 0.5 * self.previous_m_s
    }

    /// Advances `mass y'' = force - damping y' + friction` by a step; `load` is the force in the screw, N.
    pub fn advance(
        &mut self,
        mass: f64,
        damping: f64,
        force: f64,
        load: f64,
        laws: &Laws,
        step_s: f64,
    ) -> RotorStep {
        let before = self.speed_m_s;
        let half_loss = 0.5 * damping * step_s;
        let mobility = step_s / (mass + half_loss);
        let free = ((mass - half_loss) * before + step_s * force) / (mass + half_loss);
        let mut friction_n = 0.0;
        for (held_n, element) in self.presliding_n.iter_mut().zip(&laws.rotor_presliding) {
            *held_n = element.advance(*held_n, -step_s * (1.5 * before - 0.5 * self.previous_m_s));
            friction_n += *held_n;
        }
        if !laws.rotor_friction.is_empty() {
            let sliding = Sliding { before, after_free: free + mobility * friction_n, mobility };
            let (position, heat) = (self.y_m, self.heat_j);
            let dry_n = sliding.mean_force(|speed, direction| {
                laws.rotor_friction_bound(&Slip { position, speed, direction, load, heat, ..Slip::default() })
            });
            friction_n += dry_n;
            self.heat_j -= dry_n * step_s * (free + mobility * friction_n);
        }
        let mut after = free + mobility * friction_n;
        // What rounding leaves of a speed that friction has just stopped is not a motion.
        if friction_n != 0.0 && after.abs() <= 1e-14 * (free.abs() + mobility * friction_n.abs()) {
            after = 0.0;
        }
        self.previous_m_s = before;
        self.speed_m_s = after;
        self.y_m += step_s * after;
        RotorStep { acceleration: (after - before) / step_s, speed: 0.5 * (before + after), friction_n }
    }
}
