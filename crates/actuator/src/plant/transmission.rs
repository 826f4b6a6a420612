//! What lies between the rotor and the load of a drive without a spring: gears, a belt or a coupling that yields or has
//! play.

use super::{Link, Plant, SpringPath};

/// Gears, belt or coupling between the rotor and the load of a drive without a spring, referred to the output.
///
/// Rotor and load then move on their own and meet at the spring and the damper of the transmission, outside of the play:
///
/// ```text
/// m_J y'' = F_m - b y' - s,  m_2 x'' = s - ...,  s = k e(y - x) + d (y' - x') in contact,  e the dead zone of the play
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transmission {
    /// N/m; infinite where it does not yield.
    pub stiffness: f64,
    /// Of rotor against load in contact.
    pub damping_ratio: f64,
    /// Width of the play, m.
    pub gap: f64,
}

impl Transmission {
    /// Neither yields nor has play.
    pub const RIGID: Self =
        Self { stiffness: f64::INFINITY, damping_ratio: TRANSMISSION_DAMPING_RATIO, gap: 0.0 };

    /// The same in series with another one. The softer one is what moves, and its damping counts.
    #[must_use]
    pub fn in_series(self, other: Self) -> Self {
        let softer = if other.stiffness < self.stiffness { other } else { self };
        let stiffness = 1.0 / (1.0 / self.stiffness + 1.0 / other.stiffness);
        Self { stiffness, gap: self.gap + other.gap, ..softer }
    }
}

/// Damping ratio of rotor against load where none is known: gear teeth have 0.03 to 0.17 (R. Kasuba and J. W. Evans 1981, J.
/// Mechanical Design 103(2)), and a hit is over within a few of their oscillations whatever it is.
pub const TRANSMISSION_DAMPING_RATIO: f64 = 0.1;

/// The greatest step times the natural frequency of rotor against load: play is a departure from the linear spring, taken
/// at the mean of a step, which must not be a large part of an oscillation.
const STEP_PER_RADIAN: f64 = 0.3;

impl Plant {
    /// Lets rotor and load of a drive without a spring move on their own where its transmission yields. A load without mass
    /// has no motion of its own, and stays with the rotor.
    pub(crate) fn part_at_transmission(&mut self) {
        let (Some(load), Transmission { stiffness, damping_ratio, gap }) = (self.rigid, self.transmission)
        else {
            return;
        };
        if !stiffness.is_finite() || load.mass_kg() <= 0.0 {
            return;
        }
        (self.rigid, self.link_2, self.stiffness) = (None, load, stiffness);
        self.laws.spring_damping = 2.0 * damping_ratio * (stiffness * self.rotor_against_load()).sqrt();
        if gap > 0.0 {
            self.laws.spring_path.push(Box::new(DeadZone { half_gap: 0.5 * gap }));
        }
    }

    /// Whether this is a drive without a spring whose rotor and load move on their own.
    #[must_use]
    #[inline]
    pub fn is_parted(&self) -> bool {
        self.rigid.is_none() && self.transmission.stiffness.is_finite()
    }

    /// The mass that oscillates between rotor and load, kg.
    fn rotor_against_load(&self) -> f64 {
        1.0 / (1.0 / self.reflected_inertia + 1.0 / self.link_2.mass_kg())
    }

    /// The greatest step of integration, s, that follows the oscillation of rotor against load; infinite where they move as one.
    #[must_use]
    fn longest_step_s(&self) -> f64 {
        match self.rigid {
            None => STEP_PER_RADIAN / (self.stiffness / self.rotor_against_load()).sqrt(),
            Some(_) => f64::INFINITY,
        }
    }

    /// A wanted step of integration, s, or a power of two less that follows the oscillation of rotor against load as far as
    /// `least_s` allows. Powers of two: what is prepared for a grid serves other values, too.
    #[must_use]
    pub fn step_following(&self, wanted_s: f64, least_s: f64) -> f64 {
        let most = self.longest_step_s().max(least_s);
        if most >= wanted_s {
            wanted_s
        } else {
            wanted_s * 0.5_f64.powi((wanted_s / most).log2().ceil() as i32)
        }
    }

    /// How far the rotor is ahead of a load that it holds at a position (m), m: half of the play and what gravity deflects.
    #[must_use]
    pub fn ahead_at_rest(&self, position: f64) -> f64 {
        let Link::Pendulum { gravity_torque_nm, arm_m, .. } = self.link_2 else { return 0.0 };
        self.ahead_under(gravity_torque_nm * (position / arm_m).sin() / arm_m)
    }

    /// How far the rotor is ahead of a load that it holds by a force (N), m.
    #[must_use]
    pub fn ahead_under(&self, force: f64) -> f64 {
        let half_gap = if force == 0.0 { 0.0 } else { (0.5 * self.transmission.gap).copysign(force) };
        half_gap + force / self.stiffness
    }
}

/// Play: a dead zone in deflection.
#[derive(Debug)]
pub(crate) struct DeadZone {
    /// m.
    pub half_gap: f64,
}

