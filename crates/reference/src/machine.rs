//! The motion of the masses: positions, forces, and one step of classical Runge-Kutta.

use crate::beyond::Beyond;
use crate::friction;
use crate::reference::{End, Reference};

/// Gravitational acceleration, m/s^2.
const G: f64 = 9.81;

pub(crate) const MOST: usize = 5;
pub(crate) type Row = [f64; MOST];
pub(crate) const P: usize = 0;

#[derive(Clone, Copy)]
pub(crate) struct State {
    pub x: Row,
    pub v: Row,
    /// Forces of the presliding element, of the slipping element beside the spring, and of Dahl's friction.
    pub slip: [f64; 3],
}

impl State {
    /// Everything at rest, the spring relaxed.
    pub const REST: Self = Self { x: [0.0; MOST], v: [0.0; MOST], slip: [0.0; 3] };
}

/// What is fixed during a step: the command's force and how the dry contacts move.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    pub commanded: f64,
    pub mode: [friction::Mode; 2],
}

pub(crate) struct Machine<'a> {
    pub of: &'a Reference,
    pub count: usize,
    pub inverse_mass: [Row; MOST],
    /// Rows of extension and of link 2.
    pub extension: Row,
    pub link_2: Row,
    link_1: Option<usize>,
    screw_end: Option<usize>,
    wobbling: Option<usize>,
    /// The spring's force now as a ratio of what it was at the beginning.
    pub spring_left: f64,
    /// By how much the drive is warmer now than at the temperature for which its friction is stated, K.
    pub warmer_k: f64,
}

