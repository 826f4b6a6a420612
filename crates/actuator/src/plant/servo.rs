//! A position loop inside the drive: from a goal and the measured position of the output to the duty of the bridge, or to a torque.

use super::REFERENCE_TEMPERATURE_C;

/// A drive's own position loop: `clamp(k_p e + k_d e' + k_i integral(e) + feed-forward)` with `e = goal - position`, a duty or a torque.
///
/// Gains are per unit of the output's motion (rad, or m for a linear drive). The loop is continuous unless it has a
/// period, and then holds what it gives from one of its samples to the next, which begin with the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    /// Duty (or torque, N m) per error, 1/rad.
    pub proportional: f64,
    /// Duty (or torque) per rate of the error, s/rad. Of the goal's own rate only what is told beside it is taken: of a goal in
    /// steps it would be a spike.
    pub derivative: f64,
    /// Duty per integral of the error, 1/(rad s). The integral stops where the duty is at its limit.
    pub integral: f64,
    /// Greatest magnitude of the duty, at most 1, or of the torque, N m.
    pub limit: f64,
    /// An error below this counts as none, rad.
    pub dead_band: f64,
    /// Age of the position that the loop sees, s.
    pub feedback_delay_s: f64,
    /// Whether it sees the rotor's position, referred to the output, in the place of the output's.
    pub sees_rotor: bool,
    /// Sampling period of the loop, s; `None` where it is continuous.
    pub period_s: Option<f64>,
    /// Constant error of the goal, rad.
    pub goal_offset: f64,
    /// Voltage at a duty of 1 where none was logged, V; `None` of a loop that commands a torque.
    pub supply_v: Option<f64>,
}

/// What a loop is told over a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Told {
    /// Where the output is to be, rad.
    pub goal: f64,
    /// The goal's own speed, rad/s.
    pub goal_speed: f64,
    /// What is added to a torque, N m.
    pub feedforward: f64,
    /// The measured supply, V.
    pub supply_v: Option<f64>,
}

/// What the loop remembers between steps.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loop {
    given: f64,
    integral: f64,
    /// Number of the loop's own sample that `given` belongs to, from 1.
    sample: u64,
}

/// The motion of the output, or of the rotor, from the start to the point where a step begins.
#[derive(Debug, Clone, Copy)]
pub struct Past<'a> {
    /// Position at every point, rad.
    pub position: &'a [f64],
    /// Its rate at every point, rad/s.
    pub speed: &'a [f64],
    /// Between two points, s.
    pub step_s: f64,
}

/// Share of a radian by which a loop's own oscillation goes on, or its damping acts, within a step that follows it: of second order in
/// this, it is 0.3 % of that motion.
const FOLLOWED: f64 = 0.25;

impl Servo {
    /// Whether it commands a torque and no voltage.
    #[must_use]
    pub fn commands_torque(&self) -> bool {
        self.supply_v.is_none()
    }

    /// The command per unit of what the loop gives: the supply without a measured one, V, or 1 of a torque.
    #[must_use]
    pub fn per_given(&self) -> f64 {
        self.supply_v.unwrap_or(1.0)
    }

    /// The same loop with so many times the gain: of one that commands a torque both, of a hobby servo's the proportional one, as
    /// its `kp` register has it.
    #[must_use]
    pub fn times(self, gain: f64) -> Self {
        let derivative = if self.commands_torque() { gain * self.derivative } else { self.derivative };
        Self { proportional: gain * self.proportional, derivative, ..self }
    }

    /// The duty (or torque, N m) over the step that begins at the last point of the `past`.
    fn given(&self, told: &Told, past: Past, of: &mut Loop) -> f64 {
        let n = past.position.len() - 1;
        let elapsed = n as f64 * past.step_s;
        let (mut look_ahead, mut span) = (0.5 * past.step_s, past.step_s);
        if let Some(period) = self.period_s {
            let sample = (elapsed / period + 1e-9).floor() as u64 + 1;
            if sample == of.sample {
                return of.given;
            }
            span = (sample - of.sample) as f64 * period;
            of.sample = sample;
            look_ahead = 0.0;
        }
        let (position, speed) = self.seen(elapsed + look_ahead, past);
        let error = told.goal + self.goal_offset - position;
        let error = error - error.clamp(-self.dead_band, self.dead_band);
        let rate = told.goal_speed - speed;
        let free = self.proportional * error
            + self.derivative * rate
            + self.integral * of.integral
            + told.feedforward;
        of.given = free.clamp(-self.limit, self.limit);
        if of.given == free {
            of.integral += error * span;
        }
        of.given
    }

