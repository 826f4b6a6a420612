//! A position loop inside the drive: from a goal and the measured position of the output to the duty of the bridge.

use super::REFERENCE_TEMPERATURE_C;

/// A servo's own position loop: `duty = clamp(k_p e + k_d e' + k_i integral(e))` with `e = goal - position`.
///
/// Gains are per unit of the output's motion (rad, or m for a linear drive). The loop is continuous unless it has a
/// period, and then holds its duty from one of its samples to the next, which begin with the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    /// Duty per error, 1/rad.
    pub proportional: f64,
    /// Duty per rate of the error, s/rad. The goal's own rate is not taken: of a goal in steps it would be a spike.
    pub derivative: f64,
    /// Duty per integral of the error, 1/(rad s). The integral stops where the duty is at its limit.
    pub integral: f64,
    /// Greatest magnitude of the duty, at most 1.
    pub duty_limit: f64,
    /// An error below this counts as none, rad.
    pub dead_band: f64,
    /// Age of the position that the loop sees, s.
    pub feedback_delay_s: f64,
    /// Sampling period of the loop, s; `None` where it is continuous.
    pub period_s: Option<f64>,
    /// Constant error of the goal, rad.
    pub goal_offset: f64,
    /// Voltage at a duty of 1 where none was logged, V.
    pub supply_v: f64,
}

/// What the loop remembers between steps.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loop {
    duty: f64,
    integral: f64,
    /// Number of the loop's own sample that `duty` belongs to, from 1.
    sample: u64,
}

/// The output's motion from the start to the point where a step begins.
#[derive(Debug, Clone, Copy)]
pub struct Past<'a> {
    /// Position at every point, rad.
    pub position: &'a [f64],
    /// Its rate at every point, rad/s.
    pub speed: &'a [f64],
    /// Between two points, s.
    pub step_s: f64,
}

impl Servo {
    /// The duty over the step that begins at the last point of the `past`.
    ///
    /// # Panics
    ///
    /// If the past has no point.
    pub fn duty(&self, goal: f64, past: Past, of: &mut Loop) -> f64 {
        let n = past.position.len() - 1;
        let elapsed = n as f64 * past.step_s;
        let (mut look_ahead, mut span) = (0.5 * past.step_s, past.step_s);
        if let Some(period) = self.period_s {
            let sample = (elapsed / period + 1e-9).floor() as u64 + 1;
            if sample == of.sample {
                return of.duty;
            }
            span = (sample - of.sample) as f64 * period;
            of.sample = sample;
            look_ahead = 0.0;
        }
        let (position, speed) = self.seen(elapsed + look_ahead, past);
        let error = goal + self.goal_offset - position;
        let error = error - error.clamp(-self.dead_band, self.dead_band);
        let free = self.proportional * error - self.derivative * speed + self.integral * of.integral;
        of.duty = free.clamp(-self.duty_limit, self.duty_limit);
        if of.duty == free {
            of.integral += error * span;
        }
        of.duty
    }

    /// The voltage that the bridge gives over that step, V, at a supply that was measured (V) or its own.
    pub fn volts(&self, goal: f64, supply_v: Option<f64>, past: Past, of: &mut Loop) -> f64 {
        supply_v.unwrap_or(self.supply_v) * self.duty(goal, past, of)
    }

    /// Position and speed of the output as the loop sees them at a time since the start, s. Before the start the position
    /// is the first one.
    fn seen(&self, at: f64, past: Past) -> (f64, f64) {
        let Past { position, speed, step_s } = past;
        let last = position.len() - 1;
        let point = (at - self.feedback_delay_s) / step_s;
        if point >= last as f64 {
            return (position[last] + (point - last as f64) * step_s * speed[last], speed[last]);
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
    /// The mean command over each step, in its unit; of a servo the goal. Zero after the last.
    pub commands: &'a [f64],
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
        self.commands.get(step).copied().unwrap_or(0.0)
    }

    /// The measured supply over a step, V.
    #[must_use]
    #[inline(always)]
    pub fn supply(&self, step: usize) -> Option<f64> {
        self.supply_v.and_then(|v| v.get(step).copied())
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
            duty_limit: 1.0,
            dead_band: 0.0,
            feedback_delay_s: 0.0,
            period_s: None,
            goal_offset: 0.0,
            supply_v: 7.4,
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
