//! A run of a scenario: its start, the controller's samples, and what is seen at every instant.

use super::ground::CORNERS;
use super::machine::{Machine, State};
use super::setup::LegReference;
use super::solve::MOST;
use nalgebra::DVector;
use sealegs_leg::LegError;
use sealegs_leg::scenario::SpringStart;

/// The true signals of one instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Instant {
    /// Joint positions, rad.
    pub q: Vec<f64>,
    /// Force on link 1 of each actuator, N, compression positive.
    pub force_1: Vec<f64>,
    /// Force on link 2, N.
    pub force_2: Vec<f64>,
    /// Commanded current, A.
    pub current: Vec<f64>,
    /// Rotor angle, rad, zero at the start.
    pub rotor_angle: Vec<f64>,
    /// Height of the base's frame, m.
    pub base_height: f64,
    /// Sum of the ground's normal forces, N.
    pub ground: f64,
}

/// Rounds in which the screws' ends come to rest at the start; each leaves a small part of what was left.
const START_ROUNDS: usize = 12;

/// Deflection at which a spring carries a force, m: its law grows with deflection, and is halved to it.
fn deflection_under(part: &crate::Reference, force: f64) -> f64 {
    if force == 0.0 {
        return 0.0;
    }
    let reaches = |deflection: f64| (part.spring_force(deflection, 0.0) - force) * force >= 0.0;
    let (mut low, mut high) = (0.0, force / part.stiffness + part.gap.copysign(force));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if reaches(middle) { high = middle } else { low = middle }
    }
    high
}

impl LegReference {
    /// Runs the scenario to its end with steps of `step_s` and returns an instant every `period_s`, both of which
    /// divide the controller's period, or it them.
    ///
    /// # Errors
    ///
    /// [`LegError::NotFinite`] for a state that has run away, [`LegError::Actuator`] if a linkage does not close.
    pub fn run(&self, step_s: f64, period_s: f64) -> Result<Vec<Instant>, LegError> {
        let (n, count) = (self.bodies, self.parts.len());
        let mut machine = Machine { of: self, rest: vec![0.0; count] };
        let mut state = State { x: [0.0; MOST], v: [0.0; MOST], bristles: [[0.0; 2]; CORNERS] };
        let first = usize::from(self.rail);
        state.x[first..n].copy_from_slice(&self.start_q);
        state.v[first..n].copy_from_slice(&self.start_speed);
        let loads = match self.scenario.start.springs {
            SpringStart::Unloaded => DVector::zeros(count),
            SpringStart::Balanced => self.balanced()?,
        };
        for (i, (length, rate)) in machine.lengths(&state).into_iter().enumerate() {
            machine.rest[i] = length + deflection_under(&self.parts[i], loads[i]);
            // A joint that starts in motion has moved its motor.
            state.v[n + i] = rate;
        }
        self.rest_screw_ends(&mut machine, &mut state)?;
        let steps = (self.scenario.duration_s / step_s - 1e-6).ceil() as usize;
        let per_command = (1.0 / (self.scenario.controller.rate_hz * step_s)).round().max(1.0) as usize;
        let per_sample = (period_s / step_s).round().max(1.0) as usize;
        // Whole steps: what draws a delay draws whole ones.
        let late: Vec<usize> =
            self.parts.iter().map(|p| (p.command_delay_s / step_s).round() as usize).collect();
        let mut given: Vec<Vec<f64>> = Vec::new();
        let mut seen = Vec::with_capacity(steps / per_sample + 1);
        for step in 0..=steps {
            if step % per_command == 0 {
                let t = step as f64 * step_s;
                given.push(self.command(t, &state.x[first..n], &state.v[n..n + count])?);
            }
            // Before the first command comes into force it is that command.
            let in_force = |i: usize| given[step.saturating_sub(late[i]) / per_command][i];
            let currents: Vec<f64> = (0..count).map(in_force).collect();
            if step % per_sample == 0 {
                let commanded = &given[given.len() - 1];
                seen.push(self.instant(&machine, &state, &currents, commanded));
            }
            machine.advance(&mut state, &currents, step_s);
            if !state.v.iter().all(|v| v.abs() < 1e4) {
                let what = "the reference's motion".to_owned();
                return Err(LegError::NotFinite { time_s: step as f64 * step_s, what });
            }
        }
        Ok(seen)
    }

    /// Lets the screws' ends begin where nothing accelerates them, each spring under its load.
    fn rest_screw_ends(&self, machine: &mut Machine, state: &mut State) -> Result<(), LegError> {
        let (n, count, first) = (self.bodies, self.parts.len(), usize::from(self.rail));
        let ends: Vec<(usize, usize)> =
            (0..count).filter_map(|i| self.screw_end(i).map(|end| (i, end))).collect();
        if ends.is_empty() {
            return Ok(());
        }
        for _ in 0..START_ROUNDS {
            let currents = self.command(0.0, &state.x[first..n], &state.v[n..n + count])?;
            let system = machine.system(state, &currents);
            let acceleration = machine.accelerate(state, &system, &machine.modes(state, &currents));
            for &(i, end) in &ends {
                let force = acceleration[end] / system.mobility(end)[end];
                let more = self.parts[i].series.map_or(0.0, |[stiffness, _]| force / stiffness);
                state.x[end] += more;
                machine.rest[i] += more;
            }
        }
        Ok(())
    }

    fn instant(&self, machine: &Machine, state: &State, currents: &[f64], commanded: &[f64]) -> Instant {
        let (n, count) = (self.bodies, self.parts.len());
        let first = usize::from(self.rail);
        let system = machine.system(state, currents);
        let acceleration = machine.accelerate(state, &system, &machine.modes(state, currents));
        let forces: Vec<[f64; 2]> = (0..count).map(|i| system.forces(i, &acceleration)).collect();
        Instant {
            q: state.x[first..n].to_vec(),
            force_1: forces.iter().map(|f| f[0]).collect(),
            force_2: forces.iter().map(|f| f[1]).collect(),
            current: commanded.to_vec(),
            rotor_angle: (0..count).map(|i| state.x[n + i] / self.parts[i].travel_per_rad).collect(),
            base_height: self.base_height + if self.rail { state.x[0] } else { 0.0 },
            ground: system.ground,
        }
    }
}