    /// The command of the drive over the step that begins at the last point of the `past`: the voltage that the bridge gives, V, at
    /// a supply that was measured or its own, or a torque, N m.
    ///
    /// # Panics
    ///
    /// If the past has no point.
    pub fn command(&self, told: &Told, past: Past, of: &mut Loop) -> f64 {
        let measured = told.supply_v.filter(|_| !self.commands_torque());
        measured.unwrap_or(self.per_given()) * self.given(told, past, of)
    }

    /// A wanted step of integration, s, or a shorter one: what a loop that commands a torque does to an inertia (kg m^2) is followed, and a
    /// sampling period has whole steps. By powers of two, so that a fit does not change it at each of its own steps.
    #[must_use]
    pub fn step_following(&self, wanted_s: f64, inertia: f64) -> f64 {
        if !self.commands_torque() {
            return wanted_s;
        }
        let oscillates = (inertia / self.proportional).sqrt();
        let damps = if self.derivative > 0.0 { inertia / self.derivative } else { f64::INFINITY };
        let most = FOLLOWED * oscillates.min(damps);
        let whole = self.period_s.map_or(wanted_s, |period| period / (period / wanted_s).ceil());
        if most >= whole { whole } else { whole * 0.5_f64.powi((whole / most).log2().ceil() as i32) }
    }

    /// Position and speed of the output as the loop sees them at a time since the start, s. Before the start the position
    /// is the first one.
    fn seen(&self, at: f64, past: Past) -> (f64, f64) {
        let Past { position, speed, step_s } = past;
        let last = position.len() - 1;
        let point = (at - self.feedback_delay_s) / step_s;
        let ahead = point - last as f64;
        if ahead >= 0.0 {
            // Of first order: a step's own acceleration is known after it.
            let rate = if self.commands_torque() && last > 0 { speed[last] - speed[last - 1] } else { 0.0 };
            return (position[last] + ahead * step_s * speed[last], speed[last] + ahead * rate);
        }
        if point <= 0.0 {
            return (position[0], speed[0]);
        }
        let i = point as usize;
        let along = point - i as f64;
        let between = |values: &[f64]| values[i] + along * (values[i + 1] - values[i]);
        (between(position), between(speed))
    }
}

/// A DC motor at a bridge that is given a voltage: what its winding makes of it, referred to the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Force per current `K_tau / r`, N/A; also the back-EMF per speed, V s/m.
    pub force_per_current: f64,
    /// Resistance of winding and bridge, ohm. The inductance is left out.
    pub resistance_ohm: f64,
    /// Voltage at a duty of 1, V.
    pub supply_v: f64,
}

impl Winding {
    /// The force in N under a voltage (V) at an output speed (m/s): `(K/r) (V - (K/r) y') / R`.
    #[must_use]
    #[inline]
    pub fn force(&self, volts: f64, speed: f64) -> f64 {
        self.force_per_current * (volts - self.force_per_current * speed) / self.resistance_ohm
    }

    /// The voltage under which the force is this: the inverse of [`Winding::force`].
    #[must_use]
    #[inline]
    pub fn volts(&self, force: f64, speed: f64) -> f64 {
        force * self.resistance_ohm / self.force_per_current + self.force_per_current * speed
    }
}

/// What a drive is told, and fed with, over the steps of a grid.
#[derive(Debug, Clone, Copy, Default)]
pub struct Feed<'a> {
    /// The mean command over each step, in its unit; of a servo the goal, as it is where the step begins if its loop samples. Zero
    /// after the last.
    pub commands: &'a [f64],
    /// What a controller adds to commanded efforts by where the joint is, in their unit.
    pub added: Option<&'a [f64]>,
    /// The goal's own speed, rad/s, of a loop that commands a torque.
    pub goal_speed: Option<&'a [f64]>,
    /// What is added to that torque, N m.
    pub feedforward: Option<&'a [f64]>,
    /// Below 0.5 the bridge is open: no torque, no back-EMF. Always on if `None`.
    pub enable: Option<&'a [f64]>,
    /// The measured supply of a servo, V.
    pub supply_v: Option<&'a [f64]>,
    /// The measured temperature of the drive, degrees Celsius.
    pub temperature_c: Option<&'a [f64]>,
}

