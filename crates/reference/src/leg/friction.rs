//! Dry friction of the rotors: each slips one way or sticks, switched at located events; and the integration.

use super::machine::{Machine, State, System};
use super::setup::MOST_ACTUATORS;
use super::solve::MOST;
use crate::effect::Rubbing;
use crate::friction::{MOST_EVENTS, Mode, first_reversal};

pub(super) type Modes = [Mode; MOST_ACTUATORS];

impl Machine<'_> {
    fn rubbing(&self) -> impl Iterator<Item = usize> {
        (0..self.of.parts.len()).filter(|i| self.of.parts[*i].has_rotor_friction())
    }

    /// Accelerations, and the friction forces that they take, N. Rotors at rest either stick or, where `may_break`,
    /// are held within their bound.
    fn resolve(
        &self,
        s: &State,
        system: &System,
        modes: &Modes,
        may_break: bool,
    ) -> ([f64; MOST], [f64; MOST_ACTUATORS]) {
        let (mut a, mut f) = (system.smooth, [0.0; MOST_ACTUATORS]);
        let rubbing: Vec<(usize, [f64; MOST])> =
            self.rubbing().map(|i| (i, system.mobility(self.of.bodies + i))).collect();
        for _ in 0..400 {
            let mut change = 0.0;
            for (i, by) in &rubbing {
                let (i, row) = (*i, self.of.bodies + *i);
                let part = &self.of.parts[i];
                let load = system.forces(i, &a)[1];
                let next = match modes[i] {
                    Mode::Free => continue,
                    Mode::Slip(direction) => {
                        -direction * part.rotor_bound(&as_it_rubs(s.x[row], s.v[row], direction, load))
                    }
                    Mode::Stick => {
                        let held = f[i] - a[row] / by[row];
                        if may_break {
                            let most = part.rotor_bound(&as_it_rubs(s.x[row], 0.0, -held.signum(), load));
                            held.clamp(-most, most)
                        } else {
                            held
                        }
                    }
                };
                let more = next - f[i];
                f[i] = next;
                (0..self.of.count).for_each(|k| a[k] += more * by[k]);
                change += more.abs();
            }
            if change <= 1e-13 * f.iter().map(|f| f.abs()).sum::<f64>() {
                break;
            }
        }
        (a, f)
    }

    /// How each rotor moves from here on.
    pub fn modes(&self, s: &State, currents: &[f64]) -> Modes {
        let mut modes = [Mode::Free; MOST_ACTUATORS];
        let mut rests = false;
        for i in self.rubbing() {
            let speed = s.v[self.of.bodies + i];
            modes[i] = if speed == 0.0 { Mode::Stick } else { Mode::Slip(speed.signum()) };
            rests |= speed == 0.0;
        }
        if rests {
            let system = self.system(s, currents);
            let (a, f) = self.resolve(s, &system, &modes, true);
            for i in self.rubbing() {
                // What still accelerates at its bound breaks away.
                let row = self.of.bodies + i;
                let moving = a[row].abs() > 1e-9 * (f[i].abs() / self.of.parts[i].rotor + 1e-9);
                if modes[i] == Mode::Stick && moving {
                    modes[i] = Mode::Slip(a[row].signum());
                }
            }
        }
        modes
    }

    /// Accelerations with everything in its mode. A rotor at rest has none, to the last bit.
    pub fn accelerate(&self, s: &State, system: &System, modes: &Modes) -> [f64; MOST] {
        let (mut a, _) = self.resolve(s, system, modes, false);
        for i in 0..self.of.parts.len() {
            if modes[i] == Mode::Stick {
                a[self.of.bodies + i] = 0.0;
            }
        }
        a
    }

    fn runge_kutta(&self, from: &State, modes: &Modes, currents: &[f64], h: f64) -> State {
        let slope = |s: &State| {
            let system = self.system(s, currents);
            (s.v, self.accelerate(s, &system, modes), system.drawing)
        };
        let moved = |k: &([f64; MOST], [f64; MOST], super::ground::Bristles), h: f64| State {
            x: std::array::from_fn(|i| from.x[i] + h * k.0[i]),
            v: std::array::from_fn(|i| from.v[i] + h * k.1[i]),
            bristles: std::array::from_fn(|i| [0, 1].map(|j| from.bristles[i][j] + h * k.2[i][j])),
        };
        let k1 = slope(from);
        let k2 = slope(&moved(&k1, 0.5 * h));
        let k3 = slope(&moved(&k2, 0.5 * h));
        let k4 = slope(&moved(&k3, h));
        let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * (b + c) + d) / 6.0;
        let k = (
            std::array::from_fn(|i| mean(k1.0[i], k2.0[i], k3.0[i], k4.0[i])),
            std::array::from_fn(|i| mean(k1.1[i], k2.1[i], k3.1[i], k4.1[i])),
            std::array::from_fn(|i| [0, 1].map(|j| mean(k1.2[i][j], k2.2[i][j], k3.2[i][j], k4.2[i][j]))),
        );
        moved(&k, h)
    }

    /// Advances the state by `step` through all events within it.
    pub fn advance(&self, state: &mut State, currents: &[f64], step: f64) {
        let mut modes = self.modes(state, currents);
        let (mut left, mut events) = (step, 0);
        loop {
            let next = self.runge_kutta(state, &modes, currents, left);
            let speeds = |i| (state.v[self.of.bodies + i], next.v[self.of.bodies + i]);
            let reversal = (events < MOST_EVENTS).then(|| first_reversal(&modes, speeds)).flatten();
            let Some((i, fraction)) = reversal else {
                *state = next;
                break;
            };
            events += 1;
            if fraction > 0.0 {
                *state = self.runge_kutta(state, &modes, currents, fraction * left);
                left *= 1.0 - fraction;
            }
            // What is left of the speed at the located instant is of the order of the step squared.
            state.v[self.of.bodies + i] = 0.0;
            let was = modes[i];
            modes = self.modes(state, currents);
            if fraction == 0.0 && modes[i] == was {
                modes[i] = Mode::Stick;
            }
        }
        if let Some(ground) = &self.of.ground {
            let (poses, bodies) = self.motion(state);
            ground.settle(&poses, &bodies, &mut state.bristles);
        }
    }
}

/// A rotor of a leg, whose temperature nobody logs.
fn as_it_rubs(y: f64, speed: f64, direction: f64, load: f64) -> Rubbing {
    Rubbing { y, speed, direction, load, warmer_k: 0.0 }
}