impl SpringPath for DeadZone {
    fn left(&self, deflection: f64) -> f64 {
        deflection - deflection.clamp(-self.half_gap, self.half_gap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Grid;

    /// 0.01 kg m^2 that turn 0.03 kg m^2 by a transmission.
    fn drive(transmission: Transmission) -> Plant {
        let mut plant = Plant::new(0.01, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(0.03));
        plant.transmission = transmission;
        plant.part_at_transmission();
        plant
    }

    fn run(plant: &Plant, h: f64, torque: impl Fn(f64) -> f64) -> super::super::Trace {
        let steps = (1.0 / h).round() as usize;
        let grid = Grid { start_s: 0.0, step_s: h, steps };
        let commands: Vec<f64> = (0..steps).map(|n| torque((n as f64 + 0.5) * h)).collect();
        plant.simulate(grid, &commands).expect("finite")
    }

    #[test]
    fn what_does_not_yield_is_the_rigid_drive() {
        let plant = drive(Transmission::RIGID);
        assert!(plant.rigid.is_some() && !plant.is_parted());
        let mut unloaded = Plant::new(0.01, 0.0, 0.0, 0.0);
        unloaded.rigid = Some(Link::Mass(0.0));
        unloaded.transmission = Transmission { stiffness: 20.0, ..Transmission::RIGID };
        unloaded.part_at_transmission();
        assert!(!unloaded.is_parted());
    }

    #[test]
    fn analytic_two_masses_on_a_spring() {
        // Under a constant torque the mass centre accelerates by T / (m_1 + m_2), and the deflection approaches
        // T m_2 / (k (m_1 + m_2)) with w = sqrt(k / m), m = m_1 m_2 / (m_1 + m_2), damped by a tenth.
        let plant = drive(Transmission { stiffness: 20.0, ..Transmission::RIGID });
        let trace = run(&plant, 1e-3, |_| 0.4);
        let w = (20.0_f64 / 0.0075).sqrt();
        let (damped, rate) = (w * (1.0 - 0.01_f64).sqrt(), 0.1 * w);
        for n in [10, 100, 400, 1000] {
            let t = n as f64 * 1e-3;
            let centre = 0.5 * 10.0 * t * t;
            let swing = (-rate * t).exp() * ((damped * t).cos() + rate / damped * (damped * t).sin());
            let deflection = 0.4 * 0.75 / 20.0 * (1.0 - swing);
            let (y, x) = (trace.screw_position[n], trace.link_2_position[n]);
            assert!((0.25 * y + 0.75 * x - centre).abs() < 1e-9, "{n}");
            assert!((y - x - deflection).abs() < 1e-9, "{n}: {} {deflection}", y - x);
            let slope = (trace.link_2_position[n] - trace.link_2_position[n - 1]) / 1e-3;
            assert!((trace.link_2_speed[n] - slope).abs() < 0.02, "{n}");
        }
    }

    #[test]
    fn analytic_the_load_stays_until_the_play_is_crossed() {
        let plant = drive(Transmission { stiffness: 400.0, gap: 0.02, ..Transmission::RIGID });
        // From the middle, 0.01 rad at 0.2 / 0.01 rad/s^2: sqrt(2 * 0.01 / 20) = 31.6 ms.
        let trace = run(&plant, 1e-4, |_| 0.2);
        let early = trace.link_2_position[..310].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(early < 1e-6, "{early}");
        assert!(trace.link_2_position[400] > 1e-5);
        // Momentum is what the torque gave, play or not.
        let momentum = 0.01 * trace.screw_speed[10_000] + 0.03 * trace.link_2_speed[10_000];
        assert!((momentum / 0.2 - 1.0).abs() < 1e-6, "{momentum}");
    }

    #[test]
    fn play_converges_with_the_step_and_gains_no_energy() {
        let plant = drive(Transmission { stiffness: 200.0, gap: 0.01, ..Transmission::RIGID });
        let torque = |t: f64| 0.3 * (9.0 * t).sin();
        let finest = run(&plant, 1e-5, torque).link_2_position;
        let off = |h: f64, every: usize| {
            let coarse = run(&plant, h, torque).link_2_position;
            let square = coarse.iter().zip(finest.iter().step_by(every)).map(|(a, b)| (a - b).powi(2));
            (square.sum::<f64>() / coarse.len() as f64).sqrt()
        };
        // The longest step admitted is 1.8 ms.
        let (coarse, fine) = (off(1e-3, 100), off(2.5e-4, 25));
        assert!(coarse < 2e-3 && fine < 0.3 * coarse, "{coarse} {fine}");
        let grid = Grid { start_s: 0.0, step_s: 2.5e-4, steps: 4000 };
        let commands: Vec<f64> = (0..4000).map(|n| torque((f64::from(n) + 0.5) * 2.5e-4)).collect();
        let ledger = plant.energy(grid, &commands).expect("finite");
        for n in 0..=4000 {
            let held = ledger.kinetic[n] + ledger.stored[n];
            assert!(held <= ledger.motor_work[n] + 1e-4, "{n}: {held} {}", ledger.motor_work[n]);
        }
    }

    #[test]
    fn analytic_steps_follow_the_oscillation_by_powers_of_two() {
        // sqrt(300 / 0.0075) = 200 rad/s: at most 1.5 ms.
        let plant = drive(Transmission { stiffness: 300.0, ..Transmission::RIGID });
        assert_eq!(plant.step_following(1e-3, 0.0), 1e-3);
        assert_eq!(plant.step_following(4e-3, 0.0), 1e-3);
        assert_eq!(plant.step_following(4e-3, 2e-3), 2e-3);
        assert_eq!(drive(Transmission::RIGID).step_following(4e-3, 0.0), 4e-3);
    }

    #[test]
    fn a_held_pendulum_begins_at_rest() {
        let mut plant = drive(Transmission::RIGID);
        plant.rigid = Some(Link::Pendulum { inertia_kg_m2: 0.03, gravity_torque_nm: 1.2, arm_m: 1.0 });
        plant.transmission = Transmission { stiffness: 60.0, gap: 0.02, ..Transmission::RIGID };
        plant.part_at_transmission();
        plant.start = (0.5, 0.0);
        let trace = run(&plant, 1e-3, |_| 1.2 * 0.5_f64.sin());
        assert!(trace.link_2_position.iter().all(|x| (x - 0.5).abs() < 1e-6));
    }
}