impl Feed<'_> {
    /// The command over a step.
    #[must_use]
    #[inline(always)]
    pub fn command(&self, step: usize) -> f64 {
        let over = |values: &[f64]| values.get(step).copied().unwrap_or(0.0);
        over(self.commands) + self.added.map_or(0.0, over)
    }

    /// What a servo's loop is told over a step.
    #[must_use]
    pub fn told(&self, step: usize) -> Told {
        let over = |values: Option<&[f64]>| values.and_then(|v| v.get(step).copied());
        Told {
            goal: self.command(step),
            goal_speed: over(self.goal_speed).unwrap_or(0.0),
            feedforward: over(self.feedforward).unwrap_or(0.0),
            supply_v: over(self.supply_v),
        }
    }

    /// By how much the drive is warmer than the reference over a step, K.
    #[must_use]
    #[inline(always)]
    pub fn warmer_k(&self, step: usize) -> f64 {
        let measured = self.temperature_c.and_then(|t| t.get(step.min(t.len().saturating_sub(1))));
        measured.map_or(0.0, |t| t - REFERENCE_TEMPERATURE_C)
    }

    /// Whether the bridge is open over a step.
    #[must_use]
    #[inline(always)]
    pub fn released(&self, step: usize) -> bool {
        self.enable.is_some_and(|on| on.get(step).is_some_and(|on| *on < 0.5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Grid, Link, Plant, Trace};

    const WINDING: Winding = Winding { force_per_current: 0.3, resistance_ohm: 2.0, supply_v: 7.4 };

    fn servo() -> Servo {
        Servo {
            proportional: 2.0,
            derivative: 0.0,
            integral: 0.0,
            limit: 1.0,
            dead_band: 0.0,
            feedback_delay_s: 0.0,
            sees_rotor: false,
            period_s: None,
            goal_offset: 0.0,
            supply_v: Some(7.4),
        }
    }

    /// 0.01 kg m^2 behind a winding.
    fn plant() -> Plant {
        let mut plant = Plant::new(0.002, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(0.008));
        plant.drive_by(WINDING);
        plant
    }

    fn step(plant: &Plant, h: f64, goal: f64) -> Trace {
        let steps = (2.0 / h).round() as usize;
        let grid = Grid { start_s: 0.0, step_s: h, steps };
        plant.simulate(grid, &vec![goal; steps]).expect("finite")
    }

    #[test]
    fn analytic_a_voltage_step_approaches_the_no_load_speed() {
        let mut plant = plant();
        plant.start = (0.5, 0.0);
        let trace = step(&plant, 1e-3, 6.0);
        // Without load the back-EMF is the voltage in the end: 20 rad/s, with time constant J R / K^2 = 0.222 s.
        let (rate, end) = (0.3 * 0.3 / (2.0 * 0.01), 6.0 / 0.3);
        for n in [1, 100, 500, 2000] {
            let t = n as f64 * 1e-3;
            let speed = end * (1.0 - (-rate * t).exp());
            let position = 0.5 + end * (t - (1.0 - (-rate * t).exp()) / rate);
            // Of the mean speed of a step, (rate h)^2 / 12 = 2e-6 off; from the first step on.
            assert!((trace.screw_speed[n] / speed - 1.0).abs() < 5e-6, "{} {speed}", trace.screw_speed[n]);
            assert!((trace.screw_position[n] / position - 1.0).abs() < 5e-6);
        }
    }

    #[test]
    fn analytic_the_loop_is_a_spring_with_the_back_emf_as_its_damper() {
        let mut plant = plant();
        plant.servo = Some(servo());
        // Duty far below its limit: k = 2 * 7.4 * 0.3 / 2 = 2.22 N m/rad, d = 0.3^2 / 2 N m s/rad, J = 0.01.
        let (k, d, inertia, goal) = (2.22, 0.045, 0.01, 0.02);
        let (decay, square): (f64, f64) = (d / (2.0 * inertia), k / inertia);
        let ringing = (square - decay * decay).sqrt();
        let error = |h: f64| {
            let trace = step(&plant, h, goal);
            let truth = |t: f64| {
                let swing = (ringing * t).cos() + decay / ringing * (ringing * t).sin();
                goal * (1.0 - (-decay * t).exp() * swing)
            };
            let off = |(n, y): (usize, &f64)| (y - truth(n as f64 * h)).abs() / goal;
            trace.screw_position.iter().enumerate().map(off).fold(0.0, f64::max)
        };
        // Of second order in the step.
        assert!(error(1e-3) < 2e-3, "{}", error(1e-3));
        assert!(error(5e-4) < 0.3 * error(1e-3), "{} {}", error(5e-4), error(1e-3));
    }

    #[test]
    fn analytic_a_loop_that_commands_a_torque_is_a_spring_and_a_damper() {
        let (k, d, inertia) = (4.0, 0.06, 0.01);
        let mut plant = Plant::new(0.002, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(0.008));
        plant.force_per_command = 1.0;
        let loop_of_torque =
            Servo { proportional: k, derivative: d, limit: f64::INFINITY, supply_v: None, ..servo() };
        plant.servo = Some(loop_of_torque);
        // The goal is a ramp whose speed is told, and a torque is added: what is left is an oscillation about ff / k.
        let (rate, added) = (0.7, 0.2);
        let (decay, square): (f64, f64) = (d / (2.0 * inertia), k / inertia);
        let ringing = (square - decay * decay).sqrt();
        let truth = |t: f64| {
            let (end, lag) = (added / k, -rate);
            // e = goal + ff / k - q begins at ff / k with the rate of the goal.
            let (first, second) = (end, (-lag + decay * end) / ringing);
            let left = (-decay * t).exp() * (first * (ringing * t).cos() + second * (ringing * t).sin());
            rate * t + end - left
        };
        let error = |h: f64| {
            let steps = (1.0 / h).round() as usize;
            let grid = Grid { start_s: 0.0, step_s: h, steps };
            let goals: Vec<f64> = (0..steps).map(|n| rate * (n as f64 + 0.5) * h).collect();
            let (speeds, feedforward) = (vec![rate; steps], vec![added; steps]);
            let feed = Feed {
                commands: &goals,
                goal_speed: Some(&speeds),
                feedforward: Some(&feedforward),
                ..Feed::default()
            };
            let trace = plant.simulate_fed(grid, feed).expect("finite");
            let off = |(n, y): (usize, &f64)| (y - truth(n as f64 * h)).abs();
            trace.screw_position.iter().enumerate().map(off).fold(0.0, f64::max)
        };
        assert!(error(1e-3) < 5e-4, "{}", error(1e-3));
        assert!(error(5e-4) < 0.3 * error(1e-3), "{} {}", error(5e-4), error(1e-3));
        // Its own oscillation of 20 rad/s and its damping, 6 per second, are followed; a voltage's loop leaves the step as it is.
        assert_eq!(loop_of_torque.step_following(0.1, inertia), 0.0125);
        assert_eq!(servo().step_following(0.1, inertia), 0.1);
        let sampled = Servo { period_s: Some(4e-3), ..loop_of_torque };
        assert_eq!(sampled.step_following(3e-3, inertia), 2e-3);
        let most = Servo { limit: 0.05, ..loop_of_torque };
        let past = Past { position: &[0.0], speed: &[0.0], step_s: 1e-3 };
        let told = Told { goal: 1.0, supply_v: Some(12.0), ..Told::default() };
        assert_eq!(most.command(&told, past, &mut Loop::default()), 0.05);
    }

    #[test]
    fn a_released_drive_coasts_without_back_emf() {
        let mut plant = plant();
        plant.start = (0.0, 3.0);
        let grid = Grid { start_s: 0.0, step_s: 1e-3, steps: 1000 };
        let (commands, enable) = (vec![5.0; 1000], vec![0.0; 1000]);
        let feed = Feed { commands: &commands, enable: Some(&enable), ..Feed::default() };
        let trace = plant.simulate_fed(grid, feed).expect("finite");
        assert!(trace.screw_speed.iter().all(|v| (v - 3.0).abs() < 1e-12));
        assert!(trace.motor_force.iter().all(|f| *f == 0.0));
    }

    #[test]
    fn a_late_feedback_rings_and_a_dead_band_leaves_an_error() {
        let peak = |delay: f64| {
            let mut plant = plant();
            plant.servo = Some(Servo { feedback_delay_s: delay, ..servo() });
            step(&plant, 1e-3, 0.02).screw_position.iter().fold(0.0_f64, |m, y| m.max(*y))
        };
        assert!(peak(0.01) > 1.05 * peak(0.0), "{} {}", peak(0.01), peak(0.0));
        let mut plant = plant();
        plant.servo = Some(Servo { dead_band: 0.03, ..servo() });
        assert!(step(&plant, 1e-3, 0.02).screw_position.iter().all(|y| *y == 0.0));
        // A loop of its own, slow rate holds its duty.
        plant.servo = Some(Servo { period_s: Some(0.05), ..servo() });
        let forces = step(&plant, 1e-3, 0.02).motor_force;
        let volts = |n: usize, speed: f64| WINDING.volts(forces[n], speed);
        assert!((volts(1, 0.0) - 2.0 * 0.02 * 7.4).abs() < 0.01, "{}", volts(1, 0.0));
    }
}