pub(crate) fn dot(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn add(a: &Row, factor: f64, b: &Row) -> Row {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

impl<'a> Machine<'a> {
    pub fn new(of: &'a Reference) -> Self {
        let mut count = 1;
        let mut next = |moves: bool| {
            moves.then(|| {
                count += 1;
                count - 1
            })
        };
        let screw_end = next(of.series.is_some() || of.link_2 != End::Held);
        let link_1 = next(of.link_1 != End::Held);
        let beyond = next(of.series.is_some() && of.link_2 != End::Held);
        let wobbling = next(of.wobbling.is_some_and(|w| w[0] > 0.0));
        let unit =
            |i: Option<usize>| -> Row { std::array::from_fn(|j| if i == Some(j) { 1.0 } else { 0.0 }) };
        let link_2 = if of.series.is_some() { unit(beyond) } else { unit(screw_end) };
        let extension = add(&unit(screw_end), -1.0, &unit(Some(P)));
        let mut mass = [[0.0; MOST]; MOST];
        let mut put = |m: f64, row: &Row| {
            for i in 0..MOST {
                for j in 0..MOST {
                    mass[i][j] += m * row[i] * row[j];
                }
            }
        };
        put(of.rotor, &extension);
        put(of.sprung, &unit(Some(P)));
        for (end, row) in [(of.link_1, unit(link_1)), (of.link_2, link_2)] {
            match end {
                End::Held => {}
                End::Mass(m) | End::Mounted([m, ..]) => put(m, &row),
                End::Pendulum { mass_kg, length_m, arm_m } => put(mass_kg * (length_m / arm_m).powi(2), &row),
            }
        }
        if let Some([_, unsprung]) = of.series {
            put(unsprung, &unit(screw_end));
        }
        if let Some(w) = of.wobbling {
            put(w[0], &unit(wobbling));
        }
        let inverse_mass = invert(mass, count);
        Self {
            of,
            count,
            inverse_mass,
            extension,
            link_2,
            link_1,
            screw_end,
            wobbling,
            spring_left: 1.0,
            warmer_k: 0.0,
        }
    }

    /// The spring's force without its slipping element.
    pub fn spring(&self, state: &State) -> f64 {
        let deflection = self.link_1.map_or(0.0, |i| state.x[i]) - state.x[P];
        let rate = self.link_1.map_or(0.0, |i| state.v[i]) - state.v[P];
        self.spring_left * self.of.spring_force(deflection, rate)
    }

    /// Generalised forces without dry friction.
    pub fn forces(&self, state: &State, commanded: f64) -> Row {
        let of = self.of;
        let (x, v) = (&state.x, &state.v);
        let (y, y_dot) = (dot(&self.extension, x), dot(&self.extension, v));
        let mut motor = commanded;
        if let Some([bus, resistance]) = of.voltage {
            let k = of.force_per_command;
            let (low, high) = ((-bus - k * y_dot) / resistance, (bus - k * y_dot) / resistance);
            motor = k * (commanded / k).clamp(low, high);
        }
        let on_screw = of.on_screw(motor, y, y_dot)
            - state.slip[0]
            - state.slip[2]
            - match of.beyond {
                Some(Beyond::SquareRootDamper { coefficient }) => {
                    coefficient * y_dot.abs().sqrt() * y_dot.signum()
                }
                _ => 0.0,
            };
        let mut q = [0.0; MOST];
        for i in 0..self.count {
            q[i] = on_screw * self.extension[i];
        }
        let spring = self.spring(state) + state.slip[1];
        q[P] += spring;
        if let Some(i) = self.link_1 {
            q[i] -= spring;
            if let End::Mounted([_, k, c]) = of.link_1 {
                q[i] -= k * x[i] + c * v[i];
            }
        }
        let x_2 = dot(&self.link_2, x);
        if let (Some([k, _]), Some(s)) = (of.series, self.screw_end) {
            let force = k * (x[s] - x_2);
            q[s] -= force;
            q = add(&q, force, &self.link_2);
        }
        if let End::Pendulum { mass_kg, length_m, arm_m } = of.link_2 {
            let angle = x_2 / arm_m;
            let mut torque = -mass_kg * G * length_m * angle.sin();
            if let (Some([m, radius, hz, ratio]), Some(u)) = (of.wobbling, self.wobbling) {
                let w0 = std::f64::consts::TAU * hz;
                let w = x[u] - radius * angle;
                let w_dot = v[u] - radius * dot(&self.link_2, v) / arm_m;
                let held = m * w0 * (w0 * w + 2.0 * ratio * w_dot);
                // V = m g (radius (1 - cos) + w sin) with w = u - radius * angle.
                q[u] -= held + m * G * angle.sin();
                torque += radius * held - m * G * w * angle.cos();
            }
            q = add(&q, torque / arm_m, &self.link_2);
        }
        q
    }

    /// Rates of the two elastic elements: they creep no further once they slip.
    fn slip_rates(&self, state: &State) -> [f64; 3] {
        let held = |parameters: Option<[f64; 2]>, stiffness: usize, f: f64, speed: f64| match parameters {
            Some(p) if !(f.abs() >= p[1 - stiffness] && f * speed > 0.0) => p[stiffness] * speed,
            _ => 0.0,
        };
        let y_dot = dot(&self.extension, &state.v);
        let rate = self.link_1.map_or(0.0, |i| state.v[i]) - state.v[P];
        let dahl = self
            .of
            .dahl
            .map_or(0.0, |[bound, stiffness]| stiffness * (y_dot - y_dot.abs() * state.slip[2] / bound));
        [
            held(self.of.presliding, 1, state.slip[0], y_dot),
            held(self.of.spring_slip, 0, state.slip[1], rate),
            dahl,
        ]
    }

    /// Force 1, force 2, extension, deflection, position of link 2.
    pub fn measure(&self, state: &State, acceleration: &Row) -> [f64; 5] {
        let force_1 = self.spring(state) + state.slip[1];
        let x_2 = dot(&self.link_2, &state.x);
        let force_2 = match (self.of.series, self.screw_end) {
            (Some([k, _]), Some(s)) => k * (state.x[s] - x_2),
            _ => force_1 - self.of.sprung * acceleration[P],
        };
        let deflection = self.link_1.map_or(0.0, |i| state.x[i]) - state.x[P];
        [force_1, force_2, dot(&self.extension, &state.x), deflection, x_2]
    }

    /// One Runge-Kutta step with everything in its mode.
    pub fn runge_kutta(&self, from: &State, frame: &Frame, h: f64) -> State {
        let slope = |s: &State| (s.v, self.accelerate(s, frame), self.slip_rates(s));
        let moved = |k: &(Row, Row, [f64; 3]), h: f64| State {
            x: add(&from.x, h, &k.0),
            v: add(&from.v, h, &k.1),
            slip: std::array::from_fn(|i| from.slip[i] + h * k.2[i]),
        };
        let k1 = slope(from);
        let k2 = slope(&moved(&k1, 0.5 * h));
        let k3 = slope(&moved(&k2, 0.5 * h));
        let k4 = slope(&moved(&k3, h));
        let mean = |a: f64, b: f64, c: f64, d: f64| h / 6.0 * (a + 2.0 * (b + c) + d);
        let mut to = *from;
        for i in 0..self.count {
            to.x[i] += mean(k1.0[i], k2.0[i], k3.0[i], k4.0[i]);
            to.v[i] += mean(k1.1[i], k2.1[i], k3.1[i], k4.1[i]);
        }
        for i in 0..3 {
            to.slip[i] += mean(k1.2[i], k2.2[i], k3.2[i], k4.2[i]);
        }
        if let Some([bound, _]) = self.of.presliding {
            to.slip[0] = to.slip[0].clamp(-bound, bound);
        }
        if let Some([_, bound]) = self.of.spring_slip {
            to.slip[1] = to.slip[1].clamp(-bound, bound);
        }
        to
    }
}

/// The inverse of the leading block of a positive definite matrix, by Gauss and Jordan.
fn invert(mut a: [Row; MOST], count: usize) -> [Row; MOST] {
    let mut inverse = [[0.0; MOST]; MOST];
    for i in 0..count {
        inverse[i][i] = 1.0;
    }
    for c in 0..count {
        let pivot = a[c][c];
        assert!(pivot > 0.0, "coordinate {c} has no mass");
        for j in 0..count {
            a[c][j] /= pivot;
            inverse[c][j] /= pivot;
        }
        for i in (0..count).filter(|i| *i != c) {
            let factor = a[i][c];
            for j in 0..count {
                a[i][j] -= factor * a[c][j];
                inverse[i][j] -= factor * inverse[c][j];
            }
        }
    }
    inverse
}
